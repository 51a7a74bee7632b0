// These tests check the following. Contrast medium in a tree of vessels moves with the blood, and at a fork
// the medium divides in proportion to the conductances. None is lost or created. Contrast medium flows back
// if more is injected than the blood carries away, and it does not move where the catheter fills the lumen.
// Each test compares the simulation with a formula that the test contains.
#include "host/effects/contrast_flow.hpp"
#include "host/effects/tests/within.hpp"
#include <cmath>
#include <csetjmp>
#include <cstdarg>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <numbers>
#include <random>
extern "C" {
#include <cmocka.h>
}

using namespace crn;
using Eigen::Vector3d;
using tests::within;

namespace
{

using std::numbers::pi;
constexpr double iodine = 350.0;

VesselBranch straight(const char *name, const Vector3d &from_mm, const Vector3d &to_mm, double radius_mm,
                      double flow_ml_s)
{
    VesselBranch branch;
    branch.name = name;
    branch.flow_ml_s = flow_ml_s;
    for (int i = 0; i <= 20; ++i) {
        branch.points_m.push_back((from_mm + (to_mm - from_mm) * (i / 20.0)) * 1e-3);
        branch.radii_m.push_back(radius_mm * 1e-3);
    }
    return branch;
}

// Makes a tube of 400 mm along x with a radius of 3 mm.
VesselTree tube(double flow_ml_s)
{
    return {{straight("tube", {0, 0, 0}, {400, 0, 0}, 3.0, flow_ml_s)}};
}

// Makes a trunk along x that divides at its end into a wide and a thin branch.
VesselTree fork()
{
    VesselTree tree{{straight("trunk", {0, 0, 0}, {60, 0, 0}, 4.0, 0.0),
                     straight("wide", {60, 0, 0}, {300, 200, 0}, 3.0, 6.0),
                     straight("thin", {60, 0, 0}, {300, -200, 0}, 1.0, 3.0)}};
    for (std::size_t b : {1, 2}) {
        tree.branches[b].parent = 0;
        tree.branches[b].parent_point = 20;
    }
    return tree;
}

// Makes an aorta along y with a renal artery that leaves the aorta in the middle.
VesselTree aorta()
{
    VesselTree tree{{straight("aorta", {0, 0, 0}, {0, -200, 0}, 10.0, 40.0),
                     straight("renal", {0, -100, 0}, {90, -100, 0}, 3.0, 8.0)}};
    tree.branches[1].parent = 0;
    tree.branches[1].parent_point = 10;
    return tree;
}

void inject_at(ContrastFlow &contrast, const Vector3d &place_mm)
{
    const CatheterMouth mouth{place_mm * 1e-3, 1.0};
    contrast.set_mouths({&mouth, 1});
}

double held_in(const ContrastFlow &contrast, std::size_t branch)
{
    double mg = 0.0;
    for (std::size_t i = contrast.cells().branch_begin(branch); i < contrast.cells().branch_begin(branch + 1);
         ++i)
        mg += contrast.iodine_mg_per_ml(i) * contrast.cells()[i].volume_ml;
    return mg;
}

// Returns the position along x, in mm, at which the concentration of contrast medium falls to half of that in
// the first cell.
double front_mm(const ContrastFlow &contrast)
{
    const double half = 0.5 * contrast.iodine_mg_per_ml(0);
    std::size_t i = 0;
    while (contrast.iodine_mg_per_ml(i) > half) ++i;
    const double before = contrast.iodine_mg_per_ml(i - 1), here = contrast.iodine_mg_per_ml(i);
    const double share = (before - half) / (before - here);
    const double a = contrast.cells().middle_m(i - 1).x() * 1e3, b = contrast.cells().middle_m(i).x() * 1e3;
    return a + share * (b - a);
}

// --- transport ---

// Returns the flow into the vascular bed behind the last cell, in ml/s.
double out_of_the_last(const ContrastFlow &contrast)
{
    return contrast.network().outflow_ml_s(contrast.network().runs().size() - 1);
}

// With plug flow a front of contrast medium in a straight tube moves by flow / area: 10 ml/s in 28.3 mm^2
// give 354 mm/s.
void a_front_moves_with_flow_over_area(void **)
{
    ContrastFlow contrast(tube(10.0), {3.5, 0.5, 30.0});
    inject_at(contrast, {0, 0, 0});
    double flow_ml_s = 0.0, first_mm = 0.0;
    for (int tick = 1; tick <= 800; ++tick) {
        contrast.step({}, {5.0, iodine});
        if (tick == 200) first_mm = front_mm(contrast);
    }
    flow_ml_s = out_of_the_last(contrast);
    within("front speed, mm/s", (front_mm(contrast) - first_mm) / 0.6, flow_ml_s * 1e3 / (pi * 9.0), 0.01);
}

// In laminar flow the two layers of blood move at 1.5 and 0.5 times the mean speed. The volume of blood that
// contrast medium has replaced (the mean position of the front times the area) must grow by exactly the flow.
void a_laminar_front_is_long_and_its_mean_moves_with_the_flow(void **)
{
    ContrastFlow contrast(tube(10.0), {3.5, 0.75, 1e9});
    inject_at(contrast, {0, 0, 0});
    double core_ml = 0.0, wall_ml = 0.0;
    const FlowCells &cells = contrast.cells();
    for (int tick = 1; tick <= 500; ++tick) contrast.step({}, {5.0, iodine});
    const double flow_ml_s = out_of_the_last(contrast), plateau = iodine * 5.0 / flow_ml_s;
    for (std::size_t i = 0; i < cells.size(); ++i) {
        core_ml += contrast.core_mg_per_ml(i) / plateau * cells[i].volume_ml / 2;
        wall_ml += contrast.wall_mg_per_ml(i) / plateau * cells[i].volume_ml / 2;
    }
    within("replaced, ml", core_ml + wall_ml, flow_ml_s * 0.5, 1e-9);
    within("core over wall", core_ml / wall_ml, 3.0, 1e-6);
}

// The two layers of blood move at U(1 +- 1/2), where U is the mean speed, and the difference of their
// concentrations falls at the rate U/lambda, where lambda is the mixing length. In these two layers of blood,
// with the mean speed U and the mixing length lambda, a pulse of contrast medium spreads with the dispersion
// D = U lambda / 4. The upwind rule with cells of length L adds U L / 2 to the dispersion, and the time step
// removes a part of this addition. With L = 1.5 mm, the upwind rule and the time step together add 3 % to the
// dispersion.
void a_pulse_spreads_as_the_two_layers_say(void **)
{
    const VesselTree tree{{straight("tube", {0, 0, 0}, {1900, 0, 0}, 3.0, 10.0)}};
    ContrastFlow contrast(tree);
    inject_at(contrast, {0, 0, 0});
    const auto variance_mm2 = [&] {
        double sum = 0.0, first = 0.0, second = 0.0;
        for (std::size_t i = 0; i < contrast.cells().size(); ++i) {
            const double mg = contrast.iodine_mg_per_ml(i), x = contrast.cells().middle_m(i).x() * 1e3;
            sum += mg;
            first += mg * x;
            second += mg * x * x;
        }
        return second / sum - first / sum * first / sum;
    };
    double before = 0.0;
    for (int tick = 1; tick <= 2000; ++tick) {
        contrast.step({}, {tick <= 50 ? 2.0 : 0.0, iodine});
        if (tick == 1500) before = variance_mm2();
    }
    const double speed_mm_s = out_of_the_last(contrast) * 1e3 / (pi * 9.0);
    within("D, mm2/s", (variance_mm2() - before) / (2 * 0.5), speed_mm_s * 90.0 / 4 + speed_mm_s * 1.5 / 4,
           0.03);
}

// Blood that flows past the catheter dilutes the injected fluid to S / Q of its concentration, where S is the
// injected flow and Q the total flow.
void injected_fluid_is_diluted_by_the_blood_that_flows(void **)
{
    ContrastFlow contrast(tube(10.0));
    inject_at(contrast, {0, 0, 0});
    for (int tick = 0; tick < 12000; ++tick) contrast.step({}, {2.0, iodine});
    const double flow_ml_s = out_of_the_last(contrast);
    within("mg/ml", contrast.iodine_mg_per_ml(contrast.cells().size() - 1), iodine * 2.0 / flow_ml_s, 1e-6);
}

// A long artery takes pressure from its bed, but no flow: the bed is so open that the stated flow leaves the
// vessels. The tube has 400 mm and a radius of 1.5 mm, and Poiseuille's drop at the stated flow is a seventh
// of the pressure. With a bed that would take the stated flow at the whole pressure, 12 % of it would be
// missing.
void the_stated_flow_comes_out_of_a_long_artery(void **)
{
    constexpr double stated_ml_s = 2.0, length_mm = 400.0, radius_mm = 1.5;
    VesselTree tree{{straight("long", {0, 0, 0}, {length_mm, 0, 0}, radius_mm, stated_ml_s)}};
    FlowNetwork network(FlowCells(tree), 3.5);
    network.settle({});
    const double drop_mmHg = 8 * 3.5 * length_mm * stated_ml_s / (pi * std::pow(radius_mm, 4)) / 133.322;
    within("drop, mmHg", mean_pressure_mmHg - network.pressure_mmHg(FlowCells(tree).size() - 1), drop_mmHg,
           1e-6);
    assert_true(drop_mmHg > 0.1 * mean_pressure_mmHg);
    within("out, ml/s", network.outflow_ml_s(network.runs().size() - 1), stated_ml_s, 1e-6);
    within("in, ml/s", network.inflow_ml_s(0), stated_ml_s, 1e-6);
    // A lesion takes flow from the same bed, because the bed is that of the healthy vessel.
    VesselLesion lesion;
    for (std::size_t i = 0; i < 3; ++i) {
        lesion.healthy_points_m.push_back(tree.branches[0].points_m[i]);
        lesion.healthy_radii_m.push_back(radius_mm * 1e-3);
    }
    tree.branches[0].radii_m[1] = 0.5e-3;
    tree.lesions = {lesion};
    FlowNetwork narrowed(FlowCells(tree), 3.5);
    narrowed.settle({});
    assert_true(narrowed.inflow_ml_s(0) < 0.9 * stated_ml_s);
}

// In a tree whose artery divides, every bed takes its stated flow, and the inlet gives their sum.
void the_flows_of_a_tree_are_the_stated_ones(void **)
{
    const VesselTree tree = fork();
    const FlowCells cells(tree);
    FlowNetwork network(cells, 3.5);
    network.settle({});
    double out_ml_s = 0.0, stated_ml_s = 0.0;
    for (std::size_t run = 0; run < network.runs().size(); ++run) {
        const double flow_ml_s = cells[network.runs()[run].end - 1].outlet_ml_s;
        if (flow_ml_s > 0.0) within("out, ml/s", network.outflow_ml_s(run), flow_ml_s, 1e-6);
        out_ml_s += network.outflow_ml_s(run);
        stated_ml_s += flow_ml_s;
    }
    within("in, ml/s", network.inflow_ml_s(0), out_ml_s, 1e-12);
    within("in over stated", network.inflow_ml_s(0), stated_ml_s, 1e-6);
}

// The paths behind the fork divide the flow as 1 / (R + 1/G), where R is the Poiseuille resistance of a
// vessel and G the conductance of the vascular bed behind it. At rest these are the stated flows, and a fast
// injection divides in the same way.
void a_fork_divides_iodine_as_its_conductances(void **)
{
    ContrastFlow contrast(fork());
    inject_at(contrast, {0, 0, 0});
    for (int tick = 0; tick < 300; ++tick) contrast.step({}, {4.0, iodine});
    // When the test compares the branches, hardly any contrast medium has left the tree of vessels, so each
    // branch still holds all medium that entered it.
    assert_true(contrast.budget().out_mg < 1e-6 * contrast.budget().injected_mg);
    within("wide over thin", held_in(contrast, 1) / held_in(contrast, 2), 6.0 / 3.0, 0.01);
}

// The heart beats for 60 s. During this time there are several injections, one of which refluxes, and the
// catheter enters the renal artery and leaves it again.
void iodine_is_conserved_and_stays_between_none_and_injected(void **)
{
    ContrastFlow contrast(aorta());
    double least = 0.0, most = 0.0;
    for (std::uint32_t tick = 0; tick < 60000; ++tick) {
        if (tick % 1000 == 0) {
            const bool is_in = tick / 1000 % 3 == 1;
            const Vector3d tip_mm(is_in ? 20.0 : 0.0, tick / 1000 % 3 == 2 ? -1.0 : -100.0, 0);
            const ToolBall tip{tip_mm * 1e-3, is_in ? 2.9e-3 : 1e-3};
            contrast.set_tools({&tip, 1});
            inject_at(contrast, tip_mm);
        }
        const bool is_injecting = tick < 45000 && tick % 2000 < 1200;
        contrast.step(flow_drive(steady_beat(tick, 75)),
                      {is_injecting ? 15.0 + tick % 7000 * 0.01 : 0.0, iodine});
        for (std::size_t i = 0; tick % 50 == 0 && i < contrast.cells().size(); ++i) {
            least = std::fmin(least, std::fmin(contrast.core_mg_per_ml(i), contrast.wall_mg_per_ml(i)));
            most = std::fmax(most, std::fmax(contrast.core_mg_per_ml(i), contrast.wall_mg_per_ml(i)));
        }
    }
    const IodineBudget &budget = contrast.budget();
    assert_true(budget.injected_mg > 1e5 && budget.out_mg > 1e4 && budget.reflux_mg > 1e4);
    within("iodine, mg", contrast.held_mg() + budget.out_mg + budget.reflux_mg, budget.injected_mg, 1e-9);
    if (least < 0.0 || most > iodine * (1 + 1e-9))
        fail_msg("concentrations %.17g to %.17g mg/ml", least, most);
}

// --- distribution ---

void more_than_flows_away_goes_back_upstream(void **)
{
    ContrastFlow gentle(aorta()), forced(aorta());
    for (ContrastFlow *contrast : {&gentle, &forced}) {
        inject_at(*contrast, {20, -100, 0});
        for (int tick = 0; tick < 150; ++tick) contrast->step({}, {contrast == &gentle ? 4.0 : 20.0, iodine});
    }
    assert_true(held_in(gentle, 0) == 0.0);
    // The vascular bed of the renal artery cannot take all contrast medium; the remainder must have flowed
    // back past the tip into the aorta.
    const FlowCells &cells = forced.cells();
    double back_mg = held_in(forced, 0);
    for (std::size_t i = cells.branch_begin(1); i < cells.size(); ++i)
        if (cells.middle_m(i).x() < 0.0195) back_mg += forced.iodine_mg_per_ml(i) * cells[i].volume_ml;
    within("mg back", back_mg, iodine * (20.0 - out_of_the_last(forced)) * 0.15, 0.03);
}

// A catheter as wide as the vessel blocks the flow: no blood flows past the catheter. The injected fluid
// flows downstream undiluted, and no fluid flows back.
void a_wedged_catheter_lets_nothing_past(void **)
{
    ContrastFlow contrast(aorta());
    const ToolBall tip{Vector3d(0.02, -0.1, 0), 3e-3};
    contrast.set_tools({&tip, 1});
    inject_at(contrast, {30, -100, 0});
    for (int tick = 0; tick < 4000; ++tick) contrast.step({}, {2.0, iodine});
    assert_true(held_in(contrast, 0) == 0.0);
    within("outflow, ml/s", out_of_the_last(contrast), 2.0, 1e-9);
    within("mg/ml", contrast.iodine_mg_per_ml(contrast.cells().size() - 1), iodine, 1e-3);
    for (int tick = 0; tick < 1000; ++tick) contrast.step({}, {});
    assert_true(held_in(contrast, 1) > 300.0); // no flow: nothing washes it out
}

// The reference is the textbook formula for a concentric annulus, evaluated with the functions of libm.
void a_tool_in_the_lumen_leaves_an_annulus(void **)
{
    for (double k = 0.02; k < 0.97; k += 0.01) {
        const double expected = 1 - std::pow(k, 4) - std::pow(1 - k * k, 2) / std::log(1 / k);
        if (std::fabs(annulus_share(k) - expected) > 1e-7)
            fail_msg("%g: %g, expected %g", k, annulus_share(k), expected);
    }
    assert_true(annulus_share(0.0) == 1.0 && annulus_share(0.98) == 0.0 && annulus_share(2.0) == 0.0);
}

void without_a_mouth_nothing_is_injected(void **)
{
    ContrastFlow contrast(aorta());
    contrast.step({}, {5.0, iodine});
    assert_true(contrast.held_mg() == 0.0 && contrast.budget().injected_mg == 0.0);
}

void side_holes_share_the_flow(void **)
{
    ContrastFlow contrast(fork());
    const CatheterMouth mouths[] = {{Vector3d(0.2, 0.14 * 0.8333, 0), 0.25},
                                    {Vector3d(0.2, -0.14 * 0.8333, 0), 0.75}};
    contrast.set_mouths(mouths);
    contrast.step({}, {4.0, iodine});
    within("thin over wide", held_in(contrast, 2) / held_in(contrast, 1), 3.0, 1e-9);
}

// The power distance decides in which vessel a tip lies. At the renal ostium, a tip that is nearer to the
// renal centreline than to the wall counts as in the renal artery.
void the_cell_is_that_of_the_vessel_in_which_the_tip_lies_deepest(void **)
{
    const FlowCells cells(aorta());
    assert_int_equal(cells[cells.nearest(Vector3d(0.012, -0.1, 0))].branch, 1);
    assert_int_equal(cells[cells.nearest(Vector3d(0.008, -0.1, 0))].branch, 0);
    assert_int_equal(cells[cells.nearest(Vector3d(0.0, -0.1, 0.009))].branch, 0);
}

// The search leaves out groups of cells; it must find the cell that a search of all cells finds.
void the_cell_is_that_of_a_search_of_all_cells(void **)
{
    const FlowCells cells(aorta());
    std::mt19937 random(1);
    auto within_m = [&](double low, double high) { return low + (high - low) * random() / 4294967295.0; };
    for (int turn = 0; turn < 2000; ++turn) {
        const Vector3d place_m(within_m(-0.1, 0.2), within_m(-0.4, 0.3), within_m(-0.1, 0.1));
        std::size_t best = 0;
        auto power = [&](std::size_t i) {
            const double radius_m = cells[i].radius_mm * 1e-3;
            return (place_m - cells.middle_m(i)).squaredNorm() - radius_m * radius_m;
        };
        for (std::size_t i = 1; i < cells.size(); ++i)
            if (power(i) < power(best)) best = i;
        assert_int_equal(cells.nearest(place_m), best);
        assert_int_equal(cells.nearest(place_m, static_cast<std::size_t>(turn) % (cells.size() + 20)), best);
    }
}

// --- time ---

void aorta_flows_in_systole_and_coronary_beds_more_in_diastole(void **)
{
    double sum[3] = {0, 0, 0}, systolic[3] = {0, 0, 0};
    for (std::uint32_t tick = 0; tick < 60000; ++tick) {
        const BeatPhase phase = steady_beat(tick, 70);
        const FlowDrive drive = flow_drive(phase);
        for (std::size_t k = 0; k < 3; ++k) {
            sum[k] += drive.openness[k];
            if (phase.since_opening_s < phase.systole_s) systolic[k] += drive.openness[k];
        }
    }
    for (double bed : sum) within("mean openness", bed / 60000, 1.0, 1e-3);
    assert_true(systolic[0] / sum[0] > 0.5);
    // Doppler wires in 301 patients: mean velocity of diastole over that of systole, 1.85 +- 0.70 in the left
    // artery and 1.53 +- 0.34 in the right one (Seligman et al., EuroIntervention 2021). The bar is three
    // times the difference from these means, and a quarter of the deviations or less.
    const double systole_share = steady_beat(0, 70).systole_s / steady_beat(0, 70).beat_s;
    auto diastole_over_systole = [&](std::size_t bed) {
        return (sum[bed] - systolic[bed]) / (1.0 - systole_share) / (systolic[bed] / systole_share);
    };
    within("left coronary bed, diastole over systole", diastole_over_systole(1), 1.85, 0.05);
    within("right coronary bed, diastole over systole", diastole_over_systole(2), 1.53, 0.05);
    BeatPhase none;
    none.is_beating = false;
    assert_true(flow_drive(none).pressure_mmHg == 0.0);
}

// At 40, 70 and 150 beats per minute. The mean of a windkessel's pressure is that of its inflow; in diastole
// the pressure falls with the time constant; and the stated change per second is that of the stated pressure.
// The bars are three times what was measured.
void the_pressure_is_that_of_a_windkessel(void **)
{
    for (const double rate : {40.0, 70.0, 150.0}) {
        const BeatPhase beat = steady_beat(0, rate);
        const double step_s = beat.beat_s / 4000;
        double mean = 0.0, worst_per_s = 0.0;
        for (int i = 0; i < 4000; ++i) {
            const double at_s = (i + 0.5) * step_s;
            const WindkesselPressure now = windkessel_pressure(at_s, beat.systole_s, beat.beat_s);
            mean += now.pressure / 4000;
            if (at_s < 0.01 || at_s > beat.beat_s - 0.01 || std::fabs(at_s - beat.systole_s) < 0.01) continue;
            const double before = windkessel_pressure(at_s - 1e-4, beat.systole_s, beat.beat_s).pressure,
                         after = windkessel_pressure(at_s + 1e-4, beat.systole_s, beat.beat_s).pressure;
            worst_per_s = std::max(worst_per_s, std::fabs((after - before) / 2e-4 - now.per_s));
        }
        const double closing = windkessel_pressure(beat.systole_s, beat.systole_s, beat.beat_s).pressure,
                     opening = windkessel_pressure(0.0, beat.systole_s, beat.beat_s).pressure;
        print_message(
            "%.0f/min: pressure %.3f to %.3f of the mean, mean off by %.1e, change off by %.1e /s\n", rate,
            opening, closing, mean - 1.0, worst_per_s);
        within("mean pressure", mean, 1.0, 1e-4);
        assert_true(worst_per_s < 1.5e-3);
        within("fall in diastole", opening / closing,
               std::exp(-(beat.beat_s - beat.systole_s) / windkessel_s), 1e-4);
    }
}

// An aorta that is as wide as an ascending one, and goes up or down from its inlet.
VesselTree wide_aorta(double rise)
{
    VesselTree tree = aorta();
    for (double &radius_m : tree.branches[0].radii_m) radius_m = 13e-3;
    for (VesselBranch &branch : tree.branches)
        for (Vector3d &point_m : branch.points_m) point_m.y() *= -rise;
    return tree;
}

// An aorta that begins behind the arch, as in a scan of the belly, has no valve however wide it is: blood
// enters it in diastole, too.
void a_wide_descending_aorta_has_no_valve(void **)
{
    ContrastFlow contrast(wide_aorta(-1.0));
    double in_diastole_ml = 0.0;
    for (std::uint32_t tick = 0; tick < 1714; ++tick) {
        const BeatPhase phase = steady_beat(tick, 70.0);
        contrast.step(flow_drive(phase), {0.0, iodine});
        if (phase.since_opening_s >= phase.systole_s)
            in_diastole_ml += contrast.network().inflow_ml_s(0) * 1e-3;
    }
    assert_true(in_diastole_ml > 10.0); // of 82 ml that flow in two beats
}

// A tree whose root is as wide as an ascending aorta and rises like one has a valve and stores blood: nothing
// enters it in diastole, nothing goes back through the valve although 20 ml/s are injected beside it, and
// flows and iodine are kept over the beats.
void an_aorta_at_the_heart_stores_blood_behind_a_valve(void **)
{
    ContrastFlow contrast(wide_aorta(1.0));
    inject_at(contrast, {0, 5, 0});
    double out_ml[2] = {0, 0}, in_ml = 0.0, in_diastole_ml = 0.0;
    constexpr std::uint32_t beats = 20, beat_ticks = 857;
    for (std::uint32_t tick = 0; tick < beats * beat_ticks; ++tick) {
        const bool injects = tick < 3000;
        const BeatPhase phase = steady_beat(tick, 60e3 / beat_ticks);
        contrast.step(flow_drive(phase), {injects ? 20.0 : 0.0, iodine});
        const double inflow_ml = contrast.network().inflow_ml_s(0) * 1e-3;
        assert_true(inflow_ml >= 0.0);
        if (tick < 10 * beat_ticks) continue;
        in_ml += inflow_ml;
        if (phase.since_opening_s >= phase.systole_s) in_diastole_ml += inflow_ml;
        for (std::size_t b : {0, 1}) {
            const std::size_t run = contrast.network().run_of(contrast.cells().branch_begin(b + 1) - 1);
            out_ml[b] += contrast.network().outflow_ml_s(run) * 1e-3;
        }
    }
    const double seconds = 10 * beat_ticks * 1e-3;
    within("flow out of the aorta", out_ml[0] / seconds, 40.0, 0.01);
    within("flow out of the renal artery", out_ml[1] / seconds, 8.0, 0.01);
    within("flow in", in_ml, out_ml[0] + out_ml[1], 1e-4);
    assert_true(in_diastole_ml == 0.0);
    const IodineBudget &budget = contrast.budget();
    assert_true(budget.reflux_mg == 0.0);
    within("iodine", contrast.held_mg() + budget.out_mg, budget.injected_mg, 1e-9);
}

void a_snapshot_goes_on_bit_for_bit(void **)
{
    ContrastFlow first(aorta()), second(aorta()), other(tube(1.0));
    const ToolBall tip{Vector3d(0.02, -0.1, 0), 1.5e-3};
    first.set_tools({&tip, 1});
    inject_at(first, {20, -100, 0});
    std::uint32_t tick = 0;
    for (; tick < 300; ++tick) first.step(flow_drive(steady_beat(tick, 70)), {10.0, iodine});
    assert_true(second.restore(first.snapshot()));
    assert_false(other.restore(first.snapshot()));
    for (; tick < 600; ++tick)
        for (ContrastFlow *contrast : {&first, &second})
            contrast->step(flow_drive(steady_beat(tick, 70)), {3.0, iodine});
    assert_true(first.snapshot() == second.snapshot());
}

// A beating heart moves its vessels: the cells of the simulated blood move with the vessels and keep their
// contents.
void cells_follow_their_vessels(void **)
{
    VesselTree tree = tube(10.0);
    ContrastFlow contrast(tree);
    inject_at(contrast, {100, 0, 0});
    for (int tick = 0; tick < 100; ++tick) contrast.step({}, {5.0, iodine});
    const double held_mg = contrast.held_mg();
    const Vector3d before = contrast.cells().middle_m(40);
    for (Vector3d &point : tree.branches[0].points_m) point.z() += 0.01;
    contrast.place(tree);
    assert_true((contrast.cells().middle_m(40) - before - Vector3d(0, 0, 0.01)).norm() < 1e-12);
    assert_true(contrast.held_mg() == held_mg);
}

} // namespace

int main()
{
    const CMUnitTest tests[] = {
        cmocka_unit_test(a_front_moves_with_flow_over_area),
        cmocka_unit_test(a_laminar_front_is_long_and_its_mean_moves_with_the_flow),
        cmocka_unit_test(a_pulse_spreads_as_the_two_layers_say),
        cmocka_unit_test(injected_fluid_is_diluted_by_the_blood_that_flows),
        cmocka_unit_test(the_stated_flow_comes_out_of_a_long_artery),
        cmocka_unit_test(the_flows_of_a_tree_are_the_stated_ones),
        cmocka_unit_test(a_fork_divides_iodine_as_its_conductances),
        cmocka_unit_test(iodine_is_conserved_and_stays_between_none_and_injected),
        cmocka_unit_test(more_than_flows_away_goes_back_upstream),
        cmocka_unit_test(a_wedged_catheter_lets_nothing_past),
        cmocka_unit_test(a_tool_in_the_lumen_leaves_an_annulus),
        cmocka_unit_test(without_a_mouth_nothing_is_injected),
        cmocka_unit_test(side_holes_share_the_flow),
        cmocka_unit_test(the_cell_is_that_of_the_vessel_in_which_the_tip_lies_deepest),
        cmocka_unit_test(the_cell_is_that_of_a_search_of_all_cells),
        cmocka_unit_test(aorta_flows_in_systole_and_coronary_beds_more_in_diastole),
        cmocka_unit_test(the_pressure_is_that_of_a_windkessel),
        cmocka_unit_test(an_aorta_at_the_heart_stores_blood_behind_a_valve),
        cmocka_unit_test(a_wide_descending_aorta_has_no_valve),
        cmocka_unit_test(a_snapshot_goes_on_bit_for_bit),
        cmocka_unit_test(cells_follow_their_vessels),
    };
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
