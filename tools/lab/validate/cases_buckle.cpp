// Tests buckling under axial thrust: Euler's four columns, and the behaviour of a column above the critical
// load.
#include "host/base/number_text.hpp"
#include "tools/lab/validate/cases.hpp"
#include "tools/lab/validate/elastica.hpp"
#include "tools/lab/validate/support.hpp"

#include <algorithm>
#include <cmath>

namespace crn::validate
{

namespace
{

constexpr double bend_N_m2 = 1.85e-3, length_m = 0.1;
constexpr unsigned elements = 64;

enum class End { free, hinged_base, pinned, clamped };

struct Column {
    const char *name;
    End end;
    double K;            // effective length over length
    double deflection_N; // w L^4 / (EI delta) of the unloaded column: sets the small side load
};

constexpr Column columns[] = {{"K_2", End::free, 2, 8},
                              {"K_1", End::hinged_base, 1, 77},
                              {"K_0.699", End::pinned, 0.699156, 185},
                              {"K_0.5", End::clamped, 0.5, 384}};

// Two supports that are `clamp_elements` elements apart clamp the tip of a column. Supports on neighbouring
// nodes could not clamp the tip, because the spring of each support would let the tip turn.
constexpr unsigned clamp_elements = 8;

// A soft piece of the rod, one element long, serves as a hinge at the introducer.
constexpr double hinge_N_m2 = 2e-6;

Rig make(const Column &column)
{
    double element = element_length(length_m, elements);
    Knot knot{.bend_N_m2 = bend_N_m2, .twist_N_m2 = bend_N_m2 / 1.3};
    Tool tool = uniform_tool(knot, element * (elements + 8), element);
    if (column.end == End::hinged_base) {
        Knot shaft = knot, soft = knot, end = knot;
        shaft.arc_m = soft.arc_m = length_m - element;
        soft.bend_N_m2 = end.bend_N_m2 = hinge_N_m2;
        end.arc_m = element * (elements + 8);
        tool.knots = {knot, shaft, soft, end};
    }
    Rig rig({tool}, nullptr, {{length_m}});
    Hold hold{.anchor_m = rig.position(0), .axial_free = true};
    if (column.end == End::clamped) {
        hold.second = clamp_elements;
        hold.second_anchor_m = rig.position(clamp_elements);
    }
    if (column.end != End::free) rig.set_hold(hold);
    return rig;
}

double critical_load(const Column &column)
{
    double element = element_length(length_m, elements);
    if (column.end == End::clamped) { // the clamp is a short second span
        double arm = clamp_elements * element;
        return std::pow(euler_two_spans(length_m - arm, arm), 2) * bend_N_m2;
    }
    if (column.end == End::hinged_base) { // the hinge is in the middle of the soft piece and slightly stiff
        double free = length_m - element / 2, spring = hinge_N_m2 / element * free / bend_N_m2;
        return std::pow(euler_spring_pinned(spring) / free, 2) * bend_N_m2;
    }
    double u = column.end == End::free ? M_PI / 2 : euler_clamped_pinned();
    return std::pow(u / length_m, 2) * bend_N_m2;
}

double sag(const Rig &rig)
{
    double most = 0;
    for (const Vector3d &p : rig.shape()) most = std::max(most, std::fabs(p[2]));
    return most;
}

// The ratio of side load to sag falls nearly linearly as the thrust rises, and reaches zero at the critical
// load (Southwell). The function first increases the thrust by half again and again, until the sag has grown.
// The straight line through the last two points (thrust, ratio) predicts the critical thrust, at which the
// ratio is zero. In each step the function raises the thrust by 7/10 of the difference to the predicted
// critical thrust. No theory of buckling enters.
double measure(const Column &column, Series &series)
{
    Rig rig = make(column);
    double side_N_m = column.deflection_N * bend_N_m2 * (length_m / 2000) / std::pow(length_m, 4);
    rig.set_gravity({0, 0, -side_N_m / 0.005});
    double scale = bend_N_m2 / (length_m * length_m);
    std::vector<double> thrusts = {scale}, stiffness;
    for (std::size_t i = 0; i < 16; i++) {
        rig.set_tip_load({-thrusts[i], 0, 0});
        settle(rig, 2e-9 + 1e-5 * sag(rig), 20000);
        stiffness.push_back(side_N_m * length_m / sag(rig));
        if (sag(rig) > length_m / 60) break;
        if (stiffness[i] > 0.6 * stiffness[0]) {
            thrusts.push_back(1.5 * thrusts[i]);
            continue;
        }
        double zero = zero_of_line({thrusts[i - 1], thrusts[i]}, {stiffness[i - 1], stiffness[i]});
        thrusts.push_back(thrusts[i] + 0.7 * (zero - thrusts[i]));
    }
    thrusts.resize(stiffness.size());
    double critical = critical_load(column);
    for (std::size_t i = 0; i < thrusts.size(); i++) {
        series.x.push_back(thrusts[i] / critical);
        series.y.push_back(stiffness[i] / stiffness[0]);
    }
    return zero_of_line(thrusts, stiffness);
}

void euler(Result &result, bool quick)
{
    result.title = "Euler buckling";
    result.setup = "EI 1.85e-3 N m2, L 0.1 m, 64 elements. The mouth clamps the base (K = 1: a soft element "
                   "of 2e-6 N m2 in it "
                   "makes a hinge, whose remaining stiffness is part of the reference); springs hold the tip "
                   "(free, on the axis, or "
                   "along it; K = 0.5: by two supports 12.5 mm apart, a second span in the reference). A "
                   "dead load presses, a small weight bends; the load at which sideways stiffness vanishes.";
    result.formula = "pi^2 EI / (K L)^2; with a turning spring k at one end: u^2 sin u = k L/EI (u cos u - "
                     "sin u); two spans by stability functions";
    result.source = "Euler 1744; Southwell 1932 for the measurement";
    Plot plot{
        "Sideways stiffness under thrust", "thrust / Euler's load", "stiffness / at the first thrust", {}};
    for (const Column &column : columns) {
        if (quick && column.K == 2) continue;
        Series series{column.name, {}, {}, true};
        double load = measure(column, series);
        result.relative(column.name, "N", critical_load(column), load, 3);
        plot.series.push_back(series);
    }
    result.plots.push_back(plot);
}

// --- beyond the load ---

void beyond_euler(Result &result, bool quick)
{
    result.title = "Buckled cantilever beyond Euler's load";
    result.setup = "As K = 2; a weight shows the direction, then only the dead load at the tip is left. "
                   "Error: distance of the tip "
                   "from the closed form.";
    result.formula = "load = K(k)^2, k = sin(alpha / 2); x / L = 2 E / K - 1, y / L = 2 k / K";
    result.source = "Kirchhoff; Love 1927, the elastica by elliptic integrals";
    Plot plot{"Tip of a buckled cantilever", "load / Euler's load", "x / L (upper at 1) and y / L", {}};
    Series x{"x / L", {}, {}, true, 0}, y{"y / L", {}, {}, true, 1};
    Series line_x{"closed form", {}, {}, false, 0}, line_y{"", {}, {}, false, 1};
    for (double factor : {1.02, 1.1, 1.3, 1.8, 2.5}) {
        if (quick && factor != 1.3) continue;
        Rig rig = make(columns[0]);
        double load = factor * M_PI * M_PI / 4, force = load * bend_N_m2 / (length_m * length_m);
        rig.set_gravity({0, 0, -2});
        rig.set_tip_load({-force, 0, 0});
        rig.step(1500);
        rig.set_gravity({0, 0, 0});
        settle(rig, 1e-7, 40000);
        Buckled shape = buckled_cantilever(load);
        Vector3d tip = rig.position(0) / length_m;
        double off = std::hypot(tip[0] - shape.x, std::fabs(tip[2]) - shape.y);
        result.error("load_" + number_text(factor), "y/L", shape.y, std::fabs(tip[2]), 100 * off, "% of L",
                     0.3);
        x.x.push_back(factor);
        x.y.push_back(tip[0]);
        y.x.push_back(factor);
        y.y.push_back(std::fabs(tip[2]));
    }
    for (double factor = 1.001; factor < 2.6; factor += 0.01) {
        Buckled shape = buckled_cantilever(factor * M_PI * M_PI / 4);
        line_x.x.push_back(factor);
        line_x.y.push_back(shape.x);
        line_y.x.push_back(factor);
        line_y.y.push_back(shape.y);
    }
    plot.series = {x, y, line_x, line_y};
    result.plots.push_back(plot);
}

} // namespace

std::vector<Case> buckle_cases()
{
    return {{"euler", euler}, {"beyond_euler", beyond_euler}};
}

} // namespace crn::validate
