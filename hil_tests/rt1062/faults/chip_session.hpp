// A session of the emulated board in which a fault of the chip happens, and its verdict. One board boots, is
// set up, and runs to a checkpoint, where the motors have power and a hand pushes; every fault then has a
// copy of the whole process (fork), so a fault costs no boot, and no fault sees another one's traces.
#pragma once
#include "hil_tests/rt1062/bench/board_bench.hpp"
#include "hil_tests/rt1062/faults/chip_fault.hpp"
#include <functional>

namespace hil
{

struct ChipOutcome {
    char failure[200] = ""; // empty: all held
    char ending[64] = "";
    double safe_ms = -1; // from the fault to the end of the last force; -1: no power had to be removed
    double bar_ms = 0;
    double peak_N = 0, peak_N_m = 0, asked_N = 0; // asked: by duty, at full supply
    double wall_s = 0;
};

using ChipFaultDone = std::function<void(const ChipFault &, const ChipOutcome &)>;

// Judges the faults of the given seeds, checkpoint by checkpoint, `jobs` of them at a time.
void run_chip_faults(const std::string &image, std::vector<std::uint32_t> seeds, std::uint32_t jobs,
                     const ChipFaultDone &done);

} // namespace hil
