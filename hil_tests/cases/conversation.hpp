// Provides what the test cases have in common: set-up of a device, sessions in LOCKSTEP and FREE_RUN, and
// checks whose failure texts contain numbers.
#pragma once
#include "hil_tests/cases/cases.hpp"
#include "host/link/link.hpp"
#include <functional>
#include <vector>

namespace hil
{

[[gnu::format(printf, 2, 3)]] void check(bool is_true, const char *format, ...);
[[gnu::format(printf, 1, 2)]] std::string text(const char *format, ...);

// Returns a straight tube as a scene file, for sessions without anatomy.
const std::vector<std::uint8_t> &tube_scene();

// Describes the state of a session at its end.
struct Ending {
    std::uint32_t tick = 0;
    std::uint64_t hash = 0;
    std::vector<crn_wire_tick_state> states; // every tick
};
void check_same(const Ending &a, const Ending &b, const char *what);

// Returns the settings of the simulated rig, with a virtual coupling that the rig's damping allows.
crn_wire_rig plant_rig();

// HELLO, the tube scene, a J wire with 30 mm inserted, the rig as the plant has it; READY.
void set_up(crn::Link &link);

// Returns the input of tick `i` of the sample session: the tool is pushed in, turned, and pulled back out.
crn_wire_tick_input sample_input(std::uint32_t tick);

// Arms the device, runs `ticks` ticks in LOCKSTEP in batches of `batch` ticks, and calls `between` after
// every batch. `input_of` gives the inputs in the order of their ticks.
Ending
lockstep_session(crn::Link &link, std::uint32_t ticks, std::uint32_t batch,
                 const std::function<void(std::uint32_t tick)> &between = {},
                 const std::function<crn_wire_tick_input(std::uint32_t tick)> &input_of = sample_input);

// Runs the session of lockstep_session() without a test bench, with the host's own device in this process.
Ending host_only_session(std::uint32_t ticks, std::uint32_t batch);

// Brings the device from the state READY to RUNNING in FREE_RUN, with power on the motors.
void start_free_run(Bench &bench, crn::Link &link);

// Sends a frame, so that the device notices that the host is alive, and returns the ticks that the device has
// sent since the last call.
std::vector<crn_wire_tick_state> keep_talking(crn::Link &link);

// Continues a session in FREE_RUN for `milliseconds`: the host sends a frame every 8 ms, so that the device
// does not consider the host silent, and receives the device's messages.
void keep_running(crn::Link &link, std::uint32_t milliseconds, Ending *ending = nullptr);

// Makes a hand on track 0 push at 60 mm/s, turn, and yield to the force that it feels; the wire bends in the
// tube.
void push_by_spring_hand(Plant &plant);

} // namespace hil
