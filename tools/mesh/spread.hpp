// Numbers that are spread evenly without randomness.
#pragma once
#include <cstddef>

namespace crn::mesh
{

// Returns an element of van der Corput's sequence in a base, which spreads evenly from 0 to 1.
inline double spread(std::size_t index, std::size_t base)
{
    double value = 0, share = 1;
    for (; index > 0; index /= base) {
        share /= static_cast<double>(base);
        value += share * static_cast<double>(index % base);
    }
    return value;
}

} // namespace crn::mesh
