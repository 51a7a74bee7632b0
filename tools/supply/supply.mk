# What the programs are made of: docs/dependencies.md. Read by the Makefile, whose rules it uses.
.PHONY: sbom notice programs-list
SUPPLY = tools/supply/supply.py --build $(BUILD) --programs "$(notdir $(PROGRAMS))"

sbom: packages-build ## list everything that the programs are made of, as SPDX: out/cournand.spdx.json
	@$(QUIET_MAKE) $(PROGRAMS)
	@$(SUPPLY) sbom -o out/cournand.spdx.json

notice: packages-build+test+matrix ## renew the list of libraries in NOTICE from what the programs are linked with
	@$(QUIET_MAKE) $(PROGRAMS)
	@$(SUPPLY) notice --write

programs-list: ## print the files of the programs
	@echo $(PROGRAMS)
