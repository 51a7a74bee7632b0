# Every bar that was ever set, and the tests that know time, repeated beside a load: docs/bars.md. Read by the Makefile.
.PHONY: bars flakes budget-docs
bars: packages-build packages-matrix packages-budget packages-bench ## every bar that an issue set, as one table: out/bars.tsv (docs/bars.md)
	@$(QUIET_MAKE) $(M7_IMAGE) $(BUDGET_MAKE) $(BUILD)/bench/bench_lumen $(BUILD)/bin/validate $(HIL_PROGRAM) $(IMAGE)
	@$(MAKE) --no-print-directory PACKAGES=skip $(SCENE)
	@tools/bars/bars.py --build $(BUILD) --jobs $(JOBS)

# N rounds, beside LOAD busy processes; TESTS=text: only tests with it in their name.
N     ?= 30
LOAD  ?= 4
flakes: packages-build packages-test packages-usb packages-hil ## repeat the tests that know time, processes or windows, beside a load: make flakes N=30
	@$(TEST_MAKE) $(PROGRAMS) tests-build
	@$(SAN_MAKE) hil-programs $(BUILD)/san/bin/cournand
	@tools/bars/flakes.py --build $(BUILD) --rounds $(N) --load $(LOAD) --jobs $(JOBS) --tests '$(TESTS)'

budget-docs: ## write the column "now" of docs/bench.md from firmware/bench/budget.tsv
	@tools/bench/budget_docs.py --write
