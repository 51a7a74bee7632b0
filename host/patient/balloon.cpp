#include "host/patient/balloon.hpp"
#include "host/model/timeline.hpp"
#include "host/model/wire_place.hpp"
#include <algorithm>
#include <cmath>

namespace crn
{

namespace
{

using Eigen::Vector3d;

constexpr double piece_m = 0.25e-3;  // along the axis: each piece is drawn as a cylinder
constexpr double cone_slope = 0.5;   // radius lost per length of the ends
constexpr double unfolded_m = 20e-6; // a balloon that is this much larger than when folded counts as filled
constexpr double seen_behind_m =
    0.03; // distance from the introducer's opening beyond which the balloon counts as outside the patient
constexpr std::size_t column_points_max = 1000;

bool has_balls(const WireFrame &wire)
{
    return wire.nodes.size() >= 2 && wire.balloon_radii_m.size() >= 2 && wire.balloon_spacing_m > 0.0 &&
           wire.balloon_arc_m < wire.nodes.back().arc_m + seen_behind_m;
}

// Returns the balloon's radius at an arc length. Between the balls that model the balloon the radius changes
// linearly; beyond the first and the last ball the balloon ends in a cone.
double radius_at(const WireFrame &wire, double from_first_m)
{
    const std::vector<double> &radii_m = wire.balloon_radii_m;
    const double last_m = static_cast<double>(radii_m.size() - 1) * wire.balloon_spacing_m;
    if (from_first_m < 0.0) return radii_m.front() + cone_slope * from_first_m;
    if (from_first_m > last_m) return radii_m.back() - cone_slope * (from_first_m - last_m);
    const double place = from_first_m / wire.balloon_spacing_m;
    const auto i = std::min(static_cast<std::size_t>(place), radii_m.size() - 2);
    const double share = place - static_cast<double>(i);
    return (1.0 - share) * radii_m[i] + share * radii_m[i + 1];
}

} // namespace

std::optional<std::size_t> balloon_tool(const std::vector<Instrument> &tools)
{
    for (std::size_t k = 0; k < tools.size(); ++k)
        if (tools[k].table.balloon_count > 0) return k;
    return {};
}

double balloon_middle_mm(const Instrument &tool)
{
    return (double{1} * tool.table.balloon_distal_um + tool.table.balloon_proximal_um) / 2 * 1e-3;
}

BalloonPose balloon_pose(const WireFrame &wire, std::size_t tool)
{
    BalloonPose pose;
    if (!has_balls(wire) || tool >= wire.tip_arc_m.size()) return pose;
    for (std::size_t j = 0; j < wire.balloon_radii_m.size(); ++j) {
        const double arc_m = wire.balloon_arc_m + static_cast<double>(j) * wire.balloon_spacing_m;
        pose.points.push_back({(arc_m - wire.tip_arc_m[tool]) * 1e3, line_place_m(wire, arc_m) * 1e3,
                               wire.balloon_radii_m[j] * 1e3});
    }
    return pose;
}

std::vector<SweptCurve> balloon_filling(const WireFrame &wire, const std::vector<Instrument> &tools,
                                        double iodine_mg_per_ml)
{
    const std::optional<std::size_t> tool = balloon_tool(tools);
    if (!tool || *tool >= wire.tip_arc_m.size() || !has_balls(wire)) return {};
    const double tip_m =
        wire.balloon_arc_m - wire.tip_arc_m[*tool]; // position of the first ball, from the tool's tip
    const double last_m = static_cast<double>(wire.balloon_radii_m.size() - 1) * wire.balloon_spacing_m;
    const double cones_m =
        *std::max_element(wire.balloon_radii_m.begin(), wire.balloon_radii_m.end()) / cone_slope;
    SweptCurve column{Material::iohexol_350, {}};
    bool is_up = false;
    for (double s_m = -cones_m; s_m <= last_m + cones_m && column.points.size() < column_points_max;
         s_m += piece_m) {
        const double folded_m = outer_radius_m(tools[*tool].table, std::max(tip_m + s_m, 0.0));
        const double radius_m = radius_at(wire, s_m);
        if (radius_m <= folded_m) continue;
        is_up = is_up || radius_m > folded_m + unfolded_m;
        const double share = 1.0 - folded_m * folded_m / (radius_m * radius_m);
        column.points.push_back({line_place_m(wire, wire.balloon_arc_m + s_m), radius_m,
                                 share * contrast_share(iodine_mg_per_ml)});
    }
    if (!is_up || column.points.size() < 2) return {};
    return {column};
}

} // namespace crn
