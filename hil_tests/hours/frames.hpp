// The host's millisecond: the frames of USB, as the device's crystal measures them. Both crystals are within
// 50 ppm of their nominal frequency, and wander, so a frame is between 100 ppm shorter and 100 ppm longer
// than the device's millisecond.
#pragma once
#include "hil_tests/plant/random.hpp"
#include <algorithm>
#include <cstdint>

namespace hours
{

inline constexpr std::int64_t ps_per_ms = 1'000'000'000, ps_per_us = 1'000'000;
inline constexpr std::int64_t crystals_ppm = 100; // of both together
inline constexpr std::uint32_t frame_numbers = 2048;

class Frames
{
  public:
    explicit Frames(std::uint64_t seed) : random_(seed) {}

    std::int64_t next_ps() const { return next_ps_; } // time of the next frame
    std::uint64_t count() const { return count_; }
    std::uint32_t number() const { return static_cast<std::uint32_t>(count_ % frame_numbers); }
    // Frames since the start as a real number: whole ones, and the share of the present one that has passed.
    double at(std::int64_t now_ps) const
    {
        return static_cast<double>(count_) +
               static_cast<double>(now_ps - last_ps_) / static_cast<double>(ps_per_ms + offset_ps_);
    }

    void begin_next()
    {
        last_ps_ = next_ps_;
        count_++;
        if (count_ % wander_every == 0) {
            const auto step = static_cast<std::int64_t>(random_.below(2 * wander_ps + 1)) - wander_ps;
            offset_ps_ = std::clamp(offset_ps_ + step, -limit_ps, limit_ps);
        }
        next_ps_ = last_ps_ + ps_per_ms + offset_ps_;
    }

  private:
    static constexpr std::uint64_t wander_every = 4096;
    static constexpr std::int64_t limit_ps = crystals_ppm * ps_per_ms / 1'000'000, wander_ps = 2000;

    hil::Random random_;
    std::int64_t offset_ps_ = 60'000; // 60 ppm
    std::int64_t last_ps_ = 0, next_ps_ = 250 * ps_per_us;
    std::uint64_t count_ = 0;
};

} // namespace hours
