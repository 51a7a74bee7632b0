// A level set holds the distances to the wall, bricks of 8^3 numbers give each voxel's neighbours, and
// Dijkstra's algorithm finds paths through the voxels.
#include "tools/centreline/fit/voxels.hpp"
#include "tools/bake/solid.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <queue>

namespace crn::centreline
{
namespace
{

struct Waiting {
    double cost;
    std::int32_t voxel;
    bool operator>(const Waiting &other) const
    {
        return cost != other.cost ? cost > other.cost : voxel > other.voxel;
    }
};

} // namespace

Voxels::Voxels(const bake::Mesh &closed, double voxel_mm)
    : voxel_mm_(voxel_mm), step_mm_{0, voxel_mm, voxel_mm * std::sqrt(2.0), voxel_mm * std::sqrt(3.0)}
{
    Eigen::AlignedBox3d box;
    for (const Eigen::Vector3d &v : closed.vertices_mm) box.extend(v);
    if (bake::volume_mm3(closed) / std::pow(voxel_mm, 3) > voxels_inside_max ||
        (box.sizes() / voxel_mm).array().ceil().prod() > bake::solid_voxels_max)
        throw Fault(closed.name + ": has too many voxels of " + std::to_string(voxel_mm) +
                    " mm: make --voxel-mm larger");
    const std::vector<mesh::InsideVoxel> inside = bake::inside_voxels(closed, voxel_mm);
    if (inside.empty())
        throw Fault(closed.name + ": has no inside at voxels of " + std::to_string(voxel_mm) +
                    " mm: make --voxel-mm smaller, or close the mesh");
    const auto cell_of = [](const mesh::InsideVoxel &voxel) {
        return Eigen::Array3i(voxel.cell[0], voxel.cell[1], voxel.cell[2]);
    };
    Eigen::Array3i high = cell_of(inside[0]);
    low_ = high;
    for (const mesh::InsideVoxel &voxel : inside) {
        low_ = low_.min(cell_of(voxel));
        high = high.max(cell_of(voxel));
    }
    bricks_ = (high - low_) / 8 + 1;
    brick_of_.assign(static_cast<std::size_t>(bricks_.cast<double>().prod()), -1);
    for (const mesh::InsideVoxel &voxel : inside) {
        const Eigen::Array3i cell = cell_of(voxel);
        const Eigen::Array3i local = cell - low_, b = local / 8, in = local - 8 * b;
        std::int32_t &brick = brick_of_[brick_index(b)];
        if (brick < 0) {
            brick = static_cast<std::int32_t>(brick_.size());
            brick_.emplace_back().fill(-1);
        }
        brick_[brick][in[0] + 8 * (in[1] + 8 * in[2])] = static_cast<std::int32_t>(cell_.size());
        cell_.push_back(cell);
        depth_mm_.push_back(voxel.depth_mm);
    }
}

Eigen::Vector3d Voxels::centre_mm(std::size_t voxel) const
{
    return cell_[voxel].cast<double>() * voxel_mm_;
}

long Voxels::nearest(const Eigen::Vector3d &p_mm, double reach_mm) const
{
    const Eigen::Array3i middle = (p_mm / voxel_mm_).array().round().cast<int>() - low_;
    const int reach = static_cast<int>(std::ceil(reach_mm / voxel_mm_));
    long best = -1;
    double best_mm = reach_mm;
    for (int z = -reach; z <= reach; ++z)
        for (int y = -reach; y <= reach; ++y)
            for (int x = -reach; x <= reach; ++x) {
                const long voxel = at(middle[0] + x, middle[1] + y, middle[2] + z);
                if (voxel < 0) continue;
                const double distance = (centre_mm(voxel) - p_mm).norm();
                if (distance <= best_mm) best_mm = distance, best = voxel;
            }
    return best;
}

std::size_t Voxels::middle_near(std::size_t voxel) const
{
    // On a path across the vessel the depth (distance to the wall) changes as fast as the path length. On a
    // path along the middle, the depth changes only where the vessel widens.
    constexpr double slope_min = 0.5;
    for (;;) {
        double steepest = slope_min;
        std::size_t next = voxel;
        each_neighbour(voxel, [&](std::size_t other, double distance_mm) {
            const double slope = (depth_mm_[other] - depth_mm_[voxel]) / distance_mm;
            if (slope > steepest) steepest = slope, next = other;
        });
        if (next == voxel) return voxel;
        voxel = next;
    }
}

std::vector<std::size_t> Ways::to(std::size_t voxel) const
{
    std::vector<std::size_t> way{voxel};
    while (from[way.back()] != static_cast<std::int32_t>(way.back()))
        way.push_back(static_cast<std::size_t>(from[way.back()]));
    std::reverse(way.begin(), way.end());
    return way;
}

Ways find_ways(const Voxels &voxels, const std::vector<std::size_t> &sources, long target)
{
    Ways ways;
    ways.from.assign(voxels.size(), -1);
    ways.source.assign(voxels.size(), -1);
    ways.length_mm.assign(voxels.size(), 0.0f);
    std::vector<double> cost(voxels.size(), INFINITY);
    std::vector<bool> is_done(voxels.size(), false);
    std::priority_queue<Waiting, std::vector<Waiting>, std::greater<>> waiting;
    for (std::size_t s = 0; s < sources.size(); ++s) {
        const auto source = static_cast<std::int32_t>(sources[s]);
        ways.from[source] = source;
        ways.source[source] = static_cast<std::int32_t>(s);
        cost[source] = 0;
        waiting.push({0.0, source});
    }
    const auto price = [&](std::size_t voxel) {
        // The middle of a voxel may lie exactly on the wall, where the cost of a path would be infinite.
        const double depth = std::max(voxels.depth_mm(voxel), 0.25 * voxels.voxel_mm());
        return 1 / (depth * depth);
    };
    std::size_t done = 0;
    while (!waiting.empty()) {
        const auto here = static_cast<std::size_t>(waiting.top().voxel);
        waiting.pop();
        if (is_done[here]) continue;
        is_done[here] = true;
        if (static_cast<long>(here) == target) break;
        if (++done % 16384 == 0 && bake::Progress::interrupted())
            throw Fault("interrupted: nothing was written");
        voxels.each_neighbour(here, [&](std::size_t other, double distance_mm) {
            const double through = cost[here] + distance_mm * (price(here) + price(other)) / 2;
            if (is_done[other] || through >= cost[other]) return;
            cost[other] = through;
            ways.from[other] = static_cast<std::int32_t>(here);
            ways.source[other] = ways.source[here];
            ways.length_mm[other] = ways.length_mm[here] + static_cast<float>(distance_mm);
            waiting.push({through, static_cast<std::int32_t>(other)});
        });
    }
    return ways;
}

} // namespace crn::centreline
