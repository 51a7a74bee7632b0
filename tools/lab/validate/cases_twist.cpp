// Tests buckling that twist causes: in a straight rod, in a ring, and in a long rod that forms a local coil.
#include "tools/lab/validate/cases.hpp"
#include "tools/lab/validate/elastica.hpp"
#include "tools/lab/validate/support.hpp"

#include <algorithm>
#include <cmath>

namespace crn::validate
{

namespace
{

constexpr double nu = 0.3, bend_over_twist = 1 + nu;

// Sets up a rod whose first edge (the segment at the tip) is clamped in space. The clamped edge counts as
// rigid, and the clamp is at the middle of that edge.
struct Clamped {
    Rig rig;
    double element_m, length_m; // between the clamps
    double hand_rad = 0;

    Clamped(double bend, double length, unsigned count, double ratio = bend_over_twist)
        : rig({tool(bend, length, count, ratio)}, nullptr, {{length}}),
          element_m(element_length(length, count)), length_m(length - element_m / 2)
    {
    }
    static Tool tool(double bend, double length, unsigned count, double ratio)
    {
        double element = element_length(length, count);
        Tool made =
            uniform_tool({.bend_N_m2 = bend, .twist_N_m2 = bend / ratio}, element * (count + 8), element);
        made.axial_stiffness_max_N = 10000;
        return made;
    }
    void hold(const Vector3d &first, const Vector3d &second, bool axial_free)
    {
        rig.set_hold({.anchor_m = first,
                      .second = 1,
                      .second_anchor_m = second,
                      .axial_free = axial_free,
                      .turn = true});
    }
    void turn_to(double rad)
    {
        while (hand_rad < rad) {
            hand_rad = std::min(rad, hand_rad + 4e-3);
            rig.turn(hand_rad);
            rig.step();
        }
    }
};

// --- straight rod ---

double radius_of(const Rig &rig)
{
    double most = 0;
    for (const Vector3d &p : rig.shape()) most = std::max(most, std::hypot(p[1], p[2]));
    return most;
}

void greenhill_case(Result &result, bool)
{
    result.title = "Greenhill: a twisted straight rod buckles";
    result.setup = "EI 1e-4 N m2, GJ = EI / 1.3, L 0.3 m, 100 elements, both ends clamped, the tip free to "
                   "move along the axis; a "
                   "small weight bends, the hand turns and waits. The twist at which 1 / sag falls to zero, "
                   "and the hand's torque then.";
    result.formula = "M L / B = 8.987 (tan x = x, x = M L / 2B); twist = 8.987 B / C";
    result.source = "Greenhill 1883";
    Clamped rod(1e-4, 0.3, 100);
    rod.hold(rod.rig.position(0), rod.rig.position(1), true);
    rod.rig.set_gravity({0, 0, -0.05});
    settle(rod.rig, 1e-9, 5000);
    double expected = greenhill() * bend_over_twist, base = radius_of(rod.rig), torque = 0;
    std::vector<double> turns, inverse;
    Series series{"ours", {}, {}, true};
    for (double turn = 5, step = 0.5; turns.empty() || inverse.back() > 0.06; turn += step) {
        rod.turn_to(turn);
        settle(rod.rig, 4e-9 + 3e-4 * radius_of(rod.rig), 10000);
        turns.push_back(turn);
        inverse.push_back(base / radius_of(rod.rig));
        torque = rod.rig.handle_torque() / turn;
        series.x.push_back(turn / expected);
        series.y.push_back(inverse.back());
        step = inverse.back() < 0.2 ? 0.1 : 0.5;
        if (turns.size() > 40) break;
    }
    double critical = zero_of_line(turns, inverse);
    result.relative("twist", "rad", expected, critical, 5);
    result.relative("moment", "N m", greenhill() * 1e-4 / rod.length_m, torque * critical, 5);
    result.plots.push_back(
        {"Sag of a twisted rod", "twist / Greenhill's", "sag without twist / sag", {series}});
}

// --- ring ---

// Fits to the nodes a plane that contains the x axis and the introducer's end; returns the root mean square
// distance of the nodes from this plane.
double warp(const Rig &rig)
{
    // We fit the two factors a and b in y = a x + b z by the normal equations, whose two columns x and z are
    // nearly orthogonal for a ring-shaped rod.
    const unsigned n = rig.free_count();
    double xx = 0, xz = 0, zz = 0, xy = 0, zy = 0;
    for (unsigned i = 0; i < n; i++) {
        const Vector3d p = rig.position(i);
        xx += p[0] * p[0];
        xz += p[0] * p[2];
        zz += p[2] * p[2];
        xy += p[0] * p[1];
        zy += p[2] * p[1];
    }
    const double det = xx * zz - xz * xz, a = (xy * zz - zy * xz) / det, b = (zy * xx - xy * xz) / det;
    double sum = 0;
    for (unsigned i = 0; i < n; i++) {
        const Vector3d p = rig.position(i);
        const double off = a * p[0] + b * p[2] - p[1];
        sum += off * off;
    }
    return std::sqrt(sum / n);
}

void ring(Result &result, bool quick)
{
    result.title = "Michell's ring: a twisted ring leaves its plane";
    result.setup = "EI 1e-3 N m2, GJ = EI / 1.3, 128 elements bent into a ring of 0.5 m, both ends clamped "
                   "at one place; the hand "
                   "turns and waits. What bends out of plane at first (the mesh's small imperfections) grows "
                   "without limit: the "
                   "twist at which its inverse falls to zero.";
    result.formula = "twist = 2 pi sqrt(3) B / C";
    result.source = "Michell 1889, Zajac 1962";
    Clamped rod(1e-3, 0.5, 128);
    double around = 2 * M_PI / rod.length_m, half = around * rod.element_m / 2;
    double radius = rod.element_m / 2 / std::sin(half); // of the nodes, so that edges keep their length
    std::vector<Vector3d> nodes;
    for (unsigned i = 0; i < rod.rig.free_count(); i++) {
        double a = (rod.rig.inserted() - rod.rig.arc(i)) * around;
        nodes.push_back({radius * std::sin(a), 0, radius * (1 - std::cos(a))});
    }
    nodes[0] = {rod.element_m / 2, 0, 0};
    nodes[1] = {-rod.element_m / 2, 0, 0};
    rod.rig.place(nodes);
    rod.hold(nodes[0], nodes[1], false);
    settle(rod.rig, 1e-7, 4000);
    double expected = 2 * std::sqrt(3.0) * M_PI * bend_over_twist;
    std::vector<double> turns, inverse;
    Series series{"ours", {}, {}, true};
    for (double turn : {11.0, 12.0, 12.5, 13.0, 13.5, 13.8}) {
        if (quick && turn < 13) continue;
        rod.turn_to(turn);
        settle(rod.rig, 2e-8, 4000);
        turns.push_back(turn);
        inverse.push_back(1e-3 / warp(rod.rig));
        series.x.push_back(turn / expected);
        series.y.push_back(inverse.back());
    }
    result.relative("twist", "rad", expected, zero_of_line(turns, inverse), 5);
    result.plots.push_back(
        {"Distance from the plane of a twisted ring", "twist / Michell's", "1 mm / warp", {series}});
}

// --- localised coil ---

// Returns the cosine of the angle between each edge and the axis, against arc length over L.
Series tilt_of(const Clamped &rod)
{
    Series series{"ours", {}, {}, true};
    for (unsigned i = 1; i < rod.rig.free_count(); i++) {
        Vector3d edge = (rod.rig.position(i - 1) - rod.rig.position(i)).normalized();
        series.x.push_back(1 - (rod.rig.arc(i) - rod.element_m / 2) / rod.rig.inserted());
        series.y.push_back(edge[0]);
    }
    return series;
}

void coil(Result &result, bool quick)
{
    result.title = "Localised helical buckling of a long twisted rod";
    result.setup = "EI 1e-4 N m2, C / B = 0.789 / 1.345, L 0.5 m, 200 elements; the tip's clamp comes 3 % "
                   "nearer while the hand makes 27 "
                   "turns, then all is left to rest. The rod gathers its slack in one coil. Torque and pull "
                   "at the hand, and the "
                   "steepest place of the coil.";
    result.formula = "slack = sqrt(16/t (1 - m^2/4t)), turns = m B/C + 4 acos(m / 2 sqrt t); cos tilt = 1 - "
                     "(1 - c) sech^2(q s), c = m^2/2t - 1";
    result.source = "van der Heijden and Thompson 2000; constants of Gazzola et al. 2018, section 3.4.1";
    const double bend = 1e-4, ratio = 1.345 / 0.789, slack = 0.03, turns = 27 * 2 * M_PI;
    Clamped rod(bend, 0.5, 200, ratio);
    Vector3d first = rod.rig.position(0), second = rod.rig.position(1);
    int ramp = quick ? 10000 : 20000, wait = quick ? 2000 : 10000;
    rod.rig.set_gravity({0, 0, -0.2}); // breaks the symmetry
    for (int tick = 1; tick <= ramp; tick++) {
        double part = double(tick) / ramp;
        Vector3d nearer(-slack * rod.length_m * part, 0, 0);
        rod.hold(first + nearer, second + nearer, false);
        rod.rig.turn(turns * part);
        rod.rig.step();
    }
    rod.rig.set_gravity({0, 0, 0});
    rod.rig.step(wait);
    Writhe expected = writhe(slack, turns, ratio);
    double unit = bend / rod.length_m;
    result.relative("moment", "N m", expected.moment * unit, rod.rig.handle_torque(), 2);
    result.relative("pull", "N", expected.tension * unit / rod.length_m, -rod.rig.handle_axial(), 2);
    Series ours = tilt_of(rod);
    auto steepest = std::min_element(ours.y.begin(), ours.y.end());
    double c = expected.moment * expected.moment / 2 / expected.tension - 1;
    result.absolute("steepest", "deg", std::acos(c) / degree, std::acos(*steepest) / degree, 2);
    double centre = ours.x[std::size_t(steepest - ours.y.begin())];
    double sharp = std::sqrt(expected.tension * (1 - c) / 2);
    Series line{"closed form at the same place", {}, {}};
    for (double s = 0; s <= 1; s += 0.002) {
        line.x.push_back(s);
        line.y.push_back(1 - (1 - c) / std::pow(std::cosh(sharp * (s - centre)), 2));
    }
    result.plots.push_back({"Coil of a twisted rod", "arc length / L", "cos of the tilt", {line, ours}});
}

} // namespace

std::vector<Case> twist_cases()
{
    return {{"greenhill", greenhill_case}, {"ring", ring}, {"coil", coil}};
}

} // namespace crn::validate
