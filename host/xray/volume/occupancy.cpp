// Counts the bricks of a CT volume that hold tissue.
#include "host/xray/volume/occupancy.hpp"
#include <algorithm>

namespace crn
{

std::vector<std::uint8_t> full_bricks(const CtVolume &volume, std::array<int, 3> &bricks)
{
    for (int axis = 0; axis < 3; ++axis) bricks[axis] = (volume.size[axis] + brick_edge - 1) / brick_edge;
    std::vector<std::uint8_t> is_full(std::size_t{1} * bricks[0] * bricks[1] * bricks[2], 0);
    const auto is_tissue = [](std::uint16_t value) { return value != 0; };
    for (int y = 0; y < volume.size[1]; ++y)
        for (int z = 0; z < volume.size[2]; ++z) {
            const std::uint16_t *row = volume.permille.data() + volume.index(0, y, z);
            std::uint8_t *full =
                is_full.data() + (std::size_t{1} * (z / brick_edge) * bricks[1] + y / brick_edge) * bricks[0];
            for (int b = 0; b < bricks[0]; ++b) {
                const int end = std::min((b + 1) * brick_edge, volume.size[0]);
                full[b] |= std::any_of(row + b * brick_edge, row + end, is_tissue) ? 1 : 0;
            }
        }
    return is_full;
}

SlabTable::SlabTable(const std::vector<std::uint8_t> &is_full, const std::array<int, 3> &bricks, int p, int q,
                     int r)
    : slabs_(bricks[p]), across_(bricks[q]), down_(bricks[r]),
      sum_(std::size_t{1} * bricks[p] * (bricks[q] + 1) * (bricks[r] + 1), 0)
{
    const std::array<std::size_t, 3> step = {1, std::size_t{1} * bricks[0],
                                             std::size_t{1} * bricks[0] * bricks[1]};
    const int width = across_ + 1;
    for (int slab = 0; slab < slabs_; ++slab) {
        std::int32_t *sum = sum_.data() + std::size_t{1} * slab * width * (down_ + 1);
        for (int j = 0; j < down_; ++j)
            for (int i = 0; i < across_; ++i)
                sum[(j + 1) * width + i + 1] = is_full[slab * step[p] + i * step[q] + j * step[r]] +
                                               sum[j * width + i + 1] + sum[(j + 1) * width + i] -
                                               sum[j * width + i];
    }
}

bool SlabTable::has_tissue(int slab, int q0, int q1, int r0, int r1) const
{
    const int left = std::max(q0, 0) / brick_edge, right = std::min(q1 / brick_edge + 1, across_);
    const int low = std::max(r0, 0) / brick_edge, high = std::min(r1 / brick_edge + 1, down_);
    if (q1 < 0 || r1 < 0 || left >= right || low >= high) return false;
    const int width = across_ + 1;
    const std::int32_t *sum = sum_.data() + std::size_t{1} * slab * width * (down_ + 1);
    return sum[high * width + right] - sum[low * width + right] - sum[high * width + left] +
               sum[low * width + left] >
           0;
}

} // namespace crn
