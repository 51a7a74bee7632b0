// From the text of a scene to its files: the whole of the tool but for the command line.
#pragma once
#include "tools/bake/centreline.hpp"
#include "tools/bake/container.hpp"
#include "tools/bake/measure.hpp"

namespace crn::bake
{

struct Options {
    std::filesystem::path scene, output,
        surface; // surface: also write the lumen's mesh there (PLY), or empty
    Folders folders;
    std::uint64_t seed = 1;
    std::size_t poses = 10000;
    std::size_t points = 200000;
};

// The lumen's surface, checked and closed. `report` gets a line for each thing that was repaired.
Mesh lumen_surface(const SceneText &text, std::string &report, Progress &progress);

// Bake, write, and return the report (docs/scene.md). Throws Fault, or UsageError when an output would
// overwrite an input; then no file was changed.
std::string bake(const Options &options, Progress &progress);

} // namespace crn::bake
