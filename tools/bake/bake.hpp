// Runs the whole pipeline from the text of a scene to its files; main.cpp adds only the command line.
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

// Returns the checked and closed surface of the lumen. Adds a line to `report` for each repair.
Mesh lumen_surface(const SceneText &text, std::string &report, Progress &progress);

// Bakes the scene, writes its files and returns the report (docs/scene.md). Throws Fault if the scene cannot
// be baked. Throws UsageError, before any file is changed, if an output file would overwrite an input file.
std::string bake(const Options &options, Progress &progress);

} // namespace crn::bake
