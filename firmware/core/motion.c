/* Looking up the lattice of a moving vessel (motion.h, docs/heart.md). Fixed work: 8 corners of one cell, of three components, of
 * three coefficients and one of breath; the blend of a cell is kept for the next point in it, which changes no result.
 * May include: motion.h, rod.h (quotient). Called by: rod_contact.c, core_state.c. */
#include "firmware/core/motion.h"
#include "firmware/core/rod.h"

enum {
    NO_CELL = -1,
    FRACTION_BITS = 15,
    DETERMINANT_MIN_q28 =
        1 << 25, /* 1/8: a lattice that folds over is none, but must not divide by nothing */
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

void seld_motion_pose_begin(seld_motion_pose *pose, const seld_rhythm *before, const seld_rhythm *now)
{
    pose->now = seld_motion_moment_at(now->heart_phase32, now->breath_phase32);
    pose->before = seld_motion_moment_at(before->heart_phase32, before->breath_phase32);
    pose->cell = pose->cell_before = (uint32_t)NO_CELL;
}

/* Corners of the cell that are also corners of the one looked at last, one step along an axis away: they move to their new places. Bit c of
 * the result: corner c is there. */
static uint32_t keep_shared(const seld_motion *motion, uint32_t from, uint32_t to,
                            int32_t corners_m_q34[8][3])
{
    const uint32_t steps[3] = {1, motion->count_xyz[0], motion->count_xyz[0] * motion->count_xyz[1]};
    for (uint32_t axis = 0; from != (uint32_t)NO_CELL && axis < 3; axis++) {
        const bool forward = to - from == steps[axis];
        if (!forward && from - to != steps[axis]) {
            continue;
        }
        uint32_t kept = 0;
        for (uint32_t corner = 0; corner < 8; corner++) {
            if ((corner >> axis & 1u) == (forward ? 1u : 0u)) {
                const uint32_t place = corner ^ (1u << axis);
                for (int k = 0; k < 3; k++) {
                    corners_m_q34[place][k] = corners_m_q34[corner][k];
                }
                kept |= 1u << place;
            }
        }
        return kept;
    }
    return 0;
}

/* Corners of a cell at a moment, but for those that are there already. Format: Q15 x 2^-19 m -> Q34 m. Overflow: |coefficient| <= 2^14 (checked), weights of the heart sum
 * to 2^15 and breath has at most as much: 2^30. */
static void blend(const seld_motion *motion, const seld_motion_moment *moment, uint32_t node, uint32_t kept,
                  int32_t corners_m_q34[8][3])
{
    enum { NODE = 3 * SELD_MOTION_ROW };
    const size_t row = motion->count_xyz[0], slice = row * motion->count_xyz[1];
    const int16_t *at = motion->rows + (size_t)node * NODE;
    const int32_t a = moment->weights_q15[0], b = moment->weights_q15[1], c = moment->weights_q15[2];
    const int32_t depth = moment->breath_q15;
    for (uint32_t corner = 0; corner < 8; corner++) {
        if ((kept >> corner & 1u) != 0) {
            continue;
        }
        const int16_t *of = at + ((corner & 1u) + (corner >> 1 & 1u) * row + (corner >> 2) * slice) * NODE;
        for (int k = 0; k < 3; k++, of += SELD_MOTION_ROW) {
            const int16_t *taps = of + moment->first;
            corners_m_q34[corner][k] =
                taps[0] * a + taps[1] * b + taps[2] * c + of[SELD_MOTION_ROW_BREATH] * depth;
        }
    }
}

/* Point between two corners. Overflow: they differ by at most a spacing (checked): 2^28. Error: 2 LSB. */
static inline int32_t between(int32_t a, int32_t b, int32_t t_q31)
{
    return a + seld_mulh(b - a, t_q31) * 2;
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
    pose->is_inside = find(motion, pose, world_m_q30, &cell);
    if (!pose->is_inside) {
        return *world_m_q30;
    }
    if (cell != pose->cell) {
        blend(motion, &pose->now, cell, keep_shared(motion, pose->cell, cell, pose->corners_m_q34),
              pose->corners_m_q34);
        pose->cell = cell;
    }
    const int32_t(*c)[3] = (const int32_t(*)[3])pose->corners_m_q34;
    const int32_t *t = pose->fraction_q31;
    seld_vec3 reference;
    for (int k = 0; k < 3; k++) {
        int32_t low = between(between(c[0][k], c[1][k], t[0]), between(c[2][k], c[3][k], t[0]), t[1]);
        int32_t high = between(between(c[4][k], c[5][k], t[0]), between(c[6][k], c[7][k], t[0]), t[1]);
        int32_t way_m_q34 = between(low, high, t[2]);
        reference.v[k] = seld_add_sat(world_m_q30->v[k], seld_asr32(way_m_q34 + 8, 4));
    }
    return reference;
}

int32_t seld_motion_distance(const seld_lumen *lumen, const seld_motion *motion, seld_motion_pose *pose,
                             const seld_vec3 *world_m_q30)
{
    seld_vec3 reference = seld_motion_pull(motion, pose, world_m_q30);
    int32_t distance = seld_lumen_distance(lumen, &reference);
    return distance < 0 && pose->is_inside ? distance - seld_asr32(distance, 3) : distance;
}

/* dw_i/dx_j in the cell of the last point. Format: Q34 m per spacing -> Q28. Overflow: at most 1 (checked). */
static void gradient_here(const seld_motion *motion, seld_motion_pose *pose)
{
    const int32_t(*c)[3] = (const int32_t(*)[3])pose->corners_m_q34;
    const int32_t *t = pose->fraction_q31;
    /* Q34 m / (2^log2 Q30 m) = 2^(-4 - log2), in Q28 */
    const uint32_t up = 24 - motion->spacing_log2_q30;
    for (int k = 0; k < 3; k++) {
        int32_t along_x = between(between(c[1][k] - c[0][k], c[3][k] - c[2][k], t[1]),
                                  between(c[5][k] - c[4][k], c[7][k] - c[6][k], t[1]), t[2]);
        int32_t a00 = between(c[0][k], c[1][k], t[0]), a10 = between(c[2][k], c[3][k], t[0]);
        int32_t a01 = between(c[4][k], c[5][k], t[0]), a11 = between(c[6][k], c[7][k], t[0]);
        int32_t along_y = between(a10 - a00, a11 - a01, t[2]);
        int32_t along_z = between(a01 - a00, a11 - a10, t[1]);
        pose->gradient_q28[k][0] = along_x * ((int32_t)1 << up);
        pose->gradient_q28[k][1] = along_y * ((int32_t)1 << up);
        pose->gradient_q28[k][2] = along_z * ((int32_t)1 << up);
    }
}

/* -(I + J)^T n of a unit normal n (already inward). Format: Q30 -> Q28. Overflow: at most 1 + sqrt(3) in a component, below 8. */
static seld_vec3 mapped_normal(const seld_motion_pose *pose, const seld_vec3 *normal_q30)
{
    seld_vec3 mapped;
    for (int j = 0; j < 3; j++) {
        int64_t sum = 0;
        for (int i = 0; i < 3; i++) {
            sum = seld_product_add(sum, pose->gradient_q28[i][j], normal_q30->v[i]);
        }
        mapped.v[j] = seld_asr32(normal_q30->v[j], 2) + (int32_t)seld_rshift_round64(sum, 30);
    }
    return mapped;
}

seld_lumen_sample seld_motion_contact(const seld_lumen *lumen, const seld_motion *motion,
                                      seld_motion_pose *pose, const seld_vec3 *world_m_q30)
{
    const seld_vec3 none = {{0, 0, 0}};
    seld_vec3 reference = seld_motion_pull(motion, pose, world_m_q30);
    seld_lumen_sample sample = seld_lumen_contact(lumen, &reference);
    if (!pose->is_inside || (sample.normal_q30.v[0] | sample.normal_q30.v[1] | sample.normal_q30.v[2]) == 0) {
        return sample;
    }
    gradient_here(motion, pose);
    int32_t length_q28;
    sample.normal_q30 = seld_vec3_normalise(mapped_normal(pose, &sample.normal_q30), none, &length_q28);
    if (length_q28 > 0) {
        sample.distance_m_q30 = seld_quotient(sample.distance_m_q30, length_q28, 28);
    }
    return sample;
}

/* --- how the wall moves ------------------------------------------------------------------------------------------ */

/* Change of w in this tick at the last point, negative: what the wall would do if w did not depend on the place. Q34 -> Q33 m, limited so
 * that what is made of it fits. */
static seld_vec3 minus_change(const seld_motion *motion, seld_motion_pose *pose)
{
    if (pose->cell_before != pose->cell) {
        blend(motion, &pose->before, pose->cell,
              keep_shared(motion, pose->cell_before, pose->cell, pose->corners_before_m_q34),
              pose->corners_before_m_q34);
        pose->cell_before = pose->cell;
    }
    const int32_t(*c)[3] = (const int32_t(*)[3])pose->corners_m_q34;
    const int32_t(*o)[3] = (const int32_t(*)[3])pose->corners_before_m_q34;
    const int32_t *t = pose->fraction_q31;
    seld_vec3 step;
    for (int k = 0; k < 3; k++) {
        int32_t change[8];
        for (int corner = 0; corner < 8; corner++) {
            change[corner] =
                seld_clamp(seld_sub_sat(o[corner][k], c[corner][k]), -2 * SELD_MOTION_WALL_STEP_MAX_M_Q33,
                           2 * SELD_MOTION_WALL_STEP_MAX_M_Q33);
        }
        int32_t low = between(between(change[0], change[1], t[0]), between(change[2], change[3], t[0]), t[1]);
        int32_t high =
            between(between(change[4], change[5], t[0]), between(change[6], change[7], t[0]), t[1]);
        step.v[k] = seld_asr32(between(low, high, t[2]), 1);
    }
    return step;
}

static inline int32_t minor_q28(int32_t a, int32_t d, int32_t b, int32_t c)
{
    return seld_sat32(seld_rshift_round64((int64_t)a * d - (int64_t)b * c, 28));
}

/* Adjugate of I + J and its determinant. Format: Q28. Overflow: entries of I + J are at most 2, their minors 5, the
 * determinant saturates. */
static int32_t adjugate(const seld_motion_pose *pose, int32_t adj_q28[3][3])
{
    int32_t m[3][3];
    for (int i = 0; i < 3; i++) {
        for (int j = 0; j < 3; j++) {
            m[i][j] = pose->gradient_q28[i][j] + (i == j ? 1 << 28 : 0);
        }
    }
    for (int i = 0; i < 3; i++) {
        for (int j = 0; j < 3; j++) {
            int p = (j + 1) % 3, q = (j + 2) % 3, r = (i + 1) % 3, s = (i + 2) % 3;
            adj_q28[i][j] = minor_q28(m[p][r], m[q][s], m[p][s], m[q][r]);
        }
    }
    int64_t determinant = 0;
    for (int k = 0; k < 3; k++) {
        determinant = seld_product_add(determinant, m[0][k], adj_q28[k][0]);
    }
    return seld_sat32(seld_rshift_round64(determinant, 28));
}

seld_vec3 seld_motion_wall_step(const seld_motion *motion, seld_motion_pose *pose)
{
    seld_vec3 step = {{0, 0, 0}};
    if (!pose->is_inside) {
        return step;
    }
    int32_t adj_q28[3][3];
    const seld_vec3 change = minus_change(motion, pose);
    int32_t determinant_q28 = adjugate(pose, adj_q28);
    determinant_q28 = determinant_q28 > DETERMINANT_MIN_q28 ? determinant_q28 : DETERMINANT_MIN_q28;
    for (int i = 0; i < 3; i++) {
        int64_t sum = 0;
        for (int j = 0; j < 3; j++) {
            sum = seld_product_add(sum, adj_q28[i][j], change.v[j]);
        }
        int32_t way = seld_quotient(seld_sat32(seld_rshift_round64(sum, 28)), determinant_q28, 28);
        step.v[i] = seld_clamp(way, -SELD_MOTION_WALL_STEP_MAX_M_Q33, SELD_MOTION_WALL_STEP_MAX_M_Q33);
    }
    return step;
}
