# Seldinger: `make help` lists the targets. Everything is built under $(BUILD); results go to out/.
#   BUILD=build/clang CC=clang CXX=clang++   another compiler in its own folder
#   OPT=-O0 CORE_OPT=-O0                     another optimisation level
#   SAN=address,undefined                    sanitizers
#   PACKAGES=skip                            do not look for missing Debian packages
BUILD    ?= build
CC       := $(if $(filter default,$(origin CC)),gcc,$(CC))
CXX      := $(if $(filter default,$(origin CXX)),g++,$(CXX))
OPT      ?= -O2
CORE_OPT ?= -O3
SAN      ?=
PACKAGES ?= install

WARN     := -Wall -Wextra -Wshadow -Werror
SANFLAGS := $(if $(SAN),-fsanitize=$(SAN) -fno-sanitize-recover=all -fno-omit-frame-pointer)
CFLAGS   := -std=c11 -g $(WARN) -Wpedantic -Wvla -Wmissing-prototypes -I. -MMD -MP $(SANFLAGS)
CXXFLAGS := -std=c++20 -g $(WARN) -I. -isystem /usr/include/eigen3 -MMD -MP -ffp-contract=off $(SANFLAGS)
LDFLAGS  := -pthread $(SANFLAGS)

# --- libraries: one per folder, lowest layer last (link order) -------------------------------------------------
LIBS       := host/app host/xray host/link host/model tools/anatomy tools/bake firmware/port/sim firmware/app \
              firmware/core shared/scene shared/wire
lib_file    = $(BUILD)/lib/lib$(subst /,_,$(1)).a
lib_sources = $(filter-out %/main.cpp,$(wildcard $(1)/*.c $(1)/*.cpp))
objects     = $(patsubst %,$(BUILD)/obj/%.o,$(1))

# What each program and test folder links, in link order.
FIRMWARE_LIBS := firmware/port/sim firmware/app firmware/core shared/scene shared/wire
HOST_LIBS     := host/app host/xray host/link host/model $(FIRMWARE_LIBS)
BAKE_LIBS     := tools/bake host/model firmware/core shared/scene shared/wire
ANATOMY_LIBS  := tools/anatomy
VDB_LINK      := -lopenvdb -ltbb -lImath-3_1
BAKE_LINK     := $(VDB_LINK) -lassimp -lccd
HOST_LINK     := -lpng -lglfw -ldl

PROGRAMS := $(BUILD)/bin/seldinger $(BUILD)/bin/bake $(BUILD)/bin/anatomy

.PHONY: all run test bench fuzz format help clean packages-% tests-build
.DEFAULT_GOAL := all
MAKEFLAGS += --no-builtin-rules

all: packages-build ## build every program into build/bin
	@$(MAKE) --no-print-directory PACKAGES=skip $(PROGRAMS)

help: ## this list
	@awk -F':.*## ' '/^[a-z%-]+:.*## /{printf "  make %-12s %s\n",$$1,$$2}' $(MAKEFILE_LIST)

packages-%:
	@[ "$(PACKAGES)" = skip ] || tools/check/install_packages.sh $*

# --- rules ------------------------------------------------------------------------------------------------------
$(BUILD)/obj/firmware/core/%.c.o: OPT := $(CORE_OPT)
$(BUILD)/obj/firmware/core/%.c.o: CFLAGS += -ffreestanding -fno-schedule-insns
$(BUILD)/obj/%.c.o: %.c
	@mkdir -p $(@D)
	$(CC) $(CFLAGS) $(OPT) -c $< -o $@
$(BUILD)/obj/%.cpp.o: %.cpp
	@mkdir -p $(@D)
	$(CXX) $(CXXFLAGS) $(OPT) -c $< -o $@

define library
$(call lib_file,$(1)): $(call objects,$(call lib_sources,$(1)))
	@mkdir -p $$(@D)
	@rm -f $$@
	ar rcs $$@ $$^
endef
$(foreach lib,$(LIBS),$(eval $(call library,$(lib))))

# program(name, main, libs, link)
define program
$(BUILD)/bin/$(1): $(call objects,$(2)) $(foreach lib,$(3),$(call lib_file,$(lib)))
	@mkdir -p $$(@D)
	$(CXX) $$^ -o $$@ $(LDFLAGS) $(4)
endef
$(eval $(call program,seldinger,host/app/main.cpp,$(HOST_LIBS),$(HOST_LINK)))
$(eval $(call program,bake,tools/bake/main.cpp,$(BAKE_LIBS),$(BAKE_LINK)))
$(eval $(call program,anatomy,tools/anatomy/main.cpp,$(ANATOMY_LIBS),$(VDB_LINK)))

# --- tests: every test_* file is one program --------------------------------------------------------------------
FIRMWARE_TESTS := $(wildcard firmware/tests/test_*.c shared/*/tests/test_*.c hil_tests/test_*.c)
HOST_TESTS     := $(wildcard host/tests/test_*.cpp)
TOOL_TESTS     := $(wildcard tools/bake/tests/test_*.cpp)
SCRIPT_TESTS   := $(wildcard tools/check/test_*.sh tools/check/test_*.py host/tests/test_*.sh tools/*/tests/test_*.sh)
test_program    = $(patsubst %,$(BUILD)/test/%,$(basename $(1)))
REFERENCE       := $(wildcard firmware/tests/reference/*.c)

define test_rule
$(call test_program,$(1)): $(call objects,$(1) $(4)) $(foreach lib,$(2),$(call lib_file,$(lib)))
	@mkdir -p $$(@D)
	$(CXX) $$^ -o $$@ $(LDFLAGS) -lcmocka -lm $(3)
endef
$(foreach t,$(FIRMWARE_TESTS),$(eval $(call test_rule,$(t),$(FIRMWARE_LIBS),,$(REFERENCE))))
$(foreach t,$(HOST_TESTS),$(eval $(call test_rule,$(t),$(HOST_LIBS),$(HOST_LINK),)))
$(foreach t,$(TOOL_TESTS),$(eval $(call test_rule,$(t),$(BAKE_LIBS),$(BAKE_LINK),)))
FIRMWARE_TEST_PROGRAMS := $(foreach t,$(FIRMWARE_TESTS),$(call test_program,$(t)))
ALL_TEST_PROGRAMS := $(FIRMWARE_TEST_PROGRAMS) $(foreach t,$(HOST_TESTS) $(TOOL_TESTS),$(call test_program,$(t)))

tests-build: $(ALL_TEST_PROGRAMS)

test: packages-build packages-test ## build and run every test
	@tools/check/run_tests.sh

clean: ## remove build/ and out/
	rm -rf build out

format: ## lay out every C and C++ file by .clang-format
	git ls-files '*.c' '*.h' '*.cpp' '*.hpp' | xargs clang-format -i

-include $(shell [ -d $(BUILD)/obj ] && find $(BUILD)/obj -name '*.d')
