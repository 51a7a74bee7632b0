// Computes the shapes of the bodies at a moment: heart and breath move them, and open lesions widen them.
#pragma once
#include "host/model/breathing_bodies.hpp"
#include "host/model/opened_bodies.hpp"
#include "host/model/scene_anatomy.hpp"
#include "host/model/wire_frame.hpp"
#include "host/xray/paths/moved.hpp"
#include <optional>
#include <span>
#include <vector>

namespace crn
{

class BodyPoses
{
  public:
    explicit BodyPoses(const SceneAnatomy &anatomy);
    // Returns the bodies whose shape at the moment of this frame differs from that in the scene's files. The
    // returned list of bodies is valid until the next call.
    std::span<const MovedBody> at(const WireFrame &wire);

  private:
    std::optional<MovingBodies> moving_;
    BreathingBodies breathing_;
    OpenedBodies opened_;
    std::vector<MovedBody> moved_;
    std::optional<MotionMoment> moved_at_; // moment to which they were last moved
    std::vector<double> moved_open_;
};

} // namespace crn
