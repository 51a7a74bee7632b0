# The main entry to the project: `make help` lists the targets. CMake and Ninja build the programs (CMakeLists.txt,
# CMakePresets.json, one list per room); tools/make has the other targets. Everything is built below $(BUILD); results
# go to out/.
#   PACKAGES=skip   do not look for missing Debian packages        YES=1   install missing ones without a question
#   JOBS=4          compilers and tests at once                    V=1     show whole commands
BUILD    ?= build
PACKAGES ?= install
JOBS     ?= $(shell nproc)
SECONDS  ?= 60
USB_ID   ?= 1209:0001
export BUILD V
MAKEFLAGS += --no-builtin-rules
.DEFAULT_GOAL := help
.DELETE_ON_ERROR:

# build(preset, parts, targets). `again` runs a second make, for targets that need programs which the first one built.
build = @JOBS=$(JOBS) CMAKE_ARGS="$(CMAKE_ARGS)" tools/build.sh $(1) $(2) $(3)
again = @$(MAKE) -s --no-print-directory PACKAGES=skip
# Several sections in one target, packages-build+tools, lead to one question.
packages-%:
	@[ "$(PACKAGES)" = skip ] || MAKE_GOALS="$(MAKECMDGOALS)" tools/check/install_packages.sh $(subst +, ,$*)

.PHONY: help run window igtl scene test deb docs install clean

##@ For everyone
help: ## this list
	@awk -F':.*## ' '/^##@ /{printf "\n%s\n",substr($$0,5)} \
	    /^[a-z0-9%-]+:.*## /{printf "  make %-20s %s\n",$$1,$$2}' $(MAKEFILE_LIST)

run: packages-build$(if $(DISPLAY),+window) ## build, run the demo into out/, open the window if there is a display
	$(call build,release,run$(if $(DISPLAY),$(comma)window),cournand)
	$(again) $(DEMO_OUT)
	@echo "Written: $(DEMO_OUT)"
	@if [ -n "$$DISPLAY" ]; then \
	    $(BUILD)/bin/cournand view --scene $(SCENE) --instrument $(WIRE) --record out/view.rec || \
	    echo "The demo is complete; only the window did not open."; \
	else echo "No display, so no window: 'make window' opens it where there is one."; fi

window: packages-build+window ## push and turn a guidewire by keyboard (needs a display)
	$(call build,release,run$(comma)window,cournand)
	$(again) $(SCENE)
	@$(BUILD)/bin/cournand view --scene $(SCENE) --instrument $(WIRE) --record out/view.rec

igtl: packages-build+igtl$(if $(DISPLAY),+window) ## build the program so that 3D Slicer can watch (docs/slicer.md)
	$(call build,release,run$(comma)igtl$(if $(DISPLAY),$(comma)window),cournand)

test: ## test the product: all programs, sanitizers, a short fuzz run, machines, levels L0 and L1
test: packages-build+tools+test+matrix+usb+bench
	@JOBS=$(JOBS) tools/check/run_tests.sh product

install: ## install programs, man pages, completion, libraries, headers, pkg-config files (PREFIX=, DESTDIR=)
install: packages-build+tools
	$(call build,release,run$(comma)tools,cournand bake anatomy centreline cournand_library)
	@cmake --install $(BUILD) --prefix $(or $(PREFIX),/usr/local)

deb: ## make Debian packages: out/deb (docs/installing.md)
deb: packages-build+tools+deb
	$(call build,release,run$(comma)tools,cournand bake anatomy centreline cournand_library)
	@tools/deb/make_packages.py --build $(BUILD) --output out/deb

docs: ## build the docs as a site with search: out/site/index.html
	@tools/docs/site.py --build $(BUILD)

clean: ## remove build/ and out/
	rm -rf build out

comma := ,
include tools/make/scenes.mk tools/make/developer.mk tools/make/rig.mk tools/make/evidence.mk \
    tools/make/safety.mk
