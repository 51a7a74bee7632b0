# Firmware, rigs, and the levels of emulation: docs/hil.md, docs/porting.md, docs/rig.md.
##@ For rig builders
.PHONY: firmware firmware-board registers install-udev hil hil-full hil-faults hil-loop hil-emulator
.PHONY: hil-machines hil-mock hil-guest hil-usbtest hil-rig
.PHONY: hil-board hil-board-faults hil-board-mutants hil-passivity hil-lies soak hours hours-m7
IMAGE_ARGS   = -DCRN_USB_ID=$(USB_ID)

firmware: ## build the images for the emulated Cortex-M7 and a real board, and check them: build/firmware
firmware: packages-build+matrix
	@JOBS=$(JOBS) CMAKE_ARGS="$(IMAGE_ARGS)" tools/build.sh m7 run cournand-mps2_an500 cournand-imxrt1062
	@tools/bench/image_report.py --build $(BUILD)
	@tools/bench/image_report.py --build $(BUILD) --port imxrt1062

firmware-board: packages-build+matrix ## build the image for a real board alone (i.MX RT1062, never run on one)
	@JOBS=$(JOBS) CMAKE_ARGS="$(IMAGE_ARGS)" tools/build.sh m7 run cournand-imxrt1062
	@tools/bench/image_report.py --build $(BUILD) --port imxrt1062

registers: ## compare the board's registers with the crate imxrt-ral (fetched from crates.io)
registers: packages-registers
	@tools/check/check_registers.py

UDEV_RULES := $(DESTDIR)/etc/udev/rules.d/60-cournand.rules
install-udev: ## let users of this machine open a rig on USB (as root, or DESTDIR=folder)
	@mkdir -p $(dir $(UDEV_RULES))
	@sed 's/=="1209"/=="$(word 1,$(subst :, ,$(USB_ID)))"/; s/=="0001"/=="$(word 2,$(subst :, ,$(USB_ID)))"/' \
	    tools/udev/60-cournand.rules > $(UDEV_RULES)
	@if [ -z "$(DESTDIR)" ]; then udevadm control --reload && \
	    udevadm trigger --subsystem-match=usb --subsystem-match=hidraw; fi
	@echo "Written: $(UDEV_RULES). Plug the rig out and in."

HIL          := $(BUILD)/bin/hil
HIL_CAMPAIGN := $(BUILD)/bin/hil_campaign
# Seconds of a session in which the rig leads at L2 and L3, and milliseconds of a session in FREE_RUN at L0 and L1.
HIL_LED  ?= 15
HIL_FREE ?= 4000
# Deliberate faults on the image: a selection of all kinds.
HIL_SPREAD ?= 40
ON_USB   := BUILD=$(BUILD) HIL=$(BUILD)/hil SECONDS_LED=$(HIL_LED) hil_tests/on_usb.sh
hil_also  = --also "$(1) $(3) $(ON_USB) $(1) $(2)"
hil_usb   = $(call hil_also,$(1),checks,libusb_and_hidapi) $(call hil_also,$(1),app,the_whole_app) \
            $(call hil_also,$(1),cases,the_same_cases_on_the_image) \
            $(call hil_also,$(1),aorta,aorta_session_by_cournand) \
            $(call hil_also,$(1),free_run,a_session_that_the_rig_leads) \
            $(call hil_also,$(1),unplug,unplugged_in_a_session) \
            $(call hil_also,$(1),two,two_rigs_by_serial_number)
HIL_PACKAGES := packages-build+tools+test+hil+usb+matrix
define hil_build
	$(call build,release,run$(comma)tools$(comma)tests,cournand hil hil_rig hil_campaign hil_programs hil_rt1062)
	$(call build,m7,run,cournand-mps2_an500 cournand-imxrt1062)
	$(again) $(SCENE)
endef
HIL_CHIP := $(BUILD)/hil/hil_rt1062 --image $(BUILD)/firmware/cournand-imxrt1062.elf

hil: $(HIL_PACKAGES) ## run every level of emulation with every case, and the aorta session: docs/hil.md
	$(hil_build)
	@$(HIL) --scene $(SCENE) --free-run $(HIL_FREE) --also "L0 faults_on_purpose $(HIL_CAMPAIGN)" \
	    --also "L1 faults_on_purpose $(HIL_CAMPAIGN) --level L1 --spread $(HIL_SPREAD) --tsv out/hil_campaign_l1.tsv" \
	    $(call hil_usb,L2) $(call hil_usb,L3) \
	    --also "RT hil.rt1062_hash $(HIL_CHIP) --aorta --scene $(SCENE) --figures out/hil_rt1062.tsv" \
	    --also "L4 one_hash_on_five_machines tools/check/matrix.py --short --jobs $(JOBS)" \
	    --also "L4 the_app_and_its_wire hil_tests/l4/wire_everywhere.sh"

hil-full: ## run make hil with a minute of FREE_RUN, all cases at L2 and L3, 520 faults, all sanitized
	@SHORT="--pause 1" LIMIT=600 STRICT=1 $(MAKE) --no-print-directory hil HIL_LED=60 HIL_FREE=60000 HIL_SPREAD=520
	$(again) hil-faults hil-usbtest

hil-faults: packages-build+test+usb ## inject every fault at L0 under the sanitizers (a few minutes)
	$(call build,sanitize,run$(comma)tests,hil_campaign)
	@$(BUILD)/san/bin/hil_campaign --tsv out/hil_campaign_san.tsv

hil-loop hil-emulator hil-mock hil-guest: $(HIL_PACKAGES)
	$(hil_build)
	@case $@ in hil-loop) $(HIL) --level L0 --scene $(SCENE) --free-run $(HIL_FREE) ;; \
	    hil-emulator) $(HIL) --level L1 --scene $(SCENE) --free-run $(HIL_FREE) ;; \
	    hil-mock) HIL=$(BUILD)/hil hil_tests/l2/test_l2.sh && $(HIL) --level L2 $(call hil_usb,L2) ;; \
	    hil-guest) $(HIL) --level L3 $(call hil_usb,L3) ;; esac
hil-loop: ## run level L0: the cases and the aorta session with the device inside the process
hil-emulator: ## run level L1: the same on the image in an emulated Cortex-M7
hil-mock: ## run level L2: libusb and hidapi see the device by umockdev, on a machine without USB
hil-guest: ## run level L3: the device behind a real Linux: Debian's kernel in QEMU, xHCI, libusb, hidapi
hil-machines: packages-build+matrix ## run level L4: one hash on five machines, and the app with its wire there
	@tools/check/matrix.py --short --jobs $(JOBS) && hil_tests/l4/wire_everywhere.sh

hil-usbtest: ## run the kernel's own USB tests (usbtest) on source and sink in both images: out/hil_usbtest.tsv
hil-usbtest: $(HIL_PACKAGES)
	$(call build,release,run$(comma)tools$(comma)tests,hil_rig hil_rt1062 hil_programs)
	$(call build,m7,run,cournand-mps2_an500 usbtest-mps2_an500 usbtest-imxrt1062)
	@BUILD=$(BUILD) hil_tests/l3/usbtest.sh

hil-board: ## run the board's own image on its emulated chip: the cases, L3, aorta and heart to the host's hash
hil-board: $(HIL_PACKAGES)
	$(call build,release,run$(comma)tools$(comma)tests,hil_rt1062 hil_programs)
	$(call build,m7,run,cournand-imxrt1062)
	$(again) $(SCENE) $(HEART)
	@$(BUILD)/hil/hil_rt1062 && $(ON_USB) L3 board && $(BUILD)/hil/hil_rt1062 --aorta --scene $(SCENE) && \
	    $(BUILD)/hil/hil_rt1062 --aorta --scene $(HEART) --aorta-ticks 12000

hil-board-faults: ## break the emulated chip 2,200 times: out/hil_rt1062_faults.tsv (4 to 20 minutes)
hil-board-faults: $(HIL_PACKAGES)
	$(call build,release,run$(comma)tests,hil_rt1062_faults)
	$(call build,m7,run,cournand-imxrt1062)
	@$(BUILD)/hil/hil_rt1062_faults --image $(BUILD)/firmware/cournand-imxrt1062.elf --count 2200 --jobs $(JOBS)

hil-board-mutants: ## make the model of the chip wrong 600 times: which test notices? (20 to 60 minutes)
hil-board-mutants: $(HIL_PACKAGES)
	$(call build,release,run$(comma)tests,hil_rt1062 rt1062_tests)
	$(call build,m7,run,cournand-imxrt1062)
	@BUILD=$(BUILD) hil_tests/rt1062/faults/mutants.py --count 600

hil-rig: ## run the cases that need no plant on a physical rig: make hil-rig SERIAL=...
hil-rig: packages-build+tools+test+usb
	$(call build,release,run$(comma)tools$(comma)tests,hil)
	$(again) $(SCENE)
	@$(HIL) --level rig --serial "$(SERIAL)" --scene $(SCENE)

# The grid of gain, coupling, damping, lag and hand (docs/haptics.md, "The grid"); make test runs a selection of it.
hil-passivity: ## run every combination of gain, coupling, stated damping and lag at an end wall
hil-passivity: packages-build+tools+test+usb
	$(call build,release,run$(comma)tools$(comma)tests,hil_campaign)
	@$(HIL_CAMPAIGN) --passivity 1 --tsv out/hil_passivity.tsv

hil-lies: ## send more than 200 false replies to every command: out/hil_lies.tsv (some minutes)
hil-lies: packages-build+tools+test+usb
	$(call build,release,run$(comma)tools$(comma)tests,hil_lies)
	@$(BUILD)/bin/hil_lies

# A call runs for HOURS=h, or until SESSIONS and TICKS are reached; SEED= selects other sessions. A later call with
# the same seed continues.
SOAK_SCENES := $(SCENE) $(HEART) $(PHANTOM_SCENE) out/lad_pci.scene out/renal_pci.scene
soak: ## run random sessions over all scenes and instruments, with limits: HOURS=1 SEED=1 (docs/soak.md)
soak: packages-build+tools+test+usb
	$(call build,release,run$(comma)tools$(comma)tests,$(TOOLS) soak)
	$(again) $(SOAK_SCENES)
	@$(BUILD)/bin/soak --jobs $(JOBS) $(if $(SEED),--seed $(SEED)) $(if $(HOURS),--hours $(HOURS)) \
	    $(if $(SESSIONS),--sessions $(SESSIONS)) $(if $(TICKS),--ticks $(TICKS)) \
	    $(foreach scene,$(SOAK_SCENES),--scene $(scene))

# A call continues a former one with the same seed. The device's clock begins so that its microseconds also wrap within
# the hour of the emulated board.
hours: ## run the device for 24 hours of simulated time: HOURS=1 SEED=1 (docs/soak.md, "A day of the device")
hours: packages-build+tools+test+usb
	$(call build,release,run$(comma)tools$(comma)tests,$(TOOLS) hours)
	$(again) $(SCENE) $(PHANTOM_SCENE)
	@$(BUILD)/bin/hours $(if $(SEED),--seed $(SEED)) $(if $(HOURS),--hours $(HOURS)) \
	    --scene $(PHANTOM_SCENE) --scene $(SCENE)

hours-m7: $(HIL_PACKAGES) ## run the image on the emulated Cortex-M7 for an hour of simulated time: HOURS=0.1 SEED=1
	$(call build,release,run$(comma)tools$(comma)tests,$(TOOLS) hours)
	$(call build,m7,run,cournand-mps2_an500)
	$(again) $(PHANTOM_SCENE)
	@$(BUILD)/bin/hours --m7 $(if $(SEED),--seed $(SEED)) --hours $(or $(HOURS),1) --seconds-max 20 --long-every 0 \
	    --begin-ms 2500000 --scene free --scene $(PHANTOM_SCENE)
