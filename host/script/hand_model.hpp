// Changes a session script as a person's hands would: slower or faster, with pauses, overshoots, searching
// motions, late pedals and forgotten checks. The same script, skill and seed always give the same session.
//
//   const Session session = with_hands(read_session(path), read_hands("novice:7"));
//
// The model is an assumption with parameters that we chose (docs/assessment.md, "The hand model"). The model
// of the hand serves to test whether an assessment separates experts from novices as published studies do.
// The model also makes clumsy sessions for tests of cases. Statements that steer a tool by its tip stay
// unchanged.
#pragma once
#include "host/script/session.hpp"
#include <cstdint>
#include <string>

namespace crn
{

struct HandSkill {
    std::string name;
    double speed = 1.0,
           speed_spread = 0.1;    // of every push and turn, as a factor; standard deviation of its log
    double pause_s = 0.2;         // mean pause before a motion; exponentially distributed
    double stroke_mm = 60.0;      // the hand regrips after so much
    double overpush_mm = 1.0;     // standard deviation of what a push goes too far, and is pulled back
    double search = 0.05;         // share of the pushes in which the hand pulls back and tries again
    double search_mm = 20.0;      // by at most so much
    double turn_spread_deg = 3.0; // standard deviation of every turn
    double late_pedal = 0.0;      // chance that the foot follows the hand when fluoroscopy begins
    double lifted_pedal = 0.0;    // chance that the foot leaves the pedal during a motion
    double held_pedal_s = 0.2;    // the foot leaves the pedal so much later
    double late_table = 0.0;      // chance that the table is moved only after the next motion
    double empty_run = 0.0;       // chance of a run before the syringe is ready
    double long_run_s = 0.5;      // mean time by which a run is too long
    double over_pressure = 0.0;   // chance that the inflator goes 15 % too high
};

struct Hands {
    HandSkill skill;
    std::uint64_t seed = 0;
};

const HandSkill &expert_hands();
const HandSkill &novice_hands();
const HandSkill &clumsy_hands(); // a novice who misses every second check

// Reads a skill and a seed, such as "expert:7", "novice:7" or "clumsy:7". Throws std::runtime_error with a
// suggestion.
Hands read_hands(const std::string &word);

// Returns the changed session. Expectations of the script are left out, because a session with changed
// motions ends differently.
Session with_hands(const Session &session, const Hands &hands);

} // namespace crn
