/* The rules that a drawn tree must keep. A distance that is already shorter in the shipped tree may stay as
 * short. */
#pragma once
#include "tools/anatomy/vessels.hpp"
#include <string>
#include <vector>

namespace anatomy
{

constexpr double TO_BONE_MM =
    1.0; // the least distance that a lumen keeps from bones, unless the shipped one is closer

/* Returns the distance from a point to the nearest bone of the shipped skeleton, negative inside. */
double bone_distance_mm(const Vec3 &point);

/* Measures of one tree, in the order of its vessels. */
struct TreeSpaces {
    std::vector<double> to_bone_mm;            // from each vessel's lumen to the nearest bone
    std::vector<double> bend_radii;            // least radius of curvature, in radii of the lumen
    std::vector<std::vector<double>> apart_mm; // between two lumens away from their origins; [i][j], j < i
};

TreeSpaces spaces_of(const std::vector<Vessel> &vessels);

/* Returns the first rule that the tree breaks, "" if it keeps all. `usual` holds the measures of the shipped
 * tree, whose vessels have the same order. */
std::string broken_rule(const std::vector<Vessel> &vessels, const TreeSpaces &usual);

} // namespace anatomy
