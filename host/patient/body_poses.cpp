#include "host/patient/body_poses.hpp"

namespace crn
{

BodyPoses::BodyPoses(const SceneAnatomy &anatomy)
    : breathing_(anatomy.bodies),
      opened_(anatomy.bodies, LesionOpening(anatomy.bodies.vessels, anatomy.stations),
              anatomy.motion_or_null())
{
    if (anatomy.motion) moving_.emplace(*anatomy.motion, anatomy.bodies);
}

// Returns the bodies in the heart phase and the breath of the frame's tick; where lesions have opened in the
// core, the walls are widened. `bake` lets no body breathe that heart or lesions move.
std::span<const MovedBody> BodyPoses::at(const WireFrame &wire)
{
    const MotionMoment moment{wire.heart_phase32, wire.breath_phase32};
    if (moved_at_ == moment && moved_open_ == wire.lesions_open) return moved_;
    moved_at_ = moment;
    moved_open_ = wire.lesions_open;
    std::span<const MovingBodies::Moved> beating;
    if (moving_ && !moving_->is_empty()) beating = moving_->at(moment);
    moved_.clear();
    for (const MovingBodies::Moved &body : opened_.at(moment, wire.lesions_open, beating))
        moved_.push_back({body.body, body.vertices_um});
    for (const MovingBodies::Moved &body : breathing_.at(moment.breath_phase32))
        moved_.push_back({body.body, body.vertices_um});
    return moved_;
}

} // namespace crn
