/* These tests check the section SMALL of a body file, which has the vessels that are picture and flow only:
 * what is read equals what was written, and wrong parents, flags, flows and positions in the file are
 * refused. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#include "shared/scene/tests/scene_sample.h"

/* Two small vessels of two points each: an artery that leaves the renal artery's end, and a vein without a
 * parent. */
enum { SMALL_BYTES = 16 + 2 * 64 + 4 * 16, ARTERY_AT = 16, VEIN_AT = 80 };

static _Alignas(16) uint8_t file[SAMPLE_BYTES_MAX];
static uint8_t small[SMALL_BYTES];

static void make_small(void)
{
    memset(small, 0, sizeof small);
    crn_scene_put_u32(small, 2);
    crn_scene_put_u32(small + 4, 4);
    sample_branch(small + ARTERY_AT, "arcuate", 1, 1, 0, 2);
    sample_branch(small + VEIN_AT, "renal vein", -1, 0, 2, 2);
    crn_scene_put_u32(small + ARTERY_AT + 48, CRN_SCENE_BED_KIDNEY);
    crn_scene_put_u32(small + ARTERY_AT + 52, 1600);
    crn_scene_put_u32(small + VEIN_AT + 48, CRN_SCENE_BED_KIDNEY);
    crn_scene_put_u32(small + VEIN_AT + 56, CRN_SCENE_BRANCH_IS_VEIN);
    for (uint32_t i = 0; i < 4; i++) {
        crn_scene_put_u32(small + 144 + 16 * i, 1000 * i);
        crn_scene_put_u32(small + 144 + 16 * i + 12, 150);
    }
}

static size_t write_file(int swaps_lesions)
{
    uint8_t meta[CRN_SCENE_META_BYTES], skin[SAMPLE_BODY_BYTES], tree[SAMPLE_TREE_BYTES],
        lesions[SAMPLE_LESIONS_BYTES];
    sample_meta(meta);
    sample_body(skin, "skin", -1);
    sample_tree(tree);
    sample_lesions(lesions);
    const crn_scene_part small_part = {CRN_SCENE_SMALL, small, sizeof small},
                         lesion_part = {CRN_SCENE_LESIONS, lesions, sizeof lesions};
    const crn_scene_part parts[5] = {{CRN_SCENE_META, meta, sizeof meta},
                                     {CRN_SCENE_BODY, skin, sizeof skin},
                                     {CRN_SCENE_TREE, tree, sizeof tree},
                                     swaps_lesions ? lesion_part : small_part,
                                     swaps_lesions ? small_part : lesion_part};
    return crn_scene_write(CRN_SCENE_KIND_BODIES, parts, 5, file, sizeof file);
}

static void expect_status(size_t at, uint32_t value, crn_scene_status wanted)
{
    make_small();
    if (at < sizeof small) crn_scene_put_u32(small + at, value);
    crn_scene scene;
    assert_int_equal(crn_scene_open(file, write_file(0), &scene, NULL), wanted);
}

static void small_vessels_give_back_what_was_written(void **state)
{
    (void)state;
    make_small();
    crn_scene scene;
    assert_int_equal(crn_scene_open(file, write_file(0), &scene, NULL), CRN_SCENE_OK);
    assert_int_equal(crn_scene_u16(file + 10), 7); /* minor version */
    assert_int_equal(scene.body_count, 1);
    assert_int_equal(scene.branch_count, 2);
    assert_int_equal(scene.lesion_count, 1);
    assert_int_equal(scene.small_count, 2);
    const crn_scene_branch_view artery = crn_scene_small(&scene, 0), vein = crn_scene_small(&scene, 1);
    assert_string_equal(artery.name, "arcuate");
    assert_int_equal(artery.parent, 1);
    assert_int_equal(artery.flow_mm3_per_s, 1600);
    assert_int_equal(artery.flags, 0);
    assert_int_equal(vein.parent, -1);
    assert_int_equal(vein.bed, CRN_SCENE_BED_KIDNEY);
    assert_int_equal(vein.flags, CRN_SCENE_BRANCH_IS_VEIN);
    assert_int_equal(crn_scene_u32(vein.points), 2000);
}

static void small_vessels_must_hang_on_the_tree(void **state)
{
    (void)state;
    expect_status(ARTERY_AT + 32, 2, CRN_SCENE_TREE_BRANCH);            /* of itself */
    expect_status(ARTERY_AT + 32, (uint32_t)-1, CRN_SCENE_TREE_BRANCH); /* an artery without a parent */
    expect_status(ARTERY_AT + 36, 2, CRN_SCENE_TREE_BRANCH);            /* beyond the parent's points */
    expect_status(VEIN_AT + 32, 2, CRN_SCENE_OK);                       /* the small vessel before it */
    expect_status(VEIN_AT + 48, CRN_SCENE_BED_COUNT, CRN_SCENE_TREE_BRANCH);
    expect_status(ARTERY_AT + 52, CRN_SCENE_SMALL_FLOW_MAX_nl_per_s + 1, CRN_SCENE_TREE_BRANCH);
    expect_status(VEIN_AT + 56, 4, CRN_SCENE_RESERVED);
    expect_status(VEIN_AT + 60, 1, CRN_SCENE_RESERVED);
    expect_status(0, 0, CRN_SCENE_TREE_SIZE);
    expect_status(144 + 12, 9, CRN_SCENE_TREE_POINT);
}

/* The vein becomes an artery, and the first artery joins it. Numbers 0 and 1 are the tree's branches. */
static void small_arteries_join_only_other_small_arteries(void **state)
{
    (void)state;
    const struct {
        uint32_t joins, flags, flags_of_other;
        crn_scene_status wanted;
    } cases[] = {{3, CRN_SCENE_BRANCH_JOINS, 0, CRN_SCENE_OK},
                 {2, CRN_SCENE_BRANCH_JOINS, 0, CRN_SCENE_TREE_BRANCH}, /* itself */
                 {1, CRN_SCENE_BRANCH_JOINS, 0, CRN_SCENE_TREE_BRANCH}, /* a vessel of the lumen */
                 {4, CRN_SCENE_BRANCH_JOINS, 0, CRN_SCENE_TREE_BRANCH}, /* not there */
                 {3, CRN_SCENE_BRANCH_JOINS, CRN_SCENE_BRANCH_IS_VEIN, CRN_SCENE_TREE_BRANCH},
                 {3, CRN_SCENE_BRANCH_JOINS | CRN_SCENE_BRANCH_IS_VEIN, 0, CRN_SCENE_TREE_BRANCH},
                 {3, 0, 0, CRN_SCENE_RESERVED}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        make_small();
        crn_scene_put_u32(small + VEIN_AT + 32, 1); /* a parent */
        crn_scene_put_u32(small + VEIN_AT + 56, cases[i].flags_of_other);
        crn_scene_put_u32(small + ARTERY_AT + 56, cases[i].flags);
        crn_scene_put_u32(small + ARTERY_AT + 60, cases[i].joins);
        crn_scene scene;
        assert_int_equal(crn_scene_open(file, write_file(0), &scene, NULL), cases[i].wanted);
        if (cases[i].wanted != CRN_SCENE_OK) continue;
        assert_int_equal(crn_scene_u16(file + 10), 8); /* minor version */
        assert_int_equal(crn_scene_small(&scene, 0).joins, 3);
    }
}

static void small_vessels_stand_between_tree_and_lesions(void **state)
{
    (void)state;
    make_small();
    crn_scene scene;
    assert_int_equal(crn_scene_open(file, write_file(1), &scene, NULL), CRN_SCENE_SECTION_TYPE);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(small_vessels_give_back_what_was_written),
        cmocka_unit_test(small_vessels_must_hang_on_the_tree),
        cmocka_unit_test(small_arteries_join_only_other_small_arteries),
        cmocka_unit_test(small_vessels_stand_between_tree_and_lesions),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
