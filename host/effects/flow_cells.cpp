#include "host/effects/flow_cells.hpp"
#include "host/effects/small_flows.hpp"
#include "host/model/lesion_wall.hpp"
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace crn
{
namespace
{

using Eigen::Vector3d;

using std::numbers::pi;
constexpr double length_per_radius = 0.5, length_min_mm = 1.0, length_max_mm = 3.0;
constexpr double wall_shear_per_s = 500.0; // gives 1.75 Pa at 3.5 mPa s, about as in medium arteries

// Describes a branch as a polyline with the arc length of each point.
struct Line {
    const VesselBranch &branch;
    std::vector<double> arc_m;

    explicit Line(const VesselBranch &b) : branch(b), arc_m(b.points_m.size(), 0.0)
    {
        for (std::size_t i = 1; i < arc_m.size(); ++i)
            arc_m[i] = arc_m[i - 1] + (b.points_m[i] - b.points_m[i - 1]).norm();
    }
    double length_m() const { return arc_m.back(); }
    FlowCell::Place at(double arc) const
    {
        const auto after = std::upper_bound(arc_m.begin() + 1, arc_m.end() - 1, arc);
        const auto point = static_cast<std::size_t>(after - arc_m.begin()) - 1;
        return {point, std::clamp((arc - arc_m[point]) / (arc_m[point + 1] - arc_m[point]), 0.0, 1.0)};
    }
    double radius_m(double arc) const
    {
        const FlowCell::Place p = at(arc);
        return branch.radii_m[p.point] + p.share * (branch.radii_m[p.point + 1] - branch.radii_m[p.point]);
    }
};

Vector3d between(const std::vector<Vector3d> &points_m, const FlowCell::Place &place)
{
    return points_m[place.point] + place.share * (points_m[place.point + 1] - points_m[place.point]);
}

// Integrates along the part of a branch that a cell covers; the radius changes linearly from one point of the
// branch to the next. The function computes three quantities of that part of a vessel: its length, its volume
// (the integral of pi r^2 ds), and the integral of ds / r^4, which determines its flow resistance (r: radius,
// s: arc length).
void measure(FlowCell &cell, const VesselBranch &branch)
{
    double volume_mm3 = 0.0;
    cell.length_mm = cell.per_r4_mm3 = 0.0;
    for (std::size_t i = cell.first.point; i <= cell.last.point; ++i) {
        const double from = i == cell.first.point ? cell.first.share : 0.0;
        const double to = i == cell.last.point ? cell.last.share : 1.0;
        const double length = (to - from) * (branch.points_m[i + 1] - branch.points_m[i]).norm() * 1e3;
        const double step = branch.radii_m[i + 1] - branch.radii_m[i];
        const double a = (branch.radii_m[i] + from * step) * 1e3, b = (branch.radii_m[i] + to * step) * 1e3;
        const double mean_square = (a * a + a * b + b * b) / 3.0;
        cell.length_mm += length;
        volume_mm3 += pi * mean_square * length;
        cell.per_r4_mm3 += length * mean_square / (a * a * a * b * b * b);
    }
    cell.volume_ml = volume_mm3 * 1e-3;
    cell.radius_mm = std::sqrt(volume_mm3 / (pi * cell.length_mm));
}

constexpr std::size_t group_cells = 16;

double wanted_length_m(double radius_m)
{
    return std::clamp(length_per_radius * radius_m, length_min_mm * 1e-3, length_max_mm * 1e-3);
}

} // namespace

double murray_flow_ml_s(double radius_mm)
{
    return pi / 4.0 * wall_shear_per_s * radius_mm * radius_mm * radius_mm * 1e-3;
}

FlowCells::FlowCells(const VesselTree &tree)
{
    const VesselTree healthy = healthy_tree(tree);
    for (std::size_t b = 0; b < tree.branches.size(); ++b) {
        branch_begin_.push_back(cells_.size());
        points_m_.push_back(tree.branches[b].points_m);
        cut(tree, b, healthy.branches[b]);
    }
    branch_begin_.push_back(cells_.size());
    feed_small_vessels(tree);
    for (const VesselLesion &lesion : tree.lesions) throats_.push_back(throat_of(tree, lesion));
    find_middles();
}

void FlowCells::cut(const VesselTree &tree, std::size_t index, const VesselBranch &healthy)
{
    const VesselBranch &branch = tree.branches[index];
    const Line line(branch);
    const double begin_m = vessel_start_m(tree, index), length_m = line.length_m() - begin_m;
    // The faces between cells are first placed at the wanted distances. After the faces between cells have
    // been placed, the distances between them are stretched so that the last face is at the end of the
    // branch.
    std::vector<double> faces_m = {0.0};
    while (faces_m.back() < length_m)
        faces_m.push_back(faces_m.back() + wanted_length_m(line.radius_m(
                                               std::min(begin_m + faces_m.back(), line.length_m()))));
    const double stretch = length_m / faces_m.back();
    for (std::size_t i = 0; i + 1 < faces_m.size(); ++i) {
        const double a_m = begin_m + stretch * faces_m[i], b_m = begin_m + stretch * faces_m[i + 1];
        FlowCell cell;
        cell.branch = static_cast<int>(index);
        cell.upstream = static_cast<int>(cells_.size()) - 1;
        cell.bed = branch.bed;
        cell.first = line.at(a_m);
        cell.middle = line.at(0.5 * (a_m + b_m));
        cell.last = line.at(b_m);
        measure(cell, healthy);
        cell.healthy_per_r4_mm3 = cell.per_r4_mm3;
        measure(cell, branch);
        cells_.push_back(cell);
    }
    FlowCell &first = cells_[branch_begin_[index]];
    if (branch.parent >= 0) { // fed by the parent's cell at the place where the branch leaves it
        const auto parent = static_cast<std::size_t>(branch.parent);
        first.upstream = static_cast<int>(cell_at_point(parent, branch.parent_point));
    } else {
        first.upstream = -1;
    }
    if (!tree.is_outlet(index)) return;
    cells_.back().end_ml_s =
        branch.flow_ml_s > 0.0 ? branch.flow_ml_s : murray_flow_ml_s(cells_.back().radius_mm);
}

std::size_t FlowCells::cell_at_point(std::size_t branch, std::size_t point) const
{
    std::size_t cell = branch_begin_[branch];
    while (cell + 1 < branch_begin_[branch + 1] && cells_[cell].last.point < point) ++cell;
    return cell;
}

// The small vessels that leave a cell take their flow from it, and the bed behind the branch's end gets what
// is left of the branch's own flow. A remainder below a hundredth is rounding, and counts as nothing. So does
// the flow of an end that a small vessel continues.
void FlowCells::feed_small_vessels(const VesselTree &tree)
{
    constexpr double rounding_share = 0.01;
    const std::vector<double> flows_ml_s = small_vessel_flows_ml_s(tree);
    for (std::size_t v = 0; v < tree.small.size(); ++v) {
        const VesselBranch &vessel = tree.small[v];
        if (vessel.is_vein || static_cast<std::size_t>(vessel.parent) >= tree.branches.size()) continue;
        const auto branch = static_cast<std::size_t>(vessel.parent);
        FlowCell &end = cells_[branch_begin_[branch + 1] - 1];
        if (tree.is_outlet(branch)) {
            const double whole = tree.branches[branch].flow_ml_s;
            const bool continues = vessel.parent_point + 1 == tree.branches[branch].points_m.size();
            end.end_ml_s -= flows_ml_s[v];
            if (end.end_ml_s < rounding_share * whole || (continues && !(whole > 0.0))) end.end_ml_s = 0.0;
        }
        cells_[cell_at_point(branch, vessel.parent_point)].small_ml_s += flows_ml_s[v];
    }
    for (FlowCell &cell : cells_) cell.outlet_ml_s = cell.end_ml_s + cell.small_ml_s;
}

// If the narrowest point of a lesion lies before the first cell of the branch, the lesion narrows this first
// cell.
FlowThroat FlowCells::throat_of(const VesselTree &tree, const VesselLesion &lesion) const
{
    const std::size_t point = tree.throat(lesion), end = branch_begin_[lesion.branch + 1];
    FlowThroat throat;
    throat.cell = branch_begin_[lesion.branch];
    while (throat.cell + 1 < end && cells_[throat.cell].last.point < point) ++throat.cell;
    throat.radius_mm = tree.branches[lesion.branch].radii_m[point] * 1e3;
    throat.healthy_radius_mm = lesion.healthy_radii_m[point - lesion.first_point] * 1e3;
    throat.behind = throat.cell;
    while (throat.behind + 1 < end &&
           cells_[throat.behind].first.point < lesion.first_point + lesion.size() - 1)
        ++throat.behind;
    return throat;
}

Eigen::Vector3d FlowCells::at(std::size_t cell, const FlowCell::Place &place) const
{
    return between(points_m_[static_cast<std::size_t>(cells_[cell].branch)], place);
}

bool FlowCells::is_alike(const VesselTree &tree) const
{
    if (tree.branches.size() != points_m_.size() || tree.lesions.size() != throats_.size()) return false;
    for (std::size_t b = 0; b < points_m_.size(); ++b)
        if (tree.branches[b].points_m.size() != points_m_[b].size()) return false;
    return true;
}

void FlowCells::reshape(const VesselTree &opened)
{
    if (!is_alike(opened)) return;
    for (std::size_t k = 0; k < opened.lesions.size(); ++k) {
        const VesselLesion &lesion = opened.lesions[k];
        for (std::size_t i = branch_begin_[lesion.branch]; i < branch_begin_[lesion.branch + 1]; ++i)
            measure(cells_[i], opened.branches[lesion.branch]);
        throats_[k] = throat_of(opened, lesion);
    }
    place(opened);
}

void FlowCells::place(const VesselTree &moved)
{
    if (!is_alike(moved)) return;
    for (std::size_t b = 0; b < points_m_.size(); ++b) points_m_[b] = moved.branches[b].points_m;
    find_middles();
}

void FlowCells::find_middles()
{
    middle_m_.resize(cells_.size());
    groups_.clear();
    for (std::size_t i = 0; i < cells_.size(); ++i) middle_m_[i] = at(i, cells_[i].middle);
    for (std::size_t begin = 0; begin < cells_.size(); begin += group_cells) {
        const std::size_t end = std::min(begin + group_cells, cells_.size());
        Group group{begin, end, 0.5 * (middle_m_[begin] + middle_m_[end - 1]), 0.0};
        for (std::size_t i = begin; i < end; ++i)
            group.reach_m =
                std::max(group.reach_m, (middle_m_[i] - group.middle_m).norm() + cells_[i].radius_mm * 1e-3);
        groups_.push_back(group);
    }
}

// If the smallest power distance so far is f^2, a cell with a smaller one lies within f + r, where r is the
// radius of the cell: p^2 < f^2 + r^2 <= (f + r)^2. Groups that lie farther away need no search. Of cells
// with equal power distances, the first is found.
std::size_t FlowCells::nearest(const Eigen::Vector3d &place_m) const
{
    if (groups_.empty()) return 0;
    auto square = [&](const Group &group) { return (place_m - group.middle_m).squaredNorm(); };
    std::size_t first = 0;
    for (std::size_t i = 1; i < groups_.size(); ++i)
        if (square(groups_[i]) < square(groups_[first])) first = i;
    return nearest(place_m, groups_[first].begin);
}

std::size_t FlowCells::nearest(const Eigen::Vector3d &place_m, std::size_t guess) const
{
    constexpr double margin_m = 1e-6; // far more than all rounding errors
    std::size_t best = cells_.size();
    double least = std::numeric_limits<double>::infinity(), reach_m = least;
    auto search = [&](const Group &group) {
        for (std::size_t i = group.begin; i < group.end; ++i) {
            const double radius_m = cells_[i].radius_mm * 1e-3;
            const double power = (place_m - middle_m_[i]).squaredNorm() - radius_m * radius_m;
            if (!(power < least || (power == least && i < best))) continue;
            least = power;
            best = i;
        }
        reach_m = std::sqrt(std::max(least, 0.0)) + margin_m;
    };
    const std::size_t first = guess / group_cells;
    if (first < groups_.size()) search(groups_[first]);
    for (std::size_t i = 0; i < groups_.size(); ++i) {
        const double within_m = groups_[i].reach_m + reach_m;
        if (i == first || (place_m - groups_[i].middle_m).squaredNorm() > within_m * within_m) continue;
        search(groups_[i]);
    }
    return best < cells_.size() ? best : 0;
}

} // namespace crn
