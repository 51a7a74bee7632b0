// Simulates the hand of a user who inserts any kind of rod by the protocol of a case.
#pragma once
#include "tools/lab/calibrate/evaluator.hpp"

namespace crn::calibrate
{

// Represents a rod that the simulated hand holds at one end; the simulation advances in ticks of 1 ms.
class HeldRod
{
  public:
    virtual ~HeldRod() = default;
    // Sets the hand's inserted length and angle after the next tick. The length is counted from the
    // introducer, and the angle is right-handed about the direction of insertion.
    virtual void tick(double hand_mm, double turn_deg) = 0;

    virtual double inserted_mm() const = 0;
    virtual double handle_axial_mN() const = 0; // + pushes the hand back out
    virtual bool is_sound() const = 0;          // no number is out of range, nothing is outside the vessel
    virtual std::vector<Vector3d> nodes_mm() const = 0; // the nodes inside the vessel, tip first
};

// Holds settings that define the hand's motion, the criterion by which the rod counts as resting, and the
// length of the rod's elements. The default values are for our rod; docs/calibrate.md, "Short cuts", states
// how these settings change the result.
struct InsertionSettings {
    double start_mm = 5.0;        // inserted length when the hand begins; the core may need slightly more
    double speed_mm_per_s = 40.0; // of the hand; the case's speed where that is faster
    // Only the last millimetres of the hand's motion affect the friction forces on the resting rod. The hand
    // therefore approaches every depth at the speed `approach_mm_per_s`, or at the case's speed if that is
    // faster.
    double approach_mm = 10.0, approach_mm_per_s = 10.0;
    // The rod is at rest when no node's mean position moves by more than `still_um_per_tick` per tick during
    // three times `rest_window_ticks`. We use a mean position, because a soft tip may oscillate on the wall
    // without end.
    double still_um_per_tick = 0.2;
    int rest_window_ticks = 50;
    int settle_max_ticks = 1000;
    double element_factor = 0.5; // length of the elements relative to the rod's own

    std::string text() const; // for Evaluator::settings_text
};

// Advances the rod from its present position to the first `depth_count` depths, and waits at each depth until
// the rod rests. Throws TrialRefused when the rod's state becomes invalid.
Insertion insert_by_hand(HeldRod &rod, const insertion::Case &c, const InsertionSettings &settings,
                         std::size_t depth_count);

} // namespace crn::calibrate
