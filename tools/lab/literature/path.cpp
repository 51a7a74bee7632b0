// Pushes and pulls instruments through tubes.
#include "tools/lab/literature/experiments.hpp"
#include "tools/lab/literature/shipped.hpp"
#include "tools/lab/validate/support.hpp"

#include <algorithm>
#include <cmath>

namespace crn::literature
{

namespace
{

using validate::degree;

constexpr double gram_force_N = 9.80665e-3;

// A path of 20 cm like that of the carotid artery into the skull: a long arc, the bend into the bone, the
// siphon in another plane, and the bend into the brain's artery. The source does not state its radii, so all
// of them are scaled by `scale`.
validate::Path carotid_path(double scale)
{
    validate::Path path({0, 0, 0}, {1, 0, 0}, {0, 0, 1});
    path.straight(0.035).bend(0.04 * scale, 40 * degree);
    path.roll(90 * degree).bend(0.010 * scale, 90 * degree).straight(0.012);
    path.roll(90 * degree).bend(0.008 * scale, 90 * degree).straight(0.006);
    path.roll(180 * degree).bend(0.006 * scale, 170 * degree).straight(0.004);
    path.roll(120 * degree).bend(0.008 * scale, 90 * degree);
    path.straight(std::max(0.2 - path.length(), 0.005));
    return path;
}

struct Tracked {
    double largest_N = 0;
    validate::Series force; // over the way of the tip
};

// Pushes the tools together through the path, and measures the sum of the forces on the hands.
Tracked track(std::vector<validate::Tool> tools, double lead_m, double scale, const std::string &label)
{
    const validate::Path path = carotid_path(scale);
    const validate::LumenField field = validate::tube_field(path, 0.065 * 0.0254 / 2, 2);
    constexpr double begin_m = 0.02, speed_m = 2e-5; // per tick
    validate::Start start;
    start.inserted_m.assign(tools.size(), begin_m);
    start.inserted_m[0] += lead_m;
    validate::Rig rig(tools, &field, start);
    Tracked tracked;
    tracked.force.label = label;
    const double way_m = path.length() - begin_m - lead_m - 0.002;
    for (double hand = 0; hand < way_m; hand += speed_m) {
        for (unsigned k = 0; k < tools.size(); k++) rig.feed(hand, k);
        rig.step();
        double sum = 0;
        for (unsigned k = 0; k < tools.size(); k++) sum += rig.handle_axial(k);
        tracked.largest_N = std::max(tracked.largest_N, sum);
        if (tracked.force.x.size() * 2e-3 > hand) continue;
        tracked.force.x.push_back((begin_m + lead_m + hand) * 1e3);
        tracked.force.y.push_back(sum / gram_force_N);
    }
    return tracked;
}

// The shipped coronary wire as uncoated steel on PTFE.
validate::Tool steel_wire()
{
    validate::Tool wire = shipped_tool("coronary_014", 0.24, 0.002);
    for (validate::Knot &knot : wire.knots) {
        knot.friction = 0.1;
        knot.friction_static = 0.12;
    }
    return wire;
}

// A reinforced microcatheter of 2.8 F and 0.021 in with a hydrophilic coat. Nobody publishes its stiffness:
// the wall counts as 0.3 GPa over the distal 3 cm and 1.5 GPa behind 12 cm, as in the shipped catheters.
validate::Tool microcatheter()
{
    constexpr double outer_m = 0.46e-3, inner_m = 0.27e-3;
    const double moment_m4 = M_PI / 4 * (std::pow(outer_m, 4) - std::pow(inner_m, 4));
    const auto knot = [&](double arc_m, double GPa) {
        return validate::Knot{.arc_m = arc_m,
                              .bend_N_m2 = GPa * 1e9 * moment_m4,
                              .twist_N_m2 = 1.5 * GPa * 1e9 * moment_m4,
                              .mass_kg_per_m = 0.0006,
                              .radius_m = outer_m,
                              .radius_inner_m = inner_m,
                              .friction = 0.033,
                              .friction_static = 0.04};
    };
    validate::Tool tool;
    tool.knots = {knot(0, 0.3), knot(0.03, 0.3), knot(0.12, 1.5), knot(0.24, 1.5)};
    tool.element_m = 0.002;
    tool.lumen_friction = 0.1;
    return tool;
}

Figures zoarski()
{
    Figures figures;
    validate::Plot plot{"Force on the hand along the path", "way of the leading tip (mm)", "force (gf)", {}};
    for (auto [name, scale] : {std::pair{"narrow_bends", 1.0}, {"wide_bends", 1.3}}) {
        const std::string bends = scale > 1 ? "wide" : "narrow";
        const Tracked wire = track({steel_wire()}, 0, scale, "wire, " + bends);
        const Tracked both = track({steel_wire(), microcatheter()}, 0.01, scale, "catheter, " + bends);
        figures.values[std::string("wire_") + name] = wire.largest_N / gram_force_N;
        figures.values[std::string("microcatheter_") + name] = both.largest_N / gram_force_N;
        plot.series.push_back(wire.force);
        plot.series.push_back(both.force);
    }
    figures.curves.push_back(plot);
    return figures;
}

// Draws a straight wire along the floor of a tube by its weight alone.
double drag_N(double friction)
{
    constexpr double tube_m = 0.002, radius_m = 445e-6, length_m = 0.3;
    validate::Path path({-0.05, 0, 0}, {1, 0, 0}, {0, 0, 1});
    path.straight(0.45);
    const validate::LumenField field = validate::tube_field(path, tube_m, 1);
    validate::Rig rig(
        {validate::uniform_tool({.bend_N_m2 = 1e-3, .mass_kg_per_m = 0.05, .friction = friction},
                                length_m + 0.03, 0.003)},
        &field, {.inserted_m = {length_m}, .mouth_m = {0, 0, -(tube_m - radius_m - 2e-6)}});
    rig.set_gravity({0, 0, -validate::gravity_m_s2});
    rig.step(1000);
    double sum = 0;
    // Slowly, because the core's drag of 20/s would add 20 v / (mu g) of the friction.
    constexpr int ticks = 6000, last = 2000;
    constexpr double speed_m = 1e-7; // per tick
    for (int tick = 1; tick <= ticks; tick++) {
        rig.feed(-speed_m * tick);
        rig.step();
        if (tick > ticks - last) sum -= rig.handle_axial();
    }
    return sum / last;
}

Figures schroeder()
{
    const double steel_N = drag_N(0.2);
    return {{{"ptfe", drag_N(0.1) / steel_N}, {"hydrophilic", drag_N(0.0333) / steel_N}}, {}};
}

} // namespace

std::vector<Experiment> path_experiments()
{
    return {{"track_force", zoarski}, {"sliding_friction", schroeder}};
}

} // namespace crn::literature
