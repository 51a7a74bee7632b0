# Tests, fuzz targets and the programs of the emulated USB: docs/testing.md. Read by the Makefile, whose libraries and rules it uses.

# --- tests: every test_* file is one program --------------------------------------------------------------------
FIRMWARE_TESTS := $(wildcard firmware/tests/test_*.c shared/*/tests/test_*.c hil_tests/test_*.c)
HOST_TESTS     := $(wildcard host/*/tests/test_*.cpp)
TOOL_TESTS     := $(wildcard tools/bake/tests/test_*.cpp)
LINE_TESTS     := $(wildcard tools/centreline/tests/test_*.cpp)
VALIDATE_TESTS := $(wildcard tools/lab/validate/tests/test_*.cpp)
THESIS_TESTS   := $(wildcard tools/lab/vcsim3/tests/test_*.cpp)
include tools/lab/reference_rod/reference_rod.mk
ROD_TESTS      := $(wildcard tools/lab/reference_rod/tests/test_*.cpp)
CASE_TESTS     := $(wildcard tools/lab/case/tests/test_*.cpp)
include tools/lab/calibrate/calibrate.mk
include tools/lab/ct/ct.mk
include tools/importers/importers.mk
CT_TESTS       := $(wildcard tools/lab/ct/tests/test_*.cpp)
CALIBRATE_TESTS := $(wildcard tools/lab/calibrate/tests/test_*.cpp)
HIL_TESTS      := $(wildcard hil_tests/*/tests/test_*.cpp)
include hil_tests/lies/lies.mk
SYSTEM_TESTS   := $(wildcard hil_tests/test_*.cpp) # the whole program against real anatomy
SCRIPT_TESTS   := $(wildcard tools/check/test_*.sh tools/check/test_*.py host/*/tests/test_*.sh tools/*/tests/test_*.sh tools/*/tests/test_*.py hil_tests/*/test_*.sh)
test_program    = $(patsubst %,$(BUILD)/test/%,$(basename $(1)))
REFERENCE       := $(wildcard firmware/tests/reference/*.c)

define test_rule
$(call test_program,$(1)): $(call objects,$(1) $(4)) $(foreach lib,$(2),$(call lib_file,$(lib)))
	@mkdir -p $$(@D)
	$$(Q) $(CXX) $$^ -o $$@ $(LDFLAGS) -lcmocka -lm $(3)
endef
$(foreach t,$(FIRMWARE_TESTS),$(eval $(call test_rule,$(t),$(DEVICE_LIBS),,$(REFERENCE))))
# Those of USB link a bus of ours before libusb.
$(foreach t,$(HOST_TESTS),$(eval $(call test_rule,$(t),$(HOST_LIBS),$(HOST_LINK),$(if $(findstring test_usb,$(t)),host/link/tests/fake_usb.cpp))))
$(foreach t,$(TOOL_TESTS),$(eval $(call test_rule,$(t),$(BAKE_LIBS),$(BAKE_LINK),)))
$(foreach t,$(LINE_TESTS),$(eval $(call test_rule,$(t),$(LINE_LIBS),$(LINE_LINK),$(LINE_HOST))))
$(foreach t,$(THESIS_TESTS),$(eval $(call test_rule,$(t),tools/lab/figures tools/lab/vcsim3 host/picture host/model host/base $(FIRMWARE_LIBS),-lpng,$(REFERENCE))))
$(foreach t,$(VALIDATE_TESTS),$(eval $(call test_rule,$(t),$(VALIDATE_LIBS),,)))
$(foreach t,$(ROD_TESTS),$(eval $(call test_rule,$(t),tools/lab/validate $(ROD_LIBS),,firmware/tests/reference/tube_lumen.c)))
$(foreach t,$(CASE_TESTS),$(eval $(call test_rule,$(t),$(CASE_LIBS),,)))
$(foreach t,$(CT_TESTS),$(eval $(call test_rule,$(t),$(CT_LIBS),$(CT_LINK),$(CT_HOST))))
$(foreach t,$(CALIBRATE_TESTS),$(eval $(call test_rule,$(t),$(CALIBRATE_LIBS),$(CALIBRATE_LINK),)))
$(foreach t,$(HIL_TESTS),$(eval $(call test_rule,$(t),$(HIL_LIBS),$(HOST_LINK),$(REFERENCE) $(if $(findstring hil_tests/lies/,$(t)),$(LIES_SOURCES)))))
$(foreach t,$(SYSTEM_TESTS),$(eval $(call test_rule,$(t),host/app host/command host/report host/picture host/session host/script host/rig host/patient host/room host/dicom host/xray/gl host/xray/style host/xray host/xray/paths host/stent host/effects host/link tools/bake tools/centreline tools/mesh/files tools/mesh host/model host/base $(FIRMWARE_LIBS),$(BAKE_LINK) $(HOST_LINK),)))
FIRMWARE_TEST_PROGRAMS := $(foreach t,$(FIRMWARE_TESTS),$(call test_program,$(t)))
ALL_TEST_PROGRAMS := $(FIRMWARE_TEST_PROGRAMS) $(foreach t,$(HOST_TESTS) $(HIL_TESTS) $(TOOL_TESTS) $(LINE_TESTS) $(VALIDATE_TESTS) $(THESIS_TESTS) $(ROD_TESTS) $(CASE_TESTS) $(CT_TESTS) $(CALIBRATE_TESTS) $(SYSTEM_TESTS),$(call test_program,$(t)))

tests-build: $(ALL_TEST_PROGRAMS) $(HIL_RIG) $(HIL_PROGRAM) $(BUILD)/firmware/cournand-mps2_an500.elf $(BUILD)/firmware/cournand-imxrt1062.elf $(BUILD)/bench/budget_make $(BUILD)/bench/bench_lumen $(BUILD)/m7/budget_image.elf ## build the test programs
tests-build-san: $(FIRMWARE_TEST_PROGRAMS) $(foreach t,$(HOST_TESTS) $(HIL_TESTS),$(call test_program,$(t))) $(BUILD)/firmware/cournand-mps2_an500.elf $(BUILD)/bin/cournand ## build those without OpenVDB

# --- the USB side against the host's libraries: docs/usb.md --------------------------------------------------------------
HIL_FOLDER := $(BUILD)/hil
USB_CHECKS := $(HIL_FOLDER)/unplug $(HIL_FOLDER)/app_check $(HIL_FOLDER)/usb_check $(HIL_FOLDER)/hid_check_hidraw $(HIL_FOLDER)/hid_check_libusb
define hil_rule
$(HIL_FOLDER)/$(1): $(call objects,$(2)) $(foreach lib,$(DEVICE_LIBS),$(call lib_file,$(lib)))
	@mkdir -p $$(@D)
	$$(Q) $(CC) $$^ -o $$@ $(LDFLAGS) $(3)
endef
$(eval $(call hil_rule,bridge,hil_tests/l3/bridge.c,-lusbredirparser))
$(eval $(call hil_rule,usb_check,hil_tests/library/usb_check.c hil_tests/library/check.c,-lusb-1.0))
$(eval $(call hil_rule,unplug,hil_tests/library/unplug.c,-lusb-1.0))
$(eval $(call hil_rule,app_check,hil_tests/library/app_check.c hil_tests/library/check.c $(REFERENCE),-lusb-1.0 -lm))
$(eval $(call hil_rule,hid_check_hidraw,hil_tests/library/hid_check.c hil_tests/library/check.c,-lhidapi-hidraw))
$(eval $(call hil_rule,hid_check_libusb,hil_tests/library/hid_check.c hil_tests/library/check.c,-lhidapi-libusb))

$(BUILD)/obj/hil_tests/l2/%.c.o: CFLAGS += $(patsubst -I%,-isystem %,$(shell pkg-config --cflags umockdev-1.0 2>/dev/null))
$(eval $(call hil_rule,mock_bus,$(wildcard hil_tests/l2/*.c),-lumockdev -lgobject-2.0 -lglib-2.0))
hil-programs: $(HIL_FOLDER)/bridge $(HIL_FOLDER)/mock_bus $(USB_CHECKS) ## build the programs of hil-mock and hil-guest

hil-mock: packages-build packages-run packages-usb packages-hil ## level L2: libusb and hidapi see the device by umockdev, on a machine without USB
	@$(QUIET_MAKE) $(HIL_LEVELS) hil-programs
	@$(MAKE) --no-print-directory PACKAGES=skip $(SCENE)
	@HIL=$(HIL_FOLDER) hil_tests/l2/test_l2.sh
	@$(HIL_PROGRAM) --level L2 $(HIL_L2)

hil-guest: packages-build packages-run packages-usb packages-hil ## level L3: the device behind a real Linux: Debian's kernel in QEMU, xHCI, libusb, hidapi
	@$(QUIET_MAKE) $(HIL_LEVELS) hil-programs
	@$(MAKE) --no-print-directory PACKAGES=skip $(SCENE)
	@$(HIL_PROGRAM) --level L3 $(HIL_L3)

# A fuzz target (fuzz_*.c) is one libFuzzer program and one that writes its first inputs: docs/testing.md.
FUZZ_TARGETS := $(wildcard firmware/tests/fuzz_*.c shared/*/tests/fuzz_*.c hil_tests/fuzz_*.c host/*/tests/fuzz_*.cpp tools/*/tests/fuzz_*.cpp)
# Those of the host need these files of it, and nothing that a window or a film needs.
FUZZ_HOST    := host/link/link.cpp host/link/link_hello.cpp host/link/link_receive.cpp host/link/patience.cpp host/base/interrupt.cpp host/base/pending_file.cpp host/session/recording.cpp host/base/text.cpp host/base/terminal.cpp host/base/format.cpp host/room/command.cpp host/stent/design.cpp host/base/toml.cpp
FUZZ_LINKED   = $(if $(filter host/%,$(1)),$(FUZZ_HOST),$(if $(filter tools/%,$(1)),$(FUZZ_TOOLS),$(REFERENCE)))
define fuzz_rule
$(call test_program,$(1)): $(call objects,$(1) $(call FUZZ_LINKED,$(1))) $(foreach lib,$(DEVICE_LIBS),$(call lib_file,$(lib)))
	@mkdir -p $$(@D)
	$$(Q) $(CXX) $$^ -o $$@ $(LDFLAGS) -lm $(if $(filter tools/%,$(1)),-lpugixml -lz) -fsanitize=fuzzer
$(call test_program,$(1))_seeds: $(call objects,$(1) tools/check/fuzz_seeds.c $(call FUZZ_LINKED,$(1))) $(foreach lib,$(DEVICE_LIBS),$(call lib_file,$(lib)))
	@mkdir -p $$(@D)
	$$(Q) $(CXX) $$^ -o $$@ $(LDFLAGS) -lm $(if $(filter tools/%,$(1)),-lpugixml -lz)
endef
$(foreach t,$(FUZZ_TARGETS),$(eval $(call fuzz_rule,$(t))))
fuzz-programs: $(foreach t,$(FUZZ_TARGETS),$(call test_program,$(t)) $(call test_program,$(t))_seeds) ## build the fuzz targets (needs clang)

QUIET_MAKE = $(MAKE) --no-print-directory PACKAGES=skip -j$(JOBS)
# Lines are enough for a sanitizer's report; whole debug information makes compiling a third longer. Under clang's sanitizers the code is
# compiled and runs in two thirds of the time that gcc's take, and more is looked at. The core runs long there: -O2.
TEST_MAKE  = $(QUIET_MAKE) DEBUG=-g1
SAN_MAKE   = $(TEST_MAKE) BUILD=$(BUILD)/san CC=clang CXX=clang++ PCH=$(if $(CCACHE_DIR),,1) SAN=address,undefined OPT=-O1 CORE_OPT=-O2
FUZZ_MAKE  = $(TEST_MAKE) BUILD=$(BUILD)/fuzz CC=clang CXX=clang++ SAN=fuzzer-no-link,address,undefined OPT=-O2 CORE_OPT=-O2

# What does not build is reported by run_tests.py as failed, with everything else run all the same.
test: packages-build+test+matrix+usb+bench ## build and run every test, also under the sanitizers, and a short fuzz run
	@status=0; \
	$(TEST_MAKE) -k $(PROGRAMS) tests-build || status=1; \
	$(SAN_MAKE) -k tests-build-san hil-programs || status=1; \
	$(FUZZ_MAKE) -k fuzz-programs || status=1; \
	tools/check/run_tests.py --build $(BUILD) --jobs $(JOBS) --scripts $(SCRIPT_TESTS) --programs $(ALL_TEST_PROGRAMS:$(BUILD)/test/%=%) \
	    --sanitized $(basename $(FIRMWARE_TESTS) $(HOST_TESTS) $(HIL_TESTS)) --fuzz $(basename $(FUZZ_TARGETS)) || status=1; \
	[ $$status = 0 ] || echo "make test: something did not build or failed, see above" >&2; exit $$status

FUZZ_RUN = tools/check/run_fuzz.py --build $(BUILD)/fuzz --jobs $(JOBS)
fuzz: packages-build packages-test ## look for crashing inputs, SECONDS=60 per target (LONG=1: 5 million inputs per target)
	@$(FUZZ_MAKE) fuzz-programs
	@$(FUZZ_RUN) --seconds $(SECONDS) $(if $(LONG),--executions 5000000) $(basename $(FUZZ_TARGETS))

COVER = -fprofile-instr-generate -fcoverage-mapping
fuzz-coverage: packages-build packages-test ## the lines that the committed corpora of the fuzz targets run: docs/testing.md
	@$(TEST_MAKE) BUILD=$(BUILD)/cover CC='clang $(COVER)' CXX='clang++ $(COVER)' SAN=fuzzer-no-link OPT=-O1 CORE_OPT=-O1 fuzz-programs
	@tools/check/run_fuzz.py --build $(BUILD)/cover --jobs 1 --coverage $(basename $(FUZZ_TARGETS))

fuzz-corpus: packages-build packages-test ## what fuzzing has learnt, minimised, becomes the corpora to commit
	@$(FUZZ_MAKE) fuzz-programs
	@$(FUZZ_RUN) --keep $(basename $(FUZZ_TARGETS))

compilers: packages-build packages-test ## replay out/demo.rec by gcc -O0, gcc -O3 and clang -O2 and compare the hashes
	@$(QUIET_MAKE) $(PROGRAMS)
	@$(MAKE) --no-print-directory PACKAGES=skip $(DEMO_OUT)
	@JOBS=$(JOBS) tools/check/compare_compilers.sh

matrix: packages-build packages-test packages-matrix ## one hash on five machines, gcc and clang, -O0/2/3: docs/determinism.md
	@tools/check/matrix.py --jobs $(JOBS)
