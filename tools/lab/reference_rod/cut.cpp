// Computes the constants of the reference rod from the table of properties in an instrument file.
#include "tools/lab/reference_rod/rod.hpp"
#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

namespace crn::reference
{
namespace
{

// Returns the instrument's properties at one position, interpolated linearly between knots as the wire
// protocol specifies.
struct Profile {
    double bend_N_m2, twist_N_m2, radius_m, curvature1_per_m, curvature2_per_m;
};

Profile profile_at(const crn_wire_instrument &table, double arc_m)
{
    std::uint32_t b = 1;
    while (b + 1 < table.knots_count && table.knots[b].arc_um * 1e-6 <= arc_m) b++;
    const crn_wire_knot &from = table.knots[b - 1], &to = table.knots[b];
    const double span_m = (to.arc_um - from.arc_um) * 1e-6;
    const double u = span_m > 0.0 ? std::clamp((arc_m - from.arc_um * 1e-6) / span_m, 0.0, 1.0) : 1.0;
    const auto between = [&](double a, double c, double unit) { return ((1.0 - u) * a + u * c) * unit; };
    return {between(from.bend_stiffness_nN_m2, to.bend_stiffness_nN_m2, 1e-9),
            between(from.twist_stiffness_nN_m2, to.twist_stiffness_nN_m2, 1e-9),
            between(from.radius_outer_um, to.radius_outer_um, 1e-6),
            between(from.rest_curvature1_per_m_milli, to.rest_curvature1_per_m_milli, 1e-3),
            between(from.rest_curvature2_per_m_milli, to.rest_curvature2_per_m_milli, 1e-3)};
}

// Returns the distance from the tip at which the curved part of the tip ends.
double curves_m(const crn_wire_instrument &table)
{
    double end_m = 0.0;
    for (std::uint32_t i = 0; i < table.knots_count; i++)
        if (table.knots[i].rest_curvature1_per_m_milli != 0 ||
            table.knots[i].rest_curvature2_per_m_milli != 0)
            end_m = table.knots[i].arc_um * 1e-6;
    return end_m;
}

// The parts of the rod that a joint represents (its cell) act as springs in series, so their compliances add
// up. Curvature adds over the cell.
void fill_cell(const crn_wire_instrument &table, double from_m, double to_m, int node, Rod &rod)
{
    constexpr int samples = 16;
    double bend = 0.0, twist = 0.0, turn1 = 0.0, turn2 = 0.0;
    for (int i = 0; i < samples; i++) {
        const Profile p = profile_at(table, from_m + (to_m - from_m) * (i + 0.5) / samples);
        bend += 1.0 / (p.bend_N_m2 * samples);
        twist += 1.0 / (p.twist_N_m2 * samples);
        turn1 += p.curvature1_per_m * (to_m - from_m) / samples;
        turn2 += p.curvature2_per_m * (to_m - from_m) / samples;
    }
    rod.bend_N_m2[node] = 1.0 / bend;
    rod.twist_N_m2[node] = 1.0 / twist;
    const double turn = std::hypot(turn1, turn2),
                 stretch = turn > 0.0 ? 2.0 * std::tan(0.5 * turn) / turn : 1.0;
    rod.rest_curvature1[node] = stretch * turn1;
    rod.rest_curvature2[node] = -stretch * turn2; // the file's d2 is t x d1 with t towards the hand
    rod.radius_m[node] = profile_at(table, rod.arc_m[node]).radius_m;
}

void size_cells(Rod &rod)
{
    const int n = rod.nodes();
    rod.cell_m.resize(n);
    for (int i = 0; i < n; i++)
        rod.cell_m[i] = 0.5 * ((i > 0 ? rod.length_m(i - 1) : 0.0) + (i + 1 < n ? rod.length_m(i) : 0.0));
    rod.joint_m = rod.cell_m;
    for (auto *values :
         {&rod.bend_N_m2, &rod.twist_N_m2, &rod.rest_curvature1, &rod.rest_curvature2, &rod.radius_m})
        values->assign(n, 0.0);
}

void size_stretch(double stretch, Rod &rod)
{
    for (int j = 0; j + 1 < rod.nodes(); j++)
        rod.stretch_N.push_back(stretch * std::min(rod.bend_N_m2[j], rod.bend_N_m2[j + 1]) /
                                (rod.length_m(j) * rod.length_m(j)));
}

} // namespace

Rod cut_rod(const crn_wire_instrument &table, double length_m, const Cut &cut)
{
    const double whole_m = table.knots[table.knots_count - 1].arc_um * 1e-6;
    if (length_m + 2.0 * cut.shaft_m > whole_m)
        throw std::invalid_argument("the instrument is " + std::to_string(whole_m * 1e3) +
                                    " mm long, too short to insert " + std::to_string(length_m * 1e3) +
                                    " mm");
    const double fine_m = cut.fine_m > 0.0 ? cut.fine_m : std::max(0.02, curves_m(table) + 0.005);
    constexpr double growth = 1.2;
    Rod rod;
    double arc_m = 0.0, edge_m = cut.tip_m;
    int beyond = 0; // nodes beyond the length
    while (beyond < 3) {
        rod.arc_m.push_back(arc_m);
        if (arc_m >= length_m) beyond++;
        if (arc_m >= fine_m) edge_m = std::min(edge_m * growth, cut.shaft_m);
        arc_m += edge_m;
    }
    size_cells(rod);
    for (int i = 0; i < rod.nodes(); i++) {
        const double front_m = i > 0 ? 0.5 * rod.length_m(i - 1) : 0.0;
        fill_cell(table, rod.arc_m[i] - front_m, rod.arc_m[i] - front_m + rod.cell_m[i], i, rod);
    }
    size_stretch(cut.stretch, rod);
    return rod;
}

double radius_at_m(const crn_wire_instrument &table, double arc_m)
{
    return profile_at(table, arc_m).radius_m;
}

Rod uniform_rod(double bend_N_m2, double twist_N_m2, double radius_m, double length_m, double edge_m)
{
    Rod rod;
    const int edges = static_cast<int>(std::lround(length_m / edge_m));
    for (int i = 0; i <= edges; i++) rod.arc_m.push_back(length_m * i / edges);
    size_cells(rod);
    rod.bend_N_m2.assign(rod.arc_m.size(), bend_N_m2);
    rod.twist_N_m2.assign(rod.arc_m.size(), twist_N_m2);
    rod.radius_m.assign(rod.arc_m.size(), radius_m);
    size_stretch(Cut{}.stretch, rod);
    return rod;
}

} // namespace crn::reference
