// Computes the places of the tools' tips in the vessels, for scripts that steer and for the report. The
// motion of heart and breath is removed first, so that a tip that moves with its artery keeps its place.
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
    // `motion` is empty if the vessels do not move.
    TipPlaces(const VesselTree &vessels, std::optional<Motion> motion)
        : map_(vessels), motion_(std::move(motion))
    {
    }
    const VesselMap &map() const { return map_; }
    // Returns the place of the tip of every tool, from the innermost. A place is unknown if there are no
    // vessels or the line's shape is not known.
    std::vector<TipPlace> at(const WireFrame &wire) const;

  private:
    VesselMap map_;
    std::optional<Motion> motion_;
};

// Reads the vessels from a scene's bodies, and their motion from the scene. If the path is empty, or the
// bodies have no tree, no vessel is known. Throws std::runtime_error.
std::unique_ptr<TipPlaces> read_tip_places(const std::string &bodies_path, const std::string &scene_path);

} // namespace crn
