/* Makes random numbers that are the same on every machine, with the generator SplitMix64 (Steele 2014,
   OOPSLA, "Fast splittable pseudorandom number generators"). */
#pragma once
#include <cmath>
#include <cstdint>
#include <numbers>

namespace anatomy
{

class Chance
{
  public:
    /* Equal pairs of seed and stream give equal numbers; each attempt for a seed has its own stream. */
    Chance(std::uint64_t seed, std::uint64_t stream) : state_(mixed(seed) ^ mixed(~stream)) {}

    /* Returns a uniformly distributed number in low .. high. */
    double uniform(double low, double high)
    {
        state_ += STEP;
        return low + (high - low) * std::ldexp(static_cast<double>(mixed(state_) >> 11), -53);
    }

    /* Returns a normally distributed number, at most two standard deviations from the mean. */
    double normal(double mean, double deviation)
    {
        for (int i = 0; i < TRIES_MAX; ++i) {
            const double radius = std::sqrt(-2 * std::log(uniform(1e-12, 1)));
            const double z = radius * std::cos(uniform(0, 2 * std::numbers::pi));
            if (std::abs(z) <= 2) return mean + deviation * z;
        }
        return mean;
    }

  private:
    static constexpr std::uint64_t STEP = 0x9E3779B97F4A7C15u;
    static constexpr int TRIES_MAX = 100; // one try in 22 is repeated

    static std::uint64_t mixed(std::uint64_t z)
    {
        z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9u;
        z = (z ^ (z >> 27)) * 0x94D049BB133111EBu;
        return z ^ (z >> 31);
    }

    std::uint64_t state_;
};

} // namespace anatomy
