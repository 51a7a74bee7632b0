/* These tests check that the last section of a body file names the scene with which the file was baked. The
 * tests also check that the name that is read equals the name that was written. A body file is refused when
 * its section with the scene's name is not the last one or has a wrong size. The tests use small valid files
 * whose section table is changed and whose CRCs are corrected. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>

#include <cmocka.h>

#include "shared/scene/tests/scene_sample.h"

static _Alignas(16) uint8_t file[SAMPLE_BYTES_MAX];

static crn_scene_status status_of(size_t bytes)
{
    crn_scene scene;
    return crn_scene_open(file, bytes, &scene, NULL);
}

/* Sets the type of row `row` of the section table. */
static void set_type(uint32_t row, uint32_t type, size_t bytes)
{
    crn_scene_put_u32(file + 32 + 16 * row, type);
    sample_seal(file, bytes);
}

static void bodies_name_their_scene_whatever_stands_before_it(void **state)
{
    (void)state;
    for (int vessels = SAMPLE_NO_TREE; vessels <= SAMPLE_LESIONS; vessels++) {
        const size_t bytes = sample_body_file_of(file, sizeof file, (sample_vessels)vessels, 1);
        crn_scene scene;
        assert_int_equal(crn_scene_open(file, bytes, &scene, NULL), CRN_SCENE_OK);
        assert_true(scene.has_partner);
        assert_int_equal(scene.partner_bytes, SAMPLE_PARTNER_BYTES);
        assert_int_equal(scene.partner_crc32, SAMPLE_PARTNER_CRC32);
        assert_int_equal(scene.body_count, 2);
        assert_string_equal(crn_scene_body(&scene, 1).name, "skin");
        assert_int_equal(scene.branch_count, vessels >= SAMPLE_TREE ? 2 : 0);
        assert_int_equal(scene.lesion_count, vessels == SAMPLE_LESIONS ? 1 : 0);
        assert_int_equal(crn_scene_u16(file + 10), 5); /* minor version */
    }
}

static void bodies_without_a_scene_are_of_the_old_version(void **state)
{
    (void)state;
    const size_t bytes = sample_body_file(file, sizeof file, SAMPLE_NO_TREE);
    crn_scene scene;
    assert_int_equal(crn_scene_open(file, bytes, &scene, NULL), CRN_SCENE_OK);
    assert_false(scene.has_partner);
    assert_int_equal(crn_scene_u16(file + 10), 0);
}

static void it_stands_last_and_once(void **state)
{
    (void)state;
    size_t bytes = sample_body_file_of(file, sizeof file, SAMPLE_TREE, 1); /* META, 2 bodies, TREE, PARTNER */
    set_type(2, CRN_SCENE_PARTNER, bytes);
    assert_int_equal(status_of(bytes), CRN_SCENE_SECTION_TYPE);
    bytes = sample_body_file_of(file, sizeof file, SAMPLE_TREE, 1);
    set_type(3, CRN_SCENE_PARTNER, bytes);
    assert_int_equal(status_of(bytes), CRN_SCENE_SECTION_TYPE);
    bytes = sample_scene(file, sizeof file);
    set_type(2, CRN_SCENE_PARTNER, bytes);
    assert_int_equal(status_of(bytes), CRN_SCENE_SECTION_TYPE);
}

static void alone_it_makes_no_body_file(void **state)
{
    (void)state;
    uint8_t meta[CRN_SCENE_META_BYTES], partner[CRN_SCENE_PARTNER_BYTES] = {0};
    sample_meta(meta);
    const crn_scene_part parts[2] = {{CRN_SCENE_META, meta, sizeof meta},
                                     {CRN_SCENE_PARTNER, partner, sizeof partner}};
    const size_t bytes = crn_scene_write(CRN_SCENE_KIND_BODIES, parts, 2, file, sizeof file);
    assert_int_equal(status_of(bytes), CRN_SCENE_SECTION_TYPE);
}

static void it_has_one_size(void **state)
{
    (void)state;
    for (uint32_t size = 0; size <= 16; size++) {
        uint8_t meta[CRN_SCENE_META_BYTES], bone[SAMPLE_BODY_BYTES], partner[16] = {0};
        sample_meta(meta);
        sample_body(bone, "bone", -1);
        const crn_scene_part parts[3] = {{CRN_SCENE_META, meta, sizeof meta},
                                         {CRN_SCENE_BODY, bone, sizeof bone},
                                         {CRN_SCENE_PARTNER, partner, size}};
        const size_t bytes = crn_scene_write(CRN_SCENE_KIND_BODIES, parts, 3, file, sizeof file);
        assert_int_equal(status_of(bytes),
                         size == CRN_SCENE_PARTNER_BYTES ? CRN_SCENE_OK : CRN_SCENE_SECTION_SIZE);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(bodies_name_their_scene_whatever_stands_before_it),
        cmocka_unit_test(bodies_without_a_scene_are_of_the_old_version),
        cmocka_unit_test(it_stands_last_and_once),
        cmocka_unit_test(alone_it_makes_no_body_file),
        cmocka_unit_test(it_has_one_size),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
