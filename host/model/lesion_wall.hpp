// Computes where a lesion moves the points of the healthy vessel's wall, and the inverse of this map
// (docs/lesions.md). The program `bake` maps points of healthy walls to points of narrowed walls. The host
// maps the points of narrowed walls back, by as much as the lesion has opened in the core.
//
//   const LesionWall wall(tree, 0);
//   x += wall.way_m(x);                       // from the healthy vessel to the narrowed one
//   if (wall.healthy_of(x, healthy)) ...      // and back
#pragma once
#include "host/model/vessel_tree.hpp"
#include <Eigen/Geometry>

namespace crn
{

// A point of the wall moves fully with the lesion if it is at most lesion_near_radii radii from the healthy
// centreline. A point that is more than lesion_far_radii radii from the healthy centreline does not move.
constexpr double lesion_near_radii = 1.6, lesion_far_radii = 2.4;

// Returns the tree of vessels as it was before disease narrowed it.
VesselTree healthy_tree(const VesselTree &tree);

// Holds the point of a lesion's healthy centreline that is nearest to a given point, and the position to
// which the lesion moved it.
struct LesionFoot {
    double radii = std::numeric_limits<double>::infinity(); // distance over the healthy radius
    Eigen::Vector3d healthy_m = Eigen::Vector3d::Zero(), channel_m = Eigen::Vector3d::Zero();
    double healthy_radius_m = 0, left = 1; // share of the radius that remains
    double arc_m = 0;                      // along the healthy centreline, from the lesion's first point
};

class LesionWall
{
  public:
    LesionWall(const VesselTree &tree, std::size_t lesion); // requires a checked tree

    // Returns the displacement from a point of the healthy vessel's wall to the same point of the narrowed
    // wall. The displacement is 0 far from the lesion, and where the wall is nearer to another vessel.
    Eigen::Vector3d way_m(const Eigen::Vector3d &healthy_m) const;

    struct Healthy {
        Eigen::Vector3d place_m = Eigen::Vector3d::Zero();
        double arc_m = 0; // of its foot
    };
    // Finds the position in the healthy vessel that the lesion moves to `narrowed_m`. Returns false if the
    // lesion does not move the point at `narrowed_m`.
    bool healthy_of(const Eigen::Vector3d &narrowed_m, Healthy &healthy) const;

    LesionFoot foot(const Eigen::Vector3d &place_m) const;
    // Returns the box that contains everything that moves with the lesion.
    const Eigen::AlignedBox3d &reach_m() const { return reach_m_; }

  private:
    double share_of_way(const LesionFoot &foot, const Eigen::Vector3d &place_m) const;
    Healthy back(const Eigen::Vector3d &narrowed_m, double share) const;

    std::vector<Eigen::Vector3d> healthy_m_, channel_m_;
    std::vector<double> healthy_radii_m_, channel_radii_m_, arcs_m_;
    std::vector<VesselBranch> others_; // healthy stretches of other vessels nearby
    Eigen::AlignedBox3d reach_m_;
};

// Returns the box that contains all points within this many radii of a lesion's healthy centreline.
Eigen::AlignedBox3d lesion_box_m(const VesselLesion &lesion, double radii);

} // namespace crn
