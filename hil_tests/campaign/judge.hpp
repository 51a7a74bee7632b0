// One fault in one session at any level, and what must hold afterwards: force within its limit, no force in
// time, the host told, every tick up to the fault recorded, and the session resumed to the same hash or ended
// as documented (docs/hil.md). What the same sessions are without a fault is always level 0's: so levels are
// compared, too.
#pragma once
#include "hil_tests/campaign/fault.hpp"
#include "hil_tests/campaign/faulty_pipe.hpp"
#include "hil_tests/cases/conversation.hpp"
#include <optional>

namespace hil
{

inline constexpr double force_limit_N = 8.0;     // of the track and of its driver's current
inline constexpr double torque_limit_N_m = 0.02; // likewise
inline constexpr double force_none_N = 0.02, torque_none_N_m = 0.0002; // less than the bearings' friction

// What the same sessions are without a fault.
struct Undisturbed {
    std::vector<crn_wire_tick_state> lockstep, free_run;
    std::uint64_t lockstep_hash = 0;
    std::vector<double> motor_N; // of the hand's axis at the end of every millisecond of FREE_RUN
};

enum class SafeClass { none, host_silence, sensors_and_forces, supply, processor, command };
inline constexpr std::size_t safe_classes = 6;
const char *name_of(SafeClass which);
int bar_ms(SafeClass which);

struct Outcome {
    std::string failure; // empty: all held
    std::string ending;  // what became of the session
    std::string message; // the last that the host was told
    SafeClass safe_class = SafeClass::none;
    int safe_ms = -1; // -1: no power had to go
    double peak_N = 0.0, peak_N_m = 0.0;
};

// Set-up of the campaign: a short wire in the tube, a sheath that holds it, one track driven.
void campaign_set_up(crn::Link &link);
PlantSettings campaign_plant(bool has_stuck_motor = false);
bool same_state(const crn_wire_tick_state &a, const crn_wire_tick_state &b);

Undisturbed run_undisturbed(Level &level);
Outcome run_fault(Level &level, const Fault &fault, const Undisturbed &undisturbed);

// The two kinds of session; both throw Failure.
void run_asked(Level &level, const Fault &fault, const Undisturbed &undisturbed, Outcome &outcome);
void run_free(Level &level, const Fault &fault, const Undisturbed &undisturbed, Outcome &outcome);
void free_run_undisturbed(Level &level, Undisturbed &undisturbed);

// What another host says in the middle of a session, to the very device; its answers go where answers go.
void strange_host(const Fault &fault, crn::Transport &pipe);

} // namespace hil
