// Converts the zero surface of a level set to a closed mesh.
#pragma once
#include "tools/bake/mesh.hpp"
#include "tools/lab/ct/volume/volume.hpp"
#include <filesystem>

namespace crn::ct
{

// Returns the surface on which the level set is 0 (tools/mesh/level_set). The mesh is closed, its normals
// point outwards, and its coordinates are in the scene's axes and in mm. The mesh is closed even where the
// inside of the surface reaches the volume's border.
bake::Mesh surface_of(const Volume &level, const std::string &name);

// Writes the mesh in mm to a binary PLY file, with the property unsure_mm for each vertex. Throws
// OutputError.
void write_surface(const bake::Mesh &mesh, const std::vector<float> &unsure_mm,
                   const std::filesystem::path &file);

} // namespace crn::ct
