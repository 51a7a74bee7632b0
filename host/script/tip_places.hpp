// The places of the tools' tips in the vessels, for steering scripts and the report. Heart and breath are
// removed first, so that a tip that moves with its artery keeps its place.
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
    VesselPlace place, sheath; // of the tip, and where the line enters
    double inside_m = 0.0;     // distance from where the tools enter the vessel
    Eigen::Vector3d at_m = Eigen::Vector3d::Zero();
};

class TipPlaces
{
  public:
    // `motion` is empty where the vessels do not move.
    TipPlaces(const VesselTree &vessels, std::optional<Motion> motion)
        : map_(vessels), motion_(std::move(motion))
    {
    }
    const VesselMap &map() const { return map_; }
    // Returns the place of every tool's tip, from the innermost. It is unknown without vessels or without a
    // shape.
    std::vector<TipPlace> at(const WireFrame &wire) const;

  private:
    VesselMap map_;
    std::optional<Motion> motion_;
};

// Reads the vessels of a scene's bodies and their motion in the scene; with an empty path, or bodies without
// a tree, no vessel is known. Throws std::runtime_error.
std::unique_ptr<TipPlaces> read_tip_places(const std::string &bodies_path, const std::string &scene_path);

} // namespace crn
