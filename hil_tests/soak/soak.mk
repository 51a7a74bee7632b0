# Random sessions for hours: docs/soak.md. Read by the Makefile, whose libraries and rules it uses.
SOAK        := $(BUILD)/bin/soak
SOAK_SCENES := $(SCENE) $(HEART) out/phantom.scene out/lad_pci.scene out/renal_pci.scene
$(SOAK): $(call objects,hil_tests/soak/main.cpp) $(foreach lib,hil_tests/soak $(HOST_LIBS),$(call lib_file,$(lib)))
	@mkdir -p $(@D)
	$(Q) $(CXX) $^ -o $@ $(LDFLAGS) $(HOST_LINK)

# HOURS=h of this call, or until SESSIONS and TICKS are reached; SEED= other sessions. A later call with the same seed goes on.
.PHONY: soak
soak: packages-build packages-run ## random sessions over all scenes and instruments, held against bars: HOURS=1 SEED=1 (docs/soak.md)
	@$(QUIET_MAKE) $(PROGRAMS) $(SOAK)
	@$(MAKE) --no-print-directory PACKAGES=skip $(SOAK_SCENES)
	@$(SOAK) --jobs $(JOBS) $(if $(SEED),--seed $(SEED)) $(if $(HOURS),--hours $(HOURS)) $(if $(SESSIONS),--sessions $(SESSIONS)) \
	    $(if $(TICKS),--ticks $(TICKS)) $(foreach scene,$(SOAK_SCENES),--scene $(scene))
