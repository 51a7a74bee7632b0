// Reads a person whom `anatomy` has made: bodies with the HU of a CT in the arterial phase, the lumen of the
// arteries, and their centrelines, which are the truth for what is found in the CT.
#pragma once
#include "host/model/vessel_tree.hpp"
#include "tools/bake/mesh.hpp"
#include <filesystem>

namespace crn::ct
{

struct PersonBody {
    bake::Mesh mesh;
    std::int16_t hu = 0;
    bool beats = false;     // moves with the heart
    bool is_plaque = false; // calcium in the wall of an artery
};

struct Person {
    std::vector<PersonBody> bodies; // in the order of painting
    bake::Mesh lumen;
    VesselTree tree;
    std::size_t with_lumen = 0; // so many branches of the tree lie in the lumen, the others are small
    Eigen::Vector3d heart_mm = Eigen::Vector3d::Zero();
};

// Throws Fault.
Person read_person(const std::filesystem::path &folder);

// Returns the name that TotalSegmentator or its users would give to an artery of `anatomy`; a twig without a
// name has none.
std::string structure_name(const std::string &branch);

} // namespace crn::ct
