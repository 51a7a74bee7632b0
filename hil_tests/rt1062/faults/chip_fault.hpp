// Faults of the emulated chip, drawn from seeds: one number names a fault completely. A kind of fault states
// what the device must do, whatever the fault's details are (docs/rt1062.md, "Faults at the registers").
#pragma once
#include "hil_tests/campaign/judge.hpp"
#include "hil_tests/rt1062/bench/rig_pins.hpp"
#include <string>
#include <vector>

namespace hil
{

enum class Must {
    nothing,   // beyond what holds for every fault
    power_off, // the power stage is off within the bar of the fault's class
    no_force,  // no force is left within the bar; the session may go on
    restart,   // the watchdog resets the chip, and the power stays off
};

struct ChipFault {
    std::uint32_t seed = 0;
    std::string kind, what; // "mem.code", "bit 3 of 0x00001234"
    rt_fault fault{};       // instants count from the checkpoint; at least 1
    Must must = Must::nothing;
    SafeClass safe_class = SafeClass::none;
    // The way from the firmware's order to the motor is broken, so that only the driver's limit of current
    // and the check of the measured force are left.
    bool is_of_motor = false;
    std::uint32_t horizon_ms = 40;
};

// What the faults are drawn from: the registers that the running image uses, and where its memory lies.
struct ChipSurvey {
    rt_census census{};
    std::vector<rt_word> words;
    std::vector<std::uint32_t> code, data; // words that the image executes, and reads
    std::uint32_t code_end = 0, bss_end = 0, dma_begin = 0, dma_end = 0, scene_bytes = 0;
    std::uint64_t tokens = 0; // of the bus until the checkpoint
};

ChipSurvey survey_of(rt_engine &engine, const rt_touched &touched);
ChipFault draw_chip_fault(std::uint32_t seed, const ChipSurvey &survey);

} // namespace hil
