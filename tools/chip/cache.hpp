// A data cache with lines of 32 bytes, and the counts of one tick: which lines and bricks of the scene it
// touched, and how many of its accesses missed.
#pragma once
#include <array>
#include <cstdint>
#include <vector>

namespace chip
{

inline constexpr std::uint32_t line_bytes = 32;

class Cache
{
  public:
    static constexpr std::uint32_t ways = 4;
    struct Access {
        bool is_missing = false;
        std::uint32_t written_back = 0; // address of the changed line that made room; 0: none did
    };
    explicit Cache(std::uint32_t bytes) : sets_(bytes / line_bytes / ways), lines_(sets_ * ways) {}

    // Returns whether the line was missing; it is in the cache afterwards, in place of the one of its set
    // that was used longest ago.
    Access access(std::uint32_t address, bool is_write)
    {
        const std::uint32_t number = address / line_bytes;
        Line *set = &lines_[number % sets_ * ways];
        std::uint32_t way = 0;
        while (way < ways - 1 && set[way].number != number) way++;
        Line line = set[way];
        Access result;
        if (line.number != number) {
            result.is_missing = true;
            if (line.is_changed) result.written_back = line.number * line_bytes;
            line = {number, false};
        }
        line.is_changed |= is_write;
        for (; way > 0; way--) set[way] = set[way - 1];
        set[0] = line;
        return result;
    }

  private:
    struct Line {
        std::uint32_t number = UINT32_MAX;
        bool is_changed = false;
    };
    std::uint32_t sets_;
    std::vector<Line> lines_; // per set from the line used last to the one used longest ago
};

// Counts different numbers below a bound, tick by tick, without clearing anything between ticks.
class Distinct
{
  public:
    explicit Distinct(std::size_t bound) : seen_(bound, 0) {}
    void begin()
    {
        count_ = 0;
        round_++;
    }
    void take(std::size_t number)
    {
        if (seen_[number] == round_) return;
        seen_[number] = round_;
        count_++;
    }
    std::uint32_t count() const { return count_; }

  private:
    std::vector<std::uint32_t> seen_;
    std::uint32_t round_ = 0, count_ = 0;
};

} // namespace chip
