# The program `importers`, its runs, and the fuzz targets of the tools' readers: docs/testing.md. Read by tools/testing.mk.
IMPORTER_FILES := tools/importers/main.cpp $(wildcard tools/mesh/files/mesh_file.cpp tools/mesh/files/mesh_ply.cpp tools/mesh/files/mesh_text.cpp tools/mesh/files/mesh_gltf.cpp tools/mesh/files/mesh_pieces.cpp tools/lab/ct/volume/volume.cpp tools/lab/ct/volume/volume_*.cpp)
IMPORTERS      := $(BUILD)/bin/importers
$(IMPORTERS): $(call objects,$(IMPORTER_FILES)) $(foreach lib,tools/centreline tools/mesh/files tools/mesh host/model host/base shared/wire,$(call lib_file,$(lib)))
	@mkdir -p $(@D)
	$(Q) $(CXX) $^ -o $@ $(LDFLAGS) -lassimp -lpugixml -lz $(ITK_LINK)
tests-build: $(IMPORTERS)

# What fuzz targets of tools link besides their own file.
FUZZ_BAKE       := tools/mesh/files/mesh_ply.cpp tools/mesh/files/mesh_text.cpp tools/mesh/files/mesh_gltf.cpp tools/mesh/files/mesh_pieces.cpp
FUZZ_CENTRELINE := $(wildcard tools/centreline/*.cpp) host/base/guarded_read.cpp host/base/pending_file.cpp
FUZZ_CT         := tools/lab/ct/volume/volume_declared.cpp tools/lab/ct/volume/volume_check.cpp
FUZZ_TOOLS       = $(if $(filter tools/bake/%,$(1)),$(FUZZ_BAKE))$(if $(filter tools/centreline/%,$(1)),$(FUZZ_CENTRELINE))$(if $(filter tools/lab/ct/%,$(1)),$(FUZZ_CT))

IMPORTED_FILES ?= 3600
importers: packages-build packages-test ## malformed meshes, TOML, scans and centrelines to the real readers under sanitizers: out/importers.tsv (minutes)
	@$(SAN_MAKE) $(BUILD)/san/bin/importers
	@tools/importers/importers.py --program $(BUILD)/san/bin/importers --files $(IMPORTED_FILES) -o out/importers.tsv
.PHONY: importers
