// Moves a tree of vessels with the heart and the breath. Points inside a lesion that a balloon has opened lie
// between the diseased and the healthy course of the vessel.
#pragma once
#include "host/model/lesion_opening.hpp"
#include "host/model/motion.hpp"
#include "host/model/vessel_tree.hpp"
#include <optional>
#include <span>

namespace crn
{

class MovedVessels
{
  public:
    // If `motion` is nullptr, the vessels do not move.
    MovedVessels(const VesselTree &reference, const Motion *motion, const LesionOpening &opening);

    bool can_move() const { return points_.has_value(); }
    // Returns the vessels at the given moment; `lesions_open` is as in WireFrame. The radii of the moved
    // vessels are those of the reference tree. Call this function only if can_move() is true. The returned
    // tree of vessels is valid until the next call.
    const VesselTree &at(const MotionMoment &moment, const LesionOpening &opening,
                         std::span<const double> lesions_open);
    // Returns the result of the last call, or the reference pose before the first one.
    const VesselTree &last() const { return moved_; }

  private:
    VesselTree reference_, moved_;                        // without motion both are empty
    std::optional<MovingPoints> points_, healthy_points_; // of all branches; of the lesions that yield
};

} // namespace crn
