/* These tests check that a scene may state how its walls give way, that older readers refuse such a scene,
 * and that no number leaves the range for which the core's arithmetic is proved. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#include "shared/scene/tests/scene_refusal.h"

enum { MINOR_AT = 10, WALLS_BYTES = 16 + 2 * 32 + SAMPLE_LATTICE };

static _Alignas(16) uint8_t file[SAMPLE_BYTES_MAX];

/* A scene with two laws: the second for the second brick, while the first brick is rigid. */
static size_t walls_at;
static size_t scene_with_walls(void)
{
    uint8_t meta[CRN_SCENE_META_BYTES], entry[CRN_SCENE_ENTRY_BYTES], lumen[SAMPLE_LUMEN_BYTES];
    uint8_t walls[WALLS_BYTES] = {2};
    sample_meta(meta);
    sample_entry(entry);
    sample_lumen(lumen);
    for (int law = 0; law < 2; law++) {
        const uint32_t words[8] = {30000, 200000, 150, 10000, 15000, 2000, 0, 0};
        for (int i = 0; i < 8; i++) crn_scene_put_u32(walls + 16 + 32 * law + 4 * i, words[i]);
    }
    walls[WALLS_BYTES - 1] = 2;
    const crn_scene_part parts[] = {{CRN_SCENE_META, meta, sizeof meta},
                                    {CRN_SCENE_ENTRY, entry, sizeof entry},
                                    {CRN_SCENE_LUMEN, lumen, sizeof lumen},
                                    {CRN_SCENE_WALLS, walls, sizeof walls}};
    const size_t bytes = crn_scene_write(CRN_SCENE_KIND_SCENE, parts, 4, file, sizeof file);
    walls_at = crn_scene_u32(file + CRN_SCENE_HEADER_BYTES + 3 * CRN_SCENE_TABLE_ROW_BYTES + 4);
    return bytes;
}

static void a_scene_may_state_how_its_walls_give_way(void **state)
{
    (void)state;
    crn_scene scene;
    const size_t bytes = scene_with_walls();
    assert_int_equal(crn_scene_u16(file + MINOR_AT), 11);
    assert_int_equal(crn_scene_open(file, bytes, &scene, NULL), CRN_SCENE_OK);
    assert_int_equal(scene.wall_law_count, 2);
    assert_int_equal(crn_scene_u32(scene.wall_laws + 32), 30000);
    assert_int_equal(scene.wall_law_of_brick[0], 0);
    assert_int_equal(scene.wall_law_of_brick[1], 2);
    assert_false(scene.has_motion);
    assert_int_equal(crn_scene_open(file, sample_scene(file, sizeof file), &scene, NULL), CRN_SCENE_OK);
    assert_int_equal(scene.wall_law_count, 0);
}

static void an_older_file_has_no_walls_that_give_way(void **state)
{
    (void)state;
    const size_t bytes = scene_with_walls();
    crn_scene_put_u16(file + MINOR_AT, 10);
    refuses_sealed(file, bytes, CRN_SCENE_SECTION_TYPE, (uint32_t)walls_at);
}

/* Requirement: SR-20 */
static void every_number_of_a_law_stays_in_its_range(void **state)
{
    (void)state;
    static const struct {
        uint32_t at;
        uint32_t value;
        bool is_good;
    } cases[] = {
        {0, 999, false},   {0, 1000, true},    {0, 0, true},      {0, 10000001, false},
        {4, 9999, false},  {4, 10000, true},   {4, 0, true},      {8, 19, false},
        {8, 20, true},     {8, 10001, false},  {12, 20000, true}, {12, 20001, false},
        {16, 20000, true}, {16, 20001, false}, {20, 4000, true},  {20, 4001, false},
        {24, 1, false},    {28, 1, false},     {8, 0, false},     {0, 0xffffffff, false},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        const size_t bytes = scene_with_walls(), law = walls_at + 16 + 32;
        crn_scene_put_u32(file + law + cases[i].at, cases[i].value);
        if (!cases[i].is_good) {
            refuses_sealed(file, bytes, CRN_SCENE_WALL, (uint32_t)law);
            continue;
        }
        crn_scene scene;
        sample_seal(file, bytes);
        assert_int_equal(crn_scene_open(file, bytes, &scene, NULL), CRN_SCENE_OK);
    }
}

/* Requirement: SR-20 */
static void a_brick_names_a_law_that_exists(void **state)
{
    (void)state;
    const size_t bytes = scene_with_walls(), last = walls_at + WALLS_BYTES - 1;
    file[last] = 3;
    refuses_sealed(file, bytes, CRN_SCENE_WALL, (uint32_t)last);
    scene_with_walls();
    crn_scene_put_u32(file + walls_at, 0);
    refuses_sealed(file, bytes, CRN_SCENE_WALL, (uint32_t)walls_at);
    crn_scene_put_u32(file + walls_at, 17);
    refuses_sealed(file, bytes, CRN_SCENE_WALL, (uint32_t)walls_at);
    crn_scene_put_u32(file + walls_at, 1);
    refuses_sealed(file, bytes, CRN_SCENE_SECTION_SIZE, (uint32_t)walls_at);
    scene_with_walls();
    file[walls_at + 9] = 1;
    refuses_sealed(file, bytes, CRN_SCENE_RESERVED, (uint32_t)walls_at + 8);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_scene_may_state_how_its_walls_give_way),
        cmocka_unit_test(an_older_file_has_no_walls_that_give_way),
        cmocka_unit_test(every_number_of_a_law_stays_in_its_range),
        cmocka_unit_test(a_brick_names_a_law_that_exists),
    };
    cmocka_set_message_output(CM_OUTPUT_TAP);
    return cmocka_run_group_tests(tests, NULL, NULL);
}
