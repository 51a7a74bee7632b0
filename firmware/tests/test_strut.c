/* These tests check the contact between a wire and the struts of a deployed stent (docs/lesions.md). The
 * struts act on the wire like a wall. A wire inside the stent rests on the inner surface of the struts, and a
 * wire outside the stent rests on their outer surface. The wire does not pass through the struts as long as
 * its force is below the force that a cell of the stent withstands. When a wire lies between struts and
 * vessel wall, friction on the struts and on the wall holds it. An end of the stent deflects a wire's tip to
 * one side. The stent's struts do not act on balloons. The stent's struts are part of the core's state, and
 * an invalid command for them changes nothing. The tests compare the results with closed forms for shells in
 * straight tubes. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "firmware/core/lesion.h"
#include "firmware/tests/reference/damage.h"
#include "firmware/tests/reference/long_run.h"
#include "firmware/tests/reference/tube_lumen.h"

static const double Q30 = 1073741824.0, pi = 3.14159265358979;
static const double wire_m = 0.25e-3, thickness_m = 0.08e-3;
enum { RINGS = 10, RING_um = 2000, FIRST_um = 30000, LAST_um = FIRST_um + (RINGS - 1) * RING_um };

typedef struct rig {
    crn_model model;
    crn_state state;
    crn_input input;
    crn_output output;
    crn_lumen lumen;
} rig;

static const reference_tube *tube(double radius_m)
{
    static reference_tube *wide, *narrow;
    const reference_piece straight = {.length_m = 0.08};
    reference_tube **made = radius_m > 3e-3 ? &wide : &narrow;
    if (*made == NULL) *made = reference_tube_make(&straight, 1, radius_m, 2);
    return *made;
}

static crn_instrument wire(double bend_N_m2, double friction)
{
    crn_instrument tool = reference_wire(bend_N_m2, 200000, 1000, friction);
    for (uint32_t i = 0; i < tool.knot_count; i++)
        tool.knots[i].radius_outer_um = (uint32_t)lround(wire_m * 1e6);
    return tool;
}

static rig *rig_make(const crn_instrument *tool, double tube_m, uint32_t inserted_um)
{
    rig *r = calloc(1, sizeof *r);
    const crn_entry entry = reference_entry();
    crn_build_place place;
    r->lumen = tube(tube_m)->lumen;
    assert_int_equal(crn_model_build(&r->model, tool, 1, &r->lumen, &entry, &place), CRN_BUILD_OK);
    crn_state_init(&r->model, &r->state, &inserted_um);
    return r;
}

static void run(rig *r, int ticks)
{
    for (int t = 0; t < ticks; t++) crn_step(&r->model, &r->state, &r->input, &r->output);
}

/* Returns the command for ring i of a straight stent, whose axis is parallel to x at the height `z_um`. */
static crn_strut_order ring(uint32_t i, int32_t z_um, uint32_t inside_um)
{
    return (crn_strut_order){i + 1,
                             {FIRST_um + (int32_t)i * RING_um, 0, z_um},
                             inside_um,
                             (uint32_t)lround(thickness_m * 1e6),
                             i + 1 < RINGS};
}

static void order_stent(rig *r, int32_t z_um, uint32_t inside_um)
{
    for (uint32_t i = 0; i < RINGS; i++) {
        r->input.strut = ring(i, z_um, inside_um);
        run(r, 1);
    }
    r->input.strut = (crn_strut_order){0};
}

static double place_m(const rig *r, uint32_t node, int axis)
{
    return crn_state_position(&r->state, node).v[axis] / Q30;
}

/* Returns whether a node is between the stent's ends and at least a millimetre from either end. */
static bool is_in_stent(const rig *r, uint32_t node)
{
    const double x_m = place_m(r, node, 0);
    return x_m > FIRST_um * 1e-6 + 1e-3 && x_m < LAST_um * 1e-6 - 1e-3;
}

static crn_vec3 at_m(double x, double y, double z)
{
    return crn_vec3_make((int32_t)lround(x * Q30), (int32_t)lround(y * Q30), (int32_t)lround(z * Q30));
}

/* --- the shell ------------------------------------------------------------------------------------------ */

typedef struct felt {
    bool is_near;
    double distance_m, normal[3];
} felt;

static felt feel(const crn_strut_state *struts, double x, double y, double z)
{
    const crn_vec3 place = at_m(x, y, z);
    crn_lumen_sample sample;
    felt f = {crn_struts_contact(struts, &place, (int32_t)lround(wire_m * Q30), &sample), 0, {0}};
    f.distance_m = f.is_near ? sample.distance_m_q30 / Q30 : 0;
    for (int k = 0; k < 3 && f.is_near; k++) f.normal[k] = sample.normal_q30.v[k] / Q30;
    return f;
}

/* For a straight stent of 1.5 mm inner radius, the distances to the struts agree with the closed form to a
 * hundredth of a micrometre: inside, outside and round the edge. */
static void a_straight_shell_is_a_tube_with_a_round_edge(void **state)
{
    (void)state;
    static crn_state s;
    for (uint32_t i = 0; i < RINGS; i++) {
        const crn_strut_order order = ring(i, -700, 1500);
        assert_true(crn_state_strut(&s, &order));
    }
    const crn_strut_state *struts = &s.words.struts;
    double worst_m = 0;
    for (double x = 30.1e-3; x < 48e-3; x += 1.7e-3) {
        for (double rho = 1.0e-3; rho < 2.1e-3; rho += 0.07e-3) {
            for (double turn = 0; turn < 6; turn += 0.7) {
                const double y = rho * cos(turn), z = -0.7e-3 + rho * sin(turn);
                const bool is_inside = rho < 1.5e-3 + thickness_m / 2;
                const felt f = feel(struts, x, y, z);
                assert_true(f.is_near);
                const double expected = is_inside ? rho - 1.5e-3 : 1.5e-3 + thickness_m - rho;
                worst_m = fmax(worst_m, fabs(f.distance_m - expected));
                const double side = is_inside ? -1 : 1;
                worst_m = fmax(worst_m, 1e-3 * fabs(f.normal[1] - side * cos(turn)));
                worst_m = fmax(worst_m, 1e-3 * fabs(f.normal[2] - side * sin(turn)));
            }
        }
    }
    for (double beyond = 0.01e-3; beyond < 0.4e-3; beyond += 0.05e-3) {
        for (double off = -0.3e-3; off < 0.31e-3; off += 0.1e-3) {
            const double edge = thickness_m / 2 - hypot(beyond, off);
            const felt first = feel(struts, 30e-3 - beyond, 1.54e-3 + off, -0.7e-3);
            const felt last = feel(struts, 48e-3 + beyond, 1.54e-3 + off, -0.7e-3);
            worst_m = fmax(worst_m, fmax(fabs(first.distance_m - edge), fabs(last.distance_m - edge)));
            assert_true(first.normal[0] < 0 && last.normal[0] > 0);
            assert_true(fabs(first.normal[1]) > 0.707 && fabs(last.normal[1]) > 0.707);
        }
    }
    print_message("# off by %.4f um at most\n", worst_m * 1e6);
    assert_true(worst_m < 0.05e-6);
    assert_false(feel(struts, 40e-3, 6e-3, 0).is_near);
    assert_false(feel(struts, 27e-3, 1.5e-3, -0.7e-3).is_near);
}

/* The stent of this test lies in a bend of 20 mm radius and widens by a tenth; between its rings, the struts
 * follow the torus. The tolerance allows for the 25 um by which chords of 2 mm deviate from the arc, and for
 * the slope of the cone. */
static void a_bent_shell_follows_its_rings(void **state)
{
    (void)state;
    static crn_state s;
    const double bend_m = 20e-3;
    for (uint32_t i = 0; i < RINGS; i++) {
        const double turn = i * 0.1;
        const crn_strut_order order = {
            i + 1,
            {(int32_t)lround(1e6 * bend_m * sin(turn)), 0, (int32_t)lround(1e6 * bend_m * (1 - cos(turn)))},
            1500 + 15 * i,
            80,
            1};
        assert_true(crn_state_strut(&s, &order));
    }
    double worst_m = 0, least = 1;
    for (double turn = 0.02; turn < 0.88; turn += 0.013) {
        const double inside = 1.5e-3 + 15e-6 * turn / 0.1;
        for (double round = 0; round < 6; round += 0.7) {
            const double rho = inside - 0.1e-3, out = bend_m - rho * cos(round);
            const felt f = feel(&s.words.struts, out * sin(turn), rho * sin(round), bend_m - out * cos(turn));
            assert_true(f.is_near);
            worst_m = fmax(worst_m, fabs(f.distance_m + 0.1e-3));
            const double axis[3] = {-cos(round) * -sin(turn), -sin(round), -cos(round) * cos(turn)};
            double cosine = 0;
            for (int k = 0; k < 3; k++) cosine += f.normal[k] * axis[k];
            least = fmin(least, cosine);
        }
    }
    print_message("# off by %.1f um, normals within %.2f degrees\n", worst_m * 1e6, acos(least) * 180 / pi);
    assert_true(worst_m < 30e-6 && least > cos(3.5 * pi / 180));
}

/* The inside of a conical stent widens by a tenth of its length. Distances are those from a cone, and its
 * normals lean by arctan 0.1. */
static void the_normals_of_a_conical_shell_lean(void **state)
{
    (void)state;
    static crn_state s;
    for (uint32_t i = 0; i < RINGS; i++) {
        const crn_strut_order order = ring(i, 0, 1200 + 200 * i);
        assert_true(crn_state_strut(&s, &order));
    }
    double worst_m = 0, lean = 0;
    for (double x = 30.1e-3; x < 48e-3; x += 1.7e-3) {
        const double rho = 1.2e-3 + 0.1 * (x - 30e-3) - 0.3e-3;
        const felt f = feel(&s.words.struts, x, rho, 0);
        assert_true(f.is_near);
        worst_m = fmax(worst_m, fabs(f.distance_m + 0.3e-3 / sqrt(1.01)));
        lean = fmax(lean, fabs(f.normal[0] - 0.1 / sqrt(1.01)));
    }
    print_message("# off by %.4f um, the normals by %.6f\n", worst_m * 1e6, lean);
    assert_true(worst_m < 0.05e-6 && lean < 1e-5);
}

/* A tool of 0.25 mm radius does not fit into struts of 0.2 mm. Its depth in them is its distance from their
 * axis, so nothing pushes it once it lies on the axis. */
static void a_tool_too_wide_for_the_struts_settles_on_their_axis(void **state)
{
    (void)state;
    static crn_state s;
    for (uint32_t i = 0; i < RINGS; i++) {
        const crn_strut_order order = ring(i, 0, 200);
        assert_true(crn_state_strut(&s, &order));
    }
    for (double rho = 0.01e-3; rho < 0.2e-3; rho += 0.03e-3) {
        const felt f = feel(&s.words.struts, 39e-3, 0, rho);
        assert_true(fabs(f.distance_m + wire_m - rho) < 1e-8 && f.normal[2] < -0.999);
    }
}

/* --- a wire on one side --------------------------------------------------------------------------------- */

/* A force of ten times the wire's weight presses the wire on the inside of the struts; the stent lies in a
 * tube that is wider than the stent. The wire's axis rests at the struts' radius less the wire's radius,
 * apart from the penetration that the weight causes.
 */
static void from_inside_a_wire_rests_on_the_struts_inside(void **state)
{
    (void)state;
    const crn_instrument tool = wire(2e-7, 0.1);
    rig *r = rig_make(&tool, 4e-3, 46000);
    order_stent(r, 0, 1500);
    crn_model_set_gravity(&r->model, 0, 0, -98100);
    run(r, 1500);
    double worst_m = 0;
    uint32_t count = 0;
    for (uint32_t i = 0; i < crn_state_free_count(&r->state); i++) {
        if (!is_in_stent(r, i)) continue;
        const double rho = hypot(place_m(r, i, 1), place_m(r, i, 2));
        worst_m = fmax(worst_m, rho - (1.5e-3 - wire_m));
        count += fabs(rho - (1.5e-3 - wire_m)) < 5e-6;
    }
    print_message("# %u nodes on the struts' inside, at most %.2f um in it\n", count, worst_m * 1e6);
    assert_true(count >= 5 && worst_m < 10e-6);
    free(r);
}

/* In this test the stent lies beneath the wire, which rests on the stent's outer surface. The wire outside
 * the stent is stiffer than the wire in the test of a wire inside the stent. A softer wire would bend between
 * sheath and stent, and its part beyond this bend would lift off the stent. */
static void from_outside_a_wire_rests_on_the_struts_outside(void **state)
{
    (void)state;
    const crn_instrument tool = wire(2e-6, 0.1);
    rig *r = rig_make(&tool, 4e-3, 46000);
    order_stent(r, -2200, 1500);
    crn_model_set_gravity(&r->model, 0, 0, -98100);
    run(r, 1500);
    double worst_m = 0, up_N = 0;
    uint32_t count = 0;
    for (uint32_t i = 0; i < crn_state_free_count(&r->state); i++) {
        if (!is_in_stent(r, i)) continue;
        const double rho = hypot(place_m(r, i, 1), place_m(r, i, 2) + 2.2e-3);
        worst_m = fmax(worst_m, 1.5e-3 + thickness_m + wire_m - rho);
        count += fabs(1.5e-3 + thickness_m + wire_m - rho) < 5e-6;
        crn_vec3 force; /* that callers read: the struts push the wire up */
        if (crn_state_contact_force(&r->model, &r->state, i, &force)) up_N += force.v[2] / 4194304.0;
    }
    print_message("# %u nodes on the struts' outside, at most %.2f um in it\n", count, worst_m * 1e6);
    assert_true(count >= 5 && worst_m < 10e-6);
    print_message("# they bear %.4f N\n", up_N);
    assert_true(up_N > 0);
    free(r);
}

/* One cell of the stent withstands the contact force of one node up to k_c (r + t/2) + k_deep (r + t/2 - 0.2
 * mm), which is 3.25 N in this test. */
static void below_the_force_of_a_cell_it_does_not_go_through(void **state)
{
    (void)state;
    const double middle_m = wire_m + thickness_m / 2, bears_N = 5e3 * middle_m + 2e4 * (middle_m - 0.2e-3);
    const double loads_N[2] = {0.85 * bears_N, 1.3 * bears_N};
    for (int i = 0; i < 2; i++) {
        const crn_instrument tool = wire(1e-6, 0.1);
        rig *r = rig_make(&tool, 4e-3, 40000);
        order_stent(r, 0, 1500);
        for (int t = 1; t <= 200; t++) { /* slowly: 17 mN a tick */
            const double load = loads_N[i] * t / 200;
            crn_model_set_tip_load(&r->model, (crn_vec3){{0, (int32_t)lround(load * 4194304), 0}});
            run(r, 1);
        }
        run(r, 800);
        const double rho = hypot(place_m(r, 0, 1), place_m(r, 0, 2));
        print_message("# under %.2f N its tip is at %.3f mm of 1.5\n", loads_N[i], rho * 1e3);
        assert_true(i == 0 ? rho < 1.5e-3 + thickness_m / 2 : rho > 3e-3);
        free(r);
    }
}

/* With a friction coefficient of 0.3, the tip of the wire touches the end of the stent, head on or off
 * centre; the tip then moves on along one side, inside or outside. */
static void an_end_sends_a_tip_to_one_side(void **state)
{
    (void)state;
    const double offs_m[] = {-0.2e-3, -0.05e-3, -1e-6, 0, 1e-6, 0.05e-3, 0.2e-3};
    for (size_t i = 0; i < sizeof offs_m / sizeof offs_m[0]; i++) {
        const crn_instrument tool = wire(2e-5, 0.3);
        rig *r = rig_make(&tool, 4e-3, 25000);
        crn_model_set_gravity(&r->model, 0, 0, 0);
        order_stent(r, -(int32_t)lround((1.54e-3 + offs_m[i]) * 1e6), 1500);
        double most_N = 0;
        for (int t = 0; t < 900; t++) { /* 18 mm at 20 mm/s */
            r->input.hands[0].feed_m_q30 += (int32_t)(20e-6 * Q30);
            run(r, 1);
            most_N = fmax(most_N, r->output.tools[0].axial_N_q22 / 4194304.0);
        }
        const double axis_m = -(1.54e-3 + offs_m[i]);
        const double rho = hypot(place_m(r, 0, 1), place_m(r, 0, 2) - axis_m);
        print_message("# %+.3f mm: tip at x = %.1f mm, %.3f mm off the axis, hand %.2f N\n", -offs_m[i] * 1e3,
                      place_m(r, 0, 0) * 1e3, rho * 1e3, most_N);
        assert_true(place_m(r, 0, 0) > 42e-3);
        /* offs > 0: the stent is lower, the wire at rho = 1.54 + offs, outside */
        assert_true(offs_m[i] < 0 ? rho < 1.5e-3 : rho > 1.58e-3);
        free(r);
    }
}

/* --- between struts and wall ---------------------------------------------------------------------------- */

/* The wire lies on the wall of a tube of 2 mm radius. Struts whose radius grows from 1.2 to 1.66 mm leave a
 * gap of 0.26 mm for the wire, which is 0.5 mm thick. */
static rig *jailed(double friction)
{
    const crn_instrument tool = wire(1e-6, friction);
    rig *r = rig_make(&tool, 2e-3, 70000);
    run(r, 1500);
    order_stent(r, 0, 1200);
    order_stent(r, 0, 1660);
    run(r, 600);
    return r;
}

static const double squeezed_m = (0.5e-3 - (2e-3 - 1.66e-3 - 0.08e-3)) / 2;

static uint32_t held_nodes(const rig *r, double *worst_m)
{
    uint32_t count = 0;
    for (uint32_t i = 0; i < crn_state_free_count(&r->state); i++) {
        if (!is_in_stent(r, i)) continue;
        const double rho = hypot(place_m(r, i, 1), place_m(r, i, 2));
        *worst_m = fmax(*worst_m, fabs(rho - (1.74e-3 + wire_m - squeezed_m)));
        count++;
    }
    return count;
}

/* The wire rests in the middle of the remaining gap between struts and wall, and does not move for 10,000
 * ticks. */
static void between_struts_and_wall_it_rests_without_chatter(void **state)
{
    (void)state;
    rig *r = jailed(0.1);
    double worst_m = 0;
    const uint32_t count = held_nodes(r, &worst_m);
    double fastest_m = 0;
    for (int t = 0; t < REFERENCE_RUN(10000); t++) {
        run(r, 1);
        for (uint32_t i = 0; i < crn_state_free_count(&r->state); i++)
            for (int k = 0; k < 3 && is_in_stent(r, i); k++)
                fastest_m = fmax(fastest_m, abs(r->state.words.nodes[i].step_m_q33.v[k]) / (8 * Q30));
    }
    print_message("# %u nodes, %.1f um off the middle, at most %.4f um a tick\n", count, worst_m * 1e6,
                  fastest_m * 1e6);
    assert_true(count >= 14 && worst_m < 20e-6 && fastest_m < 0.05e-6);
    free(r);
}

/* When the hand pulls the wire, the wire slips at the friction coefficient times the forces that struts and
 * wall exert on it, and stays outside the stent. */
static void pulling_it_out_needs_friction_on_both_sides(void **state)
{
    (void)state;
    rig *r = jailed(0.1);
    const double one_N = 5e3 * squeezed_m;
    double mean_N = 0, expected_N = 0;
    for (int t = 0; t < 500;
         t++) { /* 5 mm at 10 mm/s; the last of them are examined: nodes are a millimetre apart */
        r->input.hands[0].feed_m_q30 -= (int32_t)(10e-6 * Q30);
        run(r, 1);
        mean_N += t >= 400 ? -r->output.tools[0].axial_N_q22 / 4194304.0 / 100 : 0;
    }
    for (uint32_t i = 0; i < crn_state_free_count(&r->state); i++) {
        const double x = place_m(r, i, 0), rho = hypot(place_m(r, i, 1), place_m(r, i, 2));
        const bool is_between = x > FIRST_um * 1e-6 && x < LAST_um * 1e-6;
        expected_N += is_between ? 0.1 * 2 * one_N : 0;
        assert_true(!is_between || rho > 1.74e-3);
    }
    print_message("# pulled out with %.2f N, friction on both sides %.2f N\n", mean_N, expected_N);
    assert_true(fabs(mean_N - expected_N) < 0.15 * expected_N);
    free(r);
}

/* --- balloon, orders, states ---------------------------------------------------------------------------- */

/* A balloon inside a stent that is narrower than the balloon grows as wide as without the stent, because the
 * host opens the struts. */
static void a_balloon_presses_through(void **state)
{
    (void)state;
    double widest_m[2];
    for (int i = 0; i < 2; i++) {
        crn_instrument tool = reference_wire(2e-5, 200000, 1000, 0.1);
        for (uint32_t k = 0; k < tool.knot_count; k++) tool.knots[k].radius_outer_um = 450;
        tool.balloon = (crn_balloon){.point_count = 2,
                                     .distal_um = 6000,
                                     .proximal_um = 20000,
                                     .burst_kPa = 2000,
                                     .pressure_kPa = {600, 800},
                                     .diameter_um = {3000, 3200}};
        rig *r = rig_make(&tool, 4e-3, 50000);
        if (i == 1) order_stent(r, 0, 1200);
        r->input.inflator_Pa = 800000;
        run(r, 1000);
        widest_m[i] = r->output.balloon_radius_min_m_q30 / Q30;
        r->input.inflator_Pa = 0;
        run(r, 500);
        if (i == 1) assert_int_equal(r->output.contact_count > 0, 1);
        free(r);
    }
    print_message("# %.3f mm without, %.3f mm in struts of 1.2 mm\n", widest_m[0] * 1e3, widest_m[1] * 1e3);
    assert_true(fabs(widest_m[0] - 1.6e-3) < 2e-6 && fabs(widest_m[1] - widest_m[0]) < 2e-6);
}

/* A ring of stent struts moves by 5 um a tick and reaches its commanded position exactly, to the last bit. */
static void a_ring_goes_where_it_is_ordered(void **state)
{
    (void)state;
    const crn_instrument tool = wire(1e-6, 0.1);
    rig *r = rig_make(&tool, 4e-3, 20000);
    order_stent(r, 0, 1200);
    const crn_strut_ring *first = &r->state.words.struts.rings[0];
    assert_int_equal(first->inside_m_q30, lround(1.2e-3 * Q30));
    r->input.strut = ring(0, 100, 1300);
    run(r, 1);
    r->input.strut = (crn_strut_order){0};
    assert_int_equal(first->centre_m_q30.v[2], 5369);
    run(r, 18);
    assert_true(first->centre_m_q30.v[2] < first->wanted_m_q30.v[2]);
    run(r, 2);
    assert_int_equal(first->centre_m_q30.v[2], lround(1e-4 * Q30));
    assert_int_equal(first->inside_m_q30, lround(1.3e-3 * Q30));
    assert_int_equal(r->state.words.struts.moving_bits[0], 0);
    for (uint32_t i = 0; i < RINGS; i++) {
        const crn_strut_order gone = {.number = RINGS - i};
        assert_true(crn_state_strut(&r->state, &gone));
    }
    const crn_strut_state none = {0};
    assert_memory_equal(&r->state.words.struts, &none, sizeof none);
    free(r);
}

static void what_is_no_order_changes_nothing(void **state)
{
    (void)state;
    const crn_instrument tool = wire(1e-6, 0.1);
    rig *r = rig_make(&tool, 4e-3, 20000);
    order_stent(r, 0, 1200);
    const crn_state_words before = r->state.words;
    const crn_strut_order bad[] = {{0, {0, 0, 0}, 0, 0, 0},
                                   {0, {0, 0, 0}, 1500, 80, 0},
                                   {65, {0, 0, 0}, 1500, 80, 0},
                                   {1, {1900001, 0, 0}, 1500, 80, 0},
                                   {1, {0, 0, INT32_MIN}, 1500, 80, 0},
                                   {1, {0, 0, 0}, 199, 80, 0},
                                   {1, {0, 0, 0}, 20001, 80, 0},
                                   {1, {0, 0, 0}, 1500, 9, 0},
                                   {1, {0, 0, 0}, 1500, 1001, 0},
                                   {1, {0, 0, 0}, 1500, 80, 2},
                                   {1, {1, 0, 0}, 0, 0, 0},
                                   {1, {0, 0, 0}, 0, 80, 0},
                                   {65, {0, 0, 0}, 0, 0, 0},
                                   {1, {0, 0, 0}, 0, 0, 1}};
    for (size_t i = 0; i < sizeof bad / sizeof bad[0]; i++) assert_false(crn_state_strut(&r->state, &bad[i]));
    assert_memory_equal(&before, &r->state.words, sizeof before);
    free(r);
}

/* A session that continues from a state saved while struts moved has the same words and hashes as the
 * uninterrupted session. */
static void a_restored_state_goes_on_alike(void **state)
{
    (void)state;
    const crn_instrument tool = wire(1e-6, 0.1);
    rig *a = jailed(0.1), *b = rig_make(&tool, 2e-3, 70000);
    order_stent(a, 0, 1640);
    uint8_t *bytes = malloc(crn_state_bytes());
    crn_state_save(&a->state, bytes);
    assert_true(a->state.words.struts.moving_bits[0] != 0);
    assert_true(crn_state_restore(&b->model, &b->state, bytes));
    assert_true(crn_state_hash64(&a->state) == crn_state_hash64(&b->state));
    for (int t = 0; t < 300; t++) {
        a->input.hands[0].feed_m_q30 = b->input.hands[0].feed_m_q30 = -t * 5000;
        run(a, 1);
        run(b, 1);
        assert_memory_equal(a->output.hash_lane, b->output.hash_lane, sizeof a->output.hash_lane);
    }
    assert_memory_equal(&a->state.words, &b->state.words, sizeof a->state.words);
    const uint64_t hash = crn_state_hash64(&a->state);
    a->state.words.struts.rings[RINGS - 1].thickness_m_q30++;
    assert_true(crn_state_hash64(&a->state) != hash);
    free(bytes);
    free(a);
    free(b);
}

static void damaged_rings_are_not_restored(void **state)
{
    (void)state;
    const crn_instrument tool = wire(1e-6, 0.1);
    rig *r = rig_make(&tool, 4e-3, 20000);
    order_stent(r, 0, 1200);
    const size_t second = offsetof(crn_strut_state, rings) + sizeof(crn_strut_ring),
                 beyond = offsetof(crn_strut_state, rings) + RINGS * sizeof(crn_strut_ring);
    const damaged_word bad[] = {
        {offsetof(crn_strut_state, used), RINGS + 1},
        {offsetof(crn_strut_state, used), RINGS - 1},
        {offsetof(crn_strut_state, used), 65},
        {offsetof(crn_strut_state, joined_bits), 1u << RINGS},
        {offsetof(crn_strut_state, joined_bits) + 4, 1},
        {offsetof(crn_strut_state, moving_bits), 1},
        {second + offsetof(crn_strut_ring, centre_m_q30), 0x80000000u},
        {second + offsetof(crn_strut_ring, inside_m_q30), 1},
        {second + offsetof(crn_strut_ring, inside_m_q30), 0x7fffffffu},
        {second + offsetof(crn_strut_ring, thickness_m_q30), 0},
        {second + offsetof(crn_strut_ring, thickness_m_q30), 0x00ffffffu},
        {beyond + offsetof(crn_strut_ring, thickness_m_q30), 85899},
    };
    refuses_each(&r->model, &r->state, offsetof(crn_state_words, struts), bad, sizeof bad / sizeof bad[0]);
    free(r);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_straight_shell_is_a_tube_with_a_round_edge),
        cmocka_unit_test(a_bent_shell_follows_its_rings),
        cmocka_unit_test(the_normals_of_a_conical_shell_lean),
        cmocka_unit_test(a_tool_too_wide_for_the_struts_settles_on_their_axis),
        cmocka_unit_test(from_inside_a_wire_rests_on_the_struts_inside),
        cmocka_unit_test(from_outside_a_wire_rests_on_the_struts_outside),
        cmocka_unit_test(below_the_force_of_a_cell_it_does_not_go_through),
        cmocka_unit_test(an_end_sends_a_tip_to_one_side),
        cmocka_unit_test(between_struts_and_wall_it_rests_without_chatter),
        cmocka_unit_test(pulling_it_out_needs_friction_on_both_sides),
        cmocka_unit_test(a_balloon_presses_through),
        cmocka_unit_test(a_ring_goes_where_it_is_ordered),
        cmocka_unit_test(what_is_no_order_changes_nothing),
        cmocka_unit_test(a_restored_state_goes_on_alike),
        cmocka_unit_test(damaged_rings_are_not_restored),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
