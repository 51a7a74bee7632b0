// Finds the coronary arteries of a tree by the names of its branches. Their beds open in hyperaemia, and fill
// in diastole; those of all other branches do neither.
#pragma once
#include "tools/centreline/tree.hpp"
#include <string>
#include <vector>

namespace crn::patient
{

// Whether a name is that of a coronary artery: "LAD", "VH_M_diagonal_branch", "left_coronary_artery".
bool is_coronary_name(const std::string &name);

struct CoronaryBranches {
    std::vector<std::string> left, right; // names of branches, in the order of the tree

    bool is_empty() const { return left.empty() && right.empty(); }
    // The lines of a scene's [tree]; empty if there is no coronary artery.
    std::string scene_text() const;
};

// A branch of a coronary artery is one, too, and has the side of the artery that it leaves. If `root_name` is
// that of a coronary artery, the whole tree is coronary. A name such as "marginal_artery", which arteries of
// other organs have, too, counts only in a tree with a name that is surely coronary. A name that does not say
// the side, such as "coronary_arteries", has the side to which the artery goes (+x is the patient's left).
CoronaryBranches coronary_branches(const centreline::Tree &tree, const std::string &root_name);

} // namespace crn::patient
