#include "host/stent/vessel_wall.hpp"
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>

namespace crn
{

namespace
{

using Eigen::Vector3d;

constexpr std::size_t around = 24; // vertices of a row: facets cut off 0.9 % of the circle's radius
constexpr double row_mm = 0.5;     // from row to row

// Describes a vessel branch with and without its lesions; both shapes are functions of the distance along the
// healthy branch, in mm.
struct Line {
    std::vector<double> along_mm;
    std::vector<Vector3d> healthy_m, narrow_m;
    std::vector<double> healthy_radius_m, narrow_radius_m;
    std::vector<std::ptrdiff_t> lesion;
};

Line line_of(const VesselTree &tree, std::size_t index)
{
    const VesselBranch &branch = tree.branches[index];
    Line line{{}, branch.points_m, branch.points_m, branch.radii_m, branch.radii_m, {}};
    line.lesion.assign(branch.points_m.size(), -1);
    for (std::size_t k = 0; k < tree.lesions.size(); ++k) {
        const VesselLesion &lesion = tree.lesions[k];
        if (lesion.branch != index) continue;
        for (std::size_t i = 0; i < lesion.size(); ++i) {
            const std::size_t point = lesion.first_point + i;
            line.healthy_m[point] = lesion.healthy_points_m[i];
            line.healthy_radius_m[point] = lesion.healthy_radii_m[i];
            line.lesion[point] = static_cast<std::ptrdiff_t>(k);
        }
    }
    line.along_mm.push_back(0.0);
    for (std::size_t i = 1; i < line.healthy_m.size(); ++i)
        line.along_mm.push_back(line.along_mm.back() +
                                (line.healthy_m[i] - line.healthy_m[i - 1]).norm() * 1e3);
    return line;
}

} // namespace

std::vector<VesselWall::Row> VesselWall::rows_of(const VesselTree &tree, std::size_t branch, double from_mm,
                                                 double to_mm)
{
    if (branch >= tree.branches.size())
        throw std::invalid_argument("a stent's vessel: the tree has no such branch");
    const Line line = line_of(tree, branch);
    from_mm =
        std::max(from_mm, vessel_start_m(tree, branch) * 1e3); // its parent's lumen has no wall at the ostium
    to_mm = std::min(to_mm, line.along_mm.back());
    if (!(to_mm - from_mm >= 2 * row_mm))
        throw std::invalid_argument("a stent's vessel: the stretch is not in " + tree.branches[branch].name);
    const auto count = static_cast<std::size_t>(std::ceil((to_mm - from_mm) / row_mm)) + 1;
    std::vector<Row> rows;
    std::size_t i = 0;
    for (std::size_t k = 0; k < count; ++k) {
        const double along =
            from_mm + (to_mm - from_mm) * static_cast<double>(k) / static_cast<double>(count - 1);
        while (i + 2 < line.along_mm.size() && along > line.along_mm[i + 1]) ++i;
        const double share =
            std::clamp((along - line.along_mm[i]) / (line.along_mm[i + 1] - line.along_mm[i]), 0.0, 1.0);
        const auto between = [&](const auto &values) {
            return (1 - share) * values[i] + share * values[i + 1];
        };
        rows.push_back({between(line.narrow_m), between(line.healthy_m), between(line.narrow_radius_m),
                        between(line.healthy_radius_m), along, std::max(line.lesion[i], line.lesion[i + 1])});
    }
    return rows;
}

std::vector<WallTriangle> VesselWall::triangles_of(std::size_t rows)
{
    std::vector<WallTriangle> triangles;
    for (std::size_t row = 0; row + 1 < rows; ++row)
        for (std::size_t k = 0; k < around; ++k) {
            const auto a = static_cast<std::uint32_t>(row * around + k);
            const auto b = static_cast<std::uint32_t>(row * around + (k + 1) % around);
            constexpr auto next = static_cast<std::uint32_t>(around);
            // Every second row of vertices is shifted by half a step around the tube, so that triangles have
            // no long edges.
            if (row % 2 == 0) {
                triangles.push_back({a, b, a + next});
                triangles.push_back({b, b + next, a + next});
            } else {
                triangles.push_back({a, b + next, a + next});
                triangles.push_back({a, b, b + next});
            }
        }
    return triangles;
}

// The middles of the tube's facets lie on a circle with the vessel's radius. The directions in which the
// vertices of a row lie follow the centreline without twist.
void VesselWall::add_points(const std::vector<Row> &rows, const Motion *motion)
{
    const double out = 1 / std::cos(std::numbers::pi / around);
    Vector3d across = Vector3d::UnitX();
    for (std::size_t row = 0; row < rows.size(); ++row) {
        const Vector3d way =
            rows[std::min(row + 1, rows.size() - 1)].healthy_m - rows[row > 0 ? row - 1 : 0].healthy_m;
        const Vector3d tangent = way.normalized();
        if (row == 0 && std::abs(tangent.x()) > 0.9) across = Vector3d::UnitY();
        across = (across - across.dot(tangent) * tangent).normalized();
        const Vector3d third = tangent.cross(across);
        for (std::size_t k = 0; k < around; ++k) {
            const double angle =
                2 * std::numbers::pi * (static_cast<double>(k) + 0.5 * static_cast<double>(row % 2)) / around;
            const Vector3d from = out * (std::cos(angle) * across + std::sin(angle) * third);
            narrow_m_.push_back(rows[row].narrow_m + rows[row].narrow_radius_m * from);
            healthy_m_.push_back(rows[row].healthy_m + rows[row].healthy_radius_m * from);
        }
    }
    for (const Row &row : rows) {
        narrow_m_.push_back(row.narrow_m);
        healthy_m_.push_back(row.healthy_m);
    }
    if (!motion) return;
    narrow_ways_.emplace(*motion, narrow_m_);
    healthy_ways_.emplace(*motion, healthy_m_);
}

VesselWall::VesselWall(const VesselTree &tree, std::size_t branch, double from_mm, double to_mm,
                       const Motion *motion)
    : rows_(rows_of(tree, branch, from_mm, to_mm)), wall_(triangles_of(rows_.size()), rows_.size() * around)
{
    for (const Row &row : rows_) healthy_radius_mm_.push_back(row.healthy_radius_m * 1e3);
    const Line line = line_of(tree, branch);
    lesions_.resize(tree.lesions.size());
    for (std::size_t k = 0; k < tree.lesions.size(); ++k)
        if (tree.lesions[k].branch == branch)
            lesions_[k] = {line.along_mm[tree.lesions[k].first_point],
                           line.along_mm[tree.lesions[k].first_point + tree.lesions[k].size() - 1]};
    places_ = lesions_;
    add_points(rows_, motion);
    vertices_um_.resize(rows_.size() * around);
    line_mm_.resize(rows_.size());
    radius_mm_.resize(rows_.size());
    move({});
}

Vector3d VesselWall::at_m(std::size_t point, std::size_t row, double share,
                          const MotionWeights &weights) const
{
    Vector3d place = healthy_m_[point];
    if (rows_[row].lesion < 0) {
        if (healthy_ways_) place += healthy_ways_->way_um(point, weights).cast<double>() * 1e-6;
        return place;
    }
    place = narrow_m_[point] + share * (healthy_m_[point] - narrow_m_[point]);
    if (!narrow_ways_) return place;
    const Vector3d narrow = narrow_ways_->way_um(point, weights).cast<double>();
    const Vector3d healthy = healthy_ways_->way_um(point, weights).cast<double>();
    return place + (narrow + share * (healthy - narrow)) * 1e-6;
}

// Interpolates linearly between the positions for which the list `opened` of a lesion has values.
double VesselWall::opened_at(std::size_t row, std::span<const std::vector<double>> opened) const
{
    const Row &at = rows_[row];
    const auto lesion = static_cast<std::size_t>(std::max<std::ptrdiff_t>(at.lesion, 0));
    if (at.lesion < 0 || lesion >= opened.size() || opened[lesion].empty()) return 0.0;
    const std::vector<double> &list = opened[lesion];
    if (list.size() == 1) return list.front();
    const Stretch &stretch = places_[lesion];
    const double last = static_cast<double>(list.size() - 1);
    const double place =
        std::clamp((at.along_mm - stretch.from_mm) / (stretch.to_mm - stretch.from_mm), 0.0, 1.0) * last;
    const std::size_t i = std::min(static_cast<std::size_t>(place), list.size() - 2);
    const double share = place - static_cast<double>(i);
    return (1 - share) * list[i] + share * list[i + 1];
}

void VesselWall::move(const MotionMoment &moment, std::span<const std::vector<double>> opened)
{
    const MotionWeights weights = motion_weights(moment);
    for (std::size_t row = 0; row < rows_.size(); ++row) {
        const double share = opened_at(row, opened);
        for (std::size_t k = 0; k < around; ++k) {
            const Vector3d place_um = at_m(row * around + k, row, share, weights) * 1e6;
            vertices_um_[row * around + k] = place_um.array().round().matrix().cast<int>();
        }
        line_mm_[row] = at_m(rows_.size() * around + row, row, share, weights) * 1e3;
        const Row &at = rows_[row];
        radius_mm_[row] = (at.narrow_radius_m + share * (at.healthy_radius_m - at.narrow_radius_m)) * 1e3;
    }
    wall_.move(vertices_um_);
}

void VesselWall::set_places(std::size_t lesion, double span_mm)
{
    if (lesion_mm(lesion).is_empty()) return;
    const double middle = (lesions_[lesion].from_mm + lesions_[lesion].to_mm) / 2;
    places_[lesion] = {middle - span_mm / 2, middle + span_mm / 2};
}

double VesselWall::narrow_radius_mm(double along_mm) const
{
    const auto [row, share] = row_at(along_mm);
    return ((1 - share) * rows_[row].narrow_radius_m + share * rows_[row + 1].narrow_radius_m) * 1e3;
}

double VesselWall::healthy_radius_mm(double along_mm) const
{
    const auto [row, share] = row_at(along_mm);
    return (1 - share) * healthy_radius_mm_[row] + share * healthy_radius_mm_[row + 1];
}

double VesselWall::radius_at_mm(double along_mm) const
{
    const auto [row, share] = row_at(along_mm);
    return (1 - share) * radius_mm_[row] + share * radius_mm_[row + 1];
}

std::pair<std::size_t, double> VesselWall::row_at(double along_mm) const
{
    std::size_t row = 0;
    while (row + 2 < rows_.size() && along_mm > rows_[row + 1].along_mm) ++row;
    const double step = rows_[row + 1].along_mm - rows_[row].along_mm;
    return {row, std::clamp((along_mm - rows_[row].along_mm) / step, 0.0, 1.0)};
}

VesselWall::Foot VesselWall::foot_of(const Vector3d &place_mm) const
{
    double least = std::numeric_limits<double>::infinity(), along = 0.0;
    for (std::size_t row = 0; row + 1 < rows_.size(); ++row) {
        const Vector3d way = line_mm_[row + 1] - line_mm_[row];
        const double share = std::clamp((place_mm - line_mm_[row]).dot(way) / way.squaredNorm(), 0.0, 1.0);
        const double squared = (line_mm_[row] + share * way - place_mm).squaredNorm();
        if (squared >= least) continue;
        least = squared;
        along = (1 - share) * rows_[row].along_mm + share * rows_[row + 1].along_mm;
    }
    return {along, std::sqrt(least)};
}

} // namespace crn
