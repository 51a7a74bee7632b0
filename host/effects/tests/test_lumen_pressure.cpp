// These tests check the following. The pressure of an injection follows from the viscosity on the label: by
// Hagen-Poiseuille's law in an empty lumen, and by the law for an annulus beside a guidewire. An injection is
// refused if it would need more than 1200 psi with the tools that lie in the lumen at its tick; no part of it
// then enters the vessel.
#include "host/effects/lumen_pressure.hpp"
#include "host/model/units.hpp"
#include "host/patient/contrast.hpp"
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

namespace
{

using std::numbers::pi;
constexpr double kPa_per_psi = 6.894757;

Instrument tool(const char *name, double length_m, std::uint32_t outer_um, std::uint32_t inner_um)
{
    Instrument made;
    made.name = name;
    made.length_m = length_m;
    made.table.knots_count = 1;
    made.table.knots[0].radius_outer_um = outer_um;
    made.table.knots[0].radius_inner_um = inner_um;
    return made;
}

const Instrument wire_014 = tool("wire 0.014", 1.8, 178, 0);
const Instrument balloon_shaft = tool("balloon", 1.4, 450, 210);
const Instrument guide_6f = tool("guide", 1.0, 1040, 900);

void check_psi(double kPa, double expected_psi, double tolerance_psi)
{
    const double psi = kPa / kPa_per_psi;
    if (!(std::fabs(psi - expected_psi) <= tolerance_psi))
        fail_msg("%.2f psi, expected %.2f (allowed %.2f)", psi, expected_psi, tolerance_psi);
}

// At the strengths on the label the viscosity must be that of the label. Half-way between two strengths on
// the label, the viscosity must be the geometric mean of their viscosities.
void viscosity_is_the_labels(void **)
{
    for (const auto &[strength, mPa_s] : {std::pair{140.0, 1.5}, {240.0, 3.4}, {300.0, 6.3}, {350.0, 10.4}})
        assert_true(std::fabs(contrast_viscosity_mPa_s(strength) - mPa_s) < 1e-9);
    assert_true(std::fabs(contrast_viscosity_mPa_s(325.0) - std::sqrt(6.3 * 10.4)) < 1e-9);
    assert_true(contrast_viscosity_mPa_s(400.0) == contrast_viscosity_mPa_s(350.0));
}

// The pressure that a flow Q needs is 8 mu L Q / (pi R^4) (mu: viscosity, L: length and R: radius of the
// lumen): about 11,000 psi for 4 ml/s through a lumen of 0.42 mm diameter and 1.4 m length. The tolerance of
// this test allows for rounding only.
void an_empty_lumen_needs_hagen_and_poiseuilles_pressure(void **)
{
    const double expected_kPa = 8.0 * 10.4e-3 * 1.4 * 4e-6 / (pi * std::pow(0.21e-3, 4)) * 1e-3;
    const double found_kPa = injection_pressure_kPa(balloon_shaft, {}, 4.0, 350.0);
    assert_true(std::fabs(found_kPa / expected_kPa - 1.0) < 1e-9);
    check_psi(found_kPa, 11'000.0, 150.0);
}

// A 6F guiding catheter with a lumen of 1.8 mm needs 55 psi for 4 ml/s beside a concentric guidewire of 0.36
// mm. For any other position of the guidewire, the pressure is at least 1/2.5 of that with a concentric
// guidewire, and never below that of the empty catheter.
void a_wire_in_the_lumen_leaves_the_annulus(void **)
{
    const double k = 178.0 / 900.0, open = 1.0 - k * k;
    const double annulus = 1.0 - std::pow(k, 4) - open * open / std::log(1.0 / k);
    const double empty_kPa = injection_pressure_kPa(guide_6f, {}, 4.0, 350.0);
    check_psi(empty_kPa / annulus, 55.0, 2.0);
    const InnerTool wire[] = {{&wire_014, -0.05}};
    assert_true(std::fabs(injection_pressure_kPa(guide_6f, wire, 4.0, 350.0) / empty_kPa - 1.0) < 1e-9);
    const InnerTool shaft[] = {{&balloon_shaft, -0.05}};
    const double ks = 0.5, opens = 0.75, share = 1.0 - std::pow(ks, 4) - opens * opens / std::log(2.0);
    assert_true(std::fabs(injection_pressure_kPa(guide_6f, shaft, 4.0, 350.0) / (empty_kPa / (2.5 * share)) -
                          1.0) < 1e-9);
}

// A guidewire whose tip is in the middle of the lumen's length narrows only the half behind its tip. The
// integration of the pressure along the lumen uses steps of 1 mm, so it is exact for a lumen of 1 m.
void only_the_stretch_behind_its_tip_is_narrowed(void **)
{
    const InnerTool half[] = {{&balloon_shaft, 0.5}}, whole[] = {{&balloon_shaft, 0.0}};
    const double empty = injection_pressure_kPa(guide_6f, {}, 4.0, 350.0);
    const double expected = 0.5 * (empty + injection_pressure_kPa(guide_6f, whole, 4.0, 350.0));
    assert_true(std::fabs(injection_pressure_kPa(guide_6f, half, 4.0, 350.0) / expected - 1.0) < 1e-9);
    const Instrument thick = tool("thick", 1.0, 900, 0);
    const InnerTool plug[] = {{&thick, 0.2}};
    assert_true(std::isinf(injection_pressure_kPa(guide_6f, plug, 4.0, 350.0)));
}

VesselTree vessel()
{
    VesselBranch branch;
    branch.name = "artery";
    branch.flow_ml_s = 5.0;
    for (int i = 0; i <= 10; ++i) {
        branch.points_m.push_back({0.0, -0.01 * i, 0.0});
        branch.radii_m.push_back(0.003);
    }
    return {{branch}};
}

crn_wire_tick_state state_at(std::uint32_t tick, double wire_m, double catheter_m)
{
    crn_wire_tick_state state{};
    state.tick = tick;
    state.tools_count = 2;
    state.tools[0].inserted_m_q30 = units::metres_to_q30(wire_m);
    state.tools[1].inserted_m_q30 = units::metres_to_q30(catheter_m);
    return state;
}

// Through the balloon catheter's 0.42 mm lumen, an injection of 4 ml/s is refused whatever tool is in the
// lumen. The message gives the pressure that the injection would need.
void a_lumen_that_is_too_narrow_is_refused_before_the_session(void **)
{
    const RoomCommand inject{RoomAction::inject, {8000, 4000, 2}};
    const std::string why = injection_refusal({wire_014, balloon_shaft, guide_6f}, inject, 350.0);
    assert_non_null(std::strstr(why.c_str(), "4 ml/s THROUGH 'balloon' NEEDS 1"));
    assert_non_null(std::strstr(why.c_str(), "psi"));
    const RoomCommand by_guide{RoomAction::inject, {8000, 4000, 3}};
    assert_string_equal(injection_refusal({wire_014, balloon_shaft, guide_6f}, by_guide, 350.0).c_str(), "");
}

// An injection of 0.2 ml/s of 350 mg/ml needs 550 psi through the empty 0.42 mm lumen, and 60,000 psi or more
// beside the guidewire. Whether an injection is refused depends only on the inserted lengths of the tools at
// its tick; here the guidewire is pulled out one tick earlier.
void a_wire_in_the_lumen_decides_at_the_tick_of_the_injection(void **)
{
    const RoomCommand inject{RoomAction::inject, {1000, 200, 2}};
    for (bool is_out : {false, true}) {
        PatientContrast contrast(vessel(), {wire_014, balloon_shaft});
        for (std::uint32_t tick = 1; tick <= 9; ++tick) contrast.tick(state_at(tick, 0.4, 0.3));
        assert_string_equal(contrast.command(10, inject).c_str(), "");
        assert_true(contrast.refusals().empty());
        contrast.tick(state_at(10, is_out ? 0.0 : 0.4, 0.3));
        assert_int_equal(contrast.refusals().size(), is_out ? 0 : 1);
        WireFrame wire;
        wire.tip_arc_m = {0.0, 0.0};
        for (int i = 0; i <= 5; ++i) {
            WireNode node;
            node.arc_m = 0.01 * i;
            node.position_m = {0.0, -0.05 - 0.01 * i, 0.0};
            node.radius_m = 0.0005;
            wire.nodes.push_back(node);
        }
        for (std::uint32_t tick = 11; tick <= 1000; ++tick) contrast.tick(state_at(tick, 0.0, 0.3));
        for (wire.tick = 40; wire.tick <= 1000; wire.tick += 40) contrast.advance(wire);
        assert_true(contrast.was_used() == is_out);
        assert_true((contrast.injected_ml() > 0.15) == is_out);
        if (is_out) continue;
        assert_int_equal(contrast.refusals()[0].tick, 10);
        assert_non_null(std::strstr(contrast.refusals()[0].why.c_str(), "withdraw the inner device"));
    }
}

} // namespace

int main()
{
    const CMUnitTest tests[] = {
        cmocka_unit_test(viscosity_is_the_labels),
        cmocka_unit_test(an_empty_lumen_needs_hagen_and_poiseuilles_pressure),
        cmocka_unit_test(a_wire_in_the_lumen_leaves_the_annulus),
        cmocka_unit_test(only_the_stretch_behind_its_tip_is_narrowed),
        cmocka_unit_test(a_lumen_that_is_too_narrow_is_refused_before_the_session),
        cmocka_unit_test(a_wire_in_the_lumen_decides_at_the_tick_of_the_injection),
    };
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
