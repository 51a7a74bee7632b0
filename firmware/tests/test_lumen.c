/* These tests check that the functions that sample the lumen compute the quadratic B-spline of lumen.h at
 * every level of refinement. The samples are continuous across bricks, and every position is safe to sample.
 * The tests compare the results with computations in double precision and with walls whose distance is known
 * in closed form. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>

#include <cmocka.h>

#include "firmware/core/lumen.h"
#include "firmware/tests/reference/random.h"

enum { BRICKS = 32, RANDOM_POINTS = 200000, VOXEL_Q30 = 1 << 20, BRICK_Q30 = 1 << 23 };

/* Makes a lattice of 3 x 2 x 2 coarse bricks; the tests write its refinements. */
static int8_t samples[BRICKS][10][10][10];
static uint16_t entries[12];
static uint16_t children[4 * 8];
static const crn_lumen lumen = {{-BRICK_Q30, 5 * VOXEL_Q30, -3},
                                {3, 2, 2},
                                4,
                                BRICKS,
                                entries,
                                children,
                                &samples[0][0][0][0],
                                NULL,
                                0,
                                NULL,
                                NULL,
                                NULL};

static double voxel_m(int level)
{
    return ldexp(1.0, -10 - level);
}

/* --- double-precision reference --- */
static double weight(double t) /* quadratic B-spline, support +-3/2 */
{
    double a = fabs(t);
    if (a <= 0.5) return 0.75 - a * a;
    return a < 1.5 ? 0.5 * (1.5 - a) * (1.5 - a) : 0.0;
}

static double weight_slope(double t)
{
    double a = fabs(t);
    if (a <= 0.5) return -2 * t;
    return a < 1.5 ? (t > 0 ? -(1.5 - a) : 1.5 - a) : 0.0;
}

/* Computes the value (in m) and the gradient of a brick's spline at the position x, in voxels from the
 * brick's corner. */
static double reference_spline(int brick, int level, const double *x, double *gradient)
{
    double value = 0;
    for (int k = 0; k < 3; k++) gradient[k] = 0;
    for (int i = 0; i < 1000; i++) {
        int at[3] = {i % 10, i / 10 % 10, i / 100};
        double c = samples[brick][at[2]][at[1]][at[0]] / 32.0, w[3], s[3];
        for (int k = 0; k < 3; k++) {
            w[k] = weight(x[k] - (at[k] - 0.5));
            s[k] = weight_slope(x[k] - (at[k] - 0.5));
        }
        value += c * w[0] * w[1] * w[2];
        gradient[0] += c * s[0] * w[1] * w[2];
        gradient[1] += c * w[0] * s[1] * w[2];
        gradient[2] += c * w[0] * w[1] * s[2];
    }
    return value * voxel_m(level);
}

/* --- scenes --- */
static void random_bricks(reference_random *random)
{
    for (int i = 0; i < BRICKS * 1000; i++) {
        (&samples[0][0][0][0])[i] = (int8_t)((int)reference_random_below(random, 255) - 127);
    }
}

/* In the lattice of these tests, coarse brick (1,1,0) has level 0. Coarse brick (2,1,0) has level 1, and
 * level 2 in its octant 5. Coarse brick (0,0,0) is deep inside the lumen. */
static void mixed_levels(void)
{
    for (int i = 0; i < 12; i++) entries[i] = CRN_LUMEN_ENTRY_OUTSIDE;
    entries[0] = CRN_LUMEN_ENTRY_INSIDE;
    entries[4] = 2;
    entries[5] = 0x8000;
    for (int i = 0; i < 8; i++) {
        children[i] = (uint16_t)(3 + i);
        children[24 + i] = (uint16_t)(11 + i);
    }
    children[5] = 0x8000 | 3;
}

typedef struct where {
    int brick, level;
    double x[3];
    crn_vec3 position;
} where;

/* Returns a random point in a brick of the given level of the scene that the test makes. */
static where random_point(reference_random *random, int level)
{
    where w = {0, level, {0, 0, 0}, {{0, 0, 0}}};
    uint32_t octant = level == 1 ? reference_random_below(random, 8) : 5;
    uint32_t fine = reference_random_below(random, 8);
    if (level == 1 && octant == 5) octant = 4;
    w.brick = level == 0 ? 0 : level == 1 ? (int)(1 + octant) : (int)(9 + fine);
    int32_t corner[3] = {level == 0 ? BRICK_Q30 : 2 * BRICK_Q30, BRICK_Q30, 0};
    for (int k = 0; k < 3; k++) {
        if (level > 0) corner[k] += (int32_t)(octant >> k & 1) * (BRICK_Q30 >> 1);
        if (level > 1) corner[k] += (int32_t)(fine >> k & 1) * (BRICK_Q30 >> 2);
        int32_t in_brick = (int32_t)reference_random_below(random, (unsigned)BRICK_Q30 >> level);
        w.position.v[k] = lumen.origin_m_q30[k] + corner[k] + in_brick;
        w.x[k] = ldexp(in_brick, level - 20);
    }
    return w;
}

/* --- tests --- */
static void contact_is_the_quadratic_b_spline(void **state)
{
    (void)state;
    reference_random random = reference_random_seed(41);
    mixed_levels();
    double worst_m = 0, worst_normal = 0;
    for (int i = 0; i < RANDOM_POINTS / 20; i++) {
        if (i % 500 == 0) random_bricks(&random);
        where w = random_point(&random, i % 3);
        double g[3], expected = reference_spline(w.brick, w.level, w.x, g);
        crn_lumen_sample got = crn_lumen_contact(&lumen, &w.position);
        worst_m = fmax(worst_m, fabs(ldexp(got.distance_m_q30, -30) - expected));
        double length = sqrt(g[0] * g[0] + g[1] * g[1] + g[2] * g[2]);
        for (int k = 0; length > 0.05 && k < 3; k++) {
            worst_normal = fmax(worst_normal, fabs(ldexp(got.normal_q30.v[k], -30) + g[k] / length));
        }
    }
    /* The weights of the spline along x have a resolution of 2^-16. The test uses random neighbouring values
     * that differ by up to 8 voxels, whereas neighbours at a wall differ by one voxel. */
    if (worst_m > 2e-7) fail_msg("worst distance error %.3g m, allowed 2e-7", worst_m);
    if (worst_normal > 2e-3) fail_msg("worst normal error %.3g, allowed 2e-3", worst_normal);
}

/* The cheap distance function decides that some points are too far from the wall for contact; the full
 * contact function must find no contact at such a point. The cheap distance function must also be safe in
 * vessels as narrow as a voxel, at creases of the wall, and in fields whose values are not distances. */
static void distance_is_that_of_contact_bit_for_bit(void **state)
{
    (void)state;
    reference_random random = reference_random_seed(42);
    mixed_levels();
    for (int i = 0; i < RANDOM_POINTS; i++) {
        if (i % 5000 == 0) random_bricks(&random);
        const where w = random_point(&random, i % 3);
        assert_int_equal(crn_lumen_distance(&lumen, &w.position),
                         crn_lumen_contact(&lumen, &w.position).distance_m_q30);
    }
}

/* A remembered voxel saves the sum only where every coefficient of the voxel shows that the point is far. The
 * result is then between the true distance and `far`; everywhere else it is the true distance. */
static void remembered_voxel_never_hides_a_point_that_is_near(void **state)
{
    (void)state;
    reference_random random = reference_random_seed(43);
    mixed_levels();
    crn_lumen_voxel last = {0};
    int saved = 0, near = 0;
    for (int i = 0; i < RANDOM_POINTS / 4; i++) {
        if (i % 5000 == 0) {
            random_bricks(&random);
            last.number_and_depth = 0;
            for (int k = 0; k < BRICKS * 1000; k++) { /* half of the fields are deep inside the lumen */
                int8_t *sample = &samples[0][0][0][0] + k;
                if (i % 10000 == 0) *sample = (int8_t)(*sample / 4 - 96);
            }
        }
        where w = random_point(&random, i % 3);
        const int32_t far = (int32_t)reference_random_below(&random, 8 * VOXEL_Q30) - 6 * VOXEL_Q30;
        for (int step = 0; step < 4; step++) { /* the point crosses at most a few voxels */
            const int32_t got = crn_lumen_distance_unless_far(&lumen, &w.position, far, &last);
            const int32_t distance = crn_lumen_distance(&lumen, &w.position);
            assert_true(got == distance || (distance <= got && got < far));
            saved += got != distance;
            near += distance >= far;
            w.position.v[step % 3] += 1 << 17;
        }
    }
    assert_true(saved > RANDOM_POINTS / 20 && near > RANDOM_POINTS / 20); /* both kinds of points occur */
}

/* Fills every level-0 brick with values of a function of the position, in voxels from the lattice corner. The
 * function first computes the spline's coefficients c = f - (second differences) / 8 from the values f, which
 * is exact for quadratic functions. */
typedef double (*field)(double x, double y, double z);
static void fill(field f)
{
    for (int b = 0; b < 12; b++) entries[b] = (uint16_t)(2 + b);
    for (int i = 0; i < 12 * 1000; i++) {
        int b = i / 1000;
        double x = i % 10 - 0.5 + 8 * (b % 3), y = i / 10 % 10 - 0.5 + 8 * (b / 3 % 2);
        double z = i / 100 % 10 - 0.5 + 8 * (b / 6);
        double sum = f(x + 1, y, z) + f(x - 1, y, z) + f(x, y + 1, z) + f(x, y - 1, z) + f(x, y, z + 1) +
                     f(x, y, z - 1);
        double c = rint(32 * (f(x, y, z) - (sum - 6 * f(x, y, z)) / 8));
        samples[b][i / 100 % 10][i / 10 % 10][i % 10] = (int8_t)fmin(127, fmax(-127, c));
    }
}

static double plane(double x, double y, double z)
{
    return 0.75 * (x - 12) + 0.5 * (y - 8) - 0.25 * (z - 8);
}

static double tube(double x, double y, double z)
{
    (void)x;
    return sqrt((y - 8.3) * (y - 8.3) + (z - 7.9) * (z - 7.9)) - 3;
}

static double sphere(double x, double y, double z)
{
    return sqrt((x - 11.6) * (x - 11.6) + (y - 8.3) * (y - 8.3) + (z - 7.9) * (z - 7.9)) - 3;
}

static crn_vec3 at_voxels(double x, double y, double z)
{
    return crn_vec3_make((int32_t)(lumen.origin_m_q30[0] + ldexp(x, 20)),
                         (int32_t)(lumen.origin_m_q30[1] + ldexp(y, 20)),
                         (int32_t)(lumen.origin_m_q30[2] + ldexp(z, 20)));
}

static double uniform(reference_random *random, double from, double to)
{
    return from + (to - from) * ldexp((double)(reference_random_next(random) >> 11), -53);
}

/* Returns the largest |contact distance - wall distance| in voxels, over points within 1.5 voxels of the
 * wall. */
static double worst_distance(field f, reference_random *random)
{
    double worst = 0;
    for (int i = 0; i < RANDOM_POINTS; i++) {
        double x = uniform(random, 0, 24), y = uniform(random, 0, 16), z = uniform(random, 0, 16);
        if (fabs(f(x, y, z)) > 1.5) continue;
        crn_vec3 p = at_voxels(x, y, z);
        double got = ldexp(crn_lumen_contact(&lumen, &p).distance_m_q30, -20);
        worst = fmax(worst, fabs(got - f(x, y, z)));
    }
    return worst;
}

static void known_walls_are_met_within_the_rounding_of_the_samples(void **state)
{
    (void)state;
    reference_random random = reference_random_seed(43);
    const struct {
        field f;
        double allowed; /* voxels: 1/64 rounding, and for bent walls the spline's own error */
    } walls[] = {{plane, 0.0157}, {tube, 0.025}, {sphere, 0.04}};
    for (int i = 0; i < 3; i++) {
        fill(walls[i].f);
        double worst = worst_distance(walls[i].f, &random);
        if (worst > walls[i].allowed)
            fail_msg("wall %d: worst %.4f voxels, allowed %.4f", i, worst, walls[i].allowed);
    }
}

/* On every border between bricks, the test takes two points 1 LSB apart, one on each side. Between two points
 * 1 LSB apart, value and normal may differ only by what a step of 1 nm and the rounding of the weights
 * explain. */
static void field_is_smooth_across_bricks_and_voxels(void **state)
{
    (void)state;
    reference_random random = reference_random_seed(45);
    fill(tube);
    for (int n = 0; n < RANDOM_POINTS; n++) {
        int axis = n % 3;
        crn_vec3 p = at_voxels(uniform(&random, 0, 24), uniform(&random, 4, 12), uniform(&random, 4, 12));
        p.v[axis] =
            lumen.origin_m_q30[axis] + (int32_t)reference_random_below(&random, axis ? 16 : 24) * VOXEL_Q30;
        crn_vec3 q = p;
        q.v[axis] -= 1;
        if (q.v[axis] < lumen.origin_m_q30[axis]) continue;
        if (labs(crn_lumen_contact(&lumen, &p).distance_m_q30) > 3 * VOXEL_Q30 / 2)
            continue; /* away from the axis */
        crn_lumen_sample a = crn_lumen_contact(&lumen, &p), b = crn_lumen_contact(&lumen, &q);
        assert_in_range(a.distance_m_q30 - b.distance_m_q30 + 64, 0, 128); /* 60 nm */
        for (int k = 0; k < 3; k++) {
            assert_in_range(a.normal_q30.v[k] - b.normal_q30.v[k] + (1 << 16), 0, 1 << 17); /* 6e-5 */
        }
    }
}

static void normals_have_unit_length_and_point_inward(void **state)
{
    (void)state;
    reference_random random = reference_random_seed(46);
    fill(tube);
    for (int n = 0; n < RANDOM_POINTS; n++) {
        double x = uniform(&random, 0, 24), y = uniform(&random, 0, 16), z = uniform(&random, 0, 16);
        if (fabs(tube(x, y, z)) > 1.5) continue;
        crn_vec3 p = at_voxels(x, y, z);
        crn_lumen_sample s = crn_lumen_contact(&lumen, &p);
        double nx = ldexp(s.normal_q30.v[0], -30), ny = ldexp(s.normal_q30.v[1], -30),
               nz = ldexp(s.normal_q30.v[2], -30);
        assert_true(fabs(sqrt(nx * nx + ny * ny + nz * nz) - 1) < 1e-8);
        double radius = tube(x, y, z) + 3;
        double along = -(ny * (y - 8.3) + nz * (z - 7.9)) / radius;
        if (along < cos(0.06))
            fail_msg("normal off by %.4f rad, allowed 0.06", acos(along)); /* int8: 1.6 deg were seen */
    }
}

static void far_places_say_far_and_have_no_normal(void **state)
{
    (void)state;
    mixed_levels();
    const int32_t ends[] = {INT32_MIN, INT32_MIN + 1, -BRICK_Q30 - 1, 3 * BRICK_Q30, INT32_MAX};
    for (int i = 0; i < 125; i++) {
        crn_vec3 p = crn_vec3_make(ends[i % 5], ends[i / 5 % 5], ends[i / 25]);
        assert_int_equal(crn_lumen_distance(&lumen, &p), 1 << 24);
        assert_int_equal(crn_lumen_contact(&lumen, &p).distance_m_q30, 1 << 24);
    }
    crn_vec3 inside = at_voxels(1, 2, 3);
    assert_int_equal(crn_lumen_distance(&lumen, &inside), -(1 << 24));
    crn_lumen_sample s = crn_lumen_contact(&lumen, &inside);
    assert_int_equal(s.distance_m_q30, -(1 << 24));
    assert_int_equal(s.normal_q30.v[0] | s.normal_q30.v[1] | s.normal_q30.v[2], 0);
}

static void saturated_field_has_no_normal(void **state)
{
    (void)state;
    mixed_levels();
    for (int i = 0; i < BRICKS * 1000; i++) (&samples[0][0][0][0])[i] = 127;
    crn_vec3 p = at_voxels(12.3, 12.1, 4.7);
    crn_lumen_sample s = crn_lumen_contact(&lumen, &p);
    assert_int_equal(s.normal_q30.v[0] | s.normal_q30.v[1] | s.normal_q30.v[2], 0);
    assert_int_equal(s.distance_m_q30, 127 << 15);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(contact_is_the_quadratic_b_spline),
        cmocka_unit_test(distance_is_that_of_contact_bit_for_bit),
        cmocka_unit_test(remembered_voxel_never_hides_a_point_that_is_near),
        cmocka_unit_test(known_walls_are_met_within_the_rounding_of_the_samples),
        cmocka_unit_test(field_is_smooth_across_bricks_and_voxels),
        cmocka_unit_test(normals_have_unit_length_and_point_inward),
        cmocka_unit_test(far_places_say_far_and_have_no_normal),
        cmocka_unit_test(saturated_field_has_no_normal),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
