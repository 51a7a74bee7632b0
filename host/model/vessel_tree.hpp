// Vessels as a tree of centrelines with inscribed radii: where blood flows, and contrast medium with it.
// Read from the TREE section of an `X.bodies` file with the bodies (bodies.hpp); written by bake. Patient
// frame, SI.
#pragma once
#include <Eigen/Core>
#include <cstddef>
#include <limits>
#include <string>
#include <vector>

namespace crn
{

// What a vessel feeds: decides when in the beat blood flows there. The numbers stand in files.
enum class VesselBed { systemic = 0, left_coronary = 1, right_coronary = 2 };

struct VesselBranch {
    std::string name;
    int parent = -1;              // an earlier branch; -1: the root, at whose first point blood enters
    std::size_t parent_point = 0; // of the parent, nearest to this branch's first point
    std::vector<Eigen::Vector3d> points_m; // at least 2, none on the one before it
    std::vector<double> radii_m;           // of the largest sphere in the lumen there; one per point
    VesselBed bed = VesselBed::systemic;
    double flow_ml_s = 0.0; // mean, out of its end, as stated; 0: not stated
};

// A stretch of a branch that disease has narrowed: the branch's own points are those of the narrowed lumen.
struct VesselLesion {
    std::string name;
    std::size_t branch = 0, first_point = 0; // of the branch's points ...
    std::vector<Eigen::Vector3d>
        healthy_points_m;                // ... so many, at least 3: where they lay in the healthy vessel,
    std::vector<double> healthy_radii_m; // and how wide it was there

    std::size_t size() const { return healthy_radii_m.size(); }
    double length_m() const; // along the healthy vessel
};

struct VesselTree {
    std::vector<VesselBranch> branches; // branch 0 is the only root; empty: no vessels are known
    std::vector<VesselLesion> lesions = {};

    // The point of a lesion's branch where least of the healthy radius is left.
    std::size_t throat(const VesselLesion &lesion) const;

    // Blood leaves at the last point of such a branch: none goes on from there.
    bool is_outlet(std::size_t branch) const;
};

// The place of a branch from which a point lies the fewest of the branch's radii away.
struct VesselFoot {
    double radii = std::numeric_limits<double>::infinity(); // distance over the radius there
    std::size_t point = 0;                                  // between this one and the next ...
    double share = 0.0;                                     // ... so far
};
VesselFoot vessel_foot(const VesselBranch &branch, const Eigen::Vector3d &place_m);

// How far along a branch it leaves its parent: where its centreline leaves the parent's lumen, or half of the
// parent's radius behind a division; at most 0.8 of the branch. Blood of its own, and millimetres from its
// ostium, begin there. 0 for the root.
double vessel_start_m(const VesselTree &tree, std::size_t branch);

// What a reader of a file cannot promise: parents before children, places that exist, points and radii in
// range, lesions where there is vessel. False with a sentence that names the branch.
bool check_vessel_tree(const VesselTree &tree, std::string &error);

} // namespace crn
