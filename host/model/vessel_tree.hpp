// Vessels as a tree of centrelines with inscribed radii: where blood flows, and contrast medium with it.
// Read from the TREE section of an `X.bodies` file with the bodies (bodies.hpp); written by bake. Patient frame, SI.
// May include: nothing. Called by: bodies, effects, app, tools/bake.
#pragma once
#include <Eigen/Core>
#include <string>
#include <vector>

namespace seld
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

struct VesselTree {
    std::vector<VesselBranch> branches; // branch 0 is the only root; empty: no vessels are known

    // Blood leaves at the last point of such a branch: none goes on from there.
    bool is_outlet(std::size_t branch) const;
};

// What a reader of a file cannot promise: parents before children, places that exist, points and radii in range.
// False with a sentence that names the branch.
bool check_vessel_tree(const VesselTree &tree, std::string &error);

} // namespace seld
