# The program `ct` and its tests: docs/ct.md. Read by tools/testing.mk, whose rules and the Makefile's it uses.
CT_LIBS := tools/lab/ct tools/lab/ct/volume tools/lab/reference_rod tools/lab/vcsim3 tools/lab/case tools/bake tools/centreline tools/mesh/files tools/mesh host/xray host/xray/paths host/model host/base firmware/core shared/scene shared/wire
CT_HOST := host/picture/canvas.cpp host/picture/font.cpp host/picture/png.cpp
# The files that know ITK. Its headers accept gcc alone, and bring an Eigen of their own unless told that there is one.
ITK_FILES   := volume/volume_read volume/volume_write snake
ITK_LINK    := $(patsubst %,-l%-5.2,ITKIOGDCM ITKIONIFTI ITKIONRRD ITKIOMeta ITKIOImageBase ITKSmoothing ITKCommon itkvnl_algo itkvnl itksys)
ITK_OBJECTS := $(ITK_FILES:%=$(BUILD)/obj/tools/ct/%.cpp.o)
CT_LINK     := $(BAKE_LINK) -lpng $(ITK_LINK)
$(ITK_OBJECTS): CXXFLAGS += -DITK_USE_SYSTEM_EIGEN -isystem /usr/include/ITK-5.2
$(ITK_OBJECTS): override CXX := $(if $(findstring clang,$(CXX)),g++,$(CXX))
$(BUILD)/obj/tools/lab/ct/scanner%.cpp.o: OPT := -O3
$(BUILD)/obj/tools/lab/ct/scanner%.cpp.o: CXXFLAGS += -fno-math-errno -fno-trapping-math
# The command line's parser runs once.
$(BUILD)/obj/tools/lab/ct/main.cpp.o: override OPT := -O0
$(BUILD)/obj/tools/lab/ct/main.cpp.o: PCH_FOLDER = $(BUILD)/pch/quick
$(eval $(call library,tools/lab/ct))
$(eval $(call program,ct,tools/lab/ct/main.cpp $(CT_HOST),$(CT_LIBS),$(CT_LINK)))
PROGRAMS += $(BUILD)/bin/ct
