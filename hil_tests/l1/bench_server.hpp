// Provides a test bench whose device runs in another process or on another machine. The class RemoteBench
// sends requests over a pipe of bytes, and an EmulatedBench at the other end executes the requests. The
// simulated rig (class Plant) stays in the process of the test case; only sensor values, outputs, and
// commands for the power supply pass through the pipe.
//
//   case, plant, host/link  <--- requests, answers ---> server, emulator, image
//        +------------------- USB ----------------------------+
//
// Both ends of the pipe are built from this source tree for the same type of machine, so the bytes of C++
// structs are sent unchanged.
#pragma once
#include "firmware/port/port.h"
#include "host/link/emulator.hpp"
#include <cstdint>

namespace hil
{

enum class BenchOrder : std::uint32_t { power_on, edge, hold, release, power_cycle };

struct BenchRequest {
    BenchOrder order;
    std::uint32_t milliseconds; // of the rig
    crn_port_inputs inputs;
};

struct BenchAnswer {
    crn_port_outputs outputs;
    std::uint32_t edge_counts;
    char trouble[200]; // empty: done
};

// Gives access to the memory page through which an emulated device exchanges sensor values and outputs with
// its rig.
void put_rig_inputs(const crn_port_inputs &from, rig_inputs &to);
crn_port_outputs take_rig_outputs(rig_page &page);
// Passes the sensor values to the device, and returns when the device has completed the work of this
// millisecond.
void make_rig_edge(crn::Emulator &emulator, const crn_port_inputs &inputs, std::uint32_t milliseconds);

// Answers requests from `connection` until the other end closes the connection. Returns false if the
// connection broke in the middle of a request.
bool serve_bench(crn::Emulator &emulator, int connection);

} // namespace hil
