// Cost of a tick of the aorta session on the emulated Cortex-M7: exact instructions in LOCKSTEP, and overruns
// in FREE_RUN.
#pragma once
#include "hil_tests/cases/aorta_session.hpp"
#include <cstdint>
#include <vector>

namespace hil
{

// Runs the aorta session in LOCKSTEP mode, with one tick per transfer. Counts every processor instruction,
// from the first byte of the request for a tick to the end of the device's answer (the emulator's icount
// shift is 7).
AortaRun count_aorta(const AortaFiles &files, std::uint32_t ticks_max);

struct Overruns {
    std::vector<double> edge_us; // work on each edge
    std::size_t count() const;   // number of edges that took longer than 1 ms
    double worst_us() const;
};

// Runs the aorta session in FREE_RUN, in which the simulated rig moves the hands. The emulated processor
// executes 1,000 / 2^icount_shift instructions per us.
Overruns overruns_of_aorta(const AortaFiles &files, int icount_shift, std::uint32_t ticks_max);

} // namespace hil
