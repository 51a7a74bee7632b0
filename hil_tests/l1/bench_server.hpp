// A bench whose device is in another process, or another machine: what RemoteBench asks for and EmulatedBench
// does, over a pipe of bytes. The plant stays with the case; only samples, outputs and power go over the
// pipe.
//
//   case, plant, host/link  <--- requests, answers ---> server, emulator, image
//        +------------------- USB ----------------------------+
//
// Both ends are built from this tree for one kind of machine, so structs go over as they are.
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

// Samples and outputs of an emulated device's rig page.
void put_rig_inputs(const crn_port_inputs &from, rig_inputs &to);
crn_port_outputs take_rig_outputs(rig_page &page);
// One edge of the device's timer with this sample; returns when the device has done it.
void make_rig_edge(crn::Emulator &emulator, const crn_port_inputs &inputs, std::uint32_t milliseconds);

// Answers requests from `connection` until it is closed. False: it broke in the middle of one.
bool serve_bench(crn::Emulator &emulator, int connection);

} // namespace hil
