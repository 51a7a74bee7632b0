# Makes scenes, recordings and films from anatomy. A shipped scene is unpacked; `make scene` rebuilds it.
ANATOMY := $(BUILD)/anatomy/aorta/scene.toml
SCENE   := out/aorta.scene
SHIPPED := shared/examples/scenes/aorta.tar.xz
DEMO    := shared/examples/sessions/demo.session
WIRE    := shared/examples/instruments/j_wire.toml

$(SCENE) $(SCENE:.scene=.bodies) &: $(SHIPPED)
	@mkdir -p out
	@tools/scenes/shipped.py unpack $(SHIPPED) -o out
DEMO_OUT := out/demo.mp4 out/demo.png out/demo.rec out/demo.json
$(DEMO_OUT) &: $(SCENE) $(DEMO) $(WIRE) $(BUILD)/bin/cournand
	@echo "Running $(DEMO)"
	@$(BUILD)/bin/cournand run --scene $(SCENE) --instrument $(WIRE) --session $(DEMO) --record out/demo.rec \
	    --json out/demo.json --png out/demo.png --mp4 out/demo.mp4

VESSELS := shared/examples/anatomies
$(ANATOMY): $(BUILD)/bin/anatomy $(VESSELS)/aorta.toml
	@echo "Making the anatomy"
	@$(BUILD)/bin/anatomy aorta -o $(@D)

# --- the heart and its coronary arteries: docs/contrast.md ---
HEART_TEXT  := $(BUILD)/anatomy/heart/scene.toml
HEART       := out/heart.scene
HEART_FRAME := $(BUILD)/anatomy/heart/beat/frame_00.obj
$(HEART_TEXT) $(HEART_FRAME) &: $(BUILD)/bin/anatomy $(VESSELS)/aorta.toml $(VESSELS)/heart.toml
	@echo "Making the heart (1.5 minutes of one core)"
	@$(BUILD)/bin/anatomy heart -o $(dir $(HEART_TEXT))
$(HEART) $(HEART:.scene=.bodies) &: $(HEART_TEXT) $(BUILD)/bin/bake
	@mkdir -p out
	@echo "Baking $(HEART)"
	@$(BUILD)/bin/bake $(HEART_TEXT) -o $(HEART)
# coronary_session(session, guide) makes film, last picture and figures of one artery's session.
define coronary_session
out/$(1).mp4 out/$(1).png out/$(1).json &: $(HEART) shared/examples/sessions/$(1).session $(WIRE) \
    shared/examples/instruments/$(2).toml $(BUILD)/bin/cournand
	@echo "Running shared/examples/sessions/$(1).session"
	@$(BUILD)/bin/cournand run --scene $(HEART) --tool $(WIRE) --tool shared/examples/instruments/$(2).toml \
	    --session shared/examples/sessions/$(1).session --json out/$(1).json --png out/$(1).png --mp4 out/$(1).mp4
endef
$(eval $(call coronary_session,coronary,guide_jl3_6f))
$(eval $(call coronary_session,coronary_right,guide_ntr_6f))
CORONARY_OUT := $(foreach name,coronary coronary_right,out/$(name).mp4 out/$(name).png out/$(name).json)

# --- real arteries, if their meshes are present ---
REAL_DATA  := $(or $(CRN_ANATOMY),../shared/anatomy)
REAL_ATLAS := $(REAL_DATA)/hra/VH_M_Blood_Vasculature_Heart.glb
REAL_LINES := $(foreach side,left right,$(dir $(ANATOMY))real_$(side).csv)
$(REAL_LINES) &: $(ANATOMY) tools/anatomy/real_coronaries.sh $(BUILD)/bin/centreline
	@tools/anatomy/real_coronaries.sh $(BUILD)/bin/centreline $(REAL_ATLAS) $(dir $(ANATOMY))
# The heart's landmarks in the atlas: the ostia of its left and right artery in the aorta, and the farthest point of
# its left ventricle.
REAL_BEAT  := $(dir $(ANATOMY))real_beat/lumen/lumen_00.ply
$(REAL_BEAT): shared/examples/real_coronaries_lumen.toml shared/examples/centrelines/real_aorta.csv $(REAL_LINES) \
    $(BUILD)/bin/bake $(BUILD)/bin/anatomy
	@$(BUILD)/bin/bake $< --shipped $(dir $(ANATOMY)) -o $(dir $(ANATOMY))real_lumen.scene \
	    --surface $(dir $(ANATOMY))real_lumen.ply --points 1000 --poses 0
	@$(BUILD)/bin/anatomy beat $(dir $(ANATOMY))real_lumen.ply --left 14.5 506.9 23.4 --right 0.2 500.9 40.3 \
	    --apex 73.1 433.6 81.3 -o $(@D)
out/real_coronaries.scene: shared/examples/real_coronaries.toml $(REAL_BEAT) $(BUILD)/bin/bake
	@mkdir -p out && echo "Baking $@ (5 minutes of one core)"
	@$(BUILD)/bin/bake $< --data $(REAL_DATA) --shipped $(dir $(ANATOMY)) -o $@
out/coronary_real.mp4: out/real_coronaries.scene shared/examples/sessions/coronary_real.session $(BUILD)/bin/cournand
	@$(BUILD)/bin/cournand run --scene $< --tool shared/examples/instruments/guide_jr4_6f.toml \
	    --session $(word 2,$^) --json $(@:.mp4=.json) --png $(@:.mp4=.png) --mp4 $@

# --- a real patient: docs/anatomy.md, "Real anatomy" ---
# SEX=female takes the woman; DATA=FOLDER names a folder that holds the data, or some of them.
SEX         ?= male
REAL_FOLDER := $(BUILD)/real_data
REAL_ENDING := $(if $(filter female,$(SEX)),_female)
REAL_SCENE  := out/real$(REAL_ENDING).scene
$(REAL_SCENE) $(REAL_SCENE:.scene=.bodies) &: shared/examples/real_patient$(REAL_ENDING).toml $(ANATOMY) \
    $(BUILD)/bin/bake
	@mkdir -p out && echo "Baking $(REAL_SCENE) (5 minutes of processor time)"
	@tools/scenes/real_patient.py bake $< --bake $(BUILD)/bin/bake --data $(REAL_FOLDER) --shipped $(dir $(ANATOMY)) \
	    -o $(REAL_SCENE)
out/real$(REAL_ENDING).png: $(REAL_SCENE) shared/examples/sessions/real_patient.session $(WIRE) $(BUILD)/bin/cournand
	@$(BUILD)/bin/cournand run --scene $< --tool $(WIRE) --session $(word 2,$^) --png $@

# --- two angioplasties: docs/lesions.md, "Two cases" ---
# diseased(scene, anatomy's text, lesion) writes the text with a lesion beside the healthy one, which is baked
# unchanged.
define diseased
out/$(1).scene out/$(1).bodies &: $(2) shared/examples/lesions/$(3).toml $(BUILD)/bin/bake
	@mkdir -p out
	@echo "Baking out/$(1).scene"
	@cat $(2) shared/examples/lesions/$(3).toml > $(dir $(2))$(1).toml
	@$(BUILD)/bin/bake $(dir $(2))$(1).toml -o out/$(1).scene
endef
$(eval $(call diseased,lad_pci,$(HEART_TEXT),lad_middle))
$(eval $(call diseased,renal_pci,$(ANATOMY),renal_ostium))
# angioplasty(session, scene, tools, stent) makes film, last picture, figures, score, DICOM runs and
# recording of a session.
PCI_TOOLS = $(foreach tool,$(1),--tool shared/examples/instruments/$(tool).toml)
define angioplasty
out/$(1).mp4 out/$(1).png out/$(1).json out/$(1).html out/$(1).rec &: out/$(2).scene \
    shared/examples/sessions/$(1).session \
    $(foreach tool,$(3),shared/examples/instruments/$(tool).toml) shared/examples/stents/$(4).toml $(BUILD)/bin/cournand
	@echo "Running shared/examples/sessions/$(1).session"
	@rm -rf out/$(1)_dicom
	@$(BUILD)/bin/cournand run --scene out/$(2).scene $(call PCI_TOOLS,$(3)) \
	    --session shared/examples/sessions/$(1).session \
	    --stent shared/examples/stents/$(4).toml --record out/$(1).rec --json out/$(1).json --score out/$(1).html \
	    --png out/$(1).png --mp4 out/$(1).mp4 --dicom out/$(1)_dicom
endef
$(eval $(call angioplasty,pci_lad,lad_pci,j_wire coronary_014 balloon_3x20 guide_jl3_6f,coronary_3_0x18))
$(eval $(call angioplasty,pci_renal,renal_pci,j_wire terumo_stiff_angled balloon_6x20 guide_jr4_6f,renal_6_0x18))
PCI_OUT := $(foreach name,pci_lad pci_renal,\
    out/$(name).mp4 out/$(name).png out/$(name).json out/$(name).html out/$(name).rec)

# --- phantoms: docs/thesis.md, docs/calibrate.md ---
PHANTOM_TEXT  := $(BUILD)/anatomy/phantom/scene.toml
PHANTOM_SCENE := out/phantom.scene
$(PHANTOM_TEXT): $(BUILD)/bin/anatomy $(VESSELS)/phantom.toml
	@echo "Making the phantom"
	@$(BUILD)/bin/anatomy phantom -o $(@D) --no-bodies
$(PHANTOM_SCENE): $(PHANTOM_TEXT) $(BUILD)/bin/bake
	@mkdir -p out
	@echo "Baking $(PHANTOM_SCENE)"
	@$(BUILD)/bin/bake $(PHANTOM_TEXT) -o $(PHANTOM_SCENE)
ACCESS        := out/access.scene
ACCESS_CHECKS ?= # of the baker: --points 1000 --poses 0 checks less
$(ACCESS) $(ACCESS:.scene=.ply) &: $(BUILD)/bin/anatomy $(BUILD)/bin/bake $(VESSELS)/access.toml
	@mkdir -p out && echo "Making and baking the silicone phantom"
	@$(BUILD)/bin/anatomy access --quiet -o $(BUILD)/anatomy/access
	@$(BUILD)/bin/bake $(BUILD)/anatomy/access/scene.toml -o $(ACCESS) --surface $(ACCESS:.scene=.ply) $(ACCESS_CHECKS)

##@ For trainees: procedures on film (minutes)
.PHONY: cases coronary coronary-real real-patient demo-pci timi
TOOLS = cournand bake anatomy centreline
cases: ## build all programs that cases need, and list the cases (docs/cases.md)
cases: packages-build+tools
	$(call build,release,run$(comma)tools,$(TOOLS))
	@$(BUILD)/bin/cournand case list

coronary: ## guides engage the left and the right coronary artery: out/coronary.mp4, out/coronary_right.mp4
coronary: packages-build+tools
	$(call build,release,run$(comma)tools,$(TOOLS))
	$(again) $(CORONARY_OUT)
	@echo "Written: $(CORONARY_OUT)"

timi: ## frame counts of the shipped heart, and the orders of its arteries (docs/contrast.md)
timi: packages-build+tools
	$(call build,release,run$(comma)tools,timi)
	@$(BUILD)/bin/timi

coronary-real: ## the same in an artery of the Human Reference Atlas (needs ../shared/anatomy)
coronary-real: packages-build+tools
	@if [ ! -e $(REAL_ATLAS) ]; then echo "Skipped: $(REAL_ATLAS) is not there (docs/contrast.md)"; else \
	    JOBS=$(JOBS) tools/build.sh release run,tools $(TOOLS) && \
	    $(MAKE) --no-print-directory PACKAGES=skip out/coronary_real.mp4; fi

real-patient: ## take a real patient's open data, bake them, run a wire: out/real.scene (SEX=female, DATA=FOLDER)
real-patient: packages-build+tools
	@tools/scenes/real_patient.py fetch $(SEX) --mirror $(or $(DATA),$(REAL_DATA)) --into $(REAL_FOLDER)
	$(call build,release,run$(comma)tools,cournand bake anatomy)
	$(again) out/real$(REAL_ENDING).png SEX=$(SEX)
	@tools/scenes/real_patient.py credits $(SEX)
	@echo "Written: $(REAL_SCENE) $(REAL_SCENE:.scene=.bodies) out/real$(REAL_ENDING).png"

demo-pci: ## two angioplasties, LAD and left renal artery: film, DICOM, figures and score in out/
demo-pci: packages-build+tools
	$(call build,release,run$(comma)tools,$(TOOLS))
	$(again) $(PCI_OUT)
	@echo "Written: $(PCI_OUT) out/pci_lad_dicom out/pci_renal_dicom"
