/* Writes the files of an anatomy: binary PLY meshes, 3D Slicer centrelines, and the scene text that `bake`
 * reads. Each function below throws std::runtime_error with the file's name if a file cannot be written. */
#pragma once
#include "tools/anatomy/build.hpp"
#include <filesystem>
#include <string>
#include <vector>

namespace anatomy
{

/* Writes a mesh as a little-endian binary PLY file with 32-bit float coordinates, in millimetres in the
 * patient frame. */
void write_ply(const std::filesystem::path &file, const Mesh &mesh, const std::string &comment);

/* Writes one open curve as a 3D Slicer file, with a measurement "Radius" at each control point. The file
 * declares its coordinates as LPS (left, posterior, superior); L is our +x, P is our -z, and S is our +y. */
void write_centreline(const std::filesystem::path &file, const Vessel &vessel);

struct NamedCurve {
    std::string name;
    Curve curve;
};

/* Writes several open curves with their radii into one 3D Slicer file. */
void write_centrelines(const std::filesystem::path &file, const std::vector<NamedCurve> &curves);

/* Writes the scene's text. `small_vessels` is the name of the file of small vessels, or empty. */
void write_scene(const std::filesystem::path &file, const VesselTree &tree, const std::vector<Body> &bodies,
                 const std::string &lesions = "", const std::string &small_vessels = "");

/* Returns the vessel's name with underscores in place of spaces; the vessel's files have this name, followed
 * by an extension. */
std::string file_stem(const std::string &name);

} // namespace anatomy
