// Makes the lumen of the arteries from a label map, its tree of centrelines, and the names of the branches.
#pragma once
#include "tools/bake/mesh.hpp"
#include "tools/centreline/tree.hpp"
#include "tools/lab/ct/arteries/body.hpp"
#include "tools/lab/ct/arteries/clicks.hpp"
#include "tools/lab/ct/segment.hpp"

namespace crn::ct
{

// Returns the level set of the labelled arteries, on a grid of cubic voxels around them: their wall in the
// scan, or without contrast medium the smoothed surface of the labels.
Volume artery_level(const Volume &scan, const LabelMap &labels, const Contrast &contrast,
                    const Report &report);

// Returns the largest closed piece of the level set's surface.
bake::Mesh lumen_of(const Volume &level);

// Returns the place of the aortic root: where the aorta leaves the heart. Without a heart in the label map,
// it is the foremost upper end of the aorta.
Eigen::Vector3d root_of(const LabelMap &labels);

// Finds the tree of the lumen, from the root on. Branches have the name of the structure in which most of
// their spheres lie, with a number where a name comes again.
centreline::Tree tree_of(const bake::Mesh &lumen, const LabelMap &labels, const Eigen::Vector3d &root_mm,
                         Findings &findings);

// Gives the branch nearest to each click of the kind `name` its name. Throws Fault if a name is given twice.
void name_branches(centreline::Tree &tree, const std::vector<Click> &clicks);

// Adds the name, length and radius of each branch to the facts.
void describe_branches(const centreline::Tree &tree, Findings &findings);

} // namespace crn::ct
