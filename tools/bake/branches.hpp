// Centrelines as people have them, in any order and direction -> the tree along which blood flows.
#pragma once
#include "host/model/vessel_tree.hpp"
#include "tools/bake/centreline.hpp"

namespace crn::bake
{

// "right_renal_artery" of ".../right_renal_artery.mrk.json", at most 31 bytes: what a branch is called.
std::string branch_name(const std::filesystem::path &file);

// The root begins at its inlet; of the others the end that lies deepest in a vessel already joined is where
// they leave it. One that leaves within a radius of its parent's end leaves at the end. Throws Fault naming a
// centreline that meets no other, a name that is used twice, or one of `text` that is not there.
VesselTree join_branches(const std::vector<Centreline> &lines, const TreeText &text);

// "vessels           11 branches, ..." for the report.
std::string branches_report(const VesselTree &tree);

} // namespace crn::bake
