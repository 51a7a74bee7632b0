// Finds the equilibrium of a deployed stent at one step. The forces come from springs, from the lining and
// the wall of the vessel, and from balloons inside the stent; libccd computes the contacts of struts. After
// the equilibrium is found, the yielding of springs and the sliding of points become permanent.
#pragma once
#include "host/stent/contact.hpp"
#include "host/stent/stent.hpp"

namespace crn
{

inline constexpr double bed_reach_mm =
    0.1; // a strut this near the wall when the balloon deflates is in its lining
inline constexpr double wall_reach_mm = 3.0;   // distance beyond which a stent ignores a wall
inline constexpr double tissue_limit_mm = 1.0; // a place farther behind the wall counts as outside the vessel

class StentRelaxation
{
  public:
    StentRelaxation(Stent &stent, const StentSurroundings &around);
    void run();

  private:
    // Holds the loads on a point of the stent, except those from springs between points.
    struct Load {
        Eigen::Vector3d carried_mm;        // place to which the wall has carried it
        Eigen::Vector3d anchor_mm;         // place of the spring that holds it
        double hold_N_per_mm = 0.0;        // stiffness of that spring
        Eigen::Vector3d wall_mm, wall_out; // a plane with tissue behind it
        double wall_gap_mm = 0.0;          // distance that the point keeps from the plane
        bool has_wall = false, has_balloon = false;
        bool is_pushed = false;                    // pushed out of the wall, as part of a strut
        Eigen::Vector3d balloon_mm, balloon_along; // nearest point of the balloon's axis, and its direction
        double balloon_radius_mm = 0.0;            // radius that the point must stay outside of
    };
    void load_points();
    void load_balloons();
    double sweep(); // largest displacement of a point, mm
    Eigen::Vector3d newton_step(std::size_t i) const;
    void list_near();
    void push_struts();
    bool push_strut(std::size_t strut);
    StrutContact deepest(std::size_t strut, const StrutCapsule &capsule) const;
    void yield();
    void bed();

    Stent &stent_;
    StentState &state_;
    const StentSurroundings &around_;
    const StentWall *wall_;
    double half_mm_; // of the struts' thickness
    std::vector<Load> loads_;
    struct Plane {
        Eigen::Vector3d out;
        double offset_mm;
    };
    std::vector<Plane> planes_; // of the patch's triangles
    std::vector<Eigen::Vector3d> ring_centre_, ring_axis_;
};

} // namespace crn
