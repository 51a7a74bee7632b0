/* Claims about near memory (firmware/core/near/near.h): whatever it holds, the core's numbers are those that
 * it computes from the scene in place. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>

#include <cmocka.h>

#include "firmware/core/near/near.h"
#include "firmware/tests/reference/moving_tube.h"
#include "firmware/tests/reference/random.h"
#include "firmware/tests/reference/rod_rig.h"

/* Fewer than a scene needs at least, so that parts are replaced all the time. */
enum { SLOTS_FEWER = 84 };

/* A scene in near memory, and the memory. */
typedef struct nearby {
    crn_lumen lumen;
    crn_motion motion;
    void *memory;
} nearby;

static nearby *nearby_make(const crn_lumen *lumen, const crn_motion *motion)
{
    nearby *scene = calloc(1, sizeof *scene);
    scene->lumen = *lumen;
    scene->lumen.motion = NULL;
    if (motion != NULL) {
        scene->motion = *motion;
        scene->lumen.motion = &scene->motion;
    }
    const uint32_t bytes = crn_lumen_near_bytes(&scene->lumen) - SLOTS_FEWER * (CRN_LUMEN_BRICK_SAMPLES + 8);
    scene->memory = aligned_alloc(CRN_NEAR_ALIGNMENT, (bytes + 31) / 32 * 32);
    crn_lumen_near_begin(&scene->lumen, &scene->motion, NULL, scene->memory, bytes);
    return scene;
}

static void nearby_free(nearby *scene)
{
    free(scene->memory);
    free(scene);
}

static void a_sample_of_a_copy_is_that_of_the_scene(void **state)
{
    (void)state;
    const reference_piece bent[2] = {{0.05, 0, 0}, {0.08, 0.04, 0}};
    reference_tube *tube = reference_tube_make(bent, 2, 0.0025, 2);
    nearby *scene = nearby_make(&tube->lumen, NULL);
    reference_random random = reference_random_seed(3);
    crn_lumen_voxel here = {0}, there = {0};
    uint32_t in_brick = 0;
    for (int i = 0; i < 20000; i++) {
        const double *p = tube->points_m[reference_random_below(&random, tube->point_count)];
        crn_vec3 place;
        /* most within the field's band, some beyond the lattice */
        const uint32_t reach_um = i % 50 == 0 ? 400000 : 4000;
        for (int k = 0; k < 3; k++) {
            const double off_m = ((double)reference_random_below(&random, 2 * reach_um) - reach_um) * 1e-6;
            place.v[k] = (int32_t)lround((p[k] + off_m) * 1073741824.0);
        }
        scene->lumen.near->tick += i % 3 == 0;
        const crn_lumen_sample a = crn_lumen_contact(&tube->lumen, &place),
                               b = crn_lumen_contact(&scene->lumen, &place);
        assert_int_equal(a.distance_m_q30, b.distance_m_q30);
        assert_memory_equal(&a.normal_q30, &b.normal_q30, sizeof a.normal_q30);
        assert_int_equal(a.distance_m_q30, crn_lumen_distance(&scene->lumen, &place));
        const int32_t far = -(1 << 20);
        assert_int_equal(crn_lumen_distance_unless_far(&tube->lumen, &place, far, &here),
                         crn_lumen_distance_unless_far(&scene->lumen, &place, far, &there));
        in_brick += labs(a.distance_m_q30) != 1 << 24;
    }
    const crn_near *near = scene->lumen.near;
    print_message("# %u samples in bricks; %u bricks, %u slots, %u slices copied\n", in_brick,
                  tube->lumen.brick_count, near->slot_count, near->slices_copied);
    assert_true(in_brick > 5000);
    assert_true(near->slot_count < tube->lumen.brick_count / 4 && near->slices_copied > in_brick);
    nearby_free(scene);
    reference_tube_free(tube);
}

/* In a beating vessel, the distance and the normal at random points, tick after tick, are those of a scene
 * that is read in place. */
static void a_moving_wall_of_a_copy_is_that_of_the_scene(void **state)
{
    (void)state;
    reference_tube *tube = reference_tube_make(reference_coronary, 3, 0.0015, 1);
    reference_motion *beating = reference_motion_make(reference_beating_sphere, reference_coronary_low_m,
                                                      reference_coronary_high_m, 22);
    nearby *scene = nearby_make(&tube->lumen, &beating->motion);
    tube->lumen.motion = &beating->motion;
    reference_random random = reference_random_seed(5);
    uint32_t moved = 0;
    for (uint32_t tick = 0; tick < 200; tick++) {
        const crn_rhythm before = {.heart_phase32 = tick * 20000000u},
                         now = {.heart_phase32 = (tick + 1) * 20000000u};
        crn_motion_pose here, there;
        crn_motion_pose_begin(&beating->motion, &here, &before, &now);
        crn_motion_pose_begin(&scene->motion, &there, &before, &now);
        scene->lumen.near->tick++;
        for (int i = 0; i < 50; i++) {
            const double *p = tube->points_m[reference_random_below(&random, tube->point_count)];
            crn_vec3 place;
            for (int k = 0; k < 3; k++)
                place.v[k] = (int32_t)lround(
                    (p[k] + ((double)reference_random_below(&random, 4000) - 2000) * 1e-6) * 1073741824.0);
            const crn_lumen_sample a = crn_motion_contact(&tube->lumen, &beating->motion, &here, &place),
                                   b = crn_motion_contact(&scene->lumen, &scene->motion, &there, &place);
            assert_int_equal(a.distance_m_q30, b.distance_m_q30);
            assert_memory_equal(&a.normal_q30, &b.normal_q30, sizeof a.normal_q30);
            const crn_vec3 step_a = crn_motion_wall_step(&beating->motion, &here),
                           step_b = crn_motion_wall_step(&scene->motion, &there);
            assert_memory_equal(&step_a, &step_b, sizeof step_a);
            moved += (step_a.v[0] | step_a.v[1] | step_a.v[2]) != 0;
        }
    }
    assert_true(moved > 5000);
    nearby_free(scene);
    reference_motion_free(beating);
    reference_tube_free(tube);
}

/* A wire is pushed into a beating and breathing vessel. After every tick, the hash of its state is that of a
 * wire whose core reads the scene in place. */
static void a_session_has_the_hashes_that_it_has_without(void **state)
{
    (void)state;
    reference_tube *tube = reference_tube_make(reference_coronary, 3, 0.0015, 1);
    reference_motion *beating = reference_motion_make(reference_beating_sphere, reference_coronary_low_m,
                                                      reference_coronary_high_m, 22);
    nearby *scene = nearby_make(&tube->lumen, &beating->motion);
    tube->lumen.motion = &beating->motion;
    const crn_instrument wire = reference_coronary_wire();
    rig *in_place = rig_make(&wire, &tube->lumen, 30000), *copied = rig_make(&wire, &scene->lumen, 30000);
    for (int ms = 0; ms < 1500; ms++) {
        in_place->input.hands[0].feed_m_q30 += 64424; /* 0.06 m/s */
        in_place->input.rhythm = (crn_rhythm_order){ms == 0 ? CRN_RHYTHM_HEART_RATE : 0, 120};
        copied->input = in_place->input;
        rig_step(in_place);
        rig_step(copied);
        assert_memory_equal(in_place->output.hash_lane, copied->output.hash_lane,
                            sizeof copied->output.hash_lane);
    }
    const crn_near *near = scene->lumen.near;
    print_message("# %u slots, %u slices and %u nodes copied\n", near->slot_count, near->slices_copied,
                  near->nodes_copied);
    assert_true(near->slices_copied > 10 * near->slot_count && near->nodes_copied > 1000);
    free(in_place);
    free(copied);
    nearby_free(scene);
    reference_motion_free(beating);
    reference_tube_free(tube);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_sample_of_a_copy_is_that_of_the_scene),
        cmocka_unit_test(a_moving_wall_of_a_copy_is_that_of_the_scene),
        cmocka_unit_test(a_session_has_the_hashes_that_it_has_without),
    };
    cmocka_set_message_output(CM_OUTPUT_TAP);
    return cmocka_run_group_tests(tests, NULL, NULL);
}
