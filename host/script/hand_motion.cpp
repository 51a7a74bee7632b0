#include "host/script/hand_motion.hpp"
#include <algorithm>
#include <cstdlib>

namespace crn
{

namespace
{

// Returns a / b, rounded to the nearest integer; halves are rounded away from zero, and b must be positive.
std::int64_t divide_rounded(std::int64_t a, std::int64_t b)
{
    return a >= 0 ? (a + b / 2) / b : -((-a + b / 2) / b);
}

// Returns a time in ticks, multiplied by 2 r^3 so that it is a whole number; r is the length of the ramp in
// ticks. In the returned time, a hand at full speed moves as far as an accelerating hand in the first t ticks
// of a ramp of r ticks. The returned number is t^3 (2 r - t) for the time t within a ramp of r ticks, which
// follows from the integral of the smoothstep function 3u^2 - 2u^3.
std::int64_t ramp_numerator(std::int64_t t, std::int64_t r)
{
    return t * t * t * (2 * r - t);
}

} // namespace

Move::Move(std::int64_t distance_counts, std::int64_t speed_counts_per_s) : distance_(distance_counts)
{
    const std::int64_t length = std::llabs(distance_counts);
    cruise_ = std::max<std::int64_t>(1, (length * 1000 + speed_counts_per_s - 1) / speed_counts_per_s);
    ramp_ = std::min(ramp_ticks_max, cruise_);
    ticks_ = length == 0 ? 0 : cruise_ + ramp_;
}

std::int64_t Move::at(std::int64_t tick) const
{
    if (tick <= 0) return 0;
    if (tick >= ticks_) return distance_;
    if (tick > ticks_ - ramp_) return distance_ - at(ticks_ - tick);
    if (tick < ramp_)
        return divide_rounded(distance_ * ramp_numerator(tick, ramp_), 2 * ramp_ * ramp_ * ramp_ * cruise_);
    return divide_rounded(distance_ * (2 * tick - ramp_), 2 * cruise_);
}

void SteadyMove::stop(std::int64_t tick)
{
    if (!is_stopping()) stop_tick_ = std::max(tick, ramp_ticks_max);
}

std::int64_t SteadyMove::at(std::int64_t tick) const
{
    constexpr std::int64_t r = ramp_ticks_max, unit = 2 * r * r * r;
    if (is_stopping() && tick > stop_tick_) {
        const std::int64_t left = std::max<std::int64_t>(0, r - (tick - stop_tick_));
        const std::int64_t ticks_in_unit = unit * stop_tick_ - ramp_numerator(left, r);
        return divide_rounded(speed_ * (ticks_in_unit / 1000), unit);
    }
    const std::int64_t ticks_in_unit = tick < r ? ramp_numerator(tick, r) : unit * tick - unit / 2 * r;
    return divide_rounded(speed_ * (ticks_in_unit / 1000), unit);
}

void LiveHand::Axis::advance(std::int64_t step)
{
    speed += std::clamp(target - speed, -step, step);
    position_milli += speed;
}

void LiveHand::set_speed(std::int64_t translation_counts_per_s, std::int64_t rotation_counts_per_s)
{
    translation_.target = translation_counts_per_s;
    rotation_.target = rotation_counts_per_s;
}

// With the given steps of the speed per tick, a resting hand reaches 60 mm/s and one turn per second in about
// 150 ms.
void LiveHand::advance_tick()
{
    translation_.advance(400);
    rotation_.advance(440);
}

// The simulated encoder counters wrap round as hardware counters do.
std::int32_t LiveHand::translation_counts() const
{
    return static_cast<std::int32_t>(
        static_cast<std::uint32_t>(divide_rounded(translation_.position_milli, 1000)));
}

std::int32_t LiveHand::rotation_counts() const
{
    return static_cast<std::int32_t>(
        static_cast<std::uint32_t>(divide_rounded(rotation_.position_milli, 1000)));
}

} // namespace crn
