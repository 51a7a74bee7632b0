/* This file computes exact distances to the walls of tubes, and the distance fields built from them
 * (tube_lumen.h). */
#include "firmware/tests/reference/tube_lumen.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { EDGE = 8, SUPPORT = 12 /* 10 coefficients and one more sample on either side for the prefilter */ };
enum { STRETCH = 8 /* segments of the path that are looked at together */ };
#define SEGMENT_MAX_M 0.00101 /* the path has a point at every millimetre */
static const double voxel0_m = 1048576.0 / 1073741824.0;

/* --- path ----------------------------------------------------------------------------------------------- */

typedef struct frame {
    double x[3], t[3], n[3];
} frame;

static void turn(double *a, double *b, double angle_rad)
{
    for (int k = 0; k < 3; k++) {
        double p = a[k] * cos(angle_rad) + b[k] * sin(angle_rad);
        b[k] = b[k] * cos(angle_rad) - a[k] * sin(angle_rad);
        a[k] = p;
    }
}

static void cross(const double *a, const double *b, double *c)
{
    for (int k = 0; k < 3; k++) c[k] = a[(k + 1) % 3] * b[(k + 2) % 3] - a[(k + 2) % 3] * b[(k + 1) % 3];
}

static uint32_t add_piece(double (*points)[3], uint32_t count, frame *f, const reference_piece *piece)
{
    double side[3];
    cross(f->t, f->n, side);
    turn(f->n, side, piece->roll_rad);
    uint32_t steps = (uint32_t)(piece->length_m / 0.001) + 1;
    for (uint32_t s = 0; s < steps; s++) {
        double half = piece->angle_rad / steps / 2;
        turn(f->t, f->n, half);
        for (int k = 0; k < 3; k++) f->x[k] += f->t[k] * piece->length_m / steps;
        turn(f->t, f->n, half);
        memcpy(points[count++], f->x, sizeof f->x);
    }
    return count;
}

/* --- distance ------------------------------------------------------------------------------------------- */

static double segment_distance_squared(const double *p, const double *a, const double *b)
{
    double ab[3], ap[3], dot = 0, length2 = 0, square = 0;
    for (int k = 0; k < 3; k++) {
        ab[k] = b[k] - a[k];
        ap[k] = p[k] - a[k];
        dot += ab[k] * ap[k];
        length2 += ab[k] * ab[k];
    }
    double s = dot / length2;
    s = s < 0 ? 0 : (s > 1 ? 1 : s);
    for (int k = 0; k < 3; k++) square += (ap[k] - s * ab[k]) * (ap[k] - s * ab[k]);
    return square;
}

static double point_distance_squared(const double *p, const double *q)
{
    double square = 0;
    for (int k = 0; k < 3; k++) square += (p[k] - q[k]) * (p[k] - q[k]);
    return square;
}

/* Tests every eighth point of the path and returns the distance to the nearest one, which is an upper bound
 * of the distance to the path. The jump from the first branch to the second branch is not a segment of the
 * path. */
static double bound_m(const reference_tube *tube, const double *p, uint32_t from, uint32_t to)
{
    double best = 1e18;
    for (uint32_t i = from; i + 1 < to; i += STRETCH) {
        if (i + 1 == tube->branch) continue;
        double square = point_distance_squared(p, tube->points_m[i]);
        best = square < best ? square : best;
    }
    return sqrt(best) + 1e-12; /* so much for rounding */
}

/* Returns the distance to the part of the path between two of its points. The function skips every stretch of
 * the path, and every segment, whose first point is farther away than the bound plus the length of the
 * stretch or segment. */
static double nearest(const reference_tube *tube, const double *p, uint32_t from, uint32_t to)
{
    double best = 1e18; /* squared */
    double bound = bound_m(tube, p, from, to);
    double stretch_m = bound + SEGMENT_MAX_M * STRETCH, segment_m = bound + SEGMENT_MAX_M;
    for (uint32_t first = from; first + 1 < to; first += STRETCH) {
        uint32_t last = first + STRETCH < to - 1 ? first + STRETCH : to - 1;
        int holds_jump = tube->branch > first && tube->branch <= last;
        if (!holds_jump && point_distance_squared(p, tube->points_m[first]) > stretch_m * stretch_m) continue;
        for (uint32_t i = first; i < last; i++) {
            if (i + 1 == tube->branch) continue;
            if (point_distance_squared(p, tube->points_m[i]) > segment_m * segment_m) continue;
            double square = segment_distance_squared(p, tube->points_m[i], tube->points_m[i + 1]);
            best = square < best ? square : best;
        }
    }
    return sqrt(best);
}

/* Converts the distance to a tube's axis into the distance to its wall. For a tapered tube the result is
 * accurate to first order, by the cosine of the taper's slope. */
static double to_wall(const reference_tube *tube, const double *p, double axis_m)
{
    const double pi = 3.14159265358979, u = (p[0] - tube->throat_at_m) / tube->throat_length_m;
    if (tube->throat_length_m == 0 || fabs(u) > 0.5) return axis_m - tube->radius_m;
    double lost = 0.5 * (tube->radius_m - tube->throat_m);
    double slope = 2 * pi / tube->throat_length_m * lost * sin(2 * pi * u);
    return (axis_m - tube->radius_m + lost * (1 + cos(2 * pi * u))) / sqrt(1 + slope * slope);
}

double reference_tube_distance(const reference_tube *tube, const double *point_m)
{
    return to_wall(tube, point_m, nearest(tube, point_m, 0, tube->point_count));
}

/* --- field ---------------------------------------------------------------------------------------------- */

/* Finds the first and the last point of the tube's path that can lie within `reach_m` of a centre. */
static void window(const reference_tube *tube, const double *centre, double reach_m, uint32_t *from,
                   uint32_t *to)
{
    *from = tube->point_count;
    *to = 0;
    for (uint32_t i = 0; i < tube->point_count; i++) {
        double square = 0;
        for (int k = 0; k < 3; k++) square += pow(tube->points_m[i][k] - centre[k], 2);
        if (sqrt(square) < reach_m) {
            *from = i < *from ? i : *from;
            *to = i + 1;
        }
    }
    *from = *from > 2 ? *from - 2 : 0;
    *to = *to + 2 < tube->point_count ? *to + 2 : tube->point_count;
}

/* Computes the coefficients of one brick at `corner` from distances at 12^3 voxel centres. The function first
 * filters the distances by f - sum (second differences) / 8, the first-order inverse of the spline's [1 6 1]
 * / 8. */
static void fill_brick(const reference_tube *tube, const double *corner, double voxel_m, int8_t *brick)
{
    static double f[SUPPORT][SUPPORT][SUPPORT];
    double centre[3] = {corner[0] + 4 * voxel_m, corner[1] + 4 * voxel_m, corner[2] + 4 * voxel_m};
    uint32_t from, to;
    window(tube, centre, 12 * voxel_m + 2 * tube->radius_m, &from, &to);
    for (int z = 0; z < SUPPORT; z++) {
        for (int y = 0; y < SUPPORT; y++) {
            for (int x = 0; x < SUPPORT; x++) {
                double p[3] = {corner[0] + (x - 1.5) * voxel_m, corner[1] + (y - 1.5) * voxel_m,
                               corner[2] + (z - 1.5) * voxel_m};
                f[z][y][x] = to_wall(tube, p, nearest(tube, p, from, to)) / voxel_m;
            }
        }
    }
    for (int z = 1; z < SUPPORT - 1; z++) {
        for (int y = 1; y < SUPPORT - 1; y++) {
            for (int x = 1; x < SUPPORT - 1; x++) {
                double c = f[z][y][x] * 1.75 - (f[z][y][x - 1] + f[z][y][x + 1] + f[z][y - 1][x] +
                                                f[z][y + 1][x] + f[z - 1][y][x] + f[z + 1][y][x]) /
                                                   8;
                double q = round(c * 32);
                *brick++ = (int8_t)(q > 127 ? 127 : (q < -127 ? -127 : q));
            }
        }
    }
}

typedef struct builder {
    reference_tube *tube;
    int8_t *samples;
    uint16_t *children;
    uint32_t bricks, rows, level;
} builder;

/* Returns an array of `count` items with space for one more. The array doubles when it is full. */
static void *enlarged(void *array, uint32_t count, size_t item_bytes)
{
    if ((count & (count - 1)) != 0) return array;
    return realloc(array, (count == 0 ? 1 : 2 * (size_t)count) * item_bytes);
}

/* Makes the index entry for the cube at `corner` whose edge has 8 voxels. */
static uint16_t make_entry(builder *b, const double *corner, uint32_t level)
{
    double voxel = voxel0_m / (1u << level);
    double centre[3] = {corner[0] + 4 * voxel, corner[1] + 4 * voxel, corner[2] + 4 * voxel};
    double d = reference_tube_distance(b->tube, centre);
    double band = 4 * voxel * 1.7321 + 0.0025;
    if (d > band) return CRN_LUMEN_ENTRY_OUTSIDE;
    if (d < -band) return CRN_LUMEN_ENTRY_INSIDE;
    if (level == b->level) {
        b->samples = enlarged(b->samples, b->bricks, CRN_LUMEN_BRICK_SAMPLES);
        fill_brick(b->tube, corner, voxel, b->samples + (size_t)b->bricks * CRN_LUMEN_BRICK_SAMPLES);
        return (uint16_t)(CRN_LUMEN_ENTRY_FIRST_BRICK + b->bricks++);
    }
    b->children = enlarged(b->children, b->rows, 8 * sizeof *b->children);
    uint32_t row = b->rows++;
    for (uint32_t k = 0; k < 8; k++) {
        double c[3] = {corner[0] + (k & 1) * 4 * voxel, corner[1] + (k >> 1 & 1) * 4 * voxel,
                       corner[2] + (k >> 2) * 4 * voxel};
        uint16_t entry = make_entry(b, c, level + 1);
        b->children[row * 8 + k] = entry;
    }
    return (uint16_t)(CRN_LUMEN_ENTRY_REFINED | row);
}

static void build_field(reference_tube *tube, uint32_t level)
{
    double brick = EDGE * voxel0_m;
    crn_lumen *lumen = &tube->lumen;
    for (int k = 0; k < 3; k++) {
        double low = 1e9, high = -1e9;
        for (uint32_t i = 0; i < tube->point_count; i++) {
            low = fmin(low, tube->points_m[i][k]);
            high = fmax(high, tube->points_m[i][k]);
        }
        double origin = floor((low - tube->radius_m - 0.003) / brick) * brick;
        lumen->origin_m_q30[k] = (int32_t)lround(origin * 1073741824.0);
        lumen->brick_count_xyz[k] = (uint16_t)ceil((high + tube->radius_m + 0.003 - origin) / brick);
    }
    uint32_t nx = lumen->brick_count_xyz[0], ny = lumen->brick_count_xyz[1], nz = lumen->brick_count_xyz[2];
    uint16_t *index = malloc((size_t)nx * ny * nz * sizeof *index);
    builder b = {tube, NULL, NULL, 0, 0, level};
    for (uint32_t i = 0; i < nx * ny * nz; i++) {
        double corner[3] = {i % nx * brick, i / nx % ny * brick, i / nx / ny * brick};
        for (int k = 0; k < 3; k++) corner[k] += lumen->origin_m_q30[k] / 1073741824.0;
        index[i] = make_entry(&b, corner, 0);
    }
    lumen->index = index;
    lumen->children = b.children;
    lumen->samples = b.samples;
    lumen->child_row_count = (uint16_t)b.rows;
    lumen->brick_count = b.bricks;
}

static reference_tube *path_of(const reference_piece *pieces, uint32_t piece_count, double radius_m)
{
    reference_tube *tube = calloc(1, sizeof *tube);
    double total = 0.02; /* the piece behind the entry */
    for (uint32_t i = 0; i < piece_count; i++) total += pieces[i].length_m;
    tube->points_m = malloc((size_t)(total / 0.001 + 4 * piece_count + 16) * sizeof *tube->points_m);
    tube->radius_m = radius_m;
    frame f = {{-0.02, 0, 0}, {1, 0, 0}, {0, 0, 1}};
    memcpy(tube->points_m[tube->point_count++], f.x, sizeof f.x);
    const reference_piece lead = {0.02, 0, 0};
    tube->point_count = add_piece(tube->points_m, tube->point_count, &f, &lead);
    for (uint32_t i = 0; i < piece_count; i++) {
        tube->point_count = add_piece(tube->points_m, tube->point_count, &f, &pieces[i]);
    }
    return tube;
}

reference_tube *reference_tube_make(const reference_piece *pieces, uint32_t piece_count, double radius_m,
                                    uint32_t level)
{
    reference_tube *tube = path_of(pieces, piece_count, radius_m);
    build_field(tube, level);
    return tube;
}

reference_tube *reference_stenosis_make(double tube_m, double radius_m, double throat_m, double at_m,
                                        double length_m, uint32_t level)
{
    const reference_piece straight = {tube_m, 0, 0};
    reference_tube *tube = path_of(&straight, 1, radius_m);
    tube->throat_m = throat_m;
    tube->throat_at_m = at_m;
    tube->throat_length_m = length_m;
    build_field(tube, level);
    return tube;
}

reference_tube *reference_fork_make(const reference_piece *trunk, const reference_piece left[2],
                                    const reference_piece right[2], double radius_m, uint32_t level)
{
    reference_tube *tube = calloc(1, sizeof *tube);
    double total = trunk->length_m;
    for (int i = 0; i < 2; i++) total += left[i].length_m + right[i].length_m;
    tube->points_m = malloc((size_t)(total / 0.001 + 64) * sizeof *tube->points_m);
    tube->radius_m = radius_m;
    frame f = {{-0.02, 0, 0}, {1, 0, 0}, {0, 0, 1}};
    memcpy(tube->points_m[tube->point_count++], f.x, sizeof f.x);
    const reference_piece whole = {trunk->length_m + 0.02, trunk->angle_rad, trunk->roll_rad};
    uint32_t count = add_piece(tube->points_m, tube->point_count, &f, &whole);
    frame end = f;
    for (int i = 0; i < 2; i++) count = add_piece(tube->points_m, count, &f, &left[i]);
    tube->branch = count;
    memcpy(tube->points_m[count++], end.x, sizeof end.x);
    for (int i = 0; i < 2; i++) count = add_piece(tube->points_m, count, &end, &right[i]);
    tube->point_count = count;
    build_field(tube, level);
    return tube;
}

void reference_tube_free(reference_tube *tube)
{
    if (tube == NULL) return;
    free((void *)tube->lumen.index);
    free((void *)tube->lumen.children);
    free((void *)tube->lumen.samples);
    free(tube->points_m);
    free(tube);
}

/* --- scenes --------------------------------------------------------------------------------------------- */

crn_entry reference_entry(void)
{
    crn_entry entry = {{{0, 0, 0}}, {{CRN_ONE_Q30, 0, 0}}, 0};
    return entry;
}

crn_instrument reference_wire(double bend_N_m2, uint32_t length_um, uint32_t element_um, double friction)
{
    crn_instrument wire = {0};
    wire.knot_count = 2;
    for (uint32_t i = 0; i < 2; i++) {
        crn_knot *knot = &wire.knots[i];
        knot->arc_um = i * length_um;
        knot->bend_stiffness_nN_m2 = (uint32_t)lround(bend_N_m2 * 1e9);
        knot->twist_stiffness_nN_m2 = (uint32_t)lround(bend_N_m2 / 1.3 * 1e9);
        knot->mass_mg_per_m = 5000;
        knot->radius_outer_um = 445;
        knot->friction_kinetic_milli = knot->friction_static_milli = (uint32_t)lround(friction * 1000);
    }
    wire.axial_stiffness_max_N = 3000;
    wire.element_tip_um = wire.element_shaft_um = element_um;
    return wire;
}

crn_instrument reference_floppy_j(double bend_N_m2)
{
    crn_instrument wire = reference_wire(bend_N_m2, 900000, 3000, 0.2);
    wire.knot_count = 4;
    wire.knots[3] = wire.knots[2] = wire.knots[1];
    wire.knots[1] = wire.knots[0];
    wire.knots[1].arc_um = 12000;
    wire.knots[2].arc_um = 60000;
    for (int i = 0; i < 2; i++) {
        wire.knots[i].bend_stiffness_nN_m2 = wire.knots[i].twist_stiffness_nN_m2 = 10000;
        wire.knots[i].rest_curvature1_per_m_milli = 250000;
    }
    return wire;
}

reference_tube *reference_three_bends(double radius_m, uint32_t level)
{
    const double right = acos(0.0);
    const reference_piece pieces[] = {{0.15, 0, 0}, {0.08, right, 0},        {0.15, 0, 0}, {0.09, right, 1.2},
                                      {0.12, 0, 0}, {0.10, 1.2 * right, -2}, {0.25, 0, 0}};
    return reference_tube_make(pieces, sizeof pieces / sizeof pieces[0], radius_m, level);
}
