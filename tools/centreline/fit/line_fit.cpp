// The fit of a centreline repeats two steps: it moves each point to the middle of the vessel's cross-section,
// and then it smooths the centreline.
#include "tools/centreline/fit/line_fit.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace crn::centreline
{
namespace
{

using Points = std::vector<Eigen::Vector3d>;
constexpr int turns = 4;
constexpr double fine_spacing = 0.25;   // spacing of the points while fitting, in radii
constexpr double reach_share = 0.5;     // largest move of a point in a turn, in radii
constexpr double centred_share = 0.004; // smallest step of the search, in radii

double length_of(const Points &line)
{
    double sum = 0;
    for (std::size_t i = 1; i < line.size(); ++i) sum += (line[i] - line[i - 1]).norm();
    return sum;
}

// Returns points of the centreline `line` at distances of about `step(p)` from each other; the first and the
// last point do not move.
template <typename Step> Points resampled(const Points &line, Step step)
{
    Points made{line.front()};
    double left = step(line.front());
    for (std::size_t i = 1; i < line.size(); ++i) {
        Eigen::Vector3d at = line[i - 1];
        for (double rest = (line[i] - at).norm(); rest >= left; rest = (line[i] - at).norm()) {
            at += (line[i] - at) * (left / rest);
            made.push_back(at);
            left = step(at);
        }
        left -= (line[i] - at).norm();
    }
    // The last piece of the centreline should be about as long as the other pieces.
    if (made.size() > 1 && (made.back() - line.back()).norm() < 0.5 * step(line.back())) made.pop_back();
    made.push_back(line.back());
    return made;
}

void smooth(Points &line, double share, int times)
{
    for (int n = 0; n < times; ++n) {
        Points before = line;
        for (std::size_t i = 1; i + 1 < line.size(); ++i)
            line[i] += share * (0.5 * (before[i - 1] + before[i + 1]) - before[i]);
    }
}

// The code measures the centreline's direction over about one vessel radius to either side, because immediate
// neighbours are too close for a stable direction.
Eigen::Vector3d direction_at(const Points &line, std::size_t i, double radius_mm)
{
    std::size_t before = i, after = i;
    while (before > 0 && (line[i] - line[before]).norm() < 0.7 * radius_mm) --before;
    while (after + 1 < line.size() && (line[after] - line[i]).norm() < 0.7 * radius_mm) ++after;
    const Eigen::Vector3d way = line[after] - line[before];
    return way.norm() > 0 ? way.normalized() : Eigen::Vector3d::UnitZ();
}

} // namespace

Eigen::Vector3d centred(const Lumen &lumen, const Eigen::Vector3d &p_mm, const Eigen::Vector3d &direction,
                        double limit_mm)
{
    const Eigen::Vector3d u = direction.unitOrthogonal(), v = direction.cross(u);
    Eigen::Vector3d best = p_mm;
    double radius = lumen.radius_mm(best);
    const double smallest = centred_share * radius;
    for (double step = std::min(0.25 * radius, limit_mm); step > smallest;) {
        bool is_better = false;
        for (int k = 0; k < 6 && !is_better; ++k) {
            const double angle = k * 1.0471975511965976;
            const Eigen::Vector3d q = best + step * (std::cos(angle) * u + std::sin(angle) * v);
            if ((q - p_mm).norm() > limit_mm) continue;
            const double there = lumen.radius_mm(q, radius + step * 1.001);
            if (there <= radius + 0.02 * step) continue;
            best = q;
            radius = there;
            is_better = true;
        }
        if (!is_better) step *= 0.5;
    }
    return best;
}

std::vector<Sphere> spaced(const Lumen &lumen, const Points &line_mm, double spacing)
{
    const double fine_mm = 0.5 * lumen.voxels().voxel_mm();
    const Points points = resampled(
        line_mm, [&](const Eigen::Vector3d &p) { return std::max(spacing * lumen.radius_mm(p), fine_mm); });
    std::vector<Sphere> spheres;
    for (const Eigen::Vector3d &p : points) spheres.push_back({p, std::max(lumen.radius_mm(p), 1e-3)});
    return spheres;
}

std::vector<Sphere> fit_line(const Lumen &lumen, const Points &way_mm, const LineWish &wish)
{
    const double voxel_mm = lumen.voxels().voxel_mm();
    Points line = resampled(way_mm, [&](const Eigen::Vector3d &) { return voxel_mm; });
    smooth(line, 0.5, 8);
    for (int turn = 0; turn < turns && length_of(line) > 0; ++turn) {
        line = resampled(line, [&](const Eigen::Vector3d &p) {
            return std::max(fine_spacing * lumen.radius_mm(p), 0.5 * voxel_mm);
        });
        const Points before = line;
        for (std::size_t i = 0; i < line.size(); ++i) {
            if ((i == 0 && wish.holds_first) || (i + 1 == line.size() && wish.holds_last)) continue;
            if (wish.parent && hull_place(*wish.parent, before[i]).distance_mm < 0) continue;
            const double radius = lumen.radius_mm(before[i]);
            line[i] = centred(lumen, before[i], direction_at(before, i, radius), reach_share * radius);
        }
        smooth(line, 0.5, turn + 1 < turns ? 3 : 1);
    }
    return spaced(lumen, line, wish.spacing);
}

} // namespace crn::centreline
