// The wall of a lesion, healthy and narrowed: one map both ways (docs/lesions.md). The baker takes healthy
// walls to narrowed ones, the host takes them back as far as the core's lesion has given way.
//
//   const LesionWall wall(tree, 0);
//   x += wall.way_m(x);                       // from the healthy vessel to the narrowed one
//   if (wall.healthy_of(x, healthy)) ...      // and back
#pragma once
#include "host/model/vessel_tree.hpp"
#include <Eigen/Geometry>

namespace crn
{

// A wall goes with the lesion up to so many radii from the healthy centreline; beyond the second it stays.
constexpr double lesion_near_radii = 1.6, lesion_far_radii = 2.4;

// The tree as it was before disease narrowed it.
VesselTree healthy_tree(const VesselTree &tree);

// Nearest place of the healthy centreline within a lesion, and what it became.
struct LesionFoot {
    double radii = std::numeric_limits<double>::infinity(); // distance over the healthy radius
    Eigen::Vector3d healthy_m = Eigen::Vector3d::Zero(), channel_m = Eigen::Vector3d::Zero();
    double healthy_radius_m = 0, left = 1; // share of the radius that is left
    double arc_m = 0;                      // along the healthy centreline, from the lesion's first point
};

class LesionWall
{
  public:
    LesionWall(const VesselTree &tree, std::size_t lesion); // a checked tree

    // A place where the wall of the healthy vessel is: its way to the narrowed one. 0 far away, and where it
    // is rather another vessel's wall.
    Eigen::Vector3d way_m(const Eigen::Vector3d &healthy_m) const;

    struct Healthy {
        Eigen::Vector3d place_m = Eigen::Vector3d::Zero();
        double arc_m = 0; // of its foot
    };
    // The place whose way ends at `narrowed_m`. False: the map leaves that one where it is.
    bool healthy_of(const Eigen::Vector3d &narrowed_m, Healthy &healthy) const;

    LesionFoot foot(const Eigen::Vector3d &place_m) const;
    // Around everything that goes with the lesion.
    const Eigen::AlignedBox3d &reach_m() const { return reach_m_; }

  private:
    double share_of_way(const LesionFoot &foot, const Eigen::Vector3d &place_m) const;
    Healthy back(const Eigen::Vector3d &narrowed_m, double share) const;

    std::vector<Eigen::Vector3d> healthy_m_, channel_m_;
    std::vector<double> healthy_radii_m_, channel_radii_m_, arcs_m_;
    std::vector<VesselBranch> others_; // stretches of other vessels, healthy, that come near
    Eigen::AlignedBox3d reach_m_;
};

// Box around everything within so many radii of a lesion's healthy centreline.
Eigen::AlignedBox3d lesion_box_m(const VesselLesion &lesion, double radii);

} // namespace crn
