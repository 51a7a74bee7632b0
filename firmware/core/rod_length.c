/* This file makes edges of the mesh keep their length while they turn fast (docs/rod.md, "Turning edges"),
 * moves the nodes after the solve, and computes the length error. If
 * both ends of an edge move along straight lines while the edge turns by a small angle, the edge gets longer
 * by the fraction angle^2 / 2. In a tool with an axial stiffness of some kN, the elongation of a turning edge
 * would cause a tension of many newtons. To take back the excess length, the code moves the nodes between the
 * edge and the tip along the turned edge towards the hand. */
#include "firmware/core/rod.h"

enum {
    EXCESS_MAX_Q30 = CRN_ONE_Q30 / 4, /* most that is taken back from one edge in one tick */
    /* 0.49 mm in each direction, for all edges: once in the slide and once in the solve */
    SHIFT_MAX_M_Q33 = 1 << 22,
};

/* Adds the displacement `way_m_q33` in the direction `along_q30` to the shift of the nodes nearer to the tip.
 * Overflow is impossible: the sum is limited, and its two terms are below 2^31 - 2^22. */
static void shift_on(crn_vec3 *shift_m_q33, int32_t way_m_q33, const crn_vec3 *along_q30)
{
    for (int k = 0; k < 3; k++) {
        shift_m_q33->v[k] = crn_clamp(shift_m_q33->v[k] + crn_scale_q30(way_m_q33, along_q30->v[k]),
                                      -SHIFT_MAX_M_Q33, SHIFT_MAX_M_Q33);
    }
}

/* Returns a displacement that is a fraction of an edge's length. Format: Q30 x Q30 m -> Q33 m. Overflow is
 * impossible, because an edge's length is below 2^25 and the fraction is at most 0.4. */
static int32_t way_of(int32_t part_q30, int32_t length_m_q30)
{
    return crn_mulh(part_q30, length_m_q30 * 32);
}

/* Returns one component of an edge vector divided by the edge's unstretched length. Format: Q30 m x Q18 1/m
 * -> Q30. Overflow: the result saturates; the 64-bit sum of two such results is still correct. */
static int32_t over_length(int32_t from_m_q30, int32_t to_m_q30, int32_t inverse_per_m_q18)
{
    return crn_sat32(crn_asr64((int64_t)crn_sub_sat(to_m_q30, from_m_q30) * inverse_per_m_q18, 18));
}

void crn_slide_keep_length(const crn_model *model, const crn_state *state, uint32_t i,
                           const crn_vec3 *slide_m_q33, crn_vec3 *shift_m_q33)
{
    const crn_vec3 *from = &state->words.nodes[i].position_m_q30,
                   *to = &state->words.nodes[i + 1].position_m_q30;
    const crn_vec3 *ahead = &state->scratch.nodes[i + 1].position_m_q30;
    const int32_t inverse = model->mesh[i].inverse_length_per_m_q18;
    int64_t excess_q30 = 0; /* (|w*|^2 - |w|^2) / 2 */
    crn_vec3 w;
    for (int k = 0; k < 3; k++) {
        const int32_t before = over_length(from->v[k], to->v[k], inverse);
        w.v[k] = over_length(from->v[k] + ((slide_m_q33->v[k] + 4) >> 3), ahead->v[k], inverse);
        excess_q30 += crn_asr64(((int64_t)w.v[k] - before) * ((int64_t)w.v[k] + before) / 2, 30);
    }
    const int32_t e = crn_clamp(crn_sat32(excess_q30), -EXCESS_MAX_Q30, EXCESS_MAX_Q30);
    /* 1 - 1 / sqrt(1 + 2 e) of w, by its series; off by 3 % at 1/4, 0.04 % at 0.1 */
    const int32_t square = crn_scale_q30(e, e);
    const int32_t part = e - square - square / 2 + crn_scale_q30(square, e) / 2 * 5;
    shift_on(shift_m_q33, way_of(part, model->mesh[i].length_m_q30), &w);
}

/* Returns whether the deviations of an edge's two ends differ along any axis by more than a sixteenth of the
 * edge's length. If the deviations of an edge's ends differ by less than a sixteenth of the edge's length,
 * the edge gets 0.4 % longer at most. */
static inline bool is_fast(const crn_vec3 *front_m_q33, const crn_vec3 *end_m_q33, int32_t length_m_q30)
{
    const int32_t most = length_m_q30 / 2; /* a sixteenth in Q33 */
    uint32_t beyond = 0;
    for (int k = 0; k < 3; k++) {
        const int32_t way = end_m_q33->v[k] - front_m_q33->v[k];
        beyond |= (uint32_t)(most - way) | (uint32_t)(most + way);
    }
    return beyond >> 31 != 0;
}

/* Returns the rotation of an edge that results from the deviations found by the solve at its two ends. The
 * rotation is the displacement of the edge's rear end relative to its front end, divided by the edge's
 * length. Each component of the rotation is a ratio of two lengths, and is at most 1. */
static crn_vec3 turn_of(const crn_model *model, uint32_t i, const crn_vec3 *front_m_q33,
                        const crn_vec3 *end_m_q33)
{
    crn_vec3 turn_q30;
    for (int k = 0; k < 3; k++) {
        const int64_t way =
            (int64_t)(end_m_q33->v[k] - front_m_q33->v[k]) * model->mesh[i].inverse_length_per_m_q18;
        turn_q30.v[k] = crn_clamp(crn_sat32(crn_asr64(way, 21)), -CRN_ONE_Q30, CRN_ONE_Q30);
    }
    return turn_q30;
}

/* Takes back the length that edge i gains by turning, along the direction that the edge has after turning. An
 * edge that turns by an angle gains the fraction angle^2 / 2 of its length. */
CRN_RARE static void take_back(const crn_model *model, crn_state *state, uint32_t i,
                               const crn_vec3 *front_m_q33, const crn_vec3 *end_m_q33, crn_vec3 *shift_m_q33)
{
    const crn_vec3 turn = turn_of(model, i, front_m_q33, end_m_q33);
    const crn_vec3 *t = &state->words.nodes[i].tangent_q30;
    const int32_t along = crn_vec3_dot_unit(&turn, t);
    const int64_t square = crn_vec3_dot64(turn, turn) - crn_product(along, along);
    const int32_t part = crn_clamp(crn_sat32(crn_asr64(square, 31)), 0, EXCESS_MAX_Q30);
    const int32_t way = way_of(part, model->mesh[i].length_m_q30);
    crn_vec3 ended;
    for (int k = 0; k < 3; k++) {
        ended.v[k] = crn_add_sat(t->v[k], turn.v[k]);
    }
    shift_on(shift_m_q33, way, &ended);
    state->scratch.kept_m_q33 = crn_add_sat(state->scratch.kept_m_q33, way);
}

void crn_rod_keep_lengths(const crn_model *model, crn_state *state, int32_t largest_m_q33)
{
    state->scratch.kept_m_q33 = 0;
    if (largest_m_q33 < CRN_STEP_CAP_M_Q33 / 10) {
        return; /* an edge of 1 mm gets 1 % longer at most */
    }
    crn_vec3 shift = {{0, 0, 0}}, end = state->scratch.nodes[state->words.free_count - 1].solution_m_q33;
    for (uint32_t i = state->words.free_count - 1; i-- > 0;) {
        crn_vec3 *solution = &state->scratch.nodes[i].solution_m_q33;
        const crn_vec3 front = *solution;
        if (is_fast(&front, &end, model->mesh[i].length_m_q30)) {
            take_back(model, state, i, &front, &end, &shift);
        }
        if (state->scratch.kept_m_q33 != 0) {
            *solution = crn_vec3_add(front, shift);
        }
        end = front;
    }
}

/* --- after the solve ------------------------------------------------------------------------------------ */

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
