// Tests pushing a rod: its compression at a wall, the force limit at which the hand stops, and the hand's
// work compared with the rod's energy. A further test covers the range of stiffness in which the rod does not
// vibrate.
#include "host/base/number_text.hpp"
#include "tools/lab/validate/cases.hpp"
#include "tools/lab/validate/support.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace crn::validate
{

namespace
{

// --- compression ---

struct Pressed {
    double hand_N, peak_N, strain, strain_peak, resting_m, depth_m;
    Series force_against_way;
};

// A rod of 256 elements of 3 mm lies in a closed straight tube. The hand pushes the last millimetres of the
// rod into the tube until the hand's force limit is reached.
Pressed press(double axial_N, double stall_N, double friction, double speed_m_s)
{
    Path path({-0.03, 0, 0}, {1, 0, 0}, {0, 0, 1});
    path.straight(0.03 + 0.764);
    LumenField field = tube_field(path, 0.003, 0, true);
    Knot knot{.bend_N_m2 = 1.85e-3, .twist_N_m2 = 1.85e-3 / 1.3, .friction = friction};
    Tool tool = uniform_tool(knot, 0.792, 0.003);
    tool.axial_stiffness_max_N = axial_N;
    Rig rig({tool}, &field, {{0.758}});
    rig.set_gravity({0, 0, -gravity_m_s2});
    rig.set_stall(stall_N);
    Pressed got{0, 0, 0, 0, 0, 0, {"", {}, {}}};
    double hand = 0;
    const int moving = int(0.03 / speed_m_s * 1000);
    for (int tick = 0; tick < moving + 1000; tick++) {
        hand = std::min(0.03, hand + speed_m_s * 1e-3);
        rig.feed(hand);
        rig.step();
        got.peak_N = std::max(got.peak_N, rig.handle_axial());
        got.strain_peak = std::max(got.strain_peak, std::fabs(rig.length_error()));
        if (tick >= moving + 900) got.resting_m = std::max(got.resting_m, rig.motion_per_tick());
        if (tick % 10 == 0) {
            got.force_against_way.x.push_back(rig.inserted() * 1e3);
            got.force_against_way.y.push_back(rig.handle_axial());
        }
    }
    got.hand_N = rig.handle_axial();
    got.strain = std::fabs(rig.length_error());
    got.depth_m = rig.penetration();
    return got;
}

void compression(Result &result, bool quick)
{
    result.title = "Compression of 256 elements at an end wall";
    result.setup =
        "EI 1.85e-3 N m2, 3 mm elements, friction 0.2, under its weight in a closed straight tube of 3 mm; "
        "pushed at 10 mm/s "
        "until the hand stalls at the force. Axial stiffness 10 kN, as the shipped wires have (3 kN: "
        "reported). Worst length "
        "error of the whole run against the project's bar; at the end against the closed form; then at rest.";
    result.formula = "length error <= bar; at the end F / EA";
    result.source = "issue 3, bar 4 (thesis: 0.45 %)";
    Plot plot{"Pushing against an end wall", "inserted (mm)", "force on the hand (N)", {}};
    for (auto [force, bar] : {std::pair{3.0, 0.1}, {10.0, 0.45}}) {
        if (quick && force > 5) continue;
        Pressed got = press(10000, force, 0.2, 0.01);
        std::string name = number_text(force) + "N";
        result.at_most("length_error." + name, "%", 100 * got.strain_peak, bar);
        result.absolute("closed_form." + name, "%", 100 * got.hand_N / 10000, 100 * got.strain, 0.01);
        result.at_most("resting_motion." + name, "um/tick", got.resting_m * 1e6, 1);
        got.force_against_way.label = "stalls at " + name;
        plot.series.push_back(got.force_against_way);
        if (!quick) {
            Pressed soft = press(3000, force, 0.2, 0.01);
            result.reported("length_error_EA_3kN." + name, "%", 100 * soft.hand_N / 3000,
                            100 * soft.strain_peak);
        }
    }
    Rig pulled({uniform_tool({.bend_N_m2 = 1.85e-3, .twist_N_m2 = 1.4e-3}, 0.35, 0.001)}, nullptr, {{0.3}});
    pulled.set_tip_load({5, 0, 0});
    pulled.step(500);
    result.relative("stretched_by_5N", "%", 100 * 5.0 / 3000, 100 * pulled.length_error(), 0.7);
    result.plots.push_back(plot);
}

// The wall's law, docs/rod.md: 5 kN/m, and 20 kN/m more beyond 0.2 mm.
double depth_of(double force_N)
{
    return force_N <= 1 ? force_N / 5000 : (force_N + 4) / 25000;
}

void wall_law(Result &result, bool quick)
{
    result.title = "Depth of a tip in an end wall";
    result.setup = "The same tube without friction; the rod is pushed at 20 mm/s until the hand stalls at "
                   "the force, and "
                   "rests. The force at rest and the depth of the tip.";
    result.formula = "F = 5 kN/m d + 20 kN/m max(0, d - 0.2 mm)";
    result.source = "docs/rod.md, contact";
    for (double force : {0.3, 0.8, 1.5, 6.0}) {
        if (quick && force != 0.8 && force != 6) continue;
        Pressed got = press(10000, force, 0, 0.02);
        result.relative(number_text(force) + "N", "um", depth_of(got.hand_N) * 1e6, got.depth_m * 1e6, 0.7);
    }
}

void stall(Result &result, bool quick)
{
    result.title = "Stall: a blocked tip stops the hand";
    result.setup = "The same tube, the hand's limit left at its 6 N, at two speeds and without and with "
                   "friction: the force at rest "
                   "and its peak.";
    result.formula = "F = F_max = 6 N";
    result.source = "docs/rod.md, feed";
    for (double speed : {0.02, 0.1}) {
        for (double friction : {0.05, 0.3}) {
            if (quick && (speed > 0.05 || friction > 0.1)) continue;
            Pressed got = press(10000, 6, friction, speed);
            std::string name = number_text(speed * 1e3) + "mm_s.mu_" + number_text(friction);
            result.absolute("rest." + name, "N", 6, got.hand_N, 0.2);
            result.absolute("peak." + name, "N", 6, got.peak_N, 0.6);
        }
    }
}

// --- work and energy ---

// Returns the bending energy of the rod's part outside the introducer, computed from the nodes' positions
// alone. For the joint at the introducer, the function uses the length that the core gives this joint (half
// an element or less).
double bending_energy(const Rig &rig, double bend_N_m2, double element_m)
{
    double sum = 0;
    for (unsigned i = 1; i < rig.free_count(); i++) {
        Vector3d ahead = (rig.position(i) - rig.position(i - 1)) / element_m;
        Vector3d behind = (rig.position(i + 1) - rig.position(i)) / element_m;
        sum += bend_N_m2 / element_m / 2 * (behind - ahead).squaredNorm();
    }
    return sum;
}

void energy(Result &result, bool quick)
{
    result.title = "Work of the hand against stored energy";
    result.setup = "A frictionless wire, EI 5e-4 N m2, is pushed at 10 mm/s through two bends of 60 mm "
                   "radius in a tube of 4 mm and "
                   "drawn back; no weight. Work: force on the hand times its way. Energy: bending, from the "
                   "nodes' positions. In each "
                   "way the drag of blood takes a little (20/s m v x, part of the reference).";
    result.formula = "work = bending energy + drag";
    result.source = "conservation of energy";
    const double bend = 5e-4, element = 0.003, speed = quick ? 0.02 : 0.01, way_m = 0.33;
    Path path({-0.03, 0, 0}, {1, 0, 0}, {0, 0, 1});
    path.straight(0.11).bend(0.06, M_PI / 2).straight(0.1).roll(1.2).bend(0.06, M_PI / 2).straight(0.12);
    LumenField field = tube_field(path, 0.004, 0);
    Rig rig({uniform_tool({.bend_N_m2 = bend, .twist_N_m2 = bend / 1.3}, 0.6, element)}, &field, {{0.05}});
    double hand = 0, work = 0, drag = 0, before = rig.inserted(), start = bending_energy(rig, bend, element);
    Series work_in{"work of the hand, in", {}, {}}, work_out{"work, out again", {}, {}},
        stored{"bending energy", {}, {}};
    double inside[3] = {0, 0, 0};
    int moving = int(way_m / speed * 1000);
    for (int tick = 0; tick < 2 * (moving + 500); tick++) {
        bool in = tick < moving + 500;
        int local = in ? tick : tick - moving - 500;
        if (local < moving) hand += (in ? 1 : -1) * speed * 1e-3;
        rig.feed(hand);
        rig.step();
        double now = rig.inserted();
        work += rig.handle_axial() * (now - before);
        drag += 20 * 0.005 * now * std::fabs(now - before) * speed;
        before = now;
        double bent = bending_energy(rig, bend, element) - start;
        if (tick == moving + 499) std::copy_n(std::array{work, bent, drag}.begin(), 3, inside);
        if (tick % 50) continue;
        Series &series = in ? work_in : work_out;
        series.x.push_back(now * 1e3);
        series.y.push_back(work * 1e3);
        if (!in) continue;
        stored.x.push_back(now * 1e3);
        stored.y.push_back(bent * 1e3);
    }
    result.relative("in", "mJ", (inside[1] + inside[2]) * 1e3, inside[0] * 1e3, 1.5);
    result.error("round_trip", "mJ", drag * 1e3, work * 1e3, 100 * (work - drag) / inside[1], "% of stored",
                 2);
    result.at_most("gained", "mJ", std::max(0.0, -work) * 1e3, 0);
    result.plots.push_back({"Work of the hand", "inserted (mm)", "mJ", {work_in, work_out, stored}});
}

// --- range of stiffness ---

struct Calm {
    double strain, depth_m, resting_m;
    bool saturated;
};

// What a wire may do: about three times what it does. A stiffer wire lies deeper in the wall.
struct CalmBars {
    double bend_N_m2, strain_pct, depth_mm, resting_um;
};

// In this validation case the hand pushes the rod 0.55 m at 0.1 m/s through three bends that do not lie in
// one plane, and then rests for a second.
Calm insert(const Tool &tool)
{
    Path path({-0.03, 0, 0}, {1, 0, 0}, {0, 0, 1});
    path.straight(0.18)
        .bend(0.08 / (M_PI / 2), M_PI / 2)
        .straight(0.15)
        .roll(1.2)
        .bend(0.09 / (M_PI / 2), M_PI / 2);
    path.straight(0.12).roll(-2).bend(0.1 / (0.6 * M_PI), 0.6 * M_PI).straight(0.25);
    LumenField field = tube_field(path, 0.004, 0);
    Rig rig({tool}, &field, {{0.05}});
    rig.set_gravity({0, 0, -gravity_m_s2});
    Calm worst{0, 0, 0, false};
    for (int tick = 0; tick < 6500; tick++) {
        rig.feed(std::min(0.55, tick * 1e-4));
        rig.step();
        worst.strain = std::max(worst.strain, std::fabs(rig.length_error()));
        worst.depth_m = std::max(worst.depth_m, rig.penetration());
        if (tick > 6400) worst.resting_m = std::max(worst.resting_m, rig.motion_per_tick());
    }
    worst.saturated = rig.saturated();
    return worst;
}

void stability(Result &result, bool quick)
{
    result.title = "Range of stiffness that stays calm";
    result.setup = "Wires pushed 0.55 m at 0.1 m/s through three bends (R 51, 57, 53 mm) of a tube of 4 mm, "
                   "friction 0.2: uniform ones, "
                   "and one that grows from 2e-6 to 4.9e-3 N m2 within 0.3 m. 3 mm elements, 5 g/m, no "
                   "damping but blood's.";
    result.formula =
        "length error <= 0.48 %, wall depth <= 1 mm, at rest <= 4 um per tick for the softest wire, "
        "<= 0.1 for stiff ones, no saturation";
    result.source = "three times the measured figures; length error 0.6 % and depth 1 mm are promised";
    auto judge = [&](const std::string &name, const Tool &tool, const CalmBars &bars) {
        Calm worst = insert(tool);
        result.at_most("length_error." + name, "%", 100 * worst.strain, bars.strain_pct);
        result.at_most("wall_depth." + name, "mm", 1e3 * worst.depth_m, bars.depth_mm);
        result.at_most("resting_motion." + name, "um/tick", 1e6 * worst.resting_m, bars.resting_um);
        if (name == "EI_3e-2") { // needs 0.59 N m at a joint; the format holds 60 N x 3 mm
            result.reported("saturated." + name, "", 0, worst.saturated);
        } else {
            result.at_most("saturated." + name, "", worst.saturated, 0);
        }
    };
    const CalmBars wires[] = {{2e-6, 0.1, 0.065, 4},
                              {1e-4, 0.004, 0.045, 1.4},
                              {1.85e-3, 0.03, 0.6, 0.08},
                              {4.9e-3, 0.08, 0.8, 0.05},
                              {3e-2, 0.48, 1, 0.04}};
    for (const CalmBars &bars : wires) {
        const double bend = bars.bend_N_m2;
        if (quick && bend != 1.85e-3) continue;
        Tool tool = uniform_tool({.bend_N_m2 = bend, .twist_N_m2 = bend / 1.3, .friction = 0.2}, 0.9, 0.003);
        tool.axial_stiffness_max_N = 10000;
        judge("EI_" + power_text(bend), tool, bars);
    }
    if (quick) return;
    Tool tool;
    tool.axial_stiffness_max_N = 10000;
    for (int k = 0; k <= 12; k++) { // equal ratios, as on a taper
        double bend = 2e-6 * std::pow(4.9e-3 / 2e-6, k / 12.0);
        tool.knots.push_back(
            {.arc_m = 0.3 * k / 12, .bend_N_m2 = bend, .twist_N_m2 = bend / 1.3, .friction = 0.2});
    }
    tool.knots.push_back(tool.knots.back());
    tool.knots.back().arc_m = 0.9;
    judge("taper_2e-6_to_4.9e-3", tool, {0, 0.022, 0.28, 0.1});
}

} // namespace

std::vector<Case> push_cases()
{
    return {{"compression", compression},
            {"wall_law", wall_law},
            {"stall", stall},
            {"energy", energy},
            {"stability", stability}};
}

} // namespace crn::validate
