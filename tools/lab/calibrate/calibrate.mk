# The program `calibrate` and its tests: docs/calibrate.md. Read by tools/testing.mk, whose rules and the Makefile's it uses.
CALIBRATE_LIBS := tools/lab/calibrate tools/lab/case tools/lab/figures tools/lab/vcsim3 host/picture host/model host/base firmware/core shared/scene shared/wire
CALIBRATE_LINK := -lpng -lpagmo -lboost_serialization -ltbb -lmpi
# MPI's headers are read by one file.
$(BUILD)/obj/tools/lab/calibrate/workers_mpi.cpp.o: CXXFLAGS += $(patsubst %,-isystem %,$(firstword $(wildcard /usr/lib/*/openmpi/include /usr/include/openmpi-*)))
# The command line's parser runs once.
$(BUILD)/obj/tools/lab/calibrate/main.cpp.o: override OPT := -O0
$(BUILD)/obj/tools/lab/calibrate/main.cpp.o: PCH_FOLDER = $(BUILD)/pch/quick
$(eval $(call library,tools/lab/calibrate))
$(eval $(call program,calibrate,tools/lab/calibrate/main.cpp,$(CALIBRATE_LIBS),$(CALIBRATE_LINK)))
PROGRAMS += $(BUILD)/bin/calibrate

# From instrument files to their calibration, without a scan of anybody's: truth by the reference rod, virtual scans, segmentation, fits.
ACCESS      := out/access.scene
INSTRUMENT  ?= amplatz_super_stiff
INSTRUMENTS ?=
PRESET      ?= full
ACCESS_CHECKS ?= # of the baker: --points 1000 --poses 0 checks less
METHODS     ?= cmaes
FITS        ?= shape force corde
TABLE51_OUT ?= out/table51$(if $(filter-out full,$(PRESET)),_$(PRESET))
TABLE51      = python3 tools/lab/calibrate/table51.py --build $(BUILD) --scene $(ACCESS) --surface $(ACCESS:.scene=.ply) --preset $(PRESET) -o $(TABLE51_OUT) --methods $(METHODS) --fits $(FITS)
$(ACCESS) $(ACCESS:.scene=.ply) &: $(BUILD)/bin/anatomy $(BUILD)/bin/bake
	@mkdir -p out && echo "Making and baking the silicone phantom"
	@$(BUILD)/bin/anatomy access --quiet -o $(BUILD)/anatomy/access
	@$(BUILD)/bin/bake $(BUILD)/anatomy/access/scene.toml -o $(ACCESS) --surface $(ACCESS:.scene=.ply) $(ACCESS_CHECKS)

table51: packages-build ## Table 5.1 of the thesis, nine instruments fitted: out/table51/index.html (a night; PRESET=quick: an hour, fast: a minute)
	@$(QUIET_MAKE) $(foreach p,anatomy bake reference_rod ct calibrate,$(BUILD)/bin/$(p))
	@$(MAKE) --no-print-directory PACKAGES=skip $(ACCESS)
	@$(TABLE51) $(if $(INSTRUMENTS),--instruments $(INSTRUMENTS))

calibrate: ## virtual scans of INSTRUMENT=amplatz_super_stiff in a silicone phantom, segmented and fitted: its row of make table51
	@$(MAKE) --no-print-directory table51 INSTRUMENTS=$(INSTRUMENT) FITS="shape force"
.PHONY: table51 calibrate
