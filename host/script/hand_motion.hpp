// Computes the motion of a hand that starts smoothly, moves at a steady speed, and stops smoothly. The
// computation uses only integers, so that a session gives the same encoder counts on every machine.
//
//   speed      ______________
//             /              \        ramps are smoothsteps of R = 200 ms (or shorter for short moves);
//         ___/                \___    distance over a ramp = speed x R / 2
//            |R|            |R|
#pragma once
#include <cstdint>

namespace crn
{

// In sessions without a real rig, one count of an encoder is 1 um or 1/65 536 turn.
inline constexpr std::int64_t counts_per_m = 1'000'000;
inline constexpr std::int64_t counts_per_turn = 65'536;
inline constexpr std::int64_t ramp_ticks_max = 200;

// Computes a move of a hand over a known distance. |distance| <= 2^26 counts, 1 <= speed <= 2^26 counts/s.
class Move
{
  public:
    Move(std::int64_t distance_counts, std::int64_t speed_counts_per_s);
    std::int64_t ticks() const { return ticks_; }
    std::int64_t at(std::int64_t tick) const; // counts moved `tick` ticks after the start

  private:
    std::int64_t distance_, cruise_, ramp_, ticks_;
};

// Computes a move of a hand at a steady speed. After a call of stop(), the hand slows down and comes to rest
// within one ramp, which takes at most ramp_ticks_max ticks. The speed may be negative.
class SteadyMove
{
  public:
    explicit SteadyMove(std::int64_t speed_counts_per_s) : speed_(speed_counts_per_s) {}
    void stop(std::int64_t tick);
    bool is_stopping() const { return stop_tick_ >= 0; }
    bool is_done(std::int64_t tick) const { return is_stopping() && tick >= stop_tick_ + ramp_ticks_max; }
    std::int64_t at(std::int64_t tick) const;

  private:
    std::int64_t speed_;
    std::int64_t stop_tick_ = -1;
};

// Simulates the hand of a user who moves tools with the keyboard. The target speeds of this hand may change
// at any time, and its actual speed changes by a limited step per tick.
class LiveHand
{
  public:
    void set_speed(std::int64_t translation_counts_per_s, std::int64_t rotation_counts_per_s);
    void advance_tick();
    std::int32_t translation_counts() const;
    std::int32_t rotation_counts() const;

  private:
    struct Axis {
        std::int64_t target = 0, speed = 0, position_milli = 0; // counts/s, counts/s, 1/1000 count
        void advance(std::int64_t step);
    };
    Axis translation_, rotation_;
};

} // namespace crn
