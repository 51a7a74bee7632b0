/* These tests check nested (coaxial) tools (docs/rod.md, "tools"). Nested tools add their stiffness, and each
 * tool keeps its own feed, rotation and rest shape. Nested tools press and rub on each other in both
 * directions, and no node jumps when another tool becomes the leading tool (the one that reaches farthest).
 * The vessel wall resists the turning of a tool by Coulomb's law of friction. The tests compare the results
 * with closed forms of composite beams, stored energy, and force balances. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "firmware/tests/reference/long_run.h"
#include "firmware/tests/reference/random.h"
#include "firmware/tests/reference/random_hands.h"
#include "firmware/tests/reference/rod_rig.h"

static const double Q30 = 1073741824.0;
static const double pi = 3.14159265358979;

enum { WIRE, CATHETER, GUIDE };

/* Makes a tool with a bent end: over the first `bent_mm` the tool has a rest curvature; behind that length it
 * is straight and has the stiffness `shaft`. */
typedef struct tool_plan {
    double tip_N_m2, shaft_N_m2, curve_per_m, bent_mm;
    uint32_t radius_um, bore_um;
    double wall_friction, lumen_friction;
} tool_plan;

static crn_instrument make_tool(const tool_plan *plan)
{
    crn_instrument tool = reference_wire(plan->shaft_N_m2, 900000, 4000, plan->wall_friction);
    tool.element_tip_um = 1000;
    tool.element_fine_um = 40000;
    tool.lumen_friction_milli = (uint32_t)lround(1000 * plan->lumen_friction);
    tool.knot_count = 4;
    tool.knots[3] = tool.knots[1];
    for (int i = 0; i < 3; i++) tool.knots[i] = tool.knots[0];
    for (int i = 0; i < 4; i++) {
        tool.knots[i].radius_outer_um = plan->radius_um;
        tool.knots[i].radius_inner_um = plan->bore_um;
    }
    tool.knots[1].arc_um = tool.knots[2].arc_um = (uint32_t)lround(1000 * plan->bent_mm);
    for (int i = 0; i < 2; i++) {
        tool.knots[i].bend_stiffness_nN_m2 = (uint32_t)lround(1e9 * plan->tip_N_m2);
        tool.knots[i].twist_stiffness_nN_m2 = (uint32_t)lround(1e9 * plan->tip_N_m2);
        tool.knots[i].rest_curvature1_per_m_milli = (int32_t)lround(1000 * plan->curve_per_m);
    }
    return tool;
}

/* From the tip on, the tool is straight for 6 mm, bends by 90 degrees at R = 7 mm, is straight for 23 mm, and
 * bends by 180 degrees at R = 10 mm in the opposite direction. */
static void judkins(crn_instrument *tool)
{
    static const uint32_t arc_um[] = {0, 6000, 6000, 17000, 17000, 40000, 40000, 71400, 71400};
    static const int32_t curve_per_m[] = {0, 0, -143, -143, 0, 0, 100, 100, 0};
    const crn_knot soft = tool->knots[0], shaft = tool->knots[3];
    for (int i = 0; i < 9; i++) {
        tool->knots[i] = soft;
        tool->knots[i].arc_um = arc_um[i];
        tool->knots[i].rest_curvature1_per_m_milli = 1000 * curve_per_m[i];
    }
    tool->knots[9] = tool->knots[10] = shaft;
    tool->knots[9].arc_um = 71400;
    tool->knot_count = 11;
}

static rig *rig_planned(const tool_plan *plans, uint32_t count, const crn_lumen *lumen,
                        const uint32_t *inserted_um)
{
    crn_instrument tools[CRN_TOOL_MAX];
    for (uint32_t k = 0; k < count; k++) tools[k] = make_tool(&plans[k]);
    return rig_of(tools, count, lumen, inserted_um);
}

static void rest(rig *r, int ticks)
{
    for (int t = 0; t < ticks; t++) rig_step(r);
}

static double axial_N(const rig *r, int tool)
{
    return r->output.tools[tool].axial_N_q22 / 4194304.0;
}

static double torque_N_m(const rig *r, int tool)
{
    return r->output.tools[tool].torque_N_m_q24 / 16777216.0;
}

/* Returns the largest displacement of a node in the last tick, in mm. */
static double largest_step_mm(const rig *r)
{
    double largest = 0;
    for (uint32_t i = 0; i < crn_state_free_count(&r->state); i++) {
        double square = 0;
        for (int k = 0; k < 3; k++)
            square += pow(r->state.words.nodes[i].step_m_q33.v[k] / (Q30 * 8) * 1e3, 2);
        largest = fmax(largest, sqrt(square));
    }
    return largest;
}

typedef struct journey {
    double work_J, step_mm;
} journey;

/* Moves one tool by `way_m` at `speed_m_s` and then waits two seconds for the tools to come to rest. Returns
 * the work of all hands and the largest displacement of any node in one tick. */
static journey move_tool(rig *r, int tool, double way_m, double speed_m_s)
{
    journey j = {0, 0};
    int32_t from = r->input.hands[tool].feed_m_q30;
    int moving = (int)(fabs(way_m) / speed_m_s * 1000);
    double inserted[CRN_TOOL_MAX];
    for (int k = 0; k < CRN_TOOL_MAX; k++) inserted[k] = r->state.words.tools[k].inserted_m_q30 / Q30;
    for (int t = 1; t <= moving + 2000; t++) {
        double share = t < moving ? (double)t / moving : 1;
        r->input.hands[tool].feed_m_q30 = from + (int32_t)lround(share * way_m * Q30);
        rig_step(r);
        for (int k = 0; k < CRN_TOOL_MAX; k++) {
            double now = r->output.tools[k].inserted_m_q30 / Q30;
            j.work_J += axial_N(r, k) * (now - inserted[k]);
            inserted[k] = now;
        }
        j.step_mm = fmax(j.step_mm, largest_step_mm(r));
    }
    return j;
}

/* Returns the angle between the first edge and the edge at `arc_m`, in degrees. */
static double turning_deg(const rig *r, double arc_m)
{
    uint32_t edge = 0;
    while (crn_model_arc(&r->model, edge) < arc_m * Q30) edge++;
    double dot = 0;
    for (int k = 0; k < 3; k++) {
        dot += r->state.words.nodes[0].tangent_q30.v[k] / Q30 *
               (r->state.words.nodes[edge].tangent_q30.v[k] / Q30);
    }
    return acos(fmin(1, fmax(-1, dot))) * 180 / pi;
}

static void check_near(const char *what, double value, double expected, double tolerance)
{
    if (!(fabs(value - expected) <= tolerance))
        fail_msg("%s = %g, expected %g +- %g", what, value, expected, tolerance);
}

static const tool_plan j_wire = {1e-4, 2e-4, 60, 30, 445, 0, 0, 0};
static const tool_plan straight_wire = {1.2e-3, 1.2e-3, 0, 30, 445, 0, 0, 0};
static const tool_plan straight_catheter = {4e-4, 4e-4, 0, 30, 800, 500, 0, 0};
static const tool_plan bent_catheter = {4e-4, 4e-4, 20, 60, 800, 500, 0, 0};

static rig *rig_in_air(const tool_plan *wire, const tool_plan *catheter, uint32_t wire_um,
                       uint32_t catheter_um)
{
    const tool_plan plans[] = {*wire, *catheter};
    const uint32_t inserted_um[] = {wire_um, catheter_um};
    rig *r = rig_planned(plans, 2, NULL, inserted_um);
    crn_model_set_gravity(&r->model, 0, 0, 0);
    return r;
}

/* --- shapes: a composite beam rests at kappa = sum EI_k kappa_k / sum EI_k ------------------------------ */

/* A wire with an EI of 1e-4 N m^2, curved by 60/m over 30 mm, lies in a straight catheter with an EI of 4e-4
 * N m^2. The expected curvature of wire and catheter together is 60 / 5 = 12/m over 30 mm, that is, 20.6
 * degrees. The tolerance of the angle is 1 degree, because the catheter's frictionless tip is 5 mm beyond the
 * curve. */
static void a_catheter_opens_the_j_of_the_wire_inside_it(void **context)
{
    (void)context;
    rig *r = rig_in_air(&j_wire, &straight_catheter, 150000, 50000);
    rest(r, 2000);
    check_near("turning of the free J (deg)", turning_deg(r, 0.045), 60 * 0.03 * 180 / pi, 2);
    move_tool(r, CATHETER, 0.105, 0.05);
    check_near("turning inside the catheter (deg)", turning_deg(r, 0.045), 12 * 0.03 * 180 / pi, 1);
    free(r);
}

/* A rest curvature of 20/m over 60 mm bends the catheter alone by 68.8 degrees; with the straight wire
 * inside, the catheter bends by a quarter of this angle. */
static void withdrawing_the_wire_lets_a_shaped_catheter_take_its_shape(void **context)
{
    (void)context;
    rig *r = rig_in_air(&straight_wire, &bent_catheter, 200000, 200000);
    rest(r, 2000);
    double alone = 20 * 0.06 * 180 / pi;
    check_near("turning on the stiff wire (deg)", turning_deg(r, 0.08), alone * 4e-4 / 16e-4, 1);
    move_tool(r, WIRE, -0.12, 0.05);
    assert_int_equal(r->output.lead_tool, CATHETER);
    check_near("turning with the wire withdrawn (deg)", turning_deg(r, 0.08), alone, 1);
    move_tool(r, WIRE, 0.12, 0.05);
    check_near("turning with the wire back (deg)", turning_deg(r, 0.08), alone * 4e-4 / 16e-4, 1);
    free(r);
}

/* Two nested, heavy tools of masses m_w and m_c per length sag under their common weight by (m_w + m_c) g L^4
 * / (8 (EI_w + EI_c)), if the sag is small compared with their length L. L 100 mm, 1 %. */
static void stiffness_and_weight_add_where_tools_overlap(void **context)
{
    (void)context;
    const tool_plan plans[] = {straight_wire, straight_catheter};
    const uint32_t inserted_um[] = {100000, 100000};
    rig *r = rig_planned(plans, 2, NULL, inserted_um);
    rest(r, 6000);
    double length_m = r->output.tools[0].inserted_m_q30 / Q30;
    double sag_m = -crn_state_position(&r->state, 0).v[2] / Q30;
    double expected_m = 0.010 * 9.81 * pow(length_m, 4) / (8 * 1.6e-3);
    check_near("sag in % of the composite beam's", 100 * sag_m / expected_m, 100, 1);
    free(r);
}

/* --- forces --------------------------------------------------------------------------------------------- */

/* Pushing the catheter over the wire's J-shaped tip of curvature kappa stores EI_w EI_c / (EI_w + EI_c)
 * kappa^2 / 2 x 30 mm = 4.32 mJ of energy, where EI_w and EI_c are the stiffnesses of wire and catheter. The
 * work of the hands equals the stored energy of 4.32 mJ, which the hands get back when the wire is pushed out
 * again. The tolerance of 5 % of the work allows for the drag of the blood on the moving tip. */
static void work_of_the_hands_is_the_energy_stored_in_the_j(void **context)
{
    (void)context;
    rig *r = rig_in_air(&j_wire, &straight_catheter, 150000, 100000);
    rest(r, 3000);
    const double stored_J = 0.5 * 0.8e-4 * 60 * 60 * 0.03;
    check_near("work of covering it, in % of the energy",
               100 * move_tool(r, CATHETER, 0.12, 0.02).work_J / stored_J, 100, 5);
    check_near("work of uncovering it, in %", 100 * move_tool(r, WIRE, 0.12, 0.02).work_J / stored_J, -100,
               5);
    free(r);
}

/* With friction in the catheter's lumen, the hands do more work for the same motion in both directions, and
 * get no energy back in either direction. */
static void friction_between_tools_takes_work_both_ways(void **context)
{
    (void)context;
    tool_plan rough = straight_catheter;
    rough.lumen_friction = 0.1;
    rig *r = rig_in_air(&j_wire, &rough, 150000, 100000);
    rest(r, 3000);
    double there = move_tool(r, CATHETER, 0.12, 0.05).work_J;
    double back = move_tool(r, CATHETER, -0.12, 0.05).work_J;
    check_below("work over the closed way, as its negative (J)", -(there + back), -1e-3);
    free(r);
}

/* The catheter slides while a hand holds the wire: the force on one hand increases by as much as the force on
 * the other hand decreases. */
static void sliding_friction_acts_on_both_hands(void **context)
{
    (void)context;
    tool_plan rough = straight_catheter;
    rough.lumen_friction = 0.1;
    rig *r = rig_in_air(&j_wire, &rough, 150000, 170000);
    rest(r, 2000);
    for (int t = 0; t < 200; t++) {
        r->input.hands[CATHETER].feed_m_q30 += (int32_t)(5e-5 * Q30);
        rig_step(r);
    }
    double wire_N = axial_N(r, WIRE), catheter_N = axial_N(r, CATHETER);
    check_below("force on the catheter's hand, as its negative (N)", -catheter_N, -0.05);
    check_near("sum of both hands (N)", wire_N + catheter_N, 0, 0.03);
    free(r);
}

/* A catheter that a hand turns about a bent wire drags the wire along, with equal and opposite torques at the
 * two hands. */
static void turning_friction_acts_on_both_hands(void **context)
{
    (void)context;
    tool_plan rough = straight_catheter;
    rough.lumen_friction = 0.3;
    rig *r = rig_in_air(&j_wire, &rough, 150000, 170000);
    rest(r, 2000);
    for (int t = 0; t < 500; t++) {
        r->input.hands[CATHETER].turn32 += 2000000;
        rig_step(r);
    }
    double wire = torque_N_m(r, WIRE), catheter = torque_N_m(r, CATHETER);
    check_below("torque on the catheter's hand, as its negative (N m)", -catheter, -2e-5);
    check_near("torque on both hands in % of one", 100 * (wire + catheter) / catheter, 0, 5);
    free(r);
}

/* --- lead ----------------------------------------------------------------------------------------------- */

/* While another tool becomes the leading tool, no node moves by more than 0.1 mm a tick; the hand's feed
 * alone causes 0.05 mm of this motion. */
static void a_change_of_the_lead_moves_no_node_by_more_than_0_1_mm(void **context)
{
    (void)context;
    rig *r = rig_in_air(&j_wire, &bent_catheter, 150000, 130000);
    rest(r, 3000);
    assert_int_equal(r->output.lead_tool, WIRE);
    check_below("node motion when the catheter takes the lead (mm per tick)",
                move_tool(r, CATHETER, 0.04, 0.05).step_mm, 0.1);
    assert_int_equal(r->output.lead_tool, CATHETER);
    check_below("node motion when the wire takes it back (mm per tick)",
                move_tool(r, WIRE, 0.05, 0.05).step_mm, 0.1);
    assert_int_equal(r->output.lead_tool, WIRE);
    check_below("node motion when the wire gives it up (mm per tick)",
                move_tool(r, WIRE, -0.06, 0.05).step_mm, 0.1);
    assert_int_equal(r->output.lead_tool, CATHETER);
    free(r);
}

/* The catheter follows the wire through three bends. The catheter stays in the tube, and the wire's tip moves
 * by 0.63 mm. */
static void a_catheter_tracks_over_the_wire_round_the_bends(void **context)
{
    (void)context;
    reference_tube *tube = reference_three_bends(0.004, 0);
    const tool_plan plans[] = {{1e-5, 3e-4, 0, 30, 445, 0, 0.1, 0}, {2e-4, 3e-4, 0, 30, 800, 500, 0.1, 0.05}};
    const uint32_t inserted_um[] = {60000, 20000};
    rig *r = rig_planned(plans, 2, &tube->lumen, inserted_um);
    move_tool(r, WIRE, 0.44, 0.15);
    crn_vec3 before = crn_state_position(&r->state, 0);
    double deepest_mm = 0;
    for (int t = 0; t < 4500; t++) {
        r->input.hands[CATHETER].feed_m_q30 += (int32_t)(1e-4 * Q30);
        rig_step(r);
        deepest_mm = fmax(deepest_mm, r->output.penetration_max_m_q30 / Q30 * 1e3);
    }
    rest(r, 500);
    crn_vec3 after = crn_state_position(&r->state, 0);
    double moved = 0;
    for (int k = 0; k < 3; k++) moved += pow((after.v[k] - before.v[k]) / Q30 * 1e3, 2);
    check_near("inserted length of the catheter (mm)", r->output.tools[CATHETER].inserted_m_q30 / Q30 * 1e3,
               470, 1);
    check_below("motion of the wire's tip (mm)", sqrt(moved), 2);
    check_below("penetration (mm)", deepest_mm, 0.5);
    free(r);
    reference_tube_free(tube);
}

/* --- turning -------------------------------------------------------------------------------------------- */

/* The tools are straight and frictionless, so every edge of each tool has the angle of the hand that holds
 * this tool. The tolerance of the angle is 1e-6 turn = 0.0004 degrees. */
static void without_friction_each_tool_follows_its_own_hand(void **context)
{
    (void)context;
    rig *r = rig_in_air(&straight_wire, &straight_catheter, 200000, 150000);
    for (int t = 0; t < 1000; t++) {
        r->input.hands[WIRE].turn32 += 5000000;
        r->input.hands[CATHETER].turn32 -= 3000000;
        rig_step(r);
    }
    rest(r, 200);
    for (int k = 0; k < 2; k++) {
        uint32_t edge = k == WIRE ? 0 : 60;
        uint32_t lag = r->state.words.nodes[edge].angle_turn32[k] + r->input.hands[k].turn32;
        check_near("tip's lag (turn)", (int32_t)lag / 4294967296.0, 0, 1e-6);
    }
    free(r);
}

static double resting_torque(double friction, double sliding_m_s)
{
    const reference_piece straight = {0.5, 0, 0};
    reference_tube *tube = reference_tube_make(&straight, 1, 0.002, 1);
    const tool_plan plan = {1e-4, 1e-4, 0, 30, 445, 0, friction, 0};
    const uint32_t inserted_um = 400000;
    rig *r = rig_planned(&plan, 1, &tube->lumen, &inserted_um);
    rest(r, 1500);
    double torque = 0;
    for (int t = 0; t < 1500; t++) {
        r->input.hands[0].turn32 += 1000000; /* 1.5 rad/s */
        r->input.hands[0].feed_m_q30 -= (int32_t)(sliding_m_s * 1e-3 * Q30);
        rig_step(r);
        if (t >= 1000) torque += torque_N_m(r, 0) / 500;
    }
    free(r);
    reference_tube_free(tube);
    return torque;
}

/* A wire of radius r that lies on the floor of a tube resists turning with the torque mu N r, where mu is the
 * friction coefficient and N the normal force. The force N is the wire's weight minus the weight that the
 * sheath supports. The sheath supports two thirds of the span over which the wire hangs, which is (72 EI h /
 * w)^(1/4) = 123 mm for a height h of 2 mm and a weight w per length. The tolerance is 8 %.
 */
static void the_wall_resists_turning_with_mu_n_r(void **context)
{
    (void)context;
    double span_m = pow(72 * 1e-4 * 0.0015555 / (0.005 * 9.81), 0.25);
    double weight_N = 0.005 * 9.81 * (0.4 - span_m * 2 / 3);
    check_near("torque in % of mu N r", 100 * resting_torque(0.3, 0) / (0.3 * weight_N * 445e-6), 100, 8);
    assert_true(fabs(resting_torque(0, 0)) < 1e-7);
}

/* The friction limit, the coefficient mu times the normal force N, holds for the slip along the wire and the
 * slip around the wire together. When a hand draws a wire ten times as fast as the wire's surface turns (6.67
 * mm/s against 0.667 mm/s), the wire resists turning by only about a tenth, 1 / sqrt(101). */
static void a_wire_that_slides_turns_almost_freely(void **context)
{
    (void)context;
    double held = resting_torque(0.3, 0);
    double surface_m_s = 1000000 / 4294967296.0 * 2 * pi * 1000 * 445e-6;
    double sliding = resting_torque(0.3, 10 * surface_m_s);
    check_near("torque while sliding in % of that at rest", 100 * sliding / held, 100 / sqrt(101), 3);
}

/* --- contact forces ------------------------------------------------------------------------------------- */

static void contact_forces_of_the_nodes_carry_the_weight(void **context)
{
    (void)context;
    const reference_piece straight = {0.5, 0, 0};
    reference_tube *tube = reference_tube_make(&straight, 1, 0.002, 1);
    const tool_plan plan = {1e-5, 1e-5, 0, 30, 445, 0, 0.2, 0};
    const uint32_t inserted_um = 400000;
    rig *r = rig_planned(&plan, 1, &tube->lumen, &inserted_um);
    rest(r, 4000);
    double up_N = 0;
    for (uint32_t i = 0; i < crn_state_free_count(&r->state); i++) {
        crn_vec3 force;
        bool touches = crn_state_contact_force(&r->model, &r->state, i, &force);
        assert_true(touches || force.v[2] == 0);
        up_N += force.v[2] / 4194304.0;
    }
    double span_m = pow(72 * 1e-5 * 0.0015555 / (0.005 * 9.81), 0.25);
    check_near("sum of the contact forces in % of the weight",
               100 * up_N / (0.005 * 9.81 * (0.4 - span_m * 2 / 3)), 100, 5);
    free(r);
    reference_tube_free(tube);
}

/* --- robustness ----------------------------------------------------------------------------------------- */

static const tool_plan three_shaped[] = {{1e-5, 5e-4, 66, 20, 445, 0, 0.1, 0},
                                         {2e-4, 5e-4, 30, 40, 800, 500, 0.1, 0.05},
                                         {5e-4, 8e-4, 15, 40, 1150, 850, 0.1, 0.05}};

/* The command `make bench` runs this test with a million ticks and prints the result in the row
 * hands.length_error_max_pct. */
static void random_hands_keep_three_tools_in_the_vessel(void **context)
{
    (void)context;
    reference_hands_result result = {0};
    reference_random_hands(3, 8, REFERENCE_RUN(12000), &result);
    check_below("length error (%)", result.strain_max_pct, 0.6);
    check_below("ticks with more than 0.45 %", result.long_045, 1);
    check_below("ticks deeper than 1 mm", result.deep, 1);
}

static void three_tools_are_restored_bit_for_bit(void **context)
{
    (void)context;
    const uint32_t inserted_um[] = {150000, 120000, 90000};
    rig *r = rig_planned(three_shaped, 3, NULL, inserted_um);
    for (int t = 0; t < 1000; t++) {
        r->input.hands[t % 3].feed_m_q30 += 150000;
        r->input.hands[(t + 1) % 3].turn32 += 9000000;
        rig_step(r);
    }
    uint8_t *saved = malloc(crn_state_bytes());
    crn_state_save(&r->state, saved);
    crn_input input = r->input;
    uint64_t hash[2];
    for (int run = 0; run < 2; run++) {
        if (run) {
            const uint32_t elsewhere_um[] = {50000, 60000, 70000};
            crn_state_init(&r->model, &r->state, elsewhere_um);
            assert_true(crn_state_restore(&r->model, &r->state, saved));
        }
        r->input = input;
        for (int t = 0; t < 300; t++) {
            r->input.hands[CATHETER].feed_m_q30 += 200000;
            rig_step(r);
        }
        hash[run] = crn_state_hash64(&r->state);
    }
    assert_true(hash[0] == hash[1]);
    free(saved);
    free(r);
}

/* The core keeps the combined properties of the nested tools from tick to tick. After the tools have slid,
 * the stored combined properties must equal the properties that the core computes anew. */
static void a_line_that_is_kept_is_the_line_built_afresh(void **context)
{
    (void)context;
    const uint32_t inserted_um[] = {150000, 120000, 160000};
    rig *kept = rig_planned(three_shaped, 3, NULL, inserted_um);
    rig *afresh = malloc(sizeof *afresh);
    *afresh = *kept;
    reference_random random = {7};
    int32_t way[3] = {0, 0, 0};
    for (int t = 0; t < 3000; t++) {
        for (int k = 0; k < 3; k++) {
            /* half of the time the tool moves, often alone: the line behind is steady, shifts, or belongs to
             * another tool */
            if (t % 50 == 0) {
                bool moves = reference_random_below(&random, 2) == 1;
                way[k] = moves ? (int32_t)reference_random_below(&random, 800000) - 330000 : 0;
            }
            kept->input.hands[k].feed_m_q30 += way[k];
        }
        afresh->input = kept->input;
        afresh->state.line.count = 0;
        rig_step(kept);
        rig_step(afresh);
        assert_int_equal(kept->output.hash_lane[0], afresh->output.hash_lane[0]);
        assert_int_equal(kept->output.hash_lane[1], afresh->output.hash_lane[1]);
    }
    free(kept);
    free(afresh);
}

/* A 6F Judkins left guiding catheter with a 0.014 in wire and a balloon catheter inside leaves the sheath and
 * enters an artery of 3.6 mm radius. The artery keeps the guiding catheter's primary curve open (R = 7 mm;
 * straightening it takes 0.052 N m), and the sheath's distal end bends this curve in the opposite direction.
 * In elements of 1 mm, the forces at a joint of this guiding catheter exceed 60 N. */
static void a_tight_guide_comes_out_of_the_sheath_without_saturating(void **context)
{
    (void)context;
    static const tool_plan plans[3] = {{1e-7, 1.12e-4, 0, 20, 178, 0, 0.1, 0.05},
                                       {3.3e-7, 4.6e-5, 0, 25, 450, 210, 0.1, 0.05},
                                       {3.63e-4, 7.67e-4, 0, 6, 1040, 900, 0.12, 0.05}};
    const reference_piece pieces[] = {{0.2, 0, 0}};
    const uint32_t inserted_um[3] = {5000, 5000, 5000};
    reference_tube *tube = reference_tube_make(pieces, 1, 3.6e-3, 1);
    rig *r = calloc(1, sizeof *r);
    crn_instrument tools[3];
    crn_entry entry = reference_entry();
    crn_build_place place;
    for (int k = 0; k < 3; k++) tools[k] = make_tool(&plans[k]);
    judkins(&tools[GUIDE]);
    assert_int_equal(crn_model_build(&r->model, tools, 3, &tube->lumen, &entry, &place), CRN_BUILD_OK);
    crn_state_init(&r->model, &r->state, inserted_um);
    for (int t = 0; t < 1200; t++) {
        for (int k = 0; k < 3; k++) r->input.hands[k].feed_m_q30 += (int32_t)(0.06e-3 * Q30);
        rig_step(r);
        if (r->output.fault_bits & CRN_FAULT_SATURATED) fail_msg("saturated in tick %u", r->output.tick);
    }
    free(r);
    reference_tube_free(tube);
}

static void tools_that_do_not_fit_are_refused_by_name(void **context)
{
    (void)context;
    crn_instrument tools[4];
    crn_entry entry = reference_entry();
    crn_build_place place;
    crn_model *model = malloc(sizeof *model);
    for (int k = 0; k < 3; k++) tools[k] = make_tool(&three_shaped[k]);
    tools[3] = tools[2];
    assert_int_equal(crn_model_build(model, tools, 3, NULL, &entry, &place), CRN_BUILD_OK);
    assert_int_equal(crn_model_build(model, tools, 0, NULL, &entry, &place), CRN_BUILD_TOOLS);
    assert_int_equal(crn_model_build(model, tools, 4, NULL, &entry, &place), CRN_BUILD_TOOLS);
    tools[GUIDE].knots[2].radius_inner_um = 799; /* the catheter is 800 um thick */
    assert_int_equal(crn_model_build(model, tools, 3, NULL, &entry, &place), CRN_BUILD_NESTING);
    assert_int_equal(place.tool, GUIDE);
    assert_int_equal(place.knot, 2);
    tools[GUIDE].knots[2].radius_inner_um = 1150; /* no wall left */
    assert_int_equal(crn_model_build(model, tools, 3, NULL, &entry, &place), CRN_BUILD_RANGE);
    assert_int_equal(place.tool, GUIDE);
    free(model);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_catheter_opens_the_j_of_the_wire_inside_it),
        cmocka_unit_test(withdrawing_the_wire_lets_a_shaped_catheter_take_its_shape),
        cmocka_unit_test(stiffness_and_weight_add_where_tools_overlap),
        cmocka_unit_test(work_of_the_hands_is_the_energy_stored_in_the_j),
        cmocka_unit_test(friction_between_tools_takes_work_both_ways),
        cmocka_unit_test(sliding_friction_acts_on_both_hands),
        cmocka_unit_test(turning_friction_acts_on_both_hands),
        cmocka_unit_test(a_change_of_the_lead_moves_no_node_by_more_than_0_1_mm),
        cmocka_unit_test(a_catheter_tracks_over_the_wire_round_the_bends),
        cmocka_unit_test(without_friction_each_tool_follows_its_own_hand),
        cmocka_unit_test(the_wall_resists_turning_with_mu_n_r),
        cmocka_unit_test(a_wire_that_slides_turns_almost_freely),
        cmocka_unit_test(contact_forces_of_the_nodes_carry_the_weight),
        cmocka_unit_test(random_hands_keep_three_tools_in_the_vessel),
        cmocka_unit_test(three_tools_are_restored_bit_for_bit),
        cmocka_unit_test(a_line_that_is_kept_is_the_line_built_afresh),
        cmocka_unit_test(a_tight_guide_comes_out_of_the_sheath_without_saturating),
        cmocka_unit_test(tools_that_do_not_fit_are_refused_by_name),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
