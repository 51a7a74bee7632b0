/* These tests check walls that give way (firmware/core/wall, docs/walls.md). A rod lies in a tube that fits
 * it closely, so that the closed forms of a beam on an elastic bed hold: the rod presses on the wall with the
 * force f per length, and the bed of stiffness k gives by f / k. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "firmware/core/lesion.h"
#include "firmware/core/rod.h"
#include "firmware/tests/reference/long_run.h"
#include "firmware/tests/reference/random_hands.h"
#include "firmware/tests/reference/rod_rig.h"

static const double Q30 = 1073741824.0, Q22 = 4194304.0;
static const double SPACING_m = 0.0078125;

enum { ROD_um = 500000, ELEMENT_um = 2000, RELAX_ms = 100, BED_N_m2 = 10000, RADIAL_N_m2 = 200000 };

/* A lumen whose bricks all have law 1, or law 0 beyond the plane x = `rigid_from_m`. */
typedef struct soft_lumen {
    reference_tube *tube;
    crn_lumen lumen;
    crn_walls walls;
    crn_wall_law law;
    uint8_t *law_of_brick;
} soft_lumen;

static const crn_wall_law usual = {BED_N_m2, RADIAL_N_m2, RELAX_ms, 0, 20000, 4000, {0, 0}};

static soft_lumen *soft_make(reference_tube *tube, crn_wall_law law, double rigid_from_m)
{
    soft_lumen *soft = calloc(1, sizeof *soft);
    soft->tube = tube;
    soft->lumen = tube->lumen;
    soft->law = law;
    const uint32_t *n = tube->lumen.brick_count_xyz;
    soft->law_of_brick = calloc((size_t)n[0] * n[1] * n[2], 1);
    for (uint32_t i = 0; i < n[0] * n[1] * n[2]; i++) {
        const double x_m = tube->lumen.origin_m_q30[0] / Q30 + (i % n[0]) * SPACING_m;
        soft->law_of_brick[i] = x_m < rigid_from_m;
    }
    soft->walls = (crn_walls){1, &soft->law, soft->law_of_brick};
    soft->lumen.walls = &soft->walls;
    return soft;
}

static soft_lumen *straight(double length_m, double radius_m, crn_wall_law law)
{
    const reference_piece piece = {length_m, 0, 0};
    return soft_make(reference_tube_make(&piece, 1, radius_m, 1), law, 10);
}

static void soft_free(soft_lumen *soft)
{
    reference_tube_free(soft->tube);
    free(soft->law_of_brick);
    free(soft);
}

/* A heavy rod of 0.9 mm radius. */
static crn_instrument rod_of(double bend_N_m2)
{
    crn_instrument rod = reference_wire(bend_N_m2, ROD_um, ELEMENT_um, 0);
    for (uint32_t i = 0; i < rod.knot_count; i++) {
        rod.knots[i].radius_outer_um = 900;
        rod.knots[i].mass_mg_per_m = 50000;
    }
    return rod;
}

static rig *rig_in(const soft_lumen *soft, const crn_instrument *rod, uint32_t inserted_um)
{
    rig *r = rig_make(rod, &soft->lumen, inserted_um);
    crn_model_set_gravity(&r->model, 0, 0, 0);
    return r;
}

static void settle(rig *r, int ticks)
{
    for (int t = 0; t < ticks; t++) rig_step(r);
    assert_int_equal(r->output.fault_bits & CRN_FAULT_SATURATED, 0);
}

static double way_m(const rig *r, double arc_m, int axis)
{
    return crn_wall_give_at(&r->state.words.wall, (int32_t)(arc_m * Q30)).way_m_q30.v[axis] / Q30;
}

static double widening_m(const rig *r, double arc_m)
{
    return crn_wall_give_at(&r->state.words.wall, (int32_t)(arc_m * Q30)).widen_m_q30 / Q30;
}

static void load_tip(rig *r, double newton)
{
    crn_model_set_tip_load(&r->model, (crn_vec3){{0, 0, (int32_t)lround(newton * Q22)}});
}

/* The weight in blood, in N/m, of the rod's steady part. */
static double weight_N_m(const rig *r, double m_s2)
{
    return r->state.line.nodes[50].weight_kg_q40 / exp2(40) / (1e-6 * ELEMENT_um) * m_s2;
}

/* Lays the rod on the upper wall. */
static rig *on_the_wall(const soft_lumen *soft, double bend_N_m2)
{
    const crn_instrument rod = rod_of(bend_N_m2);
    rig *r = rig_in(soft, &rod, 400000);
    crn_model_set_gravity(&r->model, 0, 0, 100000);
    return r;
}

/* A rod that lies on the wall by its weight alone presses with the same force per length everywhere, so the
 * wall gives by f / k and widens by f / k_w. The ends are left out: the sheath holds the vessel there. */
static void weight_sinks_by_force_over_stiffness(void **context)
{
    (void)context;
    crn_wall_law law = usual;
    law.carry_um = 20000; /* carries nothing where all neighbours give alike */
    soft_lumen *soft = straight(0.45, 0.002, law);
    rig *r = on_the_wall(soft, 0.0001);
    settle(r, 6000);
    const double per_m = weight_N_m(r, 100), way = way_m(r, 0.1, 2), widened = widening_m(r, 0.1);
    print_message("# %.3f N/m: way %.2f um, f / k %.2f um; widened %.3f um, f / k_w %.3f um\n", per_m,
                  way * 1e6, per_m / BED_N_m2 * 1e6, widened * 1e6, per_m / RADIAL_N_m2 * 1e6);
    check_below("way", fabs(way * BED_N_m2 / per_m - 1), 0.01);
    check_below("widening", fabs(widened * RADIAL_N_m2 / per_m - 1), 0.005);
    assert_true(fabs(way_m(r, 0.4, 2)) < way / 2);
    free(r);
    soft_free(soft);
}

/* A law holds where its bricks are: the rod's distal part lies in a rigid part of the vessel. The bed carries
 * nothing along, so a station's law decides alone, except within a spacing of the border. */
static void a_law_holds_in_its_bricks(void **context)
{
    (void)context;
    const reference_piece piece = {0.45, 0, 0};
    soft_lumen *soft = soft_make(reference_tube_make(&piece, 1, 0.002, 1), usual, 0.2);
    rig *r = on_the_wall(soft, 0.0001);
    settle(r, 4000);
    const double expected_m = weight_N_m(r, 100) / BED_N_m2;
    check_below("rigid", fabs(way_m(r, 0.4 - 0.25, 2)), 1e-6);
    check_below("soft", fabs(way_m(r, 0.4 - 0.1, 2) / expected_m - 1), 0.01);
    free(r);
    soft_free(soft);
}

/* A rod on a wall that widens and does not move aside sinks by the widening. */
static void a_rod_sinks_by_the_widening_of_its_wall(void **context)
{
    (void)context;
    crn_wall_law law = usual;
    law.bed_N_m2 = 0;
    law.radial_N_m2 = 10000;
    double z_m[2];
    soft_lumen *soft[2] = {straight(0.45, 0.002, usual), straight(0.45, 0.002, law)};
    soft[0]->lumen.walls = NULL;
    double widened_m = 0;
    for (int i = 0; i < 2; i++) {
        rig *r = on_the_wall(soft[i], 0.0001);
        settle(r, 4000);
        z_m[i] = crn_state_position(&r->state, 100).v[2] / Q30;
        widened_m = widening_m(r, 0.2);
        free(r);
        soft_free(soft[i]);
    }
    print_message("# sinks by %.2f um, widened by %.2f um\n", (z_m[1] - z_m[0]) * 1e6, widened_m * 1e6);
    check_below("widening", fabs(widened_m / 500e-6 - 1), 0.005);
    check_below("sinking", fabs((z_m[1] - z_m[0]) / widened_m - 1), 0.015);
}

/* Hetenyi, "Beams on Elastic Foundation" (1946): a half-infinite beam with a force P across its end sinks by
 * 2 P beta / k exp(-beta x) cos(beta x) at the distance x; beta^4 = k / (4 EI). The rod's weight keeps it on
 * the wall where the beam would lift, and adds f / k everywhere. */
static void a_stiff_rod_bends_its_vessel_like_a_beam_on_a_bed(void **context)
{
    (void)context;
    const double bend_N_m2 = 0.01, load_N = 1, beta = pow(BED_N_m2 / (4 * bend_N_m2), 0.25);
    crn_wall_law law = usual;
    law.radial_N_m2 = 0;
    soft_lumen *soft = straight(0.45, 0.002, law);
    rig *r = on_the_wall(soft, bend_N_m2);
    load_tip(r, load_N);
    settle(r, 6000);
    const double end_m = 2 * load_N * beta / BED_N_m2, everywhere_m = weight_N_m(r, 100) / BED_N_m2;
    for (double x_m = 0; x_m < 0.145; x_m += 0.02) {
        const double expected_m = everywhere_m + end_m * exp(-beta * x_m) * cos(beta * x_m);
        print_message("# %3.0f mm behind the tip: way %.3f mm, beam on a bed %.3f mm\n", x_m * 1e3,
                      way_m(r, x_m, 2) * 1e3, expected_m * 1e3);
        check_below("way", fabs(way_m(r, x_m, 2) - expected_m), 0.025 * end_m);
    }
    free(r);
    soft_free(soft);
}

/* A rod on the axis of a wide tube, which it does not touch. */
static rig *in_wide_tube(crn_wall_law law, soft_lumen **soft)
{
    const crn_instrument rod = rod_of(0.01);
    *soft = straight(0.45, 0.006, law);
    return rig_in(*soft, &rod, 400000);
}

/* An unloaded wall goes back by the implicit step for exp(-t / tau). */
static void an_unloaded_wall_goes_back_in_the_time_of_its_tissue(void **context)
{
    (void)context;
    soft_lumen *soft;
    rig *r = in_wide_tube(usual, &soft);
    crn_wall_state *wall = &r->state.words.wall;
    wall->used = 20;
    for (uint32_t j = 0; j < wall->used; j++)
        wall->stations[j] = (crn_wall_give){{{0, (int32_t)(0.001 * Q30), 0}}, (int32_t)(0.0005 * Q30)};
    settle(r, RELAX_ms);
    const double expected = pow(1 + 1.0 / RELAX_ms, -RELAX_ms);
    const double way = way_m(r, 0.05, 1) / 0.001, widened = widening_m(r, 0.05) / 0.0005;
    print_message("# after tau: way %.5f, widening %.5f, expected %.5f\n", way, widened, expected);
    check_below("way", fabs(way - expected), 3e-5);
    check_below("widening", fabs(widened - expected), 3e-5);
    settle(r, 20 * RELAX_ms);
    assert_int_equal(wall->used, 0);
    free(r);
    soft_free(soft);
}

/* Puts contacts of 0.1 mm, which are 0.5 N each, at nodes of the rod, and lets only the walls take a step. */
static void press(rig *r, const uint32_t *nodes, const int *signs, uint32_t count, int ticks)
{
    for (uint32_t i = 0; i < r->state.words.free_count; i++) r->state.scratch.nodes[i].touching = 0;
    for (uint32_t n = 0; n < count; n++) {
        crn_work *work = &r->state.scratch.nodes[nodes[n]];
        work->touching = 1;
        work->depth_m_q30 = (int32_t)(0.0001 * Q30);
        work->solution_m_q33 = (crn_vec3){{0, 0, 0}};
        work->normal_q30 = (crn_vec3){{0, 0, -signs[n] * CRN_ONE_Q30}};
    }
    for (int t = 0; t < ticks; t++) crn_wall_step(&r->model, &r->state);
}

/* A string on a bed, loaded at one station: u(n) = P / (k l sqrt(1 + 4 c)) q^|n| with c = T / (k l^2) and q
 * the root of c q^2 - (1 + 2 c) q + c = 0 that is below 1. A node between two stations loads both. */
static void a_vessel_carries_a_way_along_itself_like_a_string_on_a_bed(void **context)
{
    (void)context;
    enum { NODE = 98 }; /* 196 mm: between stations 25 and 26 */
    crn_wall_law law = usual;
    law.carry_um = 15000;
    soft_lumen *soft;
    rig *r = in_wide_tube(law, &soft);
    press(r, (const uint32_t[]){NODE}, (const int[]){1}, 1, 4000);
    const double c = pow(0.015 / SPACING_m, 2), root = sqrt(1 + 4 * c), q = (1 + 2 * c - root) / (2 * c);
    const double unit_m = 0.5 / (BED_N_m2 * SPACING_m * root), share = 0.196 / SPACING_m - 25;
    for (int j = 20; j < 32; j++) {
        const double expected_m = unit_m * ((1 - share) * pow(q, abs(j - 25)) + share * pow(q, abs(j - 26)));
        const double found_m = r->state.words.wall.stations[j].way_m_q30.v[2] / Q30;
        if (j > 24 && j < 29)
            print_message("# station %d: %.4f mm, string %.4f mm\n", j, found_m * 1e3, expected_m * 1e3);
        check_below("way", fabs(found_m - expected_m), 1.5e-6); /* a tick moves by whole nanometres */
    }
    free(r);
    soft_free(soft);
}

/* Two opposite forces at one place do not move the vessel; they only widen it, by both of them. */
static void opposite_forces_widen_a_vessel_and_do_not_move_it(void **context)
{
    (void)context;
    soft_lumen *soft;
    rig *r = in_wide_tube(usual, &soft);
    press(r, (const uint32_t[]){98, 98 + 1}, (const int[]){1, -1}, 1, 3000);
    const double alone_m = widening_m(r, 0.196);
    free(r);
    soft_free(soft);
    r = in_wide_tube(usual, &soft);
    /* nodes as far to the left and to the right of station 32 load it alike */
    press(r, (const uint32_t[]){124, 126}, (const int[]){1, -1}, 2, 3000);
    const crn_wall_give *at = &r->state.words.wall.stations[32];
    const double shares = 2 - fabs(0.248 / SPACING_m - 32) - fabs(0.252 / SPACING_m - 32);
    check_below("way", fabs(at->way_m_q30.v[2] / Q30), 1e-9);
    const double expected_m = shares * 0.5 / (RADIAL_N_m2 * SPACING_m);
    print_message("# widened %.2f um, expected %.2f um\n", at->widen_m_q30 / Q30 * 1e6, expected_m * 1e6);
    check_below("widening", fabs(at->widen_m_q30 / Q30 / expected_m - 1), 1e-3);
    assert_true(alone_m > 0);
    free(r);
    soft_free(soft);
}

/* The way belongs to the vessel: while the tip advances by four spacings, it gets four stations behind. */
static void a_way_stays_at_its_place_of_the_vessel_while_the_tip_moves(void **context)
{
    (void)context;
    crn_wall_law law = usual;
    law.relax_ms = 10000;
    for (int back = 0; back < 2; back++) {
        soft_lumen *soft;
        rig *r = in_wide_tube(law, &soft);
        crn_wall_state *wall = &r->state.words.wall;
        wall->used = 22;
        wall->stations[20].way_m_q30.v[1] = wall->stations[21].way_m_q30.v[1] = (int32_t)(0.001 * Q30);
        for (int t = 0; t < 1000; t++) {
            r->input.hands[0].feed_m_q30 += (back ? -1 : 1) * (int32_t)lround(4 * SPACING_m * Q30 / 1000);
            rig_step(r);
        }
        double sum = 0, moment = 0;
        for (uint32_t j = 0; j < wall->used; j++) {
            sum += wall->stations[j].way_m_q30.v[1];
            moment += j * (double)wall->stations[j].way_m_q30.v[1];
        }
        print_message("# the way's middle is at station %.3f; inserted %.2f mm\n", moment / sum,
                      crn_state_inserted(&r->state, 0) / Q30 * 1e3);
        check_below("middle", fabs(moment / sum - (back ? 16.5 : 24.5)), 0.04);
        free(r);
        soft_free(soft);
    }
}

/* No force moves a wall farther than its law allows. */
static void a_wall_gives_no_farther_than_its_law_allows(void **context)
{
    (void)context;
    crn_wall_law law = usual;
    law.way_max_um = 3000;
    law.widen_max_um = 200;
    soft_lumen *soft = straight(0.45, 0.002, law);
    rig *r = on_the_wall(soft, 0.01);
    load_tip(r, 10);
    settle(r, 10000);
    print_message("# 10 N: way %.4f mm of 3, widening %.4f mm of 0.2\n", way_m(r, 0, 2) * 1e3,
                  widening_m(r, 0) * 1e3);
    check_below("way", fabs(way_m(r, 0, 2) / 0.003 - 1), 1e-3);
    check_below("widening", fabs(widening_m(r, 0) / 0.0002 - 1), 1e-3);
    free(r);
    soft_free(soft);
}

/* Pushes a wire with a soft tip through three bends. */
static rig *in_three_bends(const soft_lumen *soft)
{
    const crn_instrument wire = reference_floppy_j(1e-3);
    return rig_make(&wire, &soft->lumen, 20000);
}

static void push(rig *r, int ticks)
{
    for (int t = 0; t < ticks; t++) {
        r->input.hands[0].feed_m_q30 += 107374; /* 100 mm/s */
        rig_step(r);
    }
}

static void rigid_bricks_give_the_hashes_of_a_lumen_without_walls(void **context)
{
    (void)context;
    soft_lumen *rigid = soft_make(reference_three_bends(0.004, 1), usual, -10);
    soft_lumen *none = soft_make(reference_three_bends(0.004, 1), usual, -10);
    none->lumen.walls = NULL;
    rig *a = in_three_bends(rigid), *b = in_three_bends(none);
    for (int i = 0; i < 40; i++) {
        push(a, 100);
        push(b, 100);
        assert_true(crn_state_hash64(&a->state) == crn_state_hash64(&b->state));
        assert_memory_equal(a->output.hash_lane, b->output.hash_lane, sizeof a->output.hash_lane);
    }
    assert_true(a->output.contact_count > 10);
    free(a);
    free(b);
    soft_free(rigid);
    soft_free(none);
}

static void a_restored_state_goes_on_with_the_same_hashes(void **context)
{
    (void)context;
    crn_wall_law law = usual;
    law.carry_um = 10000;
    soft_lumen *soft = soft_make(reference_three_bends(0.004, 1), law, 0.5);
    rig *r = in_three_bends(soft), *other = in_three_bends(soft);
    push(r, 4000);
    assert_true(r->state.words.wall.used > 10);
    uint8_t *bytes = calloc(1, crn_state_bytes());
    crn_state_save(&r->state, bytes);
    assert_true(crn_state_restore(&other->model, &other->state, bytes));
    other->input = r->input;
    for (int t = 0; t < 1000; t++) {
        push(r, 1);
        push(other, 1);
        assert_true(crn_state_hash64(&r->state) == crn_state_hash64(&other->state));
    }
    /* Each way, its bound and what lies behind the last station are checked, and a rigid lumen takes none. */
    const size_t wall = offsetof(crn_state_words, wall), way = wall + offsetof(crn_wall_state, stations);
    const size_t behind = way + sizeof(crn_wall_give) * r->state.words.wall.used;
    const size_t widen = way + offsetof(crn_wall_give, widen_m_q30);
    const struct {
        size_t at;
        uint8_t value;
    } wrong[] = {{way + 3, 0x7f}, {way + 3, 0x80}, {widen + 3, 0x80}, {widen + 3, 1},
                 {wall, 193},     {wall + 3, 1},   {behind, 1}};
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; i++) {
        const uint8_t old = bytes[wrong[i].at];
        bytes[wrong[i].at] = wrong[i].value;
        if (crn_state_restore(&other->model, &other->state, bytes)) fail_msg("wrong state %zu is taken", i);
        bytes[wrong[i].at] = old;
    }
    assert_true(crn_state_restore(&other->model, &other->state, bytes));
    other->model.lumen = &soft->tube->lumen;
    assert_false(crn_state_restore(&other->model, &other->state, bytes));
    free(bytes);
    free(r);
    free(other);
    soft_free(soft);
}

/* A stiff wire is bent less in a vessel that gives way, and the less the softer the bed; it also takes less
 * force. The bend is the integral of the wire's squared curvature, twice its energy over EI. */
static double bend_of_stiff_wire(uint32_t bed_N_m2, double *force_N)
{
    crn_wall_law law = usual;
    law.bed_N_m2 = bed_N_m2;
    law.radial_N_m2 = 0;
    law.carry_um = 10000;
    const reference_piece bend[] = {{0.1, 0, 0}, {0.1, 1, 0}, {0.25, 0, 0}};
    soft_lumen *soft = soft_make(reference_tube_make(bend, 3, 0.003, 1), law, bed_N_m2 > 0 ? 10 : -10);
    crn_instrument wire = reference_floppy_j(5e-3);
    for (int i = 0; i < 4; i++)
        wire.knots[i].friction_kinetic_milli = wire.knots[i].friction_static_milli = 30;
    rig *r = rig_make(&wire, &soft->lumen, 20000);
    push(r, 3300);
    settle(r, 2000);
    *force_N = 0;
    for (int t = 0; t < 500; t++) {
        r->input.hands[0].feed_m_q30 += 10737; /* 10 mm/s */
        rig_step(r);
        *force_N += r->output.tools[0].axial_N_q22 / Q22 / 500;
    }
    double bend_per_m = 0;
    for (uint32_t i = 1; i + 1 < r->state.words.free_count; i++) {
        double dot = 0;
        for (int k = 0; k < 3; k++)
            dot += (double)r->state.words.nodes[i].tangent_q30.v[k] *
                   r->state.words.nodes[i - 1].tangent_q30.v[k] / Q30 / Q30;
        if (crn_model_arc(&r->model, i) / Q30 > 0.06)
            bend_per_m += pow(acos(fmin(1, dot)), 2) / (crn_model_edge_length(&r->model, i) / Q30);
    }
    free(r);
    soft_free(soft);
    return bend_per_m;
}

static void a_stiff_wire_straightens_a_vessel_that_gives_way(void **context)
{
    (void)context;
    double force_N[3];
    const double rigid = bend_of_stiff_wire(0, &force_N[0]), firm = bend_of_stiff_wire(80000, &force_N[1]),
                 soft = bend_of_stiff_wire(20000, &force_N[2]);
    print_message(
        "# bend of the wire: rigid %.1f / m and %.2f N, 80 kPa %.1f / m and %.2f N, 20 kPa %.1f / m "
        "and %.2f N\n",
        rigid, force_N[0], firm, force_N[1], soft, force_N[2]);
    assert_true(firm < 0.97 * rigid);
    assert_true(soft < 0.9 * firm);
    assert_true(force_N[2] < force_N[1] && force_N[1] < force_N[0]);
}

/* The bounds are those of rigid walls (test_tools.c, test_set.c). */
static void random_hands_keep_yielding_tools_in_a_vessel_that_gives_way(void **context)
{
    (void)context;
    reference_hands_result result = {0};
    for (uint32_t i = 0; i < 2; i++)
        reference_random_hands(3, REFERENCE_HANDS_WITH_WALLS + i, REFERENCE_RUN(6000), &result);
    print_message("# %d ticks: depth %.2f mm, length error %.3f %%, way %.1f mm, %d saturated\n",
                  result.ticks, result.depth_max_mm, result.strain_max_pct, result.way_max_mm,
                  result.saturated);
    assert_int_equal(result.saturated, 0);
    assert_int_equal(result.deep, 0);
    assert_int_equal(result.long_045, 0);
    assert_true(result.way_max_mm > 2);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(weight_sinks_by_force_over_stiffness),
        cmocka_unit_test(a_law_holds_in_its_bricks),
        cmocka_unit_test(a_rod_sinks_by_the_widening_of_its_wall),
        cmocka_unit_test(a_stiff_rod_bends_its_vessel_like_a_beam_on_a_bed),
        cmocka_unit_test(an_unloaded_wall_goes_back_in_the_time_of_its_tissue),
        cmocka_unit_test(a_vessel_carries_a_way_along_itself_like_a_string_on_a_bed),
        cmocka_unit_test(opposite_forces_widen_a_vessel_and_do_not_move_it),
        cmocka_unit_test(a_way_stays_at_its_place_of_the_vessel_while_the_tip_moves),
        cmocka_unit_test(a_wall_gives_no_farther_than_its_law_allows),
        cmocka_unit_test(rigid_bricks_give_the_hashes_of_a_lumen_without_walls),
        cmocka_unit_test(a_restored_state_goes_on_with_the_same_hashes),
        cmocka_unit_test(a_stiff_wire_straightens_a_vessel_that_gives_way),
        cmocka_unit_test(random_hands_keep_yielding_tools_in_a_vessel_that_gives_way),
    };
    cmocka_set_message_output(CM_OUTPUT_TAP);
    return cmocka_run_group_tests(tests, NULL, NULL);
}
