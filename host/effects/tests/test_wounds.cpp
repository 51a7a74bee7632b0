// These tests check wounds of the vessels against closed forms. Through a hole flows its conductance times
// the pressure before it, and the network loses exactly this flow. The blush has the integral of the leak
// times the concentration, and no iodine is lost. A balloon that fills the vessel before the hole stops it,
// and after the stated time without blood the hole is closed. A flap narrows the lumen by Poiseuille's law,
// and its pocket fills and empties exponentially.
#include "host/effects/contrast_flow.hpp"
#include "host/effects/tests/within.hpp"
#include <cmath>
#include <csetjmp>
#include <cstdarg>
#include <cstddef>
#include <cstdint>
#include <numbers>
extern "C" {
#include <cmocka.h>
}

using namespace crn;
using Eigen::Vector3d;
using tests::within;

namespace
{

using std::numbers::pi;
constexpr double wounded_radius_m = 1.5e-3, wounded_length_m = 0.1, wounded_ml_s = 1.0, wound_step_s = 1e-3;

// Makes one straight artery along x.
VesselTree wounded_artery()
{
    VesselBranch branch;
    branch.name = "artery";
    branch.flow_ml_s = wounded_ml_s;
    for (int i = 0; i <= 100; ++i) {
        branch.points_m.push_back({wounded_length_m * i / 100.0, 0.0, 0.0});
        branch.radii_m.push_back(wounded_radius_m);
    }
    return {{branch}};
}

std::size_t middle_of(const ContrastFlow &flow)
{
    return flow.cells().size() / 2;
}

WallHole hole_at(std::size_t cell, double ml_s_per_mmHg)
{
    WallHole hole;
    hole.cell = cell;
    hole.ml_s_per_mmHg = ml_s_per_mmHg;
    return hole;
}

// Fills the vessel with balls from one place to another one, as an inflated balloon does.
std::vector<ToolBall> balloon_balls(double from_m, double to_m)
{
    std::vector<ToolBall> balls;
    for (double x_m = from_m; x_m <= to_m; x_m += 0.5e-3)
        balls.push_back({{x_m, 0.0, 0.0}, wounded_radius_m});
    return balls;
}

void the_leak_is_the_conductance_times_the_pressure(void **)
{
    ContrastFlow flow(wounded_artery());
    const std::size_t cell = middle_of(flow);
    const double conductance = 2e-3;
    flow.set_hole(0, hole_at(cell, conductance));
    constexpr int steps = 1000;
    for (int i = 0; i < steps; ++i) flow.step({}, {});
    const FlowNetwork &network = flow.network();
    const std::size_t run = network.run_of(cell);
    const double leak_ml_s = conductance * network.pressure_mmHg(cell);
    within("leak, ml/s", network.leak_ml_s(run), leak_ml_s, 1e-12);
    within("leaked, ml", flow.wounds().holes()[0].leaked_ml, leak_ml_s * steps * wound_step_s, 1e-12);
    // What enters the artery leaves it through the hole or into the bed.
    double beds_ml_s = 0.0;
    for (std::size_t r = 0; r < network.runs().size(); ++r) beds_ml_s += network.bed_ml_s(r);
    within("inflow, ml/s", network.inflow_ml_s(0), leak_ml_s + beds_ml_s, 1e-12);
    // The artery before the hole loses little pressure.
    assert_true(network.pressure_mmHg(cell) > 80.0 && network.pressure_mmHg(cell) < mean_pressure_mmHg);
}

// The leak is independent of the network here: two resistances by Poiseuille's law, a hole and a bed.
void a_hole_draws_the_flow_of_two_resistances_in_parallel(void **)
{
    ContrastFlow flow(wounded_artery());
    const std::size_t cell = middle_of(flow);
    const double conductance = 20e-3;
    flow.set_hole(0, hole_at(cell, conductance));
    flow.step({}, {});
    const double per_m =
        8.0 * 3.5e-3 / (pi * std::pow(wounded_radius_m, 4)) / 133.322 * 1e-6; // mmHg s/ml per m
    const FlowCells &cells = flow.cells();
    double before_m = 0.0, all_m = 0.0;
    for (std::size_t i = 0; i < cells.size(); ++i) {
        all_m += cells[i].length_mm * 1e-3;
        if (i <= cell) before_m = all_m;
    }
    const double before = per_m * before_m, behind = per_m * (all_m - before_m);
    const double bed = mean_pressure_mmHg / wounded_ml_s - per_m * all_m;
    const double below = 1.0 / (conductance + 1.0 / (behind + bed));
    const double wanted_mmHg = mean_pressure_mmHg * below / (before + below);
    within("pressure, mmHg", flow.network().pressure_mmHg(cell), wanted_mmHg, 1e-3);
}

void the_blush_is_the_integral_of_leak_times_concentration(void **)
{
    ContrastFlow flow(wounded_artery());
    const std::size_t cell = middle_of(flow);
    flow.set_hole(0, hole_at(cell, 5e-3));
    const CatheterMouth mouth{{5e-3, 0.0, 0.0}, 1.0};
    flow.set_mouths({&mouth, 1});
    double integral_mg = 0.0;
    for (int i = 0; i < 6000; ++i) {
        // The hole takes blood of each layer in proportion to the layer's share of the flow.
        const double mixed = 0.75 * flow.core_mg_per_ml(cell) + 0.25 * flow.wall_mg_per_ml(cell);
        flow.step({}, i < 3000 ? InjectedFluid{1.0, 350.0} : InjectedFluid{});
        integral_mg += mixed * flow.network().leak_ml_s(flow.network().run_of(cell)) * wound_step_s;
    }
    const double blush_mg = flow.wounds().holes()[0].iodine_mg;
    within("blush, mg", blush_mg, integral_mg, 1e-3);
    assert_true(blush_mg > 100.0);
    const IodineBudget &budget = flow.budget();
    within("all iodine, mg", flow.held_mg() + budget.out_mg + budget.reflux_mg + budget.leaked_mg,
           budget.injected_mg, 1e-9);
    // The blush stays when the medium has left the artery.
    const double before_mg = blush_mg;
    for (int i = 0; i < 20000; ++i) flow.step({}, {});
    assert_true(flow.held_mg() < 0.1 && flow.wounds().holes()[0].iodine_mg >= before_mg);
}

void a_balloon_at_the_hole_or_before_it_stops_the_bleeding(void **)
{
    for (const double from_m : {45e-3, 10e-3}) {
        ContrastFlow flow(wounded_artery());
        const std::size_t cell = middle_of(flow);
        flow.set_hole(0, hole_at(cell, 5e-3));
        flow.set_tools(balloon_balls(from_m, from_m + 15e-3));
        for (int i = 0; i < 100; ++i) flow.step({}, {});
        assert_true(flow.wounds().holes()[0].leaked_ml == 0.0);
        flow.set_tools({}); // the balloon is deflated too early
        for (int i = 0; i < 100; ++i) flow.step({}, {});
        assert_true(flow.wounds().holes()[0].leaked_ml > 0.0);
    }
}

void a_balloon_behind_the_hole_does_not_stop_it(void **)
{
    ContrastFlow flow(wounded_artery());
    flow.set_hole(0, hole_at(middle_of(flow), 5e-3));
    flow.set_tools(balloon_balls(70e-3, 85e-3));
    for (int i = 0; i < 100; ++i) flow.step({}, {});
    within("leaked, ml", flow.wounds().holes()[0].leaked_ml, 5e-3 * mean_pressure_mmHg * 0.1, 0.05);
}

void half_of_the_sealing_time_halves_the_hole_and_all_of_it_closes_it(void **)
{
    ContrastFlow flow(wounded_artery());
    WallHole hole = hole_at(middle_of(flow), 5e-3);
    hole.seal_s = 2.0;
    flow.set_hole(0, hole);
    flow.set_tools(balloon_balls(45e-3, 60e-3));
    for (int i = 0; i < 1000; ++i) flow.step({}, {});
    within("open share", flow.wounds().holes()[0].open_share(), 0.5, 1e-9);
    for (int i = 0; i < 1100; ++i) flow.step({}, {});
    flow.take_wounds();
    flow.set_tools({});
    for (int i = 0; i < 1000; ++i) flow.step({}, {});
    assert_true(flow.wounds().holes()[0].leaked_ml == 0.0);
}

WallFlap flap_of(const ContrastFlow &flow, double narrowing)
{
    WallFlap flap;
    flap.begin = middle_of(flow) - 5;
    flap.end = middle_of(flow) + 5;
    flap.narrowing = narrowing;
    flap.pocket_ml = pocket_ml(flow.cells(), flap.begin, flap.end, narrowing);
    return flap;
}

void a_flap_adds_its_resistance_by_poiseuilles_law(void **)
{
    ContrastFlow healthy(wounded_artery()), torn(wounded_artery());
    const double narrowing = 0.6;
    torn.set_flap(0, flap_of(torn, narrowing));
    healthy.step({}, {});
    torn.step({}, {});
    const FlowCells &cells = torn.cells();
    double mm = 0.0;
    for (std::size_t i = middle_of(torn) - 5; i < middle_of(torn) + 5; ++i) mm += cells[i].length_mm;
    const double per_mm = 8.0 * 3.5e-3 / (pi * std::pow(wounded_radius_m, 4)) / 133.322 * 1e-9;
    const double more = per_mm * mm * (std::pow(1.0 - narrowing, -4) - 1.0);
    const double resistance = mean_pressure_mmHg / healthy.network().inflow_ml_s(0);
    within("flow, ml/s", torn.network().inflow_ml_s(0), mean_pressure_mmHg / (resistance + more), 1e-3);
}

void a_closed_flap_lets_nothing_pass(void **)
{
    ContrastFlow flow(wounded_artery());
    flow.set_flap(0, flap_of(flow, 1.0));
    flow.step({}, {});
    assert_true(flow.network().inflow_ml_s(0) == 0.0);
}

// The pocket's volume is the part of the lumen that the flap takes: 1 - (1 - n)^2 of it.
void the_pocket_is_the_lumen_that_the_flap_takes(void **)
{
    const ContrastFlow flow(wounded_artery());
    const WallFlap flap = flap_of(flow, 0.4);
    double mm = 0.0;
    for (std::size_t i = flap.begin; i < flap.end; ++i) mm += flow.cells()[i].length_mm;
    within("pocket, ml", flap.pocket_ml, (1.0 - 0.36) * pi * 1.5 * 1.5 * mm * 1e-3, 1e-3);
}

// After the medium has left the lumen, the pocket empties into clear blood: as exp(-t / empty_s).
void the_pocket_keeps_medium_for_its_own_time(void **)
{
    ContrastFlow flow(wounded_artery());
    WallFlap flap = flap_of(flow, 0.4);
    flap.fill_s = 0.5;
    flap.empty_s = 30.0;
    flow.set_flap(0, flap);
    const CatheterMouth mouth{{5e-3, 0.0, 0.0}, 1.0};
    flow.set_mouths({&mouth, 1});
    for (int i = 0; i < 3000; ++i) flow.step({}, {1.5, 350.0});
    within("full pocket, mg/ml", flow.wounds().flaps()[0].pocket_mg_per_ml(), 350.0, 0.02);
    for (int i = 0; i < 5000; ++i) flow.step({}, {}); // the lumen clears
    const double before_mg = flow.wounds().flaps()[0].iodine_mg;
    for (int i = 0; i < 15000; ++i) flow.step({}, {});
    within("left in the pocket", flow.wounds().flaps()[0].iodine_mg / before_mg, std::exp(-0.5), 0.03);
    const IodineBudget &budget = flow.budget();
    within("all iodine, mg", flow.held_mg() + budget.out_mg + budget.reflux_mg, budget.injected_mg, 1e-9);
}

void a_snapshot_keeps_the_wounds(void **)
{
    ContrastFlow flow(wounded_artery());
    flow.set_hole(0, hole_at(middle_of(flow), 5e-3));
    flow.set_flap(0, flap_of(flow, 0.4));
    for (int i = 0; i < 100; ++i) flow.step({}, {});
    ContrastFlow other(wounded_artery());
    assert_true(other.restore(flow.snapshot()));
    for (int i = 0; i < 100; ++i) {
        flow.step({}, {});
        other.step({}, {});
    }
    assert_true(flow.wounds().leaked_ml() == other.wounds().leaked_ml());
    assert_true(flow.snapshot() == other.snapshot());
}

} // namespace

int main()
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_leak_is_the_conductance_times_the_pressure),
        cmocka_unit_test(a_hole_draws_the_flow_of_two_resistances_in_parallel),
        cmocka_unit_test(the_blush_is_the_integral_of_leak_times_concentration),
        cmocka_unit_test(a_balloon_at_the_hole_or_before_it_stops_the_bleeding),
        cmocka_unit_test(a_balloon_behind_the_hole_does_not_stop_it),
        cmocka_unit_test(half_of_the_sealing_time_halves_the_hole_and_all_of_it_closes_it),
        cmocka_unit_test(a_flap_adds_its_resistance_by_poiseuilles_law),
        cmocka_unit_test(a_closed_flap_lets_nothing_pass),
        cmocka_unit_test(the_pocket_is_the_lumen_that_the_flap_takes),
        cmocka_unit_test(the_pocket_keeps_medium_for_its_own_time),
        cmocka_unit_test(a_snapshot_keeps_the_wounds),
    };
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
