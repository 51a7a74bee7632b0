/* The lumen is described by a sparse field of signed distances from the inner vessel wall; the field is
 * read-only during a session.
 *
 * The signed distance phi, in metres in Q30, is negative inside the lumen (where blood is), and positive in
 * the wall and beyond. The contact depth of a wire of radius r is phi + r. The inward normal is n =
 * -grad(phi)/|grad(phi)|.
 *
 * Layout. Space is a regular lattice of coarse bricks of 8x8x8 voxels. The voxel edge of level L is 2^(20-L)
 * Q30 units (level 0: 0.977 mm, level 1: 0.488 mm, level 2: 0.244 mm). A shift and a mask split a patient
 * coordinate into voxel number and fraction. An entry of the coarse index has one of the following values.
 *     0                     far outside the lumen
 *     1                     deep inside the lumen, farther than the field's band from any wall
 *     2 .. 0x7fff           brick number + 2 of a level-0 brick
 *     0x8000 | row          this brick is refined: children[row][8] hold entries of the same kind for its 8 octants
 *                           (x fastest), one level down. At most CRN_LUMEN_LEVELS - 1 refinements.
 * A brick holds 10x10x10 coefficients (x fastest) of the triquadratic B-spline of the distance phi. The
 * coefficients are int8 numbers in units of voxel/32, saturated at +-127, that is +-3.97 voxels. Coefficient
 * (i,j,k) belongs to the point that lies (i - 1/2, j - 1/2, k - 1/2) voxels from the brick's corner.
 * Neighbouring bricks therefore overlap by one sample on every side. The distances at the sample points
 * themselves are never stored. The program that bakes a scene filters the distances beforehand, so that the
 * spline passes through the true distances.
 *
 * The code in shared/scene validates the data before use, because they may come from an attacker. */
#ifndef CRN_LUMEN_H
#define CRN_LUMEN_H

#include "firmware/core/vector.h"

enum {
    CRN_LUMEN_LEVELS = 3,
    CRN_LUMEN_BRICK_EDGE = 8,
    CRN_LUMEN_BRICK_SAMPLES = 1000, /* 10^3 */
    CRN_LUMEN_VOXEL_LOG2_Q30 = 20,  /* level-0 voxel edge = 2^20 / 2^30 m */
    CRN_LUMEN_ENTRY_OUTSIDE = 0,
    CRN_LUMEN_ENTRY_INSIDE = 1,
    CRN_LUMEN_ENTRY_FIRST_BRICK = 2,
    CRN_LUMEN_ENTRY_REFINED = 0x8000,
};

struct crn_motion;
struct crn_near;

/* A lesion that a balloon can open (lesion.h) is described by points along the healthy centreline, called
 * stations. Their spacing along the centreline is 2^spacing_log2_q30, in units of 2^-30 m. The lesion's
 * points (stations) are read directly from the bytes of a scene. */
typedef struct crn_lesion_station {
    int32_t healthy_m_q30[3], healthy_radius_m_q30;
    int32_t channel_m_q30[3], channel_radius_m_q30; /* remaining channel, in the plane across the vessel */
    int32_t along_q30[3];                           /* unit vector to the next station */
    int32_t reserved;
} crn_lesion_station;

enum { CRN_LESION_MAX = 4, CRN_LESION_STATION_MAX = 24 };

typedef struct crn_lesion {
    int32_t low_m_q30[3], high_m_q30[3]; /* box around everything that the lesion can move */
    int32_t chord_q30[3];                /* unit vector from the first station to the last */
    int32_t stretch_q28;                 /* arc length over chord */
    uint32_t spacing_log2_q30, station_count;
    int32_t yield_Pa; /* pressure on the wall at which it begins to give way */
    int32_t full_Pa;  /* additional pressure that opens it completely */
    int32_t recoil_q30;
    int32_t pace_q30; /* largest change of the opening in a tick */
    const crn_lesion_station *stations;
} crn_lesion;

enum { CRN_WALL_LAW_MAX = 16 };

/* How the wall gives way, as a scene states it; the code in shared/scene checks the ranges. */
typedef struct crn_wall_law {
    uint32_t bed_N_m2;    /* force per length by which a straight vessel moves aside 1 m; 1 000 .. 10 000 000,
                             or 0: it does not move */
    uint32_t radial_N_m2; /* the same for widening; 10 000 .. 10 000 000, or 0: it does not widen */
    uint32_t relax_ms;    /* tau, 20 .. 10 000 */
    uint32_t carry_um;    /* root of T / k: over this length a way spreads along the vessel, 0 .. 20 000 */
    uint32_t way_max_um;  /* 0 .. 20 000 */
    uint32_t widen_max_um; /* 0 .. 4 000 */
    uint32_t reserved[2];
} crn_wall_law;

/* The laws of a scene. `law_of_brick` has one number for each coarse brick of the lumen's lattice, in the
 * order of its index: 0 for a rigid wall, or the number of a law from 1. */
typedef struct crn_walls {
    uint32_t law_count;
    const crn_wall_law *laws;
    const uint8_t *law_of_brick;
} crn_walls;

typedef struct crn_lumen {
    int32_t origin_m_q30[3];     /* corner of coarse brick (0,0,0) */
    uint32_t brick_count_xyz[3]; /* coarse bricks along each axis, each >= 1 */
    uint16_t child_row_count;
    uint32_t brick_count;            /* bricks in `samples`, all levels */
    const uint16_t *index;           /* brick_count_xyz product entries, x fastest */
    const uint16_t *children;        /* child_row_count x 8 entries */
    const int8_t *samples;           /* brick_count x CRN_LUMEN_BRICK_SAMPLES */
    const struct crn_motion *motion; /* The pointer `motion` leads to the motion of the vessel (motion.h), or
                                        is NULL if the vessel does not move. The samplers below ignore it */
    uint32_t lesion_count; /* lesions that give way, at most CRN_LESION_MAX. The samplers ignore them too */
    const crn_lesion *lesions;
    const crn_walls *walls; /* how the walls give way, or NULL: they are rigid. The samplers
                                      ignore it */
    /* Copies of parts of the scene in faster memory (near.h), or NULL: the scene is read in place. */
    struct crn_near *near;
} crn_lumen;

typedef struct crn_lumen_sample {
    int32_t distance_m_q30; /* phi; it saturates at the field's band */
    crn_vec3 normal_q30;    /* inward unit normal; zero where the gradient vanishes (no contact there) */
} crn_lumen_sample;

/* Returns the same distance to the wall as crn_lumen_contact, bit for bit, but without computing the normal.
 * The distance without the normal is enough to decide whether a node can touch the wall. Format: Q30 m -> Q30
 * m. The distance is +2^24 (15.6 mm) outside the lattice and in bricks marked OUTSIDE, and -2^24 in bricks
 * marked INSIDE. */
int32_t crn_lumen_distance(const crn_lumen *lumen, const crn_vec3 *position_m_q30);

/* Remembers the voxel in which a point was last, and how deep in the lumen the greatest of the voxel's 27
 * coefficients is, so that a point which stays in its voxel needs no sum. The upper 25 bits are the number of
 * the voxel's first coefficient plus one, or 0 for none. The lower 7 bits are the depth in units of voxel/32,
 * or 0 where a coefficient is not inside. What it remembers holds for one lumen. */
typedef struct crn_lumen_voxel {
    uint32_t number_and_depth;
} crn_lumen_voxel;

/* Returns crn_lumen_distance, or a greater distance that is still below `far_m_q30`. A spline is never above
 * its greatest coefficient, so a point deep in the lumen needs no sum to show that it is far from the wall.
 */
int32_t crn_lumen_distance_unless_far(const crn_lumen *lumen, const crn_vec3 *position_m_q30,
                                      int32_t far_m_q30, crn_lumen_voxel *last);

/* Returns the distance and the inward normal from the triquadratic B-spline (27 coefficients, continuous
 * first derivative), for contact. Far from the wall, crn_lumen_contact returns the same distance as
 * crn_lumen_distance. */
crn_lumen_sample crn_lumen_contact(const crn_lumen *lumen, const crn_vec3 *position_m_q30);

#if CRN_HIGH_WORDS_BY_DSP
/* Sums 27 weighted coefficients (core_m7.c); `sum` is the lumen_sum of lumen.c. */
void crn_lumen_sum_27(void *sum);
#endif

#endif
