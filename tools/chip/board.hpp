// The chips whose millisecond is priced, with the memories in which code, state and scene lie there.
// docs/budget.md states where each number comes from.
#pragma once
#include <array>
#include <cstdint>
#include <string_view>

namespace chip
{

struct Board {
    std::string_view name, memory; // memory: that of the scene
    double core_MHz;
    double line_ns;           // from a miss in the scene to the word
    double near_line_ns;      // the same for near memory (firmware/core/near/near.h)
    double state_line_ns;     // the same for the state; 0: the state lies in tightly coupled memory
    std::uint32_t slot_bytes; // the largest scene
    double tick_cycles() const { return core_MHz * 1000.0; }
};

inline constexpr std::uint32_t cache_bytes = 32 << 10; // data cache of all three

// 84 clocks of 79.2 MHz a line: cournand's port, firmware/port/imxrt1062/scene_ram.c.
inline constexpr std::array<Board, 3> boards = {{
    {"rt1062", "PSRAM, four lines at 79.2 MHz", 600.0, 84 / 0.0792, 11 / 0.15, 0.0, 8u << 20},
    {"rt1176", "SDRAM, 16 bits at 166 MHz", 1000.0, 30 / 0.166, 11 / 0.24, 0.0, 16u << 20},
    {"stm32h735", "HyperRAM, eight lines at 100 MHz, both edges", 550.0, 36 / 0.1, 14 / 0.275, 14 / 0.275,
     8u << 20},
}};

} // namespace chip
