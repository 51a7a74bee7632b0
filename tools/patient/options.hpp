// The options by which a person decides what the making of a scene would decide by itself.
#pragma once
#include "tools/patient/scene_folder.hpp"

#include <CLI/CLI.hpp>

namespace crn::patient
{

// What the command line states, as CLI11 reads it.
struct SceneOptions {
    SceneWish wish;
    std::vector<double> inlet_mm, entry_mm;
    std::string folder;
};

// Adds --output, and the options for lumen, tree, entry, names and bodies.
void add_scene_options(CLI::App &command, SceneOptions &options);
// Adds the options of mesh files: --part, --unit, --axes and --walls.
void add_mesh_options(CLI::App &command, SceneOptions &options);
// What was stated. Throws UsageError or OutputError for a folder that cannot be written.
SceneWish wish_of(const SceneOptions &options);

// Makes the folder, and prints every choice and what can be done next; after a fault, what was chosen before
// it.
void make_and_tell(const std::function<void(Choices &, bake::Progress &)> &make, const SceneWish &wish);

} // namespace crn::patient
