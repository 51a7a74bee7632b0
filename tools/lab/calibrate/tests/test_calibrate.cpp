// These tests check the following. The program `calibrate` compares distances and forces with the reference
// by equation 19 of the thesis; the tests check the results against closed forms. The simulated instrument,
// and the file that is written from it, have the requested values. A search gives results that are equal bit
// for bit for any number of workers (threads or processes) and after any number of stops. If the data do not
// determine a parameter, the result of the fit says so.
#include "host/base/tests/folder.hpp"
#include "tools/lab/calibrate/checkpoint.hpp"
#include "tools/lab/calibrate/fitted_instrument.hpp"
#include "tools/lab/calibrate/identify.hpp"
#include "tools/lab/calibrate/result.hpp"
#include "tools/lab/calibrate/rod_evaluator.hpp"
#include "tools/lab/calibrate/tests/near.hpp"
#include <cmath>
#include <fstream>
#include <mutex>

// The header cmocka.h and the headers that it needs come last, because its macros (fail, ...) would change
// other headers.
#include <csetjmp>
#include <cstdarg>
extern "C" {
#include <cmocka.h>
}

using namespace crn::calibrate;
using crn::tests::Folder;
using namespace crn::calibrate::tests;
namespace insertion = crn::insertion;

namespace
{

constexpr Method methods[] = {Method::genetic, Method::cmaes, Method::differential};

// The objective of this test is a smooth function like a curved valley, with its lowest point at 0.3, 0.6,
// ...; its computation is cheap.
Verdict valley(const std::vector<double> &shares)
{
    double sum = 0.0;
    for (std::size_t i = 0; i < shares.size(); i++) {
        const double off = shares[i] - 0.3 * static_cast<double>(i % 2 + 1);
        sum += off * off * (i == 0 ? 1.0 : 4.0);
    }
    const double objective = std::sqrt(sum);
    return {objective, objective, 0.0};
}

std::vector<Verdict> all_of(const std::vector<std::vector<double>> &trials)
{
    std::vector<Verdict> verdicts;
    for (const std::vector<double> &trial : trials) verdicts.push_back(valley(trial));
    return verdicts;
}

bool same(const std::vector<Trial> &a, const std::vector<Trial> &b)
{
    if (a.size() != b.size()) return false;
    for (std::size_t i = 0; i < a.size(); i++)
        if (a[i].shares != b[i].shares || a[i].verdict.objective != b[i].verdict.objective) return false;
    return true;
}

SearchState searched(const SearchSettings &settings, const EvaluateShares &evaluate)
{
    SearchState state;
    while (state.generation < settings.generations) advance(settings, 3, evaluate, state);
    return state;
}

// --- judging ---

// If a point lies beside a segment of the polyline, its distance to the polyline is the distance to this
// segment. If a point lies beyond an end of the polyline, its distance to the polyline is the distance to
// this end. We use 3-4-5 triangles.
void distances_go_to_the_nearest_point_of_the_line(void **)
{
    const std::vector<Vector3d> line = {{0, 0, 0}, {10, 0, 0}, {10, 10, 0}};
    assert_near(distance_to_line_mm({5, 2, 0}, line), 2.0, 1e-12);
    assert_near(distance_to_line_mm({-3, 4, 0}, line), 5.0, 1e-12);
    assert_near(distance_to_line_mm({13, 14, 0}, line), 5.0, 1e-12);
    assert_near(distance_to_line_mm({12, 5, 0}, line), 2.0, 1e-12);
}

// The distances of the nodes are 1, 1, 2 and 4 mm, so the RMS is sqrt(22/4) mm, the mean 2 mm and the
// standard deviation sqrt(22/4 - 4) mm.
void equation_19_is_the_rms_over_the_nodes(void **)
{
    const std::vector<Vector3d> line = {{0, 0, 0}, {10, 0, 0}};
    const std::vector<Vector3d> nodes = {{1, 1, 0}, {2, 0, 1}, {3, 2, 0}, {4, 0, -4}};
    const Distances d = distances_of(nodes, line);
    assert_near(d.rms_mm, std::sqrt(5.5), 1e-12);
    assert_near(d.mean_mm, 2.0, 1e-12);
    assert_near(d.deviation_mm, std::sqrt(1.5), 1e-12);
    assert_near(d.max_mm, 4.0, 1e-12);
}

// A force trace that is 1.2 times the reference everywhere has an error of 0.2. A peak in a single sample
// does not change the error of a force trace.
void the_force_error_is_relative_and_passes_over_single_peaks(void **)
{
    std::vector<insertion::ForceSample> reference, simulated;
    for (int i = 0; i <= 100; i++) {
        reference.push_back({static_cast<double>(i), 100.0 + i});
        simulated.push_back({static_cast<double>(i), 1.2 * (100.0 + i)});
    }
    simulated[50].axial_mN = 5000.0;
    const std::optional<double> error = force_error(simulated, reference, 10, 90, 6);
    assert_true(error.has_value());
    assert_near(*error, 0.2, 2e-3);
    assert_false(force_error(simulated, reference, 200, 300, 6).has_value());
}

// --- the virtual instrument ---

void parameters_and_shares_are_each_others_inverse(void **)
{
    const Parameter parameter{"a", "1", "", 0.01, 1.0, 0.1};
    assert_near(parameter.value_at(0.5), 0.1, 1e-12);
    assert_near(parameter.share_of(0.1), 0.5, 1e-12);
    assert_near(parameter.share_of(100.0), 1.0, 0.0);
}

// The test compares EI of tip and shaft, radius and mass per length with the definitions of these values.
void a_virtual_instrument_has_the_values_asked_for(void **)
{
    const crn_wire_instrument nominal =
        crn::read_instrument(std::string(instruments) + "beacon_5f.toml").table;
    RodValues values = nominal_values(nominal);
    values.bend_shaft_N_m2 *= 2.0;
    values.tip_over_shaft *= 0.5;
    values.radius_mm *= 1.1;
    values.density_kg_m3 = 5000.0;
    insertion::Case c;
    c.friction_kinetic = 0.07;
    c.friction_static = 0.09;
    const crn_wire_instrument table = virtual_instrument(nominal, values, c);
    const crn_wire_knot &shaft = table.knots[table.knots_count - 1],
                        &was = nominal.knots[nominal.knots_count - 1];
    assert_near(shaft.bend_stiffness_nN_m2, 2.0 * was.bend_stiffness_nN_m2, 1);
    assert_near(table.knots[0].bend_stiffness_nN_m2, nominal.knots[0].bend_stiffness_nN_m2, 1);
    assert_near(shaft.radius_outer_um, 1.1 * was.radius_outer_um, 0.51);
    const double outer_m = shaft.radius_outer_um * 1e-6, inner_m = shaft.radius_inner_um * 1e-6;
    const double metal_m2 = 3.14159265358979 * (outer_m * outer_m - inner_m * inner_m);
    assert_near(shaft.mass_mg_per_m * 1e-6 / metal_m2, 5000.0, 20.0); // the radius is in whole micrometres
    assert_int_equal(shaft.friction_kinetic_milli, 70);
    assert_int_equal(table.knots[0].friction_static_milli, 90);
}

// The simulator's reader returns the table that was written, within a unit of the wire: at steps, along
// tapers and behind a J.
void a_fitted_file_is_read_as_the_table_it_was_made_of(void **)
{
    const Folder folder{"fitted"};
    insertion::Case c;
    c.friction_kinetic = 0.1;
    c.friction_static = 0.12;
    for (const char *name : {"j_wire", "beacon_5f", "rosen", "terumo_4f", "simmons_2_5f"}) {
        const std::string nominal = std::string(instruments) + name + ".toml";
        const crn_wire_instrument table = crn::read_instrument(nominal).table;
        RodValues values = nominal_values(table);
        values.bend_shaft_N_m2 *= 1.7;
        values.tip_over_shaft *= 0.8;
        values.density_kg_m3 *= 1.3;
        const crn_wire_instrument fitted = virtual_instrument(table, values, c);
        std::ofstream(folder.file("fitted.toml"))
            << fitted_instrument_text(nominal, fitted, "fitted in a test");
        const crn::Instrument back = crn::read_instrument(folder.file("fitted.toml"));
        const unsigned length_mm = fitted.knots[fitted.knots_count - 1].arc_um / 1000;
        for (unsigned mm = 0; mm <= length_mm; mm++) {
            const crn_wire_knot got = knot_at(back.table, mm + 0.25, true),
                                want = knot_at(fitted, mm + 0.25, true);
            assert_near(got.bend_stiffness_nN_m2, want.bend_stiffness_nN_m2,
                        2 + 1e-3 * want.bend_stiffness_nN_m2);
            assert_near(got.twist_stiffness_nN_m2, want.twist_stiffness_nN_m2,
                        2 + 1e-3 * want.twist_stiffness_nN_m2);
            assert_near(got.mass_mg_per_m, want.mass_mg_per_m, 1);
            assert_int_equal(got.radius_outer_um, want.radius_outer_um);
            assert_int_equal(got.rest_curvature1_per_m_milli, want.rest_curvature1_per_m_milli);
        }
    }
}

void a_preset_made_from_another_one_cannot_be_written(void **)
{
    const std::string nominal = std::string(instruments) + "j_wire.toml:vcsim3-fit";
    const crn_wire_instrument table = crn::read_instrument(nominal).table;
    bool is_refused = false;
    try {
        fitted_instrument_text(nominal, table, "x");
    } catch (const std::exception &error) {
        is_refused = std::string(error.what()).find("calibrate 'physical'") != std::string::npos;
    }
    assert_true(is_refused);
}

// --- the search ---

// The recording run must request every trial that pagmo's real run requests later, so that no trial has to be
// evaluated separately.
void all_trials_of_a_generation_are_evaluated_together(void **)
{
    for (const Method method : methods) {
        const SearchSettings settings{method, 12, 6, 3};
        SearchState state;
        std::size_t batches = 0;
        while (state.generation < settings.generations) {
            std::size_t late = 1;
            advance(
                settings, 3, [&](const auto &trials) { return batches++, all_of(trials); }, state, &late);
            assert_int_equal(late, 0);
        }
        assert_int_equal(batches, settings.generations);
        assert_int_equal(state.trials.size(), settings.population * settings.generations);
    }
}

void every_method_finds_the_bottom_of_a_valley(void **)
{
    for (const Method method : methods) {
        const SearchState state = searched({method, 20, 50, 1}, all_of);
        print_message("%s: %g\n", method_token(method), best_of(state).verdict.objective);
        assert_true(best_of(state).verdict.objective < 0.02);
    }
}

// The test begins with three trials whose objectives span 0.03, and then runs a search on a smooth function
// until the search counts as converged.
void a_search_has_converged_when_its_population_is_equally_good(void **)
{
    SearchState state;
    SearchSettings settings{Method::cmaes, 20, 200, 1};
    settings.stop_spread_mm = 0.031;
    assert_false(has_converged(settings, state));
    for (const double objective : {0.50, 0.52, 0.53}) state.population.push_back({{}, {objective, 0, 0}});
    assert_true(has_converged(settings, state));
    settings.stop_spread_mm = 0.029;
    assert_false(has_converged(settings, state));
    settings.stop_spread_mm = 0.0;
    assert_false(has_converged(settings, state));

    settings.stop_spread_mm = 0.01;
    state = {};
    while (state.generation < settings.generations && !has_converged(settings, state))
        advance(settings, 3, all_of, state);
    print_message("generation %u of %u, best %g\n", state.generation, settings.generations,
                  best_of(state).verdict.objective);
    assert_in_range(state.generation, 5, 60);
    assert_true(best_of(state).verdict.objective < 0.02);
}

// In this test the nodes lie 2 mm from the reference, and the force is twice the measured force.
void without_a_weight_the_force_trace_is_not_there(void **)
{
    const Folder folder("judge");
    insertion::Case c;
    c.folder = folder.path;
    c.force = "force.csv";
    c.depths = {{"here", 30.0, 0.0, "", "depth_1.csv"}};
    insertion::write_centreline(folder.file("depth_1.csv"), {{0, 0, 0}, {30, 0, 0}});
    insertion::write_force(folder.file("force.csv"), {{10, 50}, {20, 50}, {30, 50}});
    Insertion made;
    made.nodes_mm = {{{20, 2, 0}, {10, 2, 0}}};
    made.force = {{10, 100}, {20, 100}, {30, 100}};
    const Judge with(c, {});
    assert_true(with.has_force());
    assert_near(with.judge(made).objective, 2.0 + with.settings().force_weight_mm * 1.0, 1e-9);
    JudgeSettings settings;
    settings.force_weight_mm = 0.0;
    const Judge without(c, settings);
    assert_false(without.has_force());
    assert_near(without.judge(made).objective, 2.0, 1e-9);
}

// All three methods have the same budget: the thesis' 50 generations of 50, and more but smaller generations
// for CMA-ES.
void without_a_size_a_search_has_the_budget_of_the_thesis(void **)
{
    const SearchSettings genetic = sized({}, Method::genetic, {}, {}),
                         cmaes = sized({}, Method::cmaes, {}, {});
    assert_int_equal(genetic.population, 50);
    assert_int_equal(genetic.generations, 50);
    assert_int_equal(cmaes.population, 16);
    assert_int_equal(cmaes.generations, 156);
    assert_true(sized({}, Method::differential, {}, {}).method == Method::differential);
    assert_int_equal(sized({}, Method::cmaes, 1000, {}).generations,
                     50); // at least 50, where the budget would allow only two random draws
    assert_int_equal(sized({}, Method::cmaes, {}, 20).generations, 20);
}

// The evaluator of this test either returns a rod that lies on the reference, or refuses every trial.
struct ScriptedEvaluator final : Evaluator {
    bool refuses = false;

    explicit ScriptedEvaluator(bool is_refused) : refuses(is_refused)
    {
        parameters_ = {{"alpha", "1", "of the tip", 0.1, 10.0, 1.0}};
    }
    std::string rod() const override { return "core"; }
    std::string instrument_name() const override { return "scripted"; }
    std::string settings_text() const override { return ""; }
    std::string instrument_text(const std::vector<double> &, const std::string &) const override
    {
        return "";
    }
    Insertion insert(const std::vector<double> &, std::size_t) const override
    {
        if (refuses) throw TrialRefused("elements too short for the number format");
        Insertion made;
        made.nodes_mm = {{{20, 0, 0}, {10, 0, 0}}};
        made.settle_ticks = {150};
        return made;
    }
};

// Short elements may exceed the core's number format; in this case only the result of the insertion without
// shortcuts is missing.
void a_fit_is_not_lost_where_its_short_cuts_cannot_be_measured(void **)
{
    const Folder folder("careful");
    insertion::Case c;
    c.folder = folder.path;
    c.depths = {{"here", 30.0, 0.0, "", "depth_1.csv"}};
    insertion::write_centreline(folder.file("depth_1.csv"), {{0, 0, 0}, {30, 0, 0}});
    const Judge judge(c, {});
    const ScriptedEvaluator sound(false), refused(true);
    Finished search;
    search.state.trials = {{{0.5}, {0.0, 0.0, 0.0}}};
    const EvaluateShares evaluate = [](const std::vector<std::vector<double>> &trials) {
        return std::vector<Verdict>(trials.size());
    };
    IdentifySettings settings;
    settings.is_wanted = false;
    const Result with = make_result(c, sound, sound, judge, {search}, evaluate, settings);
    const Result without = make_result(c, sound, refused, judge, {search}, evaluate, settings);
    assert_true(with.depths.at(0).short_cuts_mm.has_value());
    assert_false(without.depths.at(0).short_cuts_mm.has_value());
    assert_near(without.depths.at(0).distances.rms_mm, 0.0, 1e-9);
    assert_true(to_json(without).find("short_cuts_mm") == std::string::npos);
}

void another_seed_gives_other_trials(void **)
{
    assert_false(same(searched({Method::cmaes, 8, 3, 1}, all_of).trials,
                      searched({Method::cmaes, 8, 3, 2}, all_of).trials));
}

// The workers return results in any order, and the search does not depend on this order.
void any_number_of_threads_gives_the_same_bits(void **)
{
    for (const Method method : methods) {
        const SearchSettings settings{method, 10, 8, 5};
        const SearchState one = searched(settings, all_of);
        for (const unsigned threads : {1u, 2u, 4u}) {
            const std::unique_ptr<Workers> workers = thread_workers(threads, valley, {}, {});
            const SearchState many =
                searched(settings, [&](const auto &trials) { return workers->evaluate(trials); });
            assert_true(same(one.trials, many.trials));
        }
    }
}

void what_a_trial_throws_comes_back_from_the_workers(void **)
{
    const Evaluate broken = [](const std::vector<double> &) -> Verdict {
        throw std::runtime_error("broken");
    };
    const std::unique_ptr<Workers> workers = thread_workers(2, broken, {}, {});
    bool is_told = false;
    try {
        workers->evaluate({{0.5}, {0.6}});
    } catch (const std::runtime_error &error) {
        is_told = std::string(error.what()) == "broken";
    }
    assert_true(is_told);
}

void a_wish_to_stop_ends_an_evaluation(void **)
{
    const std::unique_ptr<Workers> workers = thread_workers(2, valley, [] { return true; }, {});
    bool is_stopped = false;
    try {
        workers->evaluate({{0.5}, {0.6}});
    } catch (const Interrupted &) {
        is_stopped = true;
    }
    assert_true(is_stopped);
}

// --- checkpoints ---

// If a search is written to a checkpoint and read back after every generation, it proceeds exactly as a
// search without checkpoints.
void a_search_that_was_stopped_after_any_generation_goes_on_as_if_not(void **)
{
    const Folder folder{"checkpoint"};
    for (const Method method : methods) {
        const SearchSettings settings{method, 10, 7, 11};
        const SearchState whole = searched(settings, all_of);
        SearchState state;
        while (state.generation < settings.generations) {
            advance(settings, 3, all_of, state);
            write_checkpoint(folder.file("c"), 77, settings, state);
            state = read_checkpoint(folder.file("c"), 77, 3);
        }
        assert_true(same(whole.trials, state.trials));
        assert_true(same(whole.population, state.population));
    }
}

bool is_refused(const std::string &file, std::uint64_t hash, const std::string &words)
{
    try {
        read_checkpoint(file, hash, 3);
    } catch (const CheckpointError &error) {
        return std::string(error.what()).find(words) != std::string::npos;
    }
    return false;
}

void a_checkpoint_of_another_case_or_a_damaged_one_is_refused(void **)
{
    const Folder folder{"refused"};
    const SearchSettings settings{Method::cmaes, 8, 3, 1};
    const std::string file = folder.file("c"), cut = folder.file("cut");
    write_checkpoint(file, 77, settings, searched(settings, all_of));
    assert_true(is_refused(file, 78, "of another case or of other settings"));
    std::ifstream stream(file);
    const std::string text{std::istreambuf_iterator<char>(stream), {}};
    for (const double share : {0.1, 0.5, 0.9, 0.999}) {
        std::ofstream(cut) << text.substr(0,
                                          static_cast<std::size_t>(share * static_cast<double>(text.size())));
        assert_true(is_refused(cut, 77, "is damaged"));
    }
    std::ofstream(cut) << "cournand-calibrate-checkpoint 9\n" << text;
    assert_true(is_refused(cut, 77, "of this version"));
}

void the_hash_tells_borders_and_numbers(void **)
{
    Hash a, b, c;
    a.add("ab");
    a.add("c");
    b.add("a");
    b.add("bc");
    c.add(0.1);
    assert_true(a.value() != b.value());
    Hash d;
    d.add(std::nextafter(0.1, 1.0));
    assert_true(c.value() != d.value());
}

// --- what is determined ---

// The objective is |x - 0.4| + 0 y, where x and y are the positions 0 .. 1 of two parameters in their ranges.
// If the objective may rise by 0.05, x can vary from 0.35 to 0.45. The test permits an error of one halving
// step (0.04 / 16) in these bounds. The objective |x - 0.4| + 0 y does not bound y.
void what_the_data_leave_open_is_said_to_be_undetermined(void **)
{
    const std::vector<Parameter> parameters = {{"x", "", "", 1.0, 10.0, 3.0}, {"y", "", "", 1.0, 10.0, 3.0}};
    const EvaluateShares evaluate = [](const std::vector<std::vector<double>> &trials) {
        std::vector<Verdict> verdicts;
        for (const auto &trial : trials)
            verdicts.push_back({std::abs(trial[0] - 0.4), std::abs(trial[0] - 0.4), 0.0});
        return verdicts;
    };
    const Trial best{{0.4, 0.7}, {0.0, 0.0, 0.0}};
    const std::vector<Identified> found = identify(parameters, best, {best}, evaluate, {});
    assert_near(parameters[0].share_of(found[0].low), 0.35, 0.0026);
    assert_near(parameters[0].share_of(found[0].high), 0.45, 0.0026);
    assert_true(found[0].is_determined);
    assert_near(found[1].span_share, 1.0, 1e-12);
    assert_false(found[1].is_determined);
}

// The objective is |x - y|, and the optimum is at x = y = 0.5. If only one number varies, its range is
// bounded. The search's trials along x = y show that both numbers are undetermined.
void numbers_that_make_up_for_each_other_are_undetermined(void **)
{
    const std::vector<Parameter> parameters = {{"x", "", "", 1.0, 10.0, 3.0}, {"y", "", "", 1.0, 10.0, 3.0}};
    const EvaluateShares evaluate = [](const std::vector<std::vector<double>> &trials) {
        std::vector<Verdict> verdicts;
        for (const auto &trial : trials) verdicts.push_back({std::abs(trial[0] - trial[1]), 0.0, 0.0});
        return verdicts;
    };
    const Trial best{{0.5, 0.5}, {0.0, 0.0, 0.0}};
    std::vector<Trial> trials = {best};
    for (const double share : {0.05, 0.3, 0.8, 0.95})
        trials.push_back({{share, share + 0.01}, {0.01, 0.0, 0.0}});
    for (const Identified &one : identify(parameters, best, trials, evaluate, {}))
        assert_false(one.is_determined);
    for (const Identified &one : identify(parameters, best, {best}, evaluate, {}))
        assert_true(one.is_determined);
}

} // namespace

int main()
{
    const CMUnitTest tests[] = {
        cmocka_unit_test(distances_go_to_the_nearest_point_of_the_line),
        cmocka_unit_test(equation_19_is_the_rms_over_the_nodes),
        cmocka_unit_test(the_force_error_is_relative_and_passes_over_single_peaks),
        cmocka_unit_test(parameters_and_shares_are_each_others_inverse),
        cmocka_unit_test(a_virtual_instrument_has_the_values_asked_for),
        cmocka_unit_test(a_fitted_file_is_read_as_the_table_it_was_made_of),
        cmocka_unit_test(a_preset_made_from_another_one_cannot_be_written),
        cmocka_unit_test(all_trials_of_a_generation_are_evaluated_together),
        cmocka_unit_test(every_method_finds_the_bottom_of_a_valley),
        cmocka_unit_test(a_search_has_converged_when_its_population_is_equally_good),
        cmocka_unit_test(without_a_weight_the_force_trace_is_not_there),
        cmocka_unit_test(without_a_size_a_search_has_the_budget_of_the_thesis),
        cmocka_unit_test(a_fit_is_not_lost_where_its_short_cuts_cannot_be_measured),
        cmocka_unit_test(another_seed_gives_other_trials),
        cmocka_unit_test(any_number_of_threads_gives_the_same_bits),
        cmocka_unit_test(what_a_trial_throws_comes_back_from_the_workers),
        cmocka_unit_test(a_wish_to_stop_ends_an_evaluation),
        cmocka_unit_test(a_search_that_was_stopped_after_any_generation_goes_on_as_if_not),
        cmocka_unit_test(a_checkpoint_of_another_case_or_a_damaged_one_is_refused),
        cmocka_unit_test(the_hash_tells_borders_and_numbers),
        cmocka_unit_test(what_the_data_leave_open_is_said_to_be_undetermined),
        cmocka_unit_test(numbers_that_make_up_for_each_other_are_undetermined),
    };
    cmocka_set_message_output(CM_OUTPUT_TAP);
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
