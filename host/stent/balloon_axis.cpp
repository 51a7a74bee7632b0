#include "host/stent/balloon_axis.hpp"
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace crn
{

namespace
{

using Eigen::Vector3d;

constexpr double shortest_mm = 1e-6;

// Returns the part of the vector `v` that is perpendicular to `tangent`, scaled to length 1. If that part is
// zero, the function returns any direction perpendicular to `tangent`.
Vector3d across_of(const Vector3d &v, const Vector3d &tangent)
{
    const Vector3d rest = v - v.dot(tangent) * tangent;
    if (rest.squaredNorm() > 1e-12) return rest.normalized();
    Eigen::Index least;
    tangent.cwiseAbs().minCoeff(&least);
    return tangent.cross(Vector3d::Unit(least)).normalized();
}

} // namespace

BalloonAxis::BalloonAxis(const BalloonPose &pose, const Vector3d &across)
{
    for (const BalloonPoint &point : pose.points) {
        if (!point.centre_mm.allFinite() || !std::isfinite(point.arc_mm) || !(point.radius_mm >= 0)) continue;
        if (!points_.empty() && (point.arc_mm <= points_.back().arc_mm ||
                                 (point.centre_mm - points_.back().centre_mm).norm() < shortest_mm))
            continue;
        points_.push_back(
            {point.arc_mm, point.radius_mm, point.room_mm, point.centre_mm, Vector3d::UnitX(), across});
    }
    if (!is_known()) return;
    for (std::size_t i = 0; i < points_.size(); ++i) {
        const Vector3d &before = points_[i > 0 ? i - 1 : i].centre_mm;
        const Vector3d &behind = points_[std::min(i + 1, points_.size() - 1)].centre_mm;
        const Vector3d way = behind - before;
        points_[i].tangent =
            way.squaredNorm() > 1e-12 ? way.normalized() : points_[i > 0 ? i - 1 : i].tangent;
        points_[i].across = across_of(i > 0 ? points_[i - 1].across : across, points_[i].tangent);
    }
}

BalloonAxis::Place BalloonAxis::at(double arc_mm) const
{
    const auto last = points_.size() - 2;
    std::size_t i = 0;
    while (i < last && arc_mm > points_[i + 1].arc_mm) ++i;
    const Station &a = points_[i], &b = points_[i + 1];
    const double share = (arc_mm - a.arc_mm) / (b.arc_mm - a.arc_mm), held = std::clamp(share, 0.0, 1.0);
    Place place;
    place.tangent = ((1 - held) * a.tangent + held * b.tangent).normalized();
    place.across = across_of((1 - held) * a.across + held * b.across, place.tangent);
    place.third = place.tangent.cross(place.across);
    place.centre_mm = (1 - held) * a.centre_mm + held * b.centre_mm;
    place.centre_mm += (share - held) * (b.arc_mm - a.arc_mm) * place.tangent;
    if (share != held) return place;
    place.radius_mm = (1 - held) * a.radius_mm + held * b.radius_mm;
    place.room_mm = std::min(a.room_mm, b.room_mm);
    return place;
}

double BalloonAxis::nearest_arc_mm(const Vector3d &place_mm, double &distance_mm) const
{
    double least = std::numeric_limits<double>::infinity(), arc = points_.front().arc_mm;
    for (std::size_t i = 1; i < points_.size(); ++i) {
        const Station &a = points_[i - 1], &b = points_[i];
        const Vector3d way = b.centre_mm - a.centre_mm;
        const double share = std::clamp((place_mm - a.centre_mm).dot(way) / way.squaredNorm(), 0.0, 1.0);
        const double squared = (a.centre_mm + share * way - place_mm).squaredNorm();
        if (squared >= least) continue;
        least = squared;
        arc = a.arc_mm + share * (b.arc_mm - a.arc_mm);
    }
    distance_mm = std::sqrt(least);
    return arc;
}

} // namespace crn
