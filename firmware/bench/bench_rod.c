/* This benchmark measures the cost of one tick, and the error of large bending in comparison with the
 * elastica, the exact curve (docs/bench.md names the rows).
 *
 * In the scene `bends`, a very stiff wire (EI 1.85e-3 N m^2, 3 mm elements) is pushed through a tube of 2 mm
 * radius with three bends. In the scene `floor`, a soft wire (EI 2e-6 N m^2) lies on the floor of a straight
 * narrow tube. In the scene `floor`, every node touches the wall except the few that hang from the sheath's
 * distal end. The scene `bends` also runs in a vessel that beats 90 times a minute, either along its whole
 * length or, as in a heart, only in its last 200 mm. In the scene `coronary`, a 0.014 in wire lies in a
 * vessel of 1.5 mm radius on a beating sphere (tests/reference/moving_tube.h). In the scene `balloon`, a wire
 * lies in a balloon catheter of 256 elements in a tube with three bends. The catheter's balloon of 3 x 20 mm
 * is either folded, or fills the vessel at 8 bar. A row of the benchmark fails when its scene has fewer
 * contacts than the row states. */
#include "firmware/bench/bench.h"
#include "firmware/core/core_state.h"
#include "firmware/tests/reference/cantilever.h"
#include "firmware/tests/reference/moving_tube.h"
#include "firmware/tests/reference/tube_lumen.h"

#include <math.h>
#include <stdio.h>

enum {
    ALL_BEATS = 1,
    HEART_BEATS,
    HEART_FROM_mm = 570 /* the path has a point per mm: from here on lie the wire's last 200 mm */
};
enum { CALLS = 100, TIMED_TICKS = 400, ELASTICA_TICKS = 20000, ELEMENT_um = 3000 };

static crn_model model;
static crn_state state;
static crn_input input;
static crn_output output;

typedef struct scene {
    int elements, on_floor, contacts, tools, beats;
    int balloon_kPa; /* 0: none; 1: folded */
    int has_lesion;  /* the vessel yields under the balloon */
} scene;
static const scene scenes[] = {{256, 0, 57, 1, 0, 0, 0},
                               {128, 0, 20, 1, 0, 0, 0},
                               {64, 0, 4, 1, 0, 0, 0},
                               {256, 1, 240, 1, 0, 0, 0},
                               {256, 1, 240, 3, 0, 0, 0},
                               {256, 0, 50, 1, ALL_BEATS, 0, 0},
                               {256, 0, 50, 1, HEART_BEATS, 0, 0},
                               {256, 0, 50, 2, 0, 1, 0},
                               {256, 0, 50, 2, 0, 800, 0},
                               {256, 0, 50, 2, HEART_BEATS, 1, 0},
                               {256, 0, 50, 2, HEART_BEATS, 800, 0},
                               {256, 0, 50, 2, 0, 800, 1},
                               {256, 0, 50, 2, HEART_BEATS, 800, 1}};

/* The program callgrind counts the instructions of crn_step only when measured_step calls it, so the ticks of
 * the insertion are not counted. In the measured ticks the tools slide and turn against each other, so that
 * the core must compute their combined properties anew in every tick. */
static BENCH_MEASURED void measured_step(void)
{
    crn_step(&model, &state, &input, &output);
}

/* Makes one of three nested tools: it is thin, and tapers over 200 mm to a shaft that is 1.5 times as stiff
 * as the tip. */
static void make_coaxial(crn_instrument *tool, uint32_t radius_um, uint32_t bore_um)
{
    tool->knot_count = 3;
    tool->knots[2] = tool->knots[1];
    tool->knots[1].arc_um = 200000;
    for (uint32_t i = 0; i < tool->knot_count; i++) {
        tool->knots[i].radius_outer_um = radius_um;
        tool->knots[i].radius_inner_um = bore_um;
        if (i > 0) tool->knots[i].bend_stiffness_nN_m2 += tool->knots[i].bend_stiffness_nN_m2 / 2;
    }
}

/* Puts the balloon on the catheter, 20 mm behind its tip. */
static void put_balloon(crn_instrument *tool)
{
    tool->balloon = (crn_balloon){.point_count = 2,
                                  .distal_um = 20000,
                                  .proximal_um = 40000,
                                  .burst_kPa = 2000,
                                  .pressure_kPa = {600, 1600},
                                  .diameter_um = {4500, 5000}};
}

static int nearest_point(const reference_tube *tube, uint32_t node)
{
    const crn_vec3 p = crn_state_position(&state, node);
    double least = 9;
    int best = 0;
    for (uint32_t i = 0; i < tube->point_count; i++) {
        double square = 0;
        for (int k = 0; k < 3; k++) {
            const double off = tube->points_m[i][k] - p.v[k] / 1073741824.0;
            square += off * off;
        }
        if (square < least) best = (int)i;
        least = fmin(least, square);
    }
    return best;
}

/* Around the middle of the balloon, the vessel widens by 0.4 mm all round over a length of 22 mm. The
 * vessel's path has one point per millimetre. */
static void put_lesion(reference_tube *tube)
{
    enum { STATIONS = 23 };
    static crn_lesion_station stations[STATIONS];
    static crn_lesion lesion;
    const double q30 = 1073741824.0;
    const double begin = nearest_point(tube, 10) - 11; /* 10 elements of 3 mm */
    lesion = (crn_lesion){.stretch_q28 = 1 << 28,
                          .spacing_log2_q30 = 20,
                          .station_count = STATIONS,
                          .yield_Pa = 100000,
                          .full_Pa = 100000,
                          .pace_q30 = 1 << 24,
                          .stations = stations};
    for (int i = 0; i < STATIONS; i++) {
        const double at = begin + i * 1048576 / q30 * 1e3;
        const double *a = tube->points_m[(int)at], *b = tube->points_m[(int)at + 1];
        stations[i].healthy_radius_m_q30 = (int32_t)(0.0024 * q30);
        stations[i].channel_radius_m_q30 = (int32_t)(0.002 * q30);
        for (int k = 0; k < 3; k++) {
            const int32_t here = (int32_t)((a[k] + (at - (int)at) * (b[k] - a[k])) * q30);
            stations[i].healthy_m_q30[k] = stations[i].channel_m_q30[k] = here;
            stations[i].along_q30[k] = (int32_t)((b[k] - a[k]) * 1e3 * q30);
            if (i == 0 || here - (1 << 23) < lesion.low_m_q30[k]) lesion.low_m_q30[k] = here - (1 << 23);
            if (i == 0 || here + (1 << 23) > lesion.high_m_q30[k]) lesion.high_m_q30[k] = here + (1 << 23);
        }
    }
    double chord[3], length = 0;
    for (int k = 0; k < 3; k++) {
        chord[k] = stations[STATIONS - 1].healthy_m_q30[k] - stations[0].healthy_m_q30[k];
        length += chord[k] * chord[k];
    }
    for (int k = 0; k < 3; k++) lesion.chord_q30[k] = (int32_t)(chord[k] / sqrt(length) * (q30 - 4));
    tube->lumen.lesion_count = 1;
    tube->lumen.lesions = &lesion;
}

/* Makes a displacement lattice with a spacing of 7.8 mm around the vessel's path, beginning at `from`. */
static void make_beat(reference_tube *tube, uint32_t from)
{
    double low[3] = {9, 9, 9}, high[3] = {-9, -9, -9};
    for (uint32_t i = from; i < tube->point_count; i++) {
        for (int k = 0; k < 3; k++) {
            low[k] = fmin(low[k], tube->points_m[i][k] - 0.03);
            high[k] = fmax(high[k], tube->points_m[i][k] + 0.03);
        }
    }
    tube->lumen.motion = &reference_waves_make(low, high, 23)->motion;
}

/* Starts a heart rhythm of 90 beats a minute. */
static void begin_beating(void)
{
    input.rhythm = (crn_rhythm_order){CRN_RHYTHM_HEART_RATE, 90};
    crn_step(&model, &state, &input, &output);
    input.rhythm = (crn_rhythm_order){CRN_RHYTHM_ASYSTOLE, 0};
    crn_step(&model, &state, &input, &output);
    input.rhythm = (crn_rhythm_order){0, 0};
}

/* Pushes the wire in at 0.1 m/s until as many mesh edges are outside the sheath as the scene states, then
 * waits for half a second. */
static void insert(const scene *s)
{
    const reference_piece straight = {0.85, 0, 0};
    reference_tube *tube =
        s->on_floor ? reference_tube_make(&straight, 1, 0.0008, 1) : reference_three_bends(0.002, 1);
    if (s->beats) make_beat(tube, s->beats == ALL_BEATS ? 0 : HEART_FROM_mm);
    crn_instrument tools[CRN_TOOL_MAX];
    const uint32_t radius_um[] = {300, 370, 445};
    for (int k = 0; k < s->tools; k++) {
        tools[k] = reference_wire(s->on_floor ? 2e-6 : 1.85e-3, 900000, ELEMENT_um, 0.2);
        tools[k].lumen_friction_milli = 50;
        if (s->tools > 1) make_coaxial(&tools[k], radius_um[k], k > 0 ? radius_um[k - 1] : 0);
    }
    if (s->balloon_kPa > 0) put_balloon(&tools[1]);
    crn_entry entry = reference_entry();
    crn_build_place place;
    const uint32_t inserted_um[] = {50000, 49000, 48000};
    if (crn_model_build(&model, tools, (uint32_t)s->tools, &tube->lumen, &entry, &place) != CRN_BUILD_OK)
        bench_fail("no model");
    crn_state_init(&model, &state, inserted_um);
    state.words.rhythm.bits = CRN_RHYTHM_WANTS_ASYSTOLE | CRN_RHYTHM_IS_RESTING;
    for (int rest = 0; rest < 500;) {
        if ((int)crn_state_free_count(&state) < s->elements) {
            for (int k = 0; k < s->tools; k++) input.hands[k].feed_m_q30 += 107374;
        } else {
            rest++;
        }
        crn_step(&model, &state, &input, &output);
    }
    fprintf(stderr, "tip %d mm\n", (int)(crn_state_inserted(&state, 0) * 1e3 / 1073741824.0));
    fprintf(stderr, "%u free nodes, %u contacts\n", crn_state_free_count(&state), output.contact_count);
    if (output.contact_count < s->contacts) bench_fail("the scene has fewer contacts than its row says");
    if (s->has_lesion) put_lesion(tube);
    if (s->beats) begin_beating();
    input.inflator_Pa = s->balloon_kPa > 1 ? s->balloon_kPa * 1000 : 0;
    const int settling_ms = s->balloon_kPa > 0 ? 500 : (s->beats ? 100 : 0);
    for (int ms = 0; ms < settling_ms; ms++) crn_step(&model, &state, &input, &output);
    if (s->has_lesion && state.words.lesions.open_q30[0][11] < CRN_ONE_Q30 / 2)
        bench_fail("the lesion does not give way");
    if (s->balloon_kPa > 1 && output.balloon_wall_N_q22 < (s->has_lesion ? 1 : 100) << 22)
        bench_fail("the balloon does not fill the vessel");
}

/* Returns the depth in mm of the deepest contact of the coronary wire. The benchmark's argument 0 selects the
 * insertion into the vessel at rest, and argument 1 selects the following 60 s at 90 beats a minute. */
static double run_coronary(const bench_case *self)
{
    reference_tube *tube = reference_tube_make(reference_coronary, 3, 0.0015, 1);
    tube->lumen.motion = &reference_motion_make(reference_beating_sphere, reference_coronary_low_m,
                                                reference_coronary_high_m, 23)
                              ->motion;
    const crn_instrument wire = reference_coronary_wire();
    const crn_entry entry = reference_entry();
    const uint32_t inserted_um = 30000;
    crn_build_place place;
    if (crn_model_build(&model, &wire, 1, &tube->lumen, &entry, &place) != CRN_BUILD_OK)
        bench_fail("no model");
    crn_state_init(&model, &state, &inserted_um);
    state.words.rhythm.bits = CRN_RHYTHM_WANTS_ASYSTOLE | CRN_RHYTHM_IS_RESTING;
    input = (crn_input){0};
    double resting_mm = 0, beating_mm = 0;
    for (int ms = 0; ms < 2500; ms++) {
        if (ms < 2000) input.hands[0].feed_m_q30 += 53687; /* 0.05 m/s */
        crn_step(&model, &state, &input, &output);
        resting_mm = fmax(resting_mm, output.penetration_max_m_q30 * 1e3 / 1073741824.0);
    }
    if (self->argument == 0) return resting_mm;
    begin_beating();
    for (int ms = 0; ms < 60000; ms++) {
        crn_step(&model, &state, &input, &output);
        beating_mm = fmax(beating_mm, output.penetration_max_m_q30 * 1e3 / 1073741824.0);
    }
    return beating_mm;
}

/* Returns the longest time, in ms, that an exchange of tools and the next tick take together; in this tick
 * the core combines the nested tools anew. While the exchange and the next tick run, the device can compute
 * no other tick. A wire and a guide are inserted by the length of 256 elements, and two catheters are
 * inserted in turn between them. */
static double run_exchange(const bench_case *self)
{
    enum { TABLE = 8, EXCHANGES = 200 };
    static const uint32_t line[] = {1, 0, 2}, inserted_um[] = {760000, 0, 760000};
    crn_instrument table[TABLE];
    const crn_entry entry = reference_entry();
    crn_build_place place;
    double longest_us = 0;
    (void)self;
    for (int k = 0; k < TABLE; k++) {
        table[k] = reference_wire(1e-4, 900000, ELEMENT_um, 0.2);
        if (k > 0) make_coaxial(&table[k], k == 1 ? 900 : 600, k == 1 ? 700 : 500);
    }
    if (crn_model_build_table(&model, table, TABLE, line, 3, NULL, &entry, &place) != CRN_BUILD_OK)
        bench_fail("no model");
    crn_state_init(&model, &state, inserted_um);
    input = (crn_input){0};
    for (int ms = 0; ms < 100; ms++) crn_step(&model, &state, &input, &output);
    for (uint32_t i = 0; i < EXCHANGES; i++) {
        const crn_exchange_order order = {1, 3 + i % 2};
        const double begin_us = bench_now_us();
        if (crn_exchange(&model, &state, &order) != CRN_EXCHANGE_DONE) bench_fail("an exchange was refused");
        crn_step(&model, &state, &input, &output);
        longest_us = fmax(longest_us, bench_now_us() - begin_us);
    }
    return longest_us / 1000;
}

static void slide_tools(const scene *s)
{
    for (int k = 1; k < s->tools; k++) {
        input.hands[k].feed_m_q30 += k == 1 ? 50000 : -50000;
        input.hands[k].turn32 += 3000000;
    }
}

static double run_instructions(const bench_case *self)
{
    insert(&scenes[self->argument]);
    for (int i = 0; i < CALLS; i++) {
        slide_tools(&scenes[self->argument]);
        measured_step();
    }
    return 0;
}

static double run_us(const bench_case *self)
{
    insert(&scenes[self->argument]);
    double fastest = 1e9;
    for (int i = 0; i < TIMED_TICKS; i++) {
        slide_tools(&scenes[self->argument]);
        double start = bench_now_us();
        measured_step();
        fastest = fmin(fastest, bench_now_us() - start);
    }
    return fastest;
}

/* Returns the largest error of the tip's position for six tip loads P on a rod of length L, with P L^2 / EI
 * from 0.5 to 10. The benchmark's argument is ten times the number of elements, plus the index of the
 * stiffness. */
static double run_elastica(const bench_case *self)
{
    static const double bend_N_m2[] = {2e-6, 1e-5, 1e-4, 1.85e-3, 4.9e-3};
    double worst = 0;
    for (int i = 0; i < REFERENCE_TIP_LOADS; i++) {
        double error = reference_tip_load_error_pct(&reference_tip_load[i], bend_N_m2[self->argument % 10],
                                                    (uint32_t)self->argument / 10, ELASTICA_TICKS);
        worst = fmax(worst, error);
    }
    return worst;
}

#define ELASTICA(elements, index, bend, length)                                                              \
    {                                                                                                        \
        "elastica.tip_error_pct_of_L", "%",                                                                  \
            "elements=" #elements " EI_N_m2=" bend " L_m=" length " PL2_EI=0.5..10", NULL, 0, run_elastica,  \
            elements * 10 + index                                                                            \
    }
#define CORONARY(context, index)                                                                             \
    {                                                                                                        \
        "rod.coronary_penetration_mm", "mm", context, NULL, 0, run_coronary, index                           \
    }
#define STEP(elements, contacts, tools, index)                                                               \
    {"rod.step_instructions",                                                                                \
     "instructions",                                                                                         \
     "elements=" #elements " contacts=" contacts " tools=" #tools,                                           \
     "measured_step",                                                                                        \
     CALLS,                                                                                                  \
     run_instructions,                                                                                       \
     index},                                                                                                 \
    {                                                                                                        \
        "rod.step_us", "us", "elements=" #elements " contacts=" contacts " tools=" #tools, NULL, 0, run_us,  \
            index                                                                                            \
    }

static const bench_case cases[] = {
    STEP(256, "57+", 1, 0),
    STEP(128, "20+", 1, 1),
    STEP(64, "4+", 1, 2),
    STEP(256, "all", 1, 3),
    STEP(256, "all", 3, 4),
    STEP(256, "50+ beating=all", 1, 5),
    STEP(256, "50+ beating=last_200_mm", 1, 6),
    STEP(256, "50+ balloon=folded", 2, 7),
    STEP(256, "50+ balloon=inflated", 2, 8),
    STEP(256, "50+ balloon=inflated lesion=open", 2, 11),
    STEP(256, "50+ beating=last_200_mm balloon=inflated lesion=open", 2, 12),
    STEP(256, "50+ beating=last_200_mm balloon=folded", 2, 9),
    STEP(256, "50+ beating=last_200_mm balloon=inflated", 2, 10),
    {"core.exchange_ms", "ms", "table=8 tools=3", NULL, 0, run_exchange, 0},
    CORONARY("at=rest pushed_in_m_s=0.05", 0),
    CORONARY("at=90/min for_s=60", 1),
    ELASTICA(256, 0, "2e-6", "0.1"),
    ELASTICA(256, 1, "1e-5", "0.1"),
    ELASTICA(256, 2, "1e-4", "0.5"),
    ELASTICA(256, 3, "1.85e-3", "0.5"),
    ELASTICA(256, 4, "4.9e-3", "0.5"),
    ELASTICA(64, 0, "2e-6", "0.1"),
    ELASTICA(64, 1, "1e-5", "0.1"),
    ELASTICA(64, 2, "1e-4", "0.5"),
    ELASTICA(64, 3, "1.85e-3", "0.5"),
    ELASTICA(64, 4, "4.9e-3", "0.5"),
};

int main(int argc, char **argv)
{
    return bench_main(argc, argv, cases, sizeof cases / sizeof cases[0]);
}
