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
    explicit Cache(std::uint32_t bytes) : sets_(bytes / line_bytes / ways), tags_(sets_ * ways, empty) {}

    // Returns whether the line was missing; it is in the cache afterwards, in place of the one of its set
    // that was used longest ago.
    bool misses(std::uint32_t address)
    {
        const std::uint32_t line = address / line_bytes;
        std::uint32_t *set = &tags_[line % sets_ * ways];
        std::uint32_t way = 0;
        while (way < ways - 1 && set[way] != line) way++;
        const bool is_missing = set[way] != line;
        for (; way > 0; way--) set[way] = set[way - 1];
        set[0] = line;
        return is_missing;
    }

  private:
    static constexpr std::uint32_t empty = UINT32_MAX;
    std::uint32_t sets_;
    std::vector<std::uint32_t> tags_; // per set from the line used last to the one used longest ago
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
