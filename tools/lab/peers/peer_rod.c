/* Simulates, in our core, the rod that tools/lab/peers/run_peers.py compares with other simulators
 * (docs/bench.md, "Peers"). The rod has a length of 0.5 m, 256 elements, a Young's modulus of 60 GPa and a
 * diameter of 0.89 mm. Under gravity the rod is held horizontally at one end; it is either free or lies in a
 * straight tube of 3 mm diameter. The command `peer_rod free|tube SETTLE_TICKS TIMED_TICKS` prints one line
 * of key=value pairs. */
#include "firmware/bench/bench.h"
#include "firmware/core/core_state.h"
#include "firmware/tests/reference/tube_lumen.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* The length of an element is 0.5 m / 256, rounded up to a whole micrometre, so the rear end of the last
 * element remains in the sheath. */
enum { ELEMENTS = 256, ELEMENT_um = 1954, LENGTH_um = 500000, SPARE_ELEMENTS = 8, TICKS_MAX = 1000000 };
static const double young_Pa = 60e9, density_kg_m3 = 7850, radius_m = 0.445e-3, tube_radius_m = 1.5e-3,
                    friction = 0.2;
static const double pi = 3.14159265358979323846;

static crn_model model;
static crn_state state;
static crn_input input;
static crn_output output;

static double bend_N_m2(void)
{
    return young_Pa * pi * pow(radius_m, 4) / 4;
}

static double mass_kg_m(void)
{
    return density_kg_m3 * pi * radius_m * radius_m;
}

static void set_up(int in_tube)
{
    const reference_piece straight = {LENGTH_um * 1e-6 + 0.02, 0, 0};
    const crn_lumen *lumen = in_tube ? &reference_tube_make(&straight, 1, tube_radius_m, 1)->lumen : NULL;
    crn_instrument wire =
        reference_wire(bend_N_m2(), (ELEMENTS + SPARE_ELEMENTS) * ELEMENT_um, ELEMENT_um, friction);
    for (int i = 0; i < 2; i++) wire.knots[i].mass_mg_per_m = (uint32_t)lround(mass_kg_m() * 1e6);
    crn_entry entry = reference_entry();
    crn_build_place place;
    if (crn_model_build(&model, &wire, 1, lumen, &entry, &place) != CRN_BUILD_OK) bench_fail("no model");
    crn_state_init(&model, &state, &(uint32_t){LENGTH_um});
}

static int by_value(const void *a, const void *b)
{
    double d = *(const double *)a - *(const double *)b;
    return (d > 0) - (d < 0);
}

static void report(const char *scene, const double *sorted_us, int ticks)
{
    crn_vec3 tip = crn_state_position(&state, 0);
    printf("code=cournand version=%d scene=%s step_us=1000 us_per_ms_min=%.4f us_per_ms_median=%.4f "
           "contacts=%u "
           "length_error_pct=%.5f tip_x_mm=%.4f tip_z_mm=%.4f elements=%u bend_N_m2=%.6g mass_g_per_m=%.5g "
           "friction=%.3g drag_per_s=20\n",
           CRN_CORE_VERSION, scene, sorted_us[0], sorted_us[ticks / 2], output.contact_count,
           output.strain_max_q30 / 1073741824.0 * 100, tip.v[0] / 1073741.824, tip.v[2] / 1073741.824,
           crn_state_free_count(&state), bend_N_m2(), mass_kg_m() * 1e3, friction);
}

int main(int argc, char **argv)
{
    int settle = argc == 4 ? atoi(argv[2]) : 0, timed = argc == 4 ? atoi(argv[3]) : 0;
    int in_tube = argc == 4 && strcmp(argv[1], "tube") == 0;
    if (settle < 1 || timed < 1 || settle > TICKS_MAX || timed > TICKS_MAX ||
        (!in_tube && strcmp(argv[1], "free") != 0)) {
        fprintf(stderr, "usage: %s free|tube SETTLE_TICKS TIMED_TICKS   (1 to %d)\n", argv[0], TICKS_MAX);
        return 2;
    }
    double *us = malloc((size_t)timed * sizeof *us);
    if (us == NULL) bench_fail("no memory for the times");
    set_up(in_tube);
    for (int i = 0; i < settle; i++) crn_step(&model, &state, &input, &output);
    for (int i = 0; i < timed; i++) {
        double start = bench_now_us();
        crn_step(&model, &state, &input, &output);
        us[i] = bench_now_us() - start;
    }
    qsort(us, (size_t)timed, sizeof *us, by_value);
    report(argv[1], us, timed);
    free(us);
    return 0;
}
