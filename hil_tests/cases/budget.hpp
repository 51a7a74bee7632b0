// What a tick of the aorta session costs on the emulated Cortex-M7: exact instructions in LOCKSTEP, and overruns in FREE_RUN.
// May include: aorta_session, l1. Called by: the program hil.
#pragma once
#include "hil_tests/cases/aorta_session.hpp"
#include <cstdint>

namespace hil
{

// The aorta session in LOCKSTEP, one step per transfer, every instruction from the first byte of a step to the end of its
// answer counted (shift 7).
AortaRun count_aorta(const AortaFiles &files, std::uint32_t ticks_max);

struct Overruns {
    std::uint32_t ticks = 0, overruns = 0; // work on one edge took longer than 1 ms
    double worst_us = 0.0;
};

// The aorta session in FREE_RUN, the hands moved by the plant, at 1,000 / 2^shift instructions per us.
Overruns overruns_of_aorta(const AortaFiles &files, int icount_shift, std::uint32_t ticks_max);

} // namespace hil
