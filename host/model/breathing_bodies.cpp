#include "host/model/breathing_bodies.hpp"
#include <cmath>

namespace crn
{

int breath_step(std::uint32_t breath_phase32)
{
    const double depth = motion_weights({0, breath_phase32}).breath;
    return static_cast<int>(std::lround(depth * breath_steps));
}

BreathingBodies::BreathingBodies(const Bodies &bodies)
{
    for (std::size_t i = 0; i < bodies.bodies.size(); ++i) {
        const crn::Body &body = bodies.bodies[i];
        if (body.breath_um.empty()) continue;
        breathing_.push_back({static_cast<int>(i), body.vertices_um, body.breath_um, body.vertices_um});
    }
}

// Moves the vertices to the given step; the displacement is rounded half away from zero.
void BreathingBodies::place(int step)
{
    constexpr int half = breath_steps / 2;
    for (Body &body : breathing_)
        for (std::size_t i = 0; i < body.rest_um.size(); ++i)
            for (int k = 0; k < 3; ++k) {
                const int way = body.breath_um[i][k] * step;
                body.vertices_um[i][k] = body.rest_um[i][k] + (way + (way < 0 ? -half : half)) / breath_steps;
            }
    step_ = step;
}

const std::vector<MovingBodies::Moved> &BreathingBodies::at(std::uint32_t breath_phase32)
{
    const int step = breath_step(breath_phase32);
    if (step != step_) place(step);
    moved_.clear();
    for (const Body &body : breathing_) moved_.push_back({body.index, body.vertices_um});
    return moved_;
}

} // namespace crn
