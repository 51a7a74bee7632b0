// The surface of a level as a closed mesh.
#pragma once
#include "tools/bake/mesh.hpp"
#include "tools/lab/ct/volume/volume.hpp"
#include <filesystem>

namespace crn::ct
{

// Marching tetrahedra: vertices where the level is 0 between two voxels, by linear interpolation; closed and
// without crossings, normals outwards, in the scene's mm. What is inside at the volume's border is closed
// there.
bake::Mesh surface_of(const Volume &level, const std::string &name);

// Pieces of less than `share` of the largest are dropped.
void keep_large_pieces(bake::Mesh &mesh, double share);

// Binary PLY in mm with the property unsure_mm per vertex. Throws OutputError.
void write_surface(const bake::Mesh &mesh, const std::vector<float> &unsure_mm,
                   const std::filesystem::path &file);

} // namespace crn::ct
