// Tests that the program detects in the same tick when the physics leaves its range, and reports the values
// and their limits. A session whose physics stays in range must not be stopped. The simulated grip of a hand
// must be rigid up to the force that fingers can hold, and the tool must slip above this force. The slip of
// the tool must not depend on how many ticks are stepped in one batch.
#include <cmath>
#include <csetjmp>
#include <cstdarg>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "host/model/vessel_tree.hpp"
#include "host/session/hand_grip.hpp"
#include "host/session/range_watch.hpp"

// The header cmocka.h comes last, because its macros (fail, ...) would change other headers.
extern "C" {
#include <cmocka.h>
}

namespace
{

using crn::HandGrip;
using crn::RangeWatch;

constexpr double q30 = 1 << 30, q22 = 1 << 22, q24 = 1 << 24;

crn_wire_tick_state state_at(std::uint32_t tick, double depth_mm = 0.0, double length_pct = 0.0,
                             std::uint32_t fault_bits = 0)
{
    crn_wire_tick_state state{};
    state.tick = tick;
    state.tools_count = 1;
    state.penetration_max_m_q30 = static_cast<std::int32_t>(depth_mm * 1e-3 * q30);
    state.strain_max_q30 = static_cast<std::int32_t>(length_pct * 1e-2 * q30);
    state.core_fault_bits = fault_bits;
    return state;
}

bool says(const RangeWatch &watch, const std::string &what)
{
    return watch.is_left() && range_text(*watch.left()).find(what) != std::string::npos;
}

// A value that equals its limit counts as in range. The core also reports stalled feeds, limited steps, and
// tools at the end of their travel (fault bits 1 to 3), which are all normal.
void what_stays_within_the_limits_is_no_error(void **)
{
    RangeWatch watch;
    watch.take(state_at(1, 0.999, 0.999));
    watch.take(state_at(2, 0.0, -0.999, 0xe));
    assert_false(watch.is_left());
    assert_true(range_report(watch.left()).is_null());
    assert_false(watch.wants_place(16, true));
}

void a_tool_deep_in_the_wall_is_out_of_range_in_that_tick(void **)
{
    RangeWatch watch;
    for (std::uint32_t tick = 1; tick < 12345; tick++) watch.take(state_at(tick, 0.2));
    watch.take(state_at(12345, 3.51));
    watch.take(state_at(12346, 9.0, 5.0, 1)); // later values are not reported
    assert_int_equal(watch.left()->tick, 12345);
    assert_true(range_notice(*watch.left()) == "physics left its range at 00:12.3");
    assert_true(says(watch, "physics left its range at 00:12.3 (tick 12345): 3.51 mm through the wall"));
    assert_true(says(watch, "limit 1 mm") && says(watch, "Remedy:"));
    assert_false(says(watch, "length error"));
    const nlohmann::ordered_json report = range_report(watch.left());
    assert_int_equal(report["tick"].get<int>(), 12345);
    assert_true(std::fabs(report["penetration_mm"].get<double>() - 3.51) < 1e-6);
    assert_true(report["place_mm"].is_null());
}

void a_line_too_long_or_too_short_and_a_saturated_core_are_out_of_range(void **)
{
    for (double length_pct : {9.47, -1.2}) {
        RangeWatch watch;
        watch.take(state_at(61000, 0.1, length_pct));
        assert_true(says(watch, "at 01:01.0") && says(watch, "of length error, limit 1 %"));
        assert_false(says(watch, "through the wall"));
    }
    RangeWatch watch;
    watch.take(state_at(7, 0.1, 0.1, 1));
    assert_true(watch.left()->is_saturated && says(watch, "CORE_SATURATED"));
}

// A session and its replay step the ticks in different batches. Session and replay must read the position of
// the largest wall force at the same tick: the next multiple of 16 or the last tick.
void where_it_happened_is_looked_at_on_a_tick_that_every_run_has(void **)
{
    RangeWatch watch;
    watch.take(state_at(33, 2.0));
    assert_false(watch.wants_place(33, false));
    assert_false(watch.wants_place(47, false));
    assert_true(watch.wants_place(48, false));
    assert_true(watch.wants_place(40, true));
}

// --- the grip ---

crn_wire_tick_state felt(std::uint32_t tick, double axial_N, double torque_mN_m = 0.0)
{
    crn_wire_tick_state state = state_at(tick);
    state.tools[0].handle_axial_N_q22 = static_cast<std::int32_t>(axial_N * q22);
    state.tools[0].handle_torque_N_m_q24 = static_cast<std::int32_t>(torque_mN_m * 1e-3 * q24);
    return state;
}

crn_wire_hand told(const HandGrip &grip, std::int32_t translation, std::int32_t rotation = 0)
{
    crn_wire_tick_input wanted{};
    wanted.hands_count = 1;
    wanted.hands[0] = {translation, rotation};
    return grip.hold(wanted).hands[0];
}

void below_its_limits_the_grip_is_rigid(void **)
{
    HandGrip grip;
    for (std::uint32_t tick = 1; tick <= 1000; tick++)
        grip.feel(felt(tick, tick % 2 == 0 ? 24.9 : -24.9, 49.0));
    assert_int_equal(told(grip, 1234, -56).translation_counts, 1234);
    assert_int_equal(told(grip, 1234, -56).rotation_counts, -56);
    assert_false(grip.figures(0).first_tick.has_value());
}

// A hand pushes a tool at 20 mm/s against a wall of 20 N/mm: without slip, the force on the wall would be 400
// N after 1 s. When the force reaches 25 N, the tool must slip in the hand. The force may exceed the limit of
// 25 N by 0.4 N through the motion of one tick (20 um), and by another 0.4 N before the slip takes effect.
// The test is repeated in the other direction, and the simulated encoder counts wrap round as real ones do.
void beyond_its_force_the_tool_stays_behind_and_the_hand_slips(void **)
{
    for (int sign : {1, -1}) {
        HandGrip grip;
        double force_N = 0.0, most_N = 0.0;
        const std::int32_t begin = INT32_MAX - 10;
        for (std::uint32_t tick = 1; tick <= 1000; tick++) {
            const auto hand = static_cast<std::int32_t>(static_cast<std::uint32_t>(begin) +
                                                        static_cast<std::uint32_t>(sign * 20) * tick);
            const auto way_um =
                static_cast<std::int32_t>(static_cast<std::uint32_t>(told(grip, hand).translation_counts) -
                                          static_cast<std::uint32_t>(begin));
            force_N = way_um * 0.02;
            most_N = std::max(most_N, std::fabs(force_N));
            grip.feel(felt(tick, force_N));
        }
        print_message("# %.2f N at most, %.2f N held, %.2f mm slipped\n", most_N, force_N,
                      grip.figures(0).slipped_mm);
        assert_true(most_N < 26.0 && std::fabs(std::fabs(force_N) - 25.0) < 0.5);
        assert_true(std::fabs(grip.figures(0).slipped_mm - (20.0 - 1.25)) < 0.1);
        assert_true(*grip.figures(0).first_tick > 60 && *grip.figures(0).first_tick < 67);
    }
}

// The tool is held with a stiffness of 1 N m/rad, so a torque of 50 mN m turns it by 0.05 rad, or 2.9
// degrees. The hand turns the tool by one turn per second, and the test checks the torque from tick 16 on.
void beyond_its_torque_it_slips_as_well(void **)
{
    HandGrip grip;
    double torque_mN_m = 0.0;
    for (std::uint32_t tick = 1; tick <= 1000; tick++) {
        torque_mN_m = told(grip, 0, static_cast<std::int32_t>(tick * 65)).rotation_counts * 6.2832 / 65.536;
        grip.feel(felt(tick, 0.0, torque_mN_m));
        assert_true(torque_mN_m < (tick < 40 ? 110.0 : 65.0));
    }
    assert_true(std::fabs(torque_mN_m - 56.2) < 7.0); // each tick adds 6.2 mN m to the torque after the slip
    assert_true(std::fabs(grip.figures(0).slipped_deg - 354.0) < 1.0);
}

// The encoder counts must be equal whether the session steps single ticks or the largest batches that the
// grip allows.
void what_slips_does_not_depend_on_the_batches(void **)
{
    const auto run = [](std::uint32_t batch_most) {
        HandGrip grip;
        std::vector<std::int32_t> all;
        double place_um = 0.0;
        for (std::uint32_t tick = 0; tick < 2000;) {
            const std::uint32_t count = std::min({grip.batch_max(tick), batch_most, 2000 - tick});
            const auto wanted = [](std::uint32_t t) {
                return static_cast<std::int32_t>(3000.0 * std::sin(t * 0.01));
            };
            std::vector<std::int32_t> hands;
            for (std::uint32_t i = 1; i <= count; i++)
                hands.push_back(told(grip, wanted(tick + i)).translation_counts);
            for (std::int32_t hand : hands) {
                place_um += 0.25 * (hand - place_um);
                all.push_back(hand);
                grip.feel(felt(++tick, place_um * 0.03));
            }
        }
        return all;
    };
    const std::vector<std::int32_t> one = run(1);
    assert_true(run(16) == one);
    assert_true(run(7) == one);
    assert_true(*std::max_element(one.begin(), one.end()) < 2000); // it did slip
}

} // namespace

int main()
{
    const CMUnitTest tests[] = {
        cmocka_unit_test(what_stays_within_the_limits_is_no_error),
        cmocka_unit_test(a_tool_deep_in_the_wall_is_out_of_range_in_that_tick),
        cmocka_unit_test(a_line_too_long_or_too_short_and_a_saturated_core_are_out_of_range),
        cmocka_unit_test(where_it_happened_is_looked_at_on_a_tick_that_every_run_has),
        cmocka_unit_test(below_its_limits_the_grip_is_rigid),
        cmocka_unit_test(beyond_its_force_the_tool_stays_behind_and_the_hand_slips),
        cmocka_unit_test(beyond_its_torque_it_slips_as_well),
        cmocka_unit_test(what_slips_does_not_depend_on_the_batches),
    };
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
