// These tests check the following. If blood flows freely past its tip, a catheter measures the aortic
// pressure. The catheter's pressure falls, and its pulse gets narrower, as the tip blocks the vessel. The
// pressure that remains behind a partial block agrees with Poiseuille's law for an annulus. The catheter's
// pressure does not depend on which pictures are made. After a tool was taken out of the catheter's lumen,
// the lumen may hold air until blood is aspirated.
#include "host/effects/flow_network.hpp"
#include "host/patient/patient.hpp"
#include <cmath>
#include <csetjmp>
#include <cstdarg>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <numbers>
extern "C" {
#include <cmocka.h>
}

using namespace crn;
using Eigen::Vector3d;

namespace
{

using std::numbers::pi;
constexpr double mmHg_Pa = 133.322;
constexpr double artery_radius_m = 1.5e-3, artery_flow_ml_s = 1.0;

constexpr double aorta_radius_m = 12e-3;

VesselBranch straight(const char *name, const Vector3d &from_m, const Vector3d &to_m, double radius_m,
                      double flow_ml_s)
{
    VesselBranch branch;
    branch.name = name;
    branch.flow_ml_s = flow_ml_s;
    for (int i = 0; i <= 100; ++i) {
        branch.points_m.push_back(from_m + (to_m - from_m) * (i / 100.0));
        branch.radii_m.push_back(radius_m);
    }
    return branch;
}

// Makes an aorta of 200 mm along y, and an artery that leaves the aorta's wall in the middle and is 100 mm
// long.
VesselTree artery()
{
    VesselBranch aorta = straight("aorta", {0, -0.1, 0}, {0, 0.1, 0}, aorta_radius_m, 60.0);
    VesselBranch artery =
        straight("artery", {0, 0, 0}, {aorta_radius_m + 0.1, 0, 0}, artery_radius_m, artery_flow_ml_s);
    artery.parent = 0;
    artery.parent_point = 50;
    return {{aorta, artery}};
}

Instrument guide()
{
    Instrument made;
    made.name = "guide";
    made.table.knots_count = 1;
    made.table.knots[0].radius_outer_um = 1000;
    made.table.knots[0].radius_inner_um = 900;
    return made;
}

// Makes a guiding catheter of the given radius that crosses the aorta and reaches `inside_m` into the artery.
WireFrame guide_at(std::uint32_t tick, double radius_m, double inside_m)
{
    WireFrame wire;
    wire.tick = tick;
    wire.tip_arc_m = {0.0};
    for (int i = 0; i <= 30; ++i) {
        WireNode node;
        node.arc_m = 1e-3 * i;
        node.position_m = {aorta_radius_m + inside_m - node.arc_m, 0.0, 0.0};
        node.radius_m = radius_m;
        wire.nodes.push_back(node);
    }
    return wire;
}

crn_wire_tick_state state_at(std::uint32_t tick, std::int32_t inserted_m_q30 = 1 << 28)
{
    crn_wire_tick_state state{};
    state.tick = tick;
    state.tools_count = 1;
    state.tools[0].inserted_m_q30 = inserted_m_q30;
    state.beat_ms = tick % 857;
    state.interval_ms = 857;
    return state;
}

// Returns an aortic pressure that rises and falls linearly between 80 and 120 mmHg (a triangular wave).
double aortic_mmHg(std::uint32_t tick)
{
    const double place = (tick % 857) / 857.0;
    return 80.0 + 80.0 * std::min(place, 1.0 - place);
}

void beats(CatheterPressure &pressure, double radius_m, std::uint32_t from, std::uint32_t to,
           std::uint32_t frame_ticks = 1000)
{
    for (std::uint32_t tick = from + 1; tick <= to; ++tick) {
        pressure.tick(aortic_mmHg(tick), state_at(tick));
        if (tick == pressure.next_tick() || tick % frame_ticks == 0)
            pressure.advance(guide_at(tick, radius_m, 0.02));
    }
}

CatheterPressure catheter()
{
    return CatheterPressure(artery(), {guide()}, nullptr, LesionOpening());
}

void beside_a_thin_catheter_the_pressure_is_that_of_the_aorta(void **)
{
    CatheterPressure pressure = catheter();
    beats(pressure, 0.3e-3, 0, 3 * 857);
    assert_true(pressure.is_measuring() && !pressure.is_damped());
    assert_true(pressure.share() > 0.99);
    // The triangular wave of the aortic pressure changes by at most 0.093 mmHg/ms, and the catheter lags by
    // less than 3 ms.
    assert_true(std::fabs(pressure.beat().systolic - 120.0) < 1.0);
    assert_true(std::fabs(pressure.beat().diastolic - 80.0) < 1.0);
}

void a_catheter_that_fills_the_artery_measures_the_collateral_pressure(void **)
{
    CatheterPressure pressure = catheter();
    beats(pressure, artery_radius_m, 0, 6 * 857);
    assert_true(pressure.is_damped());
    assert_true(std::fabs(pressure.share() - CatheterPressure::collateral_share) < 1e-12);
    // The expected mean is 6 + 0.18 (100 - 6) mmHg; after 5 s only exp(-5/0.3) of the initial difference is
    // left.
    assert_true(std::fabs(pressure.beat().mean - 22.92) < 0.2);
    assert_true(pressure.beat().pulse() < 0.18 * 40.0);
}

// A session's table of tools may have two guiding catheters with the same name. Directly after the catheter
// was replaced, the second catheter of that name has no position yet.
void another_guide_of_the_same_name_measures_anew(void **)
{
    CatheterPressure pressure = catheter();
    beats(pressure, artery_radius_m, 0, 6 * 857);
    pressure.set_tools({guide()}, 0); // another position was exchanged
    assert_true(pressure.is_measuring());
    pressure.set_tools({guide()}, 1);
    assert_false(pressure.is_measuring());
    assert_true(pressure.share() == 1.0);
}

// The removal of a guidewire from the guiding catheter may let air in; a new guiding catheter that replaces
// another has been flushed.
void another_guide_of_the_same_name_holds_no_air(void **)
{
    Instrument wire = guide();
    for (std::uint16_t i = 0; i < wire.table.knots_count; ++i) wire.table.knots[i].radius_inner_um = 0;
    const std::vector<Instrument> line = {wire, guide()};
    crn::CatheterAir air(line);
    crn_wire_tick_state state{};
    state.tools_count = 2;
    state.tools[0].inserted_m_q30 = state.tools[1].inserted_m_q30 = 1 << 28;
    air.tick(state);
    state.tools[0].inserted_m_q30 = 0;
    air.tick(state);
    assert_true(air.may_hold_air());
    air.set_tools(line, 1); // the wire was exchanged
    assert_true(air.may_hold_air());
    air.set_tools(line, 2);
    assert_false(air.may_hold_air());
}

// The reference value follows from Poiseuille's law for three resistances in series: the annulus around the
// guide in the artery, the rest of the artery, and the vascular bed.
void the_share_agrees_with_an_annulus_in_series_with_the_bed(void **)
{
    for (const double k : {0.6, 0.8, 0.9, 0.95}) {
        CatheterPressure pressure = catheter();
        beats(pressure, k * artery_radius_m, 0, 200);
        const double r4 = std::pow(artery_radius_m, 4);
        const double per_m = 8.0 * 3.5e-3 / (pi * r4) / mmHg_Pa * 1e-6; // mmHg s/ml per m
        const double annulus = 1.0 - std::pow(k, 4) - std::pow(1.0 - k * k, 2) / std::log(1.0 / k);
        const double before = per_m * 0.02 / annulus, behind = per_m * 0.08;
        // The bed takes its flow at the pressure that the artery leaves of the mean.
        const double bed = mean_pressure_mmHg / artery_flow_ml_s - per_m * 0.1;
        const double share = (behind + bed) / (before + behind + bed);
        const double wanted = 0.18 + 0.82 * share;
        // The artery is divided into cells of 1 mm, so the covered length of 20 mm is uncertain by one cell.
        assert_true(std::fabs(pressure.share() - wanted) < 0.06 * (1.0 - wanted) + 1e-3);
    }
}

void the_pressure_returns_when_the_catheter_is_withdrawn(void **)
{
    CatheterPressure pressure = catheter();
    beats(pressure, artery_radius_m, 0, 4 * 857);
    assert_true(pressure.is_damped());
    for (std::uint32_t tick = 4 * 857 + 1; tick <= 7 * 857; ++tick) {
        pressure.tick(aortic_mmHg(tick), state_at(tick));
        if (tick == pressure.next_tick()) pressure.advance(guide_at(tick, artery_radius_m, -0.005));
    }
    assert_true(!pressure.is_damped());
}

// The program must first compute the tick in which the tip enters the vessels; only then does it learn that
// the tools' shape must be read.
void the_first_look_comes_after_the_tick_in_which_the_tip_enters(void **)
{
    for (const std::uint32_t entered : {79u, 80u, 81u}) {
        CatheterPressure pressure = catheter();
        pressure.tick(100.0, state_at(entered - 1, 0));
        pressure.tick(100.0, state_at(entered));
        assert_int_equal(pressure.next_tick(), entered == 79 ? 80 : 160);
    }
}

void a_removed_catheter_measures_nothing(void **)
{
    CatheterPressure pressure = catheter();
    beats(pressure, artery_radius_m, 0, 4 * 857);
    pressure.tick(100.0, state_at(4 * 857 + 1, 0));
    assert_true(!pressure.is_measuring() && !pressure.is_damped());
    assert_true(pressure.next_tick() == UINT32_MAX);
    assert_true(pressure.pressure_mmHg() == 100.0);
}

void other_pictures_do_not_change_the_pressure(void **)
{
    CatheterPressure often = catheter(), seldom = catheter();
    beats(often, 0.9 * artery_radius_m, 0, 2000, 7);
    beats(seldom, 0.9 * artery_radius_m, 0, 2000, 5000);
    assert_true(often.pressure_mmHg() == seldom.pressure_mmHg());
    assert_true(often.damped_ticks() == seldom.damped_ticks());
}

void an_injection_while_the_pressure_is_damped_is_noted(void **)
{
    SceneAnatomy anatomy;
    anatomy.bodies.vessels = artery();
    Patient patient(anatomy, {guide()});
    const auto go_on = [&](std::uint32_t from, std::uint32_t to) {
        for (std::uint32_t tick = from + 1; tick <= to; ++tick) {
            patient.tick({}, state_at(tick));
            if (tick >= patient.next_look()) patient.look(guide_at(tick, artery_radius_m, 0.02));
        }
    };
    go_on(0, 500);
    patient.command(500, {RoomAction::inject, {100, 1000, 0}});
    assert_int_equal(patient.damped_injections().size(), 0); // no whole beat was measured yet
    go_on(500, 4 * 857);
    patient.command(4 * 857, {RoomAction::inject, {100, 1000, 0}});
    assert_int_equal(patient.damped_injections().size(), 1);
    assert_int_equal(patient.damped_injections()[0], 4 * 857);
}

// A guidewire lies in the guiding catheter until tick 100, and is then taken out.
void with_wire(Patient &patient, std::uint32_t from, std::uint32_t to, double guide_radius_m)
{
    for (std::uint32_t tick = from + 1; tick <= to; ++tick) {
        crn_wire_tick_state state = state_at(tick, tick <= 100 ? 1 << 28 : 0);
        state.tools_count = 2;
        state.tools[1].inserted_m_q30 = 1 << 28;
        patient.tick({}, state);
        WireFrame frame = guide_at(tick, guide_radius_m, 0.02);
        frame.tip_arc_m = {tick <= 100 ? 0.0 : 0.28, 0.0};
        if (tick >= patient.next_look()) patient.look(frame);
    }
}

std::vector<Instrument> wire_and_guide()
{
    Instrument wire;
    wire.name = "wire";
    wire.table.knots_count = 1;
    wire.table.knots[0].radius_outer_um = 178;
    return {wire, guide()};
}

void an_injection_after_a_wire_was_taken_out_needs_an_aspiration(void **)
{
    SceneAnatomy anatomy;
    anatomy.bodies.vessels = artery();
    Patient patient(anatomy, wire_and_guide());
    const RoomCommand inject{RoomAction::inject, {100, 1000, 0}},
        aspirate{RoomAction::aspirate, {1500, 0, 0}};
    with_wire(patient, 0, 50, 0.5e-3);
    patient.command(50, inject); // the guide was flushed before the session
    with_wire(patient, 50, 200, 0.5e-3);
    patient.command(200, inject);
    patient.command(200, aspirate);
    patient.command(200, inject); // 1.5 ml are less than the lumen holds
    patient.command(200, aspirate);
    patient.command(200, inject);
    const std::vector<std::uint32_t> wanted = {200, 200};
    assert_true(patient.catheter_air().injections() == wanted);
    assert_true(patient.refusals().empty());
}

void no_blood_comes_through_a_blocked_tip(void **)
{
    SceneAnatomy anatomy;
    anatomy.bodies.vessels = artery();
    Patient patient(anatomy, wire_and_guide());
    with_wire(patient, 0, 200, artery_radius_m);
    patient.command(200, {RoomAction::aspirate, {2000, 0, 0}});
    assert_int_equal(patient.refusals().size(), 1);
    assert_non_null(std::strstr(patient.refusals()[0].why.c_str(), "NO BLOOD"));
    assert_true(patient.catheter_air().may_hold_air());
}

} // namespace

int main()
{
    const CMUnitTest tests[] = {
        cmocka_unit_test(beside_a_thin_catheter_the_pressure_is_that_of_the_aorta),
        cmocka_unit_test(a_catheter_that_fills_the_artery_measures_the_collateral_pressure),
        cmocka_unit_test(another_guide_of_the_same_name_measures_anew),
        cmocka_unit_test(another_guide_of_the_same_name_holds_no_air),
        cmocka_unit_test(the_share_agrees_with_an_annulus_in_series_with_the_bed),
        cmocka_unit_test(the_pressure_returns_when_the_catheter_is_withdrawn),
        cmocka_unit_test(the_first_look_comes_after_the_tick_in_which_the_tip_enters),
        cmocka_unit_test(a_removed_catheter_measures_nothing),
        cmocka_unit_test(other_pictures_do_not_change_the_pressure),
        cmocka_unit_test(an_injection_while_the_pressure_is_damped_is_noted),
        cmocka_unit_test(an_injection_after_a_wire_was_taken_out_needs_an_aspiration),
        cmocka_unit_test(no_blood_comes_through_a_blocked_tip),
    };
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
