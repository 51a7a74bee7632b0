# Two angioplasties, from the shipped anatomy with a lesion to film, DICOM and figures: docs/lesions.md, "Two cases". Read by the Makefile.

# diseased(scene, anatomy's text, lesion): the text with a lesion beside the healthy one, which is baked as it is.
define diseased
out/$(1).scene out/$(1).bodies &: $(2) shared/examples/lesions/$(3).toml $(BUILD)/bin/bake
	@mkdir -p out
	@echo "Baking out/$(1).scene"
	@cat $(2) shared/examples/lesions/$(3).toml > $(dir $(2))$(1).toml
	@$(BUILD)/bin/bake $(dir $(2))$(1).toml -o out/$(1).scene
endef
$(eval $(call diseased,lad_pci,$(HEART_TEXT),lad_middle))
$(eval $(call diseased,renal_pci,$(ANATOMY),renal_ostium))

# angioplasty(session, scene, wire balloon guide, stent): film, last picture, figures, score, DICOM runs and recording of a session.
PCI_TOOLS = $(foreach tool,$(1),--tool shared/examples/instruments/$(tool).toml)
define angioplasty
out/$(1).mp4 out/$(1).png out/$(1).json out/$(1).html out/$(1).rec &: out/$(2).scene shared/examples/sessions/$(1).session $(foreach tool,$(3),shared/examples/instruments/$(tool).toml) shared/examples/stents/$(4).toml $(BUILD)/bin/cournand
	@echo "Running shared/examples/sessions/$(1).session"
	@rm -rf out/$(1)_dicom
	@$(BUILD)/bin/cournand run --scene out/$(2).scene $(call PCI_TOOLS,$(3)) --session shared/examples/sessions/$(1).session \
	    --stent shared/examples/stents/$(4).toml --record out/$(1).rec --json out/$(1).json --score out/$(1).html --png out/$(1).png --mp4 out/$(1).mp4 --dicom out/$(1)_dicom
endef
$(eval $(call angioplasty,pci_lad,lad_pci,coronary_014 balloon_3x20 guide_jl3_6f,coronary_3_0x18))
$(eval $(call angioplasty,pci_renal,renal_pci,terumo_stiff_angled balloon_6x20 guide_jr4_6f,renal_6_0x18))
PCI_OUT := $(foreach name,pci_lad pci_renal,out/$(name).mp4 out/$(name).png out/$(name).json out/$(name).html out/$(name).rec)

demo-pci: packages-build packages-run ## two angioplasties, LAD and left renal artery: out/pci_lad.mp4, out/pci_renal.mp4, DICOM and figures beside them (minutes)
	@$(QUIET_MAKE) $(PROGRAMS)
	@$(MAKE) --no-print-directory PACKAGES=skip $(PCI_OUT)
	@echo "Written: $(PCI_OUT) out/pci_lad_dicom out/pci_renal_dicom"
