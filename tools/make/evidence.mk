# The evidence: the thesis, references, calibration, other projects (tools/lab).
##@ For makers of evidence
.PHONY: test-hours tracker deep-baseline mutants
.PHONY: lab test-lab thesis table51 calibrate validate literature validate-centreline bench-peers bench-xray-peers
.PHONY: importers
LAB = run$(comma)tools$(comma)lab

lab: packages-build+tools+lab ## build every program of tools/lab
	$(call build,release,$(LAB),all)

test-lab: ## test the evidence: the thesis, calibration, CT, peers, bars, malformed files
test-lab: packages-build+tools+lab+test+hil+matrix+usb+bench+tracker+safety
	@JOBS=$(JOBS) tools/check/run_tests.sh lab

test-hours: ## play every case, 20 experts and 20 novices, race the window's threads, install packages (hours)
test-hours: packages-build+window+tools+lab+test+peers+deb+debtest+safety
	@JOBS=$(JOBS) tools/check/run_tests.sh hours

tracker: ## train a tracker of tips on 5,000 pictures, and judge it on others: out/tracker (an hour)
tracker: packages-build+tools+test+tracker
	$(call build,release,run$(comma)tools,anatomy bake cournand_library)
	@host/python/examples/tracker.sh out/tracker

deep-baseline: ## train deep policies of the named tasks, and judge them: out/deep (TASKS=iliac: one task; an hour)
deep-baseline: packages-build+tools+test+tracker
	$(call build,release,run$(comma)tools,anatomy bake cournand_library)
	@host/python/examples/deep_baseline.sh out/deep

validate: ## compare the rod with closed forms; write out/validation.html and .tsv and docs/validation.md
validate: packages-build+tools+lab
	$(call build,release,$(LAB),validate)
	@$(BUILD)/bin/validate --jobs $(JOBS) --docs docs/validation.md

literature: ## repeat published measurements; write out/literature.tsv and docs/literature.md (ONLY=ffr: some)
literature: packages-build+tools+lab
	$(call build,release,$(LAB),literature)
	@$(BUILD)/bin/literature --jobs $(JOBS) $(if $(ONLY),--only $(ONLY),--docs docs/literature.md)

mutants: ## make the core wrong 200 times: does a test notice? out/mutants.tsv (ONLY=name: those alone; docs/mutants.md)
mutants: packages-build+tools+lab+test
	$(call build,release,$(LAB)$(comma)tests,mutant_tests)
	@tools/mutants/mutants.py --build $(BUILD) --jobs $(JOBS) --only "$(ONLY)"

validate-centreline: ## recover the stEVE_bench curves from their surface (needs ../shared/anatomy)
validate-centreline: packages-build+tools+test
	$(call build,release,run$(comma)tools$(comma)tests,test_tools_centreline_tests_test_steve)
	@CRN_WHOLE=1 $(BUILD)/test/tools/centreline/tests/test_steve

LINE_POINTS := shared/examples/centrelines/aorta.toml
LINE_FIGURE := out/thesis/figure_5_9.png
$(LINE_FIGURE) $(LINE_FIGURE:.png=.csv) &: $(ANATOMY) $(LINE_POINTS) $(BUILD)/bin/centreline
	@mkdir -p $(@D)
	@echo "Making $(LINE_FIGURE)"
	@$(BUILD)/bin/centreline fit $(ANATOMY) --points $(LINE_POINTS) -o $(LINE_FIGURE:.png=.csv)
	@$(BUILD)/bin/centreline show $(LINE_FIGURE:.png=.csv) --mesh $(ANATOMY) --turn -20 --size 1600 -o $(LINE_FIGURE)
WIRES_FIGURE := out/thesis/figure_5_7.png
$(WIRES_FIGURE): $(HEART_FRAME) $(BUILD)/bin/centreline
	@mkdir -p $(@D)
	@echo "Making $(WIRES_FIGURE)"
	@$(BUILD)/bin/centreline show --wireframe --mesh $(HEART_FRAME) --part coronaries_left --part coronaries_right \
	    --turn 20 --size 900 -o $(@D)/coronaries.png
	@$(BUILD)/bin/centreline show --wireframe --mesh $(HEART_FRAME) --part heart --part aortic_root --turn 20 --size 900 \
	    -o $(@D)/heart.png
	@ffmpeg -v error -y -i $(@D)/coronaries.png -i $(@D)/heart.png -filter_complex hstack $@
	@rm $(@D)/coronaries.png $(@D)/heart.png
# The right artery under fluoroscopy when the first injection has filled it, in both picture styles; both arteries in
# cine.
SCREEN_FIGURE := out/thesis/figure_5_6.png
out/coronary_right_vcsim3.mp4: out/coronary_right.mp4
	@$(BUILD)/bin/cournand run --scene $(HEART) --tool $(WIRE) --tool shared/examples/instruments/guide_ntr_6f.toml \
	    --session shared/examples/sessions/coronary_right.session --style vcsim3 --mp4 $@ > $(@:.mp4=.log)
$(SCREEN_FIGURE): out/coronary_right_vcsim3.mp4 out/coronary_right.mp4
	@mkdir -p $(@D) && ffmpeg -v error -y -ss 45.6 -i $< -ss 45.6 -i $(word 2,$^) -filter_complex hstack -frames:v 1 $@
MEDIUM_FIGURE := out/thesis/figure_5_8.png
$(MEDIUM_FIGURE): out/coronary_right.png out/coronary.png
	@mkdir -p $(@D) && ffmpeg -v error -y -i out/coronary_right.png -i out/coronary.png -filter_complex hstack $@
# The LAD with its balloon: three moments under fluoroscopy, and the polygons around the lesion.
LESION_FIGURE := out/thesis/figure_5_10.png
$(LESION_FIGURE): out/pci_lad.rec tools/lab/figures/figure_5_10.sh $(BUILD)/bin/cournand
	@mkdir -p $(@D) && tools/lab/figures/figure_5_10.sh $< $@ $(BUILD)

thesis: ## make Figures 5.6 to 5.14 of the thesis, by its own rod and by ours: out/thesis/index.html (minutes)
thesis: packages-build+tools+lab+bench+pictures
	$(call build,release,$(LAB),$(TOOLS) vcsim3)
	$(again) $(WIRES_FIGURE) $(SCREEN_FIGURE) $(MEDIUM_FIGURE) $(LESION_FIGURE) $(PHANTOM_SCENE) $(LINE_FIGURE)
	@$(BUILD)/bin/vcsim3 figures --scene $(PHANTOM_SCENE) -o out/thesis --threads $(JOBS) --instructions

# Calibrates instruments from their files, without a real scan: truth by the reference rod, virtual scans,
# segmentation, fits.
INSTRUMENT  ?= amplatz_super_stiff
INSTRUMENTS ?=
PRESET      ?= full
METHODS     ?= cmaes
FITS        ?= shape force corde
TABLE51_OUT ?= out/table51$(if $(filter-out full,$(PRESET)),_$(PRESET))
table51: ## make Table 5.1 of the thesis: out/table51 (a night; PRESET=quick: an hour, fast: a minute)
table51: packages-build+tools+lab
	$(call build,release,$(LAB),anatomy bake reference_rod ct calibrate)
	$(again) $(ACCESS)
	@python3 tools/lab/calibrate/table51.py --build $(BUILD) --scene $(ACCESS) --surface $(ACCESS:.scene=.ply) \
	    --preset $(PRESET) -o $(TABLE51_OUT) --methods $(METHODS) --fits $(FITS) \
	    $(if $(INSTRUMENTS),--instruments $(INSTRUMENTS))

calibrate: ## make, segment and fit virtual scans of INSTRUMENT=amplatz_super_stiff: its row of make table51
	@$(MAKE) --no-print-directory table51 INSTRUMENTS=$(INSTRUMENT) FITS="shape force"

bench-peers: ## time a rod, at rest and moving, by other simulators (fetched into build/peers) and by ours
bench-peers: packages-build+tools+lab+peers
	$(call build,release,$(LAB),peer_rod peer_moving)
	@tools/lab/peers/run_moving.py --environment $(BUILD)/peers --ours $(BUILD)/bench/peer_moving
	@tools/lab/peers/run_peers.py --environment $(BUILD)/peers --ours $(BUILD)/bench/peer_rod

bench-xray-peers: ## compare our transmission pictures with gVirtualXray's and DiffDRR's: out/bench_*_peers.tsv
bench-xray-peers: packages-build+tools+lab+xraypeers+ctpeers
	$(call build,release,$(LAB),peer_xray peer_ct)
	@tools/lab/peers/run_ct_peers.py --environment $(BUILD)/ct_peers --ours $(BUILD)/bench/peer_ct
	$(again) $(SCENE:.scene=.bodies)
	@tools/lab/peers/run_xray_peers.py --environment $(BUILD)/xray_peers --ours $(BUILD)/bench/peer_xray \
	    --bodies $(SCENE:.scene=.bodies)

IMPORTED_FILES ?= 3600
importers: ## feed malformed meshes, TOML, scans and centrelines to the sanitized readers: out/importers.tsv
importers: packages-build+tools+lab+test
	$(call build,sanitize-gcc,$(LAB),importers)
	@tools/importers/importers.py --program $(BUILD)/sanitize-gcc/bin/importers --files $(IMPORTED_FILES) \
	    -o out/importers.tsv
