// These tests check what injures the vessels of a patient: a tip that pushes the wall in front of it with a
// force just above what the wall bears, and a balloon whose free diameter is just above the limit, but none
// just below. The push of a tip is its force along the tip; a tip that slides along a wall does not count. An
// injury bleeds, and pictures between the looks change nothing. A snapshot goes on with the same injuries.
#include "host/model/units.hpp"
#include "host/patient/patient.hpp"
#include <cmath>
#include <csetjmp>
#include <cstdarg>
#include <cstddef>
#include <cstdint>
#include <numbers>
extern "C" {
#include <cmocka.h>
}

using namespace crn;
using Eigen::Vector3d;

namespace
{

constexpr double lad_radius_m = 1.5e-3, wire_radius_um = 180.0;
constexpr double wire_area_mm2 = std::numbers::pi * 0.18 * 0.18;

// An artery of 100 mm along x, with the flow of a coronary artery.
SceneAnatomy lad_anatomy()
{
    VesselBranch branch;
    branch.name = "LAD";
    branch.bed = VesselBed::left_coronary;
    branch.flow_ml_s = 1.0;
    for (int i = 0; i <= 100; ++i) {
        branch.points_m.push_back({1e-3 * i, 0.0, 0.0});
        branch.radii_m.push_back(lad_radius_m);
    }
    SceneAnatomy anatomy;
    anatomy.bodies.vessels = {{branch}};
    return anatomy;
}

Instrument thin_wire()
{
    Instrument made;
    made.name = "thin wire";
    made.table.knots_count = 1;
    made.table.knots[0].radius_outer_um = static_cast<std::uint32_t>(wire_radius_um);
    return made;
}

// A balloon of 3 mm at 8 bar, and 0.1 mm more per bar.
Instrument lad_balloon()
{
    Instrument made = thin_wire();
    made.name = "balloon";
    made.table.knots[0].radius_outer_um = 500;
    made.table.knots[0].radius_inner_um = 200;
    made.table.balloon_distal_um = 2'000;
    made.table.balloon_proximal_um = 12'000;
    made.table.balloon_burst_kPa = 4000;
    made.table.balloon_count = 2;
    made.table.balloon[0] = {800, 3000};
    made.table.balloon[1] = {1800, 4000};
    return made;
}

constexpr double tip_x_m = 50e-3;

// The line along x with its tip at tip_x_m, in an artery that it fills with the balls of a balloon if
// `ball_radius_m` is not 0.
WireFrame pushing_line(std::uint32_t tick, double ball_radius_m = 0.0)
{
    WireFrame wire;
    wire.tick = tick;
    wire.tip_arc_m = {0.0};
    for (int i = 0; i <= 40; ++i) {
        WireNode node;
        node.arc_m = 1e-3 * i;
        node.position_m = {tip_x_m - node.arc_m, 0.0, 0.0};
        node.radius_m = 0.5e-3;
        wire.nodes.push_back(node);
    }
    if (ball_radius_m > 0.0) {
        wire.balloon_radii_m.assign(11, ball_radius_m);
        wire.balloon_arc_m = 2e-3;
        wire.balloon_spacing_m = 1e-3;
    }
    return wire;
}

crn_wire_contacts push_at(std::uint32_t tick, const Vector3d &force_N)
{
    crn_wire_contacts contacts{};
    contacts.tick = tick;
    contacts.contacts_count = 1;
    const auto q22 = [](double newton) { return static_cast<std::int32_t>(std::lround(newton * (1 << 22))); };
    contacts.contacts[0] = {0, q22(force_N.x()), q22(force_N.y()), q22(force_N.z())};
    return contacts;
}

crn_wire_tick_state lad_state(std::uint32_t tick, double balloon_bar)
{
    crn_wire_tick_state state{};
    state.tick = tick;
    state.tools_count = 1;
    state.tools[0].inserted_m_q30 = 1 << 26;
    state.beat_ms = tick % 857;
    state.interval_ms = 857;
    state.balloon_kPa = static_cast<std::uint16_t>(balloon_bar * 100.0);
    return state;
}

// Carries out a session of so many ticks: the wall pushes the tip back with `force_N`, as the core reports it
// every 16 ticks, and the balloon has the pressure and fills the artery. More frames are shown every
// `frame_ticks`.
void play_push(Patient &patient, std::uint32_t from, std::uint32_t to, const Vector3d &force_N,
               double balloon_bar = 0.0, std::uint32_t frame_ticks = 100'000)
{
    const double ball_m = balloon_bar > 0.0 ? lad_radius_m : 0.0;
    for (std::uint32_t tick = from + 1; tick <= to; ++tick) {
        patient.tick({}, lad_state(tick, balloon_bar));
        const std::uint32_t next = patient.next_vessel_look();
        if (tick % Patient::feel_every_ticks == 0 && patient.can_be_injured() &&
            patient.feel(push_at(tick, force_N)))
            patient.locate(pushing_line(tick, ball_m));
        if (tick == next || tick == patient.next_vessel_look() || tick % frame_ticks == 0)
            patient.look_at_vessels(pushing_line(tick, ball_m));
    }
}

Vector3d back_with(double share_of_limit, double limit_kPa)
{
    return {-share_of_limit * limit_kPa * 1e-3 * wire_area_mm2, 0.0, 0.0};
}

std::size_t holes(const Patient &patient)
{
    return patient.complications().count(InjuryKind::perforation);
}

std::size_t flaps(const Patient &patient)
{
    return patient.complications().count(InjuryKind::dissection);
}

void a_push_just_above_what_the_wall_bears_perforates_it_and_none_just_below(void **)
{
    for (const double share : {0.999, 1.001}) {
        Patient patient(lad_anatomy(), {thin_wire()});
        play_push(patient, 0, 1000, back_with(share, 1430.0));
        assert_int_equal(holes(patient), share > 1.0 ? 1 : 0);
        assert_int_equal(flaps(patient), 1); // the inner layers bear less
        if (share < 1.0) continue;
        const Injury &injury = patient.complications().injuries().back();
        assert_string_equal(injury.vessel.c_str(), "LAD");
        assert_string_equal(injury.tool.c_str(), "thin wire");
        assert_int_equal(injury.tick, 16 + 96);
        assert_true(std::fabs(injury.value / 1430.0 - 1.001) < 1e-4 && injury.limit == 1430.0);
        assert_true(std::fabs(injury.force_N - 1.001 * 1.430 * wire_area_mm2) < 1e-5);
        assert_true((injury.place_m - Vector3d(tip_x_m, 0.0, 0.0)).norm() < 1e-9);
        assert_string_equal(injury_class(injury, {}).c_str(), "II");
        assert_true(patient.notice().text.find("PERFORATION") == 0);
    }
}

void a_push_just_above_what_the_inner_layers_bear_dissects(void **)
{
    for (const double share : {0.999, 1.001}) {
        Patient patient(lad_anatomy(), {thin_wire()});
        play_push(patient, 0, 1000, back_with(share, 477.0));
        assert_int_equal(flaps(patient), share > 1.0 ? 1 : 0);
        assert_int_equal(holes(patient), 0);
    }
}

void a_short_push_and_a_tip_that_slides_along_the_wall_injure_nothing(void **)
{
    Patient patient(lad_anatomy(), {thin_wire()});
    play_push(patient, 0, 96, back_with(3.0, 1430.0)); // from tick 16 to tick 96
    play_push(patient, 96, 200, Vector3d::Zero());
    play_push(patient, 200, 1000, {0.0, 3.0 * 1.430 * wire_area_mm2, 0.0}); // across the tip
    play_push(patient, 1000, 2000, -back_with(3.0, 1430.0));                // the wall pulls it ahead
    assert_true(patient.complications().injuries().empty());
}

void the_same_push_again_is_the_same_injury(void **)
{
    Patient patient(lad_anatomy(), {thin_wire()});
    for (std::uint32_t i = 0; i < 5; ++i) {
        play_push(patient, 1000 * i, 1000 * i + 500, back_with(1.1 + 0.1 * i, 1430.0));
        play_push(patient, 1000 * i + 500, 1000 * i + 1000, Vector3d::Zero());
    }
    assert_int_equal(holes(patient), 1);
    assert_true(std::fabs(patient.complications().injuries().back().value / 1430.0 - 1.5) < 1e-3);
}

// The table gives 3 mm at 8 bar and 0.1 mm more per bar; the artery has 3 mm.
void a_balloon_just_above_the_limit_perforates_and_none_just_below(void **)
{
    for (const double bar : {16.9, 17.1}) {
        Patient patient(lad_anatomy(), {lad_balloon()});
        play_push(patient, 0, 2000, Vector3d::Zero(), bar);
        assert_int_equal(holes(patient), bar > 17.0 ? 1 : 0);
        assert_int_equal(flaps(patient), 1);
        const Injury &tear = patient.complications().injuries().front();
        assert_true(tear.cause == InjuryCause::balloon && std::fabs(tear.size_mm - 10.0) < 3.0);
    }
    Patient patient(lad_anatomy(), {lad_balloon()});
    play_push(patient, 0, 2000, Vector3d::Zero(), 13.9); // a ratio of 1.197
    assert_true(patient.complications().injuries().empty());
}

void a_balloon_that_does_not_touch_the_wall_injures_nothing(void **)
{
    Patient patient(lad_anatomy(), {lad_balloon()});
    for (std::uint32_t tick = 1; tick <= 2000; ++tick) {
        patient.tick({}, lad_state(tick, 20.0));
        if (tick == patient.next_vessel_look())
            patient.look_at_vessels(pushing_line(tick, 0.5 * lad_radius_m));
    }
    assert_true(patient.complications().injuries().empty());
}

// The hole of the wire bleeds with its conductance times the pressure, from the next look on.
void a_perforation_bleeds_without_medium_and_after_the_tip_has_gone(void **)
{
    Patient patient(lad_anatomy(), {thin_wire()});
    play_push(patient, 0, 160, back_with(1.1, 1430.0));
    play_push(patient, 160, 20'160, Vector3d::Zero());
    const double g = hole_ml_s_per_mmHg({}, 2e-3 * wire_radius_um);
    const double lost_ml = patient.contrast().flow().wounds().leaked_ml();
    // From the look at tick 120 to the last one; the artery loses less than 2 % of the pressure. A coronary
    // artery's pressure swings with the beat about its mean.
    const double wanted_ml = g * mean_pressure_mmHg * 20.0;
    if (std::fabs(lost_ml / wanted_ml - 1.0) > 0.1)
        fail_msg("lost %.4f ml, expected %.4f", lost_ml, wanted_ml);
    assert_true(patient.complications().lost_around_heart_ml(patient.contrast().flow()) == lost_ml);
}

void more_pictures_change_nothing(void **)
{
    double lost_ml[2] = {};
    for (const bool has_pictures : {false, true}) {
        Patient patient(lad_anatomy(), {thin_wire()});
        const std::uint32_t frames = has_pictures ? 7 : 100'000;
        play_push(patient, 0, 500, back_with(1.1, 1430.0), 0.0, frames);
        play_push(patient, 500, 4000, Vector3d::Zero(), 0.0, frames);
        play_push(patient, 4000, 4000, Vector3d::Zero());
        patient.look_at_vessels(pushing_line(4000));
        lost_ml[has_pictures] = patient.contrast().flow().wounds().leaked_ml();
    }
    assert_true(lost_ml[0] > 0.0 && lost_ml[0] == lost_ml[1]);
}

// Blood around the heart presses on it: the arterial pressure falls, and with it the bleeding.
void a_large_loss_lets_the_pressure_fall(void **)
{
    Patient patient(lad_anatomy(), {thin_wire()});
    patient.command(0, {RoomAction::complication_limit, {19, 1, 0}});     // tamponade_begins_ml = 0.001
    patient.command(0, {RoomAction::complication_limit, {20, 1'000, 0}}); // tamponade_full_ml = 1
    play_push(patient, 0, 200, back_with(1.1, 1430.0));
    play_push(patient, 200, 30'000, Vector3d::Zero());
    assert_true(patient.contrast().flow().wounds().leaked_ml() > 1.0);
    assert_true(std::fabs(patient.contrast().pressure_share() - 0.4) < 1e-12);
    assert_true(patient.catheter_pressure().pressure_mmHg() < 60.0);
}

void where_complications_are_off_nothing_is_injured(void **)
{
    Patient patient(lad_anatomy(), {thin_wire()});
    patient.command(0, {RoomAction::complications, {0, 0, 0}});
    play_push(patient, 0, 1000, back_with(3.0, 1430.0));
    assert_true(patient.complications().injuries().empty());
    assert_false(patient.can_be_injured());
}

void a_snapshot_goes_on_with_the_same_injuries(void **)
{
    Patient patient(lad_anatomy(), {thin_wire()}), other(lad_anatomy(), {thin_wire()});
    play_push(patient, 0, 200, back_with(1.1, 1430.0));
    std::vector<std::uint8_t> bytes;
    StateArchive saving = StateArchive::saving(bytes);
    patient.archive(saving, 200, lad_state(200, 0.0));
    StateArchive restoring = StateArchive::restoring(bytes);
    other.archive(restoring, 200, lad_state(200, 0.0));
    assert_false(restoring.is_refused());
    for (Patient *one : {&patient, &other}) play_push(*one, 200, 3000, back_with(1.2, 1430.0));
    assert_int_equal(holes(other), 1);
    assert_true(patient.contrast().flow().wounds().leaked_ml() ==
                other.contrast().flow().wounds().leaked_ml());
    assert_true(patient.contrast().flow().wounds().leaked_ml() > 0.0);
}

// Only a tip outside all other tools pushes the wall.
void a_tip_inside_another_tool_pushes_no_wall(void **)
{
    WireFrame wire = pushing_line(16);
    wire.tip_arc_m = {0.0, 0.0};
    const crn_wire_contacts contacts = push_at(16, {-1.0, 0.0, 0.0});
    assert_false(tip_push(wire, contacts, 0).is_known);
    assert_true(std::fabs(tip_push(wire, contacts, 1).force_N - 1.0) < 1e-6);
    wire.tip_arc_m = {0.0, 10e-3};
    assert_true(std::fabs(tip_push(wire, contacts, 0).force_N - 1.0) < 1e-6);
    assert_true(tip_push(wire, contacts, 1).force_N == 0.0); // the contact is before its tip
}

// The tip of a J wire turns back within 6 mm; its bow leads, which is blunt.
void the_tip_of_a_j_wire_does_not_lead(void **)
{
    for (const double degrees : {0.0, 45.0, 75.0, 180.0}) {
        WireFrame wire = pushing_line(16);
        const double turn = degrees * std::numbers::pi / 180.0;
        const Vector3d ahead(std::cos(turn), std::sin(turn), 0.0);
        for (int i = 3; i >= 0; --i) // the last 3 mm are bent by so much
            wire.nodes[static_cast<std::size_t>(i)].position_m =
                wire.nodes[static_cast<std::size_t>(i) + 1].position_m + 1e-3 * ahead;
        const crn_wire_contacts contacts = push_at(16, -ahead);
        const double wanted_N = degrees < 60.0 ? 1.0 : 0.0;
        assert_true(std::fabs(tip_push(wire, contacts, 0).force_N - wanted_N) < 1e-6);
    }
}

void a_tip_pushes_with_its_whole_end(void **)
{
    Instrument guide = thin_wire();
    guide.table.knots[0].radius_outer_um = 1000;
    guide.table.knots[0].radius_inner_um = 900;
    assert_true(std::fabs(tip_area_mm2(guide) - std::numbers::pi) < 1e-12);
    assert_true(std::fabs(tip_area_mm2(thin_wire()) - wire_area_mm2) < 1e-12);
}

void the_free_diameter_follows_the_makers_table(void **)
{
    const crn_wire_instrument table = lad_balloon().table;
    assert_true(free_balloon_mm(table, 40.0) == 0.0);
    assert_true(std::fabs(free_balloon_mm(table, 800.0) - 3.0) < 1e-12);
    assert_true(std::fabs(free_balloon_mm(table, 1300.0) - 3.5) < 1e-12);
    assert_true(std::fabs(free_balloon_mm(table, 2000.0) - 4.2) < 1e-12);
}

} // namespace

int main()
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_push_just_above_what_the_wall_bears_perforates_it_and_none_just_below),
        cmocka_unit_test(a_push_just_above_what_the_inner_layers_bear_dissects),
        cmocka_unit_test(a_short_push_and_a_tip_that_slides_along_the_wall_injure_nothing),
        cmocka_unit_test(the_same_push_again_is_the_same_injury),
        cmocka_unit_test(a_balloon_just_above_the_limit_perforates_and_none_just_below),
        cmocka_unit_test(a_balloon_that_does_not_touch_the_wall_injures_nothing),
        cmocka_unit_test(a_perforation_bleeds_without_medium_and_after_the_tip_has_gone),
        cmocka_unit_test(more_pictures_change_nothing),
        cmocka_unit_test(a_large_loss_lets_the_pressure_fall),
        cmocka_unit_test(where_complications_are_off_nothing_is_injured),
        cmocka_unit_test(a_snapshot_goes_on_with_the_same_injuries),
        cmocka_unit_test(a_tip_inside_another_tool_pushes_no_wall),
        cmocka_unit_test(the_tip_of_a_j_wire_does_not_lead),
        cmocka_unit_test(a_tip_pushes_with_its_whole_end),
        cmocka_unit_test(the_free_diameter_follows_the_makers_table),
    };
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
