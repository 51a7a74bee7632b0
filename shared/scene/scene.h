/* This header declares the functions that read a scene container; device and host run the same check before
 * they use any part of a scene.
 *
 *   crn_scene_open()   bytes -> status; on OK a view into the bytes (nothing is copied, nothing is kept)
 *   crn_scene_body()   one body of a body file
 *   crn_scene_branch() one vessel of its tree, where it has one
 *
 * A caller that replaces a scene first opens the new bytes in another memory area, and switches only when the
 * status is OK. A refused scene thus leaves the old scene unchanged. The document docs/scene.md describes
 * every byte of a scene.
 *
 * C11 and C++20. */
#ifndef CRN_SCENE_H
#define CRN_SCENE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

enum {
    CRN_SCENE_MAJOR = 1,
    /* minor version; files get the lowest that covers their contents: 1 for a body that moves, a TREE; 2 for
       LESIONS; 3 for PLAQUES; 4 for MOTION and BREATH; 5 for PARTNER; 6 for an ENTRY with a start length;
       7 for SMALL; 8 for a small vessel that joins another one; 9 for a body that breathes; 10 for a body
       with trabeculae; 11 for WALLS */
    CRN_SCENE_MINOR = 11,
    CRN_SCENE_ALIGNMENT = 16,       /* of sections in the file */
    CRN_SCENE_ADDRESS_MULTIPLE = 4, /* of the bytes in memory */
    CRN_SCENE_HEADER_BYTES = 32,
    CRN_SCENE_TABLE_ROW_BYTES = 16,
    CRN_SCENE_BYTES_MAX = 16 << 20,         /* a device reports in its set-up how large a scene it can hold */
    CRN_SCENE_BODIES_BYTES_MAX = 256 << 20, /* body files stay on the host */
    CRN_SCENE_BODY_MAX = 256,
    CRN_SCENE_TRIANGLE_MAX = 8000000, /* of all bodies */
    CRN_SCENE_NAME_BYTES = 64,
    CRN_SCENE_SOURCE_BYTES = 192,
    CRN_SCENE_META_BYTES = CRN_SCENE_NAME_BYTES + CRN_SCENE_SOURCE_BYTES,
    CRN_SCENE_ENTRY_BYTES = 24,
    CRN_SCENE_ENTRY_START_BYTES = 28, /* with a start length */
    CRN_SCENE_ENTRY_START_MAX_um = 500000,
    CRN_SCENE_LUMEN_HEADER_BYTES = 32,
    CRN_SCENE_BRICK_BYTES = 1000,
    CRN_SCENE_BRICK_LOG2_Q30 = 23, /* edge of a coarse brick: 2^23 Q30 m = 7.8 mm */
    CRN_SCENE_LATTICE_MAX = 512,   /* coarse bricks along an axis: 4 m */
    CRN_SCENE_BODY_HEADER_BYTES = 64,
    CRN_SCENE_BODY_NAME_BYTES = 32,
    CRN_SCENE_MATERIAL_BYTES = 16,
    CRN_SCENE_BODY_REACH_um = 2000000,
    CRN_SCENE_TREE_HEADER_BYTES = 16,
    CRN_SCENE_BRANCH_BYTES = 64,
    CRN_SCENE_BRANCH_MAX = 1024,
    CRN_SCENE_BRANCH_NAME_BYTES = 32,
    CRN_SCENE_SMALL_MAX = 20000,  /* vessels that are picture and flow only */
    CRN_SCENE_BRANCH_IS_VEIN = 1, /* flag of a small vessel: blood flows from its end to its beginning */
    CRN_SCENE_BRANCH_JOINS = 2,   /* flag of a small artery: its end passes its blood to another one */
    CRN_SCENE_TREE_POINT_BYTES = 16,
    CRN_SCENE_TREE_POINT_MAX = 200000, /* of all branches */
    CRN_SCENE_PARTNER_BYTES = 8,
    CRN_SCENE_LESIONS_HEADER_BYTES = 16,
    CRN_SCENE_LESION_BYTES = 48,
    CRN_SCENE_LESION_MAX = 32,
    CRN_SCENE_PLAQUES_HEADER_BYTES = 16,
    CRN_SCENE_PLAQUE_BYTES = 80,
    CRN_SCENE_PLAQUE_MAX = 4,
    CRN_SCENE_PLAQUE_STATION_BYTES = 48,
    CRN_SCENE_PLAQUE_STATION_MAX = 24, /* of a plaque */
    CRN_SCENE_RADIUS_MIN_um = 10,
    CRN_SCENE_RADIUS_MAX_um = 100000,
    CRN_SCENE_BRANCH_FLOW_MAX_mm3_per_s = 1000000,
    CRN_SCENE_SMALL_FLOW_MAX_nl_per_s = 100000000,
    CRN_SCENE_BODY_MOVES = 1,        /* flag of a body: it moves with the scene's MOTION */
    CRN_SCENE_BODY_BREATHES = 2,     /* flag of a body: it states its displacement by a full breath */
    CRN_SCENE_BODY_TRABECULAE = 4,   /* flag of a body: it has the texture of trabeculae in the picture */
    CRN_SCENE_BODY_BREATH_BYTES = 6, /* of a displacement by a full breath, per vertex */
    CRN_SCENE_MOTION_HEADER_BYTES = 32,
    CRN_SCENE_MOTION_KEYFRAMES = 24,
    CRN_SCENE_MOTION_ROW = 26, /* numbers of one component of one node; 3 components */
    CRN_SCENE_MOTION_UNIT_LOG2_Q30 = 11,
    CRN_SCENE_MOTION_VALUE_MAX = 1 << 14,
    CRN_SCENE_MOTION_COUNT_MAX = 256, /* nodes along an axis */
    CRN_SCENE_MOTION_SPACING_LOG2_MIN = 20,
    CRN_SCENE_MOTION_SPACING_LOG2_MAX = 24,
    CRN_SCENE_WALLS_HEADER_BYTES = 16,
    CRN_SCENE_WALL_LAW_BYTES = 32,
    CRN_SCENE_WALL_LAW_MAX = 16,
    CRN_SCENE_WALL_BED_MIN_N_m2 = 1000,
    CRN_SCENE_WALL_RADIAL_MIN_N_m2 = 10000,
    CRN_SCENE_WALL_STIFFNESS_MAX_N_m2 = 10000000,
    CRN_SCENE_WALL_RELAX_MIN_ms = 20,
    CRN_SCENE_WALL_RELAX_MAX_ms = 10000,
    CRN_SCENE_WALL_CARRY_MAX_um = 20000,
    CRN_SCENE_WALL_WAY_MAX_um = 20000,
    CRN_SCENE_WALL_WIDEN_MAX_um = 4000,
    CRN_SCENE_ENTRY_REACH_Q30 = 2040109465, /* 1.9 m, the limit that the core accepts */
};

typedef enum crn_scene_kind {
    CRN_SCENE_KIND_SCENE = 1,
    CRN_SCENE_KIND_BODIES = 2,
} crn_scene_kind;

typedef enum crn_scene_section {
    CRN_SCENE_META = 1,
    CRN_SCENE_ENTRY = 2,
    CRN_SCENE_LUMEN = 3,
    CRN_SCENE_MOTION = 4,
    CRN_SCENE_PLAQUES = 5,
    CRN_SCENE_BREATH = 6,
    CRN_SCENE_WALLS = 7,
    CRN_SCENE_BODY = 16,
    CRN_SCENE_TREE = 17,
    CRN_SCENE_LESIONS = 18,
    CRN_SCENE_PARTNER = 19,
    CRN_SCENE_SMALL = 20,
} crn_scene_section;

/* The function crn_scene_status_text gives a line of text for each status. */
typedef enum crn_scene_status {
    CRN_SCENE_OK = 0,
    CRN_SCENE_UNALIGNED,       /* the bytes do not lie at a multiple of 4 */
    CRN_SCENE_BYTE_ORDER,      /* this processor is big-endian */
    CRN_SCENE_TRUNCATED,       /* fewer bytes than the header states, or an incomplete header */
    CRN_SCENE_TRAILING,        /* more bytes than the header states */
    CRN_SCENE_OVERSIZED,       /* larger than the limit of its kind */
    CRN_SCENE_MAGIC,           /* no scene at all */
    CRN_SCENE_NEWER,           /* written by a newer format */
    CRN_SCENE_OLDER,           /* written by an older major version */
    CRN_SCENE_HEADER_CRC,      /* header or section table damaged */
    CRN_SCENE_KIND,            /* neither a scene nor bodies */
    CRN_SCENE_RESERVED,        /* a field or gap that must be zero is not */
    CRN_SCENE_SECTION_COUNT,   /* too few or too many sections */
    CRN_SCENE_SECTION_TYPE,    /* a section of a type that is not allowed there */
    CRN_SCENE_SECTION_PLACE,   /* unaligned, overlapping, with a gap, or beyond the end */
    CRN_SCENE_SECTION_SIZE,    /* its size does not follow from its contents */
    CRN_SCENE_SECTION_CRC,     /* its bytes are damaged */
    CRN_SCENE_TEXT,            /* an unterminated text, or one with control characters */
    CRN_SCENE_ENTRY_POSITION,  /* beyond 1.9 m */
    CRN_SCENE_ENTRY_DIRECTION, /* no unit vector */
    CRN_SCENE_LATTICE,         /* brick counts out of range, or the lattice leaves the number range */
    CRN_SCENE_CHILD_ROWS,      /* more rows that refine coarse bricks than rows in all */
    CRN_SCENE_INDEX_BRICK,     /* an index entry names a brick that does not exist */
    CRN_SCENE_INDEX_ROW, /* an index entry names a child row that does not exist or is not allowed there */
    CRN_SCENE_MOTION_LATTICE, /* node counts, spacing or keyframes out of range, or the lattice leaves the
                                 number range */
    CRN_SCENE_MOTION_VALUE,   /* a displacement over 31 mm, or a row that contradicts itself */
    CRN_SCENE_MOTION_STEEP,   /* neighbours differ so much that the vessel would fold over */
    CRN_SCENE_MOTION_EDGE,    /* the lattice's boundary moves */
    CRN_SCENE_MOTION_OLDER,   /* written before minor version 4: breath and beat in one lattice */
    CRN_SCENE_BODY_PARENT,   /* a parent that does not exist, or bodies that contain each other in a circle */
    CRN_SCENE_BODY_SIZE,     /* no triangles, or too many in all */
    CRN_SCENE_BODY_VERTEX,   /* a vertex beyond 2 m */
    CRN_SCENE_BODY_TRIANGLE, /* a triangle names a vertex that does not exist, or the same one twice */
    CRN_SCENE_TREE_SIZE,     /* no branches or points, or too many */
    CRN_SCENE_TREE_BRANCH, /* a branch whose parent does not come before it, or whose place on the parent does
                              not exist */
    CRN_SCENE_TREE_POINT,  /* a point beyond 2 m or equal to the one before, or a radius out of range */
    CRN_SCENE_LESION_SIZE, /* no lesions, or too many */
    CRN_SCENE_LESION_PLACE, /* a lesion on a branch or at points that do not exist, or healthy points or radii
                               out of range */
    CRN_SCENE_PLAQUE, /* no plaques, too many, or one whose stations, radii or pressures are out of range */
    CRN_SCENE_ENTRY_START, /* a start length of 0 or beyond 500 mm */
    CRN_SCENE_WALL, /* walls that give way: no law, too many, a number out of range, or a brick with a law
                       that does not exist */
    CRN_SCENE_STATUS_COUNT,
} crn_scene_status;

/* Holds the lumen in the form that crn_lumen of firmware/core needs. */
typedef struct crn_scene_lumen {
    int32_t origin_m_q30[3];
    uint16_t brick_count_xyz[3];
    uint16_t child_row_count;
    uint32_t brick_count;
    const uint16_t *index;
    const uint16_t *children;
    const int8_t *samples;
} crn_scene_lumen;

/* Holds the motion of the lumen in the form that crn_motion of firmware/core needs. For each of the three
 * displacement components of a lattice node, the heartbeat has a row of CRN_SCENE_MOTION_ROW numbers, and
 * breath has one number. */
typedef struct crn_scene_motion {
    int32_t origin_m_q30[3];
    uint16_t node_count_xyz[3];
    uint16_t spacing_log2_q30;
    const int16_t *rows;
} crn_scene_motion;

/* A checked file. The opened scene is valid as long as the bytes from which it was opened exist. */
typedef struct crn_scene {
    crn_scene_kind kind;
    uint32_t hash; /* the header's CRC-32, which covers the CRCs of the sections */
    const char *name;
    const char *source;
    int32_t entry_position_m_q30[3]; /* KIND_SCENE */
    int32_t entry_direction_q30[3];
    uint32_t entry_start_um; /* inserted length with which a session begins; 0: not stated */
    crn_scene_lumen lumen;
    bool has_motion;
    crn_scene_motion motion;
    bool has_breath; /* only with motion */
    crn_scene_motion breath;
    uint32_t plaque_count; /* lesions that give way, in the order of the body file's lesions */
    const uint8_t *plaques;
    uint32_t wall_law_count;          /* how walls give way; 0: they are rigid */
    const uint8_t *wall_laws;         /* CRN_SCENE_WALL_LAW_BYTES each */
    const uint8_t *wall_law_of_brick; /* of each coarse brick; 0: rigid */
    uint32_t body_count;              /* KIND_BODIES */
    uint32_t branch_count;            /* branches of its tree of vessels; 0: it has no tree */
    const uint8_t *tree;
    uint32_t small_count; /* small vessels that begin in that tree */
    const uint8_t *small;
    uint32_t lesion_count; /* of that tree */
    const uint8_t *lesions;
    bool has_partner;       /* the body file names the scene with which it was baked, as a recording does: */
    uint32_t partner_bytes; /* its size */
    uint32_t partner_crc32; /* and the CRC-32 of the whole file */
    const uint8_t *bytes;
} crn_scene;

typedef struct crn_scene_body_view {
    const char *name;
    const char *material;
    int32_t parent; /* -1: in air */
    bool moves;     /* the body moves with the scene's motion */
    bool is_trabecular;
    uint32_t vertex_count;
    uint32_t triangle_count;
    const uint8_t *vertices_um; /* 3 x i32 each: crn_scene_i32 */
    const uint8_t *triangles;   /* 3 x u32 each: crn_scene_u32 */
    const uint8_t *breath_um;   /* 3 x i16 per vertex, the displacement by a full breath; NULL: none */
} crn_scene_body_view;

/* Names the organ that a vessel feeds; the organ decides when in the heartbeat blood flows to it. */
typedef enum crn_scene_bed {
    CRN_SCENE_BED_SYSTEMIC = 0,
    CRN_SCENE_BED_LEFT_CORONARY = 1,
    CRN_SCENE_BED_RIGHT_CORONARY = 2,
    CRN_SCENE_BED_KIDNEY = 3, /* this and the next: in small vessels only */
    CRN_SCENE_BED_GUT = 4,
    CRN_SCENE_BED_COUNT,
} crn_scene_bed;

/* A branch is a part of the vessel tree, from the point where it leaves its parent to its end. Branch 0 is
 * the root: blood enters at its first point. */
typedef struct crn_scene_branch_view {
    const char *name;
    int32_t parent;        /* an earlier branch; -1: the root */
    uint32_t parent_point; /* the point of the parent nearest to this branch's first one */
    uint32_t point_count;  /* at least 2 */
    crn_scene_bed bed;
    uint32_t flow_mm3_per_s; /* mean flow out of its end; 0: not stated; of a small vessel in nl/s */
    uint32_t flags;          /* of a small vessel: CRN_SCENE_BRANCH_IS_VEIN or CRN_SCENE_BRANCH_JOINS */
    uint32_t joins;          /* with CRN_SCENE_BRANCH_JOINS: another small vessel, numbered as parents */
    const uint8_t *points;   /* i32 x 3 in um and u32 radius in um each */
} crn_scene_branch_view;

/* A lesion is a part of a branch that disease has narrowed; the branch's points are those of the narrowed
 * lumen. */
typedef struct crn_scene_lesion_view {
    const char *name;
    uint32_t branch;
    uint32_t first_point;          /* of the branch */
    uint32_t point_count;          /* at least 3 */
    const uint8_t *healthy_points; /* one for each point: i32 x 3 in um and u32 radius in um */
} crn_scene_lesion_view;

/* Holds a lesion that a balloon can open, in the form that crn_lesion of firmware/core needs. */
typedef struct crn_scene_plaque_view {
    int32_t low_m_q30[3], high_m_q30[3], chord_q30[3], stretch_q28;
    uint32_t spacing_log2_q30, station_count;
    int32_t yield_Pa, full_Pa, recoil_q30, pace_q30;
    const uint8_t *stations; /* 12 words each: healthy i32[3] and radius i32, channel i32[3] and radius i32,
                                along i32[3], 0 */
} crn_scene_plaque_view;

/* Checks everything. On OK it fills *scene. When the scene is refused, the function leaves *scene unchanged
 * and, when where_byte is not NULL, stores the position of the faulty byte in the file. The time of the check
 * is linear in the size of the file, and the check needs no additional memory and no recursion. */
crn_scene_status crn_scene_open(const uint8_t *bytes, size_t size, crn_scene *scene, uint32_t *where_byte);

/* Returns one line of text, without a full stop, that explains a status and says how to remove its cause. */
const char *crn_scene_status_text(crn_scene_status status);

/* Returns the body with the number `index` (< body_count) of an opened body file. */
crn_scene_body_view crn_scene_body(const crn_scene *scene, uint32_t index);

/* Branch number `index` < branch_count. */
crn_scene_branch_view crn_scene_branch(const crn_scene *scene, uint32_t index);

/* Small vessel number `index` < small_count. Its parent is a branch of the tree if it is below branch_count;
 * otherwise the parent is the earlier small vessel number parent - branch_count. A parent of -1 is allowed
 * only for a vein, whose blood then leaves the simulation at its first point. */
crn_scene_branch_view crn_scene_small(const crn_scene *scene, uint32_t index);

/* Lesion number `index` < lesion_count. */
crn_scene_lesion_view crn_scene_lesion(const crn_scene *scene, uint32_t index);

/* Plaque number `index` < plaque_count. */
crn_scene_plaque_view crn_scene_plaque(const crn_scene *scene, uint32_t index);

/* Little-endian words at any address. */
uint32_t crn_scene_u32(const uint8_t *bytes);
int32_t crn_scene_i32(const uint8_t *bytes);
uint16_t crn_scene_u16(const uint8_t *bytes);

#ifdef __cplusplus
}
#endif

#endif
