/* These tests check that a scene may state a start length, and that older readers refuse such a scene. Scenes
 * without a start length must keep the version that they had before. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "shared/scene/tests/scene_refusal.h"

enum { ENTRY_AT = 336, START_AT = ENTRY_AT + CRN_SCENE_ENTRY_BYTES, MINOR_AT = 10 };

static _Alignas(16) uint8_t file[SAMPLE_BYTES_MAX];

static uint32_t opened_start_um(size_t bytes)
{
    crn_scene scene;
    uint32_t where = 0;
    assert_int_equal(crn_scene_open(file, bytes, &scene, &where), CRN_SCENE_OK);
    return scene.entry_start_um;
}

static void a_scene_without_a_start_length_stays_as_it_was(void **state)
{
    (void)state;
    const size_t bytes = sample_scene(file, sizeof file);
    assert_int_equal(crn_scene_u16(file + MINOR_AT), 0);
    assert_int_equal(opened_start_um(bytes), 0);
}

static void a_start_length_raises_the_version_that_readers_need(void **state)
{
    (void)state;
    const size_t bytes = sample_scene_starting(15000, file, sizeof file);
    assert_int_equal(crn_scene_u16(file + MINOR_AT), 6);
    assert_int_equal(opened_start_um(bytes), 15000);
    crn_scene_put_u16(file + MINOR_AT, 5);
    refuses_sealed(file, bytes, CRN_SCENE_SECTION_SIZE, ENTRY_AT);
}

/* Requirement: SR-20 */
static void a_start_length_must_be_possible(void **state)
{
    (void)state;
    const size_t bytes = sample_scene_starting(CRN_SCENE_ENTRY_START_MAX_um, file, sizeof file);
    assert_int_equal(opened_start_um(bytes), CRN_SCENE_ENTRY_START_MAX_um);
    for (int wrong = 0; wrong < 3; wrong++) {
        static const uint32_t lengths_um[3] = {0, CRN_SCENE_ENTRY_START_MAX_um + 1, 0xffffffffu};
        crn_scene_put_u32(file + START_AT, lengths_um[wrong]);
        refuses_sealed(file, bytes, CRN_SCENE_ENTRY_START, START_AT);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_scene_without_a_start_length_stays_as_it_was),
        cmocka_unit_test(a_start_length_raises_the_version_that_readers_need),
        cmocka_unit_test(a_start_length_must_be_possible),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
