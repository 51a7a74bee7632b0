#include "tools/chip/pipeline.hpp"
#include <algorithm>
#include <bit>

namespace chip
{

namespace
{

constexpr std::uint32_t divide_cycles = 8; // assumed; the core divides only at set-up

template <class Do> void each_register(std::uint32_t bits, Do do_it)
{
    for (; bits != 0; bits &= bits - 1) do_it(static_cast<std::size_t>(std::countr_zero(bits)));
}

bool is_load(const Instruction &one)
{
    return one.unit == Unit::load || one.unit == Unit::narrow_load;
}

// The data memory has two banks of alternate words. Two loads pair where they are known to meet both.
bool meets_both_banks(const Instruction &a, const Instruction &b)
{
    return a.base != 0 && a.base == b.base && !a.writes(a.base) && ((a.offset ^ b.offset) & 4) != 0;
}

} // namespace

std::int64_t Pipeline::earliest(const Instruction &one) const
{
    std::int64_t at = 0;
    each_register(one.late, [&](std::size_t r) {
        at = std::max(at, one.unit == Unit::multiply ? ready_[r].product : ready_[r].late);
    });
    each_register(one.early, [&](std::size_t r) { at = std::max(at, ready_[r].early); });
    each_register(one.accumulate, [&](std::size_t r) { at = std::max(at, ready_[r].accumulate); });
    return at;
}

bool Pipeline::may_pair(const Instruction &younger) const
{
    if (!older_) return false;
    const Instruction &older = *older_;
    if (younger.unit == Unit::several || younger.unit == Unit::divide) return false;
    if (younger.unit == Unit::bits) return false; // only as the older
    const auto both = [&](Unit unit) { return older.unit == unit && younger.unit == unit; };
    if (both(Unit::multiply) || both(Unit::store) || both(Unit::branch)) return false;
    if ((older.unit == Unit::multiply && younger.unit == Unit::store) ||
        (older.unit == Unit::store && younger.unit == Unit::multiply))
        return false;
    if (older.has_shifter && younger.has_shifter) return false;
    if (is_load(older) && is_load(younger) && !meets_both_banks(older, younger)) return false;
    return true;
}

void Pipeline::define(const Instruction &one, std::int64_t at, bool is_older)
{
    bool runs_early = one.may_run_early && (is_older || one.unit == Unit::shift);
    each_register(one.late | one.early,
                  [&](std::size_t r) { runs_early = runs_early && ready_[r].early <= at; });
    Ready ready{at + 1, at + 2, at + 1, at};
    if (runs_early) ready = {at, at + 1, at, at};
    if (one.unit == Unit::load || one.unit == Unit::several) ready = {at + 1, at + 2, at + 2, at + 1};
    if (one.unit == Unit::narrow_load) ready = {at + 2, at + 3, at + 3, at + 1};
    if (one.unit == Unit::multiply) ready = {at + 2, at + 3, at + 2, at + 1};
    if (one.unit == Unit::divide) {
        const std::int64_t end = at + divide_cycles;
        ready = {end, end + 1, end, end};
    }
    const std::uint32_t address = (is_load(one) || one.unit == Unit::store) ? one.defines & one.early : 0;
    each_register(one.defines, [&](std::size_t r) {
        ready_[r] = ready;
        if (address >> r & 1) ready_[r] = {at + 1, at + 1, at + 1, at + 1}; // an address that was moved on
        if (r == 16) ready_[r] = {at + 1, at + 1, at + 1, at + 1};
    });
    if (one.defines & flags_bit) flags_cycle_ = at;
}

void Pipeline::issue(const Instruction &one)
{
    const std::int64_t first = earliest(one);
    if (may_pair(one) && first <= cycle_) {
        define(one, cycle_, false);
        older_ = nullptr;
        cycle_++;
        return;
    }
    if (older_) cycle_++;
    older_ = nullptr;
    cycle_ = std::max(cycle_, first);
    define(one, cycle_, true);
    if (one.unit == Unit::several || one.unit == Unit::divide) {
        cycle_ += one.unit == Unit::divide ? divide_cycles : one.cycles;
    } else {
        older_ = &one;
    }
}

void Pipeline::end_pair()
{
    if (older_) cycle_++;
    older_ = nullptr;
}

std::int64_t cycles_of(std::span<const Instruction> code)
{
    Pipeline pipeline;
    for (const Instruction &one : code) pipeline.issue(one);
    return pipeline.cycles();
}

} // namespace chip
