#include "tools/lab/ct/cta/painting.hpp"
#include <algorithm>
#include <cmath>

namespace crn::ct
{

namespace
{

using Eigen::Vector2d;
using Eigen::Vector3d;

std::size_t bins_between(double low_mm, double high_mm, double bin_mm)
{
    return static_cast<std::size_t>(std::max(0.0, std::ceil((high_mm - low_mm) / bin_mm))) + 1;
}

void fill(Samples &samples, const SampleGrid &grid, int row, double from_mm, double to_mm, std::int16_t hu,
          std::int16_t below_hu = INT16_MAX)
{
    const int begin = std::max(0, static_cast<int>(std::ceil((from_mm - grid.left_mm) / grid.step_mm))),
              end =
                  std::min(grid.samples, static_cast<int>(std::ceil((to_mm - grid.left_mm) / grid.step_mm)));
    const std::size_t at = static_cast<std::size_t>(row) * static_cast<std::size_t>(grid.samples);
    for (int i = begin; i < end; ++i)
        if (std::int16_t &sample = samples[at + static_cast<std::size_t>(i)]; sample < below_hu) sample = hu;
}

} // namespace

CutMesh::CutMesh(bake::Mesh mesh, double low_mm, double high_mm)
    : mesh_(std::move(mesh)), low_mm_(low_mm), bins_(bins_between(low_mm, high_mm, bin_mm))
{
    for (std::uint32_t t = 0; t < mesh_.triangles.size(); ++t) {
        double low = 1e9, high = -1e9;
        for (const std::uint32_t corner : mesh_.triangles[t]) {
            low = std::min(low, mesh_.vertices_mm[corner].y());
            high = std::max(high, mesh_.vertices_mm[corner].y());
        }
        const double last = static_cast<double>(bins_.size()) - 1;
        const double first_bin = std::floor((low - low_mm_) / bin_mm),
                     last_bin = std::floor((high - low_mm_) / bin_mm);
        for (double bin = std::max(0.0, first_bin); bin <= std::min(last, last_bin); ++bin)
            bins_[static_cast<std::size_t>(bin)].push_back(t);
    }
}

void CutMesh::paint(Samples &samples, const SampleGrid &grid, double height_mm, const Vector2d &shift_mm,
                    std::int16_t hu) const
{
    const double bin = std::floor((height_mm - low_mm_) / bin_mm);
    if (bin < 0 || bin >= static_cast<double>(bins_.size())) return;
    const std::vector<std::uint32_t> &near = bins_[static_cast<std::size_t>(bin)];
    if (near.empty()) return;
    std::vector<std::vector<double>> crossings(static_cast<std::size_t>(grid.rows));
    for (const std::uint32_t t : near) {
        Vector2d ends[3]; // where the triangle's edges cross the plane: x and z
        int count = 0;
        for (std::size_t edge = 0; edge < 3; ++edge) {
            const Vector3d &a = mesh_.vertices_mm[mesh_.triangles[t][edge]],
                           &b = mesh_.vertices_mm[mesh_.triangles[t][(edge + 1) % 3]];
            if ((a.y() <= height_mm) == (b.y() <= height_mm)) continue;
            const double share = (height_mm - a.y()) / (b.y() - a.y());
            ends[count++] =
                Vector2d(a.x() + share * (b.x() - a.x()), a.z() + share * (b.z() - a.z())) + shift_mm;
        }
        if (count != 2) continue;
        const double from = (grid.front_mm - std::max(ends[0].y(), ends[1].y())) / grid.row_mm,
                     to = (grid.front_mm - std::min(ends[0].y(), ends[1].y())) / grid.row_mm;
        for (int row = std::max(0, static_cast<int>(std::ceil(from))); row < std::min<double>(grid.rows, to);
             ++row) {
            const double z = grid.front_mm - row * grid.row_mm;
            crossings[static_cast<std::size_t>(row)].push_back(
                ends[0].x() + (z - ends[0].y()) / (ends[1].y() - ends[0].y()) * (ends[1].x() - ends[0].x()));
        }
    }
    for (int row = 0; row < grid.rows; ++row) {
        std::vector<double> &at = crossings[static_cast<std::size_t>(row)];
        std::sort(at.begin(), at.end());
        for (std::size_t i = 0; i + 1 < at.size(); i += 2) fill(samples, grid, row, at[i], at[i + 1], hu);
    }
}

CutBalls::CutBalls(double low_mm, double high_mm)
    : low_mm_(low_mm), bins_(bins_between(low_mm, high_mm, bin_mm))
{
}

void CutBalls::add(const Vector3d &from_mm, double from_radius_mm, const Vector3d &to_mm, double to_radius_mm)
{
    constexpr double step_mm = 0.25;
    const int steps = static_cast<int>(std::ceil((to_mm - from_mm).norm() / step_mm)) + 1;
    for (int i = 0; i < steps; ++i) {
        const double share = steps > 1 ? double(i) / (steps - 1) : 0.0;
        const Vector3d centre = from_mm + share * (to_mm - from_mm);
        const double radius = from_radius_mm + share * (to_radius_mm - from_radius_mm);
        const double last = static_cast<double>(bins_.size()) - 1;
        const double first_bin = std::floor((centre.y() - radius - low_mm_) / bin_mm),
                     last_bin = std::floor((centre.y() + radius - low_mm_) / bin_mm);
        for (double bin = std::max(0.0, first_bin); bin <= std::min(last, last_bin); ++bin)
            bins_[static_cast<std::size_t>(bin)].push_back(
                {centre.cast<float>(), static_cast<float>(radius)});
    }
}

void CutBalls::paint(Samples &samples, const SampleGrid &grid, double height_mm, const Vector2d &shift_mm,
                     std::int16_t hu, std::int16_t below_hu) const
{
    const double bin = std::floor((height_mm - low_mm_) / bin_mm);
    if (bin < 0 || bin >= static_cast<double>(bins_.size())) return;
    for (const Ball &ball : bins_[static_cast<std::size_t>(bin)]) {
        const Vector3d centre = ball.centre_mm.cast<double>();
        const double radius = static_cast<double>(ball.radius_mm), above = height_mm - centre.y();
        if (std::abs(above) >= radius) continue;
        const double disc = std::sqrt(radius * radius - above * above), z_middle = centre.z() + shift_mm.y();
        const int first =
            std::max(0, static_cast<int>(std::ceil((grid.front_mm - z_middle - disc) / grid.row_mm)));
        for (int row = first; row < grid.rows; ++row) {
            const double z = grid.front_mm - row * grid.row_mm - z_middle;
            if (z < -disc) break;
            const double half = std::sqrt(std::max(0.0, disc * disc - z * z)), x = centre.x() + shift_mm.x();
            fill(samples, grid, row, x - half, x + half, hu, below_hu);
        }
    }
}

} // namespace crn::ct
