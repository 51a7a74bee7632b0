// Tests tools that lie inside one another. The stiffnesses of such tools must add up, and their shapes must
// combine. The combined rod must not jump when another tool becomes the one that reaches farthest.
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

constexpr double wire_N_m2 = 3e-4, catheter_N_m2 = 5e-4, element_m = 0.002;

Knot wire_knot(double bend)
{
    return {.bend_N_m2 = bend, .twist_N_m2 = bend / 1.3};
}

Knot catheter_knot(double bend)
{
    return {.bend_N_m2 = bend, .twist_N_m2 = bend / 1.3, .radius_m = 835e-6, .radius_inner_m = 485e-6};
}

// --- stiffness adds ---

void stiffness_adds(Result &result, bool quick)
{
    result.title = "A catheter over a wire: stiffness adds";
    result.setup =
        "Wire of 3e-4 and catheter of 5e-4 N m2, straight, 0.2 m of wire beyond the mouth, dead load across "
        "at its tip. Tips "
        "together: elastica of the sum. Catheter part of the way: small deflections of the stepped beam.";
    result.formula =
        "EI = EI_w + EI_c; stepped: delta = P/3 ((L^3 - a^3) / (EI_w + EI_c) + a^3 / EI_w), a = free wire";
    result.source = "elastica by shooting; Euler-Bernoulli beam";
    const double length = 0.2;
    Tool wire = uniform_tool(wire_knot(wire_N_m2), 0.25, element_m);
    Tool catheter = uniform_tool(catheter_knot(catheter_N_m2), 0.25, element_m);
    Rig rig({wire, catheter}, nullptr, {{length, length - 1e-6}});
    double free = rig.inserted(), sum = wire_N_m2 + catheter_N_m2;
    for (double load : {1.0, 5.0}) {
        rig.set_tip_load({0, 0, -load * sum / (free * free)});
        settle(rig, 1e-7, 20000);
        PlaneShape shape = elastica(load, 0);
        Vector3d tip = rig.position(0) / free;
        double off = std::hypot(tip[0] - shape.x.back(), tip[2] - shape.y.back());
        result.error("tips_together.load_" + number_text(load), "y/L", shape.y.back(), tip[2], 100 * off,
                     "% of L", 0.3);
    }
    Plot plot{"Tip deflection with the catheter's tip at ...",
              "catheter beyond the mouth / L",
              "deflection / of the wire alone",
              {}};
    Series ours{"ours", {}, {}, true}, line{"stepped beam", {}, {}};
    double force = 0.02 * wire_N_m2 / (length * length);
    for (double part : {0.101, 0.301, 0.503, 0.757, 0.951}) {
        if (quick && part != 0.503) continue;
        Rig stepped({wire, catheter}, nullptr, {{length, part * length}});
        stepped.set_tip_load({0, 0, -force});
        settle(stepped, 1e-9, 20000);
        double L = stepped.inserted(), a = L - stepped.inserted(1);
        double deflection = force / 3 * ((L * L * L - a * a * a) / sum + a * a * a / wire_N_m2);
        result.relative("catheter_at_" + number_text(part), "mm", deflection * 1e3,
                        -stepped.position(0)[2] * 1e3, 1);
        ours.x.push_back(part);
        ours.y.push_back(-stepped.position(0)[2] / (force * L * L * L / 3 / wire_N_m2));
    }
    for (double part = 0; part <= 1; part += 0.01) {
        line.x.push_back(part);
        line.y.push_back((1 - std::pow(1 - part, 3)) * wire_N_m2 / sum + std::pow(1 - part, 3));
    }
    plot.series = {line, ours};
    result.plots.push_back(plot);
}

// --- a straight catheter opens a J ---

// Returns the angle, in degrees, between the directions of the tip and of the introducer, as the sum of the
// angles between neighbouring segments.
double opening(const Rig &rig)
{
    std::vector<Vector3d> points = rig.shape();
    double sum = 0;
    for (std::size_t i = 1; i + 1 < points.size(); i++) {
        Vector3d a = (points[i - 1] - points[i]).normalized(), b = (points[i] - points[i + 1]).normalized();
        sum += std::atan2(a.cross(b).norm(), a.dot(b));
    }
    return sum / degree;
}

constexpr double hook_m = 0.03, hook_radius_m = 0.015;

Tool hooked(const Knot &shaft, double length_m)
{
    Knot hook = shaft;
    hook.rest_curvature_per_m = 1 / hook_radius_m;
    Tool tool;
    tool.element_m = 0.001;
    tool.knots = {hook, hook, shaft, shaft};
    tool.knots[1].arc_m = tool.knots[2].arc_m = hook_m;
    tool.knots[3].arc_m = length_m;
    return tool;
}

void opens_hook(Result &result, bool quick)
{
    result.title = "A straight catheter opens the wire's J, a straight wire the catheter's";
    result.setup = "In free space: J of R 15 mm over 30 mm. The straight tool is slid over (into) it at 20 "
                   "mm/s and stops at several places; "
                   "the turning from mouth to tip, summed over the nodes.";
    result.formula = "angle = (bare + covered EI_J / (EI_J + EI_straight)) / R; bare, covered: arc of the J "
                     "without and with the other tool (less half an element at a bare tip)";
    result.source = "Euler-Bernoulli beams side by side";
    Plot plot{"Opening of a J", "J covered (mm)", "turning (degrees)", {}};
    for (bool wire_is_hooked : {true, false}) {
        double hook_bend = 1e-4, straight_bend = 4e-4;
        Tool wire = wire_is_hooked ? hooked(wire_knot(hook_bend), 0.12)
                                   : uniform_tool(wire_knot(straight_bend), 0.12, 0.001);
        Tool catheter = wire_is_hooked ? uniform_tool(catheter_knot(straight_bend), 0.12, 0.001)
                                       : hooked(catheter_knot(hook_bend), 0.12);
        double begin = 0.04, end = 0.0805; // beyond the inserter; the J lies from 0.05 to 0.08
        Start start{.inserted_m = wire_is_hooked ? std::vector{0.08, begin} : std::vector{begin, 0.08}};
        Rig rig({wire, catheter}, nullptr, start);
        settle(rig, 1e-7, 4000);
        unsigned moving = wire_is_hooked ? 1 : 0;
        std::string name = wire_is_hooked ? "wire_J" : "catheter_J";
        Series ours{name, {}, {}, true}, line{"closed form", {}, {}};
        double hand = 0;
        for (double to : {0.04, 0.0555, 0.0605, 0.0655, 0.0705, 0.0755, end}) {
            if (quick && to != 0.04 && to != 0.0655) continue;
            for (; hand < to - begin - 1e-9; hand += 2e-5) {
                rig.feed(hand, moving);
                rig.step();
            }
            rig.feed(to - begin, moving);
            settle(rig, 1e-7, 6000);
            double covered =
                std::clamp(rig.inserted(moving) - (rig.inserted(1 - moving) - hook_m), 0.0, hook_m);
            double share = hook_bend / (hook_bend + straight_bend);
            double straight_tip = covered < hook_m ? 0.0005 : 0; // half an element has no joint
            double expected = ((hook_m - straight_tip - covered) + covered * share) / hook_radius_m / degree;
            double got = opening(rig);
            result.absolute(name + ".covered_" + number_text(std::round(covered * 1e4) / 10) + "mm", "deg",
                            expected, got, 0.5);
            ours.x.push_back(covered * 1e3);
            ours.y.push_back(got);
        }
        for (double covered = 0; covered <= hook_m; covered += 0.001) {
            line.x.push_back(covered * 1e3);
            line.y.push_back((hook_m - 0.0005 - covered * 0.8) / hook_radius_m / degree);
        }
        plot.series.push_back(ours);
        if (!wire_is_hooked) plot.series.push_back(line);
    }
    result.plots.push_back(plot);
}

// --- change of the lead ---

// The test pushes a catheter over a resting wire in a bend until the catheter reaches 20 mm beyond the wire,
// and then draws the catheter back. We take the largest displacement per tick of any node outside the
// catheter, and subtract the displacement of the hand that moves the catheter.
void lead_change(Result &result, bool quick)
{
    result.title = "Change of the leading tool";
    result.setup = "Wire of 3e-4 N m2 and catheter of 5e-4 in a tube of 4 mm with a 90 degree bend of R 60 "
                   "mm, friction 0.1; the catheter "
                   "is pushed past the resting wire's tip and drawn back. Largest distance per tick, within "
                   "2 mm of both tips being level, "
                   "of the wire's tip from where it lay before.";
    result.formula = "node motion <= 0.1 mm per tick at 50 mm/s, outside snaps";
    result.source = "issue 3, item 1";
    Path path({-0.03, 0, 0}, {1, 0, 0}, {0, 0, 1});
    path.straight(0.09).bend(0.06, M_PI / 2).straight(0.15);
    LumenField field = tube_field(path, 0.004, 0);
    for (double speed : {0.02, 0.05}) {
        if (quick && speed < 0.05) continue;
        Knot inner = wire_knot(wire_N_m2), outer = catheter_knot(catheter_N_m2);
        inner.friction = outer.friction = 0.1;
        Tool catheter = uniform_tool(outer, 0.32, element_m);
        catheter.lumen_friction = 0.05;
        Rig rig({uniform_tool(inner, 0.32, element_m), catheter}, &field, {{0.05, 0.04}});
        double hand = 0;
        for (; hand < 0.12; hand += 5e-5) { // both to the middle of the bend
            rig.feed(hand, 0);
            rig.feed(hand, 1);
            rig.step();
        }
        rig.step(1000);
        double wire_hand = hand, worst = 0;
        bool led_by_catheter = false;
        auto wire_tip = [&] { // by arc length from the leading tip
            double behind = std::max(rig.inserted(0), rig.inserted(1)) - rig.inserted(0);
            unsigned i = 0;
            while (rig.arc(i + 1) <= behind) i++;
            double part = (behind - rig.arc(i)) / (rig.arc(i + 1) - rig.arc(i));
            return Vector3d(rig.position(i) + part * (rig.position(i + 1) - rig.position(i)));
        };
        for (int way : {1, -1}) {
            for (double moved = 0; moved < 0.03; moved += speed * 1e-3) {
                hand += way * speed * 1e-3;
                rig.feed(hand, 1);
                rig.feed(wire_hand, 0);
                Vector3d before = wire_tip();
                rig.step();
                led_by_catheter |= rig.inserted(1) > rig.inserted(0) + 0.01;
                if (std::fabs(rig.inserted(1) - rig.inserted(0)) < 0.002)
                    worst = std::max(worst, (wire_tip() - before).norm());
            }
        }
        std::string name = number_text(speed * 1e3) + "mm_s";
        result.at_most("step." + name, "mm/tick", worst * 1e3, 0.1);
        result.at_most("catheter_never_led." + name, "", !led_by_catheter, 0);
    }
}

// --- rubbing ---

// Half of the difference between the catheter's hand force (or torque) on the way there and back. The wire's
// J lies wholly in the catheter, so that no elastic force acts along the tools.
double rubbing(bool turns, double hook_N_m2)
{
    Tool catheter = uniform_tool(catheter_knot(4e-4), 0.3, 0.001);
    catheter.lumen_friction = 0.1;
    Rig rig({hooked(wire_knot(hook_N_m2), 0.3), catheter}, nullptr, {{0.15, 0.17}});
    rig.step(2000);
    double mean[2] = {0, 0}, hand = 0;
    for (int way : {0, 1})
        for (int tick = 0; tick < 800; tick++) {
            hand += (way == 0 ? 1 : -1) * (turns ? 2e-3 : 5e-6);
            if (turns)
                rig.turn(hand, 1);
            else
                rig.feed(hand, 1);
            rig.step();
            if (tick >= 700) mean[way] += (turns ? rig.handle_torque(1) : rig.handle_axial(1)) / 100;
        }
    return (mean[0] - mean[1]) / 2;
}

void rubbing_case(Result &result, bool)
{
    result.title = "Sliding and turning between tools";
    result.setup =
        "In free space, a wire with a J of R 15 mm lies in a straight catheter, 20 mm behind its tip, "
        "friction 0.1. The catheter slides by 4 mm and back, or turns by 1.6 rad and back.";
    result.formula = "torque / force = radius of the inner tool";
    result.source = "Coulomb: the same normal forces resist with mu N and mu N r";
    const double force_N = rubbing(false, 1e-4), torque_N_m = rubbing(true, 1e-4);
    result.relative("radius", "mm", 0.445, 1e3 * torque_N_m / force_N, 2);
}

} // namespace

std::vector<Case> coaxial_cases()
{
    return {{"stiffness_adds", stiffness_adds},
            {"opens_hook", opens_hook},
            {"rubbing", rubbing_case},
            {"lead_change", lead_change}};
}

} // namespace crn::validate
