// These tests check the following. The traces of the heart follow the beats that the core reports: rate,
// pressures of a resting adult, and the effects of a premature beat and of asystole. The host reads the
// displacements of a moving vessel exactly as the scene file holds them. Undoing a displacement returns a
// point to the reference pose, and bodies move with the lattice of displacements.
#include "host/effects/pulse.hpp"
#include "host/model/motion.hpp"
#include "shared/scene/tests/scene_sample.h"

#include <cmath>
#include <csetjmp>
#include <cstdarg>
#include <cstddef>
#include <cstdint>
extern "C" {
#include "firmware/core/core.h"
#include <cmocka.h>
}

using namespace crn;

namespace
{

// Simulates a heart monitor that receives the beats of the core's own rhythm.
struct Patient {
    crn_rhythm rhythm{};
    PulseMonitor monitor;
    Patient() { crn_rhythm_init(&rhythm); }
    crn_wire_tick_state tick(std::uint32_t action = 0, std::uint32_t value = 0)
    {
        const crn_rhythm_order order{action, value};
        crn_rhythm_step(&rhythm, &order);
        crn_wire_tick_state state{};
        state.heart_phase32 = rhythm.heart_phase32;
        state.beat_ms = rhythm.beat_ms;
        state.interval_ms = rhythm.interval_ms;
        state.rhythm_bits = static_cast<std::uint8_t>(rhythm.bits);
        monitor.tick(state);
        return state;
    }
    void run(int ms)
    {
        for (int i = 0; i < ms; ++i) tick();
    }
};

// At 70 /min the systolic pressure must be 110 to 130 mmHg, and the diastolic 70 to 85 mmHg. The heart rate,
// computed from the intervals between beats, must be exact to 0.2 /min.
void a_resting_adult_has_the_usual_pressures(void **)
{
    Patient patient;
    patient.run(15000);
    print_message("# %.0f/%.0f mmHg at %.1f /min\n", patient.monitor.systolic_mmHg(),
                  patient.monitor.diastolic_mmHg(), patient.monitor.rate_per_min());
    assert_true(patient.monitor.systolic_mmHg() > 110 && patient.monitor.systolic_mmHg() < 130);
    assert_true(patient.monitor.diastolic_mmHg() > 70 && patient.monitor.diastolic_mmHg() < 85);
    assert_true(std::abs(patient.monitor.rate_per_min() - 70) < 0.2);
}

// The ventricle ejects less blood in a premature beat, so the systolic pressure of this beat is lower. The
// diastolic pressure after the long pause that follows a premature beat is lower too.
void a_premature_beat_is_weak_and_the_pause_after_it_long(void **)
{
    Patient patient;
    patient.run(15000);
    const double systolic = patient.monitor.systolic_mmHg(), diastolic = patient.monitor.diastolic_mmHg();
    patient.tick(CRN_RHYTHM_PREMATURE, 450);
    const std::uint32_t beats = patient.monitor.beats();
    while (patient.monitor.premature_beats() == 0) patient.tick();
    assert_true(patient.monitor.beats() <= beats + 2);
    const std::uint32_t early = patient.monitor.beats();
    while (patient.monitor.beats() == early) patient.tick();
    print_message("# %.0f/%.0f mmHg, before it %.0f/%.0f\n", patient.monitor.systolic_mmHg(),
                  patient.monitor.diastolic_mmHg(), systolic, diastolic);
    assert_true(patient.monitor.systolic_mmHg() < systolic - 5);
    assert_true(patient.monitor.diastolic_mmHg() < diastolic - 5);
}

// The curve must begin at the left edge with the first pressure. A position of the curve that was never
// written would be drawn as a fall to 0 mmHg.
void the_curve_begins_with_the_first_sample(void **)
{
    Patient patient;
    patient.run(1000);
    assert_int_equal(patient.monitor.newest(), 199); // 1000 ms, a sample every 5 ms
    for (std::size_t i = 0; i <= patient.monitor.newest(); ++i)
        assert_true(patient.monitor.samples()[i].pressure_mmHg > 60.0f);
}

// Without heartbeats the windkessel empties: the pressure P less 6 mmHg falls by a factor of e in R C = 1.42
// s (resistance times compliance), and the electrocardiogram is flat.
void asystole_is_a_flat_line_and_a_falling_pressure(void **)
{
    Patient patient;
    patient.run(5000);
    patient.tick(CRN_RHYTHM_ASYSTOLE, 1);
    while ((patient.rhythm.bits & CRN_RHYTHM_IS_RESTING) == 0) patient.tick();
    patient.run(200);
    const double before = patient.monitor.pressure_mmHg() - 6;
    patient.run(1418); // 1.05 x 1.35 s
    const double after = patient.monitor.pressure_mmHg() - 6;
    assert_true(std::abs(after / before - std::exp(-1.0)) < 0.002);
    const crn_wire_tick_state state = patient.tick();
    assert_true(std::abs(ecg_mV(0, state.beat_ms, state.interval_ms, state.rhythm_bits)) < 1e-6);
    patient.run(3000);
    assert_true(patient.monitor.rate_per_min() == 0);
}

// The R wave comes 36 ms after the QRS begins, and the T wave at four fifths of systole. Up to a rate of 150
// /min, the P wave comes before the next QRS.
void the_waves_stand_where_the_beat_says(void **)
{
    for (std::uint32_t rate : {50u, 70u, 150u}) {
        const double interval = 60000.0 / rate, systole = 540 - 2.1 * rate;
        const auto at = [&](double ms) {
            const double phase = ms < systole ? ms / systole * phase_systole_end
                                              : phase_systole_end + (ms - systole) / (interval - systole) *
                                                                        (1 - phase_systole_end);
            return ecg_mV(phase, ms, interval, 0);
        };
        assert_true(at(36) > 1.0 && at(36) > at(31) && at(36) > at(41));
        assert_true(at(0.8 * systole) > 0.2);
        assert_true(at(interval - 118) > 0.1);
    }
}

// --- the lattice ---

struct Sample {
    alignas(16) std::uint8_t file[SAMPLE_BYTES_MAX];
    crn_scene scene{};
    Sample()
    {
        const std::size_t bytes = sample_moving_scene(file, sizeof file);
        if (crn_scene_open(file, bytes, &scene, nullptr) != CRN_SCENE_OK)
            fail_msg("the sample does not open");
    }
};

MotionMoment moment(double heart, double breath)
{
    return {static_cast<std::uint32_t>(heart * 4294967296.0),
            static_cast<std::uint32_t>(breath * 4294967296.0)};
}

// The middle node of the lattice is at (0, 7.8125, 7.8125) mm. The displacement coefficients of that node are
// 44 units at keyframe 0 and rise by 44 units per keyframe. A quadratic spline through values on a straight
// line is this straight line itself. The deepest breath moves the node by 262 units along y.
void the_lattice_is_read_as_it_was_written(void **)
{
    const Sample sample;
    const Motion motion(sample.scene);
    const Eigen::Vector3d node(0, 8.0 / 1024, 8.0 / 1024);
    const double unit = 0x1p-19;
    const Eigen::Vector3d pulled = motion.pull(node, moment(5.0 / 24, 0));
    assert_true(std::abs(pulled.x() - 6 * 44 * unit) < 1e-9 && std::abs(pulled.y() - node.y()) < 1e-9);
    assert_true(std::abs(motion.pull(node, moment(0, 0.5)).y() - node.y() - 262 * unit) < 1e-9);
    const Eigen::Vector3d outside(0.1, 0, 0);
    assert_true(motion.pull(outside, moment(0.3, 0.5)) == outside);
}

void pushing_undoes_pulling(void **)
{
    const Sample sample;
    const Motion motion(sample.scene);
    for (int i = 0; i < 500; ++i) {
        const Eigen::Vector3d x((i % 7 - 3) * 2e-3, (i % 11) * 1.5e-3, (i % 13) * 1.2e-3);
        const MotionMoment now = moment(i / 500.0, (i * 37 % 500) / 500.0);
        assert_true((motion.push(motion.pull(x, now), now) - x).norm() < 1e-6);
    }
}

// Each body has eight vertices, and only one of the two bodies moves. At the keyframes, the vertices of the
// moving body agree with the lattice to within 2 um.
void bodies_that_move_go_where_the_lattice_takes_them(void **)
{
    const Sample sample;
    const Motion motion(sample.scene);
    Bodies bodies;
    bodies.bodies.resize(2);
    for (int i = 0; i < 8; ++i)
        bodies.bodies[1].vertices_um.emplace_back(-1000 + 2000 * (i & 1), 7000 + 2000 * (i >> 1 & 1),
                                                  8000 + 500 * (i >> 2));
    bodies.bodies[0] = bodies.bodies[1];
    bodies.bodies[1].moves = true;
    MovingBodies moving(motion, bodies);
    for (int key = 0; key < motion_keyframes; ++key) {
        const MotionMoment now = moment(key / 24.0, 0);
        const auto &moved = moving.at(now);
        assert_true(moved.size() == 1 && moved[0].body == 1);
        for (std::size_t i = 0; i < 8; ++i) {
            const Eigen::Vector3d wanted =
                motion.push(bodies.bodies[1].vertices_um[i].cast<double>() * 1e-6, now) * 1e6;
            assert_true((moved[0].vertices_um[i].cast<double>() - wanted).cwiseAbs().maxCoeff() < 2);
        }
    }
}

// Between keyframes and in a breath, too, each vertex moves by the displacement at its point, rounded to 1
// um.
void vertices_move_as_single_points(void **)
{
    const Sample sample;
    const Motion motion(sample.scene);
    Bodies bodies;
    bodies.bodies.resize(1);
    bodies.bodies[0].moves = true;
    std::vector<Eigen::Vector3d> places_m;
    for (int i = 0; i < 300; ++i) {
        bodies.bodies[0].vertices_um.emplace_back(-6000 + 37 * i, 29 * i, 31 * i);
        places_m.push_back(bodies.bodies[0].vertices_um.back().cast<double>() * 1e-6);
    }
    const MovingPoints points(motion, places_m);
    MovingBodies moving(motion, bodies);
    for (int step = 0; step < 50; ++step) {
        const MotionMoment now = moment(step * 0.0173, step * 0.0119);
        const auto &moved = moving.at(now);
        for (std::size_t i = 0; i < points.size(); ++i) {
            const Eigen::Vector3f way_um = points.way_um(i, motion_weights(now));
            for (int k = 0; k < 3; ++k)
                assert_int_equal(moved[0].vertices_um[i][k],
                                 bodies.bodies[0].vertices_um[i][k] + std::lround(way_um[k]));
        }
    }
}

// Places move with the lattice. The spline passes through the keyframes, where positions are exact to 1 um.
// Between keyframes and in a deep breath, positions are exact to 50 um. Points outside the lattice do not
// move; their positions are equal bit for bit.
void points_that_move_go_where_the_lattice_takes_them(void **)
{
    const Sample sample;
    const Motion motion(sample.scene);
    std::vector<Eigen::Vector3d> places_m = {{0.1, 0, 0}};
    for (int i = 0; i < 40; ++i) places_m.emplace_back((i % 5 - 2) * 3e-3, (i % 8) * 1.8e-3, (i % 7) * 2e-3);
    const MovingPoints points(motion, places_m);
    assert_true(points.size() == 41 && !points.moves(0) && points.moves(10));
    for (int step = 0; step < 4 * motion_keyframes; ++step) {
        const double heart = step / (4.0 * motion_keyframes);
        const MotionMoment now = moment(heart, 0), inhaled = moment(heart, 0.5), half = moment(heart, 0.318);
        assert_true(points.at(0, motion_weights(now)) == places_m[0]);
        for (std::size_t i = 0; i < points.size(); ++i) {
            const double off_m = (points.at(i, motion_weights(now)) - motion.push(places_m[i], now)).norm();
            if (off_m > (step % 4 == 0 ? 1e-6 : 50e-6)) fail_msg("place %zu off by %g m", i, off_m);
            const double breath_off_m =
                (points.at(i, motion_weights(inhaled)) - motion.push(places_m[i], inhaled)).norm();
            if (breath_off_m > (step % 4 == 0 ? 2e-6 : 50e-6))
                fail_msg("place %zu off by %g m", i, breath_off_m);
            assert_true((points.at(i, motion_weights(half)) - motion.push(places_m[i], half)).norm() < 50e-6);
        }
    }
}

} // namespace

int main()
{
    const CMUnitTest tests[] = {
        cmocka_unit_test(a_resting_adult_has_the_usual_pressures),
        cmocka_unit_test(the_curve_begins_with_the_first_sample),
        cmocka_unit_test(a_premature_beat_is_weak_and_the_pause_after_it_long),
        cmocka_unit_test(asystole_is_a_flat_line_and_a_falling_pressure),
        cmocka_unit_test(the_waves_stand_where_the_beat_says),
        cmocka_unit_test(the_lattice_is_read_as_it_was_written),
        cmocka_unit_test(pushing_undoes_pulling),
        cmocka_unit_test(points_that_move_go_where_the_lattice_takes_them),
        cmocka_unit_test(bodies_that_move_go_where_the_lattice_takes_them),
        cmocka_unit_test(vertices_move_as_single_points),
    };
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
