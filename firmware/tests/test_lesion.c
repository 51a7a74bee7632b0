/* Claims about lesions (docs/lesions.md). The tests show that a fully opened lesion equals the healthy
 * vessel, and that a partly opened lesion is wider than the closed lesion and narrower than the vessel. The
 * normals of the lesion's wall must match the gradients of the distance. The tests also show that a balloon
 * opens a lesion by its pressure on the wall. After deflation, a lesion recoils by its recoil fraction
 * (completely where it is elastic), and a stent's scaffold holds it open. Open lesions and struts go with a
 * beating vessel. The tests compare the results with
 * the closed form of a stenosis in a straight tube. */
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
#include "firmware/core/near/near.h"
#include "firmware/tests/reference/damage.h"
#include "firmware/tests/reference/long_run.h"
#include "firmware/tests/reference/moving_tube.h"
#include "firmware/tests/reference/tube_lumen.h"

enum { SPACING_LOG2 = 20, STATIONS = 17, MIDDLE = 8, TIP_um = 50000 };

static const double Q30 = 1073741824.0, pi = 3.14159265358979;
static const double healthy_m = 1.6e-3, throat_m = 0.8e-3, middle_m = 35e-3, length_m = 14e-3;

typedef struct rig {
    crn_model model;
    crn_state state;
    crn_input input;
    crn_output output;
    crn_lumen lumen;
    crn_lesion lesion;
    crn_lesion_station stations[STATIONS];
} rig;

static double spacing_m(void)
{
    return ldexp(1, SPACING_LOG2 - 30);
}

static double channel_m(double x_m)
{
    const double u = (x_m - middle_m) / length_m;
    return fabs(u) > 0.5 ? healthy_m : healthy_m - (healthy_m - throat_m) * 0.5 * (1 + cos(2 * pi * u));
}

/* Describes a soft lesion, which begins to open at 2 bar and is completely open at 4 bar. With a `recoil` of
 * 1 the lesion recoils completely. */
static void describe(rig *r, double yield_kPa, double recoil)
{
    for (int i = 0; i < STATIONS; i++) {
        const double x_m = middle_m + (i - MIDDLE) * spacing_m();
        r->stations[i] = (crn_lesion_station){.healthy_m_q30 = {(int32_t)lround(x_m * Q30), 0, 0},
                                              .channel_m_q30 = {(int32_t)lround(x_m * Q30), 0, 0},
                                              .healthy_radius_m_q30 = (int32_t)lround(healthy_m * Q30),
                                              .channel_radius_m_q30 = (int32_t)lround(channel_m(x_m) * Q30),
                                              .along_q30 = {CRN_ONE_Q30, 0, 0}};
    }
    const int32_t reach = (int32_t)(4e-3 * Q30);
    r->lesion = (crn_lesion){
        .low_m_q30 = {r->stations[0].healthy_m_q30[0] - reach, -reach, -reach},
        .high_m_q30 = {r->stations[STATIONS - 1].healthy_m_q30[0] + reach, reach, reach},
        .chord_q30 = {CRN_ONE_Q30, 0, 0},
        .stretch_q28 = 1 << 28,
        .spacing_log2_q30 = SPACING_LOG2,
        .station_count = STATIONS,
        .yield_Pa = (int32_t)(yield_kPa * 1000),
        .full_Pa = 200000,
        .recoil_q30 = (int32_t)(recoil * Q30),
        .pace_q30 = (int32_t)(4e-6 / (healthy_m - throat_m) * Q30),
        .stations = r->stations,
    };
}

/* Makes a balloon of 3.2 x 18 mm on a catheter of 0.9 mm; the balloon's middle lies at the minimal lumen
 * diameter. */
static crn_instrument balloon_catheter(void)
{
    crn_instrument tool = reference_wire(2e-5, 600000, 4000, 0.1);
    tool.element_tip_um = 2000;
    tool.element_fine_um = 40000;
    for (uint32_t i = 0; i < tool.knot_count; i++) tool.knots[i].radius_outer_um = 450;
    tool.balloon = (crn_balloon){.point_count = 3,
                                 .distal_um = 6000,
                                 .proximal_um = 24000,
                                 .burst_kPa = 2000,
                                 .pressure_kPa = {600, 800, 1600},
                                 .diameter_um = {3150, 3200, 3400}};
    return tool;
}

static const reference_tube *tube(void)
{
    static reference_tube *made;
    if (made == NULL) made = reference_stenosis_make(0.06, healthy_m, throat_m, middle_m, length_m, 2);
    return made;
}

static rig *rig_in(double yield_kPa, double recoil, void *near_memory, uint32_t near_bytes)
{
    rig *r = calloc(1, sizeof *r);
    const crn_instrument tool = balloon_catheter();
    const crn_entry entry = reference_entry();
    const uint32_t inserted_um = TIP_um;
    crn_build_place place;
    describe(r, yield_kPa, recoil);
    r->lumen = tube()->lumen;
    r->lumen.lesion_count = 1;
    r->lumen.lesions = &r->lesion;
    if (near_memory != NULL) {
        assert_true(crn_lumen_near_bytes(&r->lumen) <= near_bytes);
        crn_lumen_near_begin(&r->lumen, NULL, &r->lesion, near_memory, near_bytes);
        memset(r->stations, 0x55, sizeof r->stations); /* nobody reads the scene's own any more */
    }
    assert_int_equal(crn_model_build(&r->model, &tool, 1, &r->lumen, &entry, &place), CRN_BUILD_OK);
    crn_state_init(&r->model, &r->state, &inserted_um);
    return r;
}

static rig *rig_make(double yield_kPa, double recoil)
{
    return rig_in(yield_kPa, recoil, NULL, 0);
}

static void inflate(rig *r, double kPa, int ticks)
{
    r->input.inflator_Pa = (int32_t)lround(kPa * 1000);
    for (int t = 0; t < ticks; t++) crn_step(&r->model, &r->state, &r->input, &r->output);
}

static double open_at(const rig *r, uint32_t station)
{
    return crn_state_open(&r->state, 0, station) / Q30;
}

/* Makes a state in which all points (stations) of the lesion are equally far open. */
static crn_lesion_state opened(double share)
{
    crn_lesion_state lesions = {.bits = 1};
    for (int i = 0; i < STATIONS; i++) lesions.open_q30[0][i] = (int32_t)lround(share * Q30);
    return lesions;
}

static crn_vec3 at_mm(double x, double y, double z)
{
    return crn_vec3_make((int32_t)lround(x * 1e-3 * Q30), (int32_t)lround(y * 1e-3 * Q30),
                         (int32_t)lround(z * 1e-3 * Q30));
}

static double distance_mm(const rig *r, const crn_lesion_state *lesions, crn_vec3 p, double normal[3])
{
    crn_lumen_sample sample;
    if (!crn_lesion_contact(&r->lumen, lesions, &p, &sample)) sample = crn_lumen_contact(&r->lumen, &p);
    for (int k = 0; k < 3 && normal != NULL; k++) normal[k] = sample.normal_q30.v[k] / Q30;
    return sample.distance_m_q30 * 1e3 / Q30;
}

/* The test takes points on the expected wall, and checks the distance that the core computes there. The
 * tolerance of the distance is 0.02 mm (the error of the narrow channel's distance field, docs/lesions.md)
 * times the factor by which the lesion is widened. */
static void open_by_a_share_its_radius_is_between_channel_and_vessel(void **state)
{
    (void)state;
    rig *r = rig_make(200, 0.3);
    const double shares[] = {0.1, 0.5, 0.9, 1.0};
    double worst_mm = 0;
    for (int s = 0; s < 4; s++) {
        const crn_lesion_state lesions = opened(shares[s]);
        for (double x_mm = 26; x_mm < 44; x_mm += 0.37) {
            const double narrow_mm = 1e3 * channel_m(x_mm * 1e-3);
            const double wall_mm = narrow_mm + shares[s] * (healthy_m * 1e3 - narrow_mm);
            for (double turn = 0; turn < 6; turn += 0.7) {
                const crn_vec3 p = at_mm(x_mm, wall_mm * cos(turn), wall_mm * sin(turn));
                worst_mm = fmax(worst_mm, fabs(distance_mm(r, &lesions, p, NULL)));
            }
        }
    }
    print_message("# farthest from the wall %.3f mm\n", worst_mm);
    assert_true(worst_mm < 0.04);
    free(r);
}

/* The gradient of the distance equals the normal within 4 degrees near the wall, where contact takes place.
 * The test computes the gradient by finite differences over 0.02 mm. The map that widens the lesion is linear
 * between the points at which the lesion is described (stations), and has kinks at these points. */
static void normals_are_those_of_the_distance(void **state)
{
    (void)state;
    rig *r = rig_make(200, 0.3);
    crn_lesion_state lesions = opened(0.6);
    for (int i = 0; i < STATIONS; i++) /* wider open in its middle */
        lesions.open_q30[0][i] = (int32_t)(Q30 * (0.9 - 0.08 * abs(i - MIDDLE)));
    const double h_mm = 0.02;
    double worst = 0;
    for (double x_mm = 29; x_mm < 41; x_mm += 0.43) {
        const double place[3] = {x_mm, 0.7, -0.8};
        double normal[3], slope[3];
        distance_mm(r, &lesions, at_mm(place[0], place[1], place[2]), normal);
        for (int k = 0; k < 3; k++) {
            double ahead[3] = {place[0], place[1], place[2]}, back[3] = {place[0], place[1], place[2]};
            ahead[k] += h_mm / 2;
            back[k] -= h_mm / 2;
            slope[k] = distance_mm(r, &lesions, at_mm(ahead[0], ahead[1], ahead[2]), NULL) -
                       distance_mm(r, &lesions, at_mm(back[0], back[1], back[2]), NULL);
        }
        const double size = sqrt(slope[0] * slope[0] + slope[1] * slope[1] + slope[2] * slope[2]);
        double cosine = 0;
        for (int k = 0; k < 3; k++) cosine -= normal[k] * slope[k] / size;
        worst = fmax(worst, acos(fmin(cosine, 1)) * 180 / pi);
    }
    print_message("# normals within %.1f degrees\n", worst);
    assert_true(worst < 4);
    free(r);
}

/* A channel of 0.8 mm radius lies 0.5 mm beside the axis of the healthy vessel. Open by a share s, the lumen
 * is a circle that has gone the share s of the way to the healthy one, in its middle and in its radius. Near
 * the wall the distance is that from the circle, because the map only stretches. */
static void an_eccentric_lesion_opens_towards_the_healthy_axis(void **state)
{
    (void)state;
    const reference_piece straight = {0.06, 0, 0};
    const double aside_m = 0.5e-3;
    reference_tube *channel = reference_tube_make(&straight, 1, throat_m, 2);
    rig *r = rig_make(200, 0.3);
    r->lumen.index = channel->lumen.index;
    r->lumen.children = channel->lumen.children;
    r->lumen.samples = channel->lumen.samples;
    for (int k = 0; k < 3; k++) {
        r->lumen.origin_m_q30[k] = channel->lumen.origin_m_q30[k];
        r->lumen.brick_count_xyz[k] = channel->lumen.brick_count_xyz[k];
    }
    for (int i = 0; i < STATIONS; i++) {
        r->stations[i].healthy_m_q30[1] = (int32_t)lround(aside_m * Q30);
        r->stations[i].channel_radius_m_q30 = (int32_t)lround(throat_m * Q30);
    }
    double worst_mm = 0;
    for (double share = 0.25; share < 1.1; share += 0.25) {
        const crn_lesion_state lesions = opened(share);
        const double radius_mm = 1e3 * (throat_m + share * (healthy_m - throat_m)),
                     middle_mm = 1e3 * aside_m * share;
        for (double turn = 0; turn < 6; turn += 0.5) {
            for (double depth_mm = -0.2; depth_mm < 0.3; depth_mm += 0.1) {
                const double rho_mm = radius_mm + depth_mm;
                const crn_vec3 p = at_mm(35.3, middle_mm + rho_mm * cos(turn), rho_mm * sin(turn));
                worst_mm = fmax(worst_mm, fabs(distance_mm(r, &lesions, p, NULL) - depth_mm));
            }
        }
    }
    print_message("# distances off by %.4f mm\n", worst_mm);
    assert_true(worst_mm < 0.008);
    free(r);
    reference_tube_free(channel);
}

/* Returns a rig whose vessel beats with the waves of the reference, which the caller frees, too. */
static rig *rig_in_waves(reference_motion **waves)
{
    rig *r = rig_make(200, 0.3);
    const double low_m[3] = {-0.05, -0.06, -0.06}, high_m[3] = {0.12, 0.06, 0.06};
    *waves = reference_waves_make(low_m, high_m, 23);
    r->lumen.motion = &(*waves)->motion;
    return r;
}

/* In a beating vessel, a point on the opened wall in the reference pose, moved by the vessel's motion, also
 * lies on the wall in patient coordinates. */
static void an_open_lesion_goes_with_a_beating_vessel(void **state)
{
    (void)state;
    reference_motion *waves;
    rig *r = rig_in_waves(&waves);
    r->state.words.lesions = opened(0.7);
    double worst_mm = 0, farthest_mm = 0;
    for (uint32_t beat = 0; beat < 12; beat++) {
        r->state.words.rhythm.heart_phase32 = beat * 357913941u;
        crn_motion_pose pose;
        crn_motion_pose_begin(&waves->motion, &pose, &r->state.words.rhythm, &r->state.words.rhythm);
        for (double x_mm = 31; x_mm < 39; x_mm += 0.9) {
            const double wall_mm =
                1e3 * (channel_m(x_mm * 1e-3) + 0.7 * (healthy_m - channel_m(x_mm * 1e-3)));
            const crn_vec3 reference = at_mm(x_mm, wall_mm * cos(x_mm), wall_mm * sin(x_mm));
            crn_vec3 world = reference;
            for (int round = 0; round < 30; round++) {
                const crn_vec3 pulled = crn_motion_pull(&waves->motion, &pose, &world);
                for (int k = 0; k < 3; k++) world.v[k] += reference.v[k] - pulled.v[k];
            }
            crn_lumen_sample sample;
            assert_true(crn_lesion_wall(&r->model, &r->state.words, &pose, &world, &sample));
            worst_mm = fmax(worst_mm, fabs(sample.distance_m_q30 * 1e3 / Q30));
            farthest_mm = fmax(farthest_mm, abs(world.v[1] - reference.v[1]) * 1e3 / Q30);
        }
    }
    print_message("# moved by up to %.1f mm, %.3f mm from the wall\n", farthest_mm, worst_mm);
    assert_true(farthest_mm > 1 && worst_mm < 0.04);
    reference_motion_free(waves);
    free(r);
}

/* In a beating vessel, a point on the struts in the reference pose, moved by the vessel's motion, also lies
 * on the struts in patient coordinates. There, a step of 0.1 mm along the normal changes the distance by 0.1
 * mm. */
static void struts_go_with_a_beating_vessel(void **state)
{
    (void)state;
    reference_motion *waves;
    rig *r = rig_in_waves(&waves);
    for (int32_t i = 0; i < 10; i++) {
        const crn_strut_order order = {(uint32_t)i + 1, {30000 + 2000 * i, 0, 0}, 1500, 80, i < 9};
        assert_true(crn_state_strut(&r->state, &order));
    }
    double worst_m = 0, farthest_m = 0, step_m = 0;
    for (uint32_t beat = 0; beat < 12; beat++) {
        r->state.words.rhythm.heart_phase32 = beat * 357913941u;
        crn_motion_pose pose;
        crn_motion_pose_begin(&waves->motion, &pose, &r->state.words.rhythm, &r->state.words.rhythm);
        for (double x = 31e-3; x < 47e-3; x += 0.9e-3) {
            const crn_vec3 reference = at_mm(1e3 * x, 1.5 * cos(1e3 * x), 1.5 * sin(1e3 * x));
            crn_vec3 world = reference;
            for (int round = 0; round < 30; round++) {
                const crn_vec3 back = crn_motion_pull(&waves->motion, &pose, &world);
                for (int k = 0; k < 3; k++) world.v[k] += reference.v[k] - back.v[k];
            }
            crn_lumen_sample sample;
            assert_true(crn_struts_wall(&r->model, &r->state.words, &pose, &world, 1000, &sample));
            worst_m = fmax(worst_m, fabs(sample.distance_m_q30 / Q30));
            farthest_m = fmax(farthest_m, abs(world.v[1] - reference.v[1]) / Q30);
            for (int k = 0; k < 3; k++) world.v[k] += (int32_t)lround(1e-4 * sample.normal_q30.v[k]);
            assert_true(crn_struts_wall(&r->model, &r->state.words, &pose, &world, 1000, &sample));
            step_m = fmax(step_m, fabs(sample.distance_m_q30 / Q30 + 1e-4));
        }
    }
    print_message("# moved by up to %.1f mm, %.2f um from the struts, 0.1 mm off by %.2f um\n",
                  farthest_m * 1e3, worst_m * 1e6, step_m * 1e6);
    assert_true(farthest_m > 1e-3 && worst_m < 1e-6 && step_m < 1.2e-6);
    reference_motion_free(waves);
    free(r);
}

static void closed_it_is_the_lumen_as_described(void **state)
{
    (void)state;
    rig *r = rig_make(200, 0.3);
    const crn_lesion_state closed = {0}, all = opened(1);
    crn_lumen_sample sample;
    const crn_vec3 inside = at_mm(35, 1.2, 0), before = at_mm(20, 1.2, 0), beside = at_mm(35, 3.5, 0);
    assert_false(crn_lesion_contact(&r->lumen, &closed, &inside, &sample));
    assert_true(crn_lesion_contact(&r->lumen, &all, &inside, &sample));
    assert_false(crn_lesion_contact(&r->lumen, &all, &before, &sample));
    assert_false(crn_lesion_contact(&r->lumen, &all, &beside, &sample));
    free(r);
}

/* At 8 bar the free balloon is as wide as the vessel. The balloon's pressure is higher than the lesion
 * withstands, so the lesion opens; after deflation, the lesion loses 30 % of the opening by recoil. */
static void a_balloon_opens_a_soft_lesion_which_keeps_its_plastic_share(void **state)
{
    (void)state;
    rig *r = rig_make(200, 0.3);
    inflate(r, 800, 1500);
    const double most = open_at(r, MIDDLE);
    const double waist_mm = 2e3 * r->output.balloon_radius_min_m_q30 / Q30;
    print_message("# open by %.3f under the balloon of %.2f mm at least\n", most, waist_mm);
    assert_true(most > 0.9 && waist_mm > 3.0);
    double kept = 0;
    inflate(r, 0, 1500);
    for (uint32_t i = 0; i < STATIONS; i++) kept = fmax(kept, open_at(r, i));
    print_message("# %.4f after it, at the throat %.4f\n", kept, open_at(r, MIDDLE));
    assert_true(fabs(open_at(r, MIDDLE) - 0.7 * most) < 2e-3);
    free(r);
}

/* At rest, a lesion is open by (pressure - yield) / 2 bar. The narrow part of the balloon is not unfolded, so
 * its own wall bears nothing, and all of the 8 bar press on the lesion that yields at 7 bar. */
static void a_lesion_opens_by_the_pressure_beyond_its_yield(void **state)
{
    (void)state;
    rig *r = rig_make(700, 1);
    inflate(r, 800, 2500);
    for (int i = MIDDLE - 2; i <= MIDDLE + 2; i++) {
        const double open = open_at(r, (uint32_t)i);
        if (!(fabs(open - 0.5) < 0.003)) fail_msg("station %d is open by %.4f, expected 0.5", i, open);
    }
    inflate(r, 750, 2500);
    assert_true(fabs(open_at(r, MIDDLE) - 0.25) < 0.003);
    inflate(r, 690, 2500);
    assert_true(open_at(r, MIDDLE) == 0);
    free(r);
}

/* At 8 bar the lesion leaves a waist in the balloon; at 14 bar the lesion opens. */
static void a_hard_lesion_leaves_a_waist_until_its_yield(void **state)
{
    (void)state;
    rig *r = rig_make(1000, 0.3);
    inflate(r, 800, 1500);
    assert_int_equal(crn_state_open(&r->state, 0, MIDDLE), 0);
    assert_true(r->output.balloon_radius_min_m_q30 < (int32_t)(0.85e-3 * Q30));
    assert_true(r->output.balloon_radius_max_m_q30 > (int32_t)(1.5e-3 * Q30));
    inflate(r, 1400, 1500);
    print_message("# open by %.3f at 14 bar\n", open_at(r, MIDDLE));
    assert_true(open_at(r, MIDDLE) > 0.5);
    free(r);
}

/* A balloon of 2 mm stops growing at the diameter at which the balloon's own wall and the lesion together
 * withstand the pressure. The lesion opens no wider than the balloon. */
static void a_balloon_too_small_opens_no_farther_than_itself(void **state)
{
    (void)state;
    rig *r = rig_make(200, 0.3);
    crn_instrument tool = balloon_catheter();
    const uint32_t diameter_um[] = {1950, 2000, 2100};
    memcpy(tool.balloon.diameter_um, diameter_um, sizeof diameter_um);
    const crn_entry entry = reference_entry();
    const uint32_t inserted_um = TIP_um;
    crn_build_place place;
    assert_int_equal(crn_model_build(&r->model, &tool, 1, &r->lumen, &entry, &place), CRN_BUILD_OK);
    crn_state_init(&r->model, &r->state, &inserted_um);
    inflate(r, 800, 2000);
    const double wall_mm = 1e3 * (throat_m + open_at(r, MIDDLE) * (healthy_m - throat_m));
    print_message("# wall at %.3f mm from the axis\n", wall_mm);
    assert_true(wall_mm > 0.9 && wall_mm < 1.05);
    free(r);
}

/* After every inflation and deflation of the balloon, the state of an elastic lesion must be exactly what it
 * was before, and the nodes must be at their former positions within 1 um. A plastic lesion keeps its
 * permanent opening from the first inflation on. */
static void inflations(int count, double recoil, bool is_elastic)
{
    rig *r = rig_make(200, recoil);
    crn_state_words *first = malloc(sizeof *first);
    double most = 0;
    for (int cycle = -3; cycle < count; cycle++) {
        inflate(r, 800, 320);
        most = fmax(most, open_at(r, MIDDLE));
        inflate(r, 0, 400);
        if (cycle == -1) *first = r->state.words;
    }
    if (is_elastic) {
        assert_memory_equal(&r->state.words.lesions, &first->lesions, sizeof first->lesions);
        assert_int_equal(r->state.words.lesions.bits, 0);
    } else {
        for (uint32_t i = 0; i < STATIONS; i++)
            assert_true(fabs(open_at(r, i) - first->lesions.open_q30[0][i] / Q30) < 1e-4);
        assert_true(fabs(open_at(r, MIDDLE) - (1 - recoil) * most) < 1e-3);
    }
    int32_t farthest = 0;
    for (uint32_t i = 0; i < first->free_count; i++)
        for (int k = 0; k < 3; k++) {
            const int32_t off =
                abs(r->state.words.nodes[i].position_m_q30.v[k] - first->nodes[i].position_m_q30.v[k]);
            farthest = off > farthest ? off : farthest;
        }
    print_message("# open by %.4f after them all, farthest node %.3f um\n", open_at(r, MIDDLE),
                  farthest / Q30 * 1e6);
    assert_true(farthest < 1074);
    free(first);
    free(r);
}

static void two_hundred_inflations_leave_no_trace_in_an_elastic_lesion(void **state)
{
    (void)state;
    inflations(REFERENCE_RUN(200), 1, true);
}

static void two_hundred_inflations_leave_a_plastic_lesion_at_its_residual(void **state)
{
    (void)state;
    inflations(REFERENCE_RUN(200), 0.3, false);
}

/* After the host has commanded a stent scaffold for some points of the lesion, these points stay open to the
 * commanded extent when the balloon is deflated. A command for points beyond the last point of the lesion has
 * no effect. */
static void a_scaffold_holds_its_stations(void **state)
{
    (void)state;
    rig *r = rig_make(200, 1);
    inflate(r, 800, 1000);
    r->input.scaffold = (crn_scaffold){0, 5, 11, (int32_t)(0.95 * Q30)};
    inflate(r, 800, 1);
    r->input.scaffold = (crn_scaffold){0, 0, 0, 0};
    inflate(r, 0, 1500);
    for (uint32_t i = 5; i <= 11; i++)
        assert_int_equal(crn_state_open(&r->state, 0, i), (int32_t)(0.95 * Q30));
    assert_int_equal(crn_state_open(&r->state, 0, 3), 0);
    const crn_state_words before = r->state.words;
    const crn_scaffold none[] = {{1, 0, 0, 1 << 30},       {0, 3, 2, 1 << 30},    {0, 0, STATIONS, 1 << 30},
                                 {0, 0, 0, (1 << 30) + 1}, {UINT32_MAX, 0, 0, 1}, {0, 0, 0, INT32_MIN}};
    for (size_t i = 0; i < sizeof none / sizeof none[0]; i++)
        assert_false(crn_state_scaffold(&r->model, &r->state, &none[i]));
    assert_memory_equal(&before, &r->state.words, sizeof before);
    free(r);
}

static void a_damaged_opening_is_not_restored(void **state)
{
    (void)state;
    rig *r = rig_make(200, 0.3);
    inflate(r, 800, 400);
    const damaged_word bad[] = {{offsetof(crn_lesion_state, bits), 0},
                                {offsetof(crn_lesion_state, bits), 3},
                                {offsetof(crn_lesion_state, open_q30), (1u << 30) + 1},
                                {offsetof(crn_lesion_state, open_q30), 0xffffffffu},
                                {offsetof(crn_lesion_state, open_q30) + 4 * STATIONS, 1},
                                {offsetof(crn_lesion_state, kept_q30) + 4, (1u << 30) + 1},
                                {offsetof(crn_lesion_state, kept_q30) + 4 * CRN_LESION_STATION_MAX, 1}};
    refuses_each(&r->model, &r->state, offsetof(crn_state_words, lesions), bad, sizeof bad / sizeof bad[0]);
    free(r);
}

/* Near memory (near.h) holds a copy of the stations, and changes no number. */
static void a_lesion_in_near_memory_opens_as_in_place(void **state)
{
    (void)state;
    static uint8_t memory[1 << 18] __attribute__((aligned(CRN_NEAR_ALIGNMENT)));
    rig *in_place = rig_make(200, 0.1), *copied = rig_in(200, 0.1, memory, sizeof memory);
    for (int i = 0; i < 100; i++) {
        inflate(in_place, 400, 10);
        inflate(copied, 400, 10);
        assert_memory_equal(in_place->output.hash_lane, copied->output.hash_lane,
                            sizeof copied->output.hash_lane);
    }
    assert_true(open_at(in_place, MIDDLE) > 0.5);
    free(in_place);
    free(copied);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_lesion_in_near_memory_opens_as_in_place),
        cmocka_unit_test(open_by_a_share_its_radius_is_between_channel_and_vessel),
        cmocka_unit_test(normals_are_those_of_the_distance),
        cmocka_unit_test(an_eccentric_lesion_opens_towards_the_healthy_axis),
        cmocka_unit_test(an_open_lesion_goes_with_a_beating_vessel),
        cmocka_unit_test(struts_go_with_a_beating_vessel),
        cmocka_unit_test(closed_it_is_the_lumen_as_described),
        cmocka_unit_test(a_balloon_opens_a_soft_lesion_which_keeps_its_plastic_share),
        cmocka_unit_test(a_lesion_opens_by_the_pressure_beyond_its_yield),
        cmocka_unit_test(a_hard_lesion_leaves_a_waist_until_its_yield),
        cmocka_unit_test(a_balloon_too_small_opens_no_farther_than_itself),
        cmocka_unit_test(two_hundred_inflations_leave_no_trace_in_an_elastic_lesion),
        cmocka_unit_test(two_hundred_inflations_leave_a_plastic_lesion_at_its_residual),
        cmocka_unit_test(a_scaffold_holds_its_stations),
        cmocka_unit_test(a_damaged_opening_is_not_restored),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
