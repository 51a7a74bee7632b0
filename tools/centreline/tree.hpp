// A vessel tree is a set of branches, each of which is an ordered list of inscribed spheres. The centreline
// tool makes such trees, files store them, and `bake` and the flow of contrast medium read them. Lengths are
// in millimetres, in the axes of the mesh from which the tree was made.
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

// A branch's number is its id: readers and writers keep it, and it is the same in all frames of a beating
// tree.
struct Tree {
    std::vector<Branch> branches;
};

// Throws Fault that names file, branch and sphere when the tree breaks a rule stated above.
void check_tree(const Tree &tree, const std::string &name);

std::size_t sphere_count(const Tree &tree);
double length_mm(const Branch &branch);

// Returns the distance, negative inside, to a capsule whose radius changes linearly from a to b (the hull of
// the two spheres).
double tapered_capsule_distance(const Eigen::Vector3d &p, const Eigen::Vector3d &a, double radius_a,
                                const Eigen::Vector3d &b, double radius_b);

// Returns the distance to the tube of a branch's spheres [first, last], and the sphere that is nearest in
// that sense.
struct HullPlace {
    double distance_mm;
    std::size_t sphere;
};
HullPlace hull_place(const Branch &branch, const Eigen::Vector3d &p_mm);

// Returns the nearest point of the line through the centres: its place as sphere number and fraction, and its
// distance.
struct LinePlace {
    double distance_mm, at, radius_mm;
};
LinePlace line_place(const Branch &branch, const Eigen::Vector3d &p_mm);

// Returns the first sphere of the branch whose centre lies outside its parent's tube; 0 for a root. The
// branch's spheres before that one only connect the parent's middle with the wall.
std::size_t first_own_sphere(const Tree &tree, std::size_t branch);

// Splits branches where others leave, as VMTK does: afterwards every parent_sphere is the parent's last
// sphere.
Tree split_at_junctions(const Tree &tree);

} // namespace crn::centreline
