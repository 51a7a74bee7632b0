// Provides random numbers that are the same with every C++ library. The C++ standard defines every bit of the
// generator std::mt19937_64, but not of the distributions in the library.
#pragma once
#include <cstdint>
#include <random>
#include <vector>

namespace soak
{

class Dice
{
  public:
    Dice(std::uint64_t seed, std::uint32_t index) : engine_(seed * 0x9e3779b97f4a7c15u + index)
    {
        engine_.discard(16);
    }
    // Returns a random number 0 .. count - 1. Taking the remainder makes some numbers more frequent than
    // others, but the probabilities here differ by less than 1e-12.
    std::size_t below(std::size_t count) { return static_cast<std::size_t>(engine_() % count); }
    int between(int low, int high)
    {
        return low + static_cast<int>(below(static_cast<std::size_t>(high - low + 1)));
    }
    bool chance(int percent) { return below(100) < static_cast<std::size_t>(percent); }
    template <typename T> const T &of(const std::vector<T> &all) { return all[below(all.size())]; }
    // Returns a random index into `weights`; the probability of an index is its weight divided by the sum of
    // all weights.
    std::size_t weighted(const std::vector<int> &weights)
    {
        int sum = 0;
        for (int weight : weights) sum += weight;
        int left = static_cast<int>(below(static_cast<std::size_t>(sum)));
        std::size_t k = 0;
        for (; left >= weights[k]; k++) left -= weights[k];
        return k;
    }

  private:
    std::mt19937_64 engine_;
};

} // namespace soak
