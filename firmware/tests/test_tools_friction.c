/* These tests check the friction between nested tools that a load on the tip causes (docs/rod.md, "Between
 * tools"). A wire lies in a guide whose end is bent by 180 degrees, without a vessel and without gravity. The
 * pull that a lip and a bend without friction pass on is the load, whatever its direction; friction belongs
 * to the tools that touch each other, and putting a further tool on the line changes no force. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "firmware/tests/reference/rod_rig.h"

static const double Q30 = 1073741824.0, Q22 = 4194304.0, pi = 3.14159265358979;

enum { WIRE, CATHETER, GUIDE, TOOLS };
enum { LENGTH_um = 400000, REST_ticks = 4000, ELEMENT_um = 3000 };

static crn_instrument straight_tool(double bend_N_m2, uint32_t radius_um, uint32_t bore_um, double friction)
{
    crn_instrument tool = {.knot_count = 2,
                           .lumen_friction_milli = (uint32_t)lround(1000 * friction),
                           .axial_stiffness_max_N = 3000,
                           .element_tip_um = ELEMENT_um,
                           .element_shaft_um = ELEMENT_um};
    for (int i = 0; i < 2; i++)
        tool.knots[i] = (crn_knot){.arc_um = i == 0 ? 0 : LENGTH_um,
                                   .bend_stiffness_nN_m2 = (uint32_t)lround(1e9 * bend_N_m2),
                                   .twist_stiffness_nN_m2 = (uint32_t)lround(1e9 * bend_N_m2),
                                   .mass_mg_per_m = 4000,
                                   .radius_outer_um = radius_um,
                                   .radius_inner_um = bore_um};
    return tool;
}

/* Straight for 30 mm from its tip, then bent by 180 degrees at R = 40 mm, then straight. */
static crn_instrument hooked_guide(double friction)
{
    enum { BEGIN_um = 30000, END_um = 155664, PER_m_milli = 25000 };
    crn_instrument tool = straight_tool(5e-3, 1350, 900, friction);
    const crn_knot knot = tool.knots[0];
    static const uint32_t arc_um[] = {0, BEGIN_um, BEGIN_um, END_um, END_um, LENGTH_um};
    tool.knot_count = 6;
    for (int i = 0; i < 6; i++) {
        tool.knots[i] = knot;
        tool.knots[i].arc_um = arc_um[i];
        tool.knots[i].rest_curvature1_per_m_milli = i == 2 || i == 3 ? PER_m_milli : 0;
    }
    return tool;
}

/* Returns a rig whose line is numbered by the table {wire, catheter, guide}. */
static rig *rest_in_air(double wire_N_m2, double friction, const uint32_t *line, const uint32_t *inserted_um)
{
    const crn_instrument table[TOOLS] = {straight_tool(wire_N_m2, 178, 0, 0),
                                         straight_tool(2e-5, 500, 250, friction), hooked_guide(friction)};
    rig *r = calloc(1, sizeof *r);
    const crn_entry entry = reference_entry();
    crn_build_place place;
    assert_int_equal(crn_model_build_table(&r->model, table, TOOLS, line, TOOLS, NULL, &entry, &place),
                     CRN_BUILD_OK);
    crn_state_init(&r->model, &r->state, inserted_um);
    crn_model_set_gravity(&r->model, 0, 0, 0);
    for (int i = 0; i < REST_ticks; i++) rig_step(r);
    return r;
}

static void tangent_at(const rig *r, uint32_t edge, double *towards_tip)
{
    for (int k = 0; k < 3; k++) towards_tip[k] = -r->state.words.nodes[edge].tangent_q30.v[k] / Q30;
}

/* Pulls the leading tip with a dead load, turned by an angle from the tip's direction into the plane of the
 * hook. */
static void pull_tip(rig *r, double load_N, double turned_rad)
{
    double tip[3], behind[3], across[3], dot = 0, length = 0;
    tangent_at(r, 0, tip);
    tangent_at(r, 30, behind);
    for (int k = 0; k < 3; k++) dot += tip[k] * behind[k];
    for (int k = 0; k < 3; k++) length += pow(across[k] = behind[k] - dot * tip[k], 2);
    crn_vec3 load_N_q22;
    for (int k = 0; k < 3; k++)
        load_N_q22.v[k] = (int32_t)lround(
            Q22 * load_N * (tip[k] * cos(turned_rad) + across[k] / sqrt(length) * sin(turned_rad)));
    crn_model_set_tip_load(&r->model, load_N_q22);
    for (int i = 0; i < REST_ticks; i++) rig_step(r);
}

static double hand_N(const rig *r, int tool)
{
    return r->output.tools[tool].axial_N_q22 / Q22;
}

/* Draws the wire back and returns the mean force of its hand. */
static double draw_wire(rig *r, int ticks)
{
    double sum_N = 0;
    for (int i = 0; i < ticks; i++) {
        r->input.hands[WIRE].feed_m_q30 -= (int32_t)lround(5e-6 * Q30);
        rig_step(r);
        if (i >= ticks / 2) sum_N += hand_N(r, WIRE);
    }
    return -sum_N / (ticks - ticks / 2);
}

/* The pull c = T + M kappa / 2 of a wire without friction is everywhere what its tip bears: the load times
 * the cosine between load and tip. Measured: within 1 % of the load for the soft wire, and 2 % for the stiff
 * one. */
static void the_pull_at_a_lip_is_the_load_whatever_its_direction(void **context)
{
    (void)context;
    static const uint32_t line[] = {1, 0, 3}, inserted_um[] = {300000, 0, 260000};
    for (double wire_N_m2 = 1e-5; wire_N_m2 < 2e-4; wire_N_m2 *= 10) {
        for (double turned_rad = 0; turned_rad < 2; turned_rad += 0.75) {
            rig *r = rest_in_air(wire_N_m2, 0, line, inserted_um);
            const double load_N = 0.5;
            double tip[3], cosine = 0;
            pull_tip(r, load_N, turned_rad);
            tangent_at(r, 0, tip);
            for (int k = 0; k < 3; k++) cosine += tip[k] * r->model.tip_load_N_q22.v[k] / Q22 / load_N;
            const double pull_N = r->state.words.tools[2].tip_axial_N_q22 / Q22;
            if (fabs(pull_N - load_N * cosine) > 0.03 * load_N)
                fail_msg("EI %g, turned by %g: the pull is %.4f N, expected %.4f N", wire_N_m2, turned_rad,
                         pull_N, load_N * cosine);
            free(r);
        }
    }
}

/* The load pulls the guide, in whose lumen the wire ends. The wire presses by its bending alone: with 4e-4 N
 * m of moment or less at either end of the bend, some 0.02 N of friction. */
static void a_wire_within_the_guide_does_not_feel_the_guides_load(void **context)
{
    (void)context;
    static const uint32_t line[] = {1, 2, 3};
    static const uint32_t inserted_um[][TOOLS] = {{250000, 200000, 260000}, {250000, 255000, 260000}};
    for (int i = 0; i < 2; i++) {
        for (double load_N = -2; load_N < 3; load_N += 2) {
            rig *r = rest_in_air(1e-5, 0.2, line, inserted_um[i]);
            pull_tip(r, load_N, 0);
            check_below("force of the wire's hand in N", fabs(draw_wire(r, 2000)), 0.05);
            free(r);
        }
    }
}

/* Ahead of the catheter's tip the wire rubs in the guide, behind it in the catheter: e^(mu angle) in all. */
static void a_wire_rubs_in_the_guide_ahead_of_the_catheter(void **context)
{
    (void)context;
    static const uint32_t line[] = {1, 2, 3}, alone[] = {1, 0, 3};
    static const uint32_t inserted_um[] = {300000, 180000, 260000};
    const double load_N = 0.5, mu = 0.2;
    rig *with = rest_in_air(1e-5, mu, line, inserted_um);
    rig *without = rest_in_air(1e-5, mu, alone, inserted_um);
    pull_tip(with, load_N, 0);
    pull_tip(without, load_N, 0);
    const double with_N = draw_wire(with, 2000), without_N = draw_wire(without, 2000);
    check_below("difference that the catheter makes in N", fabs(with_N - without_N), 0.05 * without_N);
    check_below("capstan less the force in N", load_N * exp(mu * pi) - with_N, 0.0);
    free(with);
    free(without);
}

static void a_tool_that_comes_onto_the_line_changes_no_hands_force(void **context)
{
    (void)context;
    static const uint32_t line[] = {1, 0, 3}, inserted_um[] = {300000, 0, 260000};
    rig *r = rest_in_air(1e-5, 0.2, line, inserted_um);
    pull_tip(r, 0.5, 0);
    draw_wire(r, 1000);
    const double before_N = hand_N(r, WIRE), guide_N = hand_N(r, GUIDE);
    const crn_exchange_order order = {1, 2};
    assert_int_equal(crn_exchange(&r->model, &r->state, &order), CRN_EXCHANGE_DONE);
    for (int i = 0; i < 20; i++) {
        draw_wire(r, 1);
        check_below("jump of the wire's hand in N", fabs(hand_N(r, WIRE) - before_N), 0.03);
        check_below("jump of the guide's hand in N", fabs(hand_N(r, GUIDE) - guide_N), 0.03);
    }
    free(r);
}

/* --- a wire in a bent guide, without a load ------------------------------------------------------------- */

/* A guide that is straight for 31.5 mm from its tip and then bent. The bend begins and ends between two cells
 * of the mesh, so that each of its ends is one step of the wire's moment. */
static crn_instrument bent_guide(double friction, double per_m, uint32_t bend_um, uint32_t bore_um)
{
    enum { BEGIN_um = 31500 };
    crn_instrument tool = straight_tool(5e-3, 1350, bore_um, friction);
    const crn_knot knot = tool.knots[0];
    const uint32_t arc_um[] = {0, BEGIN_um, BEGIN_um, BEGIN_um + bend_um, BEGIN_um + bend_um, LENGTH_um};
    tool.knot_count = 6;
    for (int i = 0; i < 6; i++) {
        tool.knots[i] = knot;
        tool.knots[i].arc_um = arc_um[i];
        tool.knots[i].rest_curvature1_per_m_milli = i == 2 || i == 3 ? (int32_t)lround(1000 * per_m) : 0;
    }
    return tool;
}

/* Returns a wire that ends 10 mm behind the guide's tip, in the straight part, when both have come to rest.
 */
static rig *wire_in(const crn_instrument *guide, double wire_N_m2)
{
    const crn_instrument tools[2] = {straight_tool(wire_N_m2, 178, 0, 0), *guide};
    const uint32_t inserted_um[2] = {250000, 260000};
    rig *r = rig_of(tools, 2, NULL, inserted_um);
    crn_model_set_gravity(&r->model, 0, 0, 0);
    for (int i = 0; i < REST_ticks; i++) rig_step(r);
    return r;
}

/* A straight wire of the stiffness EI bears the moment M = EI kappa in the bend, and none in the straight
 * parts. At either end of the bend it presses twice with M / (l + b), where l is the length of an element
 * and b = sqrt(2 R delta) the bearing length at R = 40 mm and the clearance delta, at least 0.5 mm. Within
 * the bend, c - M kappa / 2 grows as e^(mu angle). Measured: within 1.8 % in the widest bore, whose bearing
 * length is a fifth of the bend's radius, and 0.57 % in the others. */
static void friction_in_a_bend_without_load_is_that_of_the_moment_at_its_ends(void **context)
{
    (void)context;
    enum { BEND_um = 123000 };
    static const uint32_t bores_um[] = {900, 240, 190, 179};
    const double wire_N_m2 = 1e-4, guide_N_m2 = 5e-3, per_m = 25;
    const double kappa = per_m * guide_N_m2 / (guide_N_m2 + wire_N_m2), moment = wire_N_m2 * kappa;
    for (double mu = 0.1; mu < 0.5; mu += 0.2) {
        for (int i = 0; i < 4; i++) {
            const crn_instrument guide = bent_guide(mu, per_m, BEND_um, bores_um[i]);
            rig *r = wire_in(&guide, wire_N_m2);
            const double bearing_m = fmax(0.5e-3, sqrt(2 * 0.04 * (bores_um[i] - 178) * 1e-6)),
                         end_N = 2 * mu * moment / (ELEMENT_um * 1e-6 + bearing_m),
                         own_N = moment * kappa / 2, angle = kappa * BEND_um * 1e-6;
            const double expected_N = own_N + (end_N - own_N) * exp(mu * angle) + end_N;
            const double force_N = draw_wire(r, 2000);
            const double most = i == 0 ? 0.054 : 0.017;
            if (fabs(force_N / expected_N - 1) > most)
                fail_msg("mu %g, bore %u um: %.4f N, expected %.4f N", mu, bores_um[i], force_N, expected_N);
            free(r);
        }
    }
}

/* The more friction holds the wire, the harder the wire presses: by e^6 in a bend of 6 rad with a friction
 * coefficient of 1. Even so the force of the hand is steady. */
static void a_wire_is_drawn_steadily_against_any_friction(void **context)
{
    (void)context;
    const crn_instrument guide = bent_guide(1, 40, 150000, 900);
    rig *r = wire_in(&guide, 5e-7);
    draw_wire(r, 1500);
    double least_N = 1e9, most_N = 0;
    for (int i = 0; i < 300; i++) {
        const double force_N = draw_wire(r, 1);
        least_N = fmin(least_N, force_N);
        most_N = fmax(most_N, force_N);
    }
    check_below("swing of the force in % of it", 100 * (most_N / least_N - 1), 0.03);
    free(r);
}

/* The force of a hand that does not lead is smoothed over 8 ms. A hand that draws back by 1 mm at once slips
 * the wire in the first tick, so the force comes as 1 - (7/8)^n. Measured: within 0.0055. */
static void the_force_of_a_following_hand_comes_within_8_ms(void **context)
{
    (void)context;
    const crn_instrument guide = bent_guide(0.02, 25, 123000, 900);
    rig *r = wire_in(&guide, 1e-4);
    double force_N[200];
    r->input.hands[WIRE].feed_m_q30 -= (int32_t)lround(1e-3 * Q30);
    for (int i = 0; i < 200; i++) {
        rig_step(r);
        force_N[i] = -r->output.tools[WIRE].axial_N_q22 / Q22;
    }
    for (int n = 1; n <= 30; n++)
        check_below("off the filter's response", fabs(force_N[n - 1] / force_N[199] - 1 + pow(7.0 / 8, n)),
                    0.016);
    free(r);
}

/* --- forces of shape and stiffness on a hand that does not lead ------------------------------------------
 */

/* A dead load bends a wire to the side. A catheter over it is soft at its tip and becomes 100 times as stiff
 * over 100 mm. At a fixed shape, the energy changes with its slide by M^2 / 2 times the change of 1 / EI
 * along it; M is the load times the way from the tip across the load. Measured: within 0.16 %. */
static void a_taper_in_a_bend_pushes_its_hand_by_the_change_of_compliance(void **context)
{
    (void)context;
    enum { WIRE_um = 200000, CATHETER_um = 180000, SOFT_um = 20000, STIFF_um = 120000 };
    const double wire_N_m2 = 1e-3, load_N = 0.1;
    crn_instrument tools[2] = {straight_tool(wire_N_m2, 178, 0, 0), straight_tool(2e-5, 500, 250, 0)};
    crn_instrument *catheter = &tools[CATHETER];
    catheter->knot_count = 4;
    catheter->knots[3] = catheter->knots[1];
    catheter->knots[1] = catheter->knots[2] = catheter->knots[0];
    catheter->knots[1].arc_um = SOFT_um;
    catheter->knots[2].arc_um = STIFF_um;
    catheter->knots[2].bend_stiffness_nN_m2 = catheter->knots[3].bend_stiffness_nN_m2 = 2000000;
    const uint32_t inserted_um[2] = {WIRE_um, CATHETER_um};
    rig *r = rig_of(tools, 2, NULL, inserted_um);
    crn_model_set_gravity(&r->model, 0, 0, 0);
    crn_model_set_tip_load(&r->model, (crn_vec3){{0, (int32_t)lround(load_N * Q22), 0}});
    for (int i = 0; i < REST_ticks; i++) rig_step(r);
    double expected_N = 0, compliance = 1 / wire_N_m2;
    const double step_m = 1e-4, ahead_m = (WIRE_um - CATHETER_um) * 1e-6;
    for (double arc_m = 0; arc_m < CATHETER_um * 1e-6; arc_m += step_m) {
        const double at = (ahead_m + arc_m) / (ELEMENT_um * 1e-6), share = at - floor(at);
        const uint32_t node = (uint32_t)at;
        const double x_m = (r->state.words.nodes[node].position_m_q30.v[0] * (1 - share) +
                            r->state.words.nodes[node + 1].position_m_q30.v[0] * share) /
                           Q30;
        const double moment = load_N * (r->state.words.nodes[0].position_m_q30.v[0] / Q30 - x_m);
        const double part = fmin(1, fmax(0, (arc_m - 0.02) / 0.1));
        const double next = 1 / (wire_N_m2 + 2e-5 + part * (2e-3 - 2e-5));
        expected_N += moment * moment / 2 * (compliance - next);
        compliance = next;
    }
    check_below("off the change of compliance in %", 100 * fabs(hand_N(r, CATHETER) / expected_N - 1), 0.5);
    free(r);
}

/* A catheter of the rest curvature kappa over 60 mm comes out of the straight sheath over a stiff straight
 * wire: 50 mm of it go from EI kappa^2 / 2 per length to EI' kappa^2 / 2, where 1 / EI' = 1 / EI + 1 / EI of
 * the wire. The hands get the difference back. Measured: within 0.29 %. */
static void the_hands_get_what_a_curved_catheter_loses_out_of_the_sheath(void **context)
{
    (void)context;
    const double wire_N_m2 = 1.2e-3, catheter_N_m2 = 4e-4, per_m = 20, speed_m = 20e-6;
    crn_instrument tools[2] = {straight_tool(wire_N_m2, 178, 0, 0),
                               straight_tool(catheter_N_m2, 500, 250, 0)};
    crn_instrument *catheter = &tools[CATHETER];
    catheter->knot_count = 4;
    catheter->knots[2] = catheter->knots[3] = catheter->knots[1];
    catheter->knots[1] = catheter->knots[0];
    catheter->knots[1].arc_um = catheter->knots[2].arc_um = 60000;
    catheter->knots[2].rest_curvature1_per_m_milli = 0;
    for (int i = 0; i < 2; i++)
        catheter->knots[i].rest_curvature1_per_m_milli = (int32_t)lround(1000 * per_m);
    const uint32_t inserted_um[2] = {200000, 10000};
    rig *r = rig_of(tools, 2, NULL, inserted_um);
    crn_model_set_gravity(&r->model, 0, 0, 0);
    for (int i = 0; i < REST_ticks; i++) rig_step(r);
    double work_J = 0, before_m[2], way_m = 0;
    for (int k = 0; k < 2; k++) before_m[k] = r->output.tools[k].inserted_m_q30 / Q30;
    for (int i = 0; i < 7000 + REST_ticks; i++) {
        if (i < 7000) r->input.hands[CATHETER].feed_m_q30 += (int32_t)lround(speed_m * Q30);
        rig_step(r);
        for (int k = 0; k < 2; k++) {
            const double now_m = r->output.tools[k].inserted_m_q30 / Q30;
            work_J += hand_N(r, k) * (now_m - before_m[k]);
            way_m += k == CATHETER ? now_m - before_m[k] : 0;
            before_m[k] = now_m;
        }
    }
    const double both_N_m2 = wire_N_m2 * catheter_N_m2 / (wire_N_m2 + catheter_N_m2);
    const double expected_J = (both_N_m2 - catheter_N_m2) * per_m * per_m / 2 * 0.05;
    check_below("off 140 mm in mm", fabs(1e3 * way_m - 140), 0.1);
    check_below("off the energy in %", 100 * fabs(work_J / expected_J - 1), 0.9);
    free(r);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_pull_at_a_lip_is_the_load_whatever_its_direction),
        cmocka_unit_test(a_wire_within_the_guide_does_not_feel_the_guides_load),
        cmocka_unit_test(a_wire_rubs_in_the_guide_ahead_of_the_catheter),
        cmocka_unit_test(a_tool_that_comes_onto_the_line_changes_no_hands_force),
        cmocka_unit_test(friction_in_a_bend_without_load_is_that_of_the_moment_at_its_ends),
        cmocka_unit_test(a_wire_is_drawn_steadily_against_any_friction),
        cmocka_unit_test(the_force_of_a_following_hand_comes_within_8_ms),
        cmocka_unit_test(a_taper_in_a_bend_pushes_its_hand_by_the_change_of_compliance),
        cmocka_unit_test(the_hands_get_what_a_curved_catheter_loses_out_of_the_sheath),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
