// The hand that inserts: the case's protocol, whichever rod it holds.
#pragma once
#include "tools/lab/calibrate/evaluator.hpp"

namespace crn::calibrate
{

// A rod with one end in the hand, advanced by ticks of 1 ms.
class HeldRod
{
  public:
    virtual ~HeldRod() = default;
    // Where the hand is after the next tick: the length it has pushed in, counted from the mouth, and its
    // angle, right-handed about the feed.
    virtual void tick(double hand_mm, double turn_deg) = 0;

    virtual double inserted_mm() const = 0;
    virtual double handle_axial_mN() const = 0;         // + pushes the hand back out
    virtual bool is_sound() const = 0;                  // no number out of range, nothing outside the vessel
    virtual std::vector<Vector3d> nodes_mm() const = 0; // those beyond the mouth, tip first
};

// How the hand moves, when the rod is at rest, and how fine it is. Defaults for our rod; docs/calibrate.md,
// "Short cuts", has what they cost.
struct InsertionSettings {
    double start_mm = 5.0;        // inserted when the hand begins; the core may need a little more
    double speed_mm_per_s = 40.0; // of the hand; the case's where that is faster
    // What friction remembers is the last way: so fast there, before every depth, or as the case where that
    // is faster.
    double approach_mm = 10.0, approach_mm_per_s = 10.0;
    // At rest: over three times `rest_window_ticks` no node's mean place moves more than so much per tick. A
    // mean, as a soft tip on a wall may tremble for ever where it is.
    double still_um_per_tick = 0.2;
    int rest_window_ticks = 50;
    int settle_max_ticks = 1000;
    double element_factor = 0.5; // elements so many times longer than those that the rod has by itself

    std::string text() const; // for Evaluator::settings_text
};

// From where the rod is to the first `depth_count` depths, with a rest at each. Throws TrialRefused when the
// rod is not sound.
Insertion insert_by_hand(HeldRod &rod, const insertion::Case &c, const InsertionSettings &settings,
                         std::size_t depth_count);

} // namespace crn::calibrate
