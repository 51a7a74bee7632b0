// Names and distances in a tree of vessels: which vessel a place lies in, how far along it, and how far it is
// from there to another one by way of the vessels. Places are those of the reference pose; what moves with
// heart and breath is pulled there first (motion.hpp).
//
//   VesselMap map(bodies.vessels);
//   const std::optional<std::size_t> goal = map.find("left main");
//   const VesselPlace place = map.at(tip_m);
//
// A vessel of the map is a branch of the tree, called as its file with spaces for underscores. An aorta whose
// tree has the brachiocephalic and the left subclavian artery is three vessels, as anatomists divide it:
// ascending aorta (to the origin of the brachiocephalic), aortic arch (to that of the left subclavian),
// descending aorta.
#pragma once
#include "host/model/vessel_tree.hpp"
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace crn
{

// A vessel: its own stretch of a branch of the tree.
struct MappedVessel {
    std::string name;
    std::size_t branch = 0;
    double from_m = 0.0, to_m = 0.0; // along the branch's centreline; blood of its own begins at from_m
    int parent = -1;                 // an earlier vessel; -1: none
    double parent_along_m = 0.0;     // where it leaves its parent, from the parent's beginning

    double length_m() const { return to_m - from_m; }
};

// A place in a vessel, from the vessel's beginning as blood flows.
struct VesselPlace {
    std::size_t vessel = 0;
    double along_m = 0.0;
    double radii = 0.0; // from the centreline, in radii of the lumen: above 1 it lies outside
};

// A place seen by a tool that goes from a start to a goal, along the vessels.
struct VesselWay {
    std::int64_t ahead_um = 0;  // on the route, to the goal's mouth
    std::int64_t astray_um = 0; // off the route: in a vessel that does not lead there, or past the turning
    std::int64_t inside_um = 0; // in the goal, from its mouth; then the others are 0
};

class VesselMap
{
  public:
    VesselMap() = default;
    explicit VesselMap(const VesselTree &tree); // one that check_vessel_tree has passed, or an empty one

    bool is_empty() const { return vessels_.empty(); }
    const std::vector<MappedVessel> &vessels() const { return vessels_; }
    std::vector<std::string> names() const;

    // Case, spaces, underscores and hyphens do not count, nor does "artery" at the end; the coronary
    // arteries' usual long names are known.
    std::optional<std::size_t> find(std::string_view name) const;
    // ", did you mean ...?" or the list of all names.
    std::string suggestion(std::string_view name) const;

    // The vessel that a place lies in, or the nearest one. Not for an empty map.
    VesselPlace at(const Eigen::Vector3d &reference_m) const;
    // How far inside its vessel a place lies, from where the route from `start` comes in: the vessel's
    // beginning, or the branch that it comes from.
    double inside_m(const VesselPlace &place, const VesselPlace &start) const;
    VesselWay way(const VesselPlace &place, const VesselPlace &start, std::size_t goal) const;
    // Radius of the lumen at the goal's mouth.
    double mouth_radius_m(const VesselPlace &start, std::size_t goal) const;
    double distance_m(const VesselPlace &from, const VesselPlace &to) const; // along the vessels

    // The vessel of a place of a branch, metres along its centreline.
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
