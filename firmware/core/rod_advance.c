/* This file moves the nodes of the mesh after the solve and computes the length error. */
#include "firmware/core/rod.h"

/* Limits a node's coordinate to +-1.98 m, so that a tick's slide can be added without overflow. A node
 * reaches the limit of 1.98 m only in a scene without walls. The sum cannot overflow, because a tick's motion
 * is below 2^22 in Q30. */
static int32_t limit_position(int32_t m_q30)
{
    return crn_clamp(m_q30, -CRN_POSITION_MAX_M_Q30, CRN_POSITION_MAX_M_Q30);
}

static void move_node(crn_state *state, uint32_t i)
{
    crn_node_state *node = &state->words.nodes[i];
    const crn_work *work = &state->scratch.nodes[i];
    for (int k = 0; k < 3; k++) {
        int32_t step = work->solution_m_q33.v[k] + work->slide_m_q33.v[k];
        node->step_m_q33.v[k] = step;
        node->position_m_q30.v[k] = limit_position(node->position_m_q30.v[k] + ((step + 4) >> 3));
    }
}

/* Returns the elongation of all free edges together. The result is the sum of three parts: the elongation at
 * the predicted configuration x*, the terms t . (delta[i+1] - delta[i]) of the solve's deviations, and the
 * length that rod_length.c took back because edges turned. Edges that turn too slowly for the correction in
 * rod_length.c get longer by the fraction angle^2 / 2, which is below 0.4 % and is not counted in the
 * elongation. Format: sum of Q33 m in 64 bits. Overflow is impossible, because the length of an edge is below
 * 2^25 in Q30 m. */
static int64_t elongation_m_q33(const crn_model *model, const crn_state *state)
{
    int64_t sum = state->scratch.kept_m_q33;
    for (uint32_t i = 0; i < state->words.free_count; i++) {
        const crn_work *work = &state->scratch.nodes[i];
        const crn_vec3 *t = &state->words.nodes[i].tangent_q30;
        crn_vec3 relative = {{work[1].solution_m_q33.v[0] - work->solution_m_q33.v[0],
                              work[1].solution_m_q33.v[1] - work->solution_m_q33.v[1],
                              work[1].solution_m_q33.v[2] - work->solution_m_q33.v[2]}};
        int32_t ahead = crn_mulh(work->strain_q30, model->mesh[i].length_m_q30 * 32);
        sum += ahead + crn_vec3_dot_unit(&relative, t);
    }
    return sum;
}

void crn_rod_advance(const crn_model *model, crn_state *state, crn_output *output)
{
    uint32_t na = state->words.free_count;
    int32_t excess_m_q30 = crn_sat32(crn_rshift_round64(elongation_m_q33(model, state), 3));
    output->strain_max_q30 = crn_quotient(excess_m_q30, model->mesh[na].arc_m_q30, 30);
    for (uint32_t i = 0; i < na; i++) {
        move_node(state, i);
    }
}
