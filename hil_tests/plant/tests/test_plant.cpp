// These tests compare the simulated rig with closed formulas: motion under constant forces, friction that
// stops and holds, and slip at its threshold. The tests also cover the lag of the motors, the quantisation of
// the encoders, the timing of the power stage, and determinism.
#include <cmath>
#include <csetjmp>
#include <cstdarg>
#include <cstddef>
#include <cstdint>
#include <cstdio>

#include "hil_tests/plant/plant.hpp"

extern "C" {
#include <cmocka.h>
}

namespace
{

using hil::Axis;
using hil::AxisSettings;
using hil::Hand;
using hil::Plant;
using hil::PlantSettings;
using hil::SensorFault;

void near(const char *what, double value, double expected, double allowed)
{
    if (!(std::abs(value - expected) <= allowed))
        fail_msg("%s = %.9g, expected %.9g, allowed +-%.2g", what, value, expected, allowed);
}

AxisSettings ideal() // no friction, no lag
{
    AxisSettings s;
    s.coulomb = s.viscous = 0.0;
    s.motor_lag_s = 1e-9;
    return s;
}

void run(Axis &axis, int milliseconds, double command)
{
    for (int i = 0; i < milliseconds; i++) axis.step(command, true);
}

// x = F t^2 / 2 (m_t + m_r)
void a_free_tool_accelerates_by_newton(void **)
{
    const AxisSettings s = ideal();
    Axis axis(s);
    axis.set_hand(Hand::none);
    run(axis, 100, -0.3);
    const double expected = 0.5 * 0.3 / (s.tool_inertia + s.roller_inertia) * 0.1 * 0.1;
    near("place after 100 ms in m", axis.roller(), expected, 1e-9);
    near("tool in m", axis.tool(), expected, 1e-9);
}

// A tool of mass m is released at the speed v0, and the friction F stops it after the distance m v0^2 / (2
// F). After the stop, the tool's position stays equal to the last bit.
void friction_stops_a_free_tool_and_holds_it(void **)
{
    AxisSettings s = ideal();
    s.coulomb = 0.05;
    Axis axis(s);
    axis.move_hand(0.2);
    run(axis, 10, 0.0);
    const double begin = axis.tool();
    axis.set_hand(Hand::none);
    run(axis, 500, 0.0);
    const double mass = s.tool_inertia + s.roller_inertia;
    near("way to rest in m", axis.tool() - begin, 0.2 * 0.2 * mass / (2.0 * s.coulomb), 0.2 * 50e-6);
    const double rest = axis.roller();
    run(axis, 100, 0.049); // less than the friction: the tool holds
    assert_true(axis.roller() == rest);
    run(axis, 100, 0.051);
    assert_true(axis.roller() < rest);
}

void viscous_friction_gives_a_terminal_speed(void **)
{
    AxisSettings s = ideal();
    s.viscous = 2.0;
    Axis axis(s);
    axis.set_hand(Hand::none);
    run(axis, 1000, -1.0);
    near("speed in m/s", axis.tool_speed(), 0.5, 1e-9);
}

// While the hand holds the tool, a motor force up to the sum of grip and bearing friction does not move the
// roller. A motor force beyond the sum of grip and bearing friction makes the roller slip.
void the_roller_slips_at_its_threshold(void **)
{
    AxisSettings s = ideal();
    s.coulomb = 0.05;
    s.grip_limit = 2.0;
    Axis below(s), above(s);
    run(below, 50, 2.049);
    assert_false(below.is_slipping());
    assert_true(below.roller() == 0.0);
    run(above, 50, 2.15);
    assert_true(above.is_slipping());
    near("roller after 50 ms in m", above.roller(), -0.5 * 0.1 / s.roller_inertia * 0.05 * 0.05, 1e-6);
    assert_true(above.tool() == 0.0);
    near("force on the hand in N", above.force_on_hand(), 2.0, 1e-9);
}

void the_hand_feels_the_motor_at_rest(void **)
{
    Axis axis(AxisSettings{});
    run(axis, 100, 1.5);
    near("force on a held hand in N, up to the bearing's friction", axis.force_on_hand(), 1.5, 0.0501);
    Axis spring(AxisSettings{});
    spring.set_hand(Hand::spring);
    run(spring, 2000, 1.5);
    near("deflection of the hand's spring in m", -spring.tool(), 1.5 / 600.0, 0.0501 / 600.0);
}

// When a motor is switched on, its current follows i = I (1 - exp(-t / tau)), with the final current I, the
// time t and the time constant tau. If the motor has no power, the current decays to zero, whatever the
// device commands.
void the_motor_lags_and_loses_power(void **)
{
    const AxisSettings s;
    Axis axis(s);
    run(axis, 3, 4.0);
    near("force after 3 ms in N", axis.motor_force(), 4.0 * (1.0 - std::exp(-3e-3 / s.motor_lag_s)), 1e-9);
    const double before = axis.motor_force();
    axis.step(4.0, false);
    near("force 1 ms after power went", axis.motor_force(), before * std::exp(-1e-3 / s.motor_decay_s), 1e-9);
    run(axis, 100, 50.0);
    near("force at the current limit in N", axis.motor_force(), s.motor_limit, 1e-6);
    assert_true(axis.is_limited());
}

void a_motor_that_sticks_on_needs_the_power_stage(void **)
{
    Axis axis(AxisSettings{});
    axis.set_motor_fault(hil::MotorFault::stuck_on);
    run(axis, 20, 0.0);
    near("force in N", axis.motor_force(), axis.settings().motor_limit, 1e-3);
    assert_true(axis.is_limited());
    for (int i = 0; i < 5; i++) axis.step(0.0, false);
    near("force without power in N", axis.motor_force(), 0.0, 1e-5);
}

// The encoder's count is floor(position / width of a count + 1/2), so the position read from the count is
// wrong by at most half a count plus jitter.
void encoders_quantise_by_half_a_count(void **)
{
    hil::Random random(3);
    for (double jitter : {0.0, 2.0}) {
        hil::Encoder encoder({1e-5, jitter});
        double worst = 0.0;
        for (int i = 0; i < 5000; i++) {
            const double place = 0.02 * (random.uniform() - 0.5);
            encoder.sample(place, random);
            worst = std::fmax(worst, std::abs(encoder.counts() - place / 1e-5));
        }
        near("largest error in counts", worst, 0.5 + jitter, 0.02 + 0.02 * jitter);
        assert_true(worst <= 0.5 + jitter + 1e-9);
    }
}

void encoders_wrap_and_have_faults(void **)
{
    hil::Random random(3);
    hil::Encoder encoder({1e-9, 0.0});
    encoder.sample(2.147483648, random); // 2^31 counts
    assert_int_equal(encoder.counts(), INT32_MIN);
    hil::Encoder faulty({1e-6, 0.0});
    faulty.sample(1e-3, random);
    faulty.set_fault(SensorFault::reversed);
    faulty.sample(1.2e-3, random);
    assert_int_equal(faulty.counts(), 800);
    faulty.set_fault(SensorFault::none);
    faulty.set_fault(SensorFault::jump, 7000);
    assert_int_equal(faulty.counts(), 8200);
    faulty.set_fault(SensorFault::stuck);
    faulty.sample(5e-3, random);
    assert_int_equal(faulty.counts(), 8200);
    assert_int_equal(faulty.health(), CRN_PORT_SENSOR_OK);
    faulty.set_fault(SensorFault::range);
    assert_int_equal(faulty.health(), CRN_PORT_SENSOR_RANGE);
}

// While the device changes the level of the drive line every millisecond, the motors have power. The motors
// lose power n ms after the last change of the drive line, with n = CRN_PORT_DRIVE_HOLD_ms.
void the_power_stage_drops_power_5_ms_after_the_last_flip(void **)
{
    Plant plant(PlantSettings{});
    crn_port_outputs outputs{};
    outputs.enable = true;
    plant.step(outputs);
    assert_false(plant.is_stage_on());
    for (int i = 0; i < 20; i++) {
        outputs.drive = !outputs.drive;
        outputs.motors[1].axial_mN = 3000;
        plant.step(outputs);
        assert_true(plant.is_stage_on());
        assert_true(plant.inputs().stage_on);
    }
    near("force with power in N", plant.motor_peak_N(), 3.0, 1e-3);
    int on_ms = 0;
    for (; on_ms < 100 && plant.is_stage_on(); on_ms++) plant.step(outputs);
    assert_int_equal(on_ms, CRN_PORT_DRIVE_HOLD_ms);
    for (int i = 0; i < 3; i++) plant.step(outputs);
    near("force without power in N", plant.motor_peak_N(), 0.0, 0.01);
}

void the_power_stage_obeys_enable_stop_and_supply_at_once(void **)
{
    for (int what = 0; what < 3; what++) {
        Plant plant(PlantSettings{});
        crn_port_outputs outputs{};
        outputs.enable = outputs.drive = true;
        plant.step(outputs);
        assert_true(plant.is_stage_on());
        outputs.drive = false;
        if (what == 0) outputs.enable = false;
        if (what == 1) plant.emergency_stop = true;
        if (what == 2) plant.supply_good = false;
        plant.step(outputs);
        assert_false(plant.is_stage_on());
    }
}

void the_force_sensor_shows_the_force_and_saturates(void **)
{
    PlantSettings settings;
    settings.force_noise_N = 0.0;
    Plant plant(settings);
    crn_port_outputs outputs{};
    outputs.enable = true;
    outputs.motors[0].axial_mN = 2000;
    for (int i = 0; i < 100; i++) {
        outputs.drive = !outputs.drive;
        plant.step(outputs);
    }
    near("reading in mN", plant.inputs().tracks[0].force_raw, 2000.0, 51.0);
    plant.track(0).force_fault = SensorFault::jump;
    plant.track(0).force_jump_N = 30.0;
    plant.step(outputs);
    assert_int_equal(plant.inputs().tracks[0].force_sensor, CRN_PORT_SENSOR_RANGE);
    assert_int_equal(plant.inputs().tracks[0].force_raw, 20000);
}

void a_seed_gives_the_same_rig_every_time(void **)
{
    std::int64_t sums[3] = {0, 0, 0};
    for (int i = 0; i < 3; i++) {
        PlantSettings settings;
        settings.seed = i < 2 ? 7 : 8;
        settings.translation_encoder.jitter_counts = 1.5;
        Plant plant(settings);
        plant.track(0).translation.set_hand(Hand::spring);
        plant.track(0).translation.move_hand(0.05);
        crn_port_outputs outputs{};
        outputs.enable = true;
        for (int ms = 0; ms < 300; ms++) {
            outputs.drive = !outputs.drive;
            outputs.motors[0].axial_mN = 4 * ms;
            plant.step(outputs);
            sums[i] = sums[i] * 31 + plant.inputs().hands[0].translation_counts +
                      plant.inputs().tracks[0].force_raw;
            sums[i] &= 0xffffffffff;
        }
    }
    assert_true(sums[0] == sums[1]);
    assert_true(sums[0] != sums[2]);
}

} // namespace

int main()
{
    const CMUnitTest tests[] = {
        cmocka_unit_test(a_free_tool_accelerates_by_newton),
        cmocka_unit_test(friction_stops_a_free_tool_and_holds_it),
        cmocka_unit_test(viscous_friction_gives_a_terminal_speed),
        cmocka_unit_test(the_roller_slips_at_its_threshold),
        cmocka_unit_test(the_hand_feels_the_motor_at_rest),
        cmocka_unit_test(the_motor_lags_and_loses_power),
        cmocka_unit_test(a_motor_that_sticks_on_needs_the_power_stage),
        cmocka_unit_test(encoders_quantise_by_half_a_count),
        cmocka_unit_test(encoders_wrap_and_have_faults),
        cmocka_unit_test(the_power_stage_drops_power_5_ms_after_the_last_flip),
        cmocka_unit_test(the_power_stage_obeys_enable_stop_and_supply_at_once),
        cmocka_unit_test(the_force_sensor_shows_the_force_and_saturates),
        cmocka_unit_test(a_seed_gives_the_same_rig_every_time),
    };
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
