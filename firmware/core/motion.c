/* Looking up the lattice of a moving vessel (motion.h, docs/heart.md). Fixed work: 8 corners of one cell, of three components, of
 * three coefficients and one of breath, for now and for what the tick changed; the blend of a cell is kept for the next point in it,
 * which changes no result.
 * May include: motion.h, rod.h (quotient). Called by: rod_contact.c, core_state.c. */
#include "firmware/core/motion.h"
#include "firmware/core/rod.h"

enum {
    NO_CELL = -1,
    FRACTION_BITS = 15,
    DETERMINANT_MIN_q20 =
        1 << 17, /* 1/8: a lattice that folds over is none, but must not divide by nothing */
    NODE = 3 * SELD_MOTION_ROW,
};

/* The quadratic B-spline's weights at the fraction f between two half keyframes: (1-f)^2/2, the rest, f^2/2. */
seld_motion_moment seld_motion_moment_at(uint32_t heart_phase32, uint32_t breath_phase32)
{
    uint64_t place_q32 = (uint64_t)heart_phase32 * SELD_MOTION_KEYFRAMES + ((uint64_t)1 << 31);
    uint32_t first = (uint32_t)(place_q32 >> 32);
    int32_t f_q15 = (int32_t)((uint32_t)place_q32 >> (32 - FRACTION_BITS)), rest_q15 = 32768 - f_q15;
    int32_t low = (rest_q15 * rest_q15 + 32768) / 65536, high = (f_q15 * f_q15 + 32768) / 65536;
    return (seld_motion_moment){first == SELD_MOTION_KEYFRAMES ? 0 : first,
                                {low, 32768 - low - high, high},
                                seld_breath_depth_q15(breath_phase32)};
}

void seld_motion_pose_begin(const seld_motion *motion, seld_motion_pose *pose, const seld_rhythm *before,
                            const seld_rhythm *now)
{
    const uint32_t row = motion->count_xyz[0], slice = row * motion->count_xyz[1];
    for (uint32_t corner = 0; corner < 8; corner++) {
        pose->corner_rows[corner] = NODE * ((corner & 1u) + (corner >> 1 & 1u) * row + (corner >> 2) * slice);
    }
    pose->now = seld_motion_moment_at(now->heart_phase32, now->breath_phase32);
    pose->before = seld_motion_moment_at(before->heart_phase32, before->breath_phase32);
    pose->ways.node = pose->changes.node = (uint32_t)NO_CELL;
}

/* Corners to blend. */
typedef struct corner_list {
    const uint8_t *corners;
    uint32_t count;
} corner_list;

/* Goes on to another cell: where that is one step along an axis away, the four corners that they share move to their new places. Returns the others. */
static corner_list move_on(const seld_motion *motion, uint32_t to, seld_motion_cell *cell)
{
    /* corners on the low and the high side along x, y, z */
    static const uint8_t sides[6][4] = {{0, 2, 4, 6}, {1, 3, 5, 7}, {0, 1, 4, 5},
                                        {2, 3, 6, 7}, {0, 1, 2, 3}, {4, 5, 6, 7}};
    static const uint8_t all[8] = {0, 1, 2, 3, 4, 5, 6, 7};
    const uint32_t steps[3] = {1, motion->count_xyz[0], motion->count_xyz[0] * motion->count_xyz[1]};
    const uint32_t from = cell->node;
    cell->node = to;
    for (uint32_t axis = 0; from != (uint32_t)NO_CELL && axis < 3; axis++) {
        const uint32_t high = to - from == steps[axis] ? 1u : 0u;
        if (high == 0 && from - to != steps[axis]) {
            continue;
        }
        const uint8_t *shared = sides[2 * axis + high], *places = sides[2 * axis + 1 - high];
        for (int i = 0; i < 4; i++) {
            cell->corners_m_q34[places[i]] = cell->corners_m_q34[shared[i]];
        }
        return (corner_list){shared, 4};
    }
    return (corner_list){all, 8};
}

/* Sum over the taps of a component. Format: Q15 x 2^-19 m -> Q34 m. Overflow: |coefficient| <= 2^14 (checked); weights of the heart sum
 * to 2^15 and breath has at most as much: 2^30. */
static inline int32_t blend(const int16_t *taps, int32_t breath, const seld_motion_moment *weights)
{
    return taps[0] * weights->weights_q15[0] + taps[1] * weights->weights_q15[1] +
           taps[2] * weights->weights_q15[2] + breath * weights->breath_q15;
}

/* The ways at a cell's corners now. */
static void enter_cell(const seld_motion *motion, seld_motion_pose *pose, uint32_t node)
{
    const corner_list fresh = move_on(motion, node, &pose->ways);
    const seld_motion_moment now = pose->now;
    const int16_t *rows = motion->rows + (size_t)node * NODE;
    for (uint32_t i = 0; i < fresh.count; i++) {
        const uint32_t corner = fresh.corners[i];
        const int16_t *row = rows + pose->corner_rows[corner];
        int32_t *way = pose->ways.corners_m_q34[corner].v;
        for (int k = 0; k < 3; k++, row += SELD_MOTION_ROW) {
            way[k] = blend(row + now.first, row[SELD_MOTION_ROW_BREATH], &now);
        }
    }
}

/* What the tick has changed at a corner, when it began before the last keyframe and ended after it. */
static int32_t change_across(const int16_t *row, const seld_motion_pose *pose)
{
    const int32_t breath = row[SELD_MOTION_ROW_BREATH];
    return seld_sub_sat(blend(row + pose->now.first, breath, &pose->now),
                        blend(row + pose->before.first, breath, &pose->before));
}

/* What the tick has changed in the ways at a cell's corners, limited so that what is made of it fits. As a rule both moments lie between the same
 * keyframes, and the change of the weights, which sums to nothing, makes it. */
static void enter_changing_cell(const seld_motion *motion, seld_motion_pose *pose, uint32_t node)
{
    enum { MOST = 2 * SELD_MOTION_WALL_STEP_MAX_M_Q33 };
    const corner_list fresh = move_on(motion, node, &pose->changes);
    const seld_motion_moment *now = &pose->now, *before = &pose->before;
    const int32_t low = now->weights_q15[0] - before->weights_q15[0],
                  high = now->weights_q15[2] - before->weights_q15[2],
                  deeper = now->breath_q15 - before->breath_q15;
    const uint32_t first = now->first;
    const bool is_across = first != before->first;
    const int16_t *rows = motion->rows + (size_t)node * NODE;
    for (uint32_t i = 0; i < fresh.count; i++) {
        const uint32_t corner = fresh.corners[i];
        const int16_t *row = rows + pose->corner_rows[corner];
        int32_t *change = pose->changes.corners_m_q34[corner].v;
        for (int k = 0; k < 3; k++, row += SELD_MOTION_ROW) {
            const int16_t *taps = row + first;
            const int32_t by =
                (taps[0] - taps[1]) * low + (taps[2] - taps[1]) * high + row[SELD_MOTION_ROW_BREATH] * deeper;
            change[k] = seld_clamp(is_across ? change_across(row, pose) : by, -MOST, MOST);
        }
    }
}

/* Point between two corners. Overflow: they differ by at most a spacing (checked): 2^28. Error: 2 LSB (floor). */
static inline int32_t between(int32_t a, int32_t b, int32_t t_q31)
{
    return a + seld_high64((int64_t)(b - a) * t_q31) * 2;
}

/* Finds the cell and the place in it; false outside. As in lumen.c a difference modulo 2^32 is the true one in the lattice. */
static inline bool find(const seld_motion *motion, seld_motion_pose *pose, const seld_vec3 *p, uint32_t *cell)
{
    const uint32_t log2 = motion->spacing_log2_q30;
    uint32_t x = (uint32_t)p->v[0] - (uint32_t)motion->origin_m_q30[0];
    uint32_t y = (uint32_t)p->v[1] - (uint32_t)motion->origin_m_q30[1];
    uint32_t z = (uint32_t)p->v[2] - (uint32_t)motion->origin_m_q30[2];
    uint32_t column = x >> log2, row = y >> log2, slice = z >> log2;
    if (column >= motion->count_xyz[0] - 1 || row >= motion->count_xyz[1] - 1 ||
        slice >= motion->count_xyz[2] - 1) {
        return false;
    }
    const uint32_t up = 31 - log2; /* the fraction's bits to the top of 31 */
    pose->fraction_q31[0] = (int32_t)(x << up & INT32_MAX);
    pose->fraction_q31[1] = (int32_t)(y << up & INT32_MAX);
    pose->fraction_q31[2] = (int32_t)(z << up & INT32_MAX);
    *cell = (slice * motion->count_xyz[1] + row) * motion->count_xyz[0] + column;
    return true;
}

seld_vec3 seld_motion_pull(const seld_motion *motion, seld_motion_pose *pose, const seld_vec3 *world_m_q30)
{
    uint32_t cell;
    pose->has_gradient = false;
    pose->is_inside = find(motion, pose, world_m_q30, &cell);
    if (!pose->is_inside) {
        return *world_m_q30;
    }
    if (cell != pose->ways.node) {
        enter_cell(motion, pose, cell);
    }
    const seld_vec3 *c = pose->ways.corners_m_q34;
    const int32_t *t = pose->fraction_q31;
    seld_vec3 reference;
    for (int k = 0; k < 3; k++) {
        int32_t *edge = pose->edges_m_q34[k];
        for (int i = 0; i < 4; i++) {
            edge[i] = between(c[2 * i].v[k], c[2 * i + 1].v[k], t[0]);
        }
        int32_t way_m_q34 = between(between(edge[0], edge[1], t[1]), between(edge[2], edge[3], t[1]), t[2]);
        reference.v[k] = seld_add_sat(world_m_q30->v[k], seld_asr32(way_m_q34 + 8, 4));
    }
    return reference;
}

/* Largest |difference|^2 of neighbours along an axis: over the keyframes, and of breath. Format: coefficients. Overflow: neighbours differ by at
 * most 2^13 (checked): 3 x 2^26. */
static void longest_difference(const seld_motion *motion, uint32_t axis, uint32_t *beat, uint32_t *breath)
{
    const uint32_t *n = motion->count_xyz;
    const uint32_t steps[3] = {1, n[0], n[0] * n[1]}, nodes = n[0] * n[1] * n[2];
    *beat = *breath = 0;
    for (uint32_t node = 0; node + steps[axis] < nodes; node++) {
        /* past the end of a line comes the next line's boundary, which is 0 as the end's: no difference */
        const int16_t *here = motion->rows + (size_t)node * NODE, *next = here + (size_t)steps[axis] * NODE;
        for (int i = 0; i <= SELD_MOTION_ROW_BREATH; i++) {
            uint32_t square = 0;
            for (int k = 0; k < 3; k++) {
                const int32_t apart = next[k * SELD_MOTION_ROW + i] - here[k * SELD_MOTION_ROW + i];
                square += (uint32_t)(apart * apart);
            }
            uint32_t *most = i == SELD_MOTION_ROW_BREATH ? breath : beat;
            *most = square > *most ? square : *most;
        }
    }
}

int32_t seld_motion_shrink_q30(const seld_motion *motion)
{
    uint64_t square = 0;
    for (uint32_t axis = 0; axis < 3; axis++) {
        uint32_t beat, breath;
        longest_difference(motion, axis, &beat, &breath);
        const uint64_t most =
            (uint64_t)seld_sqrt64(beat) + (uint64_t)seld_sqrt64(breath) + 2; /* rounded up */
        square += most * most;
    }
    const uint64_t spacing = (uint64_t)1 << (motion->spacing_log2_q30 - SELD_MOTION_UNIT_LOG2_Q30);
    return (int32_t)seld_divide_u64(spacing << 30, spacing + (uint64_t)seld_sqrt64(square) + 1);
}

/* I + J, J = dw_i/dx_j in the cell of the last point. Format: Q34 m per spacing -> Q28. Overflow: at most 2 (checked). */
static void gradient_here(const seld_motion *motion, seld_motion_pose *pose)
{
    const seld_vec3 *c = pose->ways.corners_m_q34;
    const int32_t *t = pose->fraction_q31;
    /* Q34 m / (2^log2 Q30 m) = 2^(-4 - log2), in Q28 */
    const int32_t up = (int32_t)1 << (24 - motion->spacing_log2_q30);
    pose->has_gradient = true;
    for (int k = 0; k < 3; k++) {
        const int32_t *edge = pose->edges_m_q34[k];
        int32_t d[4];
        for (int i = 0; i < 4; i++) {
            d[i] = c[2 * i + 1].v[k] - c[2 * i].v[k];
        }
        int32_t *row = pose->gradient_q28[k];
        row[0] = between(between(d[0], d[1], t[1]), between(d[2], d[3], t[1]), t[2]) * up;
        row[1] = between(edge[1] - edge[0], edge[3] - edge[2], t[2]) * up;
        row[2] = between(edge[2] - edge[0], edge[3] - edge[1], t[1]) * up;
        row[k] += 1 << 28;
    }
}

/* 1 / (1 + |J|) here, |J|^2 being at most the largest sum of magnitudes of a column times that of a row. Format: Q30. */
static int32_t shrink_here(const seld_motion_pose *pose)
{
    int32_t most_q28 = 0, columns_q28[3] = {0, 0, 0};
    for (int i = 0; i < 3; i++) {
        int32_t sum_q28 = 0;
        for (int j = 0; j < 3; j++) {
            const int32_t entry = pose->gradient_q28[i][j] - (i == j ? 1 << 28 : 0),
                          size = entry < 0 ? -entry : entry;
            sum_q28 += size;
            columns_q28[j] += size;
        }
        most_q28 = sum_q28 > most_q28 ? sum_q28 : most_q28;
    }
    for (int j = 0; j < 3; j++) {
        most_q28 = columns_q28[j] > most_q28 ? columns_q28[j] : most_q28;
    }
    return seld_quotient(1 << 28, (1 << 28) + most_q28, 30);
}

int32_t seld_motion_distance(const seld_lumen *lumen, const seld_motion *motion, seld_motion_pose *pose,
                             const seld_vec3 *world_m_q30, int32_t shrink_q30, int32_t far_m_q30)
{
    enum {
        ROUNDING_M_Q30 = 32
    }; /* of the quotients here and in seld_motion_contact, of distances up to 15.6 mm */
    pose->reference_m_q30 = seld_motion_pull(motion, pose, world_m_q30);
    const int32_t reference = seld_lumen_distance(lumen, &pose->reference_m_q30);
    if (reference >= 0 || !pose->is_inside) {
        return reference;
    }
    const int32_t distance = seld_scale_q30(reference, shrink_q30) + ROUNDING_M_Q30;
    if (distance < far_m_q30) {
        return distance;
    }
    gradient_here(motion, pose);
    return seld_scale_q30(reference, shrink_here(pose)) + ROUNDING_M_Q30;
}

/* (I + J)^T n of a unit normal. Format: Q30 -> Q26. Overflow: at most 1 + sqrt(3) in a component, below 8. Error: 2 LSB. */
static inline seld_vec3 mapped_normal(const seld_motion_pose *pose, const seld_vec3 *normal_q30)
{
    const int32_t(*m)[3] = (const int32_t(*)[3])pose->gradient_q28;
    const int32_t *n = normal_q30->v;
    seld_vec3 mapped;
    for (int j = 0; j < 3; j++) {
        mapped.v[j] = seld_mulh_add(seld_mulh_add(seld_mulh(m[0][j], n[0]), m[1][j], n[1]), m[2][j], n[2]);
    }
    return mapped;
}

seld_lumen_sample seld_motion_contact_here(const seld_lumen *lumen, const seld_motion *motion,
                                           seld_motion_pose *pose)
{
    const seld_vec3 none = {{0, 0, 0}};
    seld_lumen_sample sample = seld_lumen_contact(lumen, &pose->reference_m_q30);
    if (!pose->is_inside || (sample.normal_q30.v[0] | sample.normal_q30.v[1] | sample.normal_q30.v[2]) == 0) {
        return sample;
    }
    if (!pose->has_gradient) {
        gradient_here(motion, pose);
    }
    int32_t length_q26;
    sample.normal_q30 = seld_vec3_normalise(mapped_normal(pose, &sample.normal_q30), none, &length_q26);
    if (length_q26 > 0) {
        sample.distance_m_q30 = seld_quotient(sample.distance_m_q30, length_q26, 26);
    }
    return sample;
}

seld_lumen_sample seld_motion_contact(const seld_lumen *lumen, const seld_motion *motion,
                                      seld_motion_pose *pose, const seld_vec3 *world_m_q30)
{
    pose->reference_m_q30 = seld_motion_pull(motion, pose, world_m_q30);
    return seld_motion_contact_here(lumen, motion, pose);
}

/* --- how the wall moves ------------------------------------------------------------------------------------------ */

/* Change of w in this tick at the last point. Q39 m. Overflow: limited to 4 mm at the corners: 2^31 / 2. */
static inline seld_vec3 change_here(const seld_motion *motion, seld_motion_pose *pose)
{
    if (pose->changes.node != pose->ways.node) {
        enter_changing_cell(motion, pose, pose->ways.node);
    }
    const seld_vec3 *c = pose->changes.corners_m_q34;
    const int32_t *t = pose->fraction_q31;
    seld_vec3 change;
    for (int k = 0; k < 3; k++) {
        int32_t edge[4];
        for (int i = 0; i < 4; i++) {
            edge[i] = between(c[2 * i].v[k], c[2 * i + 1].v[k], t[0]);
        }
        change.v[k] = between(between(edge[0], edge[1], t[1]), between(edge[2], edge[3], t[1]), t[2]) * 32;
    }
    return change;
}

/* High words of a cross product. Format: Qa x Qb -> Q(a+b-32). Error: 1 LSB. */
static inline seld_vec3 cross_high(const seld_vec3 *a, const seld_vec3 *b)
{
    return seld_vec3_make(seld_mulh_sub(seld_mulh(a->v[1], b->v[2]), a->v[2], b->v[1]),
                          seld_mulh_sub(seld_mulh(a->v[2], b->v[0]), a->v[0], b->v[2]),
                          seld_mulh_sub(seld_mulh(a->v[0], b->v[1]), a->v[1], b->v[0]));
}

static inline int32_t dot_high(const seld_vec3 *a, const seld_vec3 *b)
{
    return seld_mulh_add(seld_mulh_add(seld_mulh(a->v[0], b->v[0]), a->v[1], b->v[1]), a->v[2], b->v[2]);
}

/* Cramer's rule for (I + J) step = -change, with a, b, c the columns: b x c and change x a hold all of its four determinants. Overflow: columns are
 * at most 2 in a component, so b x c is below 2^27 (Q24), the determinant below 2^26 (Q20), change x a below 2^29 (Q35); steps before the division
 * below 2^29 (Q31), 250 mm. */
seld_vec3 seld_motion_wall_step(const seld_motion *motion, seld_motion_pose *pose)
{
    if (!pose->is_inside) {
        return seld_vec3_make(0, 0, 0);
    }
    const int32_t(*m)[3] = (const int32_t(*)[3])pose->gradient_q28;
    const seld_vec3 a = seld_vec3_make(m[0][0], m[1][0], m[2][0]),
                    b = seld_vec3_make(m[0][1], m[1][1], m[2][1]),
                    c = seld_vec3_make(m[0][2], m[1][2], m[2][2]), change = change_here(motion, pose);
    const seld_vec3 across_q24 = cross_high(&b, &c), around_q35 = cross_high(&change, &a);
    const int32_t determinant_q20 = dot_high(&a, &across_q24);
    const uint32_t size =
        (uint32_t)(determinant_q20 > DETERMINANT_MIN_q20 ? determinant_q20 : DETERMINANT_MIN_q20);
    const seld_vec3 turned_q31 = {
        {dot_high(&change, &across_q24), -dot_high(&around_q35, &c), dot_high(&around_q35, &b)}};
    const unsigned lead = seld_clz32(size) - 1;
    const int64_t inverse = seld_reciprocal_q30(size << lead); /* 2^61 / (size 2^lead) */
    seld_vec3 step;
    for (int i = 0; i < 3; i++) {
        /* Q31 / Q20 -> Q33: 22 bits up */
        const int32_t way = seld_sat32(seld_rshift_round64(-turned_q31.v[i] * inverse, 39 - lead));
        step.v[i] = seld_clamp(way, -SELD_MOTION_WALL_STEP_MAX_M_Q33, SELD_MOTION_WALL_STEP_MAX_M_Q33);
    }
    return step;
}
