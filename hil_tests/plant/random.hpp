// This header makes seeded noise that is the same on every machine, because it depends on no library.
#pragma once
#include <cstdint>

namespace hil
{

class Random
{
  public:
    explicit Random(std::uint64_t seed) : state_(seed) {}

    std::uint64_t next() // splitmix64
    {
        state_ += 0x9e3779b97f4a7c15u;
        std::uint64_t z = state_;
        z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
        z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
        return z ^ (z >> 31);
    }
    double uniform() { return static_cast<double>(next() >> 11) * 0x1p-53; } // [0, 1)
    std::uint32_t below(std::uint32_t count) { return static_cast<std::uint32_t>(next() % count); }
    // Returns a random number with mean 0 and standard deviation 1, which is between -6 and +6. The number is
    // the sum of twelve uniform random numbers, less 6.
    double normal()
    {
        double sum = -6.0;
        for (int i = 0; i < 12; i++) sum += uniform();
        return sum;
    }

  private:
    std::uint64_t state_;
};

} // namespace hil
