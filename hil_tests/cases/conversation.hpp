// The conversations of cases with a device: set-up, sessions in LOCKSTEP and FREE_RUN, and checks with
// numbers in their texts.
#pragma once
#include "hil_tests/cases/cases.hpp"
#include "host/link/link.hpp"
#include <functional>
#include <vector>

namespace hil
{

[[gnu::format(printf, 2, 3)]] void check(bool is_true, const char *format, ...);
[[gnu::format(printf, 1, 2)]] std::string text(const char *format, ...);

// A straight tube as a scene file: what sessions without anatomy have.
const std::vector<std::uint8_t> &tube_scene();

// The point at which a session ended.
struct Ending {
    std::uint32_t tick = 0;
    std::uint64_t hash = 0;
    std::vector<crn_wire_tick_state> states; // every tick
};
void check_same(const Ending &a, const Ending &b, const char *what);

// The rig that the plant is, with a virtual coupling that its damping allows.
crn_wire_rig plant_rig();

// HELLO, the tube scene, a J wire with 30 mm inserted, the rig as the plant has it; READY.
void set_up(crn::Link &link);

// Returns the input of tick `i` of the sample session: in, turned, back out.
crn_wire_tick_input sample_input(std::uint32_t tick);

// `ticks` ticks in LOCKSTEP in batches, from ARM on; `between` runs after every batch.
Ending lockstep_session(crn::Link &link, std::uint32_t ticks, std::uint32_t batch,
                        const std::function<void(std::uint32_t tick)> &between = {});

// Does the same without a bench, with the host's own device in this process.
Ending host_only_session(std::uint32_t ticks, std::uint32_t batch);

// From READY to RUNNING in FREE_RUN with power on the motors.
void start_free_run(Bench &bench, crn::Link &link);

// A frame that says that the host is there; what the device sent meanwhile.
std::vector<crn_wire_tick_state> keep_talking(crn::Link &link);

// Milliseconds of a session in FREE_RUN: the host is heard of every 8 ms and takes what the device sends.
void keep_running(crn::Link &link, std::uint32_t milliseconds, Ending *ending = nullptr);

// A hand on track 0 that pushes at 60 mm/s, turns, and feels what it gets: the wire bends in the tube.
void push_by_spring_hand(Plant &plant);

} // namespace hil
