// Computes the map from the healthy wall of a lesion to the narrowed wall, and its inverse (docs/lesions.md).
// The baker maps healthy walls to narrowed ones. The host maps the narrowed walls back, as far as the lesion
// has yielded in the core.
//
//   const LesionWall wall(tree, 0);
//   x += wall.way_m(x);                       // from the healthy vessel to the narrowed one
//   if (wall.healthy_of(x, healthy)) ...      // and back
#pragma once
#include "host/model/vessel_tree.hpp"
#include <Eigen/Geometry>

namespace crn
{

// A wall moves fully with the lesion up to lesion_near_radii radii from the healthy centreline, and beyond
// lesion_far_radii it does not move.
constexpr double lesion_near_radii = 1.6, lesion_far_radii = 2.4;

// Returns the tree as it was before disease narrowed it.
VesselTree healthy_tree(const VesselTree &tree);

// Holds the place on the healthy centreline inside a lesion that is nearest to a point, and the place to
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

    // Returns the displacement from a place on the healthy vessel's wall to its place on the narrowed one.
    // The displacement is 0 far from the lesion, and where the wall is nearer to another vessel.
    Eigen::Vector3d way_m(const Eigen::Vector3d &healthy_m) const;

    struct Healthy {
        Eigen::Vector3d place_m = Eigen::Vector3d::Zero();
        double arc_m = 0; // of its foot
    };
    // Finds the healthy place that the map moves to `narrowed_m`. Returns false if the map does not move that
    // place.
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

// Returns the box around everything within this many radii of a lesion's healthy centreline.
Eigen::AlignedBox3d lesion_box_m(const VesselLesion &lesion, double radii);

} // namespace crn
