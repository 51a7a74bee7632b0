#include "host/patient/tool_balls.hpp"
#include "host/model/wire_place.hpp"
#include <algorithm>

namespace crn
{

using Eigen::Vector3d;

constexpr double ball_step_m = 2e-3; // between places of a tool that narrow the lumen

bool has_lumen(const Instrument &tool)
{
    return tool.table.knots_count > 0 && tool.table.knots[0].radius_inner_um > 0;
}

Vector3d place_at(const WireFrame &wire, double arc_m)
{
    if (arc_m < wire.nodes.front().arc_m) return wire.nodes.front().position_m;
    if (arc_m >= wire.nodes.back().arc_m) return wire.nodes.back().position_m;
    return line_place_m(wire, arc_m);
}

std::vector<ToolBall> balls_of(const WireFrame &wire)
{
    std::vector<ToolBall> balls;
    for (std::size_t i = 0; i + 1 < wire.nodes.size(); ++i) {
        const WireNode &from = wire.nodes[i], &to = wire.nodes[i + 1];
        const double length_m = (to.position_m - from.position_m).norm();
        const int pieces = std::clamp(static_cast<int>(length_m / ball_step_m), 0, 50) + 1;
        for (int k = 0; k < pieces; ++k)
            balls.push_back(
                {from.position_m + (static_cast<double>(k) / pieces) * (to.position_m - from.position_m),
                 from.radius_m});
    }
    for (std::size_t j = 0; j < wire.balloon_radii_m.size() && !wire.nodes.empty(); ++j) {
        const double arc_m = wire.balloon_arc_m + static_cast<double>(j) * wire.balloon_spacing_m;
        balls.push_back({place_at(wire, arc_m), wire.balloon_radii_m[j]});
    }
    return balls;
}

} // namespace crn
