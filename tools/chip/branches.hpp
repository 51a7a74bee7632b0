// The branch prediction of the Cortex-M7, as assumed in docs/budget.md: a table of 64 branches with targets
// and two-bit counters.
#pragma once
#include "tools/chip/instruction.hpp"
#include <array>

namespace chip
{

struct Jump {
    std::uint32_t address = 0, target = 0; // target: where the program went
    bool is_taken = false;
    Flow flow = Flow::straight;
    bool knows_flags_early = false; // they were set at least three cycles before the branch
};

class BranchPredictor
{
  public:
    static constexpr std::uint32_t entries = 64;
    static constexpr std::uint32_t late_cycles = 8, early_cycles = 6; // a wrong prediction
    static constexpr std::uint32_t decode_cycles = 3; // a taken branch that only the decoder recognised

    // Returns the cycles that the jump takes beyond those of its instruction.
    std::uint32_t cycles(const Jump &jump)
    {
        Entry &entry = table_[jump.address / 2 % entries];
        const bool is_known = entry.address == jump.address && entry.is_used;
        const bool goes = is_known && entry.counter >= 2;
        // without an entry: backwards taken, forwards not, recognised by the decoder
        const bool decoder_goes = jump.flow == Flow::direct || (jump.flow == Flow::conditional &&
                                                                jump.is_taken && jump.target < jump.address);
        const std::uint32_t wrong =
            jump.knows_flags_early && jump.flow == Flow::conditional ? early_cycles : late_cycles;
        std::uint32_t result = 0;
        if (is_known) {
            if (goes != jump.is_taken || (goes && entry.target != jump.target)) result = wrong;
        } else if (jump.is_taken) {
            result = decoder_goes ? decode_cycles : wrong;
        }
        if (is_known) {
            if (jump.is_taken && entry.counter < 3) entry.counter++;
            if (!jump.is_taken && entry.counter > 0) entry.counter--;
            if (jump.is_taken) entry.target = jump.target;
        } else if (jump.is_taken) {
            entry = {jump.address, jump.target, 2, true};
        }
        return result;
    }

  private:
    struct Entry {
        std::uint32_t address = 0, target = 0;
        std::uint8_t counter = 0;
        bool is_used = false;
    };
    std::array<Entry, entries> table_{};
};

} // namespace chip
