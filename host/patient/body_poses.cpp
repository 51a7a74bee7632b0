#include "host/patient/body_poses.hpp"
#include "host/patient/pushed_vessels.hpp"
#include <algorithm>

namespace crn
{

namespace
{

bool belongs_to_vessel(const Body &body, const VesselTree &vessels)
{
    const auto is_of = [&](const VesselLesion &lesion) { return body.name == lesion.name + "_calcium"; };
    return body.material == "blood" || std::any_of(vessels.lesions.begin(), vessels.lesions.end(), is_of);
}

} // namespace

BodyPoses::BodyPoses(const SceneAnatomy &anatomy)
    : breathing_(anatomy.bodies),
      opened_(anatomy.bodies, LesionOpening(anatomy.bodies.vessels, anatomy.stations),
              anatomy.motion_or_null())
{
    if (anatomy.motion) moving_.emplace(*anatomy.motion, anatomy.bodies);
    for (std::size_t i = 0; i < anatomy.bodies.bodies.size(); ++i)
        if (belongs_to_vessel(anatomy.bodies.bodies[i], anatomy.bodies.vessels))
            pushed_.push_back({static_cast<int>(i), anatomy.bodies.bodies[i].vertices_um, {}});
}

// Returns the bodies in the heart phase and the breath of the frame's tick; where lesions have opened in the
// core, the walls are widened. `bake` lets no body breathe that heart or lesions move.
std::span<const MovedBody> BodyPoses::at(const WireFrame &wire)
{
    const MotionMoment moment{wire.heart_phase32, wire.breath_phase32};
    if (moved_at_ == moment && moved_open_ == wire.lesions_open && wire.walls.empty() && !is_pushed_)
        return moved_;
    is_pushed_ = !wire.walls.empty();
    moved_at_ = moment;
    moved_open_ = wire.lesions_open;
    std::span<const MovingBodies::Moved> beating;
    if (moving_ && !moving_->is_empty()) beating = moving_->at(moment);
    moved_.clear();
    for (const MovingBodies::Moved &body : opened_.at(moment, wire.lesions_open, beating))
        moved_.push_back({body.body, body.vertices_um});
    for (const MovingBodies::Moved &body : breathing_.at(moment.breath_phase32))
        moved_.push_back({body.body, body.vertices_um});
    push_bodies(wire);
    return moved_;
}

void BodyPoses::push_bodies(const WireFrame &wire)
{
    const PushedVessels vessels(wire);
    if (vessels.is_empty()) return;
    for (Pushed &body : pushed_) {
        const auto moved = std::find_if(moved_.begin(), moved_.end(),
                                        [&](const MovedBody &other) { return other.body == body.body; });
        const std::span<const Eigen::Vector3i> from_um =
            moved == moved_.end() ? std::span<const Eigen::Vector3i>(body.rest_um) : moved->vertices_um;
        body.vertices_um.assign(from_um.begin(), from_um.end());
        bool has_changed = false;
        for (Eigen::Vector3i &vertex : body.vertices_um) {
            const Eigen::Vector3d way_m = vessels.way_m(vertex.cast<double>() * 1e-6);
            if (way_m.isZero(0)) continue;
            vertex += (way_m * 1e6).array().round().cast<int>().matrix();
            has_changed = true;
        }
        if (!has_changed) continue;
        if (moved == moved_.end())
            moved_.push_back({body.body, body.vertices_um});
        else
            moved->vertices_um = body.vertices_um;
    }
}

} // namespace crn
