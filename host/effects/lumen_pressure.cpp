#include "host/effects/lumen_pressure.hpp"
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <iterator>
#include <limits>
#include <numbers>

namespace crn
{
namespace
{

constexpr double step_m = 1e-3; // along the tool
constexpr double eccentric_gain = 2.5;

struct Viscosity {
    double iodine_mg_per_ml, mPa_s;
};
constexpr Viscosity label[] = {{0.0, 0.69},  {140.0, 1.5}, {180.0, 2.0},
                               {240.0, 3.4}, {300.0, 6.3}, {350.0, 10.4}};

// Returns one of the tool's radii (`radius_um`) at an arc length from the tool's tip: linear between the
// knots of the tool's table, constant beyond them.
double radius_m(const Instrument &tool, double arc_m, std::uint32_t crn_wire_knot::*radius_um)
{
    const crn_wire_knot *knots = tool.table.knots;
    const std::size_t count = tool.table.knots_count;
    if (count == 0) return 0.0;
    const double arc_um = arc_m * 1e6;
    if (arc_um <= knots[0].arc_um) return knots[0].*radius_um * 1e-6;
    for (std::size_t i = 1; i < count; ++i) {
        if (arc_um > knots[i].arc_um) continue;
        const double span_um = static_cast<double>(knots[i].arc_um) - knots[i - 1].arc_um;
        const double share = span_um > 0.0 ? (arc_um - knots[i - 1].arc_um) / span_um : 1.0;
        return ((1.0 - share) * (knots[i - 1].*radius_um) + share * (knots[i].*radius_um)) * 1e-6;
    }
    return knots[count - 1].*radius_um * 1e-6;
}

// Returns the radius of the widest tool that lies in the lumen at a position, or 0 if no tool lies there.
double inner_radius_m(std::span<const InnerTool> inside, double arc_m)
{
    double widest_m = 0.0;
    for (const InnerTool &inner : inside) {
        const double inner_arc_m = arc_m - inner.tip_behind_m;
        if (inner_arc_m < 0.0 || inner_arc_m > inner.tool->length_m) continue;
        widest_m = std::max(widest_m, radius_m(*inner.tool, inner_arc_m, &crn_wire_knot::radius_outer_um));
    }
    return widest_m;
}

// Returns the conductance of a lumen with a guidewire in it, divided by the conductance of the empty lumen.
// The guidewire is assumed to lie where it lets the most fluid pass.
double gap_share(double k)
{
    if (k <= 0.0) return 1.0;
    if (k >= 1.0) return 0.0;
    const double open = 1.0 - k * k;
    const double concentric = 1.0 - std::pow(k, 4) - open * open / std::log(1.0 / k);
    return std::min(eccentric_gain * std::max(concentric, 0.0), 1.0);
}

} // namespace

double contrast_viscosity_mPa_s(double iodine_mg_per_ml)
{
    const Viscosity *above =
        std::find_if(std::begin(label) + 1, std::end(label) - 1,
                     [&](const Viscosity &row) { return row.iodine_mg_per_ml >= iodine_mg_per_ml; });
    const Viscosity &from = *(above - 1), &to = *above;
    const double share =
        (iodine_mg_per_ml - from.iodine_mg_per_ml) / (to.iodine_mg_per_ml - from.iodine_mg_per_ml);
    return from.mPa_s * std::pow(to.mPa_s / from.mPa_s, std::clamp(share, 0.0, 1.0));
}

double injection_pressure_kPa(const Instrument &tool, std::span<const InnerTool> inside, double flow_ml_s,
                              double iodine_mg_per_ml)
{
    const int steps = std::max(1, static_cast<int>(std::ceil(tool.length_m / step_m)));
    const double length_m = tool.length_m / steps;
    double per_m4 = 0.0; // integral of ds / (share R^4)
    for (int i = 0; i < steps; ++i) {
        const double arc_m = (i + 0.5) * length_m;
        const double lumen_m = radius_m(tool, arc_m, &crn_wire_knot::radius_inner_um);
        const double share = lumen_m > 0.0 ? gap_share(inner_radius_m(inside, arc_m) / lumen_m) : 0.0;
        if (share <= 0.0) return std::numeric_limits<double>::infinity();
        per_m4 += length_m / (share * std::pow(lumen_m, 4));
    }
    const double flow_m3_s = flow_ml_s * 1e-6,
                 viscosity_Pa_s = contrast_viscosity_mPa_s(iodine_mg_per_ml) * 1e-3;
    return 8.0 * viscosity_Pa_s * flow_m3_s / std::numbers::pi * per_m4 * 1e-3;
}

} // namespace crn
