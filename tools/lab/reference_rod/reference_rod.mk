# The program `reference_rod` and its tests: docs/reference_rod.md. Read by tools/testing.mk, whose rules and the Makefile's it uses.
ROD_LIBS := tools/lab/reference_rod tools/lab/vcsim3 tools/lab/case host/model host/base firmware/core shared/scene shared/wire
# The command line's parser runs once.
$(BUILD)/obj/tools/lab/reference_rod/main.cpp.o: override OPT := -O0
$(BUILD)/obj/tools/lab/reference_rod/main.cpp.o: PCH_FOLDER = $(BUILD)/pch/quick
$(eval $(call library,tools/lab/reference_rod))
$(eval $(call program,reference_rod,tools/lab/reference_rod/main.cpp,$(ROD_LIBS),))
PROGRAMS += $(BUILD)/bin/reference_rod
