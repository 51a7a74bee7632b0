/* This header makes small valid files for the tests of the scene container, and has a function that corrects
 * the CRCs of a file that a test has changed. */
#ifndef CRN_SCENE_SAMPLE_H
#define CRN_SCENE_SAMPLE_H

#include "shared/scene/scene_write.h"
#include "shared/wire/wire_frame.h"

#include <string.h>

enum {
    SAMPLE_BYTES_MAX = 16384,
    SAMPLE_LATTICE = 2, /* coarse bricks: 2 x 1 x 1 */
    SAMPLE_ROWS = 2,
    SAMPLE_BRICKS = 3,
    SAMPLE_LUMEN_BYTES = 32 + 2 * SAMPLE_LATTICE + 16 * SAMPLE_ROWS + 1000 * SAMPLE_BRICKS,
    SAMPLE_BODY_BYTES = 64 + 12 * 4 + 12 * 4,
    SAMPLE_TREE_BYTES = 16 + 2 * 64 + 5 * 16,
    SAMPLE_NODES = 3, /* along each axis: only the middle one may move */
    SAMPLE_MIDDLE = 13,
    SAMPLE_MOTION_BYTES = 32 + SAMPLE_NODES * SAMPLE_NODES * SAMPLE_NODES * 3 * CRN_SCENE_MOTION_ROW * 2,
    SAMPLE_BREATH_BYTES = 32 + SAMPLE_NODES * SAMPLE_NODES * SAMPLE_NODES * 3 * 2,
};

static inline void sample_meta(uint8_t *meta)
{
    memset(meta, 0, CRN_SCENE_META_BYTES);
    memcpy(meta, "sample", 6);
    memcpy(meta + CRN_SCENE_NAME_BYTES, "made by the tests", 17);
}

static inline void sample_entry(uint8_t *entry)
{
    memset(entry, 0, CRN_SCENE_ENTRY_BYTES);
    crn_scene_put_u32(entry + 16, 1u << 30); /* +y */
}

/* In the sample's index, the entry of coarse brick 0 refers to brick 0, and the entry of coarse brick 1 to
 * child row 0. The first octant of row 0 refers to row 1, and all other octants refer to bricks 1 and 2. */
static inline void sample_lumen(uint8_t *lumen)
{
    memset(lumen, 0, SAMPLE_LUMEN_BYTES);
    crn_scene_put_u32(lumen, (uint32_t) - (1 << 23));
    crn_scene_put_u16(lumen + 12, 2);
    crn_scene_put_u16(lumen + 14, 1);
    crn_scene_put_u16(lumen + 16, 1);
    crn_scene_put_u16(lumen + 18, SAMPLE_ROWS);
    crn_scene_put_u32(lumen + 20, SAMPLE_BRICKS);
    crn_scene_put_u16(lumen + 24, 1);
    crn_scene_put_u16(lumen + 32, 2);
    crn_scene_put_u16(lumen + 34, 0x8000);
    for (int i = 0; i < 16; i++)
        crn_scene_put_u16(lumen + 36 + 2 * i, (uint16_t)(i == 0 ? 0x8001 : i < 8 ? 3 : 4));
    for (int i = 0; i < 1000 * SAMPLE_BRICKS; i++) lumen[68 + i] = (uint8_t)(i * 37);
}

/* If `start_um` is 0, the scene states no start length. */
static inline size_t sample_scene_starting(uint32_t start_um, uint8_t *file, size_t capacity)
{
    uint8_t meta[CRN_SCENE_META_BYTES], entry[CRN_SCENE_ENTRY_START_BYTES], lumen[SAMPLE_LUMEN_BYTES];
    sample_meta(meta);
    sample_entry(entry);
    crn_scene_put_u32(entry + CRN_SCENE_ENTRY_BYTES, start_um);
    sample_lumen(lumen);
    const crn_scene_part parts[3] = {
        {CRN_SCENE_META, meta, sizeof meta},
        {CRN_SCENE_ENTRY, entry, start_um > 0 ? CRN_SCENE_ENTRY_START_BYTES : CRN_SCENE_ENTRY_BYTES},
        {CRN_SCENE_LUMEN, lumen, sizeof lumen}};
    return crn_scene_write(CRN_SCENE_KIND_SCENE, parts, 3, file, capacity);
}

static inline size_t sample_scene(uint8_t *file, size_t capacity)
{
    return sample_scene_starting(0, file, capacity);
}

/* Returns where, in the MOTION section, the number for keyframe column `i`, component `k` and node `node`
 * begins. */
static inline size_t sample_motion_at(int node, int k, int i)
{
    return 32 + 2 * (size_t)((node * 3 + k) * CRN_SCENE_MOTION_ROW + i);
}

/* Writes the header of a lattice with nodes 7.8 mm apart. */
static inline void sample_lattice(uint8_t *motion)
{
    crn_scene_put_u32(motion, (uint32_t) - (1 << 23));
    for (int k = 0; k < 3; k++) crn_scene_put_u16(motion + 12 + 2 * k, SAMPLE_NODES);
    crn_scene_put_u16(motion + 18, 23);
}

/* In this sample scene, the lattice's middle node moves by 0.5 mm along y with the breath. */
static inline void sample_breath(uint8_t *breath)
{
    memset(breath, 0, SAMPLE_BREATH_BYTES);
    sample_lattice(breath);
    crn_scene_put_u16(breath + 32 + 2 * (3 * SAMPLE_MIDDLE + 1), 262);
}

/* In this sample scene, the lattice's middle node moves by 1 mm along x and back in each heartbeat. */
static inline void sample_motion(uint8_t *motion)
{
    memset(motion, 0, SAMPLE_MOTION_BYTES);
    sample_lattice(motion);
    crn_scene_put_u16(motion + 20, CRN_SCENE_MOTION_KEYFRAMES);
    for (int i = 0; i < CRN_SCENE_MOTION_KEYFRAMES + 2; i++) {
        const int key = i % CRN_SCENE_MOTION_KEYFRAMES;
        crn_scene_put_u16(motion + sample_motion_at(SAMPLE_MIDDLE, 0, i),
                          (uint16_t)(key < 12 ? 44 * key : 44 * (24 - key)));
    }
}

static inline size_t sample_moving_scene(uint8_t *file, size_t capacity)
{
    uint8_t meta[CRN_SCENE_META_BYTES], entry[CRN_SCENE_ENTRY_BYTES], lumen[SAMPLE_LUMEN_BYTES],
        motion[SAMPLE_MOTION_BYTES], breath[SAMPLE_BREATH_BYTES];
    sample_meta(meta);
    sample_entry(entry);
    sample_lumen(lumen);
    sample_motion(motion);
    sample_breath(breath);
    const crn_scene_part parts[5] = {{CRN_SCENE_META, meta, sizeof meta},
                                     {CRN_SCENE_ENTRY, entry, sizeof entry},
                                     {CRN_SCENE_LUMEN, lumen, sizeof lumen},
                                     {CRN_SCENE_MOTION, motion, sizeof motion},
                                     {CRN_SCENE_BREATH, breath, sizeof breath}};
    return crn_scene_write(CRN_SCENE_KIND_SCENE, parts, 5, file, capacity);
}

enum { SAMPLE_STATIONS = 3, SAMPLE_PLAQUES_BYTES = 16 + 80 + SAMPLE_STATIONS * 48 };

/* Writes one plaque along +y, whose points (stations) are 0.98 mm apart. The plaque narrows the vessel from
 * its healthy radius of 2 mm to a radius of 1 mm. */
static inline void sample_plaques(uint8_t *plaques)
{
    const uint32_t one_q30 = 1u << 30, mm_q30 = 1073742, spacing = 1u << 20;
    memset(plaques, 0, SAMPLE_PLAQUES_BYTES);
    crn_scene_put_u32(plaques, 1);
    crn_scene_put_u32(plaques + 4, SAMPLE_STATIONS);
    uint8_t *record = plaques + 16;
    for (int k = 0; k < 3; k++) {
        crn_scene_put_u32(record + 4 * k, 0u - 5 * mm_q30);
        crn_scene_put_u32(record + 12 + 4 * k, 5 * mm_q30);
    }
    const uint32_t numbers[] = {0,      one_q30, 0,           1u << 28, 20, SAMPLE_STATIONS,
                                500000, 300000,  one_q30 / 3, 1 << 22};
    for (size_t i = 0; i < sizeof numbers / sizeof numbers[0]; i++)
        crn_scene_put_u32(record + 24 + 4 * i, numbers[i]);
    for (uint32_t i = 0; i < SAMPLE_STATIONS; i++) {
        uint8_t *station = record + 80 + 48 * (size_t)i;
        crn_scene_put_u32(station + 4, i * spacing);
        crn_scene_put_u32(station + 12, 2 * mm_q30);
        crn_scene_put_u32(station + 16, mm_q30 / 2);
        crn_scene_put_u32(station + 20, i * spacing);
        crn_scene_put_u32(station + 28, mm_q30);
        crn_scene_put_u32(station + 36, one_q30);
    }
}

/* The PLAQUES section follows the lumen or, in a moving scene, the lumen's motion. */
static inline size_t sample_diseased_scene(uint8_t *file, size_t capacity, bool moves)
{
    uint8_t meta[CRN_SCENE_META_BYTES], entry[CRN_SCENE_ENTRY_BYTES], lumen[SAMPLE_LUMEN_BYTES],
        motion[SAMPLE_MOTION_BYTES], plaques[SAMPLE_PLAQUES_BYTES];
    sample_meta(meta);
    sample_entry(entry);
    sample_lumen(lumen);
    sample_motion(motion);
    sample_plaques(plaques);
    crn_scene_part parts[5] = {{CRN_SCENE_META, meta, sizeof meta},
                               {CRN_SCENE_ENTRY, entry, sizeof entry},
                               {CRN_SCENE_LUMEN, lumen, sizeof lumen},
                               {CRN_SCENE_MOTION, motion, sizeof motion}};
    parts[moves ? 4 : 3] = (crn_scene_part){CRN_SCENE_PLAQUES, plaques, sizeof plaques};
    return crn_scene_write(CRN_SCENE_KIND_SCENE, parts, moves ? 5 : 4, file, capacity);
}

/* Writes a body with the name `name` that has the shape of a tetrahedron with three perpendicular edges of 1
 * m. */
static inline void sample_body(uint8_t *body, const char *name, int32_t parent)
{
    static const uint32_t triangles[12] = {0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3};
    memset(body, 0, SAMPLE_BODY_BYTES);
    memcpy(body, name, strlen(name));
    memcpy(body + 32, "bone", 4);
    crn_scene_put_u32(body + 48, (uint32_t)parent);
    crn_scene_put_u32(body + 52, 4);
    crn_scene_put_u32(body + 56, 4);
    for (int k = 0; k < 3; k++) crn_scene_put_u32(body + 64 + 12 * (k + 1) + 4 * k, 1000000);
    for (int i = 0; i < 12; i++) crn_scene_put_u32(body + 112 + 4 * i, triangles[i]);
}

static inline void sample_branch(uint8_t *branch, const char *name, int32_t parent, uint32_t parent_point,
                                 uint32_t first, uint32_t count)
{
    memcpy(branch, name, strlen(name));
    crn_scene_put_u32(branch + 32, (uint32_t)parent);
    crn_scene_put_u32(branch + 36, parent_point);
    crn_scene_put_u32(branch + 40, first);
    crn_scene_put_u32(branch + 44, count);
}

/* Writes an aorta of three points along +y, 10 mm wide, and a renal artery of two points that leaves the
 * aorta's middle. */
static inline void sample_tree(uint8_t *tree)
{
    static const int32_t points_um[5][3] = {
        {0, 0, 0}, {0, 20000, 0}, {0, 40000, 0}, {0, 20000, 0}, {30000, 20000, 0}};
    memset(tree, 0, SAMPLE_TREE_BYTES);
    crn_scene_put_u32(tree, 2);
    crn_scene_put_u32(tree + 4, 5);
    sample_branch(tree + 16, "aorta", -1, 0, 0, 3);
    sample_branch(tree + 80, "renal", 0, 1, 3, 2);
    crn_scene_put_u32(tree + 80 + 52, 8000); /* mm3/s */
    for (int i = 0; i < 5; i++) {
        for (int k = 0; k < 3; k++) crn_scene_put_u32(tree + 144 + 16 * i + 4 * k, (uint32_t)points_um[i][k]);
        crn_scene_put_u32(tree + 144 + 16 * i + 12, i < 3 ? 5000 : 3000);
    }
}

/* Writes one lesion along the whole aorta. */
enum { SAMPLE_LESIONS_BYTES = 16 + 48 + 3 * 16 };
static inline void sample_lesions(uint8_t *lesions)
{
    memset(lesions, 0, SAMPLE_LESIONS_BYTES);
    crn_scene_put_u32(lesions, 1);
    crn_scene_put_u32(lesions + 4, 3);
    memcpy(lesions + 16, "coarctation", 11);
    crn_scene_put_u32(lesions + 16 + 40, 3);
    for (uint32_t i = 0; i < 3; i++) {
        crn_scene_put_u32(lesions + 64 + 16 * i + 4, 20000 * i);
        crn_scene_put_u32(lesions + 64 + 16 * i + 12, 9000);
    }
}

/* The sections that sample_vessels names follow the two bodies of the sample's body file. */
typedef enum sample_vessels { SAMPLE_NO_TREE, SAMPLE_TREE, SAMPLE_LESIONS } sample_vessels;
/* If `has_partner` is set, one more section follows, which names the scene to which the bodies belong. */
enum { SAMPLE_PARTNER_BYTES = 4112, SAMPLE_PARTNER_CRC32 = 0x1234abcd };
static inline size_t sample_body_file_of(uint8_t *file, size_t capacity, sample_vessels vessels,
                                         int has_partner)
{
    uint8_t partner[CRN_SCENE_PARTNER_BYTES];
    crn_scene_put_u32(partner, SAMPLE_PARTNER_BYTES);
    crn_scene_put_u32(partner + 4, SAMPLE_PARTNER_CRC32);
    uint8_t meta[CRN_SCENE_META_BYTES], skin[SAMPLE_BODY_BYTES], bone[SAMPLE_BODY_BYTES];
    uint8_t tree[SAMPLE_TREE_BYTES];
    sample_meta(meta);
    sample_body(bone, "bone", 1);
    sample_body(skin, "skin", -1);
    sample_tree(tree);
    uint8_t lesions[SAMPLE_LESIONS_BYTES];
    sample_lesions(lesions);
    crn_scene_part parts[6] = {{CRN_SCENE_META, meta, sizeof meta},
                               {CRN_SCENE_BODY, bone, sizeof bone},
                               {CRN_SCENE_BODY, skin, sizeof skin},
                               {CRN_SCENE_TREE, tree, sizeof tree},
                               {CRN_SCENE_LESIONS, lesions, sizeof lesions}};
    uint32_t count = 3 + (uint32_t)vessels;
    const crn_scene_part scene = {CRN_SCENE_PARTNER, partner, sizeof partner};
    if (has_partner) parts[count++] = scene;
    return crn_scene_write(CRN_SCENE_KIND_BODIES, parts, count, file, capacity);
}

static inline size_t sample_body_file(uint8_t *file, size_t capacity, sample_vessels vessels)
{
    return sample_body_file_of(file, capacity, vessels, 0);
}

static inline size_t sample_bodies(uint8_t *file, size_t capacity)
{
    return sample_body_file(file, capacity, SAMPLE_NO_TREE);
}

/* Writes a file with one body, whose second vertex (1 m along x) moves by -12 mm along y in a full breath. */
static inline size_t sample_breathing_body(uint8_t *file, size_t capacity)
{
    uint8_t meta[CRN_SCENE_META_BYTES], body[SAMPLE_BODY_BYTES + 4 * CRN_SCENE_BODY_BREATH_BYTES] = {0};
    sample_meta(meta);
    sample_body(body, "lung", -1);
    crn_scene_put_u32(body + 60, CRN_SCENE_BODY_BREATHES);
    crn_scene_put_u16(body + SAMPLE_BODY_BYTES + CRN_SCENE_BODY_BREATH_BYTES + 2, (uint16_t)-12000);
    const crn_scene_part parts[2] = {{CRN_SCENE_META, meta, sizeof meta},
                                     {CRN_SCENE_BODY, body, sizeof body}};
    return crn_scene_write(CRN_SCENE_KIND_BODIES, parts, 2, file, capacity);
}

/* Corrects every CRC that can still be found by means of the section table. */
static inline void sample_seal(uint8_t *file, size_t size)
{
    uint32_t count = size < 32 ? 0 : crn_scene_u32(file + 20);
    if (size < 32 || count > (size - 32) / 16) return;
    for (uint32_t i = 0; i < count; i++) {
        uint8_t *row = file + 32 + 16 * (size_t)i;
        uint32_t offset = crn_scene_u32(row + 4), bytes = crn_scene_u32(row + 8);
        if (offset <= size && bytes <= size - offset)
            crn_scene_put_u32(row + 12, crn_wire_crc32(0, file + offset, bytes));
    }
    crn_scene_put_u32(file + 24, 0);
    crn_scene_put_u32(file + 24, crn_wire_crc32(0, file, 32 + 16 * (size_t)count));
}

#endif
