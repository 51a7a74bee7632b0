#include "tools/lab/ct/arteries/blocks.hpp"
#include <algorithm>

namespace crn::ct
{

void BlockMeans::set_size(const Volume &scan, double block_mm)
{
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const double spacing_mm = scan.spacing_mm[static_cast<Eigen::Index>(axis)];
        voxels_[axis] = std::max(1, static_cast<int>(block_mm / spacing_mm));
        size_[axis] = (scan.size[axis] + voxels_[axis] - 1) / voxels_[axis];
    }
}

void BlockMeans::finish(std::vector<double> sums, std::vector<double> counts, double share_least,
                        double standard)
{
    spread(sums);
    spread(counts);
    const double least = share_least * 27 * voxels_[0] * voxels_[1] * voxels_[2];
    means_.resize(sums.size());
    for (std::size_t at = 0; at < sums.size(); ++at)
        means_[at] =
            static_cast<float>(counts[at] < least || counts[at] == 0 ? standard : sums[at] / counts[at]);
}

// Adds the values of the 26 blocks around each.
void BlockMeans::spread(std::vector<double> &values) const
{
    std::size_t step = 1;
    for (const int size : size_) {
        const std::vector<double> before = values;
        for (std::size_t at = 0; at < values.size(); ++at) {
            const int index = static_cast<int>(at / step % static_cast<std::size_t>(size));
            if (index > 0) values[at] += before[at - step];
            if (index + 1 < size) values[at] += before[at + step];
        }
        step *= static_cast<std::size_t>(size);
    }
}

} // namespace crn::ct
