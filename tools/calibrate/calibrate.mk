# The program `calibrate` and its tests: docs/calibrate.md. Read by tools/testing.mk, whose rules and the Makefile's it uses.
CALIBRATE_LIBS := tools/calibrate tools/case tools/vcsim3 host/app host/model firmware/core shared/scene shared/wire
CALIBRATE_LINK := -lpng -lpagmo -lboost_serialization -ltbb -lmpi
# MPI's headers are read by one file.
$(BUILD)/obj/tools/calibrate/workers_mpi.cpp.o: CXXFLAGS += $(patsubst %,-isystem %,$(firstword $(wildcard /usr/lib/*/openmpi/include /usr/include/openmpi-*)))
# The command line's parser runs once.
$(BUILD)/obj/tools/calibrate/main.cpp.o: override OPT := -O0
$(BUILD)/obj/tools/calibrate/main.cpp.o: PCH_FOLDER = $(BUILD)/pch/quick
$(eval $(call library,tools/calibrate))
$(eval $(call program,calibrate,tools/calibrate/main.cpp,$(CALIBRATE_LIBS),$(CALIBRATE_LINK)))
PROGRAMS += $(BUILD)/bin/calibrate

# From an instrument's file to its calibration, without a scan of anybody's: truth by the reference rod, virtual scans, segmentation, fit.
ACCESS     := out/access.scene
INSTRUMENT ?= amplatz_super_stiff
CT_CASE     = out/cases/$(INSTRUMENT)
CT_DEPTHS  := --depth "iliac bifurcation:240:0" --depth "aortic bifurcation:300:0" --depth "left renal origin:362:0"
$(ACCESS) $(ACCESS:.scene=.ply) &: $(BUILD)/bin/anatomy $(BUILD)/bin/bake
	@mkdir -p out && echo "Making and baking the silicone phantom"
	@$(BUILD)/bin/anatomy access --quiet -o $(BUILD)/anatomy/access
	@$(BUILD)/bin/bake $(BUILD)/anatomy/access/scene.toml -o $(ACCESS) --surface $(ACCESS:.scene=.ply)
out/cases/%/depth_3.csv: shared/examples/instruments/%.toml $(ACCESS) $(BUILD)/bin/ct
	@$(BUILD)/bin/ct simulate $(@D) --instrument $< --scene $(ACCESS) --surface $(ACCESS:.scene=.ply) $(CT_DEPTHS) --shaft-factor 1.3 --tip-factor 0.7
	@$(BUILD)/bin/ct segment $(@D)
out/fits/%/result.json: out/cases/%/depth_3.csv $(BUILD)/bin/calibrate
	@$(BUILD)/bin/calibrate out/cases/$* -o $(@D)
.PRECIOUS: out/cases/%/depth_3.csv out/fits/%/result.json

calibrate: packages-build ## virtual scans of INSTRUMENT=amplatz_super_stiff in a silicone phantom, segmented and fitted: out/fits/NAME/index.html (minutes)
	@$(QUIET_MAKE) $(BUILD)/bin/anatomy $(BUILD)/bin/bake $(BUILD)/bin/ct $(BUILD)/bin/calibrate
	@$(MAKE) --no-print-directory PACKAGES=skip out/fits/$(INSTRUMENT)/result.json
	@$(BUILD)/bin/ct check $(CT_CASE) || echo "ct check: a bar is missed, see above"
	@echo "Written: out/fits/$(INSTRUMENT)/index.html out/cases/$(INSTRUMENT)/segmentation/index.html"
.PHONY: calibrate
