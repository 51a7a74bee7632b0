// Where the tips of the tools are in the vessels: what a script that steers and a report look at.
// Heart and breath are taken out first, so that a tip that goes with its artery stays where it is.
#pragma once
#include "host/model/motion.hpp"
#include "host/model/vessel_map.hpp"
#include "host/model/wire_frame.hpp"
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace crn
{

struct TipPlace {
    bool is_known = false;
    std::string vessel;        // its name
    VesselPlace place, sheath; // of the tip, and where the line comes in
    double inside_m = 0.0;     // from where the tools come into the vessel
    Eigen::Vector3d at_m = Eigen::Vector3d::Zero();
};

class TipPlaces
{
  public:
    // `motion`: nothing where the vessels stand still.
    TipPlaces(const VesselTree &vessels, std::optional<Motion> motion)
        : map_(vessels), motion_(std::move(motion))
    {
    }
    const VesselMap &map() const { return map_; }
    // Of every tool, from the innermost. Not known without vessels or without a shape.
    std::vector<TipPlace> at(const WireFrame &wire) const;

  private:
    VesselMap map_;
    std::optional<Motion> motion_;
};

// The vessels of a scene's bodies and how the scene moves them; an empty path, or bodies without a tree: no
// vessel is known. Throws std::runtime_error.
std::unique_ptr<TipPlaces> read_tip_places(const std::string &bodies_path, const std::string &scene_path);

} // namespace crn
