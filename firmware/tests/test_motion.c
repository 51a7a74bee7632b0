/* Claims about vessels that move. The tests show that the lattice reproduces the map from which it was made,
 * including the normal and the displacement of the wall. A wire in a beating vessel moves with the vessel,
 * and penetrates the wall no deeper than a wire in a vessel at rest. A wall that moves along the wire drags
 * it with mu N. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "firmware/core/core_state.h"
#include "firmware/tests/reference/moving_tube.h"
#include "firmware/tests/reference/random.h"

static const double q30_per_m = 1073741824.0;
static reference_tube *tube;
static reference_motion *beating;

static int set_up(void **state)
{
    (void)state;
    tube = reference_tube_make(reference_coronary, 3, 0.0015, 1);
    beating = reference_motion_make(reference_beating_sphere, reference_coronary_low_m,
                                    reference_coronary_high_m, 23);
    return 0;
}

static int tear_down(void **state)
{
    (void)state;
    reference_motion_free(beating);
    reference_tube_free(tube);
    return 0;
}

static crn_vec3 to_q30(const double *m)
{
    return crn_vec3_make((int32_t)lround(m[0] * q30_per_m), (int32_t)lround(m[1] * q30_per_m),
                         (int32_t)lround(m[2] * q30_per_m));
}

static uint32_t phase32(double phase)
{
    return (uint32_t)(uint64_t)floor((phase - floor(phase)) * 4294967296.0);
}

/* Computes the pose of the vessel for one tick. The heart's phase grows by `step` during the tick and is
 * `phase` at its end. The chest is at the end of expiration or, when `breath` is 1, at the end of
 * inspiration. */
static crn_motion_pose pose_of(const crn_motion *motion, double phase, double step, double breath)
{
    crn_rhythm now = {.heart_phase32 = phase32(phase), .breath_phase32 = breath > 0 ? 1u << 31 : 0},
               before = now;
    before.heart_phase32 = phase32(phase - step);
    crn_motion_pose pose;
    crn_motion_pose_begin(motion, &pose, &before, &now);
    return pose;
}

static crn_motion_pose pose_at(double phase, double step, double breath)
{
    return pose_of(&beating->motion, phase, step, breath);
}

static double uniform(reference_random *random, double low, double high)
{
    return low + (high - low) * (double)(reference_random_next(random) >> 11) / 9007199254740992.0;
}

static double distance_m(const double *a, const double *b)
{
    return sqrt(pow(a[0] - b[0], 2) + pow(a[1] - b[1], 2) + pow(a[2] - b[2], 2));
}

/* Chooses a random point in the moved lumen: a point of the vessel's path, moved by the map. */
static void draw_place(reference_random *random, double phase, double breath, double *X, double *x)
{
    const double *p = tube->points_m[40 + reference_random_below(random, tube->point_count - 60)];
    for (int k = 0; k < 3; k++) X[k] = p[k] + uniform(random, -0.001, 0.001);
    reference_beating_sphere(X, phase, breath, x);
}

/* At its nodes and keyframes, the lattice equals the map, apart from half a unit of the stored numbers and
 * the rounding of the weights. Each of the eight cells around a node gives the same value there. */
static void the_lattice_passes_through_its_keyframes(void **state)
{
    (void)state;
    double worst = 0;
    for (uint32_t i = 0; i < 24 * 8; i++) {
        crn_motion_pose pose = pose_at(i / 8 / 24.0 + 1e-9, 0, 0);
        const double node[3] = {-0.008 + 12 / 128.0, -0.04 + 5 / 128.0, -0.024 + 5 / 128.0};
        double x[3], X[3], got[3];
        for (int k = 0; k < 3; k++) x[k] = node[k] + ((i >> k & 1) != 0 ? 1e-8 : -1e-8);
        crn_vec3 world = to_q30(x), reference = crn_motion_pull(&beating->motion, &pose, &world);
        reference_pull(reference_beating_sphere, x, i / 8 / 24.0, 0, X);
        for (int k = 0; k < 3; k++) got[k] = reference.v[k] / q30_per_m;
        worst = fmax(worst, distance_m(got, X));
    }
    print_message("# off by %.2f um at most, allowed 3\n", worst * 1e6);
    assert_true(worst < 3e-6);
}

/* Between nodes and keyframes, a lattice with a spacing of 7.8 mm and 24 keyframes represents a beat of 11 mm
 * with an error of at most 0.3 mm. The lattice of breath represents a breath motion of 8 mm with an error of
 * at most 0.3 mm, at any moment of the beat. */
static void the_lattice_represents_the_map(void **state)
{
    (void)state;
    reference_random random = reference_random_seed(3);
    double worst = 0, square = 0, deepest = 0;
    enum { PLACES = 4000 };
    for (int i = 0; i < PLACES; i++) {
        double X[3], x[3], got[3];
        const double phase = uniform(&random, 0, 1);
        draw_place(&random, phase, i % 2, X, x);
        crn_motion_pose pose = pose_at(phase, 0, i % 2);
        crn_vec3 world = to_q30(x), reference = crn_motion_pull(&beating->motion, &pose, &world);
        for (int k = 0; k < 3; k++) got[k] = reference.v[k] / q30_per_m;
        const double error = distance_m(got, X);
        if (i % 2 == 1) deepest = fmax(deepest, error);
        if (i % 2 == 1) continue;
        worst = fmax(worst, error);
        square += error * error;
    }
    print_message("# beating: rms %.3f mm, worst %.3f mm; inhaled: worst %.3f mm\n",
                  sqrt(square / (PLACES / 2)) * 1e3, worst * 1e3, deepest * 1e3);
    assert_true(worst < 0.3e-3 && deepest < 0.3e-3);
}

/* The cycle closes. Between neighbouring lattice cells and between keyframes, no value changes by more than
 * the distance between the points explains. */
static void the_map_is_continuous_in_place_and_time(void **state)
{
    (void)state;
    crn_motion_pose last = pose_at(1 - 1e-9, 0, 0), first = pose_at(0, 0, 0);
    double before[3] = {0};
    for (int i = 0; i <= 4000; i++) {
        const double x[3] = {0.02 + 0.1 * i / 4000, 0.011, 0.02 + 0.05 * i / 4000};
        double got[3];
        crn_vec3 world = to_q30(x), a = crn_motion_pull(&beating->motion, &last, &world),
                 b = crn_motion_pull(&beating->motion, &first, &world);
        for (int k = 0; k < 3; k++) {
            assert_true(abs(a.v[k] - b.v[k]) < 2000); /* 2 um */
            got[k] = b.v[k] / q30_per_m;
        }
        if (i > 0) assert_true(distance_m(got, before) < 1.8 * 0.112 / 4000 + 1e-7);
        memcpy(before, got, sizeof got);
    }
}

static void outside_the_lattice_nothing_moves(void **state)
{
    (void)state;
    crn_motion_pose pose = pose_at(0.4, 0.001, 1);
    const double places[4][3] = {{-0.01, 0, 0}, {0.2, 0, 0}, {0.05, 1.9, 0}, {0.05, 0, -1.9}};
    for (int i = 0; i < 4; i++) {
        crn_vec3 world = to_q30(places[i]), reference = crn_motion_pull(&beating->motion, &pose, &world);
        assert_memory_equal(&world, &reference, sizeof world);
        crn_vec3 step = crn_motion_wall_step(&beating->motion, &pose);
        assert_true(step.v[0] == 0 && step.v[1] == 0 && step.v[2] == 0);
    }
}

/* Returns the depth beyond the wall that the core computes at a point, in metres. */
static double depth_at(crn_motion_pose *pose, const double *x)
{
    crn_vec3 world = to_q30(x);
    crn_vec3 reference = crn_motion_pull(&beating->motion, pose, &world);
    return crn_lumen_contact(&tube->lumen, &reference).distance_m_q30 / q30_per_m;
}

/* The normal that the core computes must agree, within 1 degree, with the central differences of the distance
 * in the reference pose, which the test computes over 20 um. The expected distance is the distance phi in the
 * reference pose, divided by the length of the gradient of phi. Near the border of two lattice cells, a
 * central difference uses points in both cells, so up to 2 % of the tested points may fail. */
static void the_normal_is_the_gradient_of_the_moved_distance(void **state)
{
    (void)state;
    reference_random random = reference_random_seed(4);
    enum { PLACES = 1000 };
    int wide = 0, far = 0;
    for (int i = 0; i < PLACES; i++) {
        double X[3], x[3], g[3], length = 0, dot = 0;
        const double phase = uniform(&random, 0, 1), h = 2e-5;
        draw_place(&random, phase, i % 2, X, x);
        crn_motion_pose pose = pose_at(phase, 0, i % 2);
        for (int k = 0; k < 3; k++) {
            double up[3], down[3];
            memcpy(up, x, sizeof up);
            memcpy(down, x, sizeof down);
            up[k] += h;
            down[k] -= h;
            g[k] = (depth_at(&pose, up) - depth_at(&pose, down)) / (2 * h);
            length += g[k] * g[k];
        }
        length = sqrt(length);
        const double phi = depth_at(&pose, x);
        crn_vec3 world = to_q30(x);
        crn_lumen_sample wall = crn_motion_contact(&tube->lumen, &beating->motion, &pose, &world);
        if (phi < -0.0005 || length < 0.5) continue; /* farther away phi itself is no exact distance */
        for (int k = 0; k < 3; k++) dot -= g[k] / length * (wall.normal_q30.v[k] / q30_per_m);
        wide += dot < cos(acos(-1.0) / 180);
        far += fabs(wall.distance_m_q30 / q30_per_m * length - phi) > 10e-6 + 0.05 * fabs(phi);
    }
    print_message(
        "# of %d normals %d are off by more than 1 deg, of distances %d by more than 5 %% and 10 um\n",
        PLACES, wide, far);
    assert_true(wide < PLACES / 50 && far < PLACES / 50);
}

static int16_t up_to(reference_random *random, int32_t most)
{
    return (int16_t)((int32_t)reference_random_below(random, 2u * (uint32_t)most + 1) - most);
}

/* The cheap distance function alone decides that a node is far from the wall. If the full contact function
 * finds a small distance at a point, the cheap function must not return a large distance there. The test uses
 * the lattice of the beating vessel, and a random lattice in which the displacements of neighbouring nodes
 * differ by as much as a scene may contain. */
static void the_cheap_distance_never_hides_a_contact(void **state)
{
    (void)state;
    reference_random random = reference_random_seed(6);
    enum { PLACES = 20000, STEEP = 8, NODES = STEEP * STEEP * STEEP, NODE = 3 * CRN_MOTION_ROW };
    static int16_t rows[NODES * NODE], inhaled[NODES * 3];
    const int32_t spacing = 1 << (23 - CRN_MOTION_UNIT_LOG2_Q30);
    for (int i = 0; i < NODES * NODE; i++) {
        const int at = i / NODE;
        const bool edge = at % STEEP % (STEEP - 1) == 0 || at / STEEP % STEEP % (STEEP - 1) == 0 ||
                          at / STEEP / STEEP % (STEEP - 1) == 0;
        rows[i] = edge ? 0 : up_to(&random, spacing * 5 / 16);
        if (i % NODE < 3) inhaled[3 * at + i % NODE] = edge ? 0 : up_to(&random, spacing * 3 / 16);
    }
    const crn_lattice lattice = {{64 * 1048576, -28 * 1048576, -20 * 1048576}, {STEEP, STEEP, STEEP}, 23};
    const crn_motion steep = {lattice, rows, lattice, inhaled, NULL};
    const crn_motion *motions[] = {&beating->motion, &steep};
    for (int m = 0; m < 2; m++) {
        crn_motion_steepness steepness;
        crn_motion_steepness_make(motions[m], &steepness);
        double ratio = 1, least = 1;
        int near = 0, spared = 0;
        for (int i = 0; i < PLACES; i++) {
            double X[3], x[3];
            const double phase = uniform(&random, 0, 1);
            draw_place(&random, phase, i % 2, X, x);
            const crn_vec3 world = to_q30(x);
            crn_motion_pose pose = pose_of(motions[m], phase, 0.001, i % 2);
            const int32_t far = -(int32_t)reference_random_below(&random, 1000000); /* to 0.93 mm */
            const int32_t shrink_q30 = crn_motion_shrink_q30(&steepness, &pose.now);
            least = fmin(least, shrink_q30 / q30_per_m);
            const int32_t cheap =
                crn_motion_distance(&tube->lumen, motions[m], &pose, &world, shrink_q30, far);
            const int32_t exact = crn_motion_contact(&tube->lumen, motions[m], &pose, &world).distance_m_q30;
            assert_true(cheap >= exact || cheap >= 0);
            near += exact < far;
            spared += cheap < far;
            if (cheap >= far && cheap < -50000) ratio = fmax(ratio, (double)exact / cheap);
        }
        print_message(
            "# shrink %.3f at least, where it matters %.3f: %d of %d distant places found at once\n", least,
            1 / ratio, spared, near);
        assert_true(m == 1 || spared > near / 2);
    }
}

/* At 120 beats a minute, the test compares the wall's displacement in a tick, as the core computes it, with
 * the displacement of the same wall point by the exact map. The two displacements must differ by less than 2
 * um plus 5 % of the largest wall displacement in a tick (0.13 mm). In every second case the chest also
 * moves, with 20 breaths a minute. */
static void the_wall_step_is_that_of_the_map(void **state)
{
    (void)state;
    reference_random random = reference_random_seed(5);
    double fastest = 0, worst[2] = {0};
    for (int i = 0; i < 1000; i++) {
        double X[3], now[3], before[3], got[3], way[3];
        const double phase = uniform(&random, 0, 1), tick = 10.0 / 24 / 288,
                     breath = i % 2 * uniform(&random, 0, 1), breath_tick = i % 2 / 3000.0;
        draw_place(&random, phase, pow(sin(acos(-1.0) * breath), 4), X, now);
        reference_beating_sphere(X, phase - tick, pow(sin(acos(-1.0) * (breath - breath_tick)), 4), before);
        const crn_rhythm rhythm = {.heart_phase32 = phase32(phase), .breath_phase32 = phase32(breath)},
                         last = {.heart_phase32 = phase32(phase - tick),
                                 .breath_phase32 = phase32(breath - breath_tick)};
        crn_motion_pose pose;
        crn_motion_pose_begin(&beating->motion, &pose, &last, &rhythm);
        crn_vec3 world = to_q30(now);
        crn_motion_contact(&tube->lumen, &beating->motion, &pose, &world);
        crn_vec3 step = crn_motion_wall_step(&beating->motion, &pose);
        for (int k = 0; k < 3; k++) {
            got[k] = step.v[k] / (8 * q30_per_m);
            way[k] = now[k] - before[k];
        }
        const double none[3] = {0, 0, 0};
        fastest = fmax(fastest, distance_m(way, none));
        worst[i % 2] = fmax(worst[i % 2], distance_m(way, got));
    }
    print_message("# wall up to %.1f um in a tick, off by %.2f um at most, breathing by %.2f\n",
                  fastest * 1e6, worst[0] * 1e6, worst[1] * 1e6);
    assert_true(fmax(worst[0], worst[1]) < 0.05 * fastest + 2e-6);
}

/* Finds the place x that the look-up of a pose maps to X in the reference pose. */
static crn_vec3 place_of(crn_motion_pose *pose, const crn_vec3 *X)
{
    crn_vec3 x = *X;
    for (int round = 0; round < 40; round++) {
        const crn_vec3 back = crn_motion_pull(&beating->motion, pose, &x);
        for (int k = 0; k < 3; k++) x.v[k] += X->v[k] - back.v[k];
    }
    return x;
}

/* Where a wall point was before a tick and where it is after it, the look-up of the lattice itself tells; the
 * wall's step is the difference. A step that leads from one cell into the next may be off by more, because
 * the slope of the lattice changes there. */
static void the_wall_step_is_the_difference_of_two_look_ups(void **state)
{
    (void)state;
    reference_random random = reference_random_seed(7);
    enum { PLACES = 2000 };
    int far = 0, steps = 0;
    double off = 0, all = 0;
    for (int i = 0; i < PLACES; i++) {
        double X[3], x[3], got[3], way[3];
        const double phase = uniform(&random, 0, 1), tick = 10.0 / 24 / 288, none[3] = {0, 0, 0};
        draw_place(&random, phase, 0, X, x);
        crn_motion_pose now = pose_at(phase, tick, 0), before = pose_at(phase - tick, 0, 0);
        const crn_vec3 here = to_q30(x), fixed = crn_motion_pull(&beating->motion, &now, &here),
                       there = place_of(&before, &fixed);
        crn_motion_contact(&tube->lumen, &beating->motion, &now, &here);
        const crn_vec3 step = crn_motion_wall_step(&beating->motion, &now);
        for (int k = 0; k < 3; k++) {
            got[k] = step.v[k] / (8 * q30_per_m);
            way[k] = (here.v[k] - there.v[k]) / q30_per_m;
        }
        if (distance_m(way, none) < 5e-6) continue; /* the rounding of the look-up is felt */
        steps++;
        off += distance_m(way, got) / distance_m(way, none);
        all = fmax(all, distance_m(way, got) / distance_m(way, none));
        far += distance_m(way, got) > 0.01 * distance_m(way, none);
    }
    print_message("# mean %.3f %% of a step, worst %.2f %%, %d of %d off by more than 1 %%\n",
                  100 * off / steps, 100 * all, far, steps);
    assert_true(steps > PLACES / 2 && off / steps < 0.002);
}

/* A breath stretches everything along x: X - m = (1 + g depth) (x - m). The series for the wall's step is
 * off by the third power of g depth. */
static void the_step_of_a_breath_that_stretches_is_that_of_its_closed_form(void **state)
{
    (void)state;
    enum { SIDE = 8, NODES = SIDE * SIDE * SIDE, MIDDLE = 3 };
    static int16_t rows[NODES * 3 * CRN_MOTION_ROW], inhaled[NODES * 3];
    const int32_t spacing_q30 = 1 << 23, unit = 1 << CRN_MOTION_UNIT_LOG2_Q30;
    const double g = 0.3, spacing_m = spacing_q30 / q30_per_m;
    for (int i = 0; i < NODES; i++)
        inhaled[3 * i] = (int16_t)lround(g * (i % SIDE - MIDDLE) * spacing_q30 / unit);
    const crn_lattice lattice = {{0, 0, 0}, {SIDE, SIDE, SIDE}, 23};
    const crn_motion stretch = {lattice, rows, lattice, inhaled, NULL};
    double worst = 0, most = 0;
    for (double turn = 0.05; turn < 0.5; turn += 0.01) {
        const crn_rhythm before = {.breath_phase32 = phase32(turn - 2e-4)},
                         now = {.breath_phase32 = phase32(turn)};
        crn_motion_pose pose;
        crn_motion_pose_begin(&stretch, &pose, &before, &now);
        const double x[3] = {5.4 * spacing_m, 3.3 * spacing_m, 3.6 * spacing_m}, m = MIDDLE * spacing_m,
                     after = 1 + g * pose.now.breath_q15 / 32768.0,
                     ahead = 1 + g * pose.before.breath_q15 / 32768.0, way = (x[0] - m) * (1 - after / ahead),
                     scale = fabs(after - 1);
        const crn_vec3 world = to_q30(x);
        crn_motion_contact(&tube->lumen, &stretch, &pose, &world);
        const crn_vec3 step = crn_motion_wall_step(&stretch, &pose);
        assert_true(abs(step.v[1]) + abs(step.v[2]) < 100);
        if (fabs(way) < 1e-6) continue; /* at either end of the breath */
        const double off = fabs(step.v[0] / (8 * q30_per_m) / way - 1);
        worst = fmax(worst, off - pow(scale, 3));
        most = fmax(most, off);
    }
    print_message("# off by %.2f %% at most, %.3f %% more than the series\n", 100 * most, 100 * worst);
    assert_true(worst < 0.0005);
}

/* --- the rod in a moving vessel ------------------------------------------------------------------------- */

static crn_model model;
static crn_state core;

/* A 0.014 in wire with a soft tip is pushed 130 mm into the vessel at rest (asystole from the first tick
 * on). */
static void insert_coronary_wire(const crn_motion *motion)
{
    const crn_instrument wire = reference_coronary_wire();
    const uint32_t inserted_um = 30000;
    const crn_entry entry = reference_entry();
    crn_build_place place;
    tube->lumen.motion = motion;
    assert_int_equal(crn_model_build(&model, &wire, 1, &tube->lumen, &entry, &place), CRN_BUILD_OK);
    crn_state_init(&model, &core, &inserted_um);
    core.words.rhythm.bits = CRN_RHYTHM_WANTS_ASYSTOLE | CRN_RHYTHM_IS_RESTING;
    core.words.rhythm.breath_per_min = 14;
    core.words.rhythm.bits |= CRN_RHYTHM_HOLDS_BREATH;
}

static crn_output tick_with(crn_input *input, uint32_t action, uint32_t value)
{
    crn_output output = {0};
    input->rhythm = (crn_rhythm_order){action, value};
    crn_step(&model, &core, input, &output);
    return output;
}

static void push_in(crn_input *input)
{
    for (int ms = 0; ms < 2500; ms++) {
        input->hands[0].feed_m_q30 += ms < 2000 ? 53687 : 0; /* 0.05 m/s */
        tick_with(input, 0, 0);
    }
}

typedef struct beat_figures {
    double penetration_m, excursion_m, miss_m;
    uint32_t solved_twice, faults;
} beat_figures;

/* Simulates four seconds at 90 beats a minute with breath. `miss` receives the largest distance of any node
 * of the wire from the moved vessel's axis. */
static beat_figures beat_on(crn_input *input)
{
    beat_figures f = {0};
    const uint32_t node = 30;
    crn_vec3 low = core.words.nodes[node].position_m_q30, high = low;
    tick_with(input, CRN_RHYTHM_HEART_RATE, 90);
    tick_with(input, CRN_RHYTHM_BREATH_HOLD, 0);
    tick_with(input, CRN_RHYTHM_ASYSTOLE, 0);
    for (int ms = 0; ms < 4000; ms++) {
        crn_output output = tick_with(input, 0, 0);
        f.penetration_m = fmax(f.penetration_m, output.penetration_max_m_q30 / q30_per_m);
        f.solved_twice += output.solve_count > 1;
        f.faults |= output.fault_bits;
        for (int k = 0; k < 3; k++) {
            const int32_t at = core.words.nodes[node].position_m_q30.v[k];
            low.v[k] = at < low.v[k] ? at : low.v[k];
            high.v[k] = at > high.v[k] ? at : high.v[k];
        }
        f.miss_m = fmax(f.miss_m, crn_state_depth(&model, &core) / q30_per_m);
    }
    const double span[3] = {(high.v[0] - low.v[0]) / q30_per_m, (high.v[1] - low.v[1]) / q30_per_m,
                            (high.v[2] - low.v[2]) / q30_per_m};
    const double none[3] = {0, 0, 0};
    f.excursion_m = distance_m(span, none);
    return f;
}

/* The wire moves by more than 8 mm where the wall moves by 10 mm, and no node is ever deeper in the wall than
 * 0.15 mm. */
static void a_wire_in_a_beating_vessel_is_carried(void **state)
{
    (void)state;
    crn_input input = {0};
    insert_coronary_wire(&beating->motion);
    push_in(&input);
    assert_true(crn_state_inserted(&core, 0) > 0.125 * q30_per_m);
    core.words.fault_bits = 0; /* of the insertion */
    const beat_figures f = beat_on(&input);
    print_message(
        "# miss %.3f mm penetration %.3f mm, a node moves by %.1f mm, %u ticks solved twice, faults %u\n",
        f.miss_m * 1e3, f.penetration_m * 1e3, f.excursion_m * 1e3, f.solved_twice, f.faults);
    assert_true(f.excursion_m > 8e-3);
    assert_true(f.penetration_m < 0.15e-3 && f.miss_m < 0.15e-3);
    /* the wire may snap when the vessel widens */
    assert_int_equal(f.faults & ~(uint32_t)CRN_FAULT_STEP_CAPPED, 0);
}

/* A session that continues from a snapshot in the middle of a heartbeat has the same hashes as the
 * uninterrupted session. The equal hashes show that the state contains all data about the motion. */
static void a_beating_state_can_be_saved_and_goes_on_the_same(void **state)
{
    (void)state;
    static uint8_t bytes[sizeof(crn_state_words)];
    static crn_state other;
    crn_input input = {0};
    insert_coronary_wire(&beating->motion);
    push_in(&input);
    tick_with(&input, CRN_RHYTHM_ASYSTOLE, 0);
    for (int ms = 0; ms < 333; ms++) tick_with(&input, 0, 0);
    crn_state_save(&core, bytes);
    assert_true(crn_state_restore(&model, &other, bytes));
    for (int ms = 0; ms < 200; ms++) {
        crn_output a = {0}, b = {0};
        crn_step(&model, &core, &input, &a);
        crn_step(&model, &other, &input, &b);
        assert_memory_equal(a.hash_lane, b.hash_lane, sizeof a.hash_lane);
    }
}

/* Makes a lattice in which everything moves 6 mm along +x at the end of systole, like a floor that slides
 * under a wire. */
static void slide_along(const double *X, double phase, double breath, double *x)
{
    memcpy(x, X, 3 * sizeof *x);
    x[0] += 0.006 * reference_contraction(phase) + 0 * breath;
}

/* Total weight of the wire that the floor bears, N. */
static double normal_sum_N(void)
{
    double sum = 0;
    for (uint32_t i = 0; i < crn_state_free_count(&core); i++) {
        crn_vec3 force;
        if (crn_state_contact_force(&model, &core, i, &force)) sum += force.v[2] / 4194304.0;
    }
    return sum;
}

/* A soft wire of 5 g/m lies on the floor of a narrow straight tube, and a hand holds the wire while the floor
 * slides. The hand feels a force of the friction coefficient mu times the weight on the floor, within 2 %, in
 * one direction in systole and in the other in diastole. The floor supports the wire's weight, except for the
 * span that hangs from the introducer sheath's distal end. */
static void a_wall_that_slides_drags_at_mu_N(void **state)
{
    (void)state;
    const reference_piece straight = {0.3, 0, 0};
    const double low[3] = {0.004, -0.02, -0.02}, high[3] = {0.31, 0.02, 0.02}, friction = 0.25;
    reference_tube *floor_tube = reference_tube_make(&straight, 1, 0.0008, 1);
    reference_motion *sliding = reference_motion_make(slide_along, low, high, 23);
    crn_instrument wire = reference_wire(2e-6, 400000, 3000, friction);
    const uint32_t inserted_um = 250000;
    const crn_entry entry = reference_entry();
    crn_build_place place;
    floor_tube->lumen.motion = &sliding->motion;
    assert_int_equal(crn_model_build(&model, &wire, 1, &floor_tube->lumen, &entry, &place), CRN_BUILD_OK);
    crn_state_init(&model, &core, &inserted_um);
    crn_input input = {0};
    double systole = 0, diastole = 0, borne_N = 0;
    uint32_t systole_ticks = 0, diastole_ticks = 0;
    for (int ms = 0; ms < 3 * 857; ms++) {
        const crn_output output = tick_with(&input, 0, 0);
        const double phase = output.heart_phase32 / 4294967296.0,
                     force_N = output.tools[0].axial_N_q22 / 4194304.0;
        if (ms < 857) continue; /* it settles */
        borne_N = normal_sum_N();
        if (phase > 0.1 && phase < 0.32) systole += force_N / borne_N, systole_ticks++;
        if (phase > 0.55 && phase < 0.85) diastole += force_N / borne_N, diastole_ticks++;
    }
    systole /= systole_ticks;
    diastole /= diastole_ticks;
    print_message("# hand %.4f of the borne force in systole, %.4f in diastole, %.1f %% of the weight\n",
                  systole, diastole, borne_N / (0.005 * 9.81 * 0.25) * 100);
    assert_true(fabs(systole + friction) <
                0.02 * friction); /* the wall pulls the wire in, away from the hand */
    assert_true(fabs(diastole - friction) < 0.02 * friction);
    assert_true(borne_N > 0.85 * 0.005 * 9.81 * 0.25 && borne_N < 1.02 * 0.005 * 9.81 * 0.25);
    reference_motion_free(sliding);
    reference_tube_free(floor_tube);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_lattice_passes_through_its_keyframes),
        cmocka_unit_test(the_lattice_represents_the_map),
        cmocka_unit_test(the_map_is_continuous_in_place_and_time),
        cmocka_unit_test(outside_the_lattice_nothing_moves),
        cmocka_unit_test(the_normal_is_the_gradient_of_the_moved_distance),
        cmocka_unit_test(the_cheap_distance_never_hides_a_contact),
        cmocka_unit_test(the_wall_step_is_that_of_the_map),
        cmocka_unit_test(the_wall_step_is_the_difference_of_two_look_ups),
        cmocka_unit_test(the_step_of_a_breath_that_stretches_is_that_of_its_closed_form),
        cmocka_unit_test(a_wire_in_a_beating_vessel_is_carried),
        cmocka_unit_test(a_beating_state_can_be_saved_and_goes_on_the_same),
        cmocka_unit_test(a_wall_that_slides_drags_at_mu_N),
    };
    return cmocka_run_group_tests(tests, set_up, tear_down);
}
