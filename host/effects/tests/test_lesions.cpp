// These tests check the following. The pressure drop of a lesion is the sum of the drop by Poiseuille's law
// and of the loss of the jet behind its narrowest point. A lesion reduces the flow in the vessels behind it,
// more so in hyperaemia and with a guidewire in the lesion, and it delays contrast medium. The state of a
// lesion is part of a snapshot. After a balloon has widened the lesion, the pressure drop is that of the
// stenosis that remains, and no iodine is lost. Each test compares the simulation with a formula that the
// test contains.
#include "host/effects/contrast_flow.hpp"
#include "host/effects/lesion_figures.hpp"
#include "host/effects/tests/within.hpp"
#include "host/model/lesion_opening.hpp"
#include <algorithm>
#include <cmath>
#include <csetjmp>
#include <cstdarg>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstring>
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
constexpr double viscosity_mPa_s = 3.5, mmHg_per_Pa = 1 / 133.322;
constexpr double healthy_mm = 1.5, flow_ml_s = 1.0;

// Returns the flow into the vascular bed behind the last cell, in ml/s.
double out_of_the_last(const FlowNetwork &network)
{
    return network.outflow_ml_s(network.runs().size() - 1);
}

// Makes a vessel of 70 mm along x with a radius of 1.5 mm, which narrows to `throat_mm` between x = 22 and 40
// mm. The lesion has a taper of 1 mm at either end.
VesselTree vessel(double throat_mm)
{
    VesselBranch branch;
    branch.name = "lad";
    branch.flow_ml_s = flow_ml_s;
    branch.bed = VesselBed::left_coronary;
    VesselLesion lesion;
    lesion.name = "plaque";
    for (int x = 0; x <= 70; ++x) {
        const bool is_in = x >= 21 && x <= 41;
        branch.points_m.emplace_back(x * 1e-3, 0, 0);
        branch.radii_m.push_back((x >= 22 && x <= 40 ? throat_mm : healthy_mm) * 1e-3);
        if (!is_in) continue;
        if (lesion.healthy_radii_m.empty()) lesion.first_point = static_cast<std::size_t>(x);
        lesion.healthy_points_m.push_back(branch.points_m.back());
        lesion.healthy_radii_m.push_back(healthy_mm * 1e-3);
    }
    return {{branch}, {lesion}};
}

// Returns the integral of ds / r^4 (r: radius, s: arc length) over the lesion, which consists of 18 mm at the
// minimal radius and two tapers of 1 mm.
double per_r4_mm3(double throat_mm)
{
    const double a = throat_mm, b = healthy_mm;
    return 18 / (a * a * a * a) + 2 * (a * a + a * b + b * b) / (3 * a * a * a * b * b * b);
}

double viscous_mmHg(double throat_mm, double q_ml_s)
{
    return 8 * viscosity_mPa_s * q_ml_s * per_r4_mm3(throat_mm) / pi * mmHg_per_Pa;
}

// Returns the pressure loss of the jet behind a stenosis, K_t rho / 2 (A0 / As - 1)^2 v0^2, with the
// coefficient K_t = 1.5 (Young and Tsai 1973), the density rho, the areas A0 of the vessel and As of the
// stenosis, and the speed v0 in the vessel.
double jet_mmHg(double throat_mm, double q_ml_s)
{
    const double widening = healthy_mm * healthy_mm / (throat_mm * throat_mm) - 1;
    const double v0_m_s = q_ml_s / (pi * healthy_mm * healthy_mm);
    return 1.5 * 1060 / 2 * widening * widening * v0_m_s * v0_m_s * mmHg_per_Pa;
}

LesionFigures figures_of(const VesselTree &tree)
{
    return lesion_figures(tree, viscosity_mPa_s).at(0);
}

// The pressures are those of the cells next to the lesion. The pressure drop therefore includes up to 4 mm of
// healthy vessel, which cause less than 1 % of the drop.
void a_lesion_costs_what_wall_and_jet_take(void **)
{
    for (double throat_mm : {0.375, 0.6, 0.9}) {
        const LesionFigures f = figures_of(vessel(throat_mm));
        const double q = f.rest_flow_ml_s;
        within("mmHg at rest", f.rest_drop_mmHg, viscous_mmHg(throat_mm, q) + jet_mmHg(throat_mm, q), 0.02);
        within("mmHg in hyperaemia", f.hyperaemic_drop_mmHg,
               viscous_mmHg(throat_mm, f.hyperaemic_flow_ml_s) + jet_mmHg(throat_mm, f.hyperaemic_flow_ml_s),
               0.02);
        print_message("# %.2f mm: %.1f mmHg at %.2f ml/s, FFR %.2f\n", 2 * throat_mm, f.rest_drop_mmHg, q,
                      f.ffr);
    }
    // At 60 ml/min, a lesion of 0.75 mm x 18 mm loses 61 mmHg to wall friction and about 30 mmHg to the jet.
    within("61 mmHg", 8 * viscosity_mPa_s * 18 / (pi * std::pow(0.375, 4)) * mmHg_per_Pa, 61, 0.02);
    within("about 30 mmHg", jet_mmHg(0.375, 1.0), 30, 0.15);
}

void percent_by_diameter_and_by_area(void **)
{
    const LesionFigures f = figures_of(vessel(0.375));
    within("percent", f.diameter_percent(), 75, 1e-9);
    within("percent", f.area_percent(), 93.75, 1e-9);
    within("mm", f.minimum_diameter_mm, 0.75, 1e-9);
    within("mm", f.length_mm, 20, 1e-9);
    assert_string_equal(f.branch.c_str(), "lad");
}

// Without a narrowing, the pressure at the vascular bed is 88 mmHg minus the Poiseuille drop along the 70 mm
// vessel; this also holds at four times the flow.
void flow_reserve_falls_with_the_stenosis(void **)
{
    double before = 1;
    for (double throat_mm : {1.499, 0.9, 0.6, 0.375}) {
        const double ffr = figures_of(vessel(throat_mm)).ffr;
        assert_true(ffr < before);
        before = ffr;
    }
    assert_true(figures_of(vessel(1.499)).ffr > 0.9);
    assert_true(before < 0.5); // 75 % by diameter: clearly worth treating (0.80 is the usual limit)
}

// Bisection finds the flow that satisfies the equations of both the vascular bed and the lesion; the flow
// network uses another method.
void the_flow_is_the_one_at_which_drops_add_up(void **)
{
    const double throat_mm = 0.375,
                 rest_of_vessel = 8 * viscosity_mPa_s * 50 / (pi * std::pow(healthy_mm, 4)) * mmHg_per_Pa;
    // At rest, the bed takes the stated flow at the pressure that 70 mm of healthy vessel leave.
    const double bed = mean_pressure_mmHg / flow_ml_s -
                       8 * viscosity_mPa_s * 70 / (pi * std::pow(healthy_mm, 4)) * mmHg_per_Pa;
    double low = 0, high = flow_ml_s;
    for (int i = 0; i < 60; ++i) {
        const double q = 0.5 * (low + high);
        const double sum = q * bed + viscous_mmHg(throat_mm, q) + jet_mmHg(throat_mm, q) + rest_of_vessel * q;
        (sum > mean_pressure_mmHg ? high : low) = q;
    }
    within("ml/s", figures_of(vessel(throat_mm)).rest_flow_ml_s, low, 0.005);
}

void a_wire_in_the_throat_takes_flow(void **)
{
    const FlowCells cells(vessel(0.375));
    FlowNetwork network(cells, viscosity_mPa_s);
    network.settle({});
    const double free_ml_s = out_of_the_last(network);
    std::vector<double> tools(cells.size(), 0.18); // 0.014 inch
    network.set_tools(tools);
    network.settle({});
    assert_true(out_of_the_last(network) < 0.6 * free_ml_s);
    network.set_tools({});
    network.settle({});
    within("ml/s", out_of_the_last(network), free_ml_s, 1e-9);
}

// Returns the time in ms from the start of an injection upstream of the lesion until the last cell has half
// of the injected iodine concentration.
int arrival_ms(double throat_mm)
{
    ContrastFlow contrast(vessel(throat_mm));
    const CatheterMouth mouth{{0.005, 0, 0}, 1.0};
    contrast.set_mouths({&mouth, 1});
    for (int ms = 1; ms < 20000; ++ms) {
        contrast.step({}, {0.2, 350.0});
        const double through = out_of_the_last(contrast.network());
        if (contrast.iodine_mg_per_ml(contrast.cells().size() - 1) > 0.5 * 350.0 * 0.2 / through) return ms;
    }
    return 20000;
}

void medium_arrives_later_behind_a_lesion(void **)
{
    const int healthy = arrival_ms(1.499), narrowed = arrival_ms(0.375);
    print_message("# healthy %d ms, 75 %% narrowed %d ms\n", healthy, narrowed);
    assert_true(narrowed > 1.25 * healthy);
}

void a_snapshot_goes_on_as_the_original_does(void **)
{
    ContrastFlow contrast(vessel(0.375)), copy(vessel(0.375));
    const CatheterMouth mouth{{0.005, 0, 0}, 1.0};
    contrast.set_mouths({&mouth, 1});
    for (int ms = 0; ms < 7; ++ms)
        contrast.step({}, {0.2, 350.0}); // the flow through the stenosis has not settled yet
    assert_true(copy.restore(contrast.snapshot()));
    for (int ms = 0; ms < 50; ++ms) {
        contrast.step({}, {0.2, 350.0});
        copy.step({}, {0.2, 350.0});
    }
    assert_true(copy.snapshot() == contrast.snapshot());
    std::vector<std::uint8_t> short_of_it = contrast.snapshot();
    short_of_it.resize(short_of_it.size() - 8);
    assert_false(copy.restore(short_of_it));
}

// --- lesions that yield ---

// Returns the same vessel after its lesion has been opened by the fraction `share`. The lesion is concentric,
// so the points of its centreline do not move, and its radii change in proportion to the opening.
VesselTree opened(const VesselTree &tree, double share)
{
    const LesionStations stations{21, 1e-3};
    std::vector<double> open(21, share);
    VesselTree now = tree;
    LesionOpening(tree, {&stations, 1}).open(tree, open, now);
    return now;
}

void opened_wholly_it_costs_what_the_healthy_vessel_does(void **)
{
    const VesselTree tree = vessel(0.375), now = opened(tree, 1);
    const LesionFigures f = lesion_figures(tree, viscosity_mPa_s, &now).at(0);
    const LesionFigures healthy = figures_of(vessel(healthy_mm));
    within("ffr", f.ffr, healthy.ffr, 1e-9);
    within("ml/s", f.rest_flow_ml_s, healthy.rest_flow_ml_s, 1e-9);
    within("mm", f.minimum_diameter_mm, 2 * healthy_mm, 1e-9);
    assert_true(std::fabs(f.diameter_percent()) < 1e-9);
}

// The radius of the opened lesion is 0.375 + 0.6 (1.5 - 0.375) mm. The pressure drop must be that of a vessel
// that was baked with the radius of the opened lesion.
void opened_partly_it_costs_what_is_left(void **)
{
    const VesselTree tree = vessel(0.375), now = opened(tree, 0.6);
    const LesionFigures f = lesion_figures(tree, viscosity_mPa_s, &now).at(0),
                        as_baked = figures_of(vessel(1.05));
    within("mm", f.minimum_diameter_mm, 2.1, 1e-9);
    within("percent", f.diameter_percent(), 30, 1e-9);
    within("mmHg", f.hyperaemic_drop_mmHg, as_baked.hyperaemic_drop_mmHg, 1e-9);
    within("ffr", f.ffr, as_baked.ffr, 1e-9);
}

// The stations (points) of a lesion are evenly spaced about the lesion's middle, and between two stations the
// opening changes linearly. A row of 8 stations with a spacing of 4 mm covers 28 mm, from -4 to 24 mm.
void a_place_is_open_as_the_stations_beside_it(void **)
{
    const VesselTree tree = vessel(0.375);
    const LesionStations stations{8, 4e-3};
    const LesionOpening opening(tree, {&stations, 1});
    const std::vector<double> open = {0, 0, 0, 1, 0.5, 0, 0, 0};
    for (const auto &[arc_mm, share] :
         {std::pair{8.0, 1.0}, {10.0, 0.75}, {12.0, 0.5}, {5.0, 0.25}, {0.0, 0.0}})
        assert_true(std::fabs(LesionOpening::at(opening.place(0, arc_mm * 1e-3), open) - share) < 1e-12);
    assert_true(opening.is_any_open(open));
    assert_false(opening.is_any_open(std::vector<double>(8, 0.0)));
    assert_false(opening.is_any_open({})); // a device that reports nothing
}

double lost_mg(const ContrastFlow &contrast)
{
    const IodineBudget &budget = contrast.budget();
    return std::fabs(budget.injected_mg - contrast.held_mg() - budget.out_mg - budget.reflux_mg);
}

// While medium is injected upstream, the lesion is opened by a balloon that blocks the flow, recoils by a
// third after deflation, and is opened again. No iodine is lost, no concentration exceeds the injected
// concentration, and the volume of each cell ends at the value that follows from its shape.
void iodine_is_conserved_while_the_wall_gives_way(void **)
{
    const VesselTree tree = vessel(0.375);
    ContrastFlow contrast(tree);
    const CatheterMouth mouth{{0.005, 0, 0}, 1.0};
    contrast.set_mouths({&mouth, 1});
    std::vector<ToolBall> balloon;
    double share = 0, strongest = 0, worst = 0;
    for (int ms = 0; ms < 4000; ++ms) {
        const bool is_up = ms / 1000 % 2 == 1;
        if (ms % 1000 == 0) {
            balloon.clear();
            for (int x = 24; is_up && x <= 38; ++x) balloon.push_back({{x * 1e-3, 0, 0}, 1.5e-3});
            contrast.set_tools(balloon);
        }
        if (ms % 40 == 0) {
            const double wanted = is_up ? 1.0 : ms < 1000 ? 0.0 : 0.65;
            share += std::clamp(wanted - share, -0.1, 0.1);
            contrast.reshape(opened(tree, share), 40);
            contrast.set_tools(balloon);
        }
        contrast.step({}, {ms % 1500 < 700 ? 1.5 : 0.0, 350.0});
        worst = std::max(worst, lost_mg(contrast));
        for (std::size_t i = 0; i < contrast.cells().size(); ++i) {
            assert_true(contrast.core_mg_per_ml(i) > -1e-9 && contrast.wall_mg_per_ml(i) > -1e-9);
            strongest = std::max({strongest, contrast.core_mg_per_ml(i), contrast.wall_mg_per_ml(i)});
        }
    }
    const double injected = contrast.budget().injected_mg;
    print_message("# lost %.2g of %.0f mg, strongest %.9g mg/ml\n", worst, injected, strongest);
    assert_true(injected > 500 && worst < 1e-9 * injected);
    assert_true(strongest < 350.0 * (1 + 1e-9));
}

// A vessel full of contrast medium at the injected concentration stays full when it opens: the added volume
// comes from the cell upstream, at the same concentration.
void what_a_widening_cell_takes_has_its_neighbours_strength(void **)
{
    const VesselTree tree = vessel(0.9);
    ContrastFlow contrast(tree);
    const CatheterMouth mouth{{0.001, 0, 0}, 1.0};
    contrast.set_mouths({&mouth, 1});
    for (int ms = 0; ms < 9000; ++ms) contrast.step({}, {6.0, 350.0});
    const std::size_t cell = contrast.cells().nearest({0.03, 0, 0});
    within("mg/ml", contrast.iodine_mg_per_ml(cell), 350.0, 1e-6);
    const double before_ml = contrast.cells()[cell].volume_ml;
    contrast.reshape(opened(tree, 1), 40);
    for (int ms = 0; ms < 60; ++ms) contrast.step({}, {6.0, 350.0});
    assert_true(contrast.cells()[cell].volume_ml > 2 * before_ml);
    within("mg/ml", contrast.iodine_mg_per_ml(cell), 350.0, 1e-6);
}

void a_snapshot_goes_on_while_the_wall_gives_way(void **)
{
    const VesselTree tree = vessel(0.375);
    ContrastFlow contrast(tree), copy(tree);
    const CatheterMouth mouth{{0.005, 0, 0}, 1.0};
    contrast.set_mouths({&mouth, 1});
    for (int ms = 0; ms < 700; ++ms) contrast.step({}, {0.5, 350.0});
    contrast.reshape(opened(tree, 0.4), 40);
    for (int ms = 0; ms < 17; ++ms) contrast.step({}, {0.5, 350.0});
    copy.reshape(opened(tree, 0.4), 40);
    assert_true(copy.restore(contrast.snapshot()));
    for (int ms = 0; ms < 50; ++ms) {
        contrast.step({}, {0.5, 350.0});
        copy.step({}, {0.5, 350.0});
    }
    assert_true(copy.snapshot() == contrast.snapshot());
}

void lesions_of_no_vessel_are_refused(void **)
{
    std::string error;
    VesselTree tree = vessel(0.375);
    assert_true(check_vessel_tree(tree, error));
    tree.lesions[0].first_point = 60;
    assert_false(check_vessel_tree(tree, error));
    assert_string_equal(error.c_str(), "lesion \"plaque\": it reaches beyond the end of its branch");
    tree.lesions[0].branch = 1;
    assert_false(check_vessel_tree(tree, error));
    tree = vessel(0.375);
    tree.lesions[0].healthy_radii_m[3] = 0;
    assert_false(check_vessel_tree(tree, error));
    assert_non_null(std::strstr(error.c_str(), "healthy radius at its point 3"));
}

} // namespace

int main()
{
    const CMUnitTest tests[] = {
        cmocka_unit_test(a_lesion_costs_what_wall_and_jet_take),
        cmocka_unit_test(percent_by_diameter_and_by_area),
        cmocka_unit_test(flow_reserve_falls_with_the_stenosis),
        cmocka_unit_test(the_flow_is_the_one_at_which_drops_add_up),
        cmocka_unit_test(a_wire_in_the_throat_takes_flow),
        cmocka_unit_test(medium_arrives_later_behind_a_lesion),
        cmocka_unit_test(a_snapshot_goes_on_as_the_original_does),
        cmocka_unit_test(opened_wholly_it_costs_what_the_healthy_vessel_does),
        cmocka_unit_test(opened_partly_it_costs_what_is_left),
        cmocka_unit_test(a_place_is_open_as_the_stations_beside_it),
        cmocka_unit_test(iodine_is_conserved_while_the_wall_gives_way),
        cmocka_unit_test(what_a_widening_cell_takes_has_its_neighbours_strength),
        cmocka_unit_test(a_snapshot_goes_on_while_the_wall_gives_way),
        cmocka_unit_test(lesions_of_no_vessel_are_refused),
    };
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
