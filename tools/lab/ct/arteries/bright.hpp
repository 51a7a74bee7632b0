// The bright voxels of a CT: those of vessels with contrast medium, bones, and undiluted medium.
#pragma once
#include "tools/lab/ct/arteries/body.hpp"
#include "tools/lab/ct/arteries/growth.hpp"

namespace crn::ct
{

constexpr double surroundings_HU = 55;

// A piece of what is brighter than blood is bone if it is larger, and a plaque if not.
constexpr double piece_least_mm3 = 300;

// What is brighter than `high_HU` is no blood with medium; what is darker than `low_HU`, no vessel.
struct BrightRange {
    float low_HU, high_HU;
};
BrightRange bright_range(const Contrast &contrast);

struct Bright {
    Mask inside;                // vessels, bones and organs with as much medium
    Widths widths;              // of `inside`
    Mask tubes;                 // what is shaped like a thin artery
    std::vector<Source> pieces; // brighter than arteries: bone, metal, undiluted medium
};

// A voxel is bright if it is above 0.42 of the way from the tissue around it to the arteries, because partial
// volume darkens thin arteries. The tissue is that of the neighbourhood, so that the noise of a spleen or
// liver with some medium does not look like vessels.
Bright bright_of(const Volume &scan, const Mask &body, const Contrast &contrast);

// Takes balls out of the bright voxels.
struct Ball {
    Eigen::Vector3d middle_mm;
    double radius_mm;
};
void take_out(const Volume &scan, const std::vector<Ball> &balls, Bright &bright);

// Calls use(voxel) for the voxels of a ball.
template <class Use> void for_ball(const Volume &scan, const Ball &ball, const Use &use)
{
    const Eigen::Vector3d voxel = scan.voxel(ball.middle_mm);
    int low[3], high[3];
    for (int axis = 0; axis < 3; ++axis) {
        const double reach = ball.radius_mm / scan.spacing_mm[axis];
        low[axis] = std::max(static_cast<int>(std::ceil(voxel[axis] - reach)), 0);
        high[axis] = std::min(static_cast<int>(std::floor(voxel[axis] + reach)),
                              scan.size[static_cast<std::size_t>(axis)] - 1);
    }
    for (int k = low[2]; k <= high[2]; ++k)
        for (int j = low[1]; j <= high[1]; ++j)
            for (int i = low[0]; i <= high[0]; ++i)
                if ((Eigen::Vector3d(i, j, k) - voxel).cwiseProduct(scan.spacing_mm).norm() <= ball.radius_mm)
                    use(scan.at(i, j, k));
}

} // namespace crn::ct
