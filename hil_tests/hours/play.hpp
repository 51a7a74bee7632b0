// Plays one session on a station, as a host's program does: set-up, ARM, permission, START, the stream of
// ticks, hands that move the rig, one fault of the rig, the cable or the processor, RESET, a second run, and
// STOP.
#pragma once
#include "hil_tests/hours/station.hpp"
#include "hil_tests/soak/catalogue.hpp"
#include "hil_tests/soak/drawn.hpp"

namespace hours
{

enum class Disturbance {
    none,
    stop_button,
    supply,
    encoder,
    force_sensor,
    stall,
    silence,
    cable,
    power,
    count
};
const char *name_of(Disturbance disturbance);

struct Plan {
    soak::DrawnSession drawn;
    Disturbance disturbance = Disturbance::none;
    std::uint32_t run_ms = 30000;     // of each of the two runs; the script begins again if it is shorter
    std::uint32_t disturb_ms = 0;     // in the first run
    std::uint32_t disturbed_ms = 100; // how long a stall, a silence, or the cable's absence lasts
    bool wraps_encoders = false;      // the encoders' counts pass the end of their 32 bits
    bool is_repeated = false; // a second device repeats every tick in LOCKSTEP, and must have its hashes
};

// Gives every tool long elements, which make a tick cheap: an hour of simulated time then takes a minute or
// two. Lines that do not allow such elements are left out.
void coarsen(soak::Catalogue &catalogue, std::uint32_t element_um);

// Draws what happens to the session with this number; the session itself comes from soak::draw_session().
Plan draw_plan(const soak::Catalogue &catalogue, std::uint64_t seed, std::uint32_t index,
               std::uint32_t seconds_max);

struct Played {
    std::uint64_t ticks = 0;      // by the device, in all runs
    std::uint64_t live_ticks = 0; // that reached the host
    std::uint64_t late_ticks = 0; // of these, marked as late
    std::uint64_t repeated_ticks = 0;
    std::uint32_t runs = 0, arms = 0, faults = 0;
    std::uint32_t faults_unplanned = 0; // the session ended by itself: the plant met a limit
    std::string why_unplanned;
    std::uint64_t hash = 0; // of the last run's last tick
};

// Throws hil::Failure if the device breaks a promise, and LinkError if it refuses a valid request.
Played play(Station &station, const soak::Catalogue &catalogue, const Plan &plan);

} // namespace hours
