/* Simulates, in our core, the moving task of tools/lab/peers/moving_task.py (docs/bench.md, "Peers on a
 * moving wire"): a wire is pushed and turned into a bent vessel of 4 mm radius. The script run_moving.py
 * states the task on the command line, and compares the line that this program prints with those of other
 * simulators.
 *
 *   peer_moving key=value ...     every key of `fields` once, in SI units */
#include "firmware/bench/bench.h"
#include "firmware/core/core.h"
#include "firmware/tests/reference/tube_lumen.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

typedef struct moving_task {
    double start_m, push_m_per_s, turn_rad_per_s, duration_s, samples;
    double radius_m, straight_m, bend_radius_m, bend_rad, end_m;
    double stiffness_N_m2, mass_kg_per_m, wire_radius_m, wire_m, element_m, friction;
} moving_task;

typedef struct field {
    const char *name;
    size_t offset;
} field;
#define FIELD(name)                                                                                          \
    {                                                                                                        \
#name, offsetof(moving_task, name)                                                                   \
    }
static const field fields[] = {
    FIELD(start_m),       FIELD(push_m_per_s), FIELD(turn_rad_per_s), FIELD(duration_s),
    FIELD(samples),       FIELD(radius_m),     FIELD(straight_m),     FIELD(bend_radius_m),
    FIELD(bend_rad),      FIELD(end_m),        FIELD(stiffness_N_m2), FIELD(mass_kg_per_m),
    FIELD(wire_radius_m), FIELD(wire_m),       FIELD(element_m),      FIELD(friction),
};
enum { FIELDS = sizeof fields / sizeof fields[0], SPARE_ELEMENTS = 8, TICKS_PER_S = 1000 };

/* Reads one argument key=value into the task; returns false for an unknown or repeated key, or for a value
 * that is not a positive number. */
static int read_field(moving_task *task, const char *argument)
{
    const char *equals = strchr(argument, '=');
    if (equals == NULL) return 0;
    for (size_t i = 0; i < FIELDS; i++) {
        if (strncmp(fields[i].name, argument, (size_t)(equals - argument)) != 0) continue;
        if (strlen(fields[i].name) != (size_t)(equals - argument)) continue;
        char *end;
        double value = strtod(equals + 1, &end), before;
        memcpy(&before, (const char *)task + fields[i].offset, sizeof before);
        if (before != 0) return 0; /* the key stands here twice */
        memcpy((char *)task + fields[i].offset, &value, sizeof value);
        return end != equals + 1 && *end == 0 && value > 0 && value < 1e6;
    }
    return 0;
}

static int read_task(moving_task *task, int argc, char **argv)
{
    for (int i = 1; i < argc; i++)
        if (!read_field(task, argv[i])) return 0;
    for (size_t i = 0; i < FIELDS; i++) {
        double value;
        memcpy(&value, (const char *)task + fields[i].offset, sizeof value);
        if (value == 0) return 0;
    }
    return task->samples >= 1 && task->samples == floor(task->samples) &&
           task->samples <= task->duration_s * TICKS_PER_S;
}

static crn_instrument wire_of(const moving_task *task)
{
    uint32_t element_um = (uint32_t)lround(task->element_m * 1e6);
    uint32_t length_um = (uint32_t)lround(task->wire_m * 1e6) + SPARE_ELEMENTS * element_um;
    crn_instrument wire = reference_wire(task->stiffness_N_m2, length_um, element_um, task->friction);
    for (int i = 0; i < 2; i++) {
        wire.knots[i].mass_mg_per_m = (uint32_t)lround(task->mass_kg_per_m * 1e6);
        wire.knots[i].radius_outer_um = (uint32_t)lround(task->wire_radius_m * 1e6);
    }
    return wire;
}

static crn_input hand_at(const moving_task *task, int tick)
{
    const double turn_rad = 6.283185307179586, time_s = (double)tick / TICKS_PER_S;
    crn_input input = {0};
    input.hands[0].feed_m_q30 = (int32_t)lround(task->push_m_per_s * time_s * CRN_ONE_Q30);
    input.hands[0].turn32 =
        (uint32_t)(int64_t)llround(task->turn_rad_per_s * time_s / turn_rad * 4294967296.0);
    return input;
}

/* What the run showed: the processor time of its ticks, the deepest contact, the largest length error. */
typedef struct findings {
    double processor_s, penetration_mm, length_error_pct;
    unsigned contacts, faults;
} findings;

static void note(findings *found, const crn_output *output)
{
    double depth_mm = output->penetration_max_m_q30 / 1073741.824;
    double error_pct = fabs(output->strain_max_q30 / 1073741824.0) * 100;
    if (depth_mm > found->penetration_mm) found->penetration_mm = depth_mm;
    if (error_pct > found->length_error_pct) found->length_error_pct = error_pct;
    if (output->contact_count > found->contacts) found->contacts = output->contact_count;
    if (output->fault_bits != 0) found->faults = 1;
}

static findings run(const moving_task *task, const crn_model *model, crn_state *state)
{
    findings found = {0};
    int samples = (int)task->samples;
    int per_sample = (int)lround(task->duration_s * TICKS_PER_S / samples);
    printf("tips_mm=");
    for (int sample = 0; sample < samples; sample++) {
        clock_t begin = clock();
        for (int k = 1; k <= per_sample; k++) {
            crn_output output;
            crn_input input = hand_at(task, sample * per_sample + k);
            crn_step(model, state, &input, &output);
            note(&found, &output);
        }
        found.processor_s += (double)(clock() - begin) / CLOCKS_PER_SEC;
        crn_vec3 tip = crn_state_position(state, 0);
        printf("%s%.4f,%.4f,%.4f", sample ? ";" : "", tip.v[0] / 1073741.824, tip.v[1] / 1073741.824,
               tip.v[2] / 1073741.824);
    }
    return found;
}

int main(int argc, char **argv)
{
    moving_task task = {0};
    if (!read_task(&task, argc, argv)) {
        fprintf(stderr, "usage: %s key=value ..., each key once, with a positive value:", argv[0]);
        for (size_t i = 0; i < FIELDS; i++) fprintf(stderr, " %s", fields[i].name);
        fprintf(stderr, "\n");
        return 2;
    }
    const reference_piece pieces[] = {
        {task.straight_m, 0, 0}, {task.bend_radius_m * task.bend_rad, task.bend_rad, 0}, {task.end_m, 0, 0}};
    reference_tube *tube = reference_tube_make(pieces, 3, task.radius_m, 1);
    crn_instrument wire = wire_of(&task);
    crn_entry entry = reference_entry();
    crn_model *model = malloc(crn_model_size());
    crn_state *state = malloc(crn_state_size());
    crn_build_place place;
    if (model == NULL || state == NULL) bench_fail("no memory for the model");
    if (crn_model_build(model, &wire, 1, &tube->lumen, &entry, &place) != CRN_BUILD_OK)
        bench_fail("the core refuses the model of the task");
    crn_state_init(model, state, &(uint32_t){(uint32_t)lround(task.start_m * 1e6)});
    findings found = run(&task, model, state);
    printf(" simulated_s=%.6g processor_s=%.6f penetration_mm=%.5f length_error_pct=%.5f warnings=%u "
           "contacts=%u elements=%u "
           "version=%d\n",
           task.duration_s, found.processor_s, found.penetration_mm, found.length_error_pct, found.faults,
           found.contacts, crn_state_free_count(state), CRN_CORE_VERSION);
    free(state);
    free(model);
    reference_tube_free(tube);
    return 0;
}
