// Tests that positions in a tree of vessels get the names that anatomists use. A script that steers must
// reach its vessel although the tip usually turns into another vessel. In this test only some angles of the
// hand lead into the wanted vessel. The script must reach the vessel for every width and position of the
// range of angles that lead into it. If a script fails to reach the vessel, the message must state where the
// tip was. Each expectation must be reported with its result and the number of its line in the script. The
// simulated anatomy of these tests is only a tube with one wrong branch. Only the angle of the hand decides
// which of the two vessels the tip enters; this is the hardest case for a bent tip.
#include <algorithm>
#include <cmath>
#include <csetjmp>
#include <cstdarg>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <string>
#include <vector>

#include "firmware/tests/reference/long_run.h"
#include "host/base/text.hpp"
#include "host/script/session.hpp"

extern "C" {
#include <cmocka.h>
}

namespace
{

using Eigen::Vector3d;

// The root vessel goes up along y from 0 to 300 mm; "brachiocephalic" leaves it at 80 mm, and "left
// subclavian" at 120 mm. The tools enter at the end of the root vessel, at 300 mm.
crn::VesselTree tree()
{
    crn::VesselTree tree;
    crn::VesselBranch root{"aorta", -1, 0, {}, {}};
    for (int i = 0; i <= 30; i++) {
        root.points_m.push_back({0.0, 0.01 * i, 0.0});
        root.radii_m.push_back(0.012);
    }
    const auto branch = [](const char *name, std::size_t point) {
        crn::VesselBranch side{name, 0, point, {}, {}};
        for (int i = 0; i <= 8; i++) {
            side.points_m.push_back({0.01 * i, 0.01 * static_cast<double>(point), 0.0});
            side.radii_m.push_back(0.005);
        }
        return side;
    };
    tree.branches = {root, branch("brachiocephalic_artery", 8), branch("left_subclavian_artery", 12)};
    return tree;
}

// The tip is `pushed_m` beyond the end of the introducer sheath, which is at y = 290 mm. At the left
// subclavian artery the tip stays in the aorta only if the hand's angle differs from `open_deg` by at most
// `window_deg`. After the tip has passed the branching, it stays in its vessel until it is pulled back.
struct World {
    double open_deg, window_deg;
    bool is_astray = false, was_beyond = false;

    Vector3d tip(double pushed_m, double hand_deg)
    {
        const double turning_m = 0.17;
        const bool is_beyond = pushed_m > turning_m;
        if (is_beyond && !was_beyond) {
            double off = std::fmod(hand_deg - open_deg, 360.0);
            if (off > 180.0) off -= 360.0;
            if (off < -180.0) off += 360.0;
            is_astray = std::fabs(off) > window_deg;
        }
        was_beyond = is_beyond;
        if (is_beyond && is_astray) return {std::min(pushed_m - turning_m, 0.079), 0.12, 0.0};
        return {0.0, 0.29 - pushed_m, 0.0};
    }
};

struct Played {
    std::vector<std::string> failures;
    std::vector<crn::SteeringResult> steered;
    std::vector<crn::ExpectationResult> expected;
    std::string vessel;
};

Played play(const std::string &script, World world)
{
    const crn::Session session = crn::parse_session(script, "case");
    const crn::VesselMap map(tree());
    crn::SessionPlayer player(session, 1, &map);
    crn::TipPlace tip;
    for (std::uint32_t tick = 1; !player.is_done() && tick < 600000; tick++) {
        const crn_wire_hand hand = player.next().hands[0];
        const double pushed_m = hand.translation_counts * 1e-6 + 0.02;
        tip.is_known = true;
        tip.place = map.at(world.tip(pushed_m, hand.rotation_counts * 360.0 / 65536.0));
        tip.sheath = map.at({0.0, 0.29, 0.0});
        tip.vessel = map.vessels()[tip.place.vessel].name;
        tip.inside_m = map.inside_m(tip.place, tip.sheath);
        if (tick % crn::SessionPlayer::observe_every_ticks == 0)
            player.observe({{&pushed_m, 1}, {&tip, 1}, nullptr});
    }
    return {player.failures(), player.steered(), player.expected(), tip.vessel};
}

std::string error_of(const std::string &script)
{
    try {
        const crn::Session session = crn::parse_session(script, "case");
        const crn::VesselMap map(tree());
        crn::SessionPlayer player(session, 1, &map);
    } catch (const crn::FileError &error) {
        return error.what();
    }
    return "";
}

void an_aorta_is_three_vessels(void **)
{
    const crn::VesselMap map(tree());
    assert_string_equal(map.vessels()[map.at({0, 0.05, 0}).vessel].name.c_str(), "ascending aorta");
    assert_string_equal(map.vessels()[map.at({0, 0.10, 0}).vessel].name.c_str(), "aortic arch");
    assert_string_equal(map.vessels()[map.at({0, 0.20, 0}).vessel].name.c_str(), "descending aorta");
    assert_string_equal(map.vessels()[map.at({0.05, 0.12, 0}).vessel].name.c_str(), "left subclavian artery");
}

// The lengths in this test may differ by 1 um from the expected lengths because of rounding.
void inside_is_measured_from_where_the_tools_come_in(void **)
{
    const crn::VesselMap map(tree());
    const crn::VesselPlace sheath = map.at({0, 0.29, 0}), tip = map.at({0, 0.05, 0});
    assert_float_equal(tip.along_m, 0.05, 1e-6);
    assert_float_equal(map.inside_m(tip, sheath), 0.03, 1e-6);
    const crn::VesselWay way = map.way(map.at({0.05, 0.12, 0}), sheath, *map.find("ascending aorta"));
    assert_int_equal(way.ahead_um, 40000);
    assert_true(way.astray_um > 37000 &&
                way.astray_um <= 50000); // the branch's own blood begins in the aorta's wall
}

void names_are_found_however_they_are_written(void **)
{
    const crn::VesselMap map(tree());
    assert_true(map.find("Left_Subclavian artery").has_value());
    assert_true(map.find("left-subclavian").has_value());
    assert_false(map.find("left subclavia").has_value());
}

void an_unknown_vessel_is_refused_with_its_place_and_a_suggestion(void **)
{
    assert_string_equal(error_of("steer into ascending aorto\n").c_str(),
                        "case:1:12: unknown vessel 'ascending aorto', did you mean 'ascending aorta'?");
    assert_non_null(strstr(error_of("expect tip in spleen\n").c_str(), "known: ascending aorta"));
}

// The range of angles that lead into the vessel (window) is a twelfth or a third of all angles, and its
// position varies.
void a_tip_that_goes_astray_is_brought_back_and_tried_again(void **)
{
    for (const double window_deg : {15.0, 60.0})
        for (int i = 0; i < std::max(REFERENCE_RUN(18), 1); i++) {
            const double open_deg = 20.0 * i + 100.0 * (REFERENCE_RUN(18) < 18);
            const Played played =
                play("steer into ascending aorta until 20 mm within 600 s\nexpect tip in ascending aorta\n",
                     {open_deg, window_deg});
            if (!played.failures.empty())
                fail_msg("open at %g +- %g deg: %s", open_deg, window_deg, played.failures[0].c_str());
            assert_string_equal(played.vessel.c_str(), "ascending aorta");
        }
}

void a_goal_that_cannot_be_reached_is_an_error_with_line_place_and_remedy(void **)
{
    const Played played = play("wait 0.1 s\nsteer into ascending aorta within 60 s\nwait 1 s\n", {0.0, -1.0});
    assert_int_equal(played.failures.size(), 1);
    const std::string &failure = played.failures[0];
    assert_int_equal(failure.find("case:2: steer: the wire did not come 20 mm into ascending aorta"), 0);
    assert_true(failure.find("remedy:") != std::string::npos);
    assert_false(played.steered.at(0).is_reached);
}

void an_expectation_that_does_not_hold_is_named_with_what_was_found(void **)
{
    const Played played = play("expect tip in descending aorta at least 5 mm\nexpect tip in aortic arch\n"
                               "expect inserted at least 100 mm\n",
                               {0.0, 180.0});
    assert_int_equal(played.failures.size(), 2); // out of three at the same moment
    assert_int_equal(played.failures[0].find("case:2: expected tip wire in aortic arch, but the tip is"), 0);
    assert_int_equal(
        played.failures[1].find("case:3: expected inserted wire at least 100 mm, but it is 20 mm"), 0);
}

void an_expectation_of_medium_fails_when_none_was_injected(void **)
{
    const Played played = play("expect iodine in aortic arch at least 10 %\n", {0.0, 180.0});
    assert_int_equal(played.failures[0].find("case:1: expected iodine in aortic arch at least 10 %, but no "
                                             "medium was injected"),
                     0);
}

} // namespace

int main()
{
    const CMUnitTest tests[] = {
        cmocka_unit_test(an_aorta_is_three_vessels),
        cmocka_unit_test(inside_is_measured_from_where_the_tools_come_in),
        cmocka_unit_test(names_are_found_however_they_are_written),
        cmocka_unit_test(an_unknown_vessel_is_refused_with_its_place_and_a_suggestion),
        cmocka_unit_test(a_tip_that_goes_astray_is_brought_back_and_tried_again),
        cmocka_unit_test(a_goal_that_cannot_be_reached_is_an_error_with_line_place_and_remedy),
        cmocka_unit_test(an_expectation_that_does_not_hold_is_named_with_what_was_found),
        cmocka_unit_test(an_expectation_of_medium_fails_when_none_was_injected),
    };
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
