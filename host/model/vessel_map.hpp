// Answers three questions about a point in a tree of vessels: in which vessel it lies, how far along that
// vessel, and how far from another point, measured along the vessels. All positions are in the reference
// pose; the position of a point that moves with heart and breath must first be converted to that pose
// (motion.hpp).
//
//   VesselMap map(bodies.vessels);
//   const std::optional<std::size_t> goal = map.find("left main");
//   const VesselPlace place = map.at(tip_m);
//
// Each branch of the tree is a vessel of this map; the vessel's name is that of the branch's file, with
// spaces for underscores. An aorta from which a brachiocephalic and a left subclavian artery leave counts as
// three vessels, as in anatomy. The three vessels are the ascending aorta (up to the origin of the
// brachiocephalic artery), the aortic arch (up to that of the left subclavian artery) and the descending
// aorta.
#pragma once
#include "host/model/vessel_tree.hpp"
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace crn
{

// Describes a vessel, which is a whole branch of the tree or a stretch of a branch.
struct MappedVessel {
    std::string name;
    std::size_t branch = 0;
    double from_m = 0.0, to_m = 0.0; // along the branch's centreline; the vessel's own blood begins at from_m
    int parent = -1;                 // an earlier vessel; -1: none
    double parent_along_m = 0.0;     // position where it leaves its parent, from the parent's beginning

    double length_m() const { return to_m - from_m; }
};

// Describes a position in a vessel, measured from the beginning of the vessel in the direction of blood flow.
struct VesselPlace {
    std::size_t vessel = 0;
    double along_m = 0.0;
    double radii = 0.0; // distance from the centreline in radii of the lumen: above 1 the place lies outside
};

// Describes where a position lies relative to the route of a tool along the vessels, from a start to a goal.
struct VesselWay {
    std::int64_t ahead_um = 0; // on the route: distance to the goal's ostium
    std::int64_t astray_um =
        0; // distance off the route: in a vessel that does not lead to the goal, or past the branching
    std::int64_t inside_um = 0; // distance inside the goal, from its ostium; then the others are 0
};

class VesselMap
{
  public:
    VesselMap() = default;
    explicit VesselMap(const VesselTree &tree); // a tree that check_vessel_tree has accepted, or an empty one

    bool is_empty() const { return vessels_.empty(); }
    const std::vector<MappedVessel> &vessels() const { return vessels_; }
    std::vector<std::string> names() const;

    // Finds a vessel by its name. The name may be in upper or lower case, with spaces, underscores or
    // hyphens, with or without "artery" at its end, or the usual long name of a coronary artery.
    std::optional<std::size_t> find(std::string_view name) const;
    // Returns ", did you mean ...?" with the vessel name nearest to the given name, or else the list of all
    // vessel names.
    std::string suggestion(std::string_view name) const;

    // Returns the vessel in which a point lies, or else the nearest vessel. The map must have at least one
    // vessel.
    VesselPlace at(const Eigen::Vector3d &reference_m) const;
    // Returns how deep inside a vessel a position lies. The depth in a vessel is measured from the point
    // where the route from `start` enters it: the vessel's beginning, or the origin of the branch from which
    // the route comes.
    double inside_m(const VesselPlace &place, const VesselPlace &start) const;
    VesselWay way(const VesselPlace &place, const VesselPlace &start, std::size_t goal) const;
    // Returns the radius of the lumen at the ostium of the goal vessel.
    double mouth_radius_m(const VesselPlace &start, std::size_t goal) const;
    double distance_m(const VesselPlace &from, const VesselPlace &to) const; // along the vessels

    // Returns the vessel to which a position on a branch belongs; `arc_m` is that position in metres along
    // the branch's centreline.
    std::size_t vessel_of(std::size_t branch, double arc_m) const;

  private:
    std::vector<VesselPlace> from_root(const VesselPlace &place) const;
    VesselPlace mouth(std::size_t goal, const VesselPlace &start) const;
    void add_branch(const VesselTree &tree, std::size_t branch);

    std::vector<VesselBranch> branches_;
    std::vector<std::vector<double>> arcs_m_; // of each branch's points
    std::vector<double> starts_m_;            // where each branch leaves its parent's lumen
    std::vector<MappedVessel> vessels_;
};

} // namespace crn
