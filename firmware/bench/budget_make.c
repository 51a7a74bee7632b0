/* This program prepares, on the PC, the cases that the Cortex-M7 measures. The program puts a wire into a
 * lumen. The program either lets the wire settle, or moves it until a tick needs a second solution of the
 * linear system (a second solve). Then it writes the state before the measured ticks with everything they
 * need (budget_case.h). usage: budget_make list | make CASE FILE */
#include "firmware/bench/bench.h"
#include "firmware/bench/budget_case.h"
#include "firmware/tests/reference/random.h"
#include "firmware/tests/reference/tube_lumen.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { REST_TICKS = 500, MEASURED_TICKS = 50, DRIVE_TICKS = 4000, FEED_m_q30 = 107374 };

typedef enum motion { RESTS, SLIDES, INSERTS, DRIVEN } motion;

typedef struct scene {
    const char *context;
    double tube_radius_m, bend_N_m2;
    bool straight;
    uint32_t elements, contacts;
    uint32_t tools;
    motion motion;
} scene;

/* The elements that touch the wall lie in the bends; in the case of a soft wire, elements also touch the
 * floor of the tube. */
static const scene scenes[] = {
    {"elements=256 contacts=100+", 0.002, 1.5e-6, false, 256, 100, 1, RESTS},
    {"elements=256 contacts=all", 0.0006, 2e-6, true, 256, 245, 1, RESTS},
    {"elements=256 contacts=all tools=3 sliding", 0.0008, 2e-6, true, 256, 240, 3, SLIDES},
    {"elements=128 contacts=20+", 0.002, 1.85e-3, false, 128, 20, 1, RESTS},
    {"elements=256 inserting", 0.002, 1.5e-6, false, 256, 100, 1, INSERTS},
    {"elements=256 second_solve", 0.004, 1e-5, false, 256, 0, 1, DRIVEN},
};
enum { SCENES = sizeof scenes / sizeof scenes[0] };

static crn_lumen lumen;
static crn_model model;
static crn_state state;
static crn_input input, inputs[BUDGET_TICKS_MAX];
static crn_output output;

/* Makes the reference wire; a driven wire has a floppy J. */
static crn_instrument make_wire(const scene *s)
{
    return s->motion == DRIVEN ? reference_floppy_j(s->bend_N_m2)
                               : reference_wire(s->bend_N_m2, 900000, 3000, 0.2);
}

/* Makes tool k of three. Makes a thin tool that tapers over 200 mm from the tip to a shaft 1.5 times as stiff
 * (as in bench_rod.c). */
static crn_instrument make_coaxial(const scene *s, uint32_t k)
{
    static const uint32_t radius_um[] = {300, 370, 445};
    crn_instrument tool = reference_wire(s->bend_N_m2, 900000, 3000, 0.2);
    tool.knot_count = 3;
    tool.knots[2] = tool.knots[1];
    tool.knots[1].arc_um = 200000;
    for (uint32_t i = 0; i < tool.knot_count; i++) {
        tool.knots[i].radius_outer_um = radius_um[k];
        tool.knots[i].radius_inner_um = k > 0 ? radius_um[k - 1] : 0;
        if (i > 0) tool.knots[i].bend_stiffness_nN_m2 += tool.knots[i].bend_stiffness_nN_m2 / 2;
    }
    tool.lumen_friction_milli = 50;
    return tool;
}

static budget_case *make_case(const scene *s, uint32_t *bytes)
{
    const reference_piece straight = {0.85, 0, 0};
    reference_tube *tube = s->straight ? reference_tube_make(&straight, 1, s->tube_radius_m, 1)
                                       : reference_three_bends(s->tube_radius_m, 1);
    const crn_lumen *l = &tube->lumen;
    uint32_t index_bytes = 2 * l->brick_count_xyz[0] * l->brick_count_xyz[1] * l->brick_count_xyz[2];
    budget_case head = {
        .magic = BUDGET_MAGIC,
        .index_bytes = index_bytes,
        .children_bytes = 16u * l->child_row_count,
        .samples_bytes = l->brick_count * CRN_LUMEN_BRICK_SAMPLES,
        .state_bytes = (uint32_t)crn_state_bytes(),
        .lumen_child_rows = l->child_row_count,
        .lumen_bricks = l->brick_count,
        .tool_count = s->tools,
        .tools = {s->tools > 1 ? make_coaxial(s, 0) : make_wire(s), make_coaxial(s, 1), make_coaxial(s, 2)},
        .entry = reference_entry()};
    memcpy(head.lumen_origin_m_q30, l->origin_m_q30, sizeof head.lumen_origin_m_q30);
    memcpy(head.lumen_bricks_xyz, l->brick_count_xyz, sizeof head.lumen_bricks_xyz);
    *bytes = (uint32_t)(sizeof head + budget_padded(head.index_bytes) + budget_padded(head.children_bytes) +
                        budget_padded(head.samples_bytes) + head.state_bytes + sizeof inputs);
    budget_case *c = calloc(1, *bytes);
    *c = head;
    uint8_t *at = (uint8_t *)(c + 1);
    memcpy(at, l->index, head.index_bytes);
    at += budget_padded(head.index_bytes);
    memcpy(at, l->children, head.children_bytes);
    at += budget_padded(head.children_bytes);
    memcpy(at, l->samples, head.samples_bytes);
    return c;
}

static uint8_t *state_of(budget_case *c)
{
    return (uint8_t *)(uintptr_t)budget_state(c);
}

static void feed(int32_t step_m_q30)
{
    for (int k = 0; k < CRN_TOOL_MAX; k++) input.hands[k].feed_m_q30 += step_m_q30;
}

/* Pushes the tools in at 0.1 m/s until as many mesh edges are outside the sheath as the scene states, then
 * waits. */
static void insert(const scene *s)
{
    for (int rest = 0; rest < REST_TICKS;) {
        if (crn_state_free_count(&state) < s->elements) {
            feed(FEED_m_q30);
        } else {
            rest++;
        }
        crn_step(&model, &state, &input, &output);
    }
}

/* The tools move against each other, so that the core must compute their combined properties anew in every
 * tick. */
static void slide(void)
{
    for (int k = 1; k < CRN_TOOL_MAX; k++) {
        input.hands[k].feed_m_q30 += k == 1 ? 50000 : -50000;
        input.hands[k].turn32 += 3000000;
    }
}

/* Moves the hand back and forth at up to 0.4 m/s and 12 rad/s around its position, changing direction every
 * 50 ticks. */
static crn_input drive(uint32_t tick, int32_t middle_m_q30)
{
    static reference_random random = {20};
    static int32_t way, turn;
    if (tick % 50 == 0) {
        way = (int32_t)(reference_random_next(&random) % 858993u) - 429496;
        turn = (int32_t)(reference_random_next(&random) % 16406000u) - 8203000;
        if ((input.hands[0].feed_m_q30 > middle_m_q30) == (way > 0)) way = -way;
    }
    feed(way);
    input.hands[0].turn32 += (uint32_t)turn;
    return input;
}

/* Records the measured ticks of a scene in which the hands rest or keep feeding the tools. */
static void record(const scene *s, budget_case *c)
{
    if (output.contact_count < s->contacts) bench_fail("the scene has fewer contacts than its row says");
    crn_state_save(&state, state_of(c));
    for (c->ticks = 0; c->ticks < MEASURED_TICKS; c->ticks++) {
        if (s->motion == INSERTS) feed(-FEED_m_q30);
        if (s->motion == SLIDES) slide();
        inputs[c->ticks] = input;
        crn_step(&model, &state, &input, &output);
    }
    memcpy(c->hash_lane, output.hash_lane, sizeof c->hash_lane);
}

/* Of all ticks with a second solve, records the tick that has the most contacts, and the tick before it.
 * Prints the number of ticks that had a second solve. */
static void record_worst(budget_case *c)
{
    size_t bytes = crn_state_bytes();
    uint8_t *before = calloc(2, bytes); /* the states before this tick and the last one */
    crn_input last = input;
    int32_t middle_m_q30 = input.hands[0].feed_m_q30;
    uint32_t twice = 0, most = 0;
    for (uint32_t tick = 0; tick < DRIVE_TICKS; tick++) {
        crn_input hand = drive(tick, middle_m_q30);
        crn_state_save(&state, before + tick % 2 * bytes);
        crn_step(&model, &state, &hand, &output);
        bool first = twice == 0;
        if (output.solve_count > 1 && tick > 0) {
            twice++;
            if (first || output.contact_count > most) {
                most = output.contact_count;
                c->ticks = 2;
                inputs[0] = last;
                inputs[1] = hand;
                memcpy(state_of(c), before + (tick + 1) % 2 * bytes, bytes);
                memcpy(c->hash_lane, output.hash_lane, sizeof c->hash_lane);
            }
        }
        last = hand;
    }
    printf("second_solves %u of %d contacts %u\n", twice, DRIVE_TICKS, most);
    if (twice == 0) bench_fail("no tick needed a second solve");
    free(before);
}

static int make(const scene *s, const char *path)
{
    uint32_t bytes;
    budget_case *c = make_case(s, &bytes);
    if (!budget_build(c, &lumen, &model)) bench_fail("no model");
    crn_state_init(&model, &state, (const uint32_t[CRN_TOOL_MAX]){50000, 49000, 48000});
    insert(s);
    fprintf(stderr, "%s: %u free nodes, %u contacts\n", s->context, crn_state_free_count(&state),
            output.contact_count);
    if (s->motion == DRIVEN) {
        record_worst(c);
    } else {
        record(s, c);
    }
    memcpy(state_of(c) + c->state_bytes, inputs, sizeof inputs);
    FILE *file = fopen(path, "wb");
    if (file == NULL || fwrite(c, bytes, 1, file) != 1 || fclose(file) != 0)
        bench_fail("the case cannot be written");
    free(c);
    return 0;
}

int main(int argc, char **argv)
{
    if (argc == 2 && strcmp(argv[1], "list") == 0) {
        for (int i = 0; i < SCENES; i++) printf("%s\n", scenes[i].context);
        return 0;
    }
    if (argc == 4 && strcmp(argv[1], "make") == 0 && atoi(argv[2]) >= 0 && atoi(argv[2]) < SCENES) {
        return make(&scenes[atoi(argv[2])], argv[3]);
    }
    fprintf(stderr, "usage: %s list | make CASE FILE   (CASE: 0 to %d)\n", argv[0], SCENES - 1);
    return 2;
}
