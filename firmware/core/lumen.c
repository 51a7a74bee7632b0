/* This file samples the lumen's distance field; docs/lumen.md describes the memory layout, the equations and
 * their errors.
 *
 * The functions crn_lumen_distance and crn_lumen_contact find a sample by the same steps. The code first
 * finds the coarse brick that contains a point, then the finer brick if the lattice is refined there, and
 * then the point's position in this brick, in voxels (Q20). Finally, the code reads the 27 int8 coefficients
 * around the point. Every sample takes the same amount of work, whatever the data are: the code makes two
 * refinement steps and reads 27 coefficients (taps). */
#include "firmware/core/lumen.h"
#include "firmware/core/near/near.h"

enum {
    FAR_M_Q30 = 1 << 24,
    BRICK_LOG2 = CRN_LUMEN_VOXEL_LOG2_Q30 + 3, /* edge of a coarse brick in Q30 m */
    ROW = 10,                                  /* coefficients along x */
    SLICE = 100,                               /* and in an x-y plane */
    VOXEL_MASK_Q20 = (1 << 20) - 1,
    IN_BRICK_MASK = (1 << BRICK_LOG2) - 1,
};

/* Describes the position of a point in the lattice: its brick, its coordinates in the brick in voxels (Q20, 0
 * .. 8), and the brick's level of refinement. */
typedef struct lumen_place {
    uint32_t number;     /* of the brick in the scene */
    const int8_t *brick; /* where its coefficients are read */
    uint32_t at;         /* with near memory: the index entry that leads to it */
    ptrdiff_t child;     /* the last child entry on the way to it */
    uint32_t x_q20, y_q20, z_q20;
    uint32_t level;
    int32_t far_m_q30;
} lumen_place;

/* Holds the coordinates of a point from the lattice's corner, and its coarse brick: the line of bricks along
 * x, and the column in the line. */
typedef struct lumen_corner {
    uint32_t x, y, z, line, column;
} lumen_corner;

/* Returns where the child of a refined entry lies in a list of children, after one refinement; bit
 * `bit_index` of each coordinate selects the octant. */
static inline ptrdiff_t child_of(uint32_t entry, const lumen_corner *c, unsigned bit_index)
{
    const uint32_t bit = 1u << bit_index;
    uint32_t octant = ((c->x & bit) + (c->y & bit) * 2 + (c->z & bit) * 4) >> bit_index;
    return (ptrdiff_t)entry * 8 + octant - (ptrdiff_t)CRN_LUMEN_ENTRY_REFINED * 8;
}

/* Returns the entry that the refinements of a coarse entry lead to. `children` is their list, in the scene or
 * in near memory, and place->child receives where the entry lies in this list. */
static inline uint32_t refined(const uint16_t *children, uint32_t entry, const lumen_corner *c,
                               lumen_place *place)
{
    if (entry & CRN_LUMEN_ENTRY_REFINED) {
        place->child = child_of(entry, c, BRICK_LOG2 - 1);
        entry = children[place->child];
        place->level = 1;
        if (entry & CRN_LUMEN_ENTRY_REFINED) {
            place->child = child_of(entry, c, BRICK_LOG2 - 2);
            entry = children[place->child];
            place->level = 2;
        }
    }
    return entry;
}

/* Returns false for a point outside the lattice. Overflow: the lattice, which was checked before, lies within
 * the Q30 range. For a point inside the lattice, a coordinate difference modulo 2^32 is correct. For a point
 * outside the lattice, the difference exceeds the lattice's size, and the comparison with this size shows
 * that the point is outside. */
static inline bool coarse_brick_at(const crn_lumen *lumen, const crn_vec3 *p, lumen_corner *c)
{
    c->x = (uint32_t)p->v[0] - (uint32_t)lumen->origin_m_q30[0];
    c->y = (uint32_t)p->v[1] - (uint32_t)lumen->origin_m_q30[1];
    c->z = (uint32_t)p->v[2] - (uint32_t)lumen->origin_m_q30[2];
    const uint32_t row = c->y >> BRICK_LOG2, slice = c->z >> BRICK_LOG2;
    c->column = c->x >> BRICK_LOG2;
    if (c->column >= lumen->brick_count_xyz[0] || row >= lumen->brick_count_xyz[1] ||
        slice >= lumen->brick_count_xyz[2]) {
        return false;
    }
    c->line = slice * lumen->brick_count_xyz[1] + row;
    return true;
}

/* Completes the place of a point whose brick's entry is known. */
static inline bool place_in_brick(const lumen_corner *c, uint32_t entry, lumen_place *place)
{
    if (entry < CRN_LUMEN_ENTRY_FIRST_BRICK) {
        place->far_m_q30 = entry == CRN_LUMEN_ENTRY_INSIDE ? -FAR_M_Q30 : FAR_M_Q30;
        return false;
    }
    place->number = entry - CRN_LUMEN_ENTRY_FIRST_BRICK;
    place->x_q20 = (c->x << place->level) & IN_BRICK_MASK;
    place->y_q20 = (c->y << place->level) & IN_BRICK_MASK;
    place->z_q20 = (c->z << place->level) & IN_BRICK_MASK;
    return true;
}

/* Finds the brick by the scene's index. Returns false if the point lies in no brick; in this case `far_m_q30`
 * is the distance to the wall. */
static inline bool find_in_scene(const crn_lumen *lumen, const crn_vec3 *p, lumen_place *place)
{
    lumen_corner c;
    place->level = place->at = 0;
    place->brick = lumen->samples;
    place->far_m_q30 = FAR_M_Q30;
    if (!coarse_brick_at(lumen, p, &c)) {
        return false;
    }
    const uint32_t entry =
        refined(lumen->children, lumen->index[c.line * lumen->brick_count_xyz[0] + c.column], &c, place);
    if (!place_in_brick(&c, entry, place)) {
        return false;
    }
    place->brick += (size_t)place->number * CRN_LUMEN_BRICK_SAMPLES;
    return true;
}

/* Finds the same brick by the index in near memory. In this index, a brick that is in near memory has the
 * entry of its slot, which leads to its number in the scene. */
static inline bool find_in_near(const crn_lumen *lumen, const crn_vec3 *p, lumen_place *place)
{
    const crn_near *near = lumen->near;
    lumen_corner c;
    place->level = place->at = 0;
    place->brick = NULL; /* until it is needed */
    place->far_m_q30 = FAR_M_Q30;
    if (!coarse_brick_at(lumen, p, &c)) {
        return false;
    }
    const crn_near_span *span = &near->spans[c.line];
    const uint32_t in_span = c.column - span->column;
    if (in_span >= (uint32_t)(span[1].begin - span->begin)) {
        return false;
    }
    place->at = span->begin + in_span;
    uint32_t entry = near->entries[place->at];
    if (entry & CRN_LUMEN_ENTRY_REFINED) {
        entry = refined(near->entries + near->child_begin, entry, &c, place);
        place->at = near->child_begin + (uint32_t)place->child;
    }
    if (entry >= CRN_LUMEN_ENTRY_FIRST_BRICK) {
        entry = crn_near_brick_number(near, entry) + (uint32_t)CRN_LUMEN_ENTRY_FIRST_BRICK;
    }
    return place_in_brick(&c, entry, place);
}

/* Finds the brick, and copies what a sample reads of it if near memory lacks it. */
static inline bool find(const crn_lumen *lumen, const crn_vec3 *p, lumen_place *place)
{
    if (lumen->near == NULL) {
        return find_in_scene(lumen, p, place);
    }
    if (!find_in_near(lumen, p, place)) {
        return false;
    }
    place->brick = crn_near_brick(lumen->near, place->at, place->z_q20 >> 20);
    return true;
}

/* Holds the three weights of the quadratic B-spline at the fraction u of a voxel: the first is (1-u)^2/2, the
 * last is u^2/2, and the middle one is the remainder to one. The three weights of the spline's slope per
 * voxel are -(1-u), 1-2u and u. The fast integer types have the width that the processor multiplies fastest;
 * the weights fit 32 bits. */
typedef struct lumen_weights {
    int_fast32_t low, middle, high;
    int_fast32_t fall, rise; /* 1-u and u */
} lumen_weights;

/* Half of a square. Format: Q20 in [0, 1] -> Q29. Error: 1/2 LSB. */
static inline int32_t half_square_q29(uint32_t v_q20)
{
    return crn_mulh((int32_t)(v_q20 << 10), (int32_t)(v_q20 << 10));
}

/* Format: fraction Q20 -> values Q30, slopes Q29. The error of each weight is at most 1 LSB. The three
 * weights of a value sum exactly to one, and the three weights of a slope sum exactly to zero. Overflow is
 * impossible, because no weight is above one. */
static inline lumen_weights weights_at(uint32_t x_q20)
{
    const uint32_t u_q20 = x_q20 & VOXEL_MASK_Q20, v_q20 = (1u << 20) - u_q20;
    const int32_t low = half_square_q29(v_q20) * 2, high = half_square_q29(u_q20) * 2;
    return (lumen_weights){low, (1 << 30) - low - high, high, (int32_t)(v_q20 << 9), (int32_t)(u_q20 << 9)};
}

/* These functions return the high words of sums of three products. Format: Qa, weights Qb -> Q(a+b-32).
 * Error: 1 LSB (floor). Overflow is impossible. For a value, the three spline weights sum to one. For a
 * slope, the three weights have one fraction bit less than for a value, and their magnitudes sum to two. The
 * sums of three products of a coefficient and a weight stay below 2^31 * 2^30. */
static inline int_fast32_t spline(int_fast32_t a, int_fast32_t b, int_fast32_t c, const lumen_weights *w)
{
    return crn_high64((int64_t)a * w->low + (int64_t)b * w->middle + (int64_t)c * w->high);
}

/* Holds the weights along x in the form in which row_of() multiplies them, and the position at which row_of()
 * begins to read. */
typedef struct lumen_row_weights {
#if CRN_HIGH_WORDS_BY_DSP
    uint32_t value, slope, middle; /* pairs of 16 bits: low and high, -fall and rise, both middles */
    uint32_t shift;                /* brings the taps to the upper three bytes of a word */
#else
    int64_t low, middle, high; /* value in the lower half, slope in the upper */
#endif
} lumen_row_weights;

/* Format: fraction Q20 -> values Q15, slopes Q14, each within 16 bits. */
static inline lumen_row_weights row_weights_at(uint32_t x_q20)
{
    const uint32_t u_q20 = x_q20 & VOXEL_MASK_Q20;
    const int32_t low = (half_square_q29((1u << 20) - u_q20) + (1 << 13)) >> 14;
    const int32_t high = (half_square_q29(u_q20) + (1 << 13)) >> 14;
    const int32_t middle = (1 << 15) - low - high;
    const int32_t rise = (int32_t)((u_q20 + (1 << 5)) >> 6), fall = (1 << 14) - rise;
#if CRN_HIGH_WORDS_BY_DSP
    /* A 32-bit word that begins one coefficient early holds the three wanted coefficients in its upper bytes.
     * In the brick's first column, a word that begins one coefficient early would begin before the brick. In
     * the brick's first column the code reads the word that begins with the brick's first coefficient, and
     * shifts this word. */
    return (lumen_row_weights){(uint32_t)low | (uint32_t)high << 16,
                               ((uint32_t)-fall & 0xffffu) | (uint32_t)rise << 16,
                               (uint32_t)middle | (uint32_t)(fall - rise) << 16, x_q20 >> 20 == 0 ? 8 : 0};
#else
    const int64_t upper = (int64_t)1 << 32;
    return (lumen_row_weights){256 * (low - fall * upper), 256 * (middle + (fall - rise) * upper),
                               256 * (high + rise * upper)};
#endif
}

#if CRN_HIGH_WORDS_BY_DSP
static inline int_fast32_t value_of_row(const int8_t *c, const lumen_row_weights *w)
{
    const uint32_t upper_bytes = 0xff00ff00u;
    uint32_t word;
    int32_t value;
    __builtin_memcpy(&word, c - 1 + (w->shift >> 3), sizeof word);
    word <<= w->shift;
    uint32_t outer = word & upper_bytes, inner = word << 8 & upper_bytes;
    __asm__("smuad %0, %1, %2" : "=r"(value) : "r"(outer), "r"(w->value));
    __asm__("smlatb %0, %1, %2, %0" : "+r"(value) : "r"(inner), "r"(w->middle));
    return value;
}
#else
/* Holds the weighted sum of three coefficients (taps) along x, as a value in Q23 and a slope in Q22. The sum
 * is exact. Overflow is impossible: coefficients are within +-128, and the weights of a slope add up to two
 * in magnitude, so the result is at most 2^30. */
typedef struct lumen_row {
    int_fast32_t value, slope;
} lumen_row;

static inline lumen_row row_of(const int8_t *c, const lumen_row_weights *w)
{
    int64_t both = c[0] * w->low + c[1] * w->middle + c[2] * w->high;
    /* A negative value in the lower half of the word borrows one from the slope in the upper half. */
    return (lumen_row){(int32_t)(uint32_t)both, crn_asr64(both + ((int64_t)1 << 31), 32)};
}

static inline int_fast32_t value_of_row(const int8_t *c, const lumen_row_weights *w)
{
    return (int32_t)(uint32_t)(uint64_t)(c[0] * w->low + c[1] * w->middle + c[2] * w->high);
}
#endif

/* Holds the value (Q19) and the gradient per voxel (Q18), both in units of voxel/32. */
typedef struct lumen_taps {
    int32_t value;
    int32_t slope_x, slope_y, slope_z;
} lumen_taps;

/* Returns which coefficient of the brick is the first of the 27 around a point. Of the three coefficients
 * (taps) along an axis, the middle one has the number floor(x) + 1, so the code reads the coefficients
 * floor(x) .. floor(x) + 2. */
static inline uint32_t first_tap_number(const lumen_place *p)
{
    return (p->z_q20 >> 20) * SLICE + (p->y_q20 >> 20) * ROW + (p->x_q20 >> 20);
}

/* Returns the first of the 27 coefficients around a point. */
static inline const int8_t *first_tap(const lumen_place *p)
{
    return p->brick + first_tap_number(p);
}

#if CRN_HIGH_WORDS_BY_DSP
/* What the sum over 27 coefficients needs, in the order in which the assembly of core_m7.c reads it. */
typedef struct lumen_sum {
    uint32_t saved[9]; /* registers of the caller */
    lumen_row_weights x;
    const int8_t *first; /* where row_of() begins to read */
    lumen_weights y, z;
    int32_t planes[2][3]; /* value, slope along y and along x */
    lumen_taps taps;
} lumen_sum;
_Static_assert(offsetof(lumen_sum, x) == 36 && offsetof(lumen_sum, first) == 52 &&
                   offsetof(lumen_sum, y) == 56 && offsetof(lumen_sum, z) == 76 &&
                   offsetof(lumen_sum, planes) == 96 && offsetof(lumen_sum, taps) == 120,
               "as the code has it");

/* Sums the 27 weighted coefficients (taps), first along x, then along y, then along z. Overflow is
 * impossible: an interpolated value lies between the smallest and the largest of its coefficients, which are
 * within +-2^7, and a slope is at most twice as large. Each weight has an error of 1 LSB of Q15. The errors
 * of the weights cause an error of 15 nm in the distance, and of 3e-5 in a slope of one. */
static inline lumen_taps spline_27(const lumen_place *p)
{
    lumen_sum sum;
    sum.x = row_weights_at(p->x_q20);
    sum.y = weights_at(p->y_q20);
    sum.z = weights_at(p->z_q20);
    sum.first = first_tap(p) - 1 + (sum.x.shift >> 3);
    crn_lumen_sum_27(&sum);
    return sum.taps;
}
#else
static inline int_fast32_t slope(int_fast32_t a, int_fast32_t b, int_fast32_t c, const lumen_weights *w)
{
    return crn_high64((int64_t)(b - a) * w->fall + (int64_t)(c - b) * w->rise);
}

/* Holds the value (Q21) and the slopes (Q20) of three rows in a plane of constant z. */
typedef struct lumen_plane {
    int_fast32_t value, slope_x, slope_y;
} lumen_plane;

static inline lumen_plane plane_of(const int8_t *c, const lumen_row_weights *x, const lumen_weights *y)
{
    const lumen_row first = row_of(c, x), second = row_of(c + ROW, x), third = row_of(c + 2 * ROW, x);
    return (lumen_plane){spline(first.value, second.value, third.value, y),
                         spline(first.slope, second.slope, third.slope, y),
                         slope(first.value, second.value, third.value, y)};
}

static inline lumen_taps spline_27(const lumen_place *p)
{
    const lumen_row_weights x = row_weights_at(p->x_q20);
    const lumen_weights y = weights_at(p->y_q20), z = weights_at(p->z_q20);
    const int8_t *c = first_tap(p);
    const lumen_plane a = plane_of(c, &x, &y), b = plane_of(c + SLICE, &x, &y),
                      d = plane_of(c + 2 * SLICE, &x, &y);
    lumen_taps taps = {
        (int32_t)spline(a.value, b.value, d.value, &z), (int32_t)spline(a.slope_x, b.slope_x, d.slope_x, &z),
        (int32_t)spline(a.slope_y, b.slope_y, d.slope_y, &z), (int32_t)slope(a.value, b.value, d.value, &z)};
    return taps;
}
#endif

/* Returns the inward unit normal, which is -g / |g|, or zero where the gradient is zero. Format: Q18 -> Q30.
 * Overflow is impossible: the gradient g is below 2^27, so the squares sum to less than 2^55, and the normal
 * n is at most 1. The error of the normal is at most 4 LSB of Q30, in addition to the error of the gradient
 * g. */
static inline crn_vec3 inward(const lumen_taps *taps)
{
    int32_t x = taps->slope_x, y = taps->slope_y, z = taps->slope_z;
    uint64_t square = (uint64_t)((int64_t)x * x + (int64_t)y * y + (int64_t)z * z);
    if (square == 0) {
        return crn_vec3_make(0, 0, 0);
    }
    unsigned lead = crn_clz64(square) & ~1u;
    int32_t root_q30 = crn_rsqrt_q30((uint32_t)((square << lead) >> 32));
    /* 1/|g| = root 2^(lead/2 - 62), and |g| 2^(lead/2) < 2^32: it is halved here and doubled again by reading
     * the root's Q30 as Q31 */
    int32_t scale = -((int32_t)1 << (lead / 2 - 1));
    return crn_vec3_make(crn_mulh(x * scale, root_q30) * 2, crn_mulh(y * scale, root_q30) * 2,
                         crn_mulh(z * scale, root_q30) * 2);
}

/* Format: Q19 of voxel/32, and that is 2^(15-L) Q30 units. */
static inline int32_t metres_q30(int32_t value_q19, uint32_t level)
{
    return crn_asr32(value_q19 + (8 << level), 4 + level);
}

static inline int_fast32_t value_of_plane(const int8_t *c, const lumen_row_weights *x, const lumen_weights *y)
{
    return spline(value_of_row(c, x), value_of_row(c + ROW, x), value_of_row(c + 2 * ROW, x), y);
}

/* Returns the distance at a place. Bound: the weights along each axis are not negative and sum exactly to
 * one, so the value in Q19 is at most the greatest coefficient, exactly. */
static inline int32_t distance_at(const lumen_place *p)
{
    const lumen_row_weights x = row_weights_at(p->x_q20);
    const lumen_weights y = weights_at(p->y_q20), z = weights_at(p->z_q20);
    const int8_t *c = first_tap(p);
    const int_fast32_t low = value_of_plane(c, &x, &y), middle = value_of_plane(c + SLICE, &x, &y),
                       high = value_of_plane(c + 2 * SLICE, &x, &y);
    return metres_q30((int32_t)spline(low, middle, high, &z), p->level);
}

int32_t crn_lumen_distance(const crn_lumen *lumen, const crn_vec3 *position_m_q30)
{
    lumen_place place;
    return find(lumen, position_m_q30, &place) ? distance_at(&place) : place.far_m_q30;
}

/* Overflow is impossible: an entry of the index has 15 bits for a brick, so there are fewer than 2^15 * 1000
 * coefficients, and their number fits 25 bits. */
enum { VOXEL_DEPTH_BITS = 7, VOXEL_DEPTH_MOST = 127 };

/* Returns how deep in the lumen the shallowest of the 27 coefficients is, 0 .. 127. Unit: voxel/32. */
static int32_t least_depth_of_27(const int8_t *c)
{
    int32_t greatest = -VOXEL_DEPTH_MOST;
    for (int z = 0; z < 3 * SLICE && greatest < 0; z += SLICE) {
        for (int y = z; y < z + 3 * ROW; y += ROW) {
            for (int x = y; x < y + 3; x++) {
                greatest = c[x] > greatest ? c[x] : greatest;
            }
        }
    }
    return greatest < 0 ? -greatest : 0;
}

/* Of the brick, only its number is needed while the point stays deep in the lumen in the same voxel. */
int32_t crn_lumen_distance_unless_far(const crn_lumen *lumen, const crn_vec3 *position_m_q30,
                                      int32_t far_m_q30, crn_lumen_voxel *last)
{
    lumen_place place;
    const bool is_near = lumen->near != NULL;
    if (is_near ? !find_in_near(lumen, position_m_q30, &place)
                : !find_in_scene(lumen, position_m_q30, &place)) {
        return place.far_m_q30;
    }
    const uint32_t number = place.number * CRN_LUMEN_BRICK_SAMPLES + first_tap_number(&place) + 1;
    const bool is_known = last->number_and_depth >> VOXEL_DEPTH_BITS == number;
    int32_t depth = (int32_t)(last->number_and_depth & VOXEL_DEPTH_MOST);
    int32_t most = metres_q30(-depth * (1 << 19), place.level);
    if (is_known && depth != 0 && most < far_m_q30) {
        return most;
    }
    if (is_near) {
        place.brick = crn_near_brick(lumen->near, place.at, place.z_q20 >> 20);
    }
    if (!is_known) {
        depth = least_depth_of_27(first_tap(&place));
        most = metres_q30(-depth * (1 << 19), place.level);
        last->number_and_depth = number << VOXEL_DEPTH_BITS | (uint32_t)depth;
    }
    return depth != 0 && most < far_m_q30 ? most : distance_at(&place);
}

crn_lumen_sample crn_lumen_contact(const crn_lumen *lumen, const crn_vec3 *position_m_q30)
{
    lumen_place place;
    crn_lumen_sample sample = {0, {{0, 0, 0}}};
    if (!find(lumen, position_m_q30, &place)) {
        sample.distance_m_q30 = place.far_m_q30;
        return sample;
    }
    lumen_taps taps = spline_27(&place);
    sample.distance_m_q30 = metres_q30(taps.value, place.level);
    sample.normal_q30 = inward(&taps);
    return sample;
}
