/* This file makes moving vessels whose motion is known in closed form; see moving_tube.h. */
#include "firmware/tests/reference/moving_tube.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static const double q30_per_m = 1073741824.0;
static const double unit_m = 2048.0 / 1073741824.0; /* of a coefficient */

const reference_piece reference_coronary[3] = {{0.08, 0, 0}, {0.07, 1.75, 0}, {0.02, 0, 0}};
const double reference_coronary_low_m[3] = {-0.008, -0.04, -0.024};
const double reference_coronary_high_m[3] = {0.15, 0.04, 0.11};

double reference_contraction(double phase)
{
    const double end = 10.0 / 24.0, turn = 2 * acos(-1.0);
    phase -= floor(phase);
    const double share = phase < end ? phase / end / 2 : 0.5 + (phase - end) / (1 - end) / 2;
    return (1 - cos(turn * share)) / 2;
}

/* Computes a point's distance from the sphere's middle, and the fraction of the sphere's motion that remains
 * at this distance. */
static double faded(const double *place, double *r)
{
    static const double middle[3] = {0.09, 0.005, 0.045}, reach = 0.09;
    double square = 0;
    for (int k = 0; k < 3; k++) {
        r[k] = place[k] - middle[k];
        square += r[k] * r[k];
    }
    const double s = sqrt(square) / reach;
    return s >= 1 ? 0 : (1 - s * s) * (1 - s * s);
}

void reference_beating_sphere(const double *X, double phase, double breath, double *x)
{
    const double in = 0.012, down = 0.006, turn = 12.0 / 180.0 * acos(-1.0), deep = 0.008;
    const double c = reference_contraction(phase);
    double r[3];
    const double fade = faded(X, r);
    const double angle = turn * c * fade, shrink = 1 - in / 0.04 * c * fade;
    x[0] = X[0] - r[0] + shrink * (cos(angle) * r[0] + sin(angle) * r[2]);
    x[1] = X[1] - r[1] + shrink * r[1] - down * c * fade;
    x[2] = X[2] - r[2] + shrink * (cos(angle) * r[2] - sin(angle) * r[0]);
    x[1] -= deep * breath * faded(x, r);
}

/* The iteration X <- X - (map(X) - x) converges to the fixed point, because the displacements of two
 * neighbouring points differ by less than the distance between these points. */
void reference_pull(reference_map map, const double *x, double phase, double breath, double *X)
{
    memcpy(X, x, 3 * sizeof *X);
    for (int i = 0; i < 200; i++) {
        double at[3], worst = 0;
        map(X, phase, breath, at);
        for (int k = 0; k < 3; k++) {
            X[k] -= at[k] - x[k];
            worst = fmax(worst, fabs(at[k] - x[k]));
        }
        if (worst < 1e-12) return;
    }
}

/* Finds the periodic coefficients c of a spline through the values w, (c[i-1] + 6 c[i] + c[i+1]) / 8 = w[i],
 * by Gauss-Seidel iteration, whose error falls by a factor of 9 in each round. */
static void prefilter(const double *w, double *c)
{
    enum { N = CRN_MOTION_KEYFRAMES };
    memcpy(c, w, N * sizeof *c);
    for (int round = 0; round < 20; round++) {
        for (int i = 0; i < N; i++) c[i] = (8 * w[i] - c[(i + N - 1) % N] - c[(i + 1) % N]) / 6;
    }
}

static int16_t coefficient(double way_m)
{
    const double value = round(way_m / unit_m);
    return (int16_t)fmax(-CRN_MOTION_COEFFICIENT_MAX, fmin(CRN_MOTION_COEFFICIENT_MAX, value));
}

/* Computes the three rows of coefficients of a lattice node, one row for each axis, and the node's
 * displacement in a full breath. */
static void fill_node(const reference_motion *m, const double *x, int16_t *rows, int16_t *inhaled)
{
    double w[3][CRN_MOTION_KEYFRAMES], X[3], deep[3], c[CRN_MOTION_KEYFRAMES];
    for (int i = 0; i < CRN_MOTION_KEYFRAMES; i++) {
        reference_pull(m->map, x, i / (double)CRN_MOTION_KEYFRAMES, 0, X);
        for (int k = 0; k < 3; k++) w[k][i] = X[k] - x[k];
    }
    reference_pull(m->map, x, 0, 1, deep);
    for (int k = 0; k < 3; k++, rows += CRN_MOTION_ROW) {
        prefilter(w[k], c);
        for (int i = 0; i < CRN_MOTION_KEYFRAMES + 2; i++)
            rows[i] = coefficient(c[(i + CRN_MOTION_KEYFRAMES - 1) % CRN_MOTION_KEYFRAMES]);
        inhaled[k] = coefficient(deep[k] - x[k]);
    }
}

/* Makes a lattice over a box, with displacements of zero; the caller then writes the displacements. */
static reference_motion *lattice_over(const double *low_m, const double *high_m, uint32_t spacing_log2_q30)
{
    reference_motion *m = calloc(1, sizeof *m);
    const double spacing = (double)(1 << spacing_log2_q30) / q30_per_m;
    size_t nodes = 1;
    crn_lattice *lattice = &m->motion.beat;
    lattice->spacing_log2_q30 = spacing_log2_q30;
    for (int k = 0; k < 3; k++) {
        lattice->origin_m_q30[k] = (int32_t)lround(low_m[k] * q30_per_m);
        lattice->count_xyz[k] = (uint32_t)ceil((high_m[k] - low_m[k]) / spacing) + 1;
        nodes *= lattice->count_xyz[k];
    }
    m->motion.breath = *lattice;
    m->motion.rows = calloc(nodes * 3 * CRN_MOTION_ROW, sizeof *m->motion.rows);
    m->motion.inhaled = calloc(nodes * 3, sizeof *m->motion.inhaled);
    return m;
}

reference_motion *reference_motion_make(reference_map map, const double *low_m, const double *high_m,
                                        uint32_t spacing_log2_q30)
{
    reference_motion *m = lattice_over(low_m, high_m, spacing_log2_q30);
    const double spacing = (double)(1 << spacing_log2_q30) / q30_per_m;
    m->map = map;
    int16_t *rows = (int16_t *)(uintptr_t)m->motion.rows;
    int16_t *inhaled = (int16_t *)(uintptr_t)m->motion.inhaled;
    const uint32_t *n = m->motion.beat.count_xyz, nx = n[0], ny = n[1], nz = n[2];
    for (uint32_t i = 0; i < nx * ny * nz; i++) {
        const uint32_t at[3] = {i % nx, i / nx % ny, i / nx / ny};
        double x[3];
        for (int k = 0; k < 3; k++) x[k] = m->motion.beat.origin_m_q30[k] / q30_per_m + at[k] * spacing;
        const bool is_edge =
            at[0] == 0 || at[1] == 0 || at[2] == 0 || at[0] + 1 == nx || at[1] + 1 == ny || at[2] + 1 == nz;
        if (!is_edge) fill_node(m, x, rows + (size_t)i * 3 * CRN_MOTION_ROW, inhaled + (size_t)i * 3);
    }
    return m;
}

void reference_motion_free(reference_motion *motion)
{
    if (motion == NULL) return;
    free((void *)(uintptr_t)motion->motion.rows);
    free((void *)(uintptr_t)motion->motion.inhaled);
    free(motion);
}

/* Returns the number of nodes between a given node and the nearer end of an axis with `count` nodes; returns
 * `most` if the number is larger. */
static uint32_t steps_inside(uint32_t at, uint32_t count, uint32_t most)
{
    const uint32_t from_edge = at < count - 1 - at ? at : count - 1 - at;
    return from_edge < most ? from_edge : most;
}

/* Breathing moves the vessel by 3.2 mm along x. The lattice nodes of breathing are twice as far apart as
 * those of the heartbeat, and the motion fades to 0 over the four outermost nodes. */
static void make_breath(reference_motion *m)
{
    enum { FADE = 4 };
    crn_lattice *breath = &m->motion.breath;
    breath->spacing_log2_q30++;
    for (int k = 0; k < 3; k++) breath->count_xyz[k] = breath->count_xyz[k] / 2 + 1;
    const uint32_t *n = breath->count_xyz;
    int16_t *inhaled = (int16_t *)(uintptr_t)m->motion.inhaled;
    for (uint32_t i = 0; i < n[0] * n[1] * n[2]; i++) {
        const uint32_t at[3] = {i % n[0], i / n[0] % n[1], i / n[0] / n[1]};
        uint32_t inside = FADE;
        for (int k = 0; k < 3; k++) {
            inside = steps_inside(at[k], n[k], inside);
        }
        inhaled[3 * i] = coefficient(-0.0032 * inside / FADE);
    }
}

/* The displacement is the product of the heart's contraction (a function of time) and a function of the
 * position. Because the displacement is a product of a function of time and a function of the position, the
 * filter in time is computed only once and not for every node. */
reference_motion *reference_waves_make(const double *low_m, const double *high_m, uint32_t spacing_log2_q30)
{
    enum { FADE = 4 };
    reference_motion *m = lattice_over(low_m, high_m, spacing_log2_q30);
    const uint32_t *n = m->motion.beat.count_xyz, nodes = n[0] * n[1] * n[2];
    const double spacing = (double)(1 << spacing_log2_q30) / q30_per_m, wave = 2 * acos(-1.0) / 0.25;
    double beat[CRN_MOTION_KEYFRAMES], c[CRN_MOTION_KEYFRAMES];
    for (int i = 0; i < CRN_MOTION_KEYFRAMES; i++)
        beat[i] = -0.005 * reference_contraction(i / (double)CRN_MOTION_KEYFRAMES);
    prefilter(beat, c);
    int16_t *row = (int16_t *)(uintptr_t)m->motion.rows;
    for (uint32_t i = 0; i < nodes; i++) {
        const uint32_t at[3] = {i % n[0], i / n[0] % n[1], i / n[0] / n[1]};
        double x[3];
        uint32_t inside = FADE;
        for (int k = 0; k < 3; k++) {
            x[k] = m->motion.beat.origin_m_q30[k] / q30_per_m + at[k] * spacing;
            inside = steps_inside(at[k], n[k], inside);
        }
        for (int k = 0; k < 3; k++, row += CRN_MOTION_ROW) {
            const double part = (double)inside / FADE * sin(wave * x[(k + 1) % 3] + k);
            for (int j = 0; j < CRN_MOTION_KEYFRAMES + 2; j++)
                row[j] = coefficient(part * c[(j + CRN_MOTION_KEYFRAMES - 1) % CRN_MOTION_KEYFRAMES]);
        }
    }
    make_breath(m);
    return m;
}

crn_instrument reference_coronary_wire(void)
{
    crn_instrument wire = reference_wire(3e-5, 400000, 2000, 0.1);
    wire.element_tip_um = 1000;
    wire.element_fine_um = 40000;
    wire.knot_count = 3;
    wire.knots[2] = wire.knots[1];
    wire.knots[1].arc_um = 60000;
    wire.knots[0].bend_stiffness_nN_m2 = wire.knots[0].twist_stiffness_nN_m2 = 2000;
    for (int i = 0; i < 3; i++) {
        wire.knots[i].radius_outer_um = 178;
        wire.knots[i].mass_mg_per_m = 800;
    }
    return wire;
}
