// These tests check the following. The simulated hand approaches each depth slowly. The hand waits until the
// rod's mean position no longer moves. The hand must not wait longer because the tip oscillates quickly, and
// must not stop waiting because a slowly creeping tip pauses. The force on the hand is recorded from the
// first millimetre of insertion onwards.
#include "tools/lab/calibrate/hand.hpp"
#include "tools/lab/calibrate/tests/near.hpp"
#include <cmath>

// The header cmocka.h and the headers that it needs come last, because its macros (fail, ...) would change
// other headers.
#include <csetjmp>
#include <cstdarg>
extern "C" {
#include <cmocka.h>
}

using namespace crn::calibrate;
using namespace crn::calibrate::tests;
namespace insertion = crn::insertion;

namespace
{

constexpr double um = 1e-3; // in mm

// The simulated rod of this test follows the hand immediately. The only node of the rod is displaced sideways
// by `aside_mm`, a function of the number of ticks since the hand stopped.
struct ScriptedRod final : HeldRod {
    double (*aside_mm)(int ticks) = [](int) { return 0.0; };
    std::vector<double> places_mm;
    int still_ticks = 0;

    void tick(double hand_mm, double) override
    {
        still_ticks = !places_mm.empty() && hand_mm == places_mm.back() ? still_ticks + 1 : 0;
        places_mm.push_back(hand_mm);
    }
    double inserted_mm() const override { return places_mm.empty() ? 5.0 : places_mm.back(); }
    double handle_axial_mN() const override { return 2.0 * inserted_mm(); }
    bool is_sound() const override { return true; }
    std::vector<Vector3d> nodes_mm() const override { return {{inserted_mm(), aside_mm(still_ticks), 0.0}}; }

    // Returns the highest speed of insertion, in mm/s, while the inserted length was between two values.
    double fastest_mm_per_s(double from_mm, double to_mm) const
    {
        double most = 0.0;
        for (std::size_t i = 1; i < places_mm.size(); i++)
            if (places_mm[i - 1] >= from_mm && places_mm[i] <= to_mm)
                most = std::max(most, (places_mm[i] - places_mm[i - 1]) * 1e3);
        return most;
    }
};

insertion::Case case_to(std::vector<double> depths_mm, double speed_mm_per_s)
{
    insertion::Case c;
    c.speed_mm_per_s = speed_mm_per_s;
    for (const double inserted_mm : depths_mm) c.depths.push_back({"", inserted_mm, 0.0, "", ""});
    return c;
}

InsertionSettings settings_of(double speed_mm_per_s)
{
    InsertionSettings settings;
    settings.speed_mm_per_s = speed_mm_per_s;
    settings.approach_mm = 10.0;
    settings.approach_mm_per_s = 10.0;
    return settings;
}

// --- speed ---

void last_way_to_each_depth_is_slow(void **)
{
    ScriptedRod rod;
    insert_by_hand(rod, case_to({40.0, 80.0}, 5.0), settings_of(50.0), 2);
    assert_near(rod.fastest_mm_per_s(5.0, 29.9), 50.0, 1e-6);
    assert_near(rod.fastest_mm_per_s(30.1, 40.0), 10.0, 1e-6);
    assert_near(rod.fastest_mm_per_s(40.0, 69.9), 50.0, 1e-6);
    assert_near(rod.fastest_mm_per_s(70.1, 80.0), 10.0, 1e-6);
}

// If the insertion was measured at 30 mm/s, the hand does not slow down to 10 mm/s before a depth.
void last_way_is_as_fast_as_the_cases_hand(void **)
{
    ScriptedRod rod;
    insert_by_hand(rod, case_to({40.0}, 30.0), settings_of(50.0), 1);
    assert_near(rod.fastest_mm_per_s(30.1, 40.0), 30.0, 1e-6);
}

void a_hand_that_is_slow_everywhere_stays_so(void **)
{
    ScriptedRod rod;
    insert_by_hand(rod, case_to({40.0}, 5.0), settings_of(5.0), 1);
    assert_near(rod.fastest_mm_per_s(5.0, 40.0), 5.0, 1e-6);
}

// --- rest ---

Insertion rested(ScriptedRod &rod, InsertionSettings settings = settings_of(50.0))
{
    return insert_by_hand(rod, case_to({20.0}, 10.0), settings, 1);
}

void a_still_rod_is_at_rest_after_three_windows(void **)
{
    ScriptedRod rod;
    const Insertion made = rested(rod);
    assert_true(made.is_settled);
    assert_int_equal(made.settle_ticks.at(0), 150);
}

// The node is displaced by 25 um in every second tick, like a J tip that oscillates on a wall (docs/rod.md).
// A displacement of 25 um is a hundred times the displacement per tick that still counts as rest. In each
// following time interval of 50 ticks, the displaced and the undisplaced ticks change places. A program that
// read the node's position only in every second tick would therefore see the node jump by 25 um between two
// time intervals. The mean position of the node is nearly the same in all time intervals.
void a_tip_that_trembles_in_its_place_is_at_rest(void **)
{
    ScriptedRod rod;
    rod.aside_mm = [](int ticks) { return (ticks + ticks / 50) % 2 ? 25.0 * um : 0.0; };
    const Insertion made = rested(rod);
    assert_true(made.is_settled);
    assert_int_equal(made.settle_ticks.at(0), 150);
    assert_near(made.nodes_mm.at(0).at(0).y(), 12.5 * um, 3.0 * um); // its mean place, from ten samples
}

// The node moves slowly by 0.3 um per tick for 400 ticks and then stops.
void a_creeping_rod_is_waited_for(void **)
{
    ScriptedRod rod;
    rod.aside_mm = [](int ticks) { return 0.3 * um * std::min(ticks, 400); };
    const Insertion made = rested(rod);
    assert_true(made.is_settled);
    assert_in_range(made.settle_ticks.at(0), 500, 600);
}

// The node swings to and fro. Two time intervals of equal length just before and after the turning point of
// the swing have equal mean positions.
void a_swing_is_not_at_rest_where_it_turns_back(void **)
{
    ScriptedRod rod;
    rod.aside_mm = [](int ticks) { return std::cos(2.0 * 3.14159265 * (ticks - 50) / 400.0); }; // mm
    assert_false(rested(rod).is_settled);
}

void a_rod_that_never_rests_is_said_to_be_unsettled(void **)
{
    ScriptedRod rod;
    rod.aside_mm = [](int ticks) { return 0.3 * um * ticks; };
    const Insertion made = rested(rod);
    assert_false(made.is_settled);
    assert_int_equal(made.settle_ticks.at(0), 1000);
}

// A rod counts as resting if its displacement per tick is small enough, whatever the length of the time
// interval. A rod that moves by 0.3 um per tick is at rest if the limit is 0.4 um per tick.
void rest_is_judged_by_the_way_per_tick(void **)
{
    ScriptedRod rod;
    rod.aside_mm = [](int ticks) { return 0.3 * um * ticks; };
    InsertionSettings settings = settings_of(50.0);
    settings.still_um_per_tick = 0.4;
    assert_true(rested(rod, settings).is_settled);
}

// --- force ---

// The force is sampled at equal steps of inserted length, both where the hand is slow and where it is fast.
void force_is_sampled_by_way(void **)
{
    ScriptedRod rod;
    const Insertion made = insert_by_hand(rod, case_to({40.0}, 10.0), settings_of(50.0), 1);
    int slow = 0, fast = 0;
    for (const insertion::ForceSample &sample : made.force) {
        fast += sample.inserted_mm > 10.0 && sample.inserted_mm <= 20.0;
        slow += sample.inserted_mm > 30.0 && sample.inserted_mm <= 40.0;
    }
    assert_in_range(fast, 60, 110); // every 0.15 and 0.1 mm
    assert_in_range(slow, 90, 110);
}

void force_is_kept_by_what_was_inserted_and_rises(void **)
{
    ScriptedRod rod;
    const Insertion made = rested(rod);
    assert_true(made.force.size() > 50);
    for (std::size_t i = 0; i < made.force.size(); i++) {
        assert_near(made.force[i].axial_mN, 2.0 * made.force[i].inserted_mm, 1e-9);
        assert_true(i == 0 || made.force[i].inserted_mm > made.force[i - 1].inserted_mm);
    }
}

} // namespace

int main()
{
    const CMUnitTest tests[] = {
        cmocka_unit_test(last_way_to_each_depth_is_slow),
        cmocka_unit_test(last_way_is_as_fast_as_the_cases_hand),
        cmocka_unit_test(a_hand_that_is_slow_everywhere_stays_so),
        cmocka_unit_test(a_still_rod_is_at_rest_after_three_windows),
        cmocka_unit_test(a_tip_that_trembles_in_its_place_is_at_rest),
        cmocka_unit_test(a_creeping_rod_is_waited_for),
        cmocka_unit_test(a_swing_is_not_at_rest_where_it_turns_back),
        cmocka_unit_test(a_rod_that_never_rests_is_said_to_be_unsettled),
        cmocka_unit_test(rest_is_judged_by_the_way_per_tick),
        cmocka_unit_test(force_is_sampled_by_way),
        cmocka_unit_test(force_is_kept_by_what_was_inserted_and_rises),
    };
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
