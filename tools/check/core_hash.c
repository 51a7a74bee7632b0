/* Drives the core through a session made of integers only and prints its state hashes: test_compilers.sh
 * builds this with several compilers and optimisation levels, and every build must print the same lines.
 *
 * The lumen is a square tube, 8 mm wide and 120 mm long, closed at its end: the wire enters, touches, turns,
 * is pushed against the end wall until it buckles, and is pulled back.
 *
 *      entry -> ================================|   y = 120 mm
 *               8 mm                            |
 *               ================================|
 *
 * May include: the core's public headers. Called by: tools/check/test_compilers.sh. */
#include <stdio.h>
#include <stdlib.h>

#include "firmware/core/core.h"

enum {
    BRICKS_X = 3,
    BRICKS_Y = 20,
    BRICKS_Z = 3,
    BRICK_COUNT = BRICKS_X * BRICKS_Y * BRICKS_Z,
    SAMPLE_EDGE = 10,
    HALF_VOXEL = 16, /* a voxel is 32 units of a coefficient */
    HALF_WIDTH = 4 * 32 + 3,
    LENGTH = 123 * 32,
    TICKS_PER_LINE = 500,
    LINES = 8,
};

static uint16_t brick_index[BRICK_COUNT];
static int8_t brick_samples[BRICK_COUNT * SELD_LUMEN_BRICK_SAMPLES];

static int largest(int a, int b)
{
    return a > b ? a : b;
}

/* Distance in 1/32 voxel at a point in 1/32 voxel: the largest of the distances from the five walls. */
static int tube_distance(int x, int y, int z)
{
    int distance = largest(largest(abs(x), abs(z)) - HALF_WIDTH, y - LENGTH);
    return distance > 127 ? 127 : distance < -127 ? -127 : distance;
}

static void fill_brick(int brick)
{
    int corner_x = (brick % BRICKS_X * SELD_LUMEN_BRICK_EDGE - BRICKS_X * SELD_LUMEN_BRICK_EDGE / 2) * 32;
    int corner_y = brick / BRICKS_X % BRICKS_Y * SELD_LUMEN_BRICK_EDGE * 32;
    int corner_z =
        (brick / (BRICKS_X * BRICKS_Y) * SELD_LUMEN_BRICK_EDGE - BRICKS_Z * SELD_LUMEN_BRICK_EDGE / 2) * 32;
    int8_t *samples = &brick_samples[brick * SELD_LUMEN_BRICK_SAMPLES];
    for (int i = 0; i < SELD_LUMEN_BRICK_SAMPLES; i++) {
        int x = corner_x + (i % SAMPLE_EDGE - 1) * 32 + HALF_VOXEL;
        int y = corner_y + (i / SAMPLE_EDGE % SAMPLE_EDGE - 1) * 32 + HALF_VOXEL;
        int z = corner_z + (i / (SAMPLE_EDGE * SAMPLE_EDGE) - 1) * 32 + HALF_VOXEL;
        samples[i] = (int8_t)tube_distance(x, y, z);
    }
    brick_index[brick] = (uint16_t)(brick + SELD_LUMEN_ENTRY_FIRST_BRICK);
}

static seld_lumen make_tube(void)
{
    for (int brick = 0; brick < BRICK_COUNT; brick++) fill_brick(brick);
    const int32_t brick_edge = (int32_t)SELD_LUMEN_BRICK_EDGE << SELD_LUMEN_VOXEL_LOG2_Q30;
    seld_lumen lumen = {
        .origin_m_q30 = {-BRICKS_X * brick_edge / 2, 0, -BRICKS_Z * brick_edge / 2},
        .brick_count_xyz = {BRICKS_X, BRICKS_Y, BRICKS_Z},
        .brick_count = BRICK_COUNT,
        .index = brick_index,
        .samples = brick_samples,
    };
    return lumen;
}

/* A J wire: floppy curved tip of 15 mm, transition to a stiff shaft at 60 mm. */
static seld_instrument make_wire(void)
{
    const seld_knot tip = {.arc_um = 0,
                           .bend_stiffness_nN_m2 = 10000,
                           .twist_stiffness_nN_m2 = 10000,
                           .mass_mg_per_m = 4000,
                           .radius_outer_um = 445,
                           .friction_kinetic_milli = 100,
                           .friction_static_milli = 120,
                           .rest_curvature1_per_m_milli = 150000};
    seld_knot bend_end = tip;
    bend_end.arc_um = 15000;
    seld_knot straight = bend_end;
    straight.rest_curvature1_per_m_milli = 0;
    seld_knot shaft = straight;
    shaft.arc_um = 60000;
    shaft.bend_stiffness_nN_m2 = 500000;
    shaft.twist_stiffness_nN_m2 = 500000;
    seld_knot end = shaft;
    end.arc_um = 400000;
    seld_instrument wire = {.knot_count = 5,
                            .knots = {tip, bend_end, straight, shaft, end},
                            .axial_stiffness_max_N = 3000,
                            .element_tip_um = 1000,
                            .element_shaft_um = 3000,
                            .element_fine_um = 40000};
    return wire;
}

/* 2.5 s forwards at 60 mm/s with a turn on the way, then back at 30 mm/s. `variant` changes the hand a
 * little. */
static seld_input hand_at(uint32_t tick, uint32_t variant)
{
    const int32_t step_m_q30 = 64425; /* 60 mm/s for 1 ms */
    const uint32_t forward_ticks = 2500;
    uint32_t forward = tick < forward_ticks ? tick : forward_ticks;
    seld_input input = {
        .hand_feed_m_q30 = (int32_t)forward * step_m_q30 - (int32_t)(tick - forward) * (step_m_q30 / 2),
        .hand_turn32 = forward * (1717987u + variant), /* 0.4 turns per second */
    };
    return input;
}

static void run(const seld_model *model, seld_state *state, uint32_t variant)
{
    seld_output output = {0};
    uint32_t contacts_max = 0;
    int32_t force_max_N_q22 = 0;
    seld_state_init(model, state, 40000);
    for (uint32_t tick = 1; tick <= LINES * TICKS_PER_LINE; tick++) {
        seld_input input = hand_at(tick, variant);
        seld_step(model, state, &input, &output);
        contacts_max = output.contact_count > contacts_max ? output.contact_count : contacts_max;
        force_max_N_q22 =
            output.handle_axial_N_q22 > force_max_N_q22 ? output.handle_axial_N_q22 : force_max_N_q22;
        if (tick % TICKS_PER_LINE == 0) {
            printf("tick %u hash %016llx lanes %08x %08x\n", output.tick,
                   (unsigned long long)seld_state_hash64(state), output.hash_lane[0], output.hash_lane[1]);
        }
    }
    printf("contacts_max %u force_max_mN %lld\n", contacts_max,
           (long long)force_max_N_q22 * 1000 / (1 << 22));
}

int main(int argc, char **argv)
{
    if (argc > 2) {
        fprintf(stderr,
                "usage: %s [VARIANT]   (VARIANT: a number that changes the hand's motion, default 0)\n",
                argv[0]);
        return 2;
    }
    uint32_t variant = argc == 2 ? (uint32_t)strtoul(argv[1], NULL, 10) : 0;
    seld_lumen lumen = make_tube();
    seld_instrument wire = make_wire();
    seld_entry entry = {.position_m_q30 = {{0, 8 << 20, 0}}, .direction_q30 = {{0, SELD_ONE_Q30, 0}}};
    seld_model *model = malloc(seld_model_size());
    seld_state *state = malloc(seld_state_size());
    uint32_t field = 0;
    seld_build_status status = model == NULL || state == NULL
                                   ? SELD_BUILD_LENGTH
                                   : seld_model_build(model, &wire, &lumen, &entry, &field);
    if (status == SELD_BUILD_OK) {
        run(model, state, variant);
    } else {
        fprintf(stderr, "core_hash: the model cannot be built: status %d, field %u\n", (int)status, field);
    }
    free(state);
    free(model);
    return status == SELD_BUILD_OK ? 0 : 1;
}
