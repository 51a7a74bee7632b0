/* This file looks up the displacements of a moving vessel in its two lattices, one for the heartbeat and one
 * for breath (motion.h, docs/heart.md). Every look-up of a displacement takes the same amount of work. For
 * the heartbeat, a look-up blends three coefficients for each of three components at the 8 corners of a
 * lattice cell. The blending for the heartbeat runs once for the present displacement and once for the change
 * in the tick. For breath, a look-up reads the displacements at 8 corners. The blended displacements of a
 * lattice cell are kept for the next point in the same cell; keeping them does not change any result. The
 * file motion_wall.c computes the displacement of the wall in a tick. */
#include "firmware/core/motion_cell.h"
#include "firmware/core/rod.h"

/* Returns the three weights of the quadratic B-spline at the fraction f of the interval around a keyframe,
 * which reaches half-way to the keyframes before and after. The first weight of the quadratic B-spline is
 * (1-f)^2/2, the last is f^2/2, and the middle one is the remainder to one. */
crn_motion_moment crn_motion_moment_at(uint32_t heart_phase32, uint32_t breath_phase32)
{
    uint64_t place_q32 = (uint64_t)heart_phase32 * CRN_MOTION_KEYFRAMES + ((uint64_t)1 << 31);
    uint32_t first = (uint32_t)(place_q32 >> 32);
    int32_t f_q15 = (int32_t)((uint32_t)place_q32 >> (32 - FRACTION_BITS)), rest_q15 = 32768 - f_q15;
    int32_t low = (rest_q15 * rest_q15 + 32768) / 65536, high = (f_q15 * f_q15 + 32768) / 65536;
    return (crn_motion_moment){first == CRN_MOTION_KEYFRAMES ? 0 : first,
                               {low, 32768 - low - high, high},
                               crn_breath_depth_q15(breath_phase32)};
}

_Static_assert((int)CRN_NEAR_ROW == (int)CRN_MOTION_ROW &&
                   (int)CRN_NEAR_BRICK_BYTES == (int)CRN_LUMEN_BRICK_SAMPLES &&
                   (int)CRN_NEAR_ENTRY_OUTSIDE == (int)CRN_LUMEN_ENTRY_OUTSIDE &&
                   (int)CRN_NEAR_ENTRY_FIRST_BRICK == (int)CRN_LUMEN_ENTRY_FIRST_BRICK &&
                   (int)CRN_NEAR_WHOLE_MAX == (int)CRN_LESION_MAX + 1,
               "core and near memory agree about a scene");

/* The lattice of breath and the lesions' stations are copied as a whole, the lattice last. */
static crn_near_scene near_scene_of(const crn_lumen *lumen)
{
    const crn_motion *motion = lumen->motion;
    const uint32_t *n = lumen->brick_count_xyz;
    crn_near_scene scene = {.index = lumen->index,
                            .columns = n[0],
                            .lines = n[1] * n[2],
                            .children = lumen->children,
                            .child_count = lumen->child_row_count * 8u,
                            .samples = lumen->samples,
                            .brick_count = lumen->brick_count,
                            .rows = motion == NULL ? NULL : motion->rows,
                            .whole_count = lumen->lesion_count};
    for (uint32_t i = 0; i < lumen->lesion_count; i++) {
        const crn_lesion *lesion = &lumen->lesions[i];
        scene.whole[i] =
            (crn_near_whole){lesion->stations, lesion->station_count * (uint32_t)sizeof *lesion->stations};
    }
    if (motion != NULL && motion->inhaled != NULL) {
        const uint32_t *nodes = motion->breath.count_xyz;
        scene.whole[scene.whole_count++] =
            (crn_near_whole){motion->inhaled, nodes[0] * nodes[1] * nodes[2] * BREATH_NODE *
                                                  (uint32_t)sizeof *motion->inhaled};
    }
    return scene;
}

uint32_t crn_lumen_near_bytes(const crn_lumen *lumen)
{
    const crn_near_scene scene = near_scene_of(lumen);
    return crn_near_bytes_min(&scene);
}

void crn_lumen_near_begin(crn_lumen *lumen, crn_motion *motion, crn_lesion *lesions, void *memory,
                          uint32_t bytes)
{
    const crn_near_scene scene = near_scene_of(lumen);
    lumen->near = crn_near_begin(memory, bytes, &scene);
    for (uint32_t i = 0; i < lumen->lesion_count; i++) {
        lesions[i].stations = lumen->near->whole[i];
    }
    if (lumen->motion != NULL) {
        motion->near = lumen->near;
        motion->inhaled = motion->inhaled == NULL ? NULL : lumen->near->whole[lumen->lesion_count];
    }
}

static void field_begin(const crn_lattice *lattice, crn_motion_field *field)
{
    const uint32_t row = lattice->count_xyz[0], slice = row * lattice->count_xyz[1];
    for (uint32_t corner = 0; corner < 8; corner++) {
        field->corner_nodes[corner] = (corner & 1u) + (corner >> 1 & 1u) * row + (corner >> 2) * slice;
    }
    field->ways.node = (uint32_t)NO_CELL;
    field->tetrahedron = NO_TETRAHEDRON;
    field->is_inside = false;
}

static int64_t end_of(const crn_lattice *lattice, int k)
{
    return lattice->origin_m_q30[k] + ((int64_t)(lattice->count_xyz[k] - 1) << lattice->spacing_log2_q30);
}

static void box_about(const crn_motion *motion, crn_motion_pose *pose)
{
    for (int k = 0; k < 3; k++) {
        int32_t low = motion->beat.origin_m_q30[k];
        int64_t high = end_of(&motion->beat, k);
        if (motion->inhaled != NULL) {
            const int64_t end = end_of(&motion->breath, k);
            low = motion->breath.origin_m_q30[k] < low ? motion->breath.origin_m_q30[k] : low;
            high = end > high ? end : high;
        }
        const int64_t size = high - low;
        pose->low_m_q30[k] = low;
        pose->size_m_q30[k] = size > UINT32_MAX ? UINT32_MAX : (uint32_t)size;
    }
}

void crn_motion_pose_begin(const crn_motion *motion, crn_motion_pose *pose, const crn_rhythm *before,
                           const crn_rhythm *now)
{
    field_begin(&motion->beat, &pose->beat);
    field_begin(&motion->breath, &pose->breath);
    pose->changes.node = (uint32_t)NO_CELL;
    box_about(motion, pose);
    pose->now = crn_motion_moment_at(now->heart_phase32, now->breath_phase32);
    pose->before = crn_motion_moment_at(before->heart_phase32, before->breath_phase32);
}

/* Blends the displacements at the corners of a lattice cell for the present phase of the heartbeat. */
static void enter_cell(const crn_motion *motion, crn_motion_pose *pose, uint32_t node)
{
    const corner_list fresh = move_on(&motion->beat, node, &pose->beat.ways);
    const crn_motion_moment now = pose->now;
    for (uint32_t i = 0; i < fresh.count; i++) {
        const uint32_t corner = fresh.corners[i];
        const node_rows rows = rows_of(motion, node + pose->beat.corner_nodes[corner]);
        const int16_t *taps = rows.numbers + now.first * rows.step;
        int32_t *way = pose->beat.ways.corners_m_q34[corner].v;
        for (int k = 0; k < 3; k++, taps += rows.apart) {
            way[k] = blend(taps, rows.step, &now);
        }
    }
    make_terms(&pose->beat);
}

/* Products of fractions. Format: Q31. Error: 1 LSB (floor). */
static inline int32_t product(int32_t a_q31, int32_t b_q31)
{
    return crn_high64((int64_t)a_q31 * b_q31) * 2;
}

/* Finds the lattice cell that contains a point, and the point's position in this cell. As in lumen.c, a
 * coordinate difference modulo 2^32 is the true difference for points inside the lattice. */
typedef enum found { OUTSIDE, SAME_CELL, OTHER_CELL } found;

static inline void place_in_cell(crn_motion_field *field, uint32_t log2, uint32_t x, uint32_t y, uint32_t z)
{
    const uint32_t up = 31 - log2; /* moves the fraction's bits to the top of 31 */
    field->powers_q31[1] = (int32_t)(x << up);
    field->powers_q31[2] = (int32_t)(y << up);
    field->powers_q31[4] = (int32_t)(z << up);
    field->is_inside = true;
}

static inline found find_other(const crn_lattice *lattice, crn_motion_field *field, const crn_vec3 *p,
                               uint32_t *node)
{
    const uint32_t log2 = lattice->spacing_log2_q30, mask = ((uint32_t)1 << log2) - 1;
    const uint32_t x = (uint32_t)p->v[0] - (uint32_t)lattice->origin_m_q30[0],
                   y = (uint32_t)p->v[1] - (uint32_t)lattice->origin_m_q30[1],
                   z = (uint32_t)p->v[2] - (uint32_t)lattice->origin_m_q30[2];
    const uint32_t column = x >> log2, row = y >> log2, slice = z >> log2;
    if (column >= lattice->count_xyz[0] - 1 || row >= lattice->count_xyz[1] - 1 ||
        slice >= lattice->count_xyz[2] - 1) {
        field->is_inside = false;
        return OUTSIDE;
    }
    field->low_m_q30[0] = (int32_t)((uint32_t)p->v[0] - (x & mask));
    field->low_m_q30[1] = (int32_t)((uint32_t)p->v[1] - (y & mask));
    field->low_m_q30[2] = (int32_t)((uint32_t)p->v[2] - (z & mask));
    place_in_cell(field, log2, x & mask, y & mask, z & mask);
    *node = (slice * lattice->count_xyz[1] + row) * lattice->count_xyz[0] + column;
    return OTHER_CELL;
}

static inline found find(const crn_lattice *lattice, crn_motion_field *field, const crn_vec3 *p,
                         uint32_t *node)
{
    const uint32_t log2 = lattice->spacing_log2_q30;
    const uint32_t x = (uint32_t)p->v[0] - (uint32_t)field->low_m_q30[0],
                   y = (uint32_t)p->v[1] - (uint32_t)field->low_m_q30[1],
                   z = (uint32_t)p->v[2] - (uint32_t)field->low_m_q30[2];
    if ((x | y | z) >> log2 == 0 && field->ways.node != (uint32_t)NO_CELL) {
        place_in_cell(field, log2, x, y, z);
        return SAME_CELL;
    }
    return find_other(lattice, field, p, node);
}

/* Finds the tetrahedron of a lattice cell that contains the point. A path along edges of the lattice cell
 * defines the tetrahedron; the path starts at the corner of the cell with the smallest coordinates. The path
 * leads first along the axis on which the point's coordinate within the cell is largest, then along the axis
 * with the next largest coordinate. */
static inline uint32_t tetrahedron_at(const int32_t *p_q31)
{
    return (p_q31[1] >= p_q31[2] ? 4u : 0u) | (p_q31[2] >= p_q31[4] ? 2u : 0u) |
           (p_q31[1] >= p_q31[4] ? 1u : 0u);
}

/* Returns the position that the point would have with the chest at the end of expiration. */
static inline crn_vec3 exhale(const crn_motion *motion, crn_motion_pose *pose, const crn_vec3 *world_m_q30)
{
    crn_motion_field *field = &pose->breath;
    uint32_t node;
    const found cell = find(&motion->breath, field, world_m_q30, &node);
    if (cell == OUTSIDE) {
        return *world_m_q30;
    }
    if (cell == OTHER_CELL) {
        enter_breathing_cell(motion, field, node);
    }
    const uint32_t tetrahedron = tetrahedron_at(field->powers_q31);
    if (cell == OTHER_CELL || tetrahedron != field->tetrahedron) {
        field->tetrahedron = tetrahedron;
        field->shrink_q30 = 0;
        make_plane(field, tetrahedron);
    }
    const int32_t depth_q15 = pose->now.breath_q15;
    crn_vec3 rest;
    for (int k = 0; k < 3; k++) {
        const int32_t inhaled_m_q34 = plane_here(field->terms_m_q34[k], field->powers_q31);
        pose->inhaled_m_q34.v[k] = inhaled_m_q34;
        /* Q34 x Q15 -> Q30 */
        const int32_t way =
            (int32_t)crn_rshift_round64(crn_product(inhaled_m_q34, depth_q15), FRACTION_BITS + 4);
        rest.v[k] = crn_add_sat(world_m_q30->v[k], way);
    }
    return rest;
}

/* Returns whether the point is outside both lattices (heartbeat and breath). As in find(), coordinate
 * differences are modulo 2^32. */
static inline bool stands_still(crn_motion_pose *pose, const crn_vec3 *p)
{
    const bool is_beyond = (uint32_t)p->v[0] - (uint32_t)pose->low_m_q30[0] >= pose->size_m_q30[0] ||
                           (uint32_t)p->v[1] - (uint32_t)pose->low_m_q30[1] >= pose->size_m_q30[1] ||
                           (uint32_t)p->v[2] - (uint32_t)pose->low_m_q30[2] >= pose->size_m_q30[2];
    if (is_beyond) {
        pose->beat.is_inside = pose->breath.is_inside = false;
    }
    return is_beyond;
}

static crn_vec3 pull_inside(const crn_motion *motion, crn_motion_pose *pose, const crn_vec3 *world_m_q30)
{
    const crn_vec3 rest_m_q30 = motion->inhaled == NULL ? *world_m_q30 : exhale(motion, pose, world_m_q30);
    crn_motion_field *field = &pose->beat;
    uint32_t node;
    const found cell = find(&motion->beat, field, &rest_m_q30, &node);
    pose->has_gradient = false;
    if (cell == OUTSIDE) {
        return rest_m_q30;
    }
    if (cell == OTHER_CELL) {
        enter_cell(motion, pose, node);
    }
    int32_t *p_q31 = field->powers_q31;
    p_q31[3] = product(p_q31[1], p_q31[2]);
    p_q31[5] = product(p_q31[1], p_q31[4]);
    p_q31[6] = product(p_q31[2], p_q31[4]);
    p_q31[7] = product(p_q31[3], p_q31[4]);
    crn_vec3 reference;
    for (int k = 0; k < 3; k++) {
        const int32_t way_m_q34 = value_here(field->terms_m_q34[k], p_q31);
        reference.v[k] = crn_add_sat(rest_m_q30.v[k], crn_asr32(way_m_q34 + 8, 4));
    }
    return reference;
}

crn_vec3 crn_motion_pull(const crn_motion *motion, crn_motion_pose *pose, const crn_vec3 *world_m_q30)
{
    return stands_still(pose, world_m_q30) ? *world_m_q30 : pull_inside(motion, pose, world_m_q30);
}

/* Every lattice node has `row` values for each of its three components. For each of the `row` values of a
 * node, the function computes the largest squared difference between neighbouring nodes along one axis, and
 * adds it to `squares`. Format: coefficients. Overflow is impossible: the displacements of neighbouring nodes
 * differ by at most 2^13 (checked when a scene is loaded). One axis adds at most 3 x 2^26 to each sum of
 * squares, and three axes add less than 2^30. */
static void add_longest(const crn_lattice *lattice, const int16_t *numbers, uint32_t row, uint32_t axis,
                        uint32_t *squares)
{
    const uint32_t *n = lattice->count_xyz;
    const uint32_t steps[3] = {1, n[0], n[0] * n[1]}, nodes = n[0] * n[1] * n[2];
    uint32_t longest[CRN_MOTION_ROW] = {0};
    for (uint32_t node = 0; node + steps[axis] < nodes; node++) {
        /* past the end of a line lies the boundary of the next line, which is 0 like the end: no
         * difference */
        const int16_t *here = numbers + (size_t)node * 3 * row, *next = here + (size_t)steps[axis] * 3 * row;
        for (uint32_t i = 0; i < row; i++) {
            uint32_t square = 0;
            for (uint32_t k = 0; k < 3; k++) {
                const int32_t apart = next[k * row + i] - here[k * row + i];
                square += (uint32_t)(apart * apart);
            }
            longest[i] = square > longest[i] ? square : longest[i];
        }
    }
    for (uint32_t i = 0; i < row; i++) {
        squares[i] += longest[i];
    }
}

/* Computes an upper bound of the steepness |J| of one lattice, for each value in a row of coefficients.
 * Format: Q28. Overflow: 5/8 sqrt(3). */
static void steepness_of(const crn_lattice *lattice, const int16_t *numbers, uint32_t row,
                         int32_t *steepness_q28)
{
    enum { MORE = 10 }; /* bits of the root */
    uint32_t squares[CRN_MOTION_ROW] = {0};
    for (uint32_t axis = 0; axis < 3; axis++) {
        add_longest(lattice, numbers, row, axis, squares);
    }
    const uint32_t spacing_log2 = lattice->spacing_log2_q30 - CRN_MOTION_UNIT_LOG2_Q30;
    for (uint32_t i = 0; i < row; i++) {
        const uint64_t root = crn_sqrt64((uint64_t)squares[i] << 2 * MORE) + 1;
        steepness_q28[i] = (int32_t)(root << (28 - MORE - spacing_log2)) + 1;
    }
}

void crn_motion_steepness_make(const crn_motion *motion, crn_motion_steepness *steepness)
{
    steepness->breath_q28 = 0;
    steepness_of(&motion->beat, motion->rows, CRN_MOTION_ROW, steepness->beat_q28);
    if (motion->inhaled != NULL) {
        steepness_of(&motion->breath, motion->inhaled, 1, &steepness->breath_q28);
    }
}

int32_t crn_motion_shrink_q30(const crn_motion_steepness *steepness, const crn_motion_moment *now)
{
    const int32_t one = 1 << 28, *taps_q28 = steepness->beat_q28 + now->first;
    int64_t sum_q43 = 0;
    for (int i = 0; i < 3; i++) {
        sum_q43 += (int64_t)taps_q28[i] * now->weights_q15[i];
    }
    const int32_t beat_q28 = (int32_t)crn_asr64(sum_q43, FRACTION_BITS) + 1,
                  breath_q28 = breathed(steepness->breath_q28, now->breath_q15) + 1;
    return crn_scale_q30(crn_quotient(one, one + beat_q28, 30), crn_quotient(one, one + breath_q28, 30));
}

/* Returns the derivative of a displacement component along one axis. The derivative is the sum of four terms:
 * the linear term of this axis, the two mixed terms of this axis with one other axis, and the mixed term of
 * all three axes. Overflow: as value_here's. */
static inline int32_t slope_here(int32_t axis, int32_t with_b, int32_t b_q31, int32_t with_c, int32_t c_q31,
                                 int32_t with_both, int32_t both_q31)
{
    return axis + from_q31((int64_t)with_b * b_q31 + (int64_t)with_c * c_q31 + (int64_t)with_both * both_q31);
}

/* Computes the gradient I + dw_i/dx_j of the map in the lattice cell of the point that was looked up last;
 * outside the lattice the gradient is the identity. Format: Q34 m per spacing -> Q28. Overflow is impossible,
 * because entries of the gradient are at most 1 5/8 (checked when a scene is loaded). */
static void gradient_here(const crn_motion *motion, crn_motion_pose *pose)
{
    const int32_t *p = pose->beat.powers_q31;
    /* Q34 m / (2^log2 Q30 m) = 2^(-4 - log2), in Q28 */
    const int32_t up = (int32_t)1 << (24 - motion->beat.spacing_log2_q30);
    pose->has_gradient = true;
    for (int k = 0; k < 3; k++) {
        const int32_t *t = pose->beat.terms_m_q34[k];
        int32_t *row = pose->gradient_q28[k];
        row[0] = row[1] = row[2] = 0;
        if (pose->beat.is_inside) {
            row[0] = slope_here(t[1], t[3], p[2], t[5], p[4], t[7], p[6]) * up;
            row[1] = slope_here(t[2], t[3], p[1], t[6], p[4], t[7], p[5]) * up;
            row[2] = slope_here(t[4], t[5], p[1], t[6], p[2], t[7], p[3]) * up;
        }
        row[k] += 1 << 28;
    }
}

static inline int32_t size_of(int32_t a)
{
    return a < 0 ? -a : a;
}

/* Returns an upper bound of the norm of a matrix. The square of a matrix's norm is at most the largest column
 * sum of magnitudes times the largest row sum of magnitudes. */
static inline int32_t norm_at_most(const int32_t m[3][3])
{
    int32_t most = 0;
    for (int i = 0; i < 3; i++) {
        const int j = i == 2 ? 0 : i + 1, k = i == 0 ? 2 : i - 1;
        const int32_t middle = size_of(m[i][i]), row = size_of(m[i][j]) + size_of(m[i][k]),
                      column = size_of(m[j][i]) + size_of(m[k][i]),
                      sum = middle + (row > column ? row : column);
        most = sum > most ? sum : most;
    }
    return most;
}

/* Returns a lower bound of 1 / |I + J|, at most 1. Format: Q28 -> Q30. Overflow is impossible: matrix norms
 * are at most 1 + 3 x 5/8 (checked when a scene is loaded), about 2.9, and Q28 holds
 * values below 8. */
static inline int32_t shrink_of_gradient(const int32_t gradient_q28[3][3])
{
    const int32_t one = 1 << 28, norm = norm_at_most(gradient_q28);
    return norm > one ? crn_quotient(one, norm, 30) : 1 << 30;
}

/* Returns the factor 1 / (1 + |J|) for breath; the factor is computed once for all points of a tetrahedron.
 * Format: Q30. */
static int32_t shrink_of_breath(const crn_motion *motion, crn_motion_pose *pose)
{
    crn_motion_field *field = &pose->breath;
    if (field->shrink_q30 == 0) {
        const int32_t up = (int32_t)1 << (24 - motion->breath.spacing_log2_q30), one = 1 << 28;
        int32_t slopes_q28[3][3];
        for (int k = 0; k < 3; k++) {
            for (int j = 0; j < 3; j++) {
                slopes_q28[k][j] = field->terms_m_q34[k][1 << j] * up;
            }
        }
        const int32_t most = norm_at_most((const int32_t(*)[3])slopes_q28);
        field->shrink_q30 = crn_quotient(one, one + breathed(most, pose->now.breath_q15) + 1, 30);
    }
    return field->shrink_q30;
}

/* Returns a lower bound of 1 / |I + J| at the point that was looked up last, where J is the gradient of the
 * displacement: the product of a factor for the heartbeat and a factor for breath. Format: Q30. */
static int32_t shrink_here(const crn_motion *motion, crn_motion_pose *pose)
{
    const int32_t beat_q30 = shrink_of_gradient((const int32_t(*)[3])pose->gradient_q28);
    return pose->breath.is_inside ? crn_scale_q30(beat_q30, shrink_of_breath(motion, pose)) : beat_q30;
}

enum {
    ROUNDING_M_Q30 = 32
}; /* bounds the quotients here and in crn_motion_contact, for distances up to 15.6 mm */

/* Computes the distance to the wall for a point that lies within a lattice. The distance within a lattice is
 * computed in a separate function, so that a node outside both lattices takes no additional time. */
CRN_APART static int32_t distance_inside(const crn_lumen *lumen, const crn_motion *motion,
                                         crn_motion_pose *pose, const crn_vec3 *world_m_q30,
                                         int32_t shrink_q30, int32_t far_m_q30)
{
    pose->reference_m_q30 = pull_inside(motion, pose, world_m_q30);
    const int32_t reference = crn_lumen_distance(lumen, &pose->reference_m_q30);
    if (reference >= 0 || !moves_here(pose)) {
        return reference;
    }
    const int32_t distance = crn_scale_q30(reference, shrink_q30) + ROUNDING_M_Q30;
    if (distance < far_m_q30) {
        return distance;
    }
    gradient_here(motion, pose);
    return crn_scale_q30(reference, shrink_here(motion, pose)) + ROUNDING_M_Q30;
}

int32_t crn_motion_distance(const crn_lumen *lumen, const crn_motion *motion, crn_motion_pose *pose,
                            const crn_vec3 *world_m_q30, int32_t shrink_q30, int32_t far_m_q30)
{
    if (stands_still(pose, world_m_q30)) {
        pose->reference_m_q30 = *world_m_q30;
        return crn_lumen_distance(lumen, world_m_q30);
    }
    return distance_inside(lumen, motion, pose, world_m_q30, shrink_q30, far_m_q30);
}

/* Returns the mapped normal (I + dw/dx)^T n for a unit normal n, where w is the displacement by the
 * heartbeat. Format: Q30 -> Q26. Overflow is impossible: a component of the result is at most 1 + 5/8
 * sqrt(3), and the number format holds values below 8. Error: 2 LSB. */
static inline crn_vec3 mapped_normal(const crn_motion_pose *pose, const crn_vec3 *normal_q30)
{
    const int32_t(*m)[3] = (const int32_t(*)[3])pose->gradient_q28;
    const int32_t *n = normal_q30->v;
    crn_vec3 mapped;
    for (int j = 0; j < 3; j++) {
        mapped.v[j] = crn_mulh_add(crn_mulh_add(crn_mulh(m[0][j], n[0]), m[1][j], n[1]), m[2][j], n[2]);
    }
    return mapped;
}

/* Multiplies the mapped normal by (I + depth db/dx)^T, where b is the displacement by breath. Overflow is
 * impossible: the components of the normal grow by a factor of at most 1 + 3/8 sqrt(3), and stay below 8, the
 * limit of the number format. */
static inline void map_by_breath(const crn_motion *motion, const crn_motion_pose *pose, crn_vec3 *mapped_q26)
{
    const crn_vec3 beaten_q26 = *mapped_q26;
    const crn_vec3 breathing_q26 = {{breathed(beaten_q26.v[0], pose->now.breath_q15),
                                     breathed(beaten_q26.v[1], pose->now.breath_q15),
                                     breathed(beaten_q26.v[2], pose->now.breath_q15)}};
    for (int j = 0; j < 3; j++) {
        const crn_vec3 slope_q30 = breath_slope(motion, pose, j);
        mapped_q26->v[j] += dot_high(&slope_q30, &breathing_q26) * 4;
    }
}

crn_lumen_sample crn_motion_carry(const crn_motion *motion, crn_motion_pose *pose, crn_lumen_sample sample)
{
    const crn_vec3 none = {{0, 0, 0}};
    if (!moves_here(pose) ||
        (sample.normal_q30.v[0] | sample.normal_q30.v[1] | sample.normal_q30.v[2]) == 0) {
        return sample;
    }
    if (!pose->has_gradient) {
        gradient_here(motion, pose);
    }
    int32_t length_q26;
    crn_vec3 mapped_q26 = mapped_normal(pose, &sample.normal_q30);
    if (pose->breath.is_inside) {
        map_by_breath(motion, pose, &mapped_q26);
    }
    sample.normal_q30 = crn_vec3_normalise(mapped_q26, none, &length_q26);
    if (length_q26 > 0) {
        sample.distance_m_q30 = crn_quotient(sample.distance_m_q30, length_q26, 26);
    }
    return sample;
}

crn_lumen_sample crn_motion_contact_here(const crn_lumen *lumen, const crn_motion *motion,
                                         crn_motion_pose *pose)
{
    return crn_motion_carry(motion, pose, crn_lumen_contact(lumen, &pose->reference_m_q30));
}

CRN_APART static crn_lumen_sample contact_inside(const crn_lumen *lumen, const crn_motion *motion,
                                                 crn_motion_pose *pose, const crn_vec3 *world_m_q30)
{
    pose->reference_m_q30 = pull_inside(motion, pose, world_m_q30);
    return crn_motion_contact_here(lumen, motion, pose);
}

crn_lumen_sample crn_motion_contact(const crn_lumen *lumen, const crn_motion *motion, crn_motion_pose *pose,
                                    const crn_vec3 *world_m_q30)
{
    if (stands_still(pose, world_m_q30)) {
        pose->reference_m_q30 = *world_m_q30;
        return crn_lumen_contact(lumen, world_m_q30);
    }
    return contact_inside(lumen, motion, pose, world_m_q30);
}
