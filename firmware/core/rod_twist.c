/* The quasi-static twist of every tool, at the predicted configuration.
 *
 * Unknown turns theta of a tool's edges minimise sum k/2 (m + theta[i] - theta[i-1])^2 plus the bending energy's
 * dependence on the rest curvature, which turns with the frames: this is how a J tip follows the hand. Friction resists:
 * that of the wall on the tool that touches it, and that between a tool and the next one. One tridiagonal solve per tool
 * from its tip to the base; the inserter's edge is held at the hand's angle, so torque reaches the tip within the tick
 * (docs/rod.md, "twist"). May include: rod.h. Called by: core_step.c. */
#include "firmware/core/rod.h"

enum {
    ANGLE_STEP_MAX_Q30 = 1 << 29, /* correction of one edge in one tick: 0.5 rad */
    HALF_PI_Q30 = 1686629713,
    TWO_OVER_PI_Q30 = 683565276,
    NEW_EDGES_MAX = 8, /* edges that a tool's tip can pass in one tick */
};

/* Twist of a joint. Format: difference of binary angles -> Q30 rad, saturated at 2 rad (114 degrees in one joint). */
static int32_t joint_angle(uint32_t ahead_turn32, uint32_t here_turn32)
{
    return seld_mul_q30((int32_t)(here_turn32 - ahead_turn32), HALF_PI_Q30);
}

/* What tool k's rest curvature adds to the twist equations of the two edges of joint i: torque W b.(t x half) on the
 * right, max(0, W b.half) on the diagonal. */
static void curvature_torque(const seld_state *state, uint32_t k, uint32_t i, int32_t *torque_N_m_q30,
                             int32_t *stiffness_q26)
{
    const seld_joint *joint = seld_rod_joint(state, i);
    const seld_node_state *node = &state->words.nodes[i];
    const seld_work *work = &state->scratch.nodes[i];
    seld_vec3 bend = seld_vec3_sub(work->u.a.stretch_q30, work[-1].u.a.stretch_q30);
    for (int side = 0; side < 2; side++) {
        seld_vec3 half;
        seld_rod_rest_turn(joint, k, state->words.release_q30, &work[side - 1].u.a.axis1_q30[k],
                           &node[side - 1].tangent_q30, &half);
        seld_vec3 turned = seld_vec3_cross_unit(&node[side - 1].tangent_q30, &half);
        int32_t lever = seld_sat32(seld_rshift_round64(seld_vec3_dot64(bend, turned), 30));
        int32_t hold = seld_sat32(seld_rshift_round64(seld_vec3_dot64(bend, half), 30));
        torque_N_m_q30[side] = seld_mul(lever, joint->bend_N_m_q26, 26);
        stiffness_q26[side] = hold > 0 ? seld_mul_q30(joint->bend_N_m_q26, hold) : 0;
    }
}

/* What resists the turn theta of an edge: torque - stiffness theta. */
typedef struct resistance {
    int32_t torque_N_m_q30, stiffness_q26;
} resistance;

/* The wall's friction on the tool that touches it: the surface moves by r theta along n x t besides its way along the
 * wall, all against one bristle (rod_contact.c). Format: Q(a) N/m x Q30 m x Q33 m -> Q30 N m. */
static void wall_resistance(const seld_model *model, const seld_state *state, uint32_t j, resistance *sum)
{
    const seld_work *work = &state->scratch.nodes[j];
    int64_t radius = state->line.nodes[j].radius_m_q30;
    unsigned exponent = model->stiffness_exponent;
    int64_t reach = work->u.a.around_reach_m_q33;
    /* k_f r in N Q22: at most 2000 N/m x 2 mm; k_f r^2 from r^2 in Q44 */
    int64_t lever = ((int64_t)work->wall_friction * radius) >> (exponent + 8);
    sum->torque_N_m_q30 = seld_sat32(sum->torque_N_m_q30 - seld_rshift_round64(lever * reach, 25));
    sum->stiffness_q26 += (int32_t)((work->wall_friction * ((radius * radius) >> 16)) >> (exponent + 18));
}

/* Friction between tool `pair` and the next one at edge j, on the inner tool; `limit` is mu N r. */
static resistance pair_resistance(const seld_state *state, uint32_t pair, uint32_t j, int32_t limit_N_m_q30)
{
    const seld_node_state *node = &state->words.nodes[j];
    int64_t reach = (int64_t)node->grip_q30[pair] + node->spin_q30[pair] - node->spin_q30[pair + 1];
    int32_t size = seld_sat32(reach < 0 ? -reach : reach);
    int32_t stiffness = SELD_GRIP_STIFFNESS_N_M_Q26;
    if (size > 0) {
        int32_t secant = seld_quotient(limit_N_m_q30, size, 26);
        stiffness = secant < stiffness ? secant : stiffness;
    }
    return (resistance){seld_mul(stiffness, node->grip_q30[pair], 26), stiffness};
}

/* Friction on tool k at edge j: between it and its neighbours (the other's turn is the newest known), and of the wall. */
static resistance edge_resistance(const seld_model *model, const seld_state *state, uint32_t k, uint32_t j)
{
    const seld_node_state *node = &state->words.nodes[j];
    const seld_work *work = &state->scratch.nodes[j];
    resistance sum = {0, 0};
    if (work->touching && state->line.nodes[j].outer == k) {
        wall_resistance(model, state, j, &sum);
    }
    if (k + 1 < model->tool_count && work->u.a.press_N_m_q30[k] > 0) {
        resistance grip = pair_resistance(state, k, j, work->u.a.press_N_m_q30[k]);
        int32_t carried = seld_mul(grip.stiffness_q26, node->spin_q30[k + 1], 26);
        sum.torque_N_m_q30 = seld_sat32((int64_t)sum.torque_N_m_q30 - grip.torque_N_m_q30 + carried);
        sum.stiffness_q26 += grip.stiffness_q26;
    }
    if (k > 0 && work->u.a.press_N_m_q30[k - 1] > 0) {
        resistance grip = pair_resistance(state, k - 1, j, work->u.a.press_N_m_q30[k - 1]);
        int32_t carried = seld_mul(grip.stiffness_q26, node->spin_q30[k - 1], 26);
        sum.torque_N_m_q30 = seld_sat32((int64_t)sum.torque_N_m_q30 + grip.torque_N_m_q30 + carried);
        sum.stiffness_q26 += grip.stiffness_q26;
    }
    if (j == 0 && k == 0 && model->hold.turn) {
        int32_t miss = (int32_t)(model->hold.turn32 - node->angle_turn32[0]);
        sum.torque_N_m_q30 =
            seld_sat32((int64_t)sum.torque_N_m_q30 + 16 * (int64_t)seld_mul_q30(miss, HALF_PI_Q30));
        sum.stiffness_q26 += 16 << 26;
    }
    return sum;
}

/* value / pivot, the pivot given by its leading zeros and reciprocal. Format: with both in one Q and q = 30 a ratio in
 * Q30; value in Q30 N m over Q26 N m with q = 26 an angle in Q30. */
static int32_t over_pivot(int32_t value, int64_t reciprocal_q30, unsigned lead, unsigned q)
{
    return seld_sat32(seld_rshift_round64(value * reciprocal_q30, 62 - lead - q));
}

/* What elimination hands from one edge to the next. */
typedef struct twist_carry {
    int32_t coupling_q26, moment;        /* k and k m of the joint ahead */
    int32_t curve_torque, curve_q26;     /* curvature terms of this edge from the joint ahead */
    int32_t reduced_q26, reduced_torque; /* what eliminating the edge ahead leaves here */
} twist_carry;

/* Row of edge j of tool k. Pivots and couplings in Q26 N m, right side in Q30 N m, angles in Q30 rad. */
static void eliminate_edge(const seld_model *model, seld_state *state, uint32_t k, uint32_t j,
                           twist_carry *carry)
{
    const seld_joint *joint = seld_rod_joint(state, j + 1);
    const seld_node_state *node = &state->words.nodes[j];
    seld_assembly *work = &state->scratch.nodes[j].u.a;
    int32_t next = joint->twist_N_m_q26[k];
    int32_t angle = joint_angle(node->angle_turn32[k], node[1].angle_turn32[k]);
    int32_t moment = seld_mul(next, angle, 26);
    int32_t curve_torque[2] = {0, 0};
    int32_t curve_q26[2] = {0, 0};
    if (joint->curved >> k & 1u) {
        curvature_torque(state, k, j + 1, curve_torque, curve_q26);
    }
    resistance friction = edge_resistance(model, state, k, j);
    int64_t pivot = (int64_t)carry->coupling_q26 + next + SELD_SPIN_DRAG_N_M_Q26 + carry->curve_q26 +
                    curve_q26[0] + friction.stiffness_q26 - carry->reduced_q26;
    pivot = pivot > INT32_MAX ? INT32_MAX : pivot;
    int32_t right = seld_sat32((int64_t)moment - carry->moment + carry->curve_torque + curve_torque[0] +
                               friction.torque_N_m_q30 + carry->reduced_torque);
    unsigned lead = seld_clz32((uint32_t)pivot);
    int64_t reciprocal = seld_reciprocal_q30((uint32_t)pivot << lead >> 1);
    int32_t ratio = over_pivot(next, reciprocal, lead, 30);
    work->joint_angle_q30 = angle; /* of joint j + 1 */
    work->twist_ratio_q30 = ratio;
    work->twist_angle_q30 = over_pivot(right, reciprocal, lead, 26);
    /* ratio <= 1: the pivot is the coupling and more */
    *carry = (twist_carry){next,
                           moment,
                           curve_torque[1],
                           curve_q26[1],
                           seld_scale_q30(next, ratio),
                           seld_scale_q30(right, ratio)};
}

/* Turns edge j of tool k and, where the rest shape needs it, its material axis: d1 (1 - a^2/2) + d2 a. */
static void turn_edge(seld_state *state, uint32_t k, uint32_t j, int32_t angle_q30)
{
    seld_node_state *node = &state->words.nodes[j];
    seld_work *work = &state->scratch.nodes[j];
    node->angle_turn32[k] += (uint32_t)seld_scale_q30(angle_q30, TWO_OVER_PI_Q30);
    node->spin_q30[k] = angle_q30;
    if (state->line.nodes[j].outer == k) {
        work->roll_m_q33 = seld_surface_way(state->line.nodes[j].radius_m_q30, angle_q30);
    }
    if ((seld_edge_curved(state, j) >> k & 1u) == 0) {
        return;
    }
    seld_vec3 *axis1 = &work->u.a.axis1_q30[k];
    seld_vec3 axis2 = seld_vec3_cross_unit(&node->tangent_q30, axis1);
    int32_t cosine = SELD_ONE_Q30 - (seld_scale_q30(angle_q30, angle_q30) >> 1);
    for (int c = 0; c < 3; c++) {
        axis1->v[c] = seld_scale_q30(axis1->v[c], cosine) + seld_scale_q30(axis2.v[c], angle_q30);
    }
    seld_frames_orthonormalise(axis1, &node->tangent_q30);
}

/* From the base to tool k's tip; edges that the tip is about to reach take the frame of its last edge. */
static void substitute(seld_state *state, uint32_t k, uint32_t first)
{
    int32_t behind = 0; /* turn of the edge nearer the base */
    for (uint32_t n = state->words.free_count; n > first; n--) {
        seld_work *work = &state->scratch.nodes[n - 1];
        int64_t angle =
            work->u.a.twist_angle_q30 + (int64_t)seld_scale_q30(behind, work->u.a.twist_ratio_q30);
        int32_t turn = angle > ANGLE_STEP_MAX_Q30
                           ? ANGLE_STEP_MAX_Q30
                           : (angle < -ANGLE_STEP_MAX_Q30 ? -ANGLE_STEP_MAX_Q30 : (int32_t)angle);
        int64_t after = (int64_t)work->u.a.joint_angle_q30 + behind - turn;
        int32_t torque = seld_mul(seld_rod_joint(state, n)->twist_N_m_q26[k], seld_sat32(after), 26);
        work[1].torque_N_m_q30 = seld_add_sat(work[1].torque_N_m_q30, torque);
        if (n == state->words.free_count) {
            state->scratch.torque_N_m_q30[k] = torque;
        }
        turn_edge(state, k, n - 1, turn);
        behind = turn;
    }
    for (uint32_t n = first; n > 0 && n + NEW_EDGES_MAX > first; n--) {
        state->words.nodes[n - 1].angle_turn32[k] = state->words.nodes[first].angle_turn32[k];
        state->words.nodes[n - 1].spin_q30[k] = behind;
    }
}

/* The edge that tool k's tip lies in; free_count when the tool is still in the inserter. */
static uint32_t tip_edge(const seld_model *model, const seld_state *state, uint32_t k)
{
    uint32_t j = 0;
    while (j < state->words.free_count && model->mesh[j + 1].arc_m_q30 <= state->line.offset_m_q30[k]) {
        j++;
    }
    return j;
}

void seld_rod_twist(const seld_model *model, seld_state *state)
{
    uint32_t na = state->words.free_count;
    for (uint32_t i = 0; i <= na; i++) {
        state->scratch.nodes[i].torque_N_m_q30 = 0;
        state->scratch.nodes[i].roll_m_q33 = 0;
    }
    for (uint32_t k = 0; k < model->tool_count; k++) {
        twist_carry carry = {0, 0, 0, 0, 0, 0};
        uint32_t first = tip_edge(model, state, k);
        state->scratch.torque_N_m_q30[k] = 0;
        for (uint32_t j = first; j < na; j++) {
            eliminate_edge(model, state, k, j, &carry);
        }
        substitute(state, k, first);
    }
}
