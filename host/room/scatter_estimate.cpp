#include "host/room/scatter_estimate.hpp"
#include "host/xray/float_math.hpp"
#include "host/xray/scatter.hpp"
#include <algorithm>

namespace crn
{
namespace
{

constexpr int rounds = 8;
constexpr float taken_share = 0.9f, cell_least = 0.1f; // of the estimate; of a cell's signal

// Returns the means of the exposed pixels in each cell; raw values behind the blades are 0.
CoarseSums cells_of(std::span<const std::uint16_t> raw, int size)
{
    const int cells = size / coarse_cell;
    CoarseSums sums(cells);
    for (int y = 0; y < cells * coarse_cell; ++y)
        for (int x = 0; x < cells * coarse_cell; ++x) {
            const std::uint16_t value = raw[static_cast<std::size_t>(y) * static_cast<std::size_t>(size) + x];
            if (value == 0) continue;
            const std::size_t cell = static_cast<std::size_t>(y / coarse_cell) * cells + x / coarse_cell;
            sums.sum[cell] += static_cast<float>(value);
            sums.count[cell] += 1.0f;
        }
    return sums;
}

} // namespace

std::vector<float> estimated_scatter(const RunFrame &frame, std::span<const std::uint16_t> raw, int size)
{
    if (!(frame.raw_open > 0.0) || size < coarse_cell || raw.size() < static_cast<std::size_t>(size) * size)
        return {};
    const CoarseSums exposed = cells_of(raw, size);
    const int cells = size / coarse_cell;
    const double cell_mm = frame.carm.field_m * 1e3 / size * coarse_cell;
    const float open = static_cast<float>(frame.raw_open);
    CoarseSums primary = exposed; // as shares of the open beam
    for (float &sum : primary.sum) sum /= open;
    const std::vector<float> signal = primary.sum;
    std::vector<float> scattered(signal.size(), 0.0f);
    for (int round = 0; round < rounds; ++round) {
        scattered = scatter_part(primary, cells, cell_mm);
        for (std::size_t i = 0; i < signal.size(); ++i) {
            const float left = signal[i] - grid_scatter_to_primary * scattered[i] * exposed.count[i];
            // Half of the way each round, because a dark cell's scatter comes from its bright neighbours.
            primary.sum[i] = 0.5f * (primary.sum[i] + std::max(left, cell_least * signal[i]));
        }
    }
    for (float &value : scattered) value *= taken_share * grid_scatter_to_primary * open;
    return scattered;
}

} // namespace crn
