#include "tools/lab/ct/arteries/tubes.hpp"
#include "tools/lab/ct/arteries/bright.hpp"
#include "tools/lab/ct/snake.hpp"
#include <Eigen/Eigenvalues>
#include <algorithm>

namespace crn::ct
{

namespace
{

using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr double scales_mm[] = {1.0, 1.8}; // tubes of 1 to 4 mm in radius
// Where the slices are thicker than the thin scale resolves, noise looks like tubes more often.
struct Least {
    double bent;  // of the medium's brightness, times the scale squared
    double round; // of the greater fall by the lesser: a sheet has 0
};
constexpr double thin_slice_mm = 1.5;
constexpr Least thin{0.05, 0.3}, thick{0.08, 0.45};
constexpr double along_most = 0.6; // of the lesser fall, along the tube

// The values of blood; what is brighter is dark by as much.
Volume like_blood(const Volume &scan, const Contrast &contrast)
{
    const auto low = static_cast<float>(surroundings_HU), mean = static_cast<float>(contrast.mean_HU),
               high = bright_range(contrast).high_HU;
    Volume blood = scan;
    for (float &hu : blood.hu) hu = std::clamp(std::min(hu, 2 * high - hu), low, mean) - low;
    return blood;
}

class Hessian
{
  public:
    explicit Hessian(const Volume &volume) : volume_(volume)
    {
        step_[0] = 1;
        for (std::size_t axis = 1; axis < 3; ++axis) step_[axis] = step_[axis - 1] * volume.size[axis - 1];
    }
    // Of a voxel that is not on the border of the grid, in 1/mm^2.
    Matrix3d at(std::size_t voxel) const
    {
        const float *here = volume_.hu.data() + voxel;
        Matrix3d bend;
        for (Eigen::Index a = 0; a < 3; ++a) {
            const std::ptrdiff_t step = step_[static_cast<std::size_t>(a)];
            bend(a, a) = static_cast<double>(here[step] - 2 * here[0] + here[-step]) /
                         (volume_.spacing_mm[a] * volume_.spacing_mm[a]);
            for (Eigen::Index b = 0; b < a; ++b) {
                const std::ptrdiff_t other = step_[static_cast<std::size_t>(b)];
                bend(a, b) = bend(b, a) = static_cast<double>(here[step + other] - here[step - other] -
                                                              here[other - step] + here[-step - other]) /
                                          (4 * volume_.spacing_mm[a] * volume_.spacing_mm[b]);
            }
        }
        return bend;
    }

  private:
    const Volume &volume_;
    std::ptrdiff_t step_[3];
};

bool is_tube(const Matrix3d &bend, double bent, double round)
{
    Eigen::SelfAdjointEigenSolver<Matrix3d> solver;
    solver.computeDirect(bend, Eigen::EigenvaluesOnly);
    const Vector3d bends = solver.eigenvalues(); // the steepest fall first
    return bends[1] < -bent && bends[1] < round * bends[0] && std::abs(bends[2]) < -along_most * bends[1];
}

} // namespace

Mask tubes_of(const Volume &scan, const Mask &inside, const Contrast &contrast)
{
    Mask tubes(scan.count(), 0);
    if (contrast.mean_HU <= surroundings_HU) return tubes; // no medium
    const Least &least = scan.spacing_mm.maxCoeff() > thin_slice_mm ? thick : thin;
    const Volume blood = like_blood(scan, contrast);
    for (const double scale_mm : scales_mm) {
        const Volume even = smoothed(blood, scale_mm);
        const Hessian hessian(even);
        const double bent = least.bent * (contrast.mean_HU - surroundings_HU) / (scale_mm * scale_mm);
        for (int k = 1; k + 1 < scan.size[2]; ++k)
            for (int j = 1; j + 1 < scan.size[1]; ++j)
                for (int i = 1; i + 1 < scan.size[0]; ++i) {
                    const std::size_t at = scan.at(i, j, k);
                    if (inside[at] && !tubes[at] && is_tube(hessian.at(at), bent, least.round)) tubes[at] = 1;
                }
    }
    return tubes;
}

} // namespace crn::ct
