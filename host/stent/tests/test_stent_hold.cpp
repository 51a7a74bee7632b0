// These tests check the following. For a minute, a stent in a beating artery stays at the part of the wall on
// which it was deployed. The struts lie on the wall and do not pass through it, at 15 and at 60 pictures per
// second. A stent that is too small for its vessel does not stay where it was deployed. A lesion that a
// balloon has opened gets the shape that the tree of vessels gives for the healthy vessel. The artery moves
// 12 mm to and fro, turns and bends; its length and width change as much as those of the arteries in the
// shipped heart.
#include "firmware/tests/reference/long_run.h"
#include "host/stent/stents.hpp"
#include "host/stent/tests/stent_heart.hpp"
#include "host/stent/tests/stent_vessel.hpp"
#include <csetjmp>
#include <cstdarg>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <numbers>
extern "C" {
#include <cmocka.h>
}

using namespace crn;
using Eigen::Vector3d;

namespace
{

using std::numbers::pi;

struct Minute {
    double off_mm = 0.0, deepest_mm = 0.0, apposed_share = 1.0;
    StentStage stage = StentStage::on_balloon;
    StentFigures last;
};

// Inflates the balloon in one second to the fraction `share` of the artery's radius, keeps it inflated for
// two seconds, deflates it in one second, and observes the stent until `seconds`.
Minute minute(double share, double pictures_per_s, double beats_per_min, double seconds)
{
    const BeatingLattice heart;
    VesselWall vessel(beating_artery(true), 0, 5, 45, &*heart.motion);
    Stent stent(read_stent("shared/examples/stents/coronary_3_0x18.toml"), artery_middle_mm);
    const std::vector<std::vector<double>> opened = {{1.0}};
    std::vector<WallFoot> held;
    Minute result;
    for (int i = 0; i < (6 + REFERENCE_RUN(seconds)) * pictures_per_s; ++i) {
        const double time_s = i / pictures_per_s, phase = std::fmod(time_s * beats_per_min / 60, 1.0);
        vessel.move({static_cast<std::uint32_t>(phase * 0x1p32), 0}, opened);
        const double up = std::clamp(std::min(time_s, 4.0 - time_s), 0.0, 1.0);
        BalloonPose pose;
        for (std::size_t k = 0; k < vessel.line_mm().size(); ++k)
            if (std::abs(vessel.along_mm(k) - artery_middle_mm) <= 10)
                pose.points.push_back({vessel.along_mm(k), vessel.line_mm()[k],
                                       0.4 + up * (share * vessel.radius_mm()[k] - 0.4)});
        stent.step({&vessel.wall(), time_s < 5 ? &pose : nullptr});
        if (time_s < 5) continue;
        if (held.empty())
            for (const StentPoint &point : stent.points())
                held.push_back(vessel.wall().walk(point.place_mm, point.foot.triangle));
        for (std::size_t k = 0; k < held.size(); ++k)
            if (held[k].is_known())
                result.off_mm = std::max(result.off_mm,
                                         (vessel.wall().place(held[k]) - stent.points()[k].place_mm).norm());
        if (i % 37 == 0)
            result.deepest_mm = std::max(result.deepest_mm, deepest_strut_mm(stent, vessel.wall()));
        if (i % 7 != 0) continue;
        result.last = stent_figures(stent, &vessel.wall());
        result.apposed_share = std::min(result.apposed_share, result.last.apposed_share);
    }
    result.stage = stent.stage();
    std::printf("# %.2f of the radius, %g pictures/s, %g /min: off %.3f mm, deepest %.4f mm, apposed %.3f\n",
                share, pictures_per_s, beats_per_min, result.off_mm, result.deepest_mm, result.apposed_share);
    return result;
}

} // namespace

static void stent_of_the_right_size_is_carried_by_the_wall_for_a_minute(void **)
{
    const struct {
        double share, pictures_per_s, beats_per_min, seconds;
    } cases[] = {{1.0, 15, 70, 60}, {1.0, 60, 70, 2}, {1.0, 15, 140, 6}, {1.05, 15, 70, 6}};
    for (const auto &one : std::span(cases).first(1 + REFERENCE_RUN(30) / 10)) {
        const Minute result = minute(one.share, one.pictures_per_s, one.beats_per_min, one.seconds);
        assert_int_equal(result.stage, StentStage::deployed);
        assert_true(result.off_mm <= 0.3);
        assert_true(result.deepest_mm <= 0.05);
        assert_true(result.apposed_share >= 0.95);
    }
}

static void stent_a_size_too_small_is_not_apposed_while_it_beats(void **)
{
    const Minute result = minute(0.83, 15, 70, 6);
    assert_true(result.apposed_share < 0.8);
    assert_true(result.deepest_mm <= 0.05);
    // The stent must move with the artery and be neither flattened nor torn.
    assert_true(result.last.diameter_min_mm > 2.0 && std::abs(result.last.length_mm - 17.9) < 1.5);
}

// The middles of the tube's facets lie on the circle of radius r, so every vertex must be at r / cos(pi/24)
// from the centreline. The expected centreline and radius come from the tree of vessels; the test checks
// every 23rd triangle.
static void tube_is_that_of_the_tree_narrowed_and_opened(void **)
{
    const VesselTree tree = beating_artery(true);
    VesselWall vessel(tree, 0, 5, 45, nullptr);
    for (double opened : {0.0, 0.5, 1.0}) {
        const std::vector<std::vector<double>> all = {{opened}};
        vessel.move({}, all);
        double least = 10, most = 0;
        for (std::size_t i = 0; i < vessel.wall().triangle_count(); i += 23)
            for (std::size_t k = 0; k < 3; ++k) {
                const Vector3d &corner = vessel.wall().corner_mm(i, k);
                double distance = 1e9;
                std::size_t row = 0;
                for (std::size_t j = 0; j < vessel.line_mm().size(); ++j)
                    if ((vessel.line_mm()[j] - corner).norm() < distance) {
                        distance = (vessel.line_mm()[j] - corner).norm();
                        row = j;
                    }
                const double share = distance * std::cos(pi / 24) / vessel.radius_mm()[row];
                least = std::min(least, share);
                most = std::max(most, share);
            }
        std::printf("# opened %.1f: vertices at %.4f to %.4f of the radius\n", opened, least, most);
        assert_true(least > 0.95 &&
                    most < 1.05); // in a taper the nearest middle is not that of the vertex itself
        const double throat = *std::min_element(vessel.radius_mm().begin(), vessel.radius_mm().end());
        const double wanted = 1.5 - 0.75 * 1.5 * (1 - opened);
        assert_true(opened == 1.0 ? throat >= 1.4 : std::abs(throat - wanted) < 0.01);
    }
}

// In this test the lesion is open at one end only. The stations (points) of the lesion are evenly spaced from
// its beginning to its end, as in the core.
static void lesion_opens_station_by_station(void **)
{
    VesselWall vessel(beating_artery(true), 0, 5, 45, nullptr);
    const std::vector<std::vector<double>> opened = {{1.0, 1.0, 1.0, 0.0, 0.0}};
    vessel.move({}, opened);
    const VesselWall::Stretch stretch = vessel.lesion_mm(0);
    for (std::size_t row = 0; row < vessel.line_mm().size(); ++row) {
        const double at = vessel.along_mm(row), radius = vessel.radius_mm()[row];
        const double share = (at - stretch.from_mm) / (stretch.to_mm - stretch.from_mm);
        if (share <= 0.5) assert_true(std::abs(radius - vessel.healthy_radius_mm(at)) < 1e-9);
        if (share >= 0.75) assert_true(std::abs(radius - vessel.narrow_radius_mm(at)) < 1e-9);
    }
    assert_true(std::abs(stretch.to_mm - stretch.from_mm - 12) < 0.6 && vessel.lesion_mm(1).is_empty());
}

// In this test two stents are deployed one after the other. The second stent lies in one end of the first
// stent and covers half of the lesion. After placing both stents, the test compares the commands to the core
// that result from them.
struct Two {
    VesselWall vessel{beating_artery(true), 0, 5, 45, nullptr};
    Stents stents;
    StentDesign design = read_stent("shared/examples/stents/coronary_3_0x18.toml");
    void picture(double at_mm, double up)
    {
        BalloonPose pose;
        for (std::size_t k = 0; k < vessel.line_mm().size(); ++k)
            if (std::abs(vessel.along_mm(k) - at_mm) <= 10)
                pose.points.push_back({vessel.along_mm(k), vessel.line_mm()[k],
                                       0.4 + up * (vessel.healthy_radius_mm()[k] - 0.4)});
        stents.step(&vessel.wall(), &pose);
    }
    void deploy(double at_mm)
    {
        const std::vector<std::vector<double>> opened = {{1.0}};
        vessel.move({}, opened);
        stents.add(design, at_mm);
        for (int i = 0; i <= 16; ++i) picture(at_mm, 1 - std::abs(i - 8) / 8.0);
    }
};

static void stents_tell_the_core_what_they_hold_open(void **)
{
    Two two;
    assert_true(two.stents.holds(two.vessel, 0, 13).empty());
    two.stents.add(two.design, 30); // taken out again without being opened
    two.picture(30, 0.0);
    two.deploy(16.0); // 7 to 25 mm: half of the lesion of 19 to 31 mm
    assert_int_equal(two.stents.size(), 1);
    const std::vector<StentHold> half = two.stents.holds(two.vessel, 0, 13);
    assert_false(half.empty());
    assert_int_equal(half.front().first, 0);
    std::printf("# held to station %u of 12\n", half.back().last);
    assert_true(half.back().last >= 5 && half.back().last <= 6); // 1 mm apart
    two.deploy(31.0);                                            // 22 to 40 mm
    assert_int_equal(two.stents.size(), 2);
    const std::vector<StentHold> whole = two.stents.holds(two.vessel, 0, 13);
    assert_int_equal(whole.back().last, 12);
    // Where the plaque is thick, the recoil of 3 % has little effect; at the minimal lumen diameter, at least
    // nine tenths of the opening must remain.
    for (const StentHold &hold : whole)
        if (hold.first <= 6 && hold.last >= 6) assert_true(hold.open_256 > 230 && hold.open_256 <= 256);
    assert_true(stent_overlap_mm(two.stents[1], two.stents[0].sleeve()) > 1.5);
    // A copy of the stents that is restored from a snapshot must behave in the same way as the original.
    Two other;
    other.deploy(16.0);
    other.deploy(31.0);
    other.picture(31, 0.3);
    assert_true(other.stents.snapshot() != two.stents.snapshot());
    assert_true(other.stents.restore(two.stents.snapshot()));
    for (Two *one : {&two, &other}) one->picture(31, 1.02);
    assert_true(other.stents.snapshot() == two.stents.snapshot());
    assert_false(Two().stents.restore(two.stents.snapshot()));
}

// In this test a renal artery of 3 mm radius leaves an aorta of 9 mm radius. The tube must begin where the
// branch leaves the aorta's lumen, so that the part of a stent in the aorta touches no wall.
static void wall_of_a_branch_begins_at_its_ostium(void **)
{
    VesselBranch aorta, renal;
    aorta.name = "aorta";
    renal.name = "left_renal_artery";
    renal.parent = 0;
    renal.parent_point = 20;
    for (int i = 0; i <= 40; ++i) {
        aorta.points_m.emplace_back(0, 0.08 - 0.004 * i, 0);
        aorta.radii_m.push_back(0.009);
        renal.points_m.emplace_back(0.001 * i, 0, 0);
        renal.radii_m.push_back(0.003);
    }
    VesselWall vessel({{aorta, renal}}, 1, 0, 40, nullptr);
    assert_true(std::abs(vessel.along_mm(0) - 9) < 0.6);
    Stent stent(read_stent("shared/examples/stents/renal_6_0x18.toml"), 16.0); // 7 to 25 mm
    for (int i = 0; i <= 16; ++i) {
        BalloonPose pose;
        for (int k = 0; k <= 22; ++k)
            pose.points.push_back(
                {5.0 + k, Vector3d(5.0 + k, 0, 0), 0.8 + 2.2 * (1 - std::abs(i - 8) / 8.0)});
        stent.step({&vessel.wall(), &pose});
    }
    const StentFigures figures = stent_figures(stent, &vessel.wall());
    std::printf("# apposed %.3f, %zu struts out of %zu not\n", figures.apposed_share, figures.gaps.size(),
                stent.lattice().struts.size());
    assert_int_equal(stent.stage(), StentStage::deployed);
    assert_true(figures.apposed_share > 0.8 && figures.apposed_share < 0.97);
    for (const StentGap &gap : figures.gaps) assert_true(gap.place_mm.x() < 9.3);
}

static void stretch_that_a_branch_has_not_is_refused(void **)
{
    for (const auto &[branch, from, to] : {std::tuple{1u, 5.0, 45.0}, {0u, 60.0, 70.0}, {0u, 20.0, 20.2}}) {
        bool is_refused = false;
        try {
            VesselWall(beating_artery(false), branch, from, to, nullptr);
        } catch (const std::invalid_argument &) {
            is_refused = true;
        }
        assert_true(is_refused);
    }
}

int main(void)
{
    const CMUnitTest tests[] = {
        cmocka_unit_test(stent_of_the_right_size_is_carried_by_the_wall_for_a_minute),
        cmocka_unit_test(stent_a_size_too_small_is_not_apposed_while_it_beats),
        cmocka_unit_test(tube_is_that_of_the_tree_narrowed_and_opened),
        cmocka_unit_test(lesion_opens_station_by_station),
        cmocka_unit_test(stents_tell_the_core_what_they_hold_open),
        cmocka_unit_test(wall_of_a_branch_begins_at_its_ostium),
        cmocka_unit_test(stretch_that_a_branch_has_not_is_refused),
    };
    cmocka_set_message_output(CM_OUTPUT_TAP);
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
