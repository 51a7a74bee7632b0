// These tests check the following. The thesis' rod, as the baseline of `calibrate`, represents the instrument
// that its file describes, in the same coordinate frame as our rod. The integration of the rod's motion stays
// stable for any values of the parameters. The search that fits our rod also fits the thesis' rod, with
// results that are equal bit for bit for any number of workers.
#include "host/base/tests/folder.hpp"
#include "tools/lab/calibrate/corde_evaluator.hpp"
#include "tools/lab/calibrate/core_rod.hpp"
#include "tools/lab/calibrate/rod_evaluator.hpp"
#include "tools/lab/calibrate/search.hpp"
#include "tools/lab/calibrate/tests/near.hpp"
#include <algorithm>
#include <cmath>

// The header cmocka.h and the headers that it needs come last, because its macros (fail, ...) would change
// other headers.
#include <csetjmp>
#include <cstdarg>
#include <numbers>
extern "C" {
#include <cmocka.h>
}

using namespace crn::calibrate;
using crn::tests::Folder;
using namespace crn::calibrate::tests;
namespace insertion = crn::insertion;

namespace
{

using std::numbers::pi;

crn::Instrument instrument_of(const std::string &name)
{
    return crn::read_instrument(std::string(instruments) + name + ".toml");
}

// Makes the distance field of a space without walls, which extends 125 mm around the origin.
struct Space {
    std::vector<std::uint16_t> index = std::vector<std::uint16_t>(16 * 16 * 16, CRN_LUMEN_ENTRY_INSIDE);
    crn_lumen lumen{};
    std::unique_ptr<vcsim3::Vessel> vessel;

    Space()
    {
        for (int k = 0; k < 3; k++) {
            lumen.origin_m_q30[k] = -(1 << 26);
            lumen.brick_count_xyz[k] = 16;
        }
        lumen.index = index.data();
        vessel = std::make_unique<vcsim3::Vessel>(lumen, Vector3d::Zero(), Vector3d::UnitX());
    }
};

// Makes a case in free space with a single depth, at which 30 mm of the instrument are inserted.
insertion::Case free_case(const std::string &name)
{
    insertion::Case c;
    c.name = "free";
    c.instrument = std::filesystem::absolute(std::string(instruments) + name + ".toml");
    c.direction = Vector3d(0.8, 0.6, 0.0);
    c.speed_mm_per_s = 200.0;
    insertion::Depth depth;
    depth.name = "out";
    depth.inserted_mm = 30.0;
    depth.centreline = "depth_1.csv";
    c.depths = {depth};
    return c;
}

// --- the rod ---

void nominal_values_make_the_files_stiffness_and_mass(void **)
{
    for (const char *name : {"amplatz_super_stiff", "beacon_5f"}) {
        const crn::Instrument instrument = instrument_of(name);
        const CordeValues values = nominal_corde_values(instrument);
        const crn_wire_knot &shaft = instrument.table.knots[instrument.table.knots_count - 1];
        const double radius_m = shaft.radius_outer_um * 1e-6;
        assert_near(values.young_Pa * pi * std::pow(radius_m, 4) / 4.0 * 1e9 / shaft.bend_stiffness_nN_m2,
                    1.0, 1e-9);
        assert_near(values.density_kg_m3 * pi * radius_m * radius_m * 1e6 / shaft.mass_mg_per_m, 1.0, 1e-9);
    }
}

// EI equals the shaft's EI on the shaft, and alpha times the shaft's EI at the tip. The ratio GJ / EI is that
// of the instrument file. Between tip and shaft, EI lies between the EI of the tip and the EI of the shaft.
void joints_have_the_stiffness_asked_for(void **)
{
    const crn::Instrument instrument = instrument_of("amplatz_super_stiff");
    CordeValues values = nominal_corde_values(instrument);
    values.tip_over_shaft = 0.02;
    values.young_Pa *= 3.0;
    const CordeModel model =
        corde_model(instrument.table, values, free_case("amplatz_super_stiff"), corde_settings(), 300.0);
    const auto &joints = model.properties.joints;
    const double shaft_N_m2 =
        3.0 * instrument.table.knots[instrument.table.knots_count - 1].bend_stiffness_nN_m2 * 1e-9;
    assert_near(joints.front().bend_N_m2 / shaft_N_m2, 0.02, 1e-9);
    assert_near(joints.back().bend_N_m2 / shaft_N_m2, 1.0, 1e-9);
    assert_near(joints.back().twist_N_m2 / joints.back().bend_N_m2, 0.77, 1e-3);
    for (std::size_t i = 1; i < joints.size(); i++)
        assert_true(joints[i].bend_N_m2 >= joints[i - 1].bend_N_m2 * (1.0 - 1e-12));
}

// For the extreme values of all parameters, the number of substeps is at most the permitted number, and the
// mass is at least the real mass. The time step times the highest angular frequency stays below 2. Closed
// forms give the highest frequency of a point between two springs of stiffness Kp/l, and that of a rotating
// segment.
void every_trial_gets_a_step_that_is_stable(void **)
{
    const Space space;
    for (const char *name : {"amplatz_super_stiff", "cook_straight", "rosen", "beacon_5f", "pigtail_5f"}) {
        const insertion::Case c = free_case(name);
        const CordeEvaluator evaluator(c, *space.vessel, corde_settings());
        const std::vector<Parameter> &parameters = evaluator.parameters();
        for (unsigned corner = 0; corner < 1u << parameters.size(); corner++) {
            std::vector<double> values;
            for (std::size_t i = 0; i < parameters.size(); i++)
                values.push_back(parameters[i].value_at(corner >> i & 1));
            const CordeModel model = corde_model(instrument_of(name).table, evaluator.values_of(values), c,
                                                 corde_settings(), 100.0);
            const vcsim3::RodProperties &p = model.properties;
            const double step_s = 1e-3 / model.substeps, l = p.element_m;
            double bend = 0.0;
            for (const vcsim3::JointProperties &joint : p.joints) bend = std::max(bend, joint.bend_N_m2);
            const double points = 4.0 * p.parallel_N / (l * l * p.mass_kg_per_m),
                         turning = (p.parallel_N + 4.0 * bend / (l * l)) / p.inertia_bend_kg_m;
            assert_true(step_s * std::sqrt(points + turning) < 1.8);
            assert_in_range(model.substeps, 1, corde_settings().substeps_max);
            assert_true(model.mass_scale >= 1.0);
        }
    }
}

// In this test the hand turns an instrument whose tip carries no load. Our rod's elements differ in length
// from those of CoRdE, so the test compares the curves of the two tips.
void a_bent_tip_lies_where_our_rods_tip_lies(void **)
{
    const Space space;
    insertion::Case c = free_case("j_wire");
    const crn::Instrument instrument = instrument_of("j_wire");
    CordeSettings settings = corde_settings();
    settings.element_mm = 1.5;
    const CordeModel model =
        corde_model(instrument.table, nominal_corde_values(instrument), c, settings, 60.0);
    for (const double turn_deg : {0.0, 120.0}) {
        c.depths.front().turn_deg = turn_deg;
        const vcsim3::Wall nothing = [](const vcsim3::Vector &) {
            return vcsim3::LumenSample{-0.01, Vector3d::Zero()};
        };
        CordeRod rod(model, c, nothing, settings);
        CoreRod ours(instrument.table, &space.lumen, c.mouth_mm, c.direction, Vector3d::Zero(), 5.0);
        const Insertion made = insert_by_hand(rod, c, settings, 1),
                        wanted = insert_by_hand(ours, c, settings, 1);
        std::vector<Vector3d> line = wanted.nodes_mm.front();
        line.push_back(c.mouth_mm);
        const Distances off = distances_of(made.nodes_mm.front(), line);
        print_message("turn %g: RMS %.3f mm, max %.3f mm\n", turn_deg, off.rms_mm, off.max_mm);
        assert_true(off.max_mm < 0.3);
        assert_near((made.nodes_mm.front().front() - wanted.nodes_mm.front().front()).norm(), 0.0,
                    0.5); // the tip
    }
}

// --- the fit ---

// A wire that extends beyond the introducer and sags under its weight shows the EI of its tip. This test fits
// alpha; the other parameters may deviate by only 0.1 % from their nominal values.
struct Sagging {
    Folder folder{"corde"};
    Space space;
    insertion::Case c = free_case("bentson");
    std::unique_ptr<CordeEvaluator> evaluator;
    std::unique_ptr<Judge> judge;

    explicit Sagging(double tip_factor)
    {
        c.folder = folder.path;
        c.gravity_m_s2 = Vector3d(0.0, 0.0, -9.81);
        CordeSettings settings = corde_settings();
        settings.speed_mm_per_s = 200.0;
        settings.drag_per_s = 20.0; // the rod touches nothing
        settings.settle_max_ticks = 400;
        evaluator = std::make_unique<CordeEvaluator>(c, *space.vessel, settings);
        std::vector<double> truth;
        for (std::size_t i = 0; i < evaluator->parameters().size(); i++) {
            const Parameter p = evaluator->parameters()[i];
            if (p.name != "alpha") evaluator->set_bounds(i, 0.999 * p.nominal, 1.001 * p.nominal);
            truth.push_back(p.nominal * (p.name == "alpha" ? tip_factor : 1.0));
        }
        std::vector<Vector3d> line = evaluator->insert(truth, 1).nodes_mm.front();
        line.push_back(c.mouth_mm);
        insertion::write_centreline(folder.file("depth_1.csv"), line);
        judge = std::make_unique<Judge>(c, JudgeSettings{});
    }

    Verdict evaluate(const std::vector<double> &shares) const
    {
        std::vector<double> values;
        for (std::size_t i = 0; i < shares.size(); i++)
            values.push_back(evaluator->parameters()[i].value_at(shares[i]));
        return judge->evaluate(*evaluator, values);
    }
};

void a_fit_finds_the_tips_stiffness_with_the_same_bits_from_any_threads(void **)
{
    const Sagging sagging(0.5);
    const SearchSettings settings{Method::cmaes, 8, 5, 1};
    std::vector<Trial> best;
    for (const unsigned threads : {1u, 2u}) {
        const std::unique_ptr<Workers> workers =
            thread_workers(threads, [&](const auto &shares) { return sagging.evaluate(shares); }, {}, {});
        SearchState state;
        while (state.generation < settings.generations)
            advance(
                settings, sagging.evaluator->parameters().size(),
                [&](const auto &trials) { return workers->evaluate(trials); }, state);
        best.push_back(best_of(state));
    }
    assert_true(best[0].shares == best[1].shares && best[0].verdict.objective == best[1].verdict.objective);
    const Parameter &alpha = sagging.evaluator->parameters()[1];
    assert_string_equal(alpha.name.c_str(), "alpha");
    const double found = alpha.value_at(best[0].shares[1]) / alpha.nominal;
    print_message("alpha %.3f of the file's, truth 0.5; %.4f mm\n", found, best[0].verdict.objective);
    assert_near(found, 0.5, 0.1);
}

// A checkpoint holds results of trials, so its hash must depend on the kind of rod and on the version of the
// core.
void settings_name_the_rod_and_the_core(void **)
{
    const Space space;
    const RodEvaluator ours(free_case("rosen"), *space.vessel, InsertionSettings());
    const CordeEvaluator thesis(free_case("rosen"), *space.vessel, corde_settings());
    assert_true(ours.settings_text().find("core " + std::to_string(CoreRod::version()) + " ") !=
                std::string::npos);
    assert_true(thesis.settings_text().find("corde ") == 0);
}

void bounds_without_the_nominal_value_are_refused(void **)
{
    const Space space;
    CordeEvaluator evaluator(free_case("rosen"), *space.vessel, corde_settings());
    bool is_refused = false;
    try {
        evaluator.set_bounds(0, 1.0, 2.0);
    } catch (const crn::Fault &error) {
        is_refused = std::string(error.what()).find("young: give LOW..HIGH") != std::string::npos;
    }
    assert_true(is_refused);
    evaluator.set_bounds(0, 1e7, 1e12);
    assert_near(evaluator.parameters()[0].low, 1e7, 0.0);
}

// The ranges of the parameters contain the numbers of the instrument file and the numbers of the thesis'
// table.
void bounds_hold_the_row_of_the_thesis_table(void **)
{
    const Space space;
    const CordeEvaluator evaluator(free_case("rosen"), *space.vessel, corde_settings());
    const auto holds = [&](const std::string &name, double value) {
        for (const Parameter &p : evaluator.parameters())
            if (p.name == name)
                return p.low < value && value < p.high && p.low < p.nominal && p.nominal < p.high;
        return false;
    };
    assert_true(holds("young", 3.90e7));
    assert_true(holds("radius", 0.67));
    assert_true(holds("density", 7.24e5));
    assert_true(holds("kp", 377.0));
}

// The wall function of this test states that every point lies 15 mm outside the vessel.
void a_rod_that_leaves_the_vessel_is_refused(void **)
{
    const insertion::Case c = free_case("bentson");
    const crn::Instrument instrument = instrument_of("bentson");
    const CordeModel model =
        corde_model(instrument.table, nominal_corde_values(instrument), c, corde_settings(), 60.0);
    const vcsim3::Wall outside = [](const vcsim3::Vector &) {
        return vcsim3::LumenSample{0.015, Vector3d::Zero()};
    };
    CordeRod rod(model, c, outside, corde_settings());
    bool is_refused = false;
    try {
        insert_by_hand(rod, c, corde_settings(), 1);
    } catch (const TrialRefused &) {
        is_refused = true;
    }
    assert_true(is_refused);
}

} // namespace

int main()
{
    const CMUnitTest tests[] = {
        cmocka_unit_test(nominal_values_make_the_files_stiffness_and_mass),
        cmocka_unit_test(joints_have_the_stiffness_asked_for),
        cmocka_unit_test(every_trial_gets_a_step_that_is_stable),
        cmocka_unit_test(a_bent_tip_lies_where_our_rods_tip_lies),
        cmocka_unit_test(a_fit_finds_the_tips_stiffness_with_the_same_bits_from_any_threads),
        cmocka_unit_test(settings_name_the_rod_and_the_core),
        cmocka_unit_test(bounds_without_the_nominal_value_are_refused),
        cmocka_unit_test(bounds_hold_the_row_of_the_thesis_table),
        cmocka_unit_test(a_rod_that_leaves_the_vessel_is_refused),
    };
    cmocka_set_message_output(CM_OUTPUT_TAP);
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
