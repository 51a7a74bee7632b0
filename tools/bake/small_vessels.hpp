// Reads the vessels that are picture and flow only, and joins them to the tree of vessels.
#pragma once
#include "host/model/vessel_tree.hpp"
#include <filesystem>
#include <string>
#include <string_view>

namespace crn::bake
{

// Adds the vessels of a table (docs/scene.md, `small`) to the tree, from a text or a file. Throws Fault,
// whose message names the file, the line and the field.
void add_small_vessels(std::string_view text, const std::string &file, VesselTree &tree);
void read_small_vessels(const std::filesystem::path &file, VesselTree &tree);

} // namespace crn::bake
