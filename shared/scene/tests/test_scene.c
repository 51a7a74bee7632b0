/* Every broken scene is refused with its own code and byte position; the caller gets no part of it. The tests
 * cut small valid files at every length, flip every bit, and break the rules of docs/scene.md singly. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>

#include <cmocka.h>

#include "shared/scene/tests/scene_sample.h"

/* Scene sections begin at bytes 80 (META), 336 (ENTRY) and 368 (LUMEN), and bodies at bytes 336 and 496. */
enum { META_AT = 80, ENTRY_AT = 336, LUMEN_AT = 368, BONE_AT = 336, SKIN_AT = 496 };
/* A vessel tree adds a row to the section table. TREE has branches at bytes 16 and 80, points at byte 144. */
enum { TREE_AT = 672, RENAL_AT = TREE_AT + 80, POINTS_AT = TREE_AT + 144 };
/* Lesions add a row to the section table, and LESIONS begins after the section TREE of 224 bytes. */
enum { LESIONS_AT = TREE_AT + 16 + 224, LESION_AT = LESIONS_AT + 16, HEALTHY_AT = LESION_AT + 48 };
/* In the moving scene, LUMEN lies at bytes 400 .. 3468, and MOTION lies at bytes 3472 .. 7716. */
enum { MOTION_AT = 3472, BREATH_AT = 7728 };

static _Alignas(16) uint8_t file[SAMPLE_BYTES_MAX];
static size_t file_bytes;

static int make_scene(void **state)
{
    (void)state;
    memset(file, 0xee, sizeof file);
    file_bytes = sample_scene(file, sizeof file);
    return file_bytes == 0;
}

static int make_bodies(void **state)
{
    (void)state;
    memset(file, 0xee, sizeof file);
    file_bytes = sample_bodies(file, sizeof file);
    return file_bytes == 0;
}

static int make_bodies_with_tree(void **state)
{
    (void)state;
    memset(file, 0xee, sizeof file);
    file_bytes = sample_body_file(file, sizeof file, SAMPLE_TREE);
    return file_bytes == 0;
}

static int make_bodies_with_lesions(void **state)
{
    (void)state;
    memset(file, 0xee, sizeof file);
    file_bytes = sample_body_file(file, sizeof file, SAMPLE_LESIONS);
    return file_bytes == 0;
}

static int make_moving_scene(void **state)
{
    (void)state;
    memset(file, 0xee, sizeof file);
    file_bytes = sample_moving_scene(file, sizeof file);
    return file_bytes == 0;
}

static crn_scene_status open_file(uint32_t *where)
{
    crn_scene scene;
    memset(&scene, 0x5a, sizeof scene);
    crn_scene before = scene;
    crn_scene_status status = crn_scene_open(file, file_bytes, &scene, where);
    if (status != CRN_SCENE_OK && memcmp(&scene, &before, sizeof scene) != 0)
        fail_msg("a refused scene was handed out");
    return status;
}

static void refuses(crn_scene_status expected, uint32_t place)
{
    uint32_t where = 0;
    crn_scene_status status = open_file(&where);
    if (status != expected || where != place) {
        fail_msg("status %d (%s) at byte %u, expected %d (%s) at byte %u", status,
                 crn_scene_status_text(status), where, expected, crn_scene_status_text(expected), place);
    }
}

/* Writes a word, corrects the CRCs, and expects a refusal; then restores the word. */
static void refuses_word(size_t at, unsigned bytes, uint32_t value, crn_scene_status expected, uint32_t place)
{
    uint8_t saved[4];
    memcpy(saved, file + at, bytes);
    for (unsigned i = 0; i < bytes; i++) file[at + i] = (uint8_t)(value >> 8 * i);
    sample_seal(file, file_bytes);
    refuses(expected, place);
    memcpy(file + at, saved, bytes);
    sample_seal(file, file_bytes);
    assert_int_equal(open_file(NULL), CRN_SCENE_OK);
}

static void scene_gives_back_what_was_written(void **state)
{
    (void)state;
    crn_scene scene;
    assert_int_equal(crn_scene_open(file, file_bytes, &scene, NULL), CRN_SCENE_OK);
    assert_string_equal(scene.name, "sample");
    assert_string_equal(scene.source, "made by the tests");
    assert_int_equal(scene.entry_direction_q30[1], 1 << 30);
    assert_int_equal(scene.lumen.origin_m_q30[0], -(1 << 23));
    assert_int_equal(scene.lumen.brick_count_xyz[0], 2);
    assert_int_equal(scene.lumen.brick_count, SAMPLE_BRICKS);
    assert_int_equal(scene.lumen.index[1], 0x8000);
    assert_int_equal(scene.lumen.children[0], 0x8001);
    assert_int_equal(scene.lumen.samples[2999], (int8_t)(uint8_t)(2999 * 37));
    assert_int_equal(scene.hash, crn_scene_u32(file + 24));
}

static void bodies_give_back_what_was_written(void **state)
{
    (void)state;
    crn_scene scene;
    assert_int_equal(crn_scene_open(file, file_bytes, &scene, NULL), CRN_SCENE_OK);
    assert_int_equal(scene.body_count, 2);
    crn_scene_body_view bone = crn_scene_body(&scene, 0), skin = crn_scene_body(&scene, 1);
    assert_string_equal(bone.name, "bone");
    assert_string_equal(skin.material, "bone");
    assert_int_equal(bone.parent, 1);
    assert_int_equal(skin.parent, -1);
    assert_int_equal(crn_scene_i32(skin.vertices_um + 12), 1000000);
    assert_int_equal(crn_scene_u32(skin.triangles + 44), 3);
}

static void a_tree_gives_back_what_was_written(void **state)
{
    (void)state;
    crn_scene scene;
    assert_int_equal(crn_scene_open(file, file_bytes, &scene, NULL), CRN_SCENE_OK);
    assert_int_equal(scene.body_count, 2);
    assert_int_equal(scene.branch_count, 2);
    crn_scene_branch_view renal = crn_scene_branch(&scene, 1);
    assert_string_equal(renal.name, "renal");
    assert_int_equal(renal.parent, 0);
    assert_int_equal(renal.parent_point, 1);
    assert_int_equal(renal.point_count, 2);
    assert_int_equal(renal.flow_mm3_per_s, 8000);
    assert_int_equal(crn_scene_i32(renal.points + 16), 30000);
    assert_int_equal(crn_scene_u32(renal.points + 12), 3000);
}

/* Only a file that contains a vessel tree has the version number that requires a reader for trees. */
static void a_file_without_a_tree_is_of_the_old_version(void **state)
{
    (void)state;
    assert_int_equal(crn_scene_u16(file + 10), 1);
    sample_bodies(file, sizeof file);
    assert_int_equal(crn_scene_u16(file + 10), 0);
}

static void every_shorter_file_is_refused(void **state)
{
    (void)state;
    size_t whole = file_bytes;
    for (file_bytes = 0; file_bytes < whole; file_bytes++) {
        uint32_t where = 0;
        crn_scene_status status = open_file(&where);
        if (status != CRN_SCENE_TRUNCATED) fail_msg("cut to %zu bytes: status %d", file_bytes, status);
        assert_true(where <= file_bytes);
    }
    file_bytes = whole;
}

static void every_flipped_bit_is_refused(void **state)
{
    (void)state;
    for (size_t bit = 0; bit < 8 * file_bytes; bit++) {
        file[bit / 8] ^= (uint8_t)(1u << bit % 8);
        if (open_file(NULL) == CRN_SCENE_OK)
            fail_msg("bit %zu of byte %zu flipped: accepted", bit % 8, bit / 8);
        file[bit / 8] ^= (uint8_t)(1u << bit % 8);
    }
    assert_int_equal(open_file(NULL), CRN_SCENE_OK);
}

static void other_files_newer_and_older_ones_are_told_apart(void **state)
{
    (void)state;
    refuses_word(0, 4, 0x46445025, CRN_SCENE_MAGIC, 0); /* a PDF */
    refuses_word(8, 2, CRN_SCENE_MAJOR + 1, CRN_SCENE_NEWER, 8);
    refuses_word(10, 2, CRN_SCENE_MINOR + 1, CRN_SCENE_NEWER, 8);
    refuses_word(8, 2, 0, CRN_SCENE_OLDER, 8);
    refuses_word(12, 4, 7, CRN_SCENE_KIND, 12);
    refuses_word(28, 4, 1, CRN_SCENE_RESERVED, 28);
    refuses_word(24, 1, file[24] ^ 1u, CRN_SCENE_OK, 0); /* sealed again: this checks refuses_word itself */
}

static void a_scene_from_before_the_renaming_is_read(void **state)
{
    (void)state;
    refuses_word(0, 4, 0x444c4553, CRN_SCENE_OK, 0);
}

static void oversized_and_trailing_bytes_are_refused(void **state)
{
    (void)state;
    refuses_word(16, 4, CRN_SCENE_BYTES_MAX + 16, CRN_SCENE_OVERSIZED, 16);
    refuses_word(16, 4, 0xffffffffu, CRN_SCENE_OVERSIZED, 16);
    size_t whole = file_bytes;
    file_bytes = whole + 16;
    refuses(CRN_SCENE_TRAILING, (uint32_t)whole);
    file_bytes = whole;
}

static void an_unaligned_buffer_is_refused(void **state)
{
    (void)state;
    crn_scene scene;
    memmove(file + 1, file, file_bytes);
    assert_int_equal(crn_scene_open(file + 1, file_bytes, &scene, NULL), CRN_SCENE_UNALIGNED);
}

static void section_table_faults_are_refused(void **state)
{
    (void)state;
    refuses_word(20, 4, 2, CRN_SCENE_SECTION_COUNT, 20);
    refuses_word(20, 4, 0xffffffff, CRN_SCENE_SECTION_COUNT, 20);
    refuses_word(32, 4, CRN_SCENE_LUMEN, CRN_SCENE_SECTION_TYPE, 32);
    refuses_word(52, 4, META_AT, CRN_SCENE_SECTION_PLACE, 52);       /* ENTRY over META */
    refuses_word(52, 4, ENTRY_AT + 16, CRN_SCENE_SECTION_PLACE, 52); /* a gap */
    refuses_word(68, 4, 0xfffffff0u, CRN_SCENE_SECTION_PLACE, 68);
    refuses_word(72, 4, 0xfffffff0u, CRN_SCENE_SECTION_PLACE, 68);
    refuses_word(ENTRY_AT + 24, 1, 1, CRN_SCENE_RESERVED, ENTRY_AT + 24); /* padding */
    refuses_word(40, 4, 255, CRN_SCENE_SECTION_SIZE, META_AT);
    refuses_word(56, 4, 23, CRN_SCENE_SECTION_SIZE, ENTRY_AT);
}

static void a_damaged_section_is_told_from_a_damaged_header(void **state)
{
    (void)state;
    file[LUMEN_AT + 100] ^= 4;
    refuses(CRN_SCENE_SECTION_CRC, LUMEN_AT);
    file[LUMEN_AT + 100] ^= 4;
    file[44] ^= 4;
    refuses(CRN_SCENE_HEADER_CRC, 24);
}

static void texts_must_end_and_be_printable(void **state)
{
    (void)state;
    refuses_word(META_AT + 3, 1, '\n', CRN_SCENE_TEXT, META_AT + 3);
    refuses_word(META_AT + 63, 1, 'x', CRN_SCENE_TEXT, META_AT + 63);
    memset(file + META_AT, 'x', 64);
    sample_seal(file, file_bytes);
    refuses(CRN_SCENE_TEXT, META_AT);
}

static void entry_must_be_a_place_and_a_unit_vector(void **state)
{
    (void)state;
    refuses_word(ENTRY_AT + 4, 4, (uint32_t)CRN_SCENE_ENTRY_REACH_Q30 + 1, CRN_SCENE_ENTRY_POSITION,
                 ENTRY_AT + 4);
    refuses_word(ENTRY_AT + 8, 4, 0x80000000u, CRN_SCENE_ENTRY_POSITION, ENTRY_AT + 8);
    refuses_word(ENTRY_AT + 16, 4, 0, CRN_SCENE_ENTRY_DIRECTION, ENTRY_AT + 12);
    refuses_word(ENTRY_AT + 16, 4, (1u << 30) + 2000, CRN_SCENE_ENTRY_DIRECTION, ENTRY_AT + 12);
    refuses_word(ENTRY_AT + 12, 4, 0x80000000u, CRN_SCENE_ENTRY_DIRECTION, ENTRY_AT + 12);
}

static void lattice_and_index_must_stay_inside(void **state)
{
    (void)state;
    const uint32_t lumen = LUMEN_AT, index = LUMEN_AT + 32, children = LUMEN_AT + 36;
    refuses_word(lumen + 12, 2, 0, CRN_SCENE_LATTICE, lumen + 12);
    refuses_word(lumen + 16, 2, 513, CRN_SCENE_LATTICE, lumen + 16);
    refuses_word(lumen, 4, 0x7fffffffu, CRN_SCENE_LATTICE, lumen);
    refuses_word(lumen + 14, 2, 2, CRN_SCENE_SECTION_SIZE, lumen + 12);
    refuses_word(lumen + 20, 4, 4, CRN_SCENE_SECTION_SIZE, lumen + 12);
    refuses_word(lumen + 20, 4, 0x83126f, CRN_SCENE_SECTION_SIZE, lumen + 12); /* x 1000 passes 2^32 */
    refuses_word(lumen + 24, 2, 3, CRN_SCENE_CHILD_ROWS, lumen + 24);
    refuses_word(lumen + 26, 2, 1, CRN_SCENE_RESERVED, lumen + 26);
    refuses_word(index, 2, 2 + SAMPLE_BRICKS, CRN_SCENE_INDEX_BRICK, index);
    refuses_word(index, 2, 0x7fff, CRN_SCENE_INDEX_BRICK, index);
    refuses_word(index, 2, 0x8001, CRN_SCENE_INDEX_ROW, index);       /* a row of the second rank */
    refuses_word(children, 2, 0x8000, CRN_SCENE_INDEX_ROW, children); /* itself: a circle */
    refuses_word(children, 2, 0x8002, CRN_SCENE_INDEX_ROW, children);
    refuses_word(children + 16, 2, 0x8001, CRN_SCENE_INDEX_ROW, children + 16); /* a third refinement */
    refuses_word(children + 30, 2, 5, CRN_SCENE_INDEX_BRICK, children + 30);
}

static void bodies_must_be_whole_and_lie_in_each_other_without_circle(void **state)
{
    (void)state;
    refuses_word(BONE_AT + 48, 4, 2, CRN_SCENE_BODY_PARENT, BONE_AT + 48);
    refuses_word(BONE_AT + 48, 4, (uint32_t)-2, CRN_SCENE_BODY_PARENT, BONE_AT + 48);
    refuses_word(BONE_AT + 48, 4, 0, CRN_SCENE_BODY_PARENT, BONE_AT + 48);
    refuses_word(SKIN_AT + 48, 4, 0, CRN_SCENE_BODY_PARENT, BONE_AT + 48); /* bone in skin in bone */
    refuses_word(SKIN_AT + 56, 4, 0, CRN_SCENE_BODY_SIZE, SKIN_AT + 56);
    refuses_word(SKIN_AT + 56, 4, 0xffffffffu, CRN_SCENE_BODY_SIZE, SKIN_AT + 56);
    refuses_word(SKIN_AT + 52, 4, 5, CRN_SCENE_SECTION_SIZE, SKIN_AT + 52);
    refuses_word(SKIN_AT + 60, 4, 4, CRN_SCENE_RESERVED, SKIN_AT + 60);
    refuses_word(SKIN_AT + 64, 4, 2000001, CRN_SCENE_BODY_VERTEX, SKIN_AT + 64);
    refuses_word(SKIN_AT + 112, 4, 4, CRN_SCENE_BODY_TRIANGLE, SKIN_AT + 112);
    refuses_word(SKIN_AT + 116, 4, 0, CRN_SCENE_BODY_TRIANGLE, SKIN_AT + 112);
    refuses_word(SKIN_AT + 32 + 15, 1, 'x', CRN_SCENE_TEXT, SKIN_AT + 32 + 15);
}

static void a_tree_must_hang_together(void **state)
{
    (void)state;
    refuses_word(TREE_AT, 4, 0, CRN_SCENE_TREE_SIZE, TREE_AT);
    refuses_word(TREE_AT, 4, 3, CRN_SCENE_SECTION_SIZE, TREE_AT);
    refuses_word(TREE_AT + 4, 4, 200001, CRN_SCENE_TREE_SIZE, TREE_AT + 4);
    refuses_word(TREE_AT + 8, 4, 1, CRN_SCENE_RESERVED, TREE_AT + 8);
    refuses_word(TREE_AT + 16 + 32, 4, 0, CRN_SCENE_TREE_BRANCH, TREE_AT + 16 + 32);
    refuses_word(RENAL_AT + 31, 1, 'x', CRN_SCENE_TEXT, RENAL_AT + 31);
    refuses_word(RENAL_AT + 32, 4, 1, CRN_SCENE_TREE_BRANCH, RENAL_AT + 32);            /* of itself */
    refuses_word(RENAL_AT + 32, 4, (uint32_t)-1, CRN_SCENE_TREE_BRANCH, RENAL_AT + 32); /* a second root */
    refuses_word(RENAL_AT + 36, 4, 3, CRN_SCENE_TREE_BRANCH, RENAL_AT + 36);
    refuses_word(RENAL_AT + 40, 4, 2, CRN_SCENE_TREE_SIZE, RENAL_AT + 40);
    refuses_word(RENAL_AT + 44, 4, 1, CRN_SCENE_TREE_SIZE, RENAL_AT + 44);
    refuses_word(RENAL_AT + 44, 4, 3, CRN_SCENE_TREE_SIZE, TREE_AT + 4);
    refuses_word(RENAL_AT + 44, 4, 0xffffffffu, CRN_SCENE_TREE_SIZE, RENAL_AT + 44);
    refuses_word(RENAL_AT + 48, 4, CRN_SCENE_BED_COUNT, CRN_SCENE_TREE_BRANCH, RENAL_AT + 48);
    refuses_word(RENAL_AT + 52, 4, 1000001, CRN_SCENE_TREE_BRANCH, RENAL_AT + 52);
    refuses_word(RENAL_AT + 60, 4, 1, CRN_SCENE_RESERVED, RENAL_AT + 60);
    refuses_word(POINTS_AT, 4, 2000001, CRN_SCENE_TREE_POINT, POINTS_AT);
    refuses_word(POINTS_AT + 16 + 4, 4, 0, CRN_SCENE_TREE_POINT, POINTS_AT + 16); /* twice the same place */
    refuses_word(POINTS_AT + 12, 4, 9, CRN_SCENE_TREE_POINT, POINTS_AT + 12);
    refuses_word(POINTS_AT + 12, 4, 100001, CRN_SCENE_TREE_POINT, POINTS_AT + 12);
}

/* The only vessel tree must come after the bodies: row 3 of the section table belongs to the tree. */
static void a_tree_stands_behind_the_bodies(void **state)
{
    (void)state;
    refuses_word(32 + 16, 4, CRN_SCENE_TREE, CRN_SCENE_SECTION_TYPE, 32 + 16);
    refuses_word(32 + 48, 4, CRN_SCENE_LUMEN, CRN_SCENE_SECTION_TYPE, 32 + 48);
}

static void lesions_give_back_what_was_written(void **state)
{
    (void)state;
    crn_scene scene;
    assert_int_equal(crn_scene_open(file, file_bytes, &scene, NULL), CRN_SCENE_OK);
    assert_int_equal(scene.body_count, 2);
    assert_int_equal(scene.branch_count, 2);
    assert_int_equal(scene.lesion_count, 1);
    assert_int_equal(crn_scene_u16(file + 10), 2); /* minor version */
    crn_scene_lesion_view lesion = crn_scene_lesion(&scene, 0);
    assert_string_equal(lesion.name, "coarctation");
    assert_int_equal(lesion.branch, 0);
    assert_int_equal(lesion.first_point, 0);
    assert_int_equal(lesion.point_count, 3);
    assert_int_equal(crn_scene_i32(lesion.healthy_points + 32 + 4), 40000);
    assert_int_equal(crn_scene_u32(lesion.healthy_points + 32 + 12), 9000);
}

static void a_lesion_lies_where_there_is_vessel(void **state)
{
    (void)state;
    refuses_word(LESIONS_AT, 4, 0, CRN_SCENE_LESION_SIZE, LESIONS_AT);
    refuses_word(LESIONS_AT, 4, 33, CRN_SCENE_LESION_SIZE, LESIONS_AT);
    refuses_word(LESIONS_AT, 4, 2, CRN_SCENE_SECTION_SIZE, LESIONS_AT);
    refuses_word(LESIONS_AT + 4, 4, 0xffffffffu, CRN_SCENE_SECTION_SIZE, LESIONS_AT);
    refuses_word(LESIONS_AT + 12, 4, 1, CRN_SCENE_RESERVED, LESIONS_AT + 8);
    refuses_word(LESION_AT + 31, 1, 'x', CRN_SCENE_TEXT, LESION_AT + 31);
    refuses_word(LESION_AT + 32, 4, 2, CRN_SCENE_LESION_PLACE, LESION_AT + 32);
    refuses_word(LESION_AT + 32, 4, 1, CRN_SCENE_LESION_PLACE, LESION_AT + 40); /* it has two points */
    refuses_word(LESION_AT + 36, 4, 3, CRN_SCENE_LESION_PLACE, LESION_AT + 36);
    refuses_word(LESION_AT + 36, 4, 1, CRN_SCENE_LESION_PLACE, LESION_AT + 40);
    refuses_word(LESION_AT + 40, 4, 2, CRN_SCENE_LESION_PLACE, LESION_AT + 40);
    refuses_word(LESION_AT + 40, 4, 0xffffffffu, CRN_SCENE_LESION_PLACE, LESION_AT + 40);
    refuses_word(LESION_AT + 44, 4, 1, CRN_SCENE_LESION_SIZE, LESION_AT + 44);
    refuses_word(HEALTHY_AT + 4, 4, 2000001, CRN_SCENE_LESION_PLACE, HEALTHY_AT + 4);
    refuses_word(HEALTHY_AT + 12, 4, 9, CRN_SCENE_LESION_PLACE, HEALTHY_AT + 12);
}

/* Rows 3 and 4 of the section table belong to the vessel tree and to the lesions. */
static void lesions_stand_behind_their_tree(void **state)
{
    (void)state;
    refuses_word(32 + 48, 4, CRN_SCENE_BODY, CRN_SCENE_SECTION_TYPE, 32 + 64);
    refuses_word(32 + 48, 4, CRN_SCENE_LESIONS, CRN_SCENE_SECTION_TYPE, 32 + 48);
    refuses_word(32 + 64, 4, CRN_SCENE_TREE, CRN_SCENE_SECTION_TYPE, 32 + 48);
}

static void a_moving_scene_gives_back_its_lattice(void **state)
{
    (void)state;
    crn_scene scene;
    assert_int_equal(crn_scene_open(file, file_bytes, &scene, NULL), CRN_SCENE_OK);
    assert_true(scene.has_motion);
    assert_int_equal(scene.motion.origin_m_q30[0], -(1 << 23));
    assert_int_equal(scene.motion.node_count_xyz[2], SAMPLE_NODES);
    assert_int_equal(scene.motion.spacing_log2_q30, 23);
    const int16_t *row = scene.motion.rows + (size_t)SAMPLE_MIDDLE * 3 * CRN_SCENE_MOTION_ROW;
    assert_int_equal(row[3], 132);
    assert_true(scene.has_breath);
    assert_int_equal(scene.breath.origin_m_q30[2], 0);
    assert_int_equal(scene.breath.node_count_xyz[1], SAMPLE_NODES);
    assert_int_equal(scene.breath.rows[3 * SAMPLE_MIDDLE + 1], 262);
    assert_int_equal(crn_scene_u16(file + 10), 4); /* minor version */
    make_scene(state);
    assert_int_equal(crn_scene_open(file, file_bytes, &scene, NULL), CRN_SCENE_OK);
    assert_false(scene.has_motion || scene.has_breath);
    assert_int_equal(crn_scene_u16(file + 10), 0);
}

static void a_body_may_move_and_have_trabeculae(void **state)
{
    (void)state;
    crn_scene scene;
    crn_scene_put_u16(file + 10, 10); /* minor version */
    crn_scene_put_u32(file + SKIN_AT + 60, CRN_SCENE_BODY_MOVES | CRN_SCENE_BODY_TRABECULAE);
    sample_seal(file, file_bytes);
    assert_int_equal(crn_scene_open(file, file_bytes, &scene, NULL), CRN_SCENE_OK);
    assert_false(crn_scene_body(&scene, 0).moves || crn_scene_body(&scene, 0).is_trabecular);
    assert_true(crn_scene_body(&scene, 1).moves && crn_scene_body(&scene, 1).is_trabecular);
}

/* The test breaks the rules of the MOTION and BREATH sections one at a time. The spacing is 4096 units, so
 * neighbouring nodes' displacements may differ by 2560 units (heartbeat) or 1536 units (breath). */
static void a_lattice_must_fit_the_cores_arithmetic_and_stand_still_at_its_boundary(void **state)
{
    (void)state;
    const uint32_t middle = MOTION_AT + (uint32_t)sample_motion_at(SAMPLE_MIDDLE, 0, 0);
    const uint32_t breath = BREATH_AT + 32 + 2 * 3 * SAMPLE_MIDDLE;
    const uint32_t before = middle - 6 * CRN_SCENE_MOTION_ROW; /* the node that precedes it along x */
    refuses_word(MOTION_AT + 18, 2, 19, CRN_SCENE_MOTION_LATTICE, MOTION_AT + 18);
    refuses_word(MOTION_AT + 18, 2, 25, CRN_SCENE_MOTION_LATTICE, MOTION_AT + 18);
    refuses_word(MOTION_AT + 20, 2, 23, CRN_SCENE_MOTION_LATTICE, MOTION_AT + 18);
    refuses_word(MOTION_AT + 12, 2, 1, CRN_SCENE_MOTION_LATTICE, MOTION_AT + 12);
    refuses_word(MOTION_AT + 16, 2, 257, CRN_SCENE_MOTION_LATTICE, MOTION_AT + 16);
    refuses_word(MOTION_AT + 4, 4, 0x7fffffffu, CRN_SCENE_MOTION_LATTICE, MOTION_AT + 4);
    refuses_word(MOTION_AT + 14, 2, 4, CRN_SCENE_SECTION_SIZE, MOTION_AT + 12);
    refuses_word(MOTION_AT + 28, 4, 1, CRN_SCENE_RESERVED, MOTION_AT + 22);
    refuses_word(MOTION_AT + 32 + 2 * 5, 2, 16385, CRN_SCENE_MOTION_VALUE, MOTION_AT + 32);
    refuses_word(middle + 2 * 24, 2, 1, CRN_SCENE_MOTION_VALUE, middle); /* this differs from keyframe 23 */
    refuses_word(middle + 2 * 5, 2, 2561, CRN_SCENE_MOTION_STEEP, middle - 9 * 6 * CRN_SCENE_MOTION_ROW);
    refuses_word(before + 2 * 5, 2, 1, CRN_SCENE_MOTION_EDGE, before);
    refuses_word(BREATH_AT + 20, 2, CRN_SCENE_MOTION_KEYFRAMES, CRN_SCENE_MOTION_LATTICE, BREATH_AT + 18);
    refuses_word(BREATH_AT + 14, 2, 4, CRN_SCENE_SECTION_SIZE, BREATH_AT + 12);
    refuses_word(BREATH_AT + 32, 2, 16385, CRN_SCENE_MOTION_VALUE, BREATH_AT + 32);
    refuses_word(breath, 2, 1537, CRN_SCENE_MOTION_STEEP, breath - 9 * 6);
    refuses_word(breath - 6, 2, 1, CRN_SCENE_MOTION_EDGE, breath - 6);
}

/* Before minor version 4 of the scene format, breath was stored in the rows of the heartbeat. */
static void a_motion_of_an_older_format_is_refused_by_name(void **state)
{
    (void)state;
    refuses_word(10, 2, 3, CRN_SCENE_MOTION_OLDER, 10);
}

/* In the scene with plaques, LUMEN lies at bytes 384 .. 3452, after a section table of 64 bytes. */
enum { PLAQUES_AT = 3456, PLAQUE_AT = PLAQUES_AT + 16, STATIONS_AT = PLAQUE_AT + 80 };

static int make_diseased_scene(void **state)
{
    (void)state;
    memset(file, 0xee, sizeof file);
    file_bytes = sample_diseased_scene(file, sizeof file, false);
    return file_bytes == 0;
}

static void plaques_give_back_what_was_written(void **state)
{
    (void)state;
    crn_scene scene;
    for (int moves = 0; moves < 2; moves++) {
        file_bytes = sample_diseased_scene(file, sizeof file, moves != 0);
        assert_int_equal(crn_scene_open(file, file_bytes, &scene, NULL), CRN_SCENE_OK);
        assert_int_equal(scene.has_motion, moves);
        assert_int_equal(scene.plaque_count, 1);
        assert_int_equal(crn_scene_u16(file + 10), moves ? 4 : 3); /* minor version */
        const crn_scene_plaque_view plaque = crn_scene_plaque(&scene, 0);
        assert_int_equal(plaque.high_m_q30[2], 5 * 1073742);
        assert_int_equal(plaque.chord_q30[1], 1 << 30);
        assert_int_equal(plaque.spacing_log2_q30, 20);
        assert_int_equal(plaque.station_count, SAMPLE_STATIONS);
        assert_int_equal(plaque.yield_Pa, 500000);
        assert_int_equal(plaque.pace_q30, 1 << 22);
        assert_int_equal(crn_scene_i32(plaque.stations + 2 * 48 + 4), 2 << 20);
    }
    make_scene(state);
    assert_int_equal(crn_scene_open(file, file_bytes, &scene, NULL), CRN_SCENE_OK);
    assert_int_equal(scene.plaque_count, 0);
}

/* The test breaks the rules of the PLAQUES section one at a time. */
static void a_plaque_must_fit_the_cores_arithmetic(void **state)
{
    (void)state;
    static const struct {
        uint32_t at, value;
    } record[] = {{0, 5u << 27},
                  {12, 0x80000000u},
                  {24, 1u << 29},
                  {36, (1u << 28) - 1},
                  {36, (1u << 29) + 1},
                  {40, 16},
                  {40, 23},
                  {44, 2},
                  {44, 25},
                  {44, 4},
                  {48, 0},
                  {48, 4000001},
                  {52, 999},
                  {56, 0xffffffffu},
                  {56, (1u << 30) + 1},
                  {60, 0},
                  {60, 1u << 29},
                  {64, 1},
                  {68, 1},
                  {76, 1}},
      station[] = {{0, 6000000},  {12, 10000},    {12, 30000000}, {28, 10000}, {28, 2147485},
                   {16, 5000000}, {36, 1u << 29}, {32, 1u << 30}, {44, 1},     {4, 3u << 20}};
    for (size_t i = 0; i < sizeof record / sizeof record[0]; i++)
        refuses_word(PLAQUE_AT + record[i].at, 4, record[i].value, CRN_SCENE_PLAQUE, PLAQUE_AT);
    for (size_t i = 0; i < sizeof station / sizeof station[0]; i++)
        refuses_word(STATIONS_AT + 48 + station[i].at, 4, station[i].value, CRN_SCENE_PLAQUE,
                     STATIONS_AT + 48);
    refuses_word(PLAQUES_AT, 4, 0, CRN_SCENE_PLAQUE, PLAQUES_AT);
    refuses_word(PLAQUES_AT, 4, 5, CRN_SCENE_PLAQUE, PLAQUES_AT);
    refuses_word(PLAQUES_AT + 4, 4, 4, CRN_SCENE_SECTION_SIZE, PLAQUES_AT);
    refuses_word(PLAQUES_AT + 8, 4, 1, CRN_SCENE_RESERVED, PLAQUES_AT + 8);
}

static void every_status_has_its_own_sentence(void **state)
{
    (void)state;
    for (int a = 0; a < CRN_SCENE_STATUS_COUNT; a++) {
        assert_non_null(crn_scene_status_text((crn_scene_status)a));
        for (int b = 0; b < a; b++) {
            assert_string_not_equal(crn_scene_status_text((crn_scene_status)a),
                                    crn_scene_status_text((crn_scene_status)b));
        }
    }
    assert_non_null(crn_scene_status_text(CRN_SCENE_STATUS_COUNT));
}

static void writer_refuses_a_buffer_that_is_too_small(void **state)
{
    (void)state;
    assert_int_equal(sample_scene(file, file_bytes - 1), 0);
    assert_int_equal(sample_scene(file, file_bytes), file_bytes);
}

/* An empty file has no bytes, and its address is NULL; the sanitizers show that no byte is read. */
static void no_bytes_at_all_are_refused(void **state)
{
    (void)state;
    crn_scene scene;
    uint32_t where = 7;
    assert_int_equal(crn_scene_open(NULL, 0, &scene, &where), CRN_SCENE_TRUNCATED);
    assert_int_equal(where, 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup(scene_gives_back_what_was_written, make_scene),
        cmocka_unit_test_setup(bodies_give_back_what_was_written, make_bodies),
        cmocka_unit_test(no_bytes_at_all_are_refused),
        cmocka_unit_test_setup(every_shorter_file_is_refused, make_scene),
        cmocka_unit_test_setup(every_flipped_bit_is_refused, make_scene),
        {"every_shorter_body_file_is_refused", every_shorter_file_is_refused, make_bodies, NULL, NULL},
        {"every_flipped_bit_of_a_body_file_is_refused", every_flipped_bit_is_refused, make_bodies, NULL,
         NULL},
        cmocka_unit_test_setup(other_files_newer_and_older_ones_are_told_apart, make_scene),
        cmocka_unit_test_setup(a_scene_from_before_the_renaming_is_read, make_scene),
        cmocka_unit_test_setup(oversized_and_trailing_bytes_are_refused, make_scene),
        cmocka_unit_test_setup(an_unaligned_buffer_is_refused, make_scene),
        cmocka_unit_test_setup(section_table_faults_are_refused, make_scene),
        cmocka_unit_test_setup(a_damaged_section_is_told_from_a_damaged_header, make_scene),
        cmocka_unit_test_setup(texts_must_end_and_be_printable, make_scene),
        cmocka_unit_test_setup(entry_must_be_a_place_and_a_unit_vector, make_scene),
        cmocka_unit_test_setup(lattice_and_index_must_stay_inside, make_scene),
        cmocka_unit_test_setup(bodies_must_be_whole_and_lie_in_each_other_without_circle, make_bodies),
        cmocka_unit_test_setup(a_tree_gives_back_what_was_written, make_bodies_with_tree),
        cmocka_unit_test_setup(a_file_without_a_tree_is_of_the_old_version, make_bodies_with_tree),
        cmocka_unit_test_setup(a_tree_must_hang_together, make_bodies_with_tree),
        cmocka_unit_test_setup(a_tree_stands_behind_the_bodies, make_bodies_with_tree),
        {"every_flipped_bit_of_a_tree_is_refused", every_flipped_bit_is_refused, make_bodies_with_tree, NULL,
         NULL},
        cmocka_unit_test_setup(lesions_give_back_what_was_written, make_bodies_with_lesions),
        cmocka_unit_test_setup(a_lesion_lies_where_there_is_vessel, make_bodies_with_lesions),
        cmocka_unit_test_setup(lesions_stand_behind_their_tree, make_bodies_with_lesions),
        cmocka_unit_test_setup(a_moving_scene_gives_back_its_lattice, make_moving_scene),
        cmocka_unit_test_setup(a_body_may_move_and_have_trabeculae, make_bodies),
        cmocka_unit_test_setup(a_lattice_must_fit_the_cores_arithmetic_and_stand_still_at_its_boundary,
                               make_moving_scene),
        cmocka_unit_test_setup(a_motion_of_an_older_format_is_refused_by_name, make_moving_scene),
        {"every_shorter_moving_scene_is_refused", every_shorter_file_is_refused, make_moving_scene, NULL,
         NULL},
        cmocka_unit_test_setup(plaques_give_back_what_was_written, make_diseased_scene),
        cmocka_unit_test_setup(a_plaque_must_fit_the_cores_arithmetic, make_diseased_scene),
        cmocka_unit_test_setup(every_shorter_file_is_refused, make_diseased_scene),
        cmocka_unit_test_setup(every_flipped_bit_is_refused, make_diseased_scene),
        cmocka_unit_test(every_status_has_its_own_sentence),
        cmocka_unit_test_setup(writer_refuses_a_buffer_that_is_too_small, make_scene),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
