/* Sampling of the lumen: docs/lumen.md has the layout, the equations and their errors.
 *
 * Both samplers go the same way: world point -> coarse brick -> finer brick where refined -> position in the brick in
 * voxels (Q20) -> 8 or 27 int8 coefficients of one brick. Fixed work: two refinements, 8 or 27 taps.
 *
 * May include: lumen.h. Called by: contact. */
#include "firmware/core/lumen.h"

enum {
    FAR_M_Q30 = 1 << 24,
    BRICK_LOG2 = SELD_LUMEN_VOXEL_LOG2_Q30 + 3, /* edge of a coarse brick in Q30 m */
    ROW = 10,                                   /* coefficients along x */
    SLICE = 100,                                /* and in an x-y plane */
    HALF_VOXEL_Q20 = 1 << 19,
    VOXEL_MASK_Q20 = (1 << 20) - 1,
    IN_BRICK_MASK = (1 << BRICK_LOG2) - 1,
};

/* Where a point lies: its brick, its place there in voxels (Q20, 0 .. 8), and the brick's level. */
typedef struct lumen_place {
    const int8_t *brick; /* when it was found */
    uint32_t x_q20, y_q20, z_q20;
    uint32_t level;
    int32_t far_m_q30;
} lumen_place;

/* Entry of one refinement: the octant is given by bit `bit_index` of the coordinates. */
static inline uint32_t child_entry(const seld_lumen *lumen, uint32_t entry, uint32_t x, uint32_t y,
                                   uint32_t z, unsigned bit_index)
{
    const uint32_t bit = 1u << bit_index;
    uint32_t octant = ((x & bit) + (y & bit) * 2 + (z & bit) * 4) >> bit_index;
    return lumen->children[(ptrdiff_t)entry * 8 + octant - (ptrdiff_t)SELD_LUMEN_ENTRY_REFINED * 8];
}

/* Finds the brick; false where `far_m_q30` holds instead. Overflow: the validated lattice lies within the Q30 range, so that a difference modulo 2^32 inside
 * the lattice is the true difference, and any other fails the comparison. */
static inline bool find(const seld_lumen *lumen, const seld_vec3 *p, lumen_place *place)
{
    place->level = 0;
    place->far_m_q30 = FAR_M_Q30;
    uint32_t x = (uint32_t)p->v[0] - (uint32_t)lumen->origin_m_q30[0];
    uint32_t y = (uint32_t)p->v[1] - (uint32_t)lumen->origin_m_q30[1];
    uint32_t z = (uint32_t)p->v[2] - (uint32_t)lumen->origin_m_q30[2];
    uint32_t column = x >> BRICK_LOG2, row = y >> BRICK_LOG2, slice = z >> BRICK_LOG2;
    if (column >= lumen->brick_count_xyz[0] || row >= lumen->brick_count_xyz[1] ||
        slice >= lumen->brick_count_xyz[2]) {
        return false;
    }
    uint32_t line = slice * lumen->brick_count_xyz[1] + row;
    uint32_t entry = lumen->index[line * lumen->brick_count_xyz[0] + column];
    if (entry & SELD_LUMEN_ENTRY_REFINED) {
        entry = child_entry(lumen, entry, x, y, z, BRICK_LOG2 - 1);
        place->level = 1;
        if (entry & SELD_LUMEN_ENTRY_REFINED) {
            entry = child_entry(lumen, entry, x, y, z, BRICK_LOG2 - 2);
            place->level = 2;
        }
    }
    if (entry < SELD_LUMEN_ENTRY_FIRST_BRICK) {
        place->far_m_q30 = entry == SELD_LUMEN_ENTRY_INSIDE ? -FAR_M_Q30 : FAR_M_Q30;
        return false;
    }
    place->brick = lumen->samples + (size_t)(entry - SELD_LUMEN_ENTRY_FIRST_BRICK) * SELD_LUMEN_BRICK_SAMPLES;
    place->x_q20 = (x << place->level) & IN_BRICK_MASK;
    place->y_q20 = (y << place->level) & IN_BRICK_MASK;
    place->z_q20 = (z << place->level) & IN_BRICK_MASK;
    return true;
}

/* Point between two values, along y and z (along x the two products are dearer once and cheaper four times). Format: Qa, fraction Q8 in [0, 1) -> Q(a+8).
 * Overflow: the result is no larger than a or b and ends at 8 + 24 bits; the unsigned product may wrap on the way, which
 * cancels. Error: exact. */
static inline int32_t between(int32_t a, int32_t b, int32_t t_q8)
{
    return (int32_t)((uint32_t)a * 256u + (uint32_t)(b - a) * (uint32_t)t_q8);
}

int32_t seld_lumen_distance(const seld_lumen *lumen, const seld_vec3 *position_m_q30)
{
    lumen_place place;
    if (!find(lumen, position_m_q30, &place)) {
        return place.far_m_q30;
    }
    /* Coefficient i sits at i - 1/2 voxels: the cell is floor(x + 1/2). */
    uint32_t x = place.x_q20 + HALF_VOXEL_Q20, y = place.y_q20 + HALF_VOXEL_Q20,
             z = place.z_q20 + HALF_VOXEL_Q20;
    const int8_t *c = place.brick + ((z >> 20) * SLICE + (y >> 20) * ROW + (x >> 20));
    const int32_t t = (int32_t)(x >> 12 & 255u), rest = 256 - t, s = (int32_t)(y >> 12 & 255u);
    int32_t low = between(c[0] * rest + c[1] * t, c[ROW] * rest + c[ROW + 1] * t, s);
    c += SLICE;
    int32_t high = between(c[0] * rest + c[1] * t, c[ROW] * rest + c[ROW + 1] * t, s);
    /* Q24 of voxel/32, and that is 2^(15-L) Q30 units */
    return seld_asr32(between(low, high, (int32_t)(z >> 12 & 255u)), 9 + place.level);
}

/* The quadratic B-spline at fraction u of a voxel: weights (1-u)^2/2, the rest, u^2/2 in Q17; those of the slope per
 * voxel are -(1-u), 1-2u, u in Q20. */
typedef struct lumen_weights {
    int64_t low, middle, high;
    int64_t fall, rise; /* 1-u and u */
} lumen_weights;

/* Error: 1 LSB each (floor); the values' weights sum to one and the slopes' to zero exactly. */
static inline lumen_weights weights_at(uint32_t x_q20)
{
    int64_t u_q20 = x_q20 & VOXEL_MASK_Q20, v_q20 = (1 << 20) - u_q20;
    int64_t low = (v_q20 * v_q20) >> 24, high = (u_q20 * u_q20) >> 24;
    lumen_weights w = {low, (1 << 17) - low - high, high, v_q20, u_q20};
    return w;
}

/* Format: Qa -> Q(a+17) and Q(a+20). Overflow: see spline_27. Error: exact. */
static inline int64_t spline(int64_t a, int64_t b, int64_t c, const lumen_weights *w)
{
    return a * w->low + b * w->middle + c * w->high;
}

static inline int64_t slope(int64_t a, int64_t b, int64_t c, const lumen_weights *w)
{
    return (b - a) * w->fall + (c - b) * w->rise;
}

/* Value (Q51) and gradient per voxel (Q54) in voxel/32. */
typedef struct lumen_taps {
    int64_t value;
    int64_t slope_x, slope_y, slope_z;
} lumen_taps;

/* One row of three taps along x: value in the low word, slope in the high word (1 LSB low when the value is negative). */
static inline int64_t row_of(const int8_t *c, const lumen_weights *x)
{
    return c[0] * x->low + c[1] * x->middle + c[2] * x->high;
}

/* Value and slopes of three rows in a plane of constant z. */
typedef struct lumen_plane {
    int64_t value, slope_x, slope_y;
} lumen_plane;

static inline lumen_plane plane_of(const int8_t *c, const lumen_weights *x, const lumen_weights *y)
{
    int64_t first = row_of(c, x), second = row_of(c + ROW, x), third = row_of(c + 2 * ROW, x);
    lumen_plane plane;
    plane.slope_x = spline(seld_asr64(first, 32), seld_asr64(second, 32), seld_asr64(third, 32), y);
    int64_t a = (int32_t)(uint32_t)first, b = (int32_t)(uint32_t)second, d = (int32_t)(uint32_t)third;
    plane.value = spline(a, b, d, y);
    plane.slope_y = slope(a, b, d, y);
    return plane;
}

/* The 27 taps, first along x, then y, then z, all exact. Overflow: a value lies between the extremes of its taps, below
 * 2^7, and a slope within twice that, so every sum stays below 2^(8 + 17 + 17 + 20) = 2^62. */
static inline lumen_taps spline_27(const lumen_place *p)
{
    lumen_weights x = weights_at(p->x_q20);
    const lumen_weights y = weights_at(p->y_q20), z = weights_at(p->z_q20);
    /* Both sets of weights in one word for row_of. */
    x.low -= x.fall * ((int64_t)1 << 32);
    x.high += x.rise * ((int64_t)1 << 32);
    x.middle = (1 << 17) - x.low - x.high;
    /* The nearest sample of floor(x) is coefficient floor(x) + 1: the taps are floor(x) .. floor(x) + 2. */
    const int8_t *c = p->brick + ((p->z_q20 >> 20) * SLICE + (p->y_q20 >> 20) * ROW + (p->x_q20 >> 20));
    const lumen_plane a = plane_of(c, &x, &y), b = plane_of(c + SLICE, &x, &y),
                      d = plane_of(c + 2 * SLICE, &x, &y);
    lumen_taps taps = {spline(a.value, b.value, d.value, &z), spline(a.slope_x, b.slope_x, d.slope_x, &z),
                       spline(a.slope_y, b.slope_y, d.slope_y, &z), slope(a.value, b.value, d.value, &z)};
    return taps;
}

/* Inward unit normal -g/|g|. Format: Q54 -> Q30; a gradient below 2^-22 gives a zero normal. Overflow: |g| < 2^62, so
 * its upper words' squares sum to less than 2^62; |n| <= 1. Error: <= 4 LSB of Q30 beside that of g. */
static inline seld_vec3 inward(const lumen_taps *taps)
{
    int64_t x = seld_asr64(taps->slope_x, 32), y = seld_asr64(taps->slope_y, 32),
            z = seld_asr64(taps->slope_z, 32);
    uint64_t square = (uint64_t)(x * x + y * y + z * z);
    if (square == 0) {
        return seld_vec3_make(0, 0, 0);
    }
    unsigned lead = seld_clz64(square) & ~1u;
    int64_t root_q30 = seld_rsqrt_q30((uint32_t)((square << lead) >> 32));
    const unsigned drop = 32 - lead / 2;
    return seld_vec3_make((int32_t)seld_asr64(-(x * root_q30), drop),
                          (int32_t)seld_asr64(-(y * root_q30), drop),
                          (int32_t)seld_asr64(-(z * root_q30), drop));
}

seld_lumen_sample seld_lumen_contact(const seld_lumen *lumen, const seld_vec3 *position_m_q30)
{
    lumen_place place;
    seld_lumen_sample sample = {0, {{0, 0, 0}}};
    if (!find(lumen, position_m_q30, &place)) {
        sample.distance_m_q30 = place.far_m_q30;
        return sample;
    }
    lumen_taps taps = spline_27(&place);
    /* Q51 of voxel/32, and that is 2^(15-L) Q30 units */
    sample.distance_m_q30 = (int32_t)seld_rshift_round64(taps.value, 36 + place.level);
    sample.normal_q30 = inward(&taps);
    return sample;
}
