// Runs the whole program `bake`, from the text of a scene to the written files, except for the command line,
// which main.cpp reads.
#pragma once
#include "tools/bake/centreline.hpp"
#include "tools/bake/container.hpp"
#include "tools/bake/measure.hpp"

namespace crn::bake
{

struct Options {
    std::filesystem::path scene, output,
        surface; // the lumen's mesh is written there too (PLY), or empty
    Folders folders;
    std::uint64_t seed = 1;
    std::size_t poses = 10000;
    std::size_t points = 200000;
};

// Reads the mesh of the lumen, checks and closes it, and returns it. For each repair of the mesh, the
// function adds a line to `report`.
Mesh lumen_surface(const SceneText &text, std::string &report, Progress &progress);

// Reads the mesh of a lumen with the key solid_mm, and makes one closed surface of its parts, which may
// overlap. Adds what was capped, and the volumes, to `report`.
Mesh solid_lumen(const LumenText &text, std::string &report);

// Bakes the scene, writes its files and returns the report (docs/scene.md). Throws Fault if the scene cannot
// be baked. Throws UsageError, before any file is changed, if an output file would overwrite an input file.
std::string bake(const Options &options, Progress &progress);

} // namespace crn::bake
