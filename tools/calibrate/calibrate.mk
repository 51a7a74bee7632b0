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
