/* Contains the rules that a drawn tree of arteries must keep. A distance that is too short in the shipped
   tree may be as short in the drawn tree. */
#pragma once
#include "tools/anatomy/skeleton.hpp"
#include "tools/anatomy/vessels.hpp"
#include <string>
#include <vector>

namespace anatomy
{

constexpr double TO_BONE_MM =
    1.0; // the least distance that a lumen keeps from bones, unless the shipped one is closer

/* Returns all bones of the trunk of a person, with the arms in both places; without changes those of the
 * shipped man. */
Solid trunk_bones(const SkeletonShape &shape = {});

/* Holds the measured distances and bends of one tree, in the order of its vessels. */
struct TreeSpaces {
    std::vector<double> to_bone_mm;            // from each vessel's lumen to the nearest bone
    std::vector<double> bend_radii;            // least radius of curvature, in radii of the lumen
    std::vector<std::vector<double>> apart_mm; // between two lumens away from their origins; [i][j], j < i
};

TreeSpaces spaces_of(const std::vector<Vessel> &vessels, const Solid &bones);

/* Returns a text about the first rule that the tree breaks, or "" if it keeps all rules. `usual` holds the
   measured values of the shipped tree among these bones, whose vessels have the same order. */
std::string broken_rule(const std::vector<Vessel> &vessels, const TreeSpaces &usual, const Solid &bones);

/* Returns a text about the first rule that the coronary arteries of a tree break, or "" if they keep all
 * rules. Their lumens are at least APART_MM apart, except near their origins, and do not bend more sharply
 * than other vessels. */
std::string broken_coronary_rule(const std::vector<Vessel> &vessels);

} // namespace anatomy
