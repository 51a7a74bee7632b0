// Describes vessels as a tree of centrelines with inscribed radii, along which blood and contrast medium
// flow. The tree is read together with the bodies (bodies.hpp) from the TREE section of an `X.bodies` file,
// which bake writes. Coordinates are in the patient frame, in SI units.
#pragma once
#include <Eigen/Core>
#include <cstddef>
#include <limits>
#include <string>
#include <vector>

namespace crn
{

// Names the kind of tissue that a vessel supplies, which determines when in the heartbeat blood flows there,
// and how long the blood stays in the tissue. Files contain these numbers; `kidney` and `gut` occur only in
// small vessels.
enum class VesselBed { systemic = 0, left_coronary = 1, right_coronary = 2, kidney = 3, gut = 4 };
inline constexpr std::size_t vessel_bed_count = 5;

struct VesselBranch {
    std::string name;
    int parent = -1;              // an earlier branch; -1: the root, where blood enters at the first point
    std::size_t parent_point = 0; // the parent's point nearest to this branch's first point
    std::vector<Eigen::Vector3d> points_m; // at least 2, none equal to the one before it
    std::vector<double> radii_m;           // radius of the largest sphere in the lumen there; one per point
    VesselBed bed = VesselBed::systemic;
    double flow_ml_s = 0.0; // mean flow out of its end, as stated; 0: not stated
    bool is_vein = false;   // of a small vessel: blood flows from its end to its first point
    int joins =
        -1; // of a small artery: the small artery that its end passes its blood to, numbered as parents
};

// Describes a stretch of a branch that disease has narrowed. Inside a lesion, the points of the branch itself
// are those of the narrowed lumen.
struct VesselLesion {
    std::string name;
    std::size_t branch = 0, first_point = 0; // first of the branch's points ...
    std::vector<Eigen::Vector3d>
        healthy_points_m; // ... and as many as here, at least 3: their places in the healthy vessel,
    std::vector<double> healthy_radii_m; // and the radii there

    std::size_t size() const { return healthy_radii_m.size(); }
    double length_m() const; // along the healthy vessel
};

struct VesselTree {
    std::vector<VesselBranch> branches; // branch 0 is the only root; empty: no vessels are known
    std::vector<VesselLesion> lesions = {};
    // Vessels that are picture and flow only, and no part of the lumen. Their parents are numbered through:
    // an index below branches.size() is that of a branch, and larger ones are those of earlier small vessels.
    // A vein may have the parent -1; its blood leaves the simulation at its first point.
    std::vector<VesselBranch> small = {};

    // Returns the branch or the small vessel with this number.
    const VesselBranch &numbered(std::size_t index) const
    {
        return index < branches.size() ? branches[index] : small[index - branches.size()];
    }
    // Returns the piece of the joined vessel at whose beginning the blood of this small artery enters it.
    std::size_t joined_piece(const VesselBranch &small_artery) const;
    // Returns the point of the branch at which the lesion has narrowed the lumen most, relative to the
    // healthy radius.
    std::size_t throat(const VesselLesion &lesion) const;

    // Returns true if no other branch continues from the last point of this branch, so that blood leaves the
    // tree there.
    bool is_outlet(std::size_t branch) const;
};

// Describes the position on a branch that is nearest to a given point. The distance of the point is measured
// in radii of the branch.
struct VesselFoot {
    double radii = std::numeric_limits<double>::infinity(); // distance over the radius there
    std::size_t point = 0;                                  // between this point and the next ...
    double share = 0.0;                                     // ... at this share
};
VesselFoot vessel_foot(const VesselBranch &branch, const Eigen::Vector3d &place_m);

// Returns the distance along a branch's centreline at which the branch leaves its parent. A branch that
// leaves the side of its parent begins where its centreline leaves the parent's lumen. A branch at the end of
// its parent (a division) begins half of the parent's radius along its own centreline. The returned distance
// is at most 0.8 of the branch's length, wherever the branch begins. At the returned distance from the first
// point of the branch's centreline, the blood that belongs to the branch begins. Distances from the branch's
// ostium are measured from the point at the returned distance. For the root branch the result is 0.
double vessel_start_m(const VesselTree &tree, std::size_t branch);

// Checks what reading alone cannot guarantee: parents come before children, indices refer to existing points,
// points and radii are in range, and lesions lie on vessels. If a check fails, the function returns false,
// and `error` is a sentence that names the branch.
bool check_vessel_tree(const VesselTree &tree, std::string &error);

} // namespace crn
