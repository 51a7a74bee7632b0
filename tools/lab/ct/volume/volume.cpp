#include "tools/lab/ct/volume/volume.hpp"
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

namespace crn::ct
{

Eigen::Matrix3d Volume::scene_per_voxel() const
{
    Eigen::Matrix3d result;
    for (int axis = 0; axis < 3; ++axis)
        result.col(axis) = scene_from_lps(direction.col(axis) * spacing_mm[axis]);
    return result;
}

double Volume::value(const Eigen::Vector3d &voxel) const
{
    int low[3];
    double share[3];
    for (int axis = 0; axis < 3; ++axis) {
        const double place = std::clamp(voxel[axis], 0.0, size[static_cast<std::size_t>(axis)] - 1.0);
        low[axis] = std::min(static_cast<int>(place), std::max(0, size[static_cast<std::size_t>(axis)] - 2));
        share[axis] = place - low[axis];
    }
    double sum = 0;
    for (int corner = 0; corner < 8; ++corner) {
        double weight = 1;
        int index[3];
        for (int axis = 0; axis < 3; ++axis) {
            const int up = corner >> axis & 1;
            weight *= up ? share[axis] : 1 - share[axis];
            index[axis] = std::min(low[axis] + up, size[static_cast<std::size_t>(axis)] - 1);
        }
        if (weight > 0) sum += weight * static_cast<double>(hu[at(index[0], index[1], index[2])]);
    }
    return sum;
}

Volume Volume::like(float fill) const
{
    Volume result;
    result.size = size;
    result.spacing_mm = spacing_mm;
    result.origin_mm = origin_mm;
    result.direction = direction;
    result.name = name;
    result.hu.assign(count(), fill);
    return result;
}

void make_right_handed(Volume &volume)
{
    if (volume.direction.determinant() > 0) return;
    volume.origin_mm = volume.lps({0, 0, volume.size[2] - 1.0});
    volume.direction.col(2) = -volume.direction.col(2);
    const std::size_t slice = volume.count() / static_cast<std::size_t>(volume.size[2]);
    for (int low = 0, high = volume.size[2] - 1; low < high; ++low, --high)
        std::swap_ranges(volume.hu.begin() + static_cast<std::ptrdiff_t>(slice) * low,
                         volume.hu.begin() + static_cast<std::ptrdiff_t>(slice) * (low + 1),
                         volume.hu.begin() + static_cast<std::ptrdiff_t>(slice) * high);
    volume.notes.push_back("its axes are left-handed: the third is counted from the other end, so that every "
                           "place keeps its value");
}

Volume cut_out(const Volume &volume, const std::array<int, 3> &low, const std::array<int, 3> &high)
{
    Volume result;
    for (std::size_t axis = 0; axis < 3; ++axis) result.size[axis] = high[axis] - low[axis];
    result.spacing_mm = volume.spacing_mm;
    result.origin_mm = volume.lps({double(low[0]), double(low[1]), double(low[2])});
    result.direction = volume.direction;
    result.name = volume.name;
    result.notes = volume.notes;
    result.hu.resize(result.count());
    for (int k = low[2]; k < high[2]; ++k)
        for (int j = low[1]; j < high[1]; ++j)
            std::copy_n(
                volume.hu.begin() + static_cast<std::ptrdiff_t>(volume.at(low[0], j, k)), result.size[0],
                result.hu.begin() + static_cast<std::ptrdiff_t>(result.at(0, j - low[1], k - low[2])));
    return result;
}

} // namespace crn::ct
