// Tests turning a rod: the torque that reaches the tip in a straight tube and round a bend, without and with
// friction.
#include "host/base/number_text.hpp"
#include "tools/lab/validate/cases.hpp"
#include "tools/lab/validate/support.hpp"

#include <algorithm>
#include <cmath>

namespace crn::validate
{

namespace
{

constexpr double wire_radius_m = 445e-6;

// --- straight ---

Rig floor_rig(const LumenField &field, double tube_m, const Knot &knot, double length_m)
{
    Start start{.inserted_m = {length_m}, .mouth_m = {0, 0, -(tube_m - wire_radius_m - 2e-6)}};
    double element = element_length(length_m, unsigned(std::min(256.0, length_m / 0.003)));
    Rig rig({uniform_tool(knot, length_m + 10 * element, element)}, &field, start);
    rig.set_gravity({0, 0, -gravity_m_s2});
    rig.step(1500);
    return rig;
}

// The torque of the hand that turns a straight rod in space, where only the drag of the blood resists: mean
// of the last 500 ticks, because the output has steps of 6e-8 N m.
double torque_in_blood(double rate_rad_s, unsigned elements)
{
    const double element = 0.003;
    Rig rig({uniform_tool({}, (elements + 12) * element, element)}, nullptr, {{elements * element}});
    double mean = 0;
    for (int tick = 1; tick <= 1000; tick++) {
        rig.turn(rate_rad_s * 1e-3 * tick);
        rig.step();
        if (tick > 500) mean += rig.handle_torque() / 500;
    }
    return mean;
}

void torque_straight(Result &result, bool quick)
{
    result.title = "Torque in a straight tube";
    result.setup =
        "A wire on the floor of a straight tube of 4 mm. Without friction: 1 m of EI 1e-3 N m2, "
        "two turns at 12 rad/s, the tip's "
        "lag while it turns and after. With friction: 0.3 m of EI 1e-4, 100 g/m, turned by 4.5 "
        "rad and then at 0.05 rad/s; it "
        "has climbed the wall until tan(angle) = mu. In space, 240 elements of 3 mm turn at 19 rad/s "
        "against the drag of the blood.";
    result.formula =
        "tip angle = hand angle; with friction: torque = m g r sin(atan mu), lag = torque L / 2 GJ; "
        "drag 1e-10 N m s for each element";
    result.source = "Saint-Venant torsion; Coulomb";
    const double tube_m = 0.004, rate = 12, turned = 4 * M_PI;
    Path path({-0.03, 0, 0}, {1, 0, 0}, {0, 0, 1});
    path.straight(1.1);
    LumenField field = tube_field(path, tube_m, 0);
    Rig smooth = floor_rig(field, tube_m, {.bend_N_m2 = 1e-3, .twist_N_m2 = 1e-3 / 1.3}, quick ? 0.3 : 0.98);
    double lag = 0;
    const int ticks = int(turned / rate * 1000);
    for (int tick = 1; tick <= ticks; tick++) {
        smooth.turn(turned * tick / ticks);
        smooth.step();
        lag = std::max(lag, (smooth.base_angle() - smooth.tip_angle()) / degree);
    }
    result.absolute("lag_at_12_rad_s", "deg", 0, lag, 1);
    smooth.step(1000);
    result.absolute("tip_after_two_turns", "deg", turned / degree, smooth.tip_angle() / degree, 0.01);
    for (double friction : {0.1, 0.3}) {
        const double bend = 1e-4, length = 0.3, mass = 0.1;
        Rig rough = floor_rig(
            field, tube_m,
            {.bend_N_m2 = bend, .twist_N_m2 = bend / 1.3, .mass_kg_per_m = mass, .friction = friction},
            length);
        double hand_rad = 0;
        for (int tick = 1; tick <= 6000; tick++) {
            hand_rad += tick <= 3000 ? 1.5e-3 : 0.05e-3;
            rough.turn(hand_rad);
            rough.step();
        }
        double torque = mass * length * gravity_m_s2 * wire_radius_m * std::sin(std::atan(friction));
        std::string name = "mu_" + number_text(friction);
        result.relative("torque." + name, "uN m", torque * 1e6, rough.handle_torque() * 1e6, 4);
        result.relative("lag." + name, "deg", torque * length / 2 / (bend / 1.3) / degree,
                        (rough.base_angle() - rough.tip_angle()) / degree, 0.8);
    }
    result.relative("drag_of_blood", "uN m", 1e-10 * 19 * 240 * 1e6, torque_in_blood(19, 240) * 1e6, 35);
}

// --- a J round a bend ---

struct Turned {
    double tip_deg, heading_deg;                  // after a turn and rest
    double lag_max_deg, torque_max_N_m, whip_deg; // largest lag, torque, and turn of the tip in one tick
    Series lag;                                   // hand angle -> lag of the tip, degrees
};

constexpr double hook_radius_m = 0.015, hook_m = 0.03;

// A J tip (radius 15 mm, length 30 mm, EI 1e-4 N m2) on a shaft with EI 1e-3 N m2 lies beyond a bend of 90
// degrees while the hand makes `turns` turns.
Turned turn_hook(double friction, double speed_rad_s, double turns)
{
    Path path({-0.03, 0, 0}, {1, 0, 0}, {0, 0, 1});
    path.straight(0.11).bend(0.05, M_PI / 2).straight(0.15);
    LumenField field = tube_field(path, 0.004, 0);
    Knot shaft{.bend_N_m2 = 1e-3, .twist_N_m2 = 1e-3 / 1.3, .friction = friction};
    Knot hook{.bend_N_m2 = 1e-4,
              .twist_N_m2 = 1e-4 / 1.3,
              .friction = friction,
              .rest_curvature_per_m = 1 / hook_radius_m};
    Tool tool;
    tool.element_m = 0.002;
    tool.knots = {hook, hook, shaft, shaft};
    tool.knots[1].arc_m = tool.knots[2].arc_m = hook_m;
    tool.knots[3].arc_m = 0.4;
    Rig rig({tool}, &field, {{0.06}});
    double inserted = 0.08 + 0.05 * M_PI / 2 + 0.08;
    for (double hand = 0; hand < inserted - 0.06; hand += 5e-5) {
        rig.feed(hand);
        rig.step();
    }
    rig.step(2000);
    auto root = unsigned(hook_m / tool.element_m);
    double tip_start = rig.tip_angle(), heading_start = heading(rig, root), heading_now = heading_start,
           before = tip_start;
    Turned got{0, 0, 0, 0, 0, {"mu " + number_text(friction), {}, {}}};
    int ticks = int(2 * M_PI * turns / speed_rad_s * 1000);
    for (int tick = 1; tick <= ticks + 3000; tick++) {
        double hand = 2 * M_PI * turns * std::min(1.0, double(tick) / ticks);
        rig.turn(hand);
        rig.step();
        double tip = rig.tip_angle();
        heading_now = unwrapped(heading(rig, root), heading_now);
        got.whip_deg = std::max(got.whip_deg, (tip - before) / degree);
        before = tip;
        got.torque_max_N_m = std::max(got.torque_max_N_m, std::fabs(rig.handle_torque()));
        if (tick > ticks) continue;
        got.lag_max_deg = std::max(got.lag_max_deg, (hand - (tip - tip_start)) / degree);
        if (tick % 20) continue;
        got.lag.x.push_back(hand / degree);
        got.lag.y.push_back((hand - (tip - tip_start)) / degree);
    }
    got.tip_deg = (rig.tip_angle() - tip_start) / degree;
    got.heading_deg = (heading_now - heading_start) / degree;
    return got;
}

void torque_bend(Result &result, bool quick)
{
    result.title = "One turn of a J beyond a 90 degree bend";
    result.setup = "J of R 15 mm over 30 mm, EI 1e-4 N m2, on a shaft of 1e-3; tube of 4 mm, bend R 50 mm, "
                   "the J 50-80 mm beyond it. One turn "
                   "of the hand in 6 s, then 3 s of rest. tip: the last edge's frame; heading: the J's "
                   "direction from the nodes' "
                   "positions alone. With friction the tip lags; the lag must grow with mu.";
    result.formula = "tip = hand = 360 degrees without friction; lag(mu) rises";
    result.source = "issue 3, bar 3";
    Plot plot{"Lag of the tip", "hand (degrees)", "hand - tip (degrees)", {}};
    double lag_before = -1, peak_before = -1, least_rise = INFINITY;
    for (double friction : {0.0, 0.05, 0.1, 0.2, 0.3}) {
        if (quick && friction != 0 && friction != 0.2) continue;
        Turned got = turn_hook(friction, quick ? 2 : 1, 1);
        std::string name = "mu_" + number_text(friction);
        double lag = 360 - got.tip_deg;
        if (friction == 0) {
            result.absolute("tip", "deg", 360, got.tip_deg, 1);
            result.absolute("heading", "deg", 360, got.heading_deg, 1);
        } else {
            result.reported("lag_at_rest." + name, "deg", 0, lag);
            least_rise = std::min({least_rise, lag - lag_before, got.lag_max_deg - peak_before});
        }
        result.reported("lag_largest." + name, "deg", 0, got.lag_max_deg);
        result.reported("torque_largest." + name, "uN m", 0, got.torque_max_N_m * 1e6);
        lag_before = lag;
        peak_before = got.lag_max_deg;
        plot.series.push_back(got.lag);
    }
    result.at_most("lag_falls_with_mu", "deg", std::max(0.0, -least_rise), 0);
    result.plots.push_back(plot);
}

} // namespace

std::vector<Case> turn_cases()
{
    return {{"torque_straight", torque_straight}, {"torque_bend", torque_bend}};
}

} // namespace crn::validate
