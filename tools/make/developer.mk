# Targets that developers of the product run.
##@ For developers
.PHONY: all scene coverage bench format fuzz fuzz-coverage fuzz-corpus compilers matrix budget
.PHONY: budget-docs budget-search docs-tables docs-cases docs-pictures gallery dissector sbom
.PHONY: notice programs-list bars flakes screenshots bench-suite
N     ?= 30
LOAD  ?= 4
# Scenes whose ticks `make budget` prices (tools/bench/chip_budget.py).
CHIP_SCENES := $(SCENE) $(HEART) out/lad_pci.scene out/renal_pci.scene

all: packages-build+tools ## build every program of the product into build/bin
	$(call build,release,run$(comma)tools,all)

scene: ## rebuild the anatomy and the shipped scene, and compare them (ACCEPT=1: ship the new one)
scene: packages-build+tools
	$(call build,release,run$(comma)tools,anatomy bake)
	$(again) $(ANATOMY)
	@tools/scenes/shipped.py make $(SHIPPED) --anatomy $(ANATOMY) --bake $(BUILD)/bin/bake $(if $(ACCEPT),--accept)

coverage: packages-build+tools+test+matrix+usb+bench ## lines that the product's tests run: out/coverage.tsv
	@JOBS=$(JOBS) tools/check/run_coverage.sh

fuzz: ## look for crashing inputs, SECONDS=60 per target (LONG=1: 5 million inputs per target)
fuzz: packages-build+test
	$(call build,sanitize,run$(comma)tests,crn_fuzzers)
	@tools/check/run_fuzz.py --build $(BUILD)/san --jobs $(JOBS) --seconds $(SECONDS) $(if $(LONG),--executions 5000000)

fuzz-coverage: ## measure the lines that the committed fuzz corpora run: docs/testing.md
fuzz-coverage: packages-build+test
	$(call build,fuzz-coverage,run$(comma)tests,crn_fuzzers)
	@tools/check/run_fuzz.py --build $(BUILD)/fuzz-coverage --jobs 1 --coverage

fuzz-corpus: packages-build+test ## minimise what fuzzing has found and write the corpora to commit
	$(call build,sanitize,run$(comma)tests,crn_fuzzers)
	@tools/check/run_fuzz.py --build $(BUILD)/san --jobs $(JOBS) --keep

compilers: ## replay out/demo.rec by gcc -O0, gcc -O3 and clang -O2 and compare the hashes
compilers: packages-build+test
	$(call build,release,run,cournand)
	$(again) $(DEMO_OUT)
	@JOBS=$(JOBS) tools/check/compare_compilers.sh

matrix: packages-build+test+matrix ## check for one hash on five machines, gcc and clang, -O0/2/3: docs/determinism.md
	@tools/check/matrix.py --jobs $(JOBS)

bench: ## run the benchmarks, write and print out/bench.tsv (CASES=text: only names that contain it)
bench: packages-build+tools+bench+matrix
	$(call build,release,run$(comma)tools,$(TOOLS) crn_benches)
	$(call build,m7,run,budget_image)
	$(again) $(SCENE) $(HEART) $(DEMO_OUT)
	@tools/bench/run_bench.py --build $(BUILD) $(if $(QUICK),--quick) --cases '$(CASES)'

budget: ## price the core's tick on Cortex-M7 boards, with stack and bytes; fails at +3 % (ACCEPT=1: new budget)
budget: packages-build+tools+matrix+budget
	$(call build,release,run$(comma)tools$(comma)chip,budget_make chip cournand anatomy bake)
	$(call build,m7,run,budget_image chip_case chip_device)
	$(again) $(CHIP_SCENES)
	@tools/bench/budget.py --build $(BUILD) --jobs $(JOBS) $(if $(ACCEPT),--accept)

budget-search: ## look for the dearest ticks anew, in an hour of one core: firmware/bench/chip/found.tsv
budget-search: packages-build+tools+matrix+budget
	$(call build,release,run$(comma)tools$(comma)chip,chip anatomy bake)
	$(call build,m7,run,chip_device)
	$(again) $(CHIP_SCENES)
	@tools/bench/budget.py --build $(BUILD) --jobs $(JOBS) --search

budget-docs: ## write the tables of docs/bench.md, budget.md, porting.md from firmware/bench/budget.tsv
	@tools/bench/budget_docs.py --write

bars: ## check every limit that an issue has set, as one table: out/bars.tsv (docs/bars.md)
bars: packages-build+tools+lab+matrix+budget+bench
	$(call build,release,run$(comma)tools$(comma)tests$(comma)lab,budget_make bench_lumen validate hil)
	$(call build,m7,run,all)
	$(again) $(SCENE)
	@tools/bars/bars.py --build $(BUILD) --jobs $(JOBS)

flakes: ## repeat the time-dependent tests beside LOAD=4 busy processes: make flakes N=30 TESTS=text
flakes: packages-build+tools+test+usb+hil
	@JOBS=$(JOBS) tools/check/run_tests.sh build
	@tools/bars/flakes.py --build $(BUILD) --rounds $(N) --load $(LOAD) --jobs $(JOBS) --tests '$(TESTS)'

docs-tables: ## write the generated tables of docs/wire.md, usb.md, faults.md and instruments.md, and its picture
docs-tables: packages-build
	$(call build,release,run$(comma)tools,docs cournand)
	@$(BUILD)/bin/docs --write
	@tools/docs/printed.py --write --build $(BUILD)
	@$(BUILD)/bin/cournand instruments --table docs/instruments.md --png docs/images/instruments.png > /dev/null

docs-cases: ## play all cases, and write the scores in docs/cases.md and the cards of the cases (half an hour)
docs-cases: packages-build+tools
	$(call build,release,run$(comma)tools,$(TOOLS))
	@$(BUILD)/bin/cournand case check --all --play --table docs/cases.md
	@$(BUILD)/bin/cournand case list --cards shared/examples/cases

screenshots: ## pictures of the window in three sizes: out/screenshots
screenshots: packages-build+tools+test
	$(call build,release,run$(comma)window,cournand)
	$(again) $(SCENE)
	@tools/docs/screenshots.sh $(BUILD)/bin/cournand $(SCENE) out/screenshots

bench-suite: ## measure the window on two processors: out/suite.tsv (SECONDS=60 each; PCI=1: play an angioplasty, too)
bench-suite: packages-build+tools+test
	$(call build,release,run$(comma)window,cournand)
	$(again) $(SCENE)
	@tools/bench/suite.py --build $(BUILD) --scene $(SCENE) --seconds $(SECONDS) --output out/suite.tsv \
		$(if $(PCI),--pci)

docs-pictures: ## remake the pictures of README and docs, each with its stamp (NAMES=..., minutes)
docs-pictures: packages-build+tools+pictures
	$(call build,release,run$(comma)tools,$(TOOLS))
	$(again) $(SCENE) $(HEART)
	@tools/docs/pictures.py --write $(NAMES)

GALLERY       := pelvis arch chest loin spine
GALLERY_DOCS  := docs/images/gallery
RENAL_TOOLS   := --tool shared/examples/instruments/bentson.toml --tool shared/examples/instruments/pigtail_5f.toml
# Of the session: filling, both arteries filled, washing out, roadmap.
RENAL_SECONDS := 11.7 12.4 13.1 15.5
gallery: packages-build+pictures ## renew the pictures of docs/gallery.md
	$(call build,release,run,cournand)
	$(again) $(SCENE)
	@mkdir -p out/gallery $(GALLERY_DOCS)
	@for name in $(GALLERY); do \
	    $(BUILD)/bin/cournand run --scene $(SCENE) --tool $(WIRE) --session shared/examples/gallery/$$name.session \
	        --fps 8 --quiet --png out/gallery/$$name.png > out/gallery/$$name.log || exit 1; \
	    ffmpeg -v error -y -i out/gallery/$$name.png -q:v 4 $(GALLERY_DOCS)/$$name.jpg || exit 1; \
	    echo "$(GALLERY_DOCS)/$$name.jpg"; done
	@$(BUILD)/bin/cournand run --scene $(SCENE) --tool $(WIRE) --session shared/examples/gallery/arch.session \
	    --fps 8 --quiet --style vcsim3 --png out/gallery/arch_vcsim3.png > out/gallery/arch_vcsim3.log
	@ffmpeg -v error -y -i out/gallery/arch_vcsim3.png -i out/gallery/arch.png -filter_complex hstack -q:v 4 \
	    $(GALLERY_DOCS)/thesis_look.jpg && echo "$(GALLERY_DOCS)/thesis_look.jpg"
	@$(BUILD)/bin/cournand run --scene $(SCENE) $(RENAL_TOOLS) --session shared/examples/sessions/renal.session \
	    --quiet --mp4 out/gallery/renal.mp4 > out/gallery/renal.log
	@ffmpeg -v error -y $(foreach s,$(RENAL_SECONDS),-ss $(s) -i out/gallery/renal.mp4) -filter_complex \
	    "$$(printf '[%d:v]trim=end_frame=1[p%d];' 0 0 1 1 2 2 3 3)[p0][p1][p2][p3]hstack=4" \
	    -frames:v 1 -q:v 4 docs/images/renal_dsa.jpg && echo "docs/images/renal_dsa.jpg"

dissector: packages-build ## write out/cournand.lua, which lets Wireshark read the wire (docs/wire.md)
	$(call build,release,run$(comma)tools,docs)
	@mkdir -p out
	@$(BUILD)/bin/docs --dissector out/cournand.lua
	@echo "Written: out/cournand.lua; use it as wireshark -X lua_script:out/cournand.lua"

EVERY_PROGRAM = $(TOOLS) docs vcsim3 validate reference_rod ct calibrate
SUPPLY = tools/supply/supply.py --build $(BUILD) --programs "$(EVERY_PROGRAM)"
sbom: ## list all parts of the programs as SPDX: out/cournand.spdx.json
sbom: packages-build+tools+lab
	$(call build,release,run$(comma)tools$(comma)lab,$(EVERY_PROGRAM))
	@$(SUPPLY) sbom -o out/cournand.spdx.json

notice: ## update the list of libraries in NOTICE from the libraries that the programs link
notice: packages-build+tools+lab+test+matrix
	$(call build,release,run$(comma)tools$(comma)lab,$(EVERY_PROGRAM))
	@$(SUPPLY) notice --write

programs-list: ## print the files of the programs
	@echo $(EVERY_PROGRAM:%=$(BUILD)/bin/%)

format: ## format all C and C++ files by .clang-format and Python by .ruff.toml
	git ls-files '*.c' '*.h' '*.cpp' '*.hpp' | xargs clang-format -i
	ruff format -q .
