// Runs one session with one fault, at any test level (L0 to L3), and judges whether the device stayed safe.
// After the fault, the force at the motor must have stayed within its limit and must have ended in time, and
// the host must have been informed. The recording must contain every tick up to the fault. The session must
// either have been resumed and have reached the state hash of the session without a fault, or have ended as
// docs/hil.md describes. The sessions are compared with reference sessions without a fault. The reference
// sessions always run at test level 0, so the test also compares the results of other levels with those of
// level 0.
#pragma once
#include "hil_tests/campaign/fault.hpp"
#include "hil_tests/campaign/faulty_pipe.hpp"
#include "hil_tests/cases/conversation.hpp"
#include <optional>

namespace hil
{

inline constexpr double force_limit_N = 8.0;     // limit of the track and of its driver's current
inline constexpr double torque_limit_N_m = 0.02; // likewise
inline constexpr double force_none_N = 0.02,
                        torque_none_N_m = 0.0002; // less than the friction of the bearings

// Holds the results of the sessions in which no fault is injected.
struct Undisturbed {
    std::vector<crn_wire_tick_state> lockstep, free_run;
    std::uint64_t lockstep_hash = 0;
    std::vector<double> motor_N; // force on the hand's axis at the end of every millisecond of FREE_RUN
};

enum class SafeClass { none, host_silence, sensors_and_forces, supply, processor, command };
inline constexpr std::size_t safe_classes = 6;
const char *name_of(SafeClass which);
int bar_ms(SafeClass which);

struct Outcome {
    std::string failure; // empty: all held
    std::string ending;  // how the session ended
    std::string message; // the last message to the host
    SafeClass safe_class = SafeClass::none;
    int safe_ms = -1; // -1: no power had to be removed
    double peak_N = 0.0, peak_N_m = 0.0;
};

// Sets up the device for the campaign: a short wire in the tube, a seal that holds the wire, and one track
// with motors.
void campaign_set_up(crn::Link &link);
PlantSettings campaign_plant(bool has_stuck_motor = false);
bool same_state(const crn_wire_tick_state &a, const crn_wire_tick_state &b);

Undisturbed run_undisturbed(Level &level);
Outcome run_fault(Level &level, const Fault &fault, const Undisturbed &undisturbed);

// The functions run_asked (a LOCKSTEP session or its set-up) and run_free (a FREE_RUN session) each run a
// session with a fault, and throw Failure if a condition does not hold.
void run_asked(Level &level, const Fault &fault, const Undisturbed &undisturbed, Outcome &outcome);
void run_free(Level &level, const Fault &fault, const Undisturbed &undisturbed, Outcome &outcome);
void free_run_undisturbed(Level &level, Undisturbed &undisturbed);

// Sends messages as if from another host to the device in the middle of a session; the device's answers reach
// the first host as usual.
void strange_host(const Fault &fault, crn::Transport &pipe);

} // namespace hil
