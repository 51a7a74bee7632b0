// These tests check the following. The compression experiment of the thesis can be repeated in a short form.
// In a given lumen, the compressions of the baseline's modes have the same order as in Figure 5.11, and our
// direct solver has the least compression. The presets are stable with the number of steps that they state,
// and become unstable with slightly fewer steps. The rod shows those limitations of the thesis' method that
// docs/thesis.md states. Everything is deterministic. The lumen is a straight tube closed at both ends.
#include "tools/lab/figures/study.hpp"
#include "tools/lab/figures/thesis_values.hpp"

#include <cmath>
#include <csetjmp>
#include <cstdarg>
#include <cstddef>
#include <cstdint>
#include <random>

extern "C" {
#include "firmware/tests/reference/tube_lumen.h"
}

// The header cmocka.h comes last, because its macros (fail, ...) would change other headers.
extern "C" {
#include <cmocka.h>
}

using namespace vcsim3;

namespace
{

constexpr double tube_radius_m = 0.008, tube_length_m = 0.085;
reference_tube *tube;

int make_tube(void **)
{
    const reference_piece straight = {tube_length_m, 0.0, 0.0};
    tube = reference_tube_make(&straight, 1, tube_radius_m, 0);
    return 0;
}

int free_tube(void **)
{
    reference_tube_free(tube);
    return 0;
}

// The rod enters the tube at an angle, so that the rod is bent when it reaches the tube's end.
Vessel vessel()
{
    return {tube->lumen, Vector::Zero(), Vector(1.0, 0.25, 0.1)};
}

StudySettings short_study(const std::vector<std::string> &tokens)
{
    StudySettings settings;
    settings.preset = find_preset("amplatz");
    settings.protocol.element_count = 68;
    settings.protocol.hold_s = 0.1;
    for (const std::string &token : tokens) {
        settings.modes.emplace_back();
        assert_true(parse_mode(token, settings.modes.back()));
    }
    settings.with_times = settings.with_stability = false;
    return settings;
}

bool keep_on(const std::string &, double)
{
    return true;
}

void order_of_figure_5_11_in_a_short_run(void **)
{
    const Vessel place = vessel();
    const Study study =
        make_study(short_study({"global", "penalty", "local1", "local5", "local10", "local25", "local50"}),
                   place, keep_on);
    for (const CompressionResult &run : study.runs)
        std::printf("# %-10s %.4f %% pushing, %.4f %% at rest, %d contacts\n", run.name.c_str(),
                    run.pushing_pct, run.holding_pct, run.contacts);
    for (const std::string &fault : order_faults(study)) fail_msg("%s", fault.c_str());
    assert_true(find_run(study, "local1")->pushing_pct > find_run(study, "local5")->pushing_pct);
}

void wrong_order_is_found(void **)
{
    Study study;
    const auto add = [&study](const char *token, double percent) {
        CompressionResult run;
        run.name = run.token = token;
        run.pushing_pct = percent;
        study.runs.push_back(run);
    };
    add("penalty", 5.0);
    add("local5", 1.0);
    add("local10", 1.5);
    add("direct", 0.1);
    assert_int_equal(order_faults(study).size(), 1);
    study.runs[3].pushing_pct = 1.2;
    assert_int_equal(order_faults(study).size(), 2);
    study.runs[0].is_sound = false;
    assert_int_equal(order_faults(study).size(), 3);
}

void same_bits_for_any_number_of_threads_and_from_a_saved_state(void **)
{
    const Vessel place = vessel();
    StudySettings settings = short_study({"penalty", "local5"});
    settings.protocol.element_count = 40;
    const Study one = make_study(settings, place, keep_on);
    settings.threads = 3;
    const Study three = make_study(settings, place, keep_on);
    for (std::size_t i = 0; i < one.runs.size(); i++) assert_true(one.runs[i].state == three.runs[i].state);

    Simulation first = make_simulation(*settings.preset, settings.modes[1], place, settings.protocol);
    for (int i = 0; i < 50; i++) first.tick(5e-5);
    Simulation second = make_simulation(*settings.preset, settings.modes[1], place, settings.protocol);
    assert_true(second.restore(first.save()));
    for (int i = 0; i < 50; i++) {
        first.tick(5e-5);
        second.tick(5e-5);
    }
    assert_true(first.save() == second.save());
    assert_false(second.restore({1.0, 2.0}));
}

void stopping_wish_ends_a_study(void **)
{
    const Vessel place = vessel();
    bool was_interrupted = false;
    try {
        make_study(short_study({"global"}), place, [](const std::string &, double) { return false; });
    } catch (const Interrupted &) {
        was_interrupted = true;
    }
    assert_true(was_interrupted);
}

void lumen_in_doubles_is_the_cores_lumen(void **)
{
    std::mt19937_64 random(5);
    const auto draw = [&random](double low, double high) {
        return low + (high - low) * std::ldexp(static_cast<double>(random() >> 11), -53);
    };
    double worst_m = 0.0, worst_normal = 0.0;
    for (int i = 0; i < 20000; i++) {
        const crn_vec3 q = crn_vec3_make(static_cast<std::int32_t>(std::ldexp(draw(-0.03, 0.12), 30)),
                                         static_cast<std::int32_t>(std::ldexp(draw(-0.02, 0.02), 30)),
                                         static_cast<std::int32_t>(std::ldexp(draw(-0.02, 0.02), 30)));
        const Vector p(std::ldexp(q.v[0], -30), std::ldexp(q.v[1], -30), std::ldexp(q.v[2], -30));
        const crn_lumen_sample core = crn_lumen_contact(&tube->lumen, &q);
        const LumenSample ours = sample_lumen(tube->lumen, p);
        worst_m = std::max(worst_m, std::abs(ours.distance_m - std::ldexp(core.distance_m_q30, -30)));
        // The direction of the normal has no meaning where the value of the distance field is at its limit.
        if (std::abs(ours.distance_m) > 0.003) continue;
        for (int k = 0; k < 3; k++)
            worst_normal =
                std::max(worst_normal, std::abs(ours.inward[k] - std::ldexp(core.normal_q30.v[k], -30)));
    }
    if (!(worst_m < 1e-7)) fail_msg("distances differ by %.3g m, allowed 1e-7", worst_m);
    if (!(worst_normal < 1e-5)) fail_msg("normals differ by %.3g, allowed 1e-5", worst_normal);
}

void presets_are_table_5_1_and_keep_the_step_ratio(void **)
{
    assert_int_equal(presets().size(), 9);
    for (const Preset &preset : presets()) {
        const double ratio = step_ratio(preset, preset_element_m, preset.substeps);
        const double fewer = step_ratio(preset, preset_element_m, preset.substeps - 1);
        if (!(ratio <= 1.5 && fewer > 1.5))
            fail_msg("%s: step ratio %.3f with %d steps, %.3f with one less; allowed 1.5", preset.token,
                     ratio, preset.substeps, fewer);
    }
    // The expected stiffness is the EI of the first row of Table 5.1 in the units of docs/instruments.md.
    const double bend = find_preset("amplatz")->bend_N_m2();
    if (std::abs(bend - 1.8e-5) > 1e-7) fail_msg("EI = %g, expected 1.80e-5", bend);
    assert_null(find_preset("lunderquist"));
}

void preset_is_stable_at_its_steps_and_bursts_with_half(void **)
{
    const Preset &preset = *find_preset("amplatz");
    for (const char *token : {"penalty", "local1", "local10", "global"}) {
        Mode mode;
        assert_true(parse_mode(token, mode));
        if (!survives_crowding(preset, mode, preset.substeps)) fail_msg("%s burst at its own steps", token);
        if (survives_crowding(preset, mode, preset.substeps / 2))
            fail_msg("%s is stable at half its steps", token);
    }
}

// By the parallel constraint with the stiffness Kp, the transverse motion of a segment of length |e| and mass
// m has the angular frequency 2/|e| sqrt(Kp l/m), so compressed segments need shorter time steps. With a step
// ratio r (time step times the highest angular frequency), the rod is stable up to a compression of 1 - r/2
// of its length. Beyond the compression of 1 - r/2 the rod becomes unstable, so the compression that a mode
// shows cannot grow without limit.
bool stays_straight_when_squeezed(double compression)
{
    const Preset &preset = *find_preset("amplatz");
    Rod rod(rod_of(preset, 40, preset_element_m), Vector::Zero(), Vector::UnitX());
    for (int i = 0; i < rod.node_count(); i++) {
        rod.position[i].x() *= 1.0 - compression;
        rod.position[i].y() = i % 2 ? 1e-9 : -1e-9;
    }
    for (int i = 0; i < 4000; i++) {
        add_elastic_forces(rod);
        integrate_velocities(rod, 1e-3 / preset.substeps);
        integrate_positions(rod, 1e-3 / preset.substeps);
    }
    for (const Vector &position : rod.position)
        if (!(std::abs(position.y()) < 1e-6)) return false;
    return true;
}

void squeezed_segments_burst_where_the_step_ratio_says(void **)
{
    const Preset &preset = *find_preset("amplatz");
    const double limit = 1.0 - step_ratio(preset, preset_element_m, preset.substeps) / 2.0;
    double stable = 0.0, burst = 0.9;
    while (burst - stable > 0.005) {
        const double middle = (stable + burst) / 2.0;
        (stays_straight_when_squeezed(middle) ? stable : burst) = middle;
    }
    std::printf("# bursts at %.3f, predicted %.3f\n", burst, limit);
    if (!(std::abs(burst - limit) < 0.05)) fail_msg("bursts at %.3f, predicted %.3f +- 0.05", burst, limit);
}

// When a straight rod is pushed straight into a wall, the wall stops the tip only after the distance
// constraints have been solved. The next solution of the constraints lets the whole rod push the tip on, so
// the wall's force never reaches the rest of the rod.
void one_global_iteration_does_not_pass_the_walls_force_on(void **)
{
    const Preset &preset = *find_preset("amplatz");
    for (const char *token : {"global", "local200"}) {
        SimulationSettings settings;
        parse_mode(token, settings.mode);
        settings.substeps = preset.substeps;
        Simulation simulation(rod_of(preset, 40, preset_element_m), Inserter(Vector::Zero(), Vector::UnitX()),
                              tube_wall(0.01, 0.0304), settings, 0.028);
        for (int i = 0; i < 40; i++) simulation.tick(5e-5);
        const Rod &rod = simulation.rod();
        const double first = (rod.position[1] - rod.position[0]).norm() / preset_element_m - 1.0;
        const double second = (rod.position[2] - rod.position[1]).norm() / preset_element_m - 1.0;
        std::printf("# %s: first segment %.1f %%, second %.2f %%\n", token, first * 100, second * 100);
        if (settings.mode.kind == Mode::Kind::global) {
            if (!(first < -0.2 && std::abs(second) < 0.01))
                fail_msg("first segment %.4f, second %.4f: expected all of it in the first", first, second);
        } else if (!(second < -0.01 && second > 3.0 * first)) {
            fail_msg("first segment %.4f, second %.4f: expected it shared", first, second);
        }
    }
}

void modes_have_names_and_tokens(void **)
{
    Mode mode;
    for (const Mode &each : thesis_modes()) {
        assert_true(parse_mode(each.token(), mode));
        assert_true(mode == each);
    }
    for (const char *wrong : {"", "local", "local0", "local10001", "local5x", "globally", "direct"})
        assert_false(parse_mode(wrong, mode));
    assert_string_equal(thesis_modes()[5].name().c_str(), "25 Local");
    // The expected values are the compression of the mode "50 local" less the two improvements that the text
    // of the thesis states.
    assert_true(std::abs(*thesis_compression_pct("local100") - 0.99) < 1e-12);
    assert_true(std::abs(*thesis_compression_pct("local200") - 0.61) < 1e-12);
    assert_false(thesis_compression_pct("penalty").has_value());
}

} // namespace

int main()
{
    const CMUnitTest tests[] = {
        cmocka_unit_test(order_of_figure_5_11_in_a_short_run),
        cmocka_unit_test(wrong_order_is_found),
        cmocka_unit_test(same_bits_for_any_number_of_threads_and_from_a_saved_state),
        cmocka_unit_test(stopping_wish_ends_a_study),
        cmocka_unit_test(lumen_in_doubles_is_the_cores_lumen),
        cmocka_unit_test(presets_are_table_5_1_and_keep_the_step_ratio),
        cmocka_unit_test(preset_is_stable_at_its_steps_and_bursts_with_half),
        cmocka_unit_test(squeezed_segments_burst_where_the_step_ratio_says),
        cmocka_unit_test(one_global_iteration_does_not_pass_the_walls_force_on),
        cmocka_unit_test(modes_have_names_and_tokens),
    };
    return cmocka_run_group_tests(tests, make_tube, free_tube);
}
