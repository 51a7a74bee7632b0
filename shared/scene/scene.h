/* The scene container: one check for device and host, before anything of a scene is used.
 *
 *   seld_scene_open()   bytes -> status; on OK a view into the bytes (nothing is copied, nothing is kept)
 *   seld_scene_body()   one body of a body file
 *   seld_scene_branch() one vessel of its tree, where it has one
 *
 * A caller that replaces a scene opens the new bytes first, in another place, and changes over only on OK: a refused
 * scene leaves the old one as it was. docs/scene.md has every byte.
 *
 * May include: shared/wire (CRC-32). Called by: firmware/app, host, tools. C11 and C++20.
 */
#ifndef SELD_SCENE_H
#define SELD_SCENE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

enum {
    SELD_SCENE_MAJOR = 1,
    SELD_SCENE_MINOR =
        5, /* written only into files that need it: 1 for a body that moves, a TREE; 2 for LESIONS; 3 for PLAQUES; 4 for MOTION and BREATH; 5 for PARTNER */
    SELD_SCENE_ALIGNMENT = 16,       /* of sections in the file */
    SELD_SCENE_ADDRESS_MULTIPLE = 4, /* of the bytes in memory */
    SELD_SCENE_HEADER_BYTES = 32,
    SELD_SCENE_TABLE_ROW_BYTES = 16,
    SELD_SCENE_BYTES_MAX = 16 << 20,         /* a device says in its set-up how much of it fits */
    SELD_SCENE_BODIES_BYTES_MAX = 256 << 20, /* body files stay on the host */
    SELD_SCENE_BODY_MAX = 256,
    SELD_SCENE_TRIANGLE_MAX = 8000000, /* of all bodies */
    SELD_SCENE_NAME_BYTES = 64,
    SELD_SCENE_SOURCE_BYTES = 192,
    SELD_SCENE_META_BYTES = SELD_SCENE_NAME_BYTES + SELD_SCENE_SOURCE_BYTES,
    SELD_SCENE_ENTRY_BYTES = 24,
    SELD_SCENE_LUMEN_HEADER_BYTES = 32,
    SELD_SCENE_BRICK_BYTES = 1000,
    SELD_SCENE_BRICK_LOG2_Q30 = 23, /* edge of a coarse brick: 2^23 Q30 m = 7.8 mm */
    SELD_SCENE_LATTICE_MAX = 512,   /* coarse bricks along an axis: 4 m */
    SELD_SCENE_BODY_HEADER_BYTES = 64,
    SELD_SCENE_BODY_NAME_BYTES = 32,
    SELD_SCENE_MATERIAL_BYTES = 16,
    SELD_SCENE_BODY_REACH_um = 2000000,
    SELD_SCENE_TREE_HEADER_BYTES = 16,
    SELD_SCENE_BRANCH_BYTES = 64,
    SELD_SCENE_BRANCH_MAX = 1024,
    SELD_SCENE_BRANCH_NAME_BYTES = 32,
    SELD_SCENE_TREE_POINT_BYTES = 16,
    SELD_SCENE_TREE_POINT_MAX = 200000, /* of all branches */
    SELD_SCENE_PARTNER_BYTES = 8,
    SELD_SCENE_LESIONS_HEADER_BYTES = 16,
    SELD_SCENE_LESION_BYTES = 48,
    SELD_SCENE_LESION_MAX = 32,
    SELD_SCENE_PLAQUES_HEADER_BYTES = 16,
    SELD_SCENE_PLAQUE_BYTES = 80,
    SELD_SCENE_PLAQUE_MAX = 4,
    SELD_SCENE_PLAQUE_STATION_BYTES = 48,
    SELD_SCENE_PLAQUE_STATION_MAX = 24, /* of a plaque */
    SELD_SCENE_RADIUS_MIN_um = 10,
    SELD_SCENE_RADIUS_MAX_um = 100000,
    SELD_SCENE_BRANCH_FLOW_MAX_mm3_per_s = 1000000,
    SELD_SCENE_BODY_MOVES = 1, /* flag of a body: it moves with the scene's MOTION */
    SELD_SCENE_MOTION_HEADER_BYTES = 32,
    SELD_SCENE_MOTION_KEYFRAMES = 24,
    SELD_SCENE_MOTION_ROW = 26, /* numbers of one component of one node; 3 components */
    SELD_SCENE_MOTION_UNIT_LOG2_Q30 = 11,
    SELD_SCENE_MOTION_VALUE_MAX = 1 << 14,
    SELD_SCENE_MOTION_COUNT_MAX = 256, /* nodes along an axis */
    SELD_SCENE_MOTION_SPACING_LOG2_MIN = 20,
    SELD_SCENE_MOTION_SPACING_LOG2_MAX = 24,
    SELD_SCENE_ENTRY_REACH_Q30 = 2040109465, /* 1.9 m, as the core takes it */
};

typedef enum seld_scene_kind {
    SELD_SCENE_KIND_SCENE = 1,
    SELD_SCENE_KIND_BODIES = 2,
} seld_scene_kind;

typedef enum seld_scene_section {
    SELD_SCENE_META = 1,
    SELD_SCENE_ENTRY = 2,
    SELD_SCENE_LUMEN = 3,
    SELD_SCENE_MOTION = 4,
    SELD_SCENE_PLAQUES = 5,
    SELD_SCENE_BREATH = 6,
    SELD_SCENE_BODY = 16,
    SELD_SCENE_TREE = 17,
    SELD_SCENE_LESIONS = 18,
    SELD_SCENE_PARTNER = 19,
} seld_scene_section;

/* One line of text each: seld_scene_status_text. */
typedef enum seld_scene_status {
    SELD_SCENE_OK = 0,
    SELD_SCENE_UNALIGNED,       /* the bytes do not lie at a multiple of 4 */
    SELD_SCENE_BYTE_ORDER,      /* this processor is big-endian */
    SELD_SCENE_TRUNCATED,       /* fewer bytes than the header says, or no whole header */
    SELD_SCENE_TRAILING,        /* more bytes than the header says */
    SELD_SCENE_OVERSIZED,       /* more than the limit of its kind */
    SELD_SCENE_MAGIC,           /* no scene at all */
    SELD_SCENE_NEWER,           /* written by a newer format */
    SELD_SCENE_OLDER,           /* of a major version before this one */
    SELD_SCENE_HEADER_CRC,      /* header or section table damaged */
    SELD_SCENE_KIND,            /* neither scene nor bodies */
    SELD_SCENE_RESERVED,        /* a field or gap that must be zero is not */
    SELD_SCENE_SECTION_COUNT,   /* too few or too many sections */
    SELD_SCENE_SECTION_TYPE,    /* a section that does not belong there */
    SELD_SCENE_SECTION_PLACE,   /* unaligned, overlapping, with a gap, or beyond the end */
    SELD_SCENE_SECTION_SIZE,    /* its size does not follow from its contents */
    SELD_SCENE_SECTION_CRC,     /* its bytes are damaged */
    SELD_SCENE_TEXT,            /* a text without end, or with control characters */
    SELD_SCENE_ENTRY_POSITION,  /* beyond 1.9 m */
    SELD_SCENE_ENTRY_DIRECTION, /* no unit vector */
    SELD_SCENE_LATTICE,         /* brick counts out of range, or the lattice leaves the number range */
    SELD_SCENE_CHILD_ROWS,      /* more rows refining coarse bricks than rows */
    SELD_SCENE_INDEX_BRICK,     /* an index entry names a brick that is not there */
    SELD_SCENE_INDEX_ROW,       /* an index entry names a child row that is not there or not allowed there */
    SELD_SCENE_MOTION_LATTICE, /* node counts, spacing or keyframes out of range, or the lattice leaves the number range */
    SELD_SCENE_MOTION_VALUE,  /* a displacement over 31 mm, or a row that contradicts itself */
    SELD_SCENE_MOTION_STEEP,  /* neighbours differ so much that the vessel would fold over */
    SELD_SCENE_MOTION_EDGE,   /* the lattice's boundary moves */
    SELD_SCENE_MOTION_OLDER,  /* of a minor version before 4: breath and beat in one lattice */
    SELD_SCENE_BODY_PARENT,   /* a parent that is not there, or bodies lying in each other in a circle */
    SELD_SCENE_BODY_SIZE,     /* no triangles, or too many in all */
    SELD_SCENE_BODY_VERTEX,   /* a vertex beyond 2 m */
    SELD_SCENE_BODY_TRIANGLE, /* a triangle names a vertex that is not there, or one twice */
    SELD_SCENE_TREE_SIZE,     /* no branches or points, or too many */
    SELD_SCENE_TREE_BRANCH, /* a branch of one that does not come before it, or of a place that is not there */
    SELD_SCENE_TREE_POINT,  /* a point beyond 2 m or where the last one was, or a radius out of range */
    SELD_SCENE_LESION_SIZE, /* no lesions, or too many */
    SELD_SCENE_LESION_PLACE, /* a lesion on a branch or at points that are not there, or healthy points or radii out of range */
    SELD_SCENE_PLAQUE, /* no plaques, too many, or one whose stations, radii or pressures are out of range */
    SELD_SCENE_STATUS_COUNT,
} seld_scene_status;

/* The lumen, as firmware/core's seld_lumen wants it. */
typedef struct seld_scene_lumen {
    int32_t origin_m_q30[3];
    uint16_t brick_count_xyz[3];
    uint16_t child_row_count;
    uint32_t brick_count;
    const uint16_t *index;
    const uint16_t *children;
    const int8_t *samples;
} seld_scene_lumen;

/* How it moves, as firmware/core's seld_motion wants it: of the beat rows of SELD_SCENE_MOTION_ROW numbers, of breath one number, for each of
 * a node's three components. */
typedef struct seld_scene_motion {
    int32_t origin_m_q30[3];
    uint16_t node_count_xyz[3];
    uint16_t spacing_log2_q30;
    const int16_t *rows;
} seld_scene_motion;

/* A checked file. Valid as long as the bytes are. */
typedef struct seld_scene {
    seld_scene_kind kind;
    uint32_t hash; /* the header's CRC-32, which covers those of the sections */
    const char *name;
    const char *source;
    int32_t entry_position_m_q30[3]; /* KIND_SCENE */
    int32_t entry_direction_q30[3];
    seld_scene_lumen lumen;
    bool has_motion;
    seld_scene_motion motion;
    bool has_breath; /* only with motion */
    seld_scene_motion breath;
    uint32_t plaque_count; /* lesions that give way, in the order of the body file's */
    const uint8_t *plaques;
    uint32_t body_count;   /* KIND_BODIES */
    uint32_t branch_count; /* of its tree of vessels; 0: it has none */
    const uint8_t *tree;
    uint32_t lesion_count; /* of that tree */
    const uint8_t *lesions;
    bool has_partner;       /* the body file names the scene it was baked with, as a recording does: */
    uint32_t partner_bytes; /* its size */
    uint32_t partner_crc32; /* and the CRC-32 of the whole file */
    const uint8_t *bytes;
} seld_scene;

typedef struct seld_scene_body_view {
    const char *name;
    const char *material;
    int32_t parent; /* -1: in air */
    bool moves;     /* with the scene's motion */
    uint32_t vertex_count;
    uint32_t triangle_count;
    const uint8_t *vertices_um; /* 3 x i32 each: seld_scene_i32 */
    const uint8_t *triangles;   /* 3 x u32 each: seld_scene_u32 */
} seld_scene_body_view;

/* What a vessel feeds: decides when in the beat blood flows there. */
typedef enum seld_scene_bed {
    SELD_SCENE_BED_SYSTEMIC = 0,
    SELD_SCENE_BED_LEFT_CORONARY = 1,
    SELD_SCENE_BED_RIGHT_CORONARY = 2,
    SELD_SCENE_BED_COUNT,
} seld_scene_bed;

/* A vessel from where it leaves its parent to its end. Branch 0 is the root: blood enters at its first point. */
typedef struct seld_scene_branch_view {
    const char *name;
    int32_t parent;        /* an earlier branch; -1: the root */
    uint32_t parent_point; /* the point of the parent nearest to this branch's first one */
    uint32_t point_count;  /* at least 2 */
    seld_scene_bed bed;
    uint32_t flow_mm3_per_s; /* mean, out of its end; 0: not stated */
    const uint8_t *points;   /* i32 x 3 in um and u32 radius in um each */
} seld_scene_branch_view;

/* A stretch of a branch that disease has narrowed: the branch's points are those of the narrowed lumen. */
typedef struct seld_scene_lesion_view {
    const char *name;
    uint32_t branch;
    uint32_t first_point;          /* of the branch */
    uint32_t point_count;          /* at least 3 */
    const uint8_t *healthy_points; /* one for each: i32 x 3 in um and u32 radius in um */
} seld_scene_lesion_view;

/* A lesion that gives way, as firmware/core's seld_lesion wants it. */
typedef struct seld_scene_plaque_view {
    int32_t low_m_q30[3], high_m_q30[3], chord_q30[3], stretch_q28;
    uint32_t spacing_log2_q30, station_count;
    int32_t yield_Pa, full_Pa, recoil_q30, pace_q30;
    const uint8_t *
        stations; /* 12 words each: healthy i32[3] and radius i32, channel i32[3] and radius i32, along i32[3], 0 */
} seld_scene_plaque_view;

/* Check everything. On OK fills *scene; otherwise leaves it alone and, when where_byte is not NULL, says at which byte
 * of the file the fault stands. Time is linear in size; no memory, no recursion. */
seld_scene_status seld_scene_open(const uint8_t *bytes, size_t size, seld_scene *scene, uint32_t *where_byte);

/* What a status means and what to do about it, one line without full stop. */
const char *seld_scene_status_text(seld_scene_status status);

/* Body number `index` < body_count of an opened body file. */
seld_scene_body_view seld_scene_body(const seld_scene *scene, uint32_t index);

/* Branch number `index` < branch_count. */
seld_scene_branch_view seld_scene_branch(const seld_scene *scene, uint32_t index);

/* Lesion number `index` < lesion_count. */
seld_scene_lesion_view seld_scene_lesion(const seld_scene *scene, uint32_t index);

/* Plaque number `index` < plaque_count. */
seld_scene_plaque_view seld_scene_plaque(const seld_scene *scene, uint32_t index);

/* Little-endian words at any address. */
uint32_t seld_scene_u32(const uint8_t *bytes);
int32_t seld_scene_i32(const uint8_t *bytes);
uint16_t seld_scene_u16(const uint8_t *bytes);

#ifdef __cplusplus
}
#endif

#endif
