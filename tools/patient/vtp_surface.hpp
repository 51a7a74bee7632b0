// Surfaces of VTK's XML files (.vtp), in which SimVascular, VMTK and ParaView save vessels.
#pragma once
#include "tools/mesh/files/mesh_file.hpp"

namespace crn::patient
{

bool is_vtp(const std::filesystem::path &file);

// Reads the polygons of all pieces of a file; a polygon of more than three corners becomes a fan of
// triangles. The file is parsed in a child process. Throws Fault with the array and the remedy.
bake::MeshPiece read_vtp_surface(const std::filesystem::path &file);

} // namespace crn::patient
