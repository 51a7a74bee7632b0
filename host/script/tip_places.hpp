// Computes where the tips of the tools are in the vessels, for scripts that steer and for the report. The
// motion of heart and breath is first subtracted, so that a tip that moves with its artery keeps its
// position.
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
    Eigen::Vector3d reference_m = Eigen::Vector3d::Zero(); // the same without the motion of heart and breath
};

class TipPlaces
{
  public:
    // `motion` has no value if the vessels do not move.
    TipPlaces(const VesselTree &vessels, std::optional<Motion> motion)
        : map_(vessels), motion_(std::move(motion))
    {
    }
    const VesselMap &map() const { return map_; }
    // Returns the position of every tool's tip in the vessels, from the innermost tool outwards. A position
    // is unknown if the scene has no vessels or the shape of the tools is not known.
    std::vector<TipPlace> at(const WireFrame &wire) const;

  private:
    VesselMap map_;
    std::optional<Motion> motion_;
};

// Reads the vessels from the scene's bodies, and the motion of the vessels from the scene. If the path of the
// scene is empty, or the bodies have no vessel tree, no vessel is known. Throws std::runtime_error.
std::unique_ptr<TipPlaces> read_tip_places(const std::string &bodies_path, const std::string &scene_path);

} // namespace crn
