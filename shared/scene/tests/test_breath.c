/* These tests check that a body may state its displacement by a full breath, and that older readers refuse
 * such a body. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "shared/scene/tests/scene_refusal.h"

enum {
    MINOR_AT = 10,
    BODY_AT = 32 + 2 * 16 + CRN_SCENE_META_BYTES,
    FLAGS_AT = BODY_AT + 60,
    BREATH_AT = BODY_AT + SAMPLE_BODY_BYTES,
};

static _Alignas(16) uint8_t file[SAMPLE_BYTES_MAX];

/* The second vertex, 1 m along x, moves by -12 mm along y. */
static size_t breathing(void)
{
    return sample_breathing_body(file, sizeof file);
}

static void a_body_may_breathe(void **state)
{
    (void)state;
    crn_scene scene;
    const size_t bytes = breathing();
    assert_int_equal(crn_scene_u16(file + MINOR_AT), 9);
    assert_int_equal(crn_scene_open(file, bytes, &scene, NULL), CRN_SCENE_OK);
    const crn_scene_body_view body = crn_scene_body(&scene, 0);
    assert_false(body.moves);
    assert_non_null(body.breath_um);
    assert_int_equal((int16_t)crn_scene_u16(body.breath_um + CRN_SCENE_BODY_BREATH_BYTES + 2), -12000);
    assert_int_equal(crn_scene_u16(body.breath_um), 0);
}

static void an_older_file_has_no_body_that_breathes(void **state)
{
    (void)state;
    const size_t bytes = breathing();
    crn_scene_put_u16(file + MINOR_AT, 8);
    refuses_sealed(file, bytes, CRN_SCENE_RESERVED, FLAGS_AT);
}

static void a_body_moves_with_the_lattice_or_breathes_but_not_both(void **state)
{
    (void)state;
    const size_t bytes = breathing();
    crn_scene_put_u32(file + FLAGS_AT, CRN_SCENE_BODY_MOVES | CRN_SCENE_BODY_BREATHES);
    refuses_sealed(file, bytes, CRN_SCENE_RESERVED, FLAGS_AT);
    crn_scene_put_u32(file + FLAGS_AT, 0);
    refuses_sealed(file, bytes, CRN_SCENE_SECTION_SIZE, BODY_AT + 52);
}

static void a_breath_stays_within_the_reach_of_bodies(void **state)
{
    (void)state;
    const size_t bytes = breathing();
    crn_scene_put_u32(file + BODY_AT + 64 + 12, CRN_SCENE_BODY_REACH_um - 5000);
    crn_scene_put_u16(file + BREATH_AT + CRN_SCENE_BODY_BREATH_BYTES, 5000);
    sample_seal(file, bytes);
    crn_scene scene;
    assert_int_equal(crn_scene_open(file, bytes, &scene, NULL), CRN_SCENE_OK);
    crn_scene_put_u16(file + BREATH_AT + CRN_SCENE_BODY_BREATH_BYTES, 5001);
    refuses_sealed(file, bytes, CRN_SCENE_BODY_VERTEX, BREATH_AT + CRN_SCENE_BODY_BREATH_BYTES);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_body_may_breathe),
        cmocka_unit_test(an_older_file_has_no_body_that_breathes),
        cmocka_unit_test(a_body_moves_with_the_lattice_or_breathes_but_not_both),
        cmocka_unit_test(a_breath_stays_within_the_reach_of_bodies),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
