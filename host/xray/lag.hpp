// Lag is signal that the detector's photodiodes trap from one picture and release into the next ones.
//
// The model has one kind of trap, as in Siewerdsen and Jaffray, "A ghost story", Med Phys 26 (1999) 1624, who
// measured a lag of 2 to 10 %. A fraction a = 3 % of each picture's signal s is trapped. Within the time T to
// the next read-out, the traps release the fraction b(T) = 1 - 2^(-T/h) of their signal, where h = 140 ms is
// the half-life.
//     out = (1 - a) s + b q,   q <- (1 - b) q + a s
// No signal is lost. After a long exposure, the first picture without X-rays has 3 % of the last picture's
// signal, at any picture rate. From picture to picture without X-rays, the signal falls by the fraction b
// that the traps release; at 15 pictures/s each picture has 0.72 times the signal of the previous one.
#pragma once
#include <cstdint>

namespace crn
{

inline constexpr float lag_trapped_share = 0.03f;
inline constexpr float lag_half_time_ms = 140.0f;

// Returns the fraction of the trapped signal that the detector releases within the given time.
float lag_released_share(std::uint32_t elapsed_ms);

// Adds to each pixel of a row the signal that its traps release, and traps a part of the pixel's own signal.
void lag_row(float released_share, int size, float *trapped, float *signal);

} // namespace crn
