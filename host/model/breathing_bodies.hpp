// Moves the bodies that state their displacement by a full breath (docs/heart.md, "Breath in the picture").
// The vessels and the core stand still.
//
//   BreathingBodies breathing(bodies);
//   for (const auto &body : breathing.at(wire.breath_phase32)) ...
#pragma once
#include "host/model/motion.hpp"

namespace crn
{

// The depth of breath in pictures is rounded to 1/32. A body that moves by 13 mm thus moves in steps of 0.4
// mm, half of what it moves between two pictures at 15 per second, and a picture is redrawn only when a step
// is done. The rounded depth depends on the phase alone, so the picture depends on the state and not on
// earlier pictures.
inline constexpr int breath_steps = 32;

// Returns the depth of breath in steps, 0 to breath_steps.
int breath_step(std::uint32_t breath_phase32);

class BreathingBodies
{
  public:
    explicit BreathingBodies(const Bodies &bodies);
    bool is_empty() const { return breathing_.empty(); }
    // Returns all bodies that breathe, also at the end of expiration, where they are as in the scene's files.
    // The list is valid until the next call.
    const std::vector<MovingBodies::Moved> &at(std::uint32_t breath_phase32);

  private:
    struct Body {
        int index; // in Bodies
        std::vector<Eigen::Vector3i> rest_um, breath_um, vertices_um;
    };
    void place(int step);

    std::vector<Body> breathing_;
    std::vector<MovingBodies::Moved> moved_;
    int step_ = 0; // of vertices_um
};

} // namespace crn
