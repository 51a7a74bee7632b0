// This header has a bench whose device is in another process, or on another machine. RemoteBench sends
// requests and EmulatedBench executes them, over a pipe of bytes. The plant stays in the process of the case;
// only samples, outputs and power orders pass through the pipe.
//
//   case, plant, host/link  <--- requests, answers ---> server, emulator, image
//        +------------------- USB ----------------------------+
//
// Both ends are built from this source tree for the same kind of machine, so structs are sent unchanged.
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

// This class gives access to samples and outputs of an emulated device's rig page.
void put_rig_inputs(const crn_port_inputs &from, rig_inputs &to);
crn_port_outputs take_rig_outputs(rig_page &page);
// Runs one edge of the device's timer with this sample; returns when the device has completed it.
void make_rig_edge(crn::Emulator &emulator, const crn_port_inputs &inputs, std::uint32_t milliseconds);

// Answers requests from `connection` until it is closed. Returns false when the connection broke in the
// middle of a request.
bool serve_bench(crn::Emulator &emulator, int connection);

} // namespace hil
