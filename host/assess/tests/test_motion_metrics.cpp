// Tests the measures of motion: smoothness, pauses, submovements, and the path length of a trembling point.
// The smoothness is compared with check values that its authors published.
#include "host/assess/motion_metrics.hpp"
#include "host/assess/session_log.hpp"
#include <cmath>
#include <csetjmp>
#include <cstdarg>
#include <cstddef>
#include <cstdint>
#include <vector>
extern "C" {
#include <cmocka.h>
}

namespace
{

std::vector<double> bell(double narrowness, double centre_s = 0.0)
{
    std::vector<double> speed;
    for (int i = 0; i < 200; ++i)
        speed.push_back(std::exp(-narrowness * std::pow(-1.0 + 0.01 * i - centre_s, 2)));
    return speed;
}

// For the speed profile exp(-5 t^2), with t from -1 to 1 s at 100 Hz, the program of SPARC's authors gives a
// spectral arc length of -1.41403.
void sparc_has_its_published_check_value(void **)
{
    assert_float_equal(crn::sparc(bell(5.0), 100.0), -1.41403, 5e-6);
}

// For the same function, the program of SPARC's authors gives -5.81636 as the logarithmic dimensionless jerk.
void ldlj_has_its_published_check_value(void **)
{
    assert_float_equal(crn::ldlj(bell(5.0), 100.0), -5.81636, 5e-6);
}

void smoothness_does_not_depend_on_the_speed_and_falls_with_tremor(void **)
{
    const std::vector<double> smooth = bell(5.0);
    std::vector<double> fast = smooth, trembling = smooth;
    for (std::size_t i = 0; i < smooth.size(); ++i) {
        fast[i] *= 10.0;
        trembling[i] *= 1.0 + 0.3 * std::sin(2.0 * M_PI * 5.0 * 0.01 * static_cast<double>(i));
    }
    assert_float_equal(crn::sparc(fast, 100.0), crn::sparc(smooth, 100.0), 1e-12);
    assert_float_equal(crn::ldlj(fast, 100.0), crn::ldlj(smooth, 100.0), 1e-9);
    assert_true(crn::sparc(trembling, 100.0) < crn::sparc(smooth, 100.0) - 0.1);
    assert_true(crn::ldlj(trembling, 100.0) < crn::ldlj(smooth, 100.0) - 1.0);
}

void profiles_without_motion_have_no_smoothness(void **)
{
    const std::vector<double> none(50, 0.0), one = {1.0};
    assert_float_equal(crn::sparc(none, 100.0), 0.0, 0.0);
    assert_float_equal(crn::ldlj(none, 100.0), 0.0, 0.0);
    assert_float_equal(crn::sparc(one, 100.0), 0.0, 0.0);
    assert_int_equal(crn::submovements(none), 0);
}

void two_bells_are_two_submovements_and_a_ripple_is_none(void **)
{
    const std::vector<double> first = bell(60.0, -0.4), second = bell(60.0, 0.4);
    std::vector<double> both = first, rippled = first;
    for (std::size_t i = 0; i < both.size(); ++i) {
        both[i] += 0.5 * second[i];
        rippled[i] += 0.03 * second[i];
    }
    assert_int_equal(crn::submovements(first), 1);
    assert_int_equal(crn::submovements(both), 2);
    assert_int_equal(crn::submovements(rippled), 1);
}

void a_motion_is_split_at_its_pauses_only(void **)
{
    std::vector<double> speed(300, 0.0);
    for (std::size_t i = 20; i < 80; ++i) speed[i] = 30.0;   // 0.6 s
    for (std::size_t i = 85; i < 140; ++i) speed[i] = 30.0;  // after 50 ms: the same movement
    for (std::size_t i = 180; i < 240; ++i) speed[i] = 30.0; // after 400 ms: another one
    for (std::size_t i = 260; i < 270; ++i) speed[i] = 30.0; // 0.1 s: too short
    const std::vector<crn::Movement> movements = crn::split_movements(speed, 100.0);
    assert_int_equal(movements.size(), 2);
    assert_int_equal(movements[0].begin, 20);
    assert_int_equal(movements[0].end, 140);
    assert_int_equal(movements[1].begin, 180);
}

void a_trembling_tip_has_no_path(void **)
{
    crn::PathLength<2> path(2.0);
    for (int i = 0; i < 1000; ++i) path.add({100.0 + (i % 2), 100.0});
    assert_float_equal(path.length(), 0.0, 0.0);
    for (int i = 0; i <= 100; ++i) path.add({100.0 + i, 100.0});
    assert_float_equal(path.length(), 100.0, 2.0);
    path.interrupt(); // a jump while the X-ray is off is no path
    path.add({400.0, 400.0});
    assert_float_equal(path.length(), 100.0, 2.0);
}

// A hand pushes 60 mm in 2 s, rests, and pulls 60 mm back; the tip follows the hand. The path in the picture
// counts only while the X-ray is on.
void a_tool_has_the_path_of_its_hand_and_its_tip(void **)
{
    crn::SessionLog log;
    log.tools = {"wire"};
    for (int i = 0; i < 500; ++i) {
        crn::SessionMoment moment;
        moment.tick = static_cast<std::uint32_t>(i) * crn::SessionLog::every_ticks;
        const double x = std::min(i, 125) - std::clamp(i - 300, 0, 125);
        crn::ToolMoment &tool = moment.tools[0];
        tool.inserted_mm = 60.0 * x / 125.0;
        tool.has_tip = tool.is_in_picture = true;
        tool.tip_mm = {0.0, tool.inserted_mm, 0.0};
        tool.right_px = 100.0;
        tool.down_px = 400.0 - 3.0 * tool.inserted_mm;
        moment.is_xray_on = i < 200;
        log.moments.push_back(moment);
    }
    const crn::MotionFigures motion = crn::motion_of(log, 0);
    assert_float_equal(motion.hand_path_mm, 120.0, 1e-6);
    assert_float_equal(motion.tip_path_mm, 120.0, 1.0);
    assert_float_equal(motion.tip_path_px, 180.0, 4.0);
    assert_int_equal(motion.movements, 2);
    assert_true(motion.sparc.has_value() && *motion.sparc < -1.0);
    assert_float_equal(*motion.speed_mean_mm_s, 30.0, 3.0);
}

} // namespace

int main()
{
    const CMUnitTest tests[] = {
        cmocka_unit_test(sparc_has_its_published_check_value),
        cmocka_unit_test(ldlj_has_its_published_check_value),
        cmocka_unit_test(smoothness_does_not_depend_on_the_speed_and_falls_with_tremor),
        cmocka_unit_test(profiles_without_motion_have_no_smoothness),
        cmocka_unit_test(two_bells_are_two_submovements_and_a_ripple_is_none),
        cmocka_unit_test(a_motion_is_split_at_its_pauses_only),
        cmocka_unit_test(a_trembling_tip_has_no_path),
        cmocka_unit_test(a_tool_has_the_path_of_its_hand_and_its_tip),
    };
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
