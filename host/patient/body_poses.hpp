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
    void push_bodies(const WireFrame &wire);

    // Bodies that tools push along with the vessels: the blood, and the calcium of lesions. The scene's own
    // vertices belong to those that nothing else moves.
    struct Pushed {
        int body = 0;
        std::vector<Eigen::Vector3i> rest_um, vertices_um;
    };
    std::vector<Pushed> pushed_;
    bool is_pushed_ = false; // in the list that was returned last
    std::vector<MovedBody> moved_;
    std::optional<MotionMoment> moved_at_; // moment to which they were last moved
    std::vector<double> moved_open_;
};

} // namespace crn
