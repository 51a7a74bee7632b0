# Lies of a device to every command: docs/hil.md. The bus is the tests' own, in libusb's place. Read by tools/testing.mk.
LIES_SOURCES := $(filter-out %/main.cpp,$(wildcard hil_tests/lies/*.cpp)) host/link/tests/fake_usb.cpp
HIL_LIES     := $(BUILD)/bin/hil_lies
$(BUILD)/obj/hil_tests/lies/main.cpp.o: override OPT := -O0
$(HIL_LIES): $(call objects,hil_tests/lies/main.cpp $(LIES_SOURCES) $(HIL_REFERENCE)) $(foreach lib,$(HIL_LIBS),$(call lib_file,$(lib)))
	@mkdir -p $(@D)
	$(Q) $(CXX) $^ -o $@ $(LDFLAGS) -lm $(HOST_LINK)

.PHONY: hil-lies
hil-lies: packages-build packages-run ## a device tells every command more than 200 lies each: out/hil_lies.tsv (some minutes)
	@$(QUIET_MAKE) $(HIL_LIES)
	@$(HIL_LIES)
