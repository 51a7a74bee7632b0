// A static model of the Cortex-M7's pipeline: in order, two instructions a cycle, without caches. It prices
// straight code; branches are added by BranchPredictor. docs/budget.md states the rules and their sources.
#pragma once
#include "tools/chip/instruction.hpp"
#include <array>
#include <span>
#include <vector>

namespace chip
{

class Pipeline
{
  public:
    void issue(const Instruction &one);
    // A taken branch ends the pair: the next instruction comes from another place.
    void end_pair();
    std::int64_t cycles() const { return older_ ? cycle_ + 1 : cycle_; }
    // How many cycles ago the flags were last set.
    std::int64_t since_flags() const { return cycle_ - flags_cycle_; }

  private:
    // The first cycle in which an instruction may issue that consumes the register there.
    struct Ready {
        std::int64_t late = 0, early = 0, product = 0, accumulate = 0;
    };
    std::int64_t earliest(const Instruction &one) const;
    bool may_pair(const Instruction &younger) const;
    void define(const Instruction &one, std::int64_t at, bool is_older);

    std::array<Ready, 17> ready_{};
    std::int64_t cycle_ = 0, flags_cycle_ = -8;
    const Instruction *older_ = nullptr; // issued in this cycle, which has room for a second
};

// Cycles of straight code, from an idle pipeline.
std::int64_t cycles_of(std::span<const Instruction> code);

} // namespace chip
