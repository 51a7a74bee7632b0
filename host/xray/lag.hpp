// Lag: what the detector's photodiodes keep of a picture and give to the next ones.
//
// One kind of trap (as in Siewerdsen and Jaffray, "A ghost story", Med. Phys. 26 (1999) 1624, who measured 2
// to 10 %): of each picture's signal s a share a = 3 % is trapped, and of what is trapped a share b(T) = 1 -
// 2^(-T/h) comes free within the time T to the
// next read-out, h = 140 ms:   out = (1 - a) s + b q,   q <- (1 - b) q + a s.  Nothing is lost. After a long exposure the first
// picture without X-rays holds 3 % of the last one at any picture rate, and each later one 1 - b of the one
// before it: 0.72 at 15 pictures/s.
#pragma once
#include <cstdint>

namespace crn
{

inline constexpr float lag_trapped_share = 0.03f;
inline constexpr float lag_half_time_ms = 140.0f;

// Share of the trapped signal that comes free within this time.
float lag_released_share(std::uint32_t elapsed_ms);

// Takes a row of signals through the traps.
void lag_row(float released_share, int size, float *trapped, float *signal);

} // namespace crn
