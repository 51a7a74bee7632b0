#include "host/patient/pushed_vessels.hpp"
#include <algorithm>
#include <cmath>
#include <limits>

namespace crn
{

using Eigen::Vector3d;

namespace
{

constexpr double fade_m = 0.025, reach_m = 0.05; // at the reach, 2 % of the way are left
constexpr double seen_m = 20e-6;                 // shorter ways are not visible
constexpr double step_m = 2e-3;

} // namespace

PushedVessels::PushedVessels(const WireFrame &wire)
    : low_m_(Vector3d::Constant(std::numeric_limits<double>::infinity())), high_m_(-low_m_)
{
    double last_m = -step_m;
    bool is_seen = false;
    for (const WireNode &node : wire.nodes) {
        if (wire.walls.empty() || node.arc_m < last_m + step_m) continue;
        last_m = node.arc_m;
        const WallWay way = wall_way(wire, node.arc_m);
        const Vector3d rest_m = node.position_m - way.way_m;
        places_.push_back({rest_m, way.way_m});
        if (way.way_m.norm() < seen_m) continue;
        is_seen = true;
        low_m_ = low_m_.cwiseMin(rest_m - Vector3d::Constant(reach_m));
        high_m_ = high_m_.cwiseMax(rest_m + Vector3d::Constant(reach_m));
    }
    if (!is_seen) places_.clear();
}

Vector3d PushedVessels::way_m(const Vector3d &rest_m) const
{
    if (places_.empty() || (rest_m.array() < low_m_.array()).any() ||
        (rest_m.array() > high_m_.array()).any())
        return Vector3d::Zero();
    double least = std::numeric_limits<double>::infinity();
    Vector3d way_m = Vector3d::Zero();
    for (std::size_t i = 0; i < places_.size(); ++i) {
        const Place &from = places_[i], &to = places_[std::min(i + 1, places_.size() - 1)];
        const Vector3d edge_m = to.rest_m - from.rest_m;
        const double length = edge_m.squaredNorm();
        const double share =
            length > 0 ? std::clamp((rest_m - from.rest_m).dot(edge_m) / length, 0.0, 1.0) : 0.0;
        const double distance = (rest_m - from.rest_m - share * edge_m).squaredNorm();
        if (distance >= least) continue;
        least = distance;
        way_m = from.way_m + share * (to.way_m - from.way_m);
    }
    return std::exp(-least / (fade_m * fade_m)) * way_m;
}

void PushedVessels::push(std::span<SweptCurve> curves) const
{
    if (is_empty()) return;
    for (SweptCurve &curve : curves)
        for (SweptPoint &point : curve.points) point.at_m += way_m(point.at_m);
}

} // namespace crn
