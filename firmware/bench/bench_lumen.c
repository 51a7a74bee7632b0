/* With callgrind, this benchmark counts the instructions of one look-up in the lumen, for the cheap distance
 * function and for the contact function. The sampled points lie near the wall of a straight tube of 8 mm
 * radius (level 0) and of a refined tube (level 1). Samples near the wall take the most expensive paths
 * through the code. */
#include "firmware/bench/bench.h"
#include "firmware/core/lumen.h"

enum { CALLS = 1000, POINTS = 64 };

/* The first lumen is one coarse brick whose wall is the plane x = 4 voxels; the second lumen is the same
 * brick refined. */
static int8_t samples[2 * CRN_LUMEN_BRICK_SAMPLES];
static const uint16_t index_entries[2] = {2, 0x8000};
static const uint16_t children[8] = {3, 3, 3, 3, 3, 3, 3, 3};
static const crn_lumen lumen = {{0, 0, 0}, {2, 1, 1}, 1, 2,    index_entries, children,
                                samples,   NULL,      0, NULL, NULL,          NULL};
static crn_vec3 points[POINTS];
static volatile int32_t sink;

/* Fills a brick with the coefficients of a slightly bent wall, and makes points that are spread over the
 * brick of `level`. */
static void fill(int level)
{
    for (int i = 0; i < 2 * CRN_LUMEN_BRICK_SAMPLES; i++) {
        int x = i % 10 - 5, y = i / 10 % 10 - 5, z = i / 100 % 10 - 5;
        samples[i] = (int8_t)(12 * x + 3 * y - 2 * z + (y * y + z * z) / 8);
    }
    for (int i = 0; i < POINTS; i++) {
        int32_t step = i * 131071;
        points[i] =
            crn_vec3_make((level << 23) + step % (1 << 23), step * 3 % (1 << 23), step * 7 % (1 << 23));
    }
}

static double run_cull(const bench_case *self)
{
    fill(self->argument);
    for (int i = 0; i < CALLS; i++) sink = crn_lumen_distance(&lumen, &points[i % POINTS]);
    return 0;
}

static double run_contact(const bench_case *self)
{
    fill(self->argument);
    for (int i = 0; i < CALLS; i++) sink = crn_lumen_contact(&lumen, &points[i % POINTS]).distance_m_q30;
    return 0;
}

static const bench_case cases[] = {
    {"lumen.sample_instructions", "instructions", "kind=cull level=0", "crn_lumen_distance", CALLS, run_cull,
     0},
    {"lumen.sample_instructions", "instructions", "kind=cull level=1", "crn_lumen_distance", CALLS, run_cull,
     1},
    {"lumen.sample_instructions", "instructions", "kind=contact level=0", "crn_lumen_contact", CALLS,
     run_contact, 0},
    {"lumen.sample_instructions", "instructions", "kind=contact level=1", "crn_lumen_contact", CALLS,
     run_contact, 1},
};

int main(int argc, char **argv)
{
    return bench_main(argc, argv, cases, sizeof(cases) / sizeof(cases[0]));
}
