/* These tests check what a bend leaves in a tool (rod_set.c; docs/rod.md, "Materials"). A cantilever in free
 * space bears a slowly changing load across its tip. The closed forms are those of small deflections: the
 * moment at the distance x from the tip is P x, and beyond the yield curvature k_y the curvature grows 1 / h
 * times as fast. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "firmware/core/rod.h"
#include "firmware/tests/reference/long_run.h"
#include "firmware/tests/reference/random_hands.h"
#include "firmware/tests/reference/rod_rig.h"

static const double Q30 = 1073741824.0, Q22 = 4194304.0;
static const double FREE_m = 0.1, HARDENING = 0.5, UNLOAD = 0.5, LIMIT = 0.25;
static const double WIRE_N_m2 = 2e-4, WIRE_YIELD_per_m = 5; /* the material of all wires */

enum { MODULUS_MPa = 60000, TOOL_um = 300000, FREE_um = 100000, ELEMENT_um = 2000, RAMP_ticks = 4000 };

static double core_radius_m(void)
{
    return pow(4 * WIRE_N_m2 / (3.14159265358979 * 1e6 * MODULUS_MPa), 0.25);
}

static crn_instrument wire_of(uint32_t kind, double bend_N_m2)
{
    crn_instrument tool = {.knot_count = 2,
                           .axial_stiffness_max_N = 3000,
                           .element_tip_um = ELEMENT_um,
                           .element_shaft_um = ELEMENT_um,
                           .material = {kind, (uint32_t)lround(1e6 * WIRE_YIELD_per_m * core_radius_m()),
                                        MODULUS_MPa, (uint32_t)lround(1000 * HARDENING), 0, 0}};
    if (kind == CRN_ELASTIC) tool.material = (crn_material){0};
    if (kind == CRN_SUPERELASTIC) {
        tool.material.unload_milli = (uint32_t)lround(1000 * UNLOAD);
        tool.material.limit_milli = (uint32_t)lround(1000 * LIMIT);
    }
    for (int i = 0; i < 2; i++)
        tool.knots[i] = (crn_knot){.arc_um = i == 0 ? 0 : TOOL_um,
                                   .bend_stiffness_nN_m2 = (uint32_t)lround(1e9 * bend_N_m2),
                                   .twist_stiffness_nN_m2 = (uint32_t)lround(1e9 * bend_N_m2),
                                   .mass_mg_per_m = 500,
                                   .radius_outer_um = 178};
    return tool;
}

static rig *cantilever_of(crn_instrument tool)
{
    const uint32_t inserted_um[CRN_TOOL_MAX] = {FREE_um};
    rig *r = calloc(1, sizeof *r);
    crn_entry entry = reference_entry();
    crn_build_place place;
    assert_int_equal(crn_model_build(&r->model, &tool, 1, NULL, &entry, &place), CRN_BUILD_OK);
    crn_state_init(&r->model, &r->state, inserted_um);
    crn_model_set_gravity(&r->model, 0, 0, 0);
    return r;
}

static rig *cantilever(uint32_t kind)
{
    return cantilever_of(wire_of(kind, WIRE_N_m2));
}

/* Changes the load across the tip, along the base's first axis turned by an angle, from one to another, and
 * lets the wire come to rest. */
static void load_tip(rig *r, double from_N, double to_N, double turned_rad)
{
    for (int t = 0; t < RAMP_ticks; t++) {
        const double load_N = from_N + (to_N - from_N) * fmin(1, t / (0.75 * RAMP_ticks));
        crn_vec3 load_N_q22;
        for (int k = 0; k < 3; k++)
            load_N_q22.v[k] = (int32_t)lround(Q22 * load_N *
                                              (cos(turned_rad) * r->model.base_axis1_q30.v[k] +
                                               sin(turned_rad) * r->model.base_axis2_q30.v[k]) /
                                              Q30);
        crn_model_set_tip_load(&r->model, load_N_q22);
        rig_step(r);
    }
}

static const double yield_N = 2e-4 * 5 / 0.1; /* of WIRE_N_m2 */

static double tip_m(const rig *r, double turned_rad)
{
    double across = 0;
    for (int k = 0; k < 3; k++)
        across += (r->state.words.nodes[0].position_m_q30.v[k] - r->model.entry.position_m_q30.v[k]) / Q30 *
                  (cos(turned_rad) * r->model.base_axis1_q30.v[k] +
                   sin(turned_rad) * r->model.base_axis2_q30.v[k]) /
                  Q30;
    return across;
}

/* --- the reference: the same cantilever as a continuum with large deflections, by iteration ------------- */

enum { STATIONS = 2000 };

typedef struct reference {
    uint32_t kind;
    double bend_N_m2, yield_per_m;
    double elastic_from_m;      /* the parts of two cells at the sheath do not yield */
    double set_per_m[STATIONS]; /* by the distance from the tip */
} reference;

/* The set under an elastic curvature whose moment rises or falls monotonically to its new value. */
static double follow_set(const reference *f, double elastic_per_m, double set_per_m)
{
    const double slope = HARDENING / (1 - HARDENING);
    /* forward: e = k_y + g set; on the way back: e = r k_y + g set */
    const double forward = (elastic_per_m - f->yield_per_m) / slope;
    const double back = f->kind == CRN_SUPERELASTIC ? (elastic_per_m - UNLOAD * f->yield_per_m) / slope
                                                    : (elastic_per_m + f->yield_per_m) / slope;
    const double set = fmax(forward, fmin(back, set_per_m));
    return f->kind == CRN_SUPERELASTIC ? fmin(fmax(set, 0), LIMIT * f->yield_per_m) : set;
}

/* Changes the load; returns the deflection of the tip along it. */
static double reference_load(reference *f, double load_N)
{
    static double along_m[STATIONS], set_per_m[STATIONS]; /* distance along the sheath's axis */
    const double step_m = FREE_m / STATIONS;
    double tip = 0;
    for (int i = 0; i < STATIONS; i++) along_m[i] = FREE_m - (i + 0.5) * step_m;
    for (int round = 0; round < 60; round++) {
        double angle = 0, along = 0, across = 0;
        const double tip_along_m = along_m[0];
        for (int i = STATIONS - 1; i >= 0; i--) {
            const double elastic = load_N * (tip_along_m - along_m[i]) / f->bend_N_m2;
            set_per_m[i] = f->set_per_m[i];
            if ((i + 0.5) * step_m < f->elastic_from_m)
                set_per_m[i] = follow_set(f, elastic, f->set_per_m[i]);
            angle += (elastic + set_per_m[i]) * step_m;
            along += cos(angle) * step_m;
            across += sin(angle) * step_m;
            along_m[i] = along;
        }
        tip = across;
    }
    memcpy(f->set_per_m, set_per_m, sizeof set_per_m);
    return tip;
}

static reference reference_of(const rig *r, uint32_t kind)
{
    return (reference){.kind = kind,
                       .bend_N_m2 = WIRE_N_m2,
                       .yield_per_m = WIRE_YIELD_per_m,
                       .elastic_from_m = r->model.mesh[r->state.words.free_count - 2].cell_end_m_q30 / Q30};
}

/* Takes the load through a list of values, in parts of the load at yield, and compares with the reference. */
static void follow_loads(uint32_t kind, const double *parts, int count, double bar_m)
{
    rig *r = cantilever(kind);
    reference f = reference_of(r, kind);
    double last = 0;
    for (int i = 0; i < count; i++) {
        load_tip(r, last * yield_N, parts[i] * yield_N, 0.4);
        last = parts[i];
        const double expected_m = reference_load(&f, parts[i] * yield_N);
        if (!(fabs(tip_m(r, 0.4) - expected_m) <= bar_m))
            fail_msg("load %d, %.2f of the load at yield: the tip is off by %.4f mm, expected %.4f mm", i,
                     parts[i], 1e3 * tip_m(r, 0.4), 1e3 * expected_m);
    }
    free(r);
}

static void a_metal_wire_yields_and_keeps_its_set(void **context)
{
    (void)context;
    static const double parts[] = {0.97, 0, 1.6, 0, 1.5, 0, -0.6, -1.6, 0};
    follow_loads(CRN_PLASTIC, parts, 9, 8e-5);
}

static void nitinol_comes_back_on_a_lower_branch(void **context)
{
    (void)context;
    static const double parts[] = {0.97, 1.3, 1.6, 1.4, 1.2, 1.0, 0.8, 1.4, 0.6, 0.4, 0};
    follow_loads(CRN_SUPERELASTIC, parts, 11, 8e-5);
}

/* Deflections agree within 0.03 mm of 28 mm; the bars above stand at 0.08 mm. */

/* Below the yield no word of a set changes, so the hash is that of an elastic wire. */
static void below_the_yield_a_metal_wire_is_elastic(void **context)
{
    (void)context;
    rig *metal = cantilever(CRN_PLASTIC), *elastic = cantilever(CRN_ELASTIC);
    load_tip(metal, 0, 0.97 * yield_N, 0.4);
    load_tip(elastic, 0, 0.97 * yield_N, 0.4);
    assert_true(crn_state_hash64(&metal->state) == crn_state_hash64(&elastic->state));
    load_tip(metal, 0.97 * yield_N, 1.1 * yield_N, 0.4);
    assert_true(metal->state.words.set.used_bits == 1);
    free(metal);
    free(elastic);
}

/* The set turns with the wire: a hand that turns by half a turn moves the tip of a bent wire to the other
 * side.
 */
static void a_set_turns_with_the_hand(void **context)
{
    (void)context;
    rig *r = cantilever(CRN_PLASTIC);
    load_tip(r, 0, 1.6 * yield_N, 0.4);
    load_tip(r, 1.6 * yield_N, 0, 0.4);
    const double before_m = tip_m(r, 0.4);
    for (int t = 0; t < 4000; t++) {
        if (t < 1000) r->input.hands[0].turn32 += (1u << 31) / 1000;
        rig_step(r);
    }
    if (fabs(tip_m(r, 0.4) + before_m) > 0.03 * before_m)
        fail_msg("turned by half a turn, the tip is off by %.4f mm; it was off by %.4f mm",
                 1e3 * tip_m(r, 0.4), 1e3 * before_m);
    free(r);
}

/* A state that is saved while the wire yields, and restored into another rig, goes on with the same hashes.
 */
static void a_restored_state_goes_on_with_the_same_hashes(void **context)
{
    (void)context;
    rig *r = cantilever(CRN_SUPERELASTIC), *other = cantilever(CRN_SUPERELASTIC);
    load_tip(r, 0, 1.4 * yield_N, 0.4);
    uint8_t *bytes = calloc(1, crn_state_bytes());
    crn_state_save(&r->state, bytes);
    assert_true(crn_state_restore(&other->model, &other->state, bytes));
    other->input = r->input;
    crn_model_set_tip_load(&other->model, r->model.tip_load_N_q22);
    for (int t = 0; t < 300; t++) {
        const crn_vec3 load_N_q22 = {{0, (300 - t) * 100, t * 50}};
        crn_model_set_tip_load(&r->model, load_N_q22);
        crn_model_set_tip_load(&other->model, load_N_q22);
        rig_step(r);
        rig_step(other);
        assert_true(crn_state_hash64(&r->state) == crn_state_hash64(&other->state));
    }
    /* a set beyond its range is refused */
    const size_t cell = offsetof(crn_state_words, set.cells) + 4 * sizeof(crn_set);
    bytes[cell + 3] = 0x7f;
    assert_false(crn_state_restore(&other->model, &other->state, bytes));
    free(bytes);
    free(r);
    free(other);
}

static crn_instrument guide_of(double bend_N_m2)
{
    crn_instrument tool = wire_of(CRN_ELASTIC, WIRE_N_m2);
    for (int i = 0; i < 2; i++) {
        tool.knots[i].radius_outer_um = 900;
        tool.knots[i].radius_inner_um = 500;
        tool.knots[i].bend_stiffness_nN_m2 = tool.knots[i].twist_stiffness_nN_m2 =
            (uint32_t)lround(1e9 * bend_N_m2);
        tool.knots[i].mass_mg_per_m = 4000;
    }
    return tool;
}

/* The wire comes 100 mm out of the sheath, and the guide 30 mm. */
static rig *wire_in_guide(double guide_N_m2)
{
    const crn_instrument tools[] = {wire_of(CRN_PLASTIC, WIRE_N_m2), guide_of(guide_N_m2)};
    const uint32_t inserted_um[] = {FREE_um, 30000};
    crn_entry entry = reference_entry();
    crn_build_place place;
    rig *r = calloc(1, sizeof *r);
    assert_int_equal(crn_model_build(&r->model, tools, 2, NULL, &entry, &place), CRN_BUILD_OK);
    crn_state_init(&r->model, &r->state, inserted_um);
    crn_model_set_gravity(&r->model, 0, 0, 0);
    load_tip(r, 0, 2 * yield_N, 0);
    load_tip(r, 2 * yield_N, 0, 0);
    return r;
}

/* Moves the guide by 90 mm, 0.1 m/s, and lets the tools come to rest. */
static void move_guide(rig *r, double m_per_tick)
{
    for (int t = 0; t < 6000; t++) {
        if (t < 900) r->input.hands[1].feed_m_q30 += (int32_t)lround(m_per_tick * Q30);
        rig_step(r);
    }
}

/* A stiff, straight guide is pushed over a bent wire and drawn back. In the guide, the wire is nearly
 * straight, because its EI is 1 % of the guide's; it does not yield there, because its set is below half of
 * the yield curvature. */
static void a_set_stays_with_the_wire_in_a_guide(void **context)
{
    (void)context;
    rig *r = wire_in_guide(2e-2);
    const double before_m = tip_m(r, 0);
    move_guide(r, 1e-4);
    const double inside_m = tip_m(r, 0);
    move_guide(r, -1e-4);
    const double after_m = tip_m(r, 0);
    if (fabs(inside_m) > 0.02 * before_m || fabs(after_m - before_m) > 0.003 * before_m)
        fail_msg("the tip is off by %.4f mm, by %.4f mm in the guide, and by %.4f mm outside again",
                 1e3 * before_m, 1e3 * inside_m, 1e3 * after_m);
    free(r);
}

/* A guide as stiff as the wire takes half of its set, where the wire's material lies: 20 mm behind the
 * guide's tip and more. The tip of the guide is off by the integral of curvature times distance. */
static void a_set_bends_the_guide_where_the_wire_lies(void **context)
{
    (void)context;
    rig *r = wire_in_guide(WIRE_N_m2);
    move_guide(r, 1e-4);
    double expected_m = 0;
    const double ahead_m =
        (r->state.words.tools[1].inserted_m_q30 - r->state.words.tools[0].inserted_m_q30) / Q30;
    for (int i = 1; i < CRN_SET_CELL_MAX; i++)
        expected_m += 0.5 * (-r->state.words.set.cells[0][i].turn_q29[0] / (Q30 / 2)) *
                      (ahead_m + r->model.mesh[i].arc_m_q30 / Q30);
    assert_true(fabs(ahead_m - 0.02) < 1e-3);
    if (fabs(fabs(tip_m(r, 0)) - fabs(expected_m)) > 0.03 * fabs(expected_m))
        fail_msg("the guide's tip is off by %.4f mm, expected %.4f mm", 1e3 * tip_m(r, 0), 1e3 * expected_m);
    free(r);
}

/* EI of a sixteenth: half of the core's radius, so twice the curvature at yield. */
static void a_thin_core_yields_at_a_larger_curvature(void **context)
{
    (void)context;
    rig *r = cantilever_of(wire_of(CRN_PLASTIC, WIRE_N_m2 / 16));
    reference f = reference_of(r, CRN_PLASTIC);
    f.bend_N_m2 = WIRE_N_m2 / 16;
    f.yield_per_m = 2 * WIRE_YIELD_per_m;
    static const double parts[] = {0.97, 1.6, 0};
    double last_N = 0;
    for (int i = 0; i < 3; i++) {
        const double load_N = parts[i] * yield_N / 8;
        load_tip(r, last_N, load_N, 0.4);
        last_N = load_N;
        const double expected_m = reference_load(&f, load_N);
        if (fabs(tip_m(r, 0.4) - expected_m) > 1e-4)
            fail_msg("%.2f of the load at yield: the tip is off by %.4f mm, expected %.4f mm", parts[i],
                     1e3 * tip_m(r, 0.4), 1e3 * expected_m);
    }
    free(r);
}

/* Only a bend beyond the rest shape counts: a tip whose rest curvature is twice that at yield does not yield
 * by itself. */
static void a_rest_shape_does_not_yield(void **context)
{
    (void)context;
    crn_instrument tool = wire_of(CRN_PLASTIC, WIRE_N_m2);
    for (int i = 0; i < 2; i++)
        tool.knots[i].rest_curvature1_per_m_milli = (int32_t)lround(2000 * WIRE_YIELD_per_m);
    rig *r = cantilever_of(tool);
    for (int t = 0; t < 3000; t++) rig_step(r);
    assert_int_equal(r->state.words.set.used_bits, 0);
    assert_true(fabs(tip_m(r, 0)) > 0.03);
    free(r);
}

/* A wire of nitinol in tools of a soft metal, all of which yield. */
static void random_hands_keep_tools_that_yield_in_the_vessel(void **context)
{
    (void)context;
    reference_hands_result result = {0};
    for (uint32_t i = 0; i < 2; i++)
        reference_random_hands(3, REFERENCE_HANDS_WITH_MATERIALS + i, REFERENCE_RUN(6000), &result);
    assert_int_equal(result.sets_bits, 7);
    check_below("ticks with a saturated quantity", result.saturated, 0);
    check_below("length error (%)", result.strain_max_pct, 0.6);
    check_below("ticks deeper than 1 mm", result.deep, 1);
}

/* A J of 3 mm radius, with its end in the middle of a cell: the step of the rest curvature is more than twice
 * the curvature at yield. */
static void a_step_of_the_rest_curvature_does_not_yield(void **context)
{
    (void)context;
    enum { J_um = 4801, J_per_m_milli = 333000 };
    crn_instrument tool = wire_of(CRN_PLASTIC, 1.5e-5);
    tool.material.core_modulus_MPa = 190000;
    tool.material.yield_strain_micro = 13900; /* 139 per metre for a core of 0.1 mm radius */
    tool.element_tip_um = 800;
    tool.element_fine_um = 40000;
    tool.knot_count = 4;
    tool.knots[3] = tool.knots[1];
    for (int i = 1; i < 3; i++) {
        tool.knots[i] = tool.knots[0];
        tool.knots[i].arc_um = J_um;
    }
    tool.knots[0].rest_curvature1_per_m_milli = tool.knots[1].rest_curvature1_per_m_milli = J_per_m_milli;
    rig *r = cantilever_of(tool);
    for (int t = 0; t < 2000; t++) rig_step(r);
    assert_int_equal(r->state.words.set.used_bits, 0);
    free(r);
}

/* A wire that enters askew is drawn back and forth; it is saved and restored again and again, and both go on
 * with the same hashes. */
static void stays_the_same_when_restored(const crn_instrument *tool, uint32_t inserted_um, double load_N,
                                         double m_per_tick, int turn_at)
{
    enum { SEGMENTS = 185, TICKS = 30 };
    rig *two[2];
    crn_entry entry = reference_entry();
    const double askew[3] = {0.307, -0.716, 0.624};
    for (int k = 0; k < 3; k++)
        entry.direction_q30.v[k] =
            (int32_t)lround(askew[k] / sqrt(0.307 * 0.307 + 0.716 * 0.716 + 0.624 * 0.624) * Q30);
    for (int i = 0; i < 2; i++) {
        crn_build_place place;
        two[i] = calloc(1, sizeof *two[i]);
        assert_int_equal(crn_model_build(&two[i]->model, tool, 1, NULL, &entry, &place), CRN_BUILD_OK);
        crn_state_init(&two[i]->model, &two[i]->state, (const uint32_t[CRN_TOOL_MAX]){inserted_um});
        crn_model_set_gravity(&two[i]->model, 0, 0, 0);
    }
    load_tip(two[0], 0, load_N, 0);
    two[1]->model.tip_load_N_q22 = two[0]->model.tip_load_N_q22;
    uint8_t *bytes = malloc(crn_state_bytes());
    for (int s = 0; s < SEGMENTS; s++) {
        two[0]->input.hands[0].feed_m_q30 -= (int32_t)lround(m_per_tick * Q30) * (s < turn_at ? 1 : -1);
        for (int t = 0; t < 3; t++) rig_step(two[0]);
        crn_state_save(&two[0]->state, bytes);
        assert_true(crn_state_restore(&two[1]->model, &two[1]->state, bytes));
        two[1]->input = two[0]->input;
        for (int t = 0; t < TICKS; t++) {
            rig_step(two[0]);
            rig_step(two[1]);
            if (crn_state_hash64(&two[0]->state) != crn_state_hash64(&two[1]->state))
                fail_msg("segment %d, tick %d: the restored state goes another way", s, t);
        }
    }
    free(bytes);
    free(two[0]);
    free(two[1]);
}

/* Yielded cells go into the sheath: nothing of them may stay behind its end. */
static void a_set_that_enters_the_sheath_leaves_nothing_behind(void **context)
{
    (void)context;
    crn_instrument tool = wire_of(CRN_PLASTIC, WIRE_N_m2);
    tool.knot_count = 4;
    tool.knots[3] = tool.knots[1];
    for (int i = 1; i < 3; i++) {
        tool.knots[i] = tool.knots[0];
        tool.knots[i].arc_um = 10000;
    }
    tool.knots[0].rest_curvature1_per_m_milli = tool.knots[1].rest_curvature1_per_m_milli = 3000;
    stays_the_same_when_restored(&tool, FREE_um, 2.2 * yield_N, 3.2e-4, 180);
}

/* Joints behind the last cell that can have a set bend beyond the yield, and go into the sheath. */
static void a_bend_beyond_the_last_cell_leaves_no_mark(void **context)
{
    (void)context;
    crn_instrument tool = wire_of(CRN_PLASTIC, WIRE_N_m2);
    tool.knots[1].arc_um = 700000;
    tool.element_shaft_um = 4000;
    tool.element_fine_um = 200000;
    tool.material.yield_strain_micro = (uint32_t)lround(1e6 * 2.2 * core_radius_m());
    stays_the_same_when_restored(&tool, 650000, 0.00085, 2e-4, 100);
}

/* Any state that passes the checks of a restored one must be computed without overflow: here, under the
 * sanitizers, with every set at its limit. A set of a tool without a material is refused. */
static void sets_at_their_limits_are_computed(void **context)
{
    (void)context;
    for (uint32_t kind = CRN_ELASTIC; kind <= CRN_SUPERELASTIC; kind++) {
        crn_instrument tool = wire_of(kind, WIRE_N_m2);
        if (kind != CRN_ELASTIC) {
            tool.material.hardening_milli = 900;
            tool.material.yield_strain_micro = 50000;
            tool.material.core_modulus_MPa = 300000;
        }
        for (int i = 0; i < 2; i++) tool.knots[i].rest_curvature1_per_m_milli = 590000;
        rig *r = cantilever_of(tool);
        for (int t = 0; t < 300; t++) rig_step(r);
        r->state.words.set.used_bits = 1;
        for (int i = 1; i < CRN_SET_CELL_MAX; i++)
            r->state.words.set.cells[0][i] = (crn_set){{i % 2 ? 720000000 : -720000000, 720000000}};
        uint8_t *bytes = malloc(crn_state_bytes());
        crn_state_save(&r->state, bytes);
        assert_int_equal(crn_state_restore(&r->model, &r->state, bytes), kind != CRN_ELASTIC);
        for (int t = 0; t < 500 && kind != CRN_ELASTIC; t++) rig_step(r);
        free(bytes);
        free(r);
    }
}

/* A tool that leaves the line comes back as a new one. */
static void an_exchange_forgets_the_set(void **context)
{
    (void)context;
    crn_state_words *words = calloc(1, sizeof *words);
    words->set.used_bits = 3;
    words->set.cells[1][5].turn_q29[0] = words->set.cells[0][5].turn_q29[1] = 1000;
    crn_set_forget(words, 1);
    assert_int_equal(words->set.used_bits, 1);
    assert_int_equal(words->set.cells[1][5].turn_q29[0], 0);
    assert_int_equal(words->set.cells[0][5].turn_q29[1], 1000);
    free(words);
}

/* Each number of a material has its range, and an elastic tool has none of them. */
static void a_material_out_of_range_is_refused(void **context)
{
    (void)context;
    const crn_material wrong[] = {
        {3, 10000, 60000, 0, 0, 0},
        {CRN_ELASTIC, 10000, 0, 0, 0, 0},
        {CRN_PLASTIC, 499, 60000, 0, 0, 0},
        {CRN_PLASTIC, 50001, 60000, 0, 0, 0},
        {CRN_PLASTIC, 10000, 999, 0, 0, 0},
        {CRN_PLASTIC, 10000, 300001, 0, 0, 0},
        {CRN_PLASTIC, 10000, 60000, 901, 0, 0},
        {CRN_PLASTIC, 10000, 60000, 100, 1, 0},
        {CRN_SUPERELASTIC, 10000, 60000, 100, 951, 1000},
        {CRN_SUPERELASTIC, 10000, 60000, 100, 400, 99},
        {CRN_SUPERELASTIC, 10000, 60000, 100, 400, 20001},
    };
    for (size_t i = 0; i < sizeof wrong / sizeof wrong[0]; i++) {
        crn_instrument tool = wire_of(CRN_ELASTIC, WIRE_N_m2);
        tool.material = wrong[i];
        crn_entry entry = reference_entry();
        crn_build_place place;
        crn_model *model = calloc(1, sizeof *model);
        assert_int_equal(crn_model_build(model, &tool, 1, NULL, &entry, &place), CRN_BUILD_RANGE);
        free(model);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_metal_wire_yields_and_keeps_its_set),
        cmocka_unit_test(nitinol_comes_back_on_a_lower_branch),
        cmocka_unit_test(below_the_yield_a_metal_wire_is_elastic),
        cmocka_unit_test(a_set_turns_with_the_hand),
        cmocka_unit_test(a_restored_state_goes_on_with_the_same_hashes),
        cmocka_unit_test(a_set_stays_with_the_wire_in_a_guide),
        cmocka_unit_test(a_set_bends_the_guide_where_the_wire_lies),
        cmocka_unit_test(a_thin_core_yields_at_a_larger_curvature),
        cmocka_unit_test(a_rest_shape_does_not_yield),
        cmocka_unit_test(random_hands_keep_tools_that_yield_in_the_vessel),
        cmocka_unit_test(a_step_of_the_rest_curvature_does_not_yield),
        cmocka_unit_test(a_set_that_enters_the_sheath_leaves_nothing_behind),
        cmocka_unit_test(a_bend_beyond_the_last_cell_leaves_no_mark),
        cmocka_unit_test(sets_at_their_limits_are_computed),
        cmocka_unit_test(an_exchange_forgets_the_set),
        cmocka_unit_test(a_material_out_of_range_is_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
