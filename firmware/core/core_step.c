/* One tick, part by part (docs/tick.md follows it through the code).
 * May include: rod.h. Called by: firmware/app, tools, tests through core.h. */
#include "firmware/core/rod.h"

/* Force the rod exerts on the two nodes held by the inserter, after the solve: f - A delta, along the axis.
 * Bending is part of it: the edge force alone jumps when a node is freed and reads low with a bent mouth
 * (docs/rod.md). */
static int32_t handle_axial(const seld_model *model, const seld_state *state)
{
    uint32_t na = state->words.free_count;
    const seld_work *work = state->scratch.nodes;
    const int32_t *s = work[na - 1].spring.m;
    int64_t off = work[na - 1].off_diagonal;
    const int64_t row[9] = {off - s[0], -s[1], -s[2], -s[1], off - s[3], -s[4], -s[2], -s[4], off - s[5]};
    const int32_t *near = work[na - 1].solution_m_q33.v;
    const int32_t *far = work[na - 2].solution_m_q33.v;
    unsigned shift = model->stiffness_exponent + 11;
    int64_t axial = 0;
    for (int k = 0; k < 3; k++) {
        int64_t moved = row[3 * k] * near[0] + row[3 * k + 1] * near[1] + row[3 * k + 2] * near[2];
        moved += (int64_t)work[na - 2].off_second * far[k] + (int64_t)work[na - 1].off_second * near[k];
        int64_t force = (int64_t)work[na].force_N_q22.v[k] + work[na + 1].force_N_q22.v[k];
        force -= seld_rshift_round64(moved, shift);
        axial -= force * model->entry.direction_q30.v[k];
    }
    return seld_sat32(seld_rshift_round64(axial, 30));
}

/* Largest component of any node's deviation, Q33 m. */
static int32_t largest_deviation(const seld_state *state)
{
    int32_t largest = 0;
    for (uint32_t i = 0; i < state->words.free_count; i++) {
        for (int k = 0; k < 3; k++) {
            int32_t part = state->scratch.nodes[i].solution_m_q33.v[k];
            part = part < 0 ? -part : part;
            largest = part > largest ? part : largest;
        }
    }
    return largest;
}

/* Scales the whole deviation when a node would move more than max(0.5 mm, 3 feeds) beyond the slide: one factor for
 * all nodes keeps the shape; per-node caps add energy (docs/rod.md, "contact"). */
static void cap_step(seld_state *state, int32_t largest_m_q33)
{
    int32_t feed = state->scratch.feed_m_q33 < 0 ? -state->scratch.feed_m_q33 : state->scratch.feed_m_q33;
    int32_t cap = 3 * feed > SELD_STEP_CAP_M_Q33 ? 3 * feed : SELD_STEP_CAP_M_Q33;
    if (largest_m_q33 <= cap) {
        return;
    }
    state->words.fault_bits |= SELD_FAULT_STEP_CAPPED;
    int32_t factor_q30 = seld_quotient(cap, largest_m_q33, 30);
    for (uint32_t i = 0; i < state->words.free_count; i++) {
        for (int k = 0; k < 3; k++) {
            int32_t *part = &state->scratch.nodes[i].solution_m_q33.v[k];
            *part = seld_scale_q30(*part, factor_q30);
        }
    }
}

void seld_step(const seld_model *model, seld_state *state, const seld_input *input, seld_output *output)
{
    seld_rod_feed(model, state, input);
    seld_rod_stretch(model, state);
    seld_rod_twist(model, state);
    seld_rod_bend(model, state);
    seld_contact_assemble(model, state);
    seld_rod_solve(model, state);
    output->solve_count = 1;
    int32_t largest_m_q33 = largest_deviation(state);
    if (seld_contact_missed(model, state, largest_m_q33) > 0) {
        seld_rod_solve(model, state);
        output->solve_count = 2;
        largest_m_q33 = largest_deviation(state);
    }
    state->words.handle_axial_N_q22 = handle_axial(model, state);
    cap_step(state, largest_m_q33);
    seld_contact_finish(model, state, output);
    seld_rod_advance(model, state, output);
    state->words.feed_m_q33 = state->scratch.feed_m_q33;
    state->words.tick++;

    output->tick = state->words.tick;
    output->handle_axial_N_q22 = state->words.handle_axial_N_q22;
    output->handle_torque_N_m_q24 = -(state->scratch.nodes[state->words.free_count].torque_N_m_q30 / 64);
    output->inserted_m_q30 = state->words.inserted_m_q30;
    output->fault_bits = state->words.fault_bits;
    seld_state_hash_lanes(state, output->hash_lane);
}
