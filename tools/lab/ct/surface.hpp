// The surface of a level as a closed mesh.
#pragma once
#include "tools/bake/mesh.hpp"
#include "tools/lab/ct/volume/volume.hpp"
#include <filesystem>

namespace crn::ct
{

// Marching tetrahedra: vertices lie where the level is 0 between two voxels, by linear interpolation. The
// mesh is closed and free of crossings, with outward normals, in the scene's mm. It is closed at the volume's
// border where the inside reaches it.
bake::Mesh surface_of(const Volume &level, const std::string &name);

// Drops pieces smaller than `share` of the largest.
void keep_large_pieces(bake::Mesh &mesh, double share);

// Writes binary PLY in mm with the property unsure_mm per vertex. Throws OutputError.
void write_surface(const bake::Mesh &mesh, const std::vector<float> &unsure_mm,
                   const std::filesystem::path &file);

} // namespace crn::ct
