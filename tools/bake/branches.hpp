// Joins centrelines in any order and direction into the tree along which blood flows.
#pragma once
#include "host/model/vessel_tree.hpp"
#include "tools/bake/centreline.hpp"

namespace crn::bake
{

// Returns the name of a branch, which is its file's name without the extension and has at most 31 bytes, such
// as "right_renal_artery" for ".../right_renal_artery.mrk.json".
std::string branch_name(const std::filesystem::path &file);

// The root of the tree begins at the inlet of the blood. Every branch except the root begins at that one of
// its two ends that lies deeper in an already joined vessel. If a branch leaves its parent within one radius
// of the parent's end, it is joined to the end itself. Throws Fault for a centreline that touches no other,
// for a name that is used twice, and for a name in `text` that no centreline has; the message gives the name.
VesselTree join_branches(const std::vector<Curve> &lines, const TreeText &text);

// Returns the line of the report that describes the tree, "vessels 11 branches, ...".
std::string branches_report(const VesselTree &tree);

} // namespace crn::bake
