#include "host/stent/wall.hpp"
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace crn
{

using Eigen::Vector3d;

StentWall::StentWall(std::span<const WallTriangle> triangles, std::size_t vertex_count)
    : vertices_mm_(vertex_count, Vector3d::Zero()), fan_begin_(vertex_count + 1, 0)
{
    for (const WallTriangle &triangle : triangles)
        if (std::all_of(triangle.begin(), triangle.end(), [&](std::uint32_t v) { return v < vertex_count; }))
            triangles_.push_back(triangle);
    for (const WallTriangle &triangle : triangles_)
        for (std::uint32_t vertex : triangle) ++fan_begin_[vertex + 1];
    for (std::size_t i = 0; i < vertex_count; ++i) fan_begin_[i + 1] += fan_begin_[i];
    fan_.resize(3 * triangles_.size());
    std::vector<std::uint32_t> next(fan_begin_.begin(), fan_begin_.end() - 1);
    for (std::size_t i = 0; i < triangles_.size(); ++i)
        for (std::uint32_t vertex : triangles_[i]) fan_[next[vertex]++] = static_cast<std::uint32_t>(i);
}

void StentWall::move(std::span<const Eigen::Vector3i> vertices_um)
{
    if (vertices_um.size() != vertices_mm_.size()) return;
    for (std::size_t i = 0; i < vertices_um.size(); ++i)
        vertices_mm_[i] = vertices_um[i].cast<double>() * 1e-3;
    is_placed_ = true;
}

Vector3d StentWall::normal(std::size_t triangle) const
{
    const Vector3d &a = corner_mm(triangle, 0);
    const Vector3d n = (corner_mm(triangle, 1) - a).cross(corner_mm(triangle, 2) - a);
    const double length = n.norm();
    return length > 1e-12 ? Vector3d(n / length) : Vector3d::Zero();
}

Vector3d StentWall::on_plane(const WallFoot &foot) const
{
    const auto t = static_cast<std::size_t>(foot.triangle);
    return (1 - foot.u - foot.v) * corner_mm(t, 0) + foot.u * corner_mm(t, 1) + foot.v * corner_mm(t, 2);
}

Vector3d StentWall::place(const WallFoot &foot) const
{
    return on_plane(foot) - foot.height_mm * normal(static_cast<std::size_t>(foot.triangle));
}

// Finds the closest point of a triangle by testing the regions of its corners, edges and face (Ericson,
// Real-Time Collision Detection, 5.1.5).
StentWall::Closest StentWall::closest(const Vector3d &p, std::size_t triangle) const
{
    const Vector3d &a = corner_mm(triangle, 0), &b = corner_mm(triangle, 1), &c = corner_mm(triangle, 2);
    const Vector3d ab = b - a, ac = c - a, ap = p - a, bp = p - b, cp = p - c;
    const auto at = [&](double u, double v, bool inside) {
        return Closest{(ap - u * ab - v * ac).squaredNorm(), inside};
    };
    const double d1 = ab.dot(ap), d2 = ac.dot(ap);
    if (d1 <= 0 && d2 <= 0) return at(0, 0, false);
    const double d3 = ab.dot(bp), d4 = ac.dot(bp);
    if (d3 >= 0 && d4 <= d3) return at(1, 0, false);
    const double vc = d1 * d4 - d3 * d2;
    if (vc <= 0 && d1 >= 0 && d3 <= 0) return at(d1 / (d1 - d3), 0, false);
    const double d5 = ab.dot(cp), d6 = ac.dot(cp);
    if (d6 >= 0 && d5 <= d6) return at(0, 1, false);
    const double vb = d5 * d2 - d1 * d6;
    if (vb <= 0 && d2 >= 0 && d6 <= 0) return at(0, d2 / (d2 - d6), false);
    const double va = d3 * d6 - d5 * d4, along = d4 - d3, back = d5 - d6;
    if (va <= 0 && along >= 0 && back >= 0)
        return at(1 - along / (along + back), along / (along + back), false);
    const double sum = va + vb + vc;
    return sum > 0 ? at(vb / sum, vc / sum, true) : at(0, 0, false);
}

WallFoot StentWall::foot(const Vector3d &place_mm, std::size_t triangle, const Closest &at) const
{
    const Vector3d &a = corner_mm(triangle, 0);
    const Vector3d ab = corner_mm(triangle, 1) - a, ac = corner_mm(triangle, 2) - a, ap = place_mm - a;
    const Vector3d n = ab.cross(ac);
    const double area2 = std::max(n.squaredNorm(), 1e-24);
    WallFoot result{static_cast<std::int32_t>(triangle), ap.cross(ac).dot(n) / area2,
                    ab.cross(ap).dot(n) / area2};
    result.height_mm = -ap.dot(n) / std::sqrt(area2);
    result.distance_mm = std::copysign(std::sqrt(at.squared), result.height_mm);
    return result;
}

WallFoot StentWall::walk(const Vector3d &place_mm, std::int32_t from) const
{
    constexpr int steps_max = 64;
    if (from < 0 || static_cast<std::size_t>(from) >= triangles_.size()) return {};
    auto best = static_cast<std::size_t>(from);
    Closest at = closest(place_mm, best);
    for (int step = 0; step < steps_max && !at.is_inside; ++step) {
        std::size_t next = best;
        Closest next_at = at;
        for (std::uint32_t vertex : triangles_[best])
            for (std::uint32_t k = fan_begin_[vertex]; k < fan_begin_[vertex + 1]; ++k) {
                const Closest candidate = closest(place_mm, fan_[k]);
                // At equal distances, the function prefers a point inside a triangle's face to a point on the
                // edge of a neighbouring triangle.
                const bool is_nearer = candidate.squared < next_at.squared - 1e-12;
                const bool is_as_near = candidate.squared <= next_at.squared + 1e-12;
                if (!is_nearer && !(is_as_near && candidate.is_inside && !next_at.is_inside)) continue;
                next = fan_[k];
                next_at = candidate;
            }
        if (next == best) break;
        best = next;
        at = next_at;
    }
    return foot(place_mm, best, at);
}

WallFoot StentWall::nearest(const Vector3d &place_mm, std::span<const std::uint32_t> among,
                            double reach_mm) const
{
    double least = reach_mm * reach_mm;
    std::int32_t found = -1;
    for (std::uint32_t triangle : among) {
        const double squared = closest(place_mm, triangle).squared;
        if (squared >= least) continue;
        least = squared;
        found = static_cast<std::int32_t>(triangle);
    }
    return walk(place_mm, found);
}

std::vector<std::uint32_t> StentWall::near(std::span<const Vector3d> places_mm, double reach_mm) const
{
    std::vector<std::uint32_t> result;
    if (places_mm.empty()) return result;
    Vector3d low = places_mm[0], high = places_mm[0];
    for (const Vector3d &place : places_mm) {
        low = low.cwiseMin(place);
        high = high.cwiseMax(place);
    }
    low.array() -= reach_mm;
    high.array() += reach_mm;
    for (std::size_t i = 0; i < triangles_.size(); ++i) {
        const Vector3d &a = corner_mm(i, 0), &b = corner_mm(i, 1), &c = corner_mm(i, 2);
        if ((a.cwiseMax(b).cwiseMax(c).array() < low.array()).any() ||
            (a.cwiseMin(b).cwiseMin(c).array() > high.array()).any())
            continue;
        for (const Vector3d &place : places_mm)
            if (closest(place, i).squared < reach_mm * reach_mm) {
                result.push_back(static_cast<std::uint32_t>(i));
                break;
            }
    }
    return result;
}

// --- grid ---

namespace
{

constexpr double cell_mm = 1.0;
constexpr int cells_max = 128; // along an axis: enough for a stent of 80 mm

} // namespace

std::array<int, 3> WallGrid::cell_of(const Vector3d &place_mm) const
{
    std::array<int, 3> cell{};
    for (std::size_t k = 0; k < 3; ++k) {
        const auto axis = static_cast<Eigen::Index>(k);
        const double at = std::floor((place_mm[axis] - low_mm_[axis]) / cell_mm);
        cell[k] = static_cast<int>(std::clamp(at, 0.0, count_[k] - 1.0));
    }
    return cell;
}

void WallGrid::build(const StentWall &wall, std::span<const std::uint32_t> patch, const Vector3d &low_mm,
                     const Vector3d &high_mm)
{
    low_mm_ = low_mm;
    for (std::size_t k = 0; k < 3; ++k) {
        const auto axis = static_cast<Eigen::Index>(k);
        count_[k] = static_cast<int>(
            std::clamp(std::ceil((high_mm[axis] - low_mm[axis]) / cell_mm), 1.0, double(cells_max)));
    }
    boxes_.clear();
    for (std::uint32_t k = 0; k < patch.size(); ++k) {
        const Vector3d &a = wall.corner_mm(patch[k], 0), &b = wall.corner_mm(patch[k], 1),
                       &c = wall.corner_mm(patch[k], 2);
        const Vector3d low = a.cwiseMin(b).cwiseMin(c), high = a.cwiseMax(b).cwiseMax(c);
        if ((high.array() < low_mm.array()).any() || (low.array() > high_mm.array()).any()) continue;
        boxes_.push_back({low.cast<float>(), high.cast<float>(), k});
    }
    const auto cells = static_cast<std::size_t>(count_[0] * count_[1] * count_[2]);
    const auto for_cells = [&](const Box &box, auto &&visit) {
        const std::array<int, 3> from = cell_of(box.low.cast<double>()),
                                 to = cell_of(box.high.cast<double>());
        for (int z = from[2]; z <= to[2]; ++z)
            for (int y = from[1]; y <= to[1]; ++y)
                for (int x = from[0]; x <= to[0]; ++x)
                    visit(static_cast<std::size_t>((z * count_[1] + y) * count_[0] + x));
    };
    begin_.assign(cells + 1, 0);
    for (const Box &box : boxes_) for_cells(box, [&](std::size_t cell) { ++begin_[cell + 1]; });
    for (std::size_t i = 0; i < cells; ++i) begin_[i + 1] += begin_[i];
    items_.resize(begin_.back());
    for (std::size_t i = boxes_.size(); i-- > 0;) // backwards, so that each cell's list ascends
        for_cells(boxes_[i],
                  [&](std::size_t cell) { items_[--begin_[cell + 1]] = static_cast<std::uint32_t>(i); });
    begin_.erase(begin_.begin()); // the former ends are now the begins
    begin_.push_back(static_cast<std::uint32_t>(items_.size()));
    seen_.assign(boxes_.size(), 0);
    round_ = 0;
}

void WallGrid::query(const Vector3d &low_mm, const Vector3d &high_mm, std::vector<std::uint32_t> &found)
{
    if (boxes_.empty()) return;
    ++round_;
    const std::array<int, 3> from = cell_of(low_mm), to = cell_of(high_mm);
    const Eigen::Vector3f low = low_mm.cast<float>(), high = high_mm.cast<float>();
    for (int z = from[2]; z <= to[2]; ++z)
        for (int y = from[1]; y <= to[1]; ++y)
            for (int x = from[0]; x <= to[0]; ++x) {
                const auto cell = static_cast<std::size_t>((z * count_[1] + y) * count_[0] + x);
                for (std::uint32_t k = begin_[cell]; k < begin_[cell + 1]; ++k) {
                    const std::uint32_t item = items_[k];
                    if (seen_[item] == round_) continue;
                    seen_[item] = round_;
                    const Box &box = boxes_[item];
                    if ((box.high.array() < low.array()).any() || (box.low.array() > high.array()).any())
                        continue;
                    found.push_back(box.index);
                }
            }
}

} // namespace crn
