# Cournand: `make help` lists the targets. Everything is built under $(BUILD); results go to out/.
#   BUILD=build/clang CC=clang CXX=clang++   another compiler in its own folder
#   OPT=-O0 CORE_OPT=-O0 BUILD=build/O0      another optimisation level: other flags need a folder of their own
#   SAN=address,undefined BUILD=build/san    sanitizers
#   DEBUG=-g                                 what debuggers are told (make test: -g1, lines only)
#   V=1                                      show whole commands
#   PCH=                                     no precompiled headers
#   PACKAGES=skip                            do not look for missing Debian packages
#   YES=1                                    install missing ones without a question (CI=true does the same)
#   JOBS=4                                   parallel jobs of make test, fuzz and bench (default: one per core)
BUILD    ?= build
CC       := $(if $(filter default,$(origin CC)),gcc,$(CC))
CXX      := $(if $(filter default,$(origin CXX)),g++,$(CXX))
OPT      ?= -O2
CORE_OPT ?= -O3
SAN      ?=
DEBUG    ?= -g
PACKAGES ?= install
JOBS     ?= $(shell nproc)
SECONDS  ?= 60
USB_ID   ?= 1209:0001

WARN     := -Wall -Wextra -Wshadow -Werror
SANFLAGS := $(if $(SAN),-fsanitize=$(SAN) -fno-sanitize-recover=all -fno-omit-frame-pointer)
# The same bytes from every folder: what a compiler writes down of this one is "." (docs/dependencies.md, "The same bytes twice").
SAME     := -ffile-prefix-map=$(CURDIR)=.
CFLAGS   := -std=c11 $(SAME) $(DEBUG) $(WARN) -Wpedantic -Wvla -Wmissing-prototypes -I. -MMD -MP $(SANFLAGS)
PCH      ?= $(if $(findstring clang,$(CXX))$(CCACHE_DIR),,1)
# gcc 12 sees overlapping copies in std::string's operator+ at -O3 that are not there (its bug 105329), and in a precompiled header it
# forgets that such finds lie in its own library. Without one (PCH=, and with clang) they are heard.
CXXWARN  := $(if $(findstring clang,$(CXX)),,-Wno-restrict $(if $(PCH),-Wno-array-bounds -Wno-stringop-overflow -Wno-stringop-overread))
CXXFLAGS := -std=c++20 $(SAME) $(DEBUG) $(WARN) $(CXXWARN) -I. -isystem /usr/include/eigen3 -MMD -MP -ffp-contract=off $(SANFLAGS)
LDFLAGS  := -pthread $(SANFLAGS)

# --- libraries: one per folder, lowest layer last (link order) -------------------------------------------------
LIBS       := tools/lab/ct/volume tools/lab/figures tools/lab/case hil_tests/soak hil_tests/campaign hil_tests/cases hil_tests/l1 hil_tests/l0 hil_tests/plant tools/lab/vcsim3 host/app host/command host/report host/picture host/session host/script host/rig host/patient host/room host/dicom host/xray/gl host/xray/style host/xray host/xray/paths host/stent host/effects host/link host/model host/base tools/anatomy tools/centreline/fit tools/bake tools/centreline tools/mesh/files tools/mesh tools/lab/validate hil_tests/usb firmware/port/usb firmware/port/sim firmware/app firmware/app/haptics firmware/app/safety \
              firmware/port/mailbox firmware/app/usb firmware/core shared/scene shared/wire
lib_file    = $(BUILD)/lib/lib$(subst /,_,$(1)).a
lib_sources = $(filter-out %/main.cpp,$(wildcard $(1)/*.c $(1)/*.cpp))
objects     = $(patsubst %,$(BUILD)/obj/%.o,$(1))

# What each program and test folder links, in link order.
FIRMWARE_LIBS := firmware/port/sim firmware/app firmware/app/haptics firmware/app/safety firmware/core shared/scene shared/wire
DEVICE_LIBS   := hil_tests/usb firmware/port/usb firmware/port/mailbox firmware/app/usb $(FIRMWARE_LIBS)
HOST_LIBS     := host/app host/command host/report host/picture host/session host/script host/rig host/patient host/room host/dicom host/xray/gl host/xray/style host/xray host/xray/paths host/stent host/effects host/link host/model host/base $(FIRMWARE_LIBS)
BAKE_LIBS     := tools/bake tools/centreline tools/mesh/files tools/mesh host/model host/base firmware/core shared/scene shared/wire
LINE_LIBS     := tools/centreline/fit tools/bake tools/centreline tools/mesh/files tools/mesh host/xray/gl host/xray/paths host/model host/base
LINE_HOST     := host/picture/canvas.cpp host/picture/font.cpp host/picture/png.cpp host/picture/screen.cpp
ANATOMY_LIBS  := tools/anatomy $(BAKE_LIBS)
VALIDATE_LIBS := tools/lab/validate host/model host/base firmware/core
CASE_LIBS     := tools/lab/case host/model host/base firmware/core shared/scene shared/wire
VCSIM3_LIBS   := tools/lab/figures tools/lab/vcsim3 host/picture host/model host/base firmware/core shared/scene shared/wire
HIL_LIBS      := hil_tests/soak hil_tests/campaign hil_tests/cases hil_tests/l1 hil_tests/l0 hil_tests/plant hil_tests/usb $(HOST_LIBS) firmware/port/usb firmware/port/mailbox firmware/app/usb $(FIRMWARE_LIBS)
HIL_REFERENCE := firmware/tests/reference/tube_lumen.c
VDB_LINK      := -lopenvdb -ltbb -lImath-3_1
BAKE_LINK     := $(VDB_LINK) -lassimp -lccd -lpugixml -lz
LINE_LINK     := $(BAKE_LINK) -lpng -lglfw -ldl
HOST_LINK     := -lpng -lglfw -lusb-1.0 -ldl -ldcmdata -lofstd -lccd

PROGRAMS := $(BUILD)/bin/cournand $(BUILD)/bin/bake $(BUILD)/bin/anatomy $(BUILD)/bin/centreline $(BUILD)/bin/vcsim3 $(BUILD)/bin/docs $(BUILD)/bin/validate

.PHONY: docs-pictures gallery coronary coronary-real demo-pci dissector all run window test validate validate-centreline bench bench-peers thesis fuzz fuzz-coverage fuzz-corpus compilers matrix budget format help clean docs tests-build tests-build-san fuzz-programs hil-programs hil-mock hil-guest firmware firmware-board registers hil hil-full hil-rig hil-faults hil-loop hil-emulator hil-machines install-udev bench-xray-peers
.DEFAULT_GOAL := all
.DELETE_ON_ERROR:
MAKEFLAGS += --no-builtin-rules

all: packages-build ## build every program into build/bin
	@$(MAKE) --no-print-directory PACKAGES=skip $(PROGRAMS)

help: ## this list
	@awk -F':.*## ' '/^[a-z0-9%-]+:.*## /{printf "  make %-16s %s\n",$$1,$$2}' $(MAKEFILE_LIST)

# Several sections at once, packages-build+run, are one question.
packages-%:
	@[ "$(PACKAGES)" = skip ] || MAKE_GOALS="$(MAKECMDGOALS)" tools/check/install_packages.sh $(subst +, ,$*)

# Recipes start with $(Q): one short line instead of the command, unless V=1.
Q = @$(if $(V),,echo "  $(@:$(BUILD)/%=%)";)$(if $(V),set -x;)

# --- rules ------------------------------------------------------------------------------------------------------
$(BUILD)/obj/firmware/core/%.c.o: OPT := $(CORE_OPT)
$(BUILD)/obj/firmware/core/%.c.o: CFLAGS += -ffreestanding $(if $(findstring clang,$(CC)),,-fno-schedule-insns -fno-tree-pre)
# The number a rig shows on the bus, vendor:product in hexadecimal: docs/usb.md.
USB_ID_FLAGS := -DCRN_USB_VENDOR_ID=0x$(word 1,$(subst :, ,$(USB_ID))) -DCRN_USB_PRODUCT_ID=0x$(word 2,$(subst :, ,$(USB_ID)))
$(BUILD)/obj/firmware/app/usb/%.c.o $(BUILD)/obj/hil_tests/library/%.c.o: CFLAGS += $(USB_ID_FLAGS)
$(BUILD)/obj/host/link/%.cpp.o $(BUILD)/obj/host/rig/%.cpp.o $(BUILD)/obj/host/session/%.cpp.o $(BUILD)/obj/host/app/%.cpp.o: CXXFLAGS += $(USB_ID_FLAGS)
# The command line's parser is half a minute of templates that run once: not optimised, half of that.
UNOPTIMISED := $(BUILD)/obj/host/command/cli.cpp.o $(BUILD)/obj/host/command/cli_rig.cpp.o $(BUILD)/obj/host/command/cli_dicom.cpp.o \
         $(foreach main,tools/centreline/fit tools/anatomy tools/bake tools/docs tools/lab/validate tools/lab/vcsim3 hil_tests/rig hil_tests/soak hil_tests/campaign hil_tests/cases,$(BUILD)/obj/$(main)/main.cpp.o)
# Under the sanitizers what reads, asks and writes is compiled without optimising, which takes two thirds of the time.
UNOPTIMISED += $(if $(SAN),$(foreach folder,host/app host/base host/report host/picture host/session host/script host/rig host/dicom host/link hil_tests,$(BUILD)/obj/$(folder)/%.cpp.o))
UNOPTIMISED += $(if $(SAN),$(patsubst %,$(BUILD)/obj/%.o,$(filter-out host/model/lesion_%.cpp host/model/opened_%.cpp,$(wildcard host/model/*.cpp))))
# So are the tests of it; those that look at pixels are not: they would run longer than they compile.
UNOPTIMISED += $(if $(SAN),$(foreach name,bodies contrast dicom dicom_export heart instrument instrument_shape link pending recording rig session patient_contrast tools usb,$(patsubst %,$(BUILD)/obj/%.o,$(wildcard host/*/tests/test_$(name).cpp))))
$(UNOPTIMISED): override OPT := -O0
# Frames and codecs are loops over bytes, where comparing is half of a fuzzer's time and teaches it nothing.
$(BUILD)/obj/shared/wire/%.c.o: CFLAGS += $(if $(findstring fuzzer,$(SAN)),-fno-sanitize-coverage=trace-cmp)
# Loops over pixels become vector code; neither flag changes a value.
$(BUILD)/obj/host/xray/%.cpp.o $(BUILD)/obj/host/room/%.cpp.o: OPT := -O3
$(BUILD)/obj/host/xray/%.cpp.o $(BUILD)/obj/host/room/%.cpp.o: CXXFLAGS += -fno-math-errno -fno-trapping-math
$(BUILD)/obj/%.c.o: %.c
	@mkdir -p $(@D)
	$(Q) $(CC) $(CFLAGS) $(OPT) -c $< -o $@
# What most files of C++ begin with is read once: two minutes of make test. A precompiled header fits one set of flags; gcc leaves it
# aside where others are given. Not with clang unless asked (few files) nor with ccache (which keeps nothing that used one).
PCH_HEADERS := Eigen/Core Eigen/Geometry algorithm array cmath cstdint cstdio filesystem fstream functional map memory optional set span sstream string thread vector
PCH_FOLDER   = $(BUILD)/pch/plain
$(BUILD)/obj/host/xray/%.cpp.o $(BUILD)/obj/host/room/%.cpp.o: PCH_FOLDER = $(BUILD)/pch/pixels
$(UNOPTIMISED): PCH_FOLDER = $(BUILD)/pch/quick
# Taken here, since what one object sets for itself would reach what it waits for.
PCH_FLAGS_plain  := $(filter-out -MMD -MP,$(CXXFLAGS)) $(OPT)
PCH_FLAGS_quick  := $(filter-out -MMD -MP,$(CXXFLAGS)) -O0
PCH_FLAGS_pixels := $(filter-out -MMD -MP,$(CXXFLAGS)) -fno-math-errno -fno-trapping-math $(if $(findstring command line,$(origin OPT)),$(OPT),-O3)
$(BUILD)/pch/%/headers.hpp.gch:
	@mkdir -p $(@D)
	@printf '#include <%s>\n' $(PCH_HEADERS) >$(@:.gch=)
	$(Q) $(CXX) $(PCH_FLAGS_$*) -MD -MP -MF $(@:.gch=.d) -MT $@ $(if $(findstring clang,$(CXX)),-fpch-instantiate-templates) -x c++-header $(@:.gch=) -o $@
.PRECIOUS: $(BUILD)/pch/%/headers.hpp.gch
%/headers.hpp: ; # clang names it by its whole path, which a copied build folder has no more
# Tests are long lists that run once.
$(foreach room,$(wildcard host/*/tests),$(BUILD)/obj/$(room)/%.cpp.o) $(BUILD)/obj/tools/bake/tests/%.cpp.o $(BUILD)/obj/tools/centreline/tests/%.cpp.o $(BUILD)/obj/hil_tests/cases/tests/%.cpp.o: OPT := -O1
$(BUILD)/obj/%.cpp.o: %.cpp $(if $(PCH),| $(foreach kind,plain pixels quick,$(BUILD)/pch/$(kind)/headers.hpp.gch))
	@mkdir -p $(@D)
	$(Q) $(CXX) $(if $(PCH),-include $(PCH_FOLDER)/headers.hpp) $(CXXFLAGS) $(OPT) -c $< -o $@

define library
$(call lib_file,$(1)): $(call objects,$(call lib_sources,$(1)))
	@mkdir -p $$(@D)
	@rm -f $$@
	$$(Q) ar rcsD $$@ $$^
endef
$(foreach lib,$(LIBS),$(eval $(call library,$(lib))))

# program(name, main, libs, link)
define program
$(BUILD)/bin/$(1): $(call objects,$(2)) $(foreach lib,$(3),$(call lib_file,$(lib)))
	@mkdir -p $$(@D)
	$$(Q) $(CXX) $$^ -o $$@ $(LDFLAGS) $(4)
endef
$(eval $(call program,cournand,host/app/main.cpp,$(HOST_LIBS),$(HOST_LINK)))
$(eval $(call program,bake,tools/bake/main.cpp,$(BAKE_LIBS),$(BAKE_LINK)))
$(eval $(call program,anatomy,tools/anatomy/main.cpp,$(ANATOMY_LIBS),$(BAKE_LINK)))
$(eval $(call program,centreline,tools/centreline/fit/main.cpp $(LINE_HOST),$(LINE_LIBS),$(LINE_LINK)))
$(eval $(call program,vcsim3,tools/lab/figures/main.cpp,$(VCSIM3_LIBS),-lpng))
$(eval $(call program,docs,tools/docs/main.cpp tools/docs/dissector.cpp,shared/wire,))
HIL_PROGRAM := $(BUILD)/bin/hil
$(HIL_PROGRAM): $(call objects,hil_tests/cases/main.cpp $(HIL_REFERENCE)) $(foreach lib,$(HIL_LIBS),$(call lib_file,$(lib)))
	@mkdir -p $(@D)
	$(Q) $(CXX) $^ -o $@ $(LDFLAGS) -lm $(HOST_LINK)
HIL_RIG := $(BUILD)/bin/hil_rig
$(HIL_RIG): $(call objects,hil_tests/rig/main.cpp) $(foreach lib,$(HIL_LIBS),$(call lib_file,$(lib)))
	@mkdir -p $(@D)
	$(Q) $(CXX) $^ -o $@ $(LDFLAGS) -lm $(HOST_LINK)
HIL_CAMPAIGN := $(BUILD)/bin/hil_campaign
$(HIL_CAMPAIGN): $(call objects,hil_tests/campaign/main.cpp $(HIL_REFERENCE)) $(foreach lib,$(HIL_LIBS),$(call lib_file,$(lib)))
	@mkdir -p $(@D)
	$(Q) $(CXX) $^ -o $@ $(LDFLAGS) -lm $(HOST_LINK)
$(eval $(call program,validate,tools/lab/validate/main.cpp,$(VALIDATE_LIBS),))

# --- the demo: shipped anatomy -> scene -> session -> film -----------------------------------------------------------
ANATOMY := $(BUILD)/anatomy/aorta/scene.toml
SCENE   := out/aorta.scene
DEMO    := shared/examples/sessions/demo.session
WIRE    := shared/examples/instruments/j_wire.toml

$(ANATOMY): $(BUILD)/bin/anatomy
	@echo "Making the anatomy"
	@$(BUILD)/bin/anatomy aorta -o $(@D)
$(SCENE) $(SCENE:.scene=.bodies) &: $(ANATOMY) $(BUILD)/bin/bake
	@mkdir -p out
	@echo "Baking $(SCENE)"
	@$(BUILD)/bin/bake $(ANATOMY) -o $(SCENE)
DEMO_OUT := out/demo.mp4 out/demo.png out/demo.rec out/demo.json
$(DEMO_OUT) &: $(SCENE) $(DEMO) $(WIRE) $(BUILD)/bin/cournand
	@echo "Running $(DEMO)"
	@$(BUILD)/bin/cournand run --scene $(SCENE) --instrument $(WIRE) --session $(DEMO) --record out/demo.rec \
	    --json out/demo.json --png out/demo.png --mp4 out/demo.mp4

run: packages-build+run ## build, make the anatomy, run the demo into out/, and open the window where there is a display
	@$(QUIET_MAKE) $(PROGRAMS)
	@$(MAKE) --no-print-directory PACKAGES=skip $(DEMO_OUT)
	@echo "Written: out/demo.mp4 out/demo.png out/demo.rec out/demo.json"
	@if [ -n "$$DISPLAY" ]; then $(BUILD)/bin/cournand view --scene $(SCENE) --instrument $(WIRE) --record out/view.rec || \
	    echo "The demo is complete; only the window did not open."; \
	else echo "No display, so no window: 'make window' opens it where there is one."; fi

window: packages-build+run ## push and turn a wire by keyboard (needs a display)
	@$(QUIET_MAKE) $(PROGRAMS)
	@$(MAKE) --no-print-directory PACKAGES=skip $(SCENE)
	@$(BUILD)/bin/cournand view --scene $(SCENE) --instrument $(WIRE) --record out/view.rec

# --- the heart and its coronary arteries: docs/contrast.md -------------------------------------------------------------
HEART_TEXT  := $(BUILD)/anatomy/heart/scene.toml
HEART       := out/heart.scene
HEART_FRAME := $(BUILD)/anatomy/heart/beat/frame_00.obj
$(HEART_TEXT) $(HEART_FRAME) &: $(BUILD)/bin/anatomy
	@echo "Making the heart (1.5 minutes of one core)"
	@$(BUILD)/bin/anatomy heart -o $(dir $(HEART_TEXT))
$(HEART) $(HEART:.scene=.bodies) &: $(HEART_TEXT) $(BUILD)/bin/bake
	@mkdir -p out
	@echo "Baking $(HEART)"
	@$(BUILD)/bin/bake $(HEART_TEXT) -o $(HEART)
# coronary_session(session, guide): film, last picture and figures of one artery's session
define coronary_session
out/$(1).mp4 out/$(1).png out/$(1).json &: $(HEART) shared/examples/sessions/$(1).session $(WIRE) shared/examples/instruments/$(2).toml $(BUILD)/bin/cournand
	@echo "Running shared/examples/sessions/$(1).session"
	@$(BUILD)/bin/cournand run --scene $(HEART) --tool $(WIRE) --tool shared/examples/instruments/$(2).toml \
	    --session shared/examples/sessions/$(1).session --json out/$(1).json --png out/$(1).png --mp4 out/$(1).mp4
endef
$(eval $(call coronary_session,coronary,guide_jl3_6f))
$(eval $(call coronary_session,coronary_right,guide_ntr_6f))
CORONARY_OUT := $(foreach name,coronary coronary_right,out/$(name).mp4 out/$(name).png out/$(name).json)

coronary: packages-build packages-run ## guides take the left and the right coronary artery, contrast in two views each: out/coronary.mp4, out/coronary_right.mp4
	@$(QUIET_MAKE) $(PROGRAMS)
	@$(MAKE) --no-print-directory PACKAGES=skip $(CORONARY_OUT)
	@echo "Written: $(CORONARY_OUT)"

# The same on real arteries, where their meshes are.
REAL_DATA  := $(or $(CRN_ANATOMY),../shared/anatomy)
REAL_ATLAS := $(REAL_DATA)/hra/VH_M_Blood_Vasculature_Heart.glb
REAL_LINES := $(foreach side,left right,$(dir $(ANATOMY))real_$(side).csv)
$(REAL_LINES) &: $(ANATOMY) tools/anatomy/real_coronaries.sh $(BUILD)/bin/centreline
	@tools/anatomy/real_coronaries.sh $(BUILD)/bin/centreline $(REAL_ATLAS) $(dir $(ANATOMY))
# The heart's places in the atlas: where its left and right artery leave the aorta, and the farthest of its left ventricle.
REAL_BEAT  := $(dir $(ANATOMY))real_beat/lumen/lumen_00.ply
$(REAL_BEAT): shared/examples/real_coronaries_lumen.toml shared/examples/centrelines/real_aorta.csv $(REAL_LINES) $(BUILD)/bin/bake $(BUILD)/bin/anatomy
	@$(BUILD)/bin/bake $< --shipped $(dir $(ANATOMY)) -o $(dir $(ANATOMY))real_lumen.scene --surface $(dir $(ANATOMY))real_lumen.ply --points 1000 --poses 0
	@$(BUILD)/bin/anatomy beat $(dir $(ANATOMY))real_lumen.ply --left 14.5 506.9 23.4 --right 0.2 500.9 40.3 --apex 73.1 433.6 81.3 -o $(@D)
out/real_coronaries.scene: shared/examples/real_coronaries.toml $(REAL_BEAT) $(BUILD)/bin/bake
	@mkdir -p out && echo "Baking $@ (5 minutes of one core)"
	@$(BUILD)/bin/bake $< --data $(REAL_DATA) --shipped $(dir $(ANATOMY)) -o $@
out/coronary_real.mp4: out/real_coronaries.scene shared/examples/sessions/coronary_real.session $(BUILD)/bin/cournand
	@$(BUILD)/bin/cournand run --scene $< --tool shared/examples/instruments/guide_jr4_6f.toml \
	    --session $(word 2,$^) --json $(@:.mp4=.json) --png $(@:.mp4=.png) --mp4 $@
coronary-real: packages-build packages-run ## a guide takes the right coronary artery of the Human Reference Atlas, which beats (needs ../shared/anatomy): out/coronary_real.mp4
	@if [ ! -e $(REAL_ATLAS) ]; then echo "Skipped: $(REAL_ATLAS) is not there (docs/contrast.md)"; else \
	    $(QUIET_MAKE) $(PROGRAMS) && $(MAKE) --no-print-directory PACKAGES=skip out/coronary_real.mp4; fi

# --- the gallery: docs/gallery.md ---------------------------------------------------------------------------------------
GALLERY       := pelvis arch chest loin
GALLERY_DOCS  := docs/images/gallery
RENAL_TOOLS   := --tool shared/examples/instruments/bentson.toml --tool shared/examples/instruments/pigtail_5f.toml
# Of the session: filling, both arteries filled, washing out, roadmap.
RENAL_SECONDS := 11.7 12.4 13.1 15.5
gallery: packages-build packages-run ## renew the pictures of docs/gallery.md
	@$(QUIET_MAKE) $(PROGRAMS)
	@$(MAKE) --no-print-directory PACKAGES=skip $(SCENE)
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
	    '[0:v]trim=end_frame=1[a];[1:v]trim=end_frame=1[b];[2:v]trim=end_frame=1[c];[3:v]trim=end_frame=1[d];[a][b][c][d]hstack=4' \
	    -frames:v 1 -q:v 4 docs/images/renal_dsa.jpg && echo "docs/images/renal_dsa.jpg"

include tools/testing.mk
include tools/pci.mk
include tools/supply/supply.mk
include hil_tests/passivity.mk
include hil_tests/soak/soak.mk

# --- validation: docs/validation.md --------------------------------------------------------------------------------
validate: packages-build ## compare the rod with closed forms; writes out/validation.html and .tsv, renews docs/validation.md
	@$(QUIET_MAKE) $(BUILD)/bin/validate
	@$(BUILD)/bin/validate --jobs $(JOBS) --docs docs/validation.md

validate-centreline: packages-build packages-test ## recover the stEVE_bench curves from their surface (needs ../shared/anatomy): docs/centreline.md
	@$(QUIET_MAKE) $(BUILD)/test/tools/centreline/tests/test_steve
	@CRN_WHOLE=1 $(BUILD)/test/tools/centreline/tests/test_steve

# --- benchmarks: docs/bench.md -------------------------------------------------------------------------------------
BENCHES := $(wildcard firmware/bench/bench_*.c)
bench_program = $(patsubst %,$(BUILD)/bench/%,$(basename $(notdir $(1))))
define bench_rule
$(call bench_program,$(1)): $(call objects,$(1) firmware/bench/bench.c $(REFERENCE)) $(foreach lib,$(FIRMWARE_LIBS),$(call lib_file,$(lib)))
	@mkdir -p $$(@D)
	$$(Q) $(CC) $$^ -o $$@ $(LDFLAGS) -lm
endef
$(foreach b,$(BENCHES),$(eval $(call bench_rule,$(b))))
# Those of the host.
HOST_BENCHES := $(wildcard host/bench/bench_*.cpp)
define host_bench_rule
$(call bench_program,$(1)): $(call objects,$(1) firmware/bench/bench.c) $(foreach lib,$(HOST_LIBS),$(call lib_file,$(lib)))
	@mkdir -p $$(@D)
	$$(Q) $(CXX) $$^ -o $$@ $(LDFLAGS) $(HOST_LINK)
endef
$(foreach b,$(HOST_BENCHES),$(eval $(call host_bench_rule,$(b))))

PEER_ROD := $(BUILD)/bench/peer_rod
$(eval $(call bench_rule,tools/lab/peers/peer_rod.c))

bench-peers: packages-build packages-peers ## the same rod by other simulators (fetched into build/peers) and by ours: out/bench_peers.tsv
	@$(QUIET_MAKE) $(PEER_ROD)
	@tools/lab/peers/run_peers.py --environment $(BUILD)/peers --ours $(PEER_ROD)

PEER_XRAY := $(BUILD)/bench/peer_xray
$(PEER_XRAY): $(call objects,tools/lab/peers/peer_xray.cpp) $(foreach lib,$(HOST_LIBS),$(call lib_file,$(lib)))
	@mkdir -p $(@D)
	$(Q) $(CXX) $^ -o $@ $(LDFLAGS) $(HOST_LINK)

bench-xray-peers: packages-build packages-xraypeers ## our transmission pictures and gVirtualXray's (fetched into build/xray_peers): out/bench_xray_peers.tsv
	@$(QUIET_MAKE) $(PEER_XRAY)
	@$(MAKE) --no-print-directory PACKAGES=skip $(SCENE:.scene=.bodies)
	@tools/lab/peers/run_xray_peers.py --environment $(BUILD)/xray_peers --ours $(PEER_XRAY) --bodies $(SCENE:.scene=.bodies)

bench: packages-build packages-run packages-bench packages-matrix ## measure; writes out/bench.tsv and prints it (CASES=text: only names with it)
	@$(QUIET_MAKE) $(PROGRAMS) $(HEART) $(foreach b,$(BENCHES) $(HOST_BENCHES),$(call bench_program,$(b))) $(M7_IMAGE) $(BUDGET_MAKE)
	@tools/bench/run_bench.py --build $(BUILD) $(if $(QUICK),--quick) --cases '$(CASES)' $(foreach b,$(BENCHES) $(HOST_BENCHES),$(call bench_program,$(b)))

# --- Cortex-M7 image: docs/bench.md, "The Cortex-M7's budget" ---------------------------------------------------------
M7_CC      := arm-none-eabi-gcc
M7_FLAGS   := -mcpu=cortex-m7 -mthumb -mfloat-abi=soft -std=c11 $(SAME) $(DEBUG) $(WARN) -I. -MMD -MP -ffreestanding -fno-tree-loop-distribute-patterns \
              -fstack-usage -fcallgraph-info=su
M7_SOURCES := $(wildcard firmware/core/*.c firmware/port/mps2_an500/*.c)
M7_IMAGE   := $(BUILD)/m7/budget_image.elf
BUDGET_MAKE := $(BUILD)/bench/budget_make

$(BUILD)/m7/obj/%.c.o: %.c
	@mkdir -p $(@D)
	$(Q) $(M7_CC) $(M7_FLAGS) $(CORE_OPT) -fno-schedule-insns -fno-tree-pre -c $< -o $@
$(M7_IMAGE): $(M7_SOURCES:%=$(BUILD)/m7/obj/%.o) $(BUILD)/m7/obj/firmware/bench/budget_image.c.o firmware/port/mps2_an500/image.ld
	$(Q) $(M7_CC) -mcpu=cortex-m7 -mthumb -mfloat-abi=soft -nostdlib -T firmware/port/mps2_an500/image.ld $(filter %.o,$^) -o $@ -lgcc
$(BUDGET_MAKE): $(call objects,firmware/bench/budget_make.c firmware/bench/bench.c $(REFERENCE)) $(foreach lib,$(FIRMWARE_LIBS),$(call lib_file,$(lib)))
	@mkdir -p $(@D)
	$(Q) $(CC) $^ -o $@ $(LDFLAGS) -lm

budget: packages-build packages-matrix packages-budget ## count the Cortex-M7's instructions, stack and bytes; fails at +3 % (ACCEPT=1: new budget)
	@$(QUIET_MAKE) $(M7_IMAGE) $(BUDGET_MAKE)
	@tools/bench/budget.py --build $(BUILD) $(if $(ACCEPT),--accept)

# --- the device's image: docs/hil.md ---------------------------------------------------------------------------------
IMAGE         := $(BUILD)/firmware/cournand-mps2_an500.elf
IMAGE_FOLDER  := firmware/port/mps2_an500/device
IMAGE_SOURCES := $(wildcard firmware/core/*.c firmware/app/*.c firmware/app/haptics/*.c firmware/app/safety/*.c firmware/app/usb/*.c firmware/port/mailbox/*.c firmware/port/usb/*.c shared/wire/*.c shared/scene/*.c \
                 $(IMAGE_FOLDER)/*.c) firmware/port/mps2_an500/memory.c
# What only hosts need of the shared libraries is left out by the linker.
IMAGE_FLAGS   := -isystem firmware/port/libc -ffunction-sections -fdata-sections

$(BUILD)/firmware/obj/firmware/core/%.c.o: IMAGE_OPT := $(CORE_OPT) -fno-schedule-insns -fno-tree-pre
$(BUILD)/firmware/obj/firmware/app/usb/%.c.o: IMAGE_OPT := -O2 $(USB_ID_FLAGS)
$(BUILD)/firmware/obj/%.c.o: IMAGE_OPT ?= -O2
$(BUILD)/firmware/obj/%.c.o: %.c
	@mkdir -p $(@D)
	$(Q) $(M7_CC) $(M7_FLAGS) $(IMAGE_FLAGS) $(IMAGE_OPT) -c $< -o $@
$(IMAGE): $(IMAGE_SOURCES:%=$(BUILD)/firmware/obj/%.o) $(IMAGE_FOLDER)/device.ld
	$(Q) $(M7_CC) -mcpu=cortex-m7 -mthumb -mfloat-abi=soft -nostdlib -Wl,--gc-sections -T $(IMAGE_FOLDER)/device.ld $(filter %.o,$^) -o $@ -lgcc

HIL_LEVELS := $(HIL_RIG) $(HIL_PROGRAM) $(HIL_CAMPAIGN) $(IMAGE) $(BUILD)/bin/cournand
# Seconds of a session that the rig leads at L2 and L3, milliseconds of one in FREE_RUN at L0 and L1.
HIL_LED  ?= 15
HIL_FREE ?= 4000
# Faults on purpose on the image: a spread over all kinds.
HIL_SPREAD ?= 40
ON_USB := BUILD=$(BUILD) HIL=$(HIL_FOLDER) SECONDS_LED=$(HIL_LED) hil_tests/on_usb.sh
hil_also = --also "$(1) $(3) $(ON_USB) $(1) $(2)"
hil_usb = $(call hil_also,$(1),checks,libusb_and_hidapi) $(call hil_also,$(1),app,the_whole_app) $(call hil_also,$(1),cases,the_same_cases_on_the_image) \
          $(call hil_also,$(1),aorta,aorta_session_by_cournand) $(call hil_also,$(1),free_run,a_session_that_the_rig_leads) \
          $(call hil_also,$(1),unplug,unplugged_in_a_session) $(call hil_also,$(1),two,two_rigs_by_serial_number)
HIL_L2 := $(call hil_usb,L2)
HIL_L3 := $(call hil_usb,L3)

hil: packages-build packages-run packages-hil packages-usb packages-matrix ## every level of emulation with every case, and the aorta session: docs/hil.md
	@$(QUIET_MAKE) $(HIL_LEVELS) hil-programs
	@$(MAKE) --no-print-directory PACKAGES=skip $(SCENE)
	@$(HIL_PROGRAM) --scene $(SCENE) --free-run $(HIL_FREE) --also "L0 faults_on_purpose $(HIL_CAMPAIGN)" \
	    --also "L1 faults_on_purpose $(HIL_CAMPAIGN) --level L1 --spread $(HIL_SPREAD) --tsv out/hil_campaign_l1.tsv" $(HIL_L2) $(HIL_L3) \
	    --also "L4 one_hash_on_five_machines tools/check/matrix.py --short --jobs $(JOBS)" \
	    --also "L4 the_app_and_its_wire hil_tests/l4/wire_everywhere.sh"

hil-full: ## make hil with FREE_RUN for a minute everywhere, cases in full at L2 and L3, 520 faults on the image, and all faults under the sanitizers
	@SHORT="--pause 1" LIMIT=600 STRICT=1 $(MAKE) --no-print-directory hil HIL_LED=60 HIL_FREE=60000 HIL_SPREAD=520
	@$(MAKE) --no-print-directory PACKAGES=skip hil-faults

hil-faults: packages-build packages-test ## every fault on purpose at L0 under the sanitizers (a few minutes)
	@$(SAN_MAKE) $(BUILD)/san/bin/hil_campaign
	@$(BUILD)/san/bin/hil_campaign --tsv out/hil_campaign_san.tsv

hil-loop hil-emulator: packages-build packages-run packages-hil # levels L0 and L1
	@$(QUIET_MAKE) $(HIL_LEVELS)
	@$(MAKE) --no-print-directory PACKAGES=skip $(SCENE)
	@$(HIL_PROGRAM) --level $(if $(filter hil-loop,$@),L0,L1) --scene $(SCENE) --free-run $(HIL_FREE)
hil-loop: ## level L0: the cases and the aorta session with the device inside the process
hil-emulator: ## level L1: the same on the image in an emulated Cortex-M7
hil-machines: packages-build packages-matrix ## level L4: one hash on five machines, and the app with its wire there
	@tools/check/matrix.py --short --jobs $(JOBS) && hil_tests/l4/wire_everywhere.sh

hil-rig: packages-build packages-run packages-usb ## the cases that need no plant on a rig of metal: make hil-rig SERIAL=...
	@$(QUIET_MAKE) $(HIL_PROGRAM)
	@$(MAKE) --no-print-directory PACKAGES=skip $(SCENE)
	@$(HIL_PROGRAM) --level rig --serial "$(SERIAL)" --scene $(SCENE)

# The real board's image, never run on hardware: docs/porting.md
RT1062_IMAGE   := $(BUILD)/firmware/cournand-imxrt1062.elf
RT1062_FOLDER  := firmware/port/imxrt1062
RT1062_OBJECTS := $(BUILD)/firmware/imxrt1062
RT1062_SOURCES := $(wildcard firmware/core/*.c firmware/app/*.c firmware/app/haptics/*.c firmware/app/safety/*.c firmware/app/usb/*.c firmware/port/usb/*.c shared/wire/*.c shared/scene/*.c \
                  $(RT1062_FOLDER)/*.c) firmware/port/mps2_an500/memory.c
$(RT1062_OBJECTS)/firmware/core/%.c.o: IMAGE_OPT := $(CORE_OPT) -fno-schedule-insns -fno-tree-pre
$(RT1062_OBJECTS)/firmware/app/usb/%.c.o: IMAGE_OPT := -O2 $(USB_ID_FLAGS)
$(RT1062_OBJECTS)/%.c.o: IMAGE_OPT ?= -O2
$(RT1062_OBJECTS)/%.c.o: %.c
	@mkdir -p $(@D)
	$(Q) $(M7_CC) $(M7_FLAGS) $(IMAGE_FLAGS) $(IMAGE_OPT) -c $< -o $@
$(RT1062_IMAGE): $(RT1062_SOURCES:%=$(RT1062_OBJECTS)/%.o) $(RT1062_FOLDER)/image.ld
	$(Q) $(M7_CC) -mcpu=cortex-m7 -mthumb -mfloat-abi=soft -nostdlib -Wl,--gc-sections -T $(RT1062_FOLDER)/image.ld $(filter %.o,$^) -o $@ -lgcc
$(RT1062_IMAGE:.elf=.hex): $(RT1062_IMAGE)
	$(Q) arm-none-eabi-objcopy -O ihex $< $@

firmware-board: packages-build packages-matrix ## build and check the image for a real board (i.MX RT1062, never run on one): docs/porting.md
	@$(QUIET_MAKE) $(RT1062_IMAGE:.elf=.hex)
	@tools/bench/image_report.py --objects $(RT1062_OBJECTS) --port imxrt1062 $(RT1062_IMAGE)

registers: packages-registers ## hold the board's registers against the crate imxrt-ral (fetched from crates.io)
	@tools/check/check_registers.py

firmware: packages-build packages-matrix firmware-board ## build the device's images, for the emulated Cortex-M7 and a real board, and check them: build/firmware
	@$(QUIET_MAKE) $(IMAGE)
	@tools/bench/image_report.py --objects $(BUILD)/firmware/obj $(IMAGE)

# --- the thesis' rod beside ours: docs/thesis.md ---------------------------------------------------------------------
PHANTOM_TEXT  := $(BUILD)/anatomy/phantom/scene.toml
PHANTOM_SCENE := out/phantom.scene
$(PHANTOM_TEXT): $(BUILD)/bin/anatomy
	@echo "Making the phantom"
	@$(BUILD)/bin/anatomy phantom -o $(@D) --no-bodies
$(PHANTOM_SCENE): $(PHANTOM_TEXT) $(BUILD)/bin/bake
	@mkdir -p out
	@echo "Baking $(PHANTOM_SCENE)"
	@$(BUILD)/bin/bake $(PHANTOM_TEXT) -o $(PHANTOM_SCENE)

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
	@$(BUILD)/bin/centreline show --wireframe --mesh $(HEART_FRAME) --part heart --part aortic_root --turn 20 --size 900 -o $(@D)/heart.png
	@ffmpeg -v error -y -i $(@D)/coronaries.png -i $(@D)/heart.png -filter_complex hstack $@
	@rm $(@D)/coronaries.png $(@D)/heart.png
# The right artery under fluoroscopy when the first injection has filled it, in both looks; both arteries in cine.
SCREEN_FIGURE := out/thesis/figure_5_6.png
out/coronary_right_vcsim3.mp4: out/coronary_right.mp4
	@$(BUILD)/bin/cournand run --scene $(HEART) --tool $(WIRE) --tool shared/examples/instruments/guide_ntr_6f.toml \
	    --session shared/examples/sessions/coronary_right.session --style vcsim3 --mp4 $@ > $(@:.mp4=.log)
$(SCREEN_FIGURE): out/coronary_right_vcsim3.mp4 out/coronary_right.mp4
	@mkdir -p $(@D) && ffmpeg -v error -y -ss 45.6 -i $< -ss 45.6 -i $(word 2,$^) -filter_complex hstack -frames:v 1 $@
MEDIUM_FIGURE := out/thesis/figure_5_8.png
$(MEDIUM_FIGURE): out/coronary_right.png out/coronary.png
	@mkdir -p $(@D) && ffmpeg -v error -y -i out/coronary_right.png -i out/coronary.png -filter_complex hstack $@

# The LAD under its balloon (tools/pci.mk): three moments under fluoroscopy, and the polygons round the lesion.
LESION_FIGURE := out/thesis/figure_5_10.png
out/thesis/figure_5_10.png: out/pci_lad.rec tools/lab/figures/figure_5_10.sh $(BUILD)/bin/cournand
	@mkdir -p $(@D) && tools/lab/figures/figure_5_10.sh $< $@ $(BUILD)

thesis: packages-build packages-run packages-bench ## Figures 5.6 to 5.10 and 5.11 to 5.14 of the thesis, by its own rod and by ours: out/thesis/index.html (minutes)
	@$(QUIET_MAKE) $(BUILD)/bin/cournand
	@$(MAKE) --no-print-directory PACKAGES=skip $(WIRES_FIGURE) $(SCREEN_FIGURE) $(MEDIUM_FIGURE) $(LESION_FIGURE)
	@$(QUIET_MAKE) $(BUILD)/bin/vcsim3 $(BUILD)/bin/centreline $(PHANTOM_SCENE)
	@$(MAKE) --no-print-directory PACKAGES=skip $(LINE_FIGURE)
	@$(BUILD)/bin/vcsim3 figures --scene $(PHANTOM_SCENE) -o out/thesis --threads $(JOBS) --instructions

docs-pictures: packages-build packages-run ## make the pictures of README and docs anew, each with its stamp (NAMES=..., minutes)
	@$(QUIET_MAKE) $(PROGRAMS)
	@$(MAKE) --no-print-directory PACKAGES=skip $(SCENE) $(HEART)
	@tools/docs/pictures.py --write $(NAMES)

docs: packages-build ## write the generated tables of docs/wire.md, usb.md, faults.md and instruments.md, and its picture
	@$(QUIET_MAKE) $(BUILD)/bin/docs $(BUILD)/bin/cournand
	@$(BUILD)/bin/docs --write
	@tools/docs/printed.py --write --build $(BUILD)
	@$(BUILD)/bin/cournand instruments --table docs/instruments.md --png docs/images/instruments.png > /dev/null

dissector: packages-build ## write out/cournand.lua, which lets Wireshark read the wire (docs/wire.md)
	@$(QUIET_MAKE) $(BUILD)/bin/docs
	@mkdir -p out
	@$(BUILD)/bin/docs --dissector out/cournand.lua
	@echo "Written: out/cournand.lua; use it as wireshark -X lua_script:out/cournand.lua"

# --- the right to open a rig: docs/rig.md --------------------------------------------------------------------------------
UDEV_RULES := $(DESTDIR)/etc/udev/rules.d/60-cournand.rules
install-udev: ## let users of this machine open a rig on USB (as root, or DESTDIR=folder)
	@mkdir -p $(dir $(UDEV_RULES))
	@sed 's/=="1209"/=="$(word 1,$(subst :, ,$(USB_ID)))"/; s/=="0001"/=="$(word 2,$(subst :, ,$(USB_ID)))"/' tools/udev/60-cournand.rules > $(UDEV_RULES)
	@if [ -z "$(DESTDIR)" ]; then udevadm control --reload && udevadm trigger --subsystem-match=usb --subsystem-match=hidraw; fi
	@echo "Written: $(UDEV_RULES). Plug the rig out and in."

include tools/bars/bars.mk

clean: ## remove build/ and out/
	rm -rf build out

format: ## lay out every C and C++ file by .clang-format and Python by .ruff.toml
	git ls-files '*.c' '*.h' '*.cpp' '*.hpp' | xargs clang-format -i
	ruff format -q .

-include $(shell [ -d $(BUILD)/obj ] && find $(BUILD)/obj $(wildcard $(BUILD)/m7 $(BUILD)/firmware $(BUILD)/pch) -name '*.d')
