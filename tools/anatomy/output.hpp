/* Writes the files of an anatomy: binary PLY meshes, 3D Slicer centrelines, and the scene text that `bake`
 * reads. Each function throws std::runtime_error naming the file when it cannot be written. */
#pragma once
#include "tools/anatomy/build.hpp"
#include <filesystem>
#include <string>
#include <vector>

namespace anatomy
{

/* Writes little-endian binary PLY with 32-bit float coordinates in millimetres of the patient frame. */
void write_ply(const std::filesystem::path &file, const Mesh &mesh, const std::string &comment);

/* Writes one open curve with a "Radius" measurement per control point, in LPS as the file declares (L =
 * +x, P = -z, S = +y). */
void write_centreline(const std::filesystem::path &file, const Vessel &vessel);

struct NamedCurve {
    std::string name;
    Curve curve;
};

/* Does the same for several curves in one file. */
void write_centrelines(const std::filesystem::path &file, const std::vector<NamedCurve> &curves);

void write_scene(const std::filesystem::path &file, const VesselTree &tree, const std::vector<Body> &bodies,
                 const std::string &lesions = "");

/* Returns the file name of a vessel or body: lower case, words joined by underscores. */
std::string file_stem(const std::string &name);

} // namespace anatomy
