/* These tests check the model of a balloon on a tool (docs/balloon.md). Where nothing confines the balloon,
 * its diameter follows the manufacturer's table. In a rigid vessel that is narrower than the unconfined
 * balloon, the balloon fills the vessel, presses on the wall with a force of pressure times area, and is held
 * by friction. A deflated balloon no longer acts on tool or vessel, and a balloon bursts above its pressure
 * limit. The tests compare the results with closed forms. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "firmware/core/balloon.h"
#include "firmware/tests/reference/damage.h"
#include "firmware/tests/reference/long_run.h"
#include "firmware/tests/reference/moving_tube.h"
#include "firmware/tests/reference/tube_lumen.h"

static const double Q30 = 1073741824.0, pi = 3.14159265358979;
static const double friction = 0.1;

typedef struct rig {
    crn_model model;
    crn_state state;
    crn_input input;
    crn_output output;
    reference_tube *tube;
} rig;

/* Makes a balloon catheter of 0.9 mm with a balloon of 3.0 x 18 mm at 8 bar, 6 mm behind its tip. */
static crn_instrument balloon_catheter(void)
{
    crn_instrument tool = reference_wire(2e-5, 600000, 4000, friction);
    tool.element_tip_um = 1000;
    tool.element_fine_um = 40000;
    for (uint32_t i = 0; i < tool.knot_count; i++) tool.knots[i].radius_outer_um = 450;
    tool.balloon = (crn_balloon){.point_count = 4,
                                 .distal_um = 6000,
                                 .proximal_um = 24000,
                                 .burst_kPa = 2000,
                                 .pressure_kPa = {600, 800, 1200, 1600},
                                 .diameter_um = {2920, 3000, 3120, 3230}};
    return tool;
}

static rig *rig_with(const crn_instrument *tool, reference_tube *tube, uint32_t inserted_um)
{
    rig *r = calloc(1, sizeof *r);
    const crn_entry entry = reference_entry();
    crn_build_place place;
    r->tube = tube;
    assert_int_equal(crn_model_build(&r->model, tool, 1, &r->tube->lumen, &entry, &place), CRN_BUILD_OK);
    crn_state_init(&r->model, &r->state, &inserted_um);
    return r;
}

static rig *rig_in_by(reference_tube *tube, uint32_t inserted_um)
{
    const crn_instrument tool = balloon_catheter();
    return rig_with(&tool, tube, inserted_um);
}

static rig *rig_in(reference_tube *tube)
{
    return rig_in_by(tube, 120000);
}

static rig *rig_make(double bore_radius_m)
{
    const reference_piece straight = {0.13, 0, 0};
    return rig_in(reference_tube_make(&straight, 1, bore_radius_m, 1));
}

static void rig_free(rig *r)
{
    reference_tube_free(r->tube);
    free(r);
}

static void run(rig *r, int ticks)
{
    for (int t = 0; t < ticks; t++) crn_step(&r->model, &r->state, &r->input, &r->output);
}

static void inflate(rig *r, double kPa, int ticks)
{
    r->input.inflator_Pa = (int32_t)lround(kPa * 1000);
    run(r, ticks);
}

static double wall_N(const rig *r)
{
    return r->output.balloon_wall_N_q22 / 4194304.0;
}

static double diameter_mm(int32_t radius_m_q30)
{
    return 2e3 * radius_m_q30 / Q30;
}

/* Bar: 2 %. The balloon's table of diameters is linear between its points. Below the first pressure of its
 * table, the balloon has not unfolded completely. */
static void a_free_balloon_has_the_diameter_of_its_table(void **state)
{
    (void)state;
    const double kPa[] = {600, 700, 800, 1000, 1200, 1600, 1800},
                 mm[] = {2.92, 2.96, 3.0, 3.06, 3.12, 3.23, 3.285};
    rig *r = rig_make(3e-3);
    for (int i = 0; i < 7; i++) {
        inflate(r, kPa[i], 400);
        assert_true(fabs(diameter_mm(r->output.balloon_radius_min_m_q30) - mm[i]) < 0.002 * mm[i]);
        assert_true(fabs(diameter_mm(r->output.balloon_radius_max_m_q30) - mm[i]) < 0.002 * mm[i]);
        assert_int_equal(r->output.balloon_wall_N_q22, 0);
    }
    inflate(r, 0, 1000);
    assert_true(fabs(diameter_mm(r->output.balloon_radius_max_m_q30) - 0.9) < 1e-4);
    rig_free(r);
}

/* A free balloon grows and shrinks by 5 um of its radius in a tick. */
static void a_free_balloon_grows_by_5_um_a_tick(void **state)
{
    (void)state;
    rig *r = rig_make(3e-3);
    inflate(r, 800, 100);
    assert_true(fabs(diameter_mm(r->output.balloon_radius_max_m_q30) - (0.9 + 100 * 0.01)) < 0.005);
    inflate(r, 0, 50);
    assert_true(fabs(diameter_mm(r->output.balloon_radius_max_m_q30) - (0.9 + 50 * 0.01)) < 0.005);
    rig_free(r);
}

/* The tolerances are 0.012 mm for the balloon's radius, and 1 % of the pressure times the covered area, 2 pi
 * r 18 mm, for the wall force. The measured errors are 0.004 mm and 0.3 %. The vessel is narrower than the
 * unfolded balloon, so the balloon's own wall supports no pressure. */
static void in_a_rigid_tube_it_fills_the_bore_and_presses_with_pressure_times_area(void **state)
{
    (void)state;
    const double bore_m[] = {1.0e-3, 1.25e-3, 1.4e-3};
    for (int i = 0; i < 3; i++) {
        rig *r = rig_make(bore_m[i]);
        inflate(r, 500, 1500);
        const double widest = diameter_mm(r->output.balloon_radius_max_m_q30) / 2,
                     narrowest = diameter_mm(r->output.balloon_radius_min_m_q30) / 2;
        print_message("# bore %.2f mm: radius %.3f to %.3f mm, %.2f N\n", bore_m[i] * 1e3, narrowest, widest,
                      wall_N(r));
        assert_true(fabs(widest - bore_m[i] * 1e3) < 0.012 && fabs(narrowest - bore_m[i] * 1e3) < 0.012);
        const double expected_N = 500e3 * 2 * pi * bore_m[i] * 18e-3;
        assert_true(fabs(wall_N(r) - expected_N) < 0.01 * expected_N);
        assert_true(r->output.penetration_max_m_q30 < (int32_t)(0.2e-3 * Q30));
        rig_free(r);
    }
}

/* In a bore that is wider than the unfolded balloon, the balloon's own wall bears the pressure that its table
 * gives for this diameter: between 6 bar for 2.92 mm and 8 bar for 3 mm. The vessel bears the rest of 12 bar.
 */
static void in_a_wide_tube_its_own_wall_bears_a_part(void **state)
{
    (void)state;
    rig *r = rig_make(1.47e-3);
    inflate(r, 1200, 1500);
    const double mm = diameter_mm(r->output.balloon_radius_max_m_q30);
    const double own_Pa = 600e3 + (mm - 2.92) / 0.08 * 200e3;
    const double expected_N = (1200e3 - own_Pa) * pi * mm * 1e-3 * 18e-3;
    print_message("# %.3f mm wide, %.2f N, expected %.2f N\n", mm, wall_N(r), expected_N);
    assert_true(mm > 2.92 && mm < 3);
    assert_true(fabs(wall_N(r) - expected_N) < 0.02 * expected_N);
    rig_free(r);
}

/* When the catheter is pulled at 5 mm/s, it slips once the hand's force reaches friction times wall force;
 * only the balloon presses hard on the wall. The hand's largest force is 11 % above, which the bar of 18 %
 * allows. */
static void an_inflated_balloon_is_held_by_friction_times_wall_force(void **state)
{
    (void)state;
    rig *r = rig_make(1.25e-3);
    inflate(r, 200, 1500);
    const double held_N = friction * wall_N(r);
    double most_N = 0;
    int32_t before = r->state.words.balloon.balls[9].centre_m_q30.v[0], first_slip = 0;
    for (int t = 0; t < 1500; t++) {
        r->input.hands[0].feed_m_q30 -= (int32_t)(5e-6 * Q30);
        run(r, 1);
        const double pull_N = -r->output.tools[0].axial_N_q22 / 4194304.0;
        most_N = fmax(most_N, pull_N);
        if (pull_N < 0.9 * held_N && first_slip == 0)
            assert_true(abs(r->state.words.balloon.balls[9].centre_m_q30.v[0] - before) <
                        (int32_t)(0.05e-3 * Q30));
        else if (first_slip == 0)
            first_slip = t;
    }
    print_message("# wall %.2f N, held %.2f N, pulled with %.2f N\n", wall_N(r), held_N, most_N);
    assert_true(most_N >= held_N && most_N < 1.18 * held_N);
    assert_true(before - r->state.words.balloon.balls[9].centre_m_q30.v[0] > (int32_t)(3e-3 * Q30));
    rig_free(r);
}

/* With a wire inside that leads, the friction of the balloon acts on the hand of the balloon catheter alone.
 */
static void over_a_wire_the_hand_of_the_catheter_feels_the_balloon(void **state)
{
    (void)state;
    const reference_piece straight = {0.15, 0, 0};
    rig *r = calloc(1, sizeof *r);
    r->tube = reference_tube_make(&straight, 1, 1.25e-3, 1);
    crn_instrument tools[2] = {reference_wire(1e-6, 600000, 4000, 0), balloon_catheter()};
    for (uint32_t i = 0; i < tools[0].knot_count; i++) tools[0].knots[i].radius_outer_um = 178;
    for (uint32_t i = 0; i < tools[1].knot_count; i++) tools[1].knots[i].radius_inner_um = 210;
    const crn_entry entry = reference_entry();
    const uint32_t inserted_um[] = {130000, 120000};
    crn_build_place place;
    assert_int_equal(crn_model_build(&r->model, tools, 2, &r->tube->lumen, &entry, &place), CRN_BUILD_OK);
    crn_state_init(&r->model, &r->state, inserted_um);
    inflate(r, 200, 1500);
    const double held_N = friction * wall_N(r);
    double catheter_N = 0, wire_N = 0;
    for (int t = 0; t < 1500; t++) {
        r->input.hands[1].feed_m_q30 -= (int32_t)(5e-6 * Q30);
        run(r, 1);
        if (t < 1000) continue;
        catheter_N -= r->output.tools[1].axial_N_q22 / 4194304.0 / 500;
        wire_N += fabs(r->output.tools[0].axial_N_q22 / 4194304.0) / 500;
    }
    print_message("# held %.2f N, the catheter's hand %.2f N, the wire's %.3f N\n", held_N, catheter_N,
                  wire_N);
    assert_true(fabs(catheter_N - held_N) < 0.02 * held_N);
    assert_true(wire_N < 0.1 * held_N);
    rig_free(r);
}

/* Holds the largest force at the hands and the worst length error since the last reset of these values. */
typedef struct worst {
    double hand_N, length_pct, aside_mm;
} worst;

static void look(const rig *r, uint32_t tools, worst *w)
{
    for (uint32_t k = 0; k < tools; k++)
        w->hand_N = fmax(w->hand_N, fabs(r->output.tools[k].axial_N_q22 / 4194304.0));
    w->length_pct = fmax(w->length_pct, 100 * fabs(r->output.strain_max_q30 / Q30));
}

/* Makes an introducer sheath in a position as in a patient: the sheath's end does not lie at the origin, and
 * the sheath's axis does not pass through the origin. */
static crn_entry entry_of_a_patient(void)
{
    const crn_entry entry = {
        {{(int32_t)(-0.08 * Q30), (int32_t)(-0.3 * Q30), (int32_t)(0.04 * Q30)}}, {{0, CRN_ONE_Q30, 0}}, 0};
    return entry;
}

/* Returns the largest distance of a free node from the sheath's axis. */
static double aside_mm(const rig *r)
{
    double most = 0;
    const crn_entry entry = entry_of_a_patient();
    for (uint32_t i = 0; i < r->state.words.free_count; i++) {
        const crn_vec3 *p = &r->state.words.nodes[i].position_m_q30;
        most =
            fmax(most,
                 1e3 / Q30 * hypot(p->v[0] - entry.position_m_q30.v[0], p->v[2] - entry.position_m_q30.v[2]));
    }
    return most;
}

/* In free space no vessel presses on the balloon, so the hand feels only the weight. The balloon is modelled
 * as a row of balls (spheres). If a ball leaves the sheath or another tool, its centre begins on the tools'
 * centreline at the point where the ball leaves. In an earlier version, such a ball began at the origin of
 * the patient frame, some 300 mm away, tied to the tool by a spring of 2 N/mm. This gave 512 N at the hand, a
 * length error of 9.5 %, and a depth of 3.5 mm in the wall of the shipped scene. The limits in this test are
 * a few times larger than the values that the test prints. */
static void an_inflated_balloon_comes_out_of_sheath_and_guide_without_a_jolt(void **state)
{
    (void)state;
    crn_instrument tools[2] = {balloon_catheter(), reference_wire(2e-4, 600000, 4000, friction)};
    for (uint32_t i = 0; i < tools[1].knot_count; i++) {
        tools[1].knots[i].radius_outer_um = 1040;
        tools[1].knots[i].radius_inner_um = 900;
    }
    tools[1].element_tip_um = 1000;
    tools[1].element_fine_um = 40000;
    const crn_entry entry = entry_of_a_patient();
    for (uint32_t count = 1; count <= 2;
         count++) { /* alone: out of the sheath; with a guiding catheter: out of that */
        rig *r = calloc(1, sizeof *r);
        worst w = {0, 0, 0};
        crn_build_place place;
        const uint32_t inserted_um[] = {7000, 14000};
        assert_int_equal(crn_model_build(&r->model, tools, count, NULL, &entry, &place), CRN_BUILD_OK);
        for (int k = 0; k < 3; k++) r->model.gravity_m_s2_q20[k] = 0;
        crn_state_init(&r->model, &r->state, inserted_um);
        inflate(r, 800, 800);
        for (int t = 0; t < 5000; t++) { /* 40 mm out, and back */
            r->input.hands[0].feed_m_q30 += (int32_t)(t < 2000 ? 20e-6 * Q30 : (t < 4000 ? -18e-6 * Q30 : 0));
            run(r, 1);
            look(r, count, &w);
            w.aside_mm = fmax(w.aside_mm, aside_mm(r));
            if (t == 2500)
                assert_true(fabs(diameter_mm(r->output.balloon_radius_min_m_q30) -
                                 diameter_mm(r->output.balloon_radius_max_m_q30)) < 0.01);
        }
        print_message("# %u tools: %.4f N, %.5f %%, %.4f mm aside\n", count, w.hand_N, w.length_pct,
                      w.aside_mm);
        assert_true(w.hand_N < 0.01 && w.length_pct < 0.001 && w.aside_mm < 0.01);
        assert_int_equal(r->output.fault_bits & CRN_FAULT_SATURATED, 0);
        free(r);
    }
}

/* At 20 bar in a bore of 1.2 mm, the friction coefficient of 0.1 lets the balloon hold 36 N, more than any
 * hand. If the hand pushes and pulls at 250 mm/s, the tool stays in place while the hand slips along it
 * (docs/rod.md, "Feed"), and no number leaves its range. The force limit of the test is 30 N, which a hand's
 * grip can withstand. */
static void a_balloon_that_holds_harder_than_a_hand_yields_in_the_hand(void **state)
{
    (void)state;
    rig *r = rig_make(1.2e-3);
    worst w = {0, 0, 0};
    inflate(r, 1900, 2000);
    for (int t = 0; t < 2000; t++) {
        r->input.hands[0].feed_m_q30 += (int32_t)((t / 500 % 2 == 0 ? 250e-6 : -250e-6) * Q30);
        run(r, 1);
        look(r, 1, &w);
        assert_true(r->output.penetration_max_m_q30 < (int32_t)(1e-3 * Q30));
    }
    print_message("# wall %.1f N, hand %.2f N at most, length error %.3f %%\n", wall_N(r), w.hand_N,
                  w.length_pct);
    assert_true(wall_N(r) * friction > 15);
    assert_true(w.hand_N < 30 && w.length_pct < 1);
    assert_int_equal(r->output.fault_bits & CRN_FAULT_SATURATED, 0);
    rig_free(r);
}

/* In an elastic vessel, every inflation and deflation must restore the balloon's state exactly, and the
 * positions of the nodes within 1 um. The test does not count the first five inflations, because they leave
 * some friction displacements, which later inflations do not change. */
static void two_hundred_inflations_leave_nothing_behind(void **state)
{
    (void)state;
    const reference_piece straight = {0.1, 0, 0};
    rig *r = rig_in_by(reference_tube_make(&straight, 1, 1.25e-3, 1), 45000);
    inflate(r, 0, 2000);
    crn_state_words *first = malloc(sizeof *first);
    for (int cycle = -5; cycle < REFERENCE_RUN(200); cycle++) {
        inflate(r, 800, 250);
        inflate(r, 0, 250);
        if (cycle == -1) *first = r->state.words;
    }
    int32_t farthest = 0;
    for (uint32_t i = 0; i < first->free_count; i++)
        for (int k = 0; k < 3; k++) {
            const int32_t off =
                abs(r->state.words.nodes[i].position_m_q30.v[k] - first->nodes[i].position_m_q30.v[k]);
            farthest = off > farthest ? off : farthest;
        }
    print_message("# farthest node %.3f um\n", farthest / Q30 * 1e6);
    assert_true(farthest < 1074);
    assert_int_equal(r->state.words.balloon.bits, 0);
    for (int j = 0; j < CRN_BALLOON_BALL_MAX; j++)
        assert_int_equal(r->state.words.balloon.balls[j].radius_m_q30, first->balloon.balls[j].radius_m_q30);
    free(first);
    rig_free(r);
}

/* The vessel is narrowed at 105 mm, where the balloon's middle lies when the tip is at 120 mm. All tests
 * share one lumen, because it takes long to make a lumen. */
static rig *rig_in_stenosis(uint32_t inserted_um)
{
    static reference_tube *tube;
    if (tube == NULL) tube = reference_stenosis_make(0.13, 1.6e-3, 0.8e-3, 105e-3, 14e-3, 2);
    return rig_in_by(tube, inserted_um);
}

static double ball_x_m(const rig *r, int ball)
{
    return r->state.words.balloon.balls[ball].centre_m_q30.v[0] / Q30;
}

static void across_a_hard_stenosis_it_takes_the_shape_of_a_dog_bone(void **state)
{
    (void)state;
    rig *r = rig_in_stenosis(120000);
    inflate(r, 800, 1500);
    const crn_balloon_ball *balls = r->state.words.balloon.balls;
    double narrowest_m = 1, widest_m = 0;
    for (uint32_t j = 0; j < r->model.balloon.ball_count; j++) {
        const double radius_m = balls[j].radius_m_q30 / Q30;
        const double centre[3] = {ball_x_m(r, (int)j), 0, 0};
        const double room_m = fmin(-reference_tube_distance(r->tube, centre), 1.5e-3);
        if (fabs(centre[0] - 105e-3) < 1e-3 ||
            fabs(centre[0] - 105e-3) > 7e-3) /* elsewhere the wall of the taper is slanted */
            assert_true(fabs(radius_m - room_m) < 0.1e-3);
        narrowest_m = fmin(narrowest_m, radius_m);
        widest_m = fmax(widest_m, radius_m);
    }
    print_message("# dog bone: radius %.2f mm in the waist, %.2f mm at the ends\n", narrowest_m * 1e3,
                  widest_m * 1e3);
    assert_true(narrowest_m < 0.9e-3 && widest_m > 1.48e-3);
    assert_true(fabs(ball_x_m(r, 9) - 104.5e-3) <
                2e-3); /* the forces of the two tapers cancel, so it stays */
    free(r);
}

/* In this test only the balloon's distal end is in the stenosis. The vessel tapers with a slope of up to
 * 0.18, whereas friction can hold the balloon only up to a slope of 0.1. */
static void badly_placed_it_is_squeezed_out(void **state)
{
    (void)state;
    rig *r = rig_in_stenosis(111000);
    inflate(r, 800, 3000);
    assert_true(96e-3 - ball_x_m(r, 9) > 1e-3);
    free(r);
}

/* Without friction, a hand holds a balloon whose distal end lies in the throat. Its force is the pressure
 * times the difference of the vessel's cross-sections at the two ends, because N dr/ds is p 2 pi r dr.
 * Measured: 0.7 % less. */
static void the_hand_holds_pressure_times_the_difference_of_the_cross_sections(void **state)
{
    (void)state;
    const double wide_m = 1.4e-3, throat_m = 0.9e-3, Pa = 400e3;
    crn_instrument tool = balloon_catheter();
    for (uint32_t i = 0; i < tool.knot_count; i++)
        tool.knots[i].friction_kinetic_milli = tool.knots[i].friction_static_milli = 0;
    rig *r = rig_with(&tool, reference_stenosis_make(0.13, wide_m, throat_m, 105e-3, 14e-3, 2), 111000);
    crn_model_set_gravity(&r->model, 0, 0, 0);
    inflate(r, Pa / 1000, 3000);
    const double u = (ball_x_m(r, 0) - 105e-3) / 14e-3,
                 here_m = wide_m - (wide_m - throat_m) * 0.5 * (1 + cos(2 * pi * u)),
                 expected_N = Pa * pi * (wide_m * wide_m - here_m * here_m),
                 hand_N = r->output.tools[0].axial_N_q22 / 4194304.0;
    assert_true(here_m < 1e-3 && fabs(hand_N - expected_N) < 0.02 * expected_N);
    rig_free(r);
}

static void slide(const double *X_m, double phase, double breath, double *x_m)
{
    memcpy(x_m, X_m, 3 * sizeof *x_m);
    x_m[0] += 1e-4 * reference_contraction(phase) + 0 * breath;
}

/* A wall that slides by 0.1 mm along the vessel in each heartbeat carries a balloon that it grips: the spring
 * of a ball then has 0.2 N, and its friction holds 0.6 N. */
static void a_wall_that_slides_carries_the_balloon(void **state)
{
    (void)state;
    const reference_piece straight = {0.13, 0, 0};
    const double low_m[3] = {0.004, -0.02, -0.02}, high_m[3] = {0.14, 0.02, 0.02};
    reference_motion *sliding = reference_motion_make(slide, low_m, high_m, 23);
    reference_tube *tube = reference_tube_make(&straight, 1, 1.25e-3, 1);
    tube->lumen.motion = &sliding->motion;
    rig *r = rig_in(tube);
    inflate(r, 800, 1714);
    double worst_um = 0, most_um = 0, first_m = 0;
    for (int t = 0; t < 1714; t++) {
        run(r, 1);
        const double wall_m = 1e-4 * reference_contraction(r->output.heart_phase32 / 4294967296.0);
        if (t == 0) first_m = ball_x_m(r, 9) - wall_m;
        worst_um = fmax(worst_um, 1e6 * fabs(ball_x_m(r, 9) - wall_m - first_m));
        most_um = fmax(most_um, 1e6 * wall_m);
    }
    assert_true(most_um > 99 && worst_um < 3.6);
    reference_motion_free(sliding);
    rig_free(r);
}

/* Two branches that part slowly have a cross-section of two circles, whose waist is sqrt(R^2 - e^2) where
 * their middles are e away from the axis. Here the waist lies at 45 degrees to the patient's axes. */
static void in_a_bore_that_is_not_round_it_grows_to_the_waist(void **state)
{
    (void)state;
    enum { INSERTED_um = 112000 };
    const double bore_m = 1.3e-3, bend_rad = 0.02, length_m = 0.06, begin_m = 0.06, quarter = pi / 4;
    const reference_piece trunk = {begin_m, 0, 0}, left[2] = {{length_m, bend_rad, quarter}, {0.01, 0, 0}},
                          right[2] = {{length_m, -bend_rad, quarter}, {0.01, 0, 0}};
    rig *r = rig_in_by(reference_fork_make(&trunk, left, right, bore_m, 2), INSERTED_um);
    crn_model_set_gravity(&r->model, 0, 0, 0);
    inflate(r, 500, 1500);
    double worst_mm = 0;
    for (uint32_t j = 0; j < r->model.balloon.ball_count; j++) {
        const double along_m = ball_x_m(r, (int)j) - begin_m,
                     aside_m = along_m * along_m * bend_rad / (2 * length_m),
                     waist_m = sqrt(bore_m * bore_m - aside_m * aside_m),
                     radius_m = r->state.words.balloon.balls[j].radius_m_q30 / Q30;
        worst_mm = fmax(worst_mm, 1e3 * fabs(radius_m - waist_m));
    }
    assert_true(worst_mm < 0.03);
    rig_free(r);
}

static void above_its_limit_it_bursts_for_good(void **state)
{
    (void)state;
    rig *r = rig_make(1.25e-3);
    inflate(r, 2000, 800);
    assert_int_equal(r->output.balloon_bits, 0);
    inflate(r, 2001, 1000);
    assert_int_equal(r->output.balloon_bits, CRN_BALLOON_BURST);
    assert_int_equal(r->output.balloon_wall_N_q22, 0);
    inflate(r, 800, 500);
    assert_true(fabs(diameter_mm(r->output.balloon_radius_max_m_q30) - 0.9) < 1e-3);
    rig_free(r);
}

static void hostile_pressures_are_limited(void **state)
{
    (void)state;
    rig *r = rig_make(1.25e-3);
    r->input.inflator_Pa = INT32_MIN;
    run(r, 100);
    assert_int_equal(r->state.words.balloon.pressure_Pa, 0);
    r->input.inflator_Pa = INT32_MAX;
    run(r, 100);
    assert_int_equal(r->output.balloon_bits, CRN_BALLOON_BURST);
    rig_free(r);
}

static void refused(crn_instrument tool)
{
    static crn_model model;
    const crn_entry entry = reference_entry();
    crn_build_place place;
    assert_int_equal(crn_model_build(&model, &tool, 1, NULL, &entry, &place), CRN_BUILD_BALLOON);
}

static void a_table_that_is_none_is_refused(void **state)
{
    (void)state;
    crn_instrument tool = balloon_catheter();
    tool.balloon.point_count = 13;
    refused(tool);
    tool.balloon.point_count = 1;
    refused(tool);
    tool = balloon_catheter();
    tool.balloon.pressure_kPa[2] = 800;
    refused(tool);
    tool = balloon_catheter();
    tool.balloon.diameter_um[3] = 3120;
    refused(tool);
    tool = balloon_catheter();
    tool.balloon.diameter_um[0] = 900;
    refused(tool);
    tool = balloon_catheter();
    tool.balloon.burst_kPa = 1600;
    refused(tool);
    tool = balloon_catheter();
    tool.balloon.proximal_um = 600001;
    refused(tool);
    tool = balloon_catheter();
    tool.balloon.distal_um = 23000;
    refused(tool);
}

static void a_damaged_balloon_is_not_restored(void **state)
{
    (void)state;
    rig *r = rig_make(1.25e-3);
    inflate(r, 800, 400);
    const damaged_word bad[] = {{offsetof(crn_balloon_state, bits), 2},
                                {offsetof(crn_balloon_state, pressure_Pa), 4000001},
                                {offsetof(crn_balloon_state, pressure_Pa), 0x80000000u},
                                {offsetof(crn_balloon_state, confined_bits), 1u << 20},
                                {offsetof(crn_balloon_state, balls) + 12, (1u << 24) + 1},
                                {offsetof(crn_balloon_state, balls) + 12, 0xffffffffu},
                                {offsetof(crn_balloon_state, balls) + 16, 0x7fffffffu},
                                {offsetof(crn_balloon_state, balls), 0x7fffffffu},
                                {offsetof(crn_balloon_state, balls) + 23 * sizeof(crn_balloon_ball), 1}};
    refuses_each(&r->model, &r->state, offsetof(crn_state_words, balloon), bad, sizeof bad / sizeof bad[0]);
    rig_free(r);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_free_balloon_has_the_diameter_of_its_table),
        cmocka_unit_test(a_free_balloon_grows_by_5_um_a_tick),
        cmocka_unit_test(in_a_wide_tube_its_own_wall_bears_a_part),
        cmocka_unit_test(over_a_wire_the_hand_of_the_catheter_feels_the_balloon),
        cmocka_unit_test(in_a_rigid_tube_it_fills_the_bore_and_presses_with_pressure_times_area),
        cmocka_unit_test(an_inflated_balloon_is_held_by_friction_times_wall_force),
        cmocka_unit_test(an_inflated_balloon_comes_out_of_sheath_and_guide_without_a_jolt),
        cmocka_unit_test(a_balloon_that_holds_harder_than_a_hand_yields_in_the_hand),
        cmocka_unit_test(two_hundred_inflations_leave_nothing_behind),
        cmocka_unit_test(across_a_hard_stenosis_it_takes_the_shape_of_a_dog_bone),
        cmocka_unit_test(badly_placed_it_is_squeezed_out),
        cmocka_unit_test(the_hand_holds_pressure_times_the_difference_of_the_cross_sections),
        cmocka_unit_test(a_wall_that_slides_carries_the_balloon),
        cmocka_unit_test(in_a_bore_that_is_not_round_it_grows_to_the_waist),
        cmocka_unit_test(above_its_limit_it_bursts_for_good),
        cmocka_unit_test(hostile_pressures_are_limited),
        cmocka_unit_test(a_table_that_is_none_is_refused),
        cmocka_unit_test(a_damaged_balloon_is_not_restored),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
