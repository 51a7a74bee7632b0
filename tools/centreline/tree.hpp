// A vessel tree is a set of branches, each of which is an ordered list of inscribed spheres. The program
// `centreline` makes vessel trees and stores them in files. The program `bake` and the simulation of contrast
// medium read the files of vessel trees. Coordinates are in millimetres, along the axes of the mesh from
// which the tree was made.
#pragma once
#include "tools/mesh/fault.hpp"

#include <Eigen/Core>
#include <string>
#include <vector>

namespace crn::centreline
{

constexpr std::size_t branches_max = 4096;
constexpr std::size_t spheres_max = 1'000'000; // limit of a whole tree
constexpr double radius_max_mm = 1000.0;
constexpr double coordinate_max_mm = 1e6;

struct Sphere {
    Eigen::Vector3d centre_mm = Eigen::Vector3d::Zero();
    double radius_mm = 0;
    double speed_mm_s = 0;  // mean blood speed over the section; 0: not computed
    bool is_manual = false; // a person has placed it
};

//   root o--o--o--o--o--o        branch 0, parent -1
//                 \              branch 1, parent 0, parent_sphere 3: its own sphere 0 is that sphere again
//                  o--o--o
struct Branch {
    std::string name;
    int parent = -1;               // number of the branch that it leaves, always a lower one; -1: a root
    std::size_t parent_sphere = 0; // the parent's sphere that is this branch's first one
    std::vector<Sphere> spheres;   // in the direction of the blood, at least two
};

// A branch is identified by its number. The functions that read and write files keep the numbers of branches,
// and a branch has the same number in all frames of a beating tree.
struct Tree {
    std::vector<Branch> branches;
};

// Throws a Fault that names file, branch and sphere when the tree breaks one of the rules above.
void check_tree(const Tree &tree, const std::string &name);

std::size_t sphere_count(const Tree &tree);
double length_mm(const Branch &branch);

// Returns the distance of p to a capsule whose radius changes linearly from a to b (the hull of two spheres);
// the distance is negative inside.
double tapered_capsule_distance(const Eigen::Vector3d &p, const Eigen::Vector3d &a, double radius_a,
                                const Eigen::Vector3d &b, double radius_b);

// Holds a point's distance to the tube around a branch's spheres, and the sphere at which this distance is
// smallest.
struct HullPlace {
    double distance_mm;
    std::size_t sphere;
};
HullPlace hull_place(const Branch &branch, const Eigen::Vector3d &p_mm);

// Describes the nearest point on the line through the spheres' centres: its distance, its position as sphere
// number plus fraction, and the radius at this position.
struct LinePlace {
    double distance_mm, at, radius_mm;
};
LinePlace line_place(const Branch &branch, const Eigen::Vector3d &p_mm);

// Returns the number of the branch's first sphere whose centre lies outside the parent's tube, or 0 for a
// root. The spheres before the first sphere outside the parent's tube only connect the middle of the parent
// with the parent's wall.
std::size_t first_own_sphere(const Tree &tree, std::size_t branch);

// Splits each branch where another branch leaves it, as VMTK does. In the result every parent_sphere is the
// parent's last sphere.
Tree split_at_junctions(const Tree &tree);

} // namespace crn::centreline
