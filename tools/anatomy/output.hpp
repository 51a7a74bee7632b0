/* Writes the files of an anatomy: binary PLY meshes, 3D Slicer centrelines, and the scene text that `bake`
 * reads. Each function throws std::runtime_error, which names the file, when the file cannot be written. */
#pragma once
#include "tools/anatomy/build.hpp"
#include <filesystem>
#include <string>
#include <vector>

namespace anatomy
{

/* Writes little-endian binary PLY with 32-bit float coordinates in millimetres of the patient frame. */
void write_ply(const std::filesystem::path &file, const Mesh &mesh, const std::string &comment);

/* Writes one open curve with a measurement "Radius" per control point. The file declares its coordinates
 * as LPS; L is our +x, P is -z, and S is +y. */
void write_centreline(const std::filesystem::path &file, const Vessel &vessel);

struct NamedCurve {
    std::string name;
    Curve curve;
};

/* Writes several such curves into one file. */
void write_centrelines(const std::filesystem::path &file, const std::vector<NamedCurve> &curves);

void write_scene(const std::filesystem::path &file, const VesselTree &tree, const std::vector<Body> &bodies,
                 const std::string &lesions = "");

/* Returns the name with underscores in place of spaces, which is the name of its files without their
 * ending. */
std::string file_stem(const std::string &name);

} // namespace anatomy
