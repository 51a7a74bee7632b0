// Estimates, from the raw values of a picture alone, the scattered radiation in them, as a system does before
// it subtracts a mask. Scatter is nearly the same in mask and live picture; if it stayed in both, medium
// would look paler before bone than beside it.
#pragma once
#include "host/xray/run.hpp"
#include <cstdint>
#include <span>
#include <vector>

namespace crn
{

// Returns the raw value of scatter in each cell of 8 x 8 pixels; nothing where `frame.raw_open` is not known.
//
// Scatter follows from primary radiation by a convolution (Ohnesorge et al., Eur Radiol 9 (1999) 563;
// scatter.hpp), and the primary radiation is what is left of the signal without scatter. A few rounds find
// both. The estimate is taken at nine tenths, because too high a one makes holes in dark places.
std::vector<float> estimated_scatter(const RunFrame &frame, std::span<const std::uint16_t> raw, int size);

} // namespace crn
