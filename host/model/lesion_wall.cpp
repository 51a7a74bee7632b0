#include "host/model/lesion_wall.hpp"
#include <algorithm>
#include <cmath>

namespace crn
{
namespace
{

using Eigen::Vector3d;

constexpr double unmoved_m = 1e-6;
constexpr int share_rounds = 24;

// Adds the stretches of a branch that may be nearer than the lesion to some part of the wall inside the box.
// Distances from a vessel are compared in radii of that vessel.
void add_near_stretches(const VesselBranch &branch, const Eigen::AlignedBox3d &reach_m,
                        std::vector<VesselBranch> &stretches)
{
    VesselBranch stretch;
    const auto end_stretch = [&] {
        if (stretch.points_m.size() >= 2) stretches.push_back(stretch);
        stretch.points_m.clear();
        stretch.radii_m.clear();
    };
    for (std::size_t i = 0; i + 1 < branch.points_m.size(); ++i) {
        Eigen::AlignedBox3d box;
        box.extend(branch.points_m[i]).extend(branch.points_m[i + 1]);
        const double widest_m = std::max(branch.radii_m[i], branch.radii_m[i + 1]);
        if (box.exteriorDistance(reach_m) > lesion_far_radii * widest_m) {
            end_stretch();
            continue;
        }
        if (stretch.points_m.empty()) {
            stretch.points_m.push_back(branch.points_m[i]);
            stretch.radii_m.push_back(branch.radii_m[i]);
        }
        stretch.points_m.push_back(branch.points_m[i + 1]);
        stretch.radii_m.push_back(branch.radii_m[i + 1]);
    }
    end_stretch();
}

} // namespace

VesselTree healthy_tree(const VesselTree &tree)
{
    VesselTree healthy = tree;
    for (const VesselLesion &lesion : tree.lesions) {
        VesselBranch &branch = healthy.branches[lesion.branch];
        const auto first = static_cast<std::ptrdiff_t>(lesion.first_point);
        std::copy(lesion.healthy_points_m.begin(), lesion.healthy_points_m.end(),
                  branch.points_m.begin() + first);
        std::copy(lesion.healthy_radii_m.begin(), lesion.healthy_radii_m.end(),
                  branch.radii_m.begin() + first);
    }
    return healthy;
}

Eigen::AlignedBox3d lesion_box_m(const VesselLesion &lesion, double radii)
{
    Eigen::AlignedBox3d box;
    for (std::size_t i = 0; i < lesion.size(); ++i) {
        const Vector3d margin = Vector3d::Constant(radii * lesion.healthy_radii_m[i]);
        box.extend(lesion.healthy_points_m[i] - margin).extend(lesion.healthy_points_m[i] + margin);
    }
    return box;
}

LesionWall::LesionWall(const VesselTree &tree, std::size_t index)
{
    const VesselLesion &lesion = tree.lesions[index];
    const VesselBranch &branch = tree.branches[lesion.branch];
    const auto first = static_cast<std::ptrdiff_t>(lesion.first_point),
               end = first + static_cast<std::ptrdiff_t>(lesion.size());
    healthy_m_ = lesion.healthy_points_m;
    healthy_radii_m_ = lesion.healthy_radii_m;
    channel_m_.assign(branch.points_m.begin() + first, branch.points_m.begin() + end);
    channel_radii_m_.assign(branch.radii_m.begin() + first, branch.radii_m.begin() + end);
    arcs_m_.push_back(0);
    for (std::size_t i = 1; i < healthy_m_.size(); ++i)
        arcs_m_.push_back(arcs_m_.back() + (healthy_m_[i] - healthy_m_[i - 1]).norm());
    reach_m_ = lesion_box_m(lesion, lesion_far_radii);
    const VesselTree healthy = healthy_tree(tree);
    for (std::size_t b = 0; b < healthy.branches.size(); ++b)
        if (b != lesion.branch) add_near_stretches(healthy.branches[b], reach_m_, others_);
}

LesionFoot LesionWall::foot(const Vector3d &place_m) const
{
    LesionFoot foot;
    double least_m = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i + 1 < healthy_m_.size(); ++i) {
        const Vector3d &a = healthy_m_[i], step = healthy_m_[i + 1] - a;
        const double share = std::clamp((place_m - a).dot(step) / step.squaredNorm(), 0.0, 1.0);
        const double distance_m = (place_m - a - share * step).norm();
        if (distance_m >= least_m) continue;
        least_m = distance_m;
        const auto mix = [share](double from, double to) { return from + share * (to - from); };
        const double healthy_m = mix(healthy_radii_m_[i], healthy_radii_m_[i + 1]);
        const double now_m = mix(channel_radii_m_[i], channel_radii_m_[i + 1]);
        foot = {distance_m / healthy_m,
                a + share * step,
                channel_m_[i] + share * (channel_m_[i + 1] - channel_m_[i]),
                healthy_m,
                now_m / healthy_m,
                mix(arcs_m_[i], arcs_m_[i + 1])};
    }
    return foot;
}

// Returns the fraction of the lesion's displacement that applies to a point of the wall. The fraction of the
// displacement is 1 near the vessel, and 0 far from the vessel or where the point is nearer to another
// vessel.
double LesionWall::share_of_way(const LesionFoot &foot, const Vector3d &place_m) const
{
    const double fade =
        std::clamp((lesion_far_radii - foot.radii) / (lesion_far_radii - lesion_near_radii), 0.0, 1.0);
    if (fade == 0) return 0;
    double others = std::numeric_limits<double>::infinity();
    for (const VesselBranch &other : others_) others = std::min(others, vessel_foot(other, place_m).radii);
    const double ahead = others - foot.radii;
    return fade * fade * (3 - 2 * fade) * std::clamp(1 + 2 * ahead, 0.0, 1.0);
}

Vector3d LesionWall::way_m(const Vector3d &healthy_m) const
{
    const LesionFoot at = foot(healthy_m);
    const Vector3d there = at.channel_m + at.left * (healthy_m - at.healthy_m);
    return share_of_way(at, healthy_m) * (there - healthy_m);
}

// Finds the healthy position of a point of the wall that has moved by a known fraction s of the lesion's
// displacement. Let v be the position that a point of the wall had in the healthy vessel. Let h be the point
// on the healthy centreline that is nearest to v. The lesion moved the point from v to x, near the point m =
// h + s (c - h), where h is a point of the healthy centreline, c is the point of the lesion's channel that
// belongs to h, and s is a fraction between 0 and 1. Perpendicular to the centreline, the vectors x - m
// (after the displacement) and v
// - h (before it) have the same direction. The point h of the centreline is therefore one at which the line
// from m to the moved point x is perpendicular to the centreline, or a corner at which this line is
// perpendicular to neither side. The healthy position is then v = h + (x - m) / (1 - s (1 - left)), where
// `left` is the radius of the channel divided by the healthy radius.
LesionWall::Healthy LesionWall::back(const Vector3d &narrowed_m, double share) const
{
    Healthy healthy{narrowed_m, 0};
    double least_m = std::numeric_limits<double>::infinity();
    bool was_beyond = true; // the end of the previous segment
    const std::size_t last = healthy_m_.size() - 2;
    for (std::size_t i = 0; i <= last; ++i) {
        const Vector3d step = healthy_m_[i + 1] - healthy_m_[i];
        const Vector3d m = healthy_m_[i] + share * (channel_m_[i] - healthy_m_[i]),
                       m_step = healthy_m_[i + 1] + share * (channel_m_[i + 1] - healthy_m_[i + 1]) - m;
        const double foot = (narrowed_m - m).dot(step) / m_step.dot(step), along = std::clamp(foot, 0.0, 1.0);
        const bool is_foot = foot < 0 ? was_beyond : foot <= 1 || i == last;
        was_beyond = foot > 1;
        const Vector3d from_m = narrowed_m - m - along * m_step;
        if (!is_foot || from_m.norm() >= least_m) continue;
        least_m = from_m.norm();
        const auto mix = [along](const std::vector<double> &values, std::size_t at) {
            return values[at] + along * (values[at + 1] - values[at]);
        };
        const double left = mix(channel_radii_m_, i) / mix(healthy_radii_m_, i);
        healthy.place_m = healthy_m_[i] + along * step + from_m / (1 - share * (1 - left));
        healthy.arc_m = mix(arcs_m_, i);
    }
    return healthy;
}

// The farther a point of the healthy wall was from the centreline, the smaller is the fraction s of the
// displacement by which it moved. Exactly one fraction s is therefore consistent with each narrowed position.
bool LesionWall::healthy_of(const Vector3d &narrowed_m, Healthy &healthy) const
{
    if (!reach_m_.contains(narrowed_m)) return false;
    const auto share_at = [this](const Vector3d &place_m) { return share_of_way(foot(place_m), place_m); };
    healthy = back(narrowed_m, 1);
    if (share_at(healthy.place_m) < 1) {
        double low = 0, high = 1;
        for (int round = 0; round < share_rounds; ++round) {
            const double share = 0.5 * (low + high);
            healthy = back(narrowed_m, share);
            (share_at(healthy.place_m) > share ? low : high) = share;
        }
    }
    return (healthy.place_m - narrowed_m).norm() >= unmoved_m;
}

} // namespace crn
