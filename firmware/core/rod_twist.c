/* This file computes the axes of the edges and the twist of the tools at the predicted configuration.
 *
 * Each edge has a reference axis u, which all tools share. The code carries the reference axis u over from
 * edge to edge, from the introducer sheath to the tip, without rotation about the tangent (Bishop frame). A
 * tool's material axis is d1 = cos(angle) u + sin(angle) (t x u), where u is the reference axis and t the
 * tangent, so the twist of a joint is simply the difference of two angles (docs/rod.md, "twist").
 *
 * The twist of every tool along its length is quasi-static. The unknown rotations theta of a tool's edges
 * minimise sum k/2 (m + theta[i] - theta[i-1])^2 (k: twist stiffness of a joint, m: its twist before the
 * tick) plus the bending energy. The bending energy depends on the stress-free curvature of a tool, which
 * turns with the tool's frames; this dependence makes a J-shaped tip follow the hand. Two kinds of friction
 * resist the rotation: the friction of the wall on the tool that touches it, and the friction between a tool
 * and the tool around it. The twist of each tool takes one tridiagonal solve, from the tool's tip to the
 * base. The edge in the introducer sheath is held at the angle of the user's hand, so torque from the hand
 * reaches the tip within the same tick (docs/rod.md, "twist"). */
#include "firmware/core/rod.h"

enum {
    LACK_FAST_Q30 = 1 << 28, /* 1 - t.t' up to 1/4 (41 degrees per joint): series for 1 / (1 + t.t') */
    FOLD_Q30 = 1 << 28,      /* 1 + t.t' below 1/4 (beyond 139 degrees): no transport, only a projection */
};

/* All vectors of this file have unit length and all factors are below one, so sums and products fit Q30. */
static void add_scaled(crn_vec3 *sum, const crn_vec3 *direction_q30, int32_t amount)
{
    for (int k = 0; k < 3; k++) {
        sum->v[k] += crn_scale_q30(amount, direction_q30->v[k]);
    }
}

void crn_frames_orthonormalise(crn_vec3 *axis, const crn_vec3 *tangent)
{
    add_scaled(axis, tangent, -crn_vec3_dot_unit(axis, tangent));
    int32_t excess = (int32_t)((crn_vec3_dot64(*axis, *axis) - ((int64_t)1 << 60)) >> 31);
    for (int k = 0; k < 3; k++) {
        axis->v[k] = crn_scale_q30(axis->v[k], CRN_ONE_Q30 - excess);
    }
}

/* Carries the reference axis over to the next edge across a sharp bend. Up to a bend of 139 degrees the axis
 * is transported exactly; beyond that angle the old axis is only projected. */
static crn_vec3 transport_sharply(crn_vec3 axis, const crn_vec3 *from, const crn_vec3 *to, int32_t tilt,
                                  int32_t lack)
{
    uint32_t sum = ((uint32_t)CRN_ONE_Q30 << 1) - (uint32_t)lack; /* 1 + t.t' */
    if (sum < FOLD_Q30) {
        add_scaled(&axis, to, -tilt);
        return crn_vec3_normalise(axis, *from, NULL);
    }
    int32_t ratio_q27 = crn_quotient(tilt, (int32_t)(sum > INT32_MAX ? INT32_MAX : sum), 27);
    for (int k = 0; k < 3; k++) {
        int64_t moved = (int64_t)ratio_q27 * from->v[k] + (int64_t)ratio_q27 * to->v[k];
        axis.v[k] = crn_sat32(axis.v[k] - crn_rshift_round64(moved, 27));
    }
    crn_frames_orthonormalise(&axis, to);
    return axis;
}

/* Returns u - (u.t') / (1 + t.t') (t + t'), which is the parallel transport of the axis u from the tangent t
 * to the tangent t'. */
static crn_vec3 transport(crn_vec3 axis, const crn_vec3 *from, const crn_vec3 *to)
{
    int32_t tilt = crn_vec3_dot_unit(&axis, to);
    int32_t lack = crn_sub_sat(CRN_ONE_Q30, crn_vec3_dot_unit(from, to));
    if (lack > LACK_FAST_Q30) {
        return transport_sharply(axis, from, to, tilt, lack);
    }
    /* 1 / (1 + c) = 1/2 + lack/4 + lack^2/8 + lack^3/16 */
    int32_t square = crn_scale_q30(lack, lack);
    int32_t inverse = (CRN_ONE_Q30 >> 1) + (lack >> 2) + (square >> 3) + (crn_scale_q30(square, lack) >> 4);
    int32_t amount = -crn_scale_q30(tilt, inverse);
    for (int k = 0; k < 3; k++) {
        int32_t middle_q29 = crn_asr32(from->v[k], 1) + crn_asr32(to->v[k], 1); /* half the sum, within one */
        axis.v[k] += crn_mulh(amount, middle_q29) * 8;
    }
    return axis;
}

/* Computes the material axis d1 of an edge from the edge's reference axis and angle. */
static void material_axis(const crn_vec3 *reference, const crn_vec3 *tangent, uint32_t angle_turn32,
                          crn_vec3 *axis1)
{
    int32_t sine, cosine;
    crn_sincos_turn32(angle_turn32, &sine, &cosine);
    crn_vec3 across = crn_vec3_cross_unit(tangent, reference);
    for (int k = 0; k < 3; k++) {
        axis1->v[k] = crn_scale_q30(reference->v[k], cosine) + crn_scale_q30(across.v[k], sine);
    }
    crn_frames_orthonormalise(axis1, tangent);
}

/* Computes the edges' reference axes from the introducer sheath to the tip, and the tools' material axes at
 * edges where a curved rest shape needs them. */
void crn_frames_carry(const crn_model *model, crn_state *state)
{
    crn_node_state *nodes = state->words.nodes;
    uint32_t na = state->words.free_count;
    crn_vec3 reference = model->base_axis1_q30;
    uint32_t last = 0; /* no edge beyond it needs an axis */
    while (last <= na && crn_edge_curved(state, last) == 0) {
        last++;
    }
    for (uint32_t n = na + 1; n > last; n--) {
        uint32_t j = n - 1;
        if (j < na) {
            reference = transport(reference, &nodes[j + 1].tangent_q30, &nodes[j].tangent_q30);
        }
        uint32_t curved = crn_edge_curved(state, j);
        if (curved == 0) {
            continue;
        }
        crn_frames_orthonormalise(&reference, &nodes[j].tangent_q30);
        for (uint32_t k = 0; k < model->tool_count; k++) {
            if (curved >> k & 1u) {
                material_axis(&reference, &nodes[j].tangent_q30, nodes[j].angle_turn32[k],
                              &state->scratch.nodes[j].u.a.axis1_q30[k]);
            }
        }
    }
}

/* --- twist ---------------------------------------------------------------------------------------------- */

enum {
    ANGLE_STEP_MAX_Q30 = 1 << 29, /* correction of one edge in one tick: 0.5 rad */
    HALF_PI_Q30 = 1686629713,
    TWO_OVER_PI_Q30 = 683565276,
    CURVE_MAX_N_M_Q26 = 1 << 29, /* 8 N m: the most that a rest shape may add to a pivot */
    NO_TOOL = CRN_TOOL_MAX,      /* a tool has no neighbour */
    NEW_EDGES_MAX = 8,           /* largest number of edges that a tool's tip can pass in one tick */
};

/* Twist of a joint. Format: difference of binary angles -> Q30 rad, saturated at 2 rad (114 degrees in one
 * joint). */
static int32_t joint_angle(uint32_t ahead_turn32, uint32_t here_turn32)
{
    return crn_mul_q30((int32_t)(here_turn32 - ahead_turn32), HALF_PI_Q30);
}

/* Computes the terms that tool k's rest curvature adds to the twist equations of the two edges of joint i:
 * the torque W b.(t x half) on the right side, and max(0, W b.half) on the diagonal. */
static void curvature_torque(const crn_state *state, uint32_t k, uint32_t i, int32_t *torque_N_m_q30,
                             int32_t *stiffness_q26)
{
    const crn_joint *joint = crn_rod_joint(state, i);
    const crn_node_state *node = &state->words.nodes[i];
    const crn_work *work = &state->scratch.nodes[i];
    crn_vec3 bend = crn_vec3_sub(work->u.a.stretch_q30, work[-1].u.a.stretch_q30);
    for (int side = 0; side < 2; side++) {
        crn_vec3 half;
        crn_rod_rest_turn(joint, k, state->words.release_q30, &work[side - 1].u.a.axis1_q30[k],
                          &node[side - 1].tangent_q30, &half);
        crn_vec3 turned = crn_vec3_cross_unit(&node[side - 1].tangent_q30, &half);
        int32_t lever = crn_sat32(crn_rshift_round64(crn_vec3_dot64(bend, turned), 30));
        int32_t hold = crn_sat32(crn_rshift_round64(crn_vec3_dot64(bend, half), 30));
        torque_N_m_q30[side] = crn_mul(lever, joint->bend_N_m_q26, 26);
        stiffness_q26[side] =
            hold > 0 ? crn_clamp(crn_mul_q30(joint->bend_N_m_q26, hold), 0, CURVE_MAX_N_M_Q26) : 0;
    }
}

/* Holds the friction torque on an edge, torque - stiffness theta, as a function of the edge's rotation theta.
 */
typedef struct resistance {
    int32_t torque_N_m_q30, stiffness_q26;
} resistance;

/* Returns the wall's friction on the tool that touches it. The tool's surface moves by the radius r times the
 * rotation theta, along the direction n x t across normal and tangent, in addition to its displacement along
 * the wall; one friction displacement represents the two motions together (rod_contact.c). Overflow is
 * impossible: k_f r is below 2000 N/m x 2 mm = 2^24 in Q22 and the reach of the friction displacement is
 * below 2^30.5, so the torque is below 2^29. */
static inline __attribute__((always_inline)) resistance
wall_resistance(unsigned exponent, const crn_work *work, int32_t radius_m_q30)
{
    /* k_f in Q19 N/m, r in Q35 m: k_f r in Q22 N, then Q28; with the reach in Q33 m Q29 N m, with r in Q30 m
     * Q26 N m */
    int32_t stiffness_q19 = work->wall_friction << (19 - exponent);
    int32_t lever_N_q28 = crn_mulh(stiffness_q19, radius_m_q30 << 5) << 6;
    return (resistance){crn_mulh(lever_N_q28, -work->reach_m_q33) * 2, crn_mulh(lever_N_q28, radius_m_q30)};
}

/* Returns the friction on tool k at an edge. The friction on an edge is the sum of the friction with the
 * neighbouring tools, at their newest known rotations, and the friction with the wall. Overflow is
 * impossible: the friction stiffness of a pair of tools is below 2^15, so the torque between two tools is
 * below 2^20. */
static inline __attribute__((always_inline)) resistance
edge_resistance(unsigned exponent, const crn_node_state *node, const crn_work *work,
                const crn_line_node *line, uint32_t k, uint32_t inner, uint32_t around)
{
    resistance sum = {0, 0};
    if (work->touching && line->outer == k) {
        sum = wall_resistance(exponent, work, line->radius_m_q30);
    }
    if (around != NO_TOOL) {
        int32_t stiffness = work->u.a.grip_N_m_q26[k];
        int32_t way = crn_sub_sat(node->spin_q30[around], node->grip_q30[k]);
        sum.torque_N_m_q30 += crn_mulh(stiffness << 6, way);
        sum.stiffness_q26 += stiffness;
    }
    if (inner != NO_TOOL) {
        int32_t stiffness = work->u.a.grip_N_m_q26[inner];
        int32_t way = crn_add_sat(node->spin_q30[inner], node->grip_q30[inner]);
        sum.torque_N_m_q30 += crn_mulh(stiffness << 6, way);
        sum.stiffness_q26 += stiffness;
    }
    return sum;
}

/* Holds the values that elimination passes from one edge to the next. */
typedef struct twist_carry {
    int32_t left_q26; /* k of the joint ahead less what eliminating the edge ahead takes away: not negative */
    int32_t moment;   /* k m of the joint ahead */
    int32_t curve_torque, curve_q26; /* curvature terms of this edge from the joint ahead */
    int32_t reduced_torque;          /* the remaining torque after the edge ahead was eliminated */
} twist_carry;

/* Returns right / pivot in Q30 from the reciprocal 2^61 / mantissa, where `right` is in Q30, and the pivot is
 * mantissa 2^(1 - lead) in Q26. To detect an overflow on a 32-bit machine, the code examines only the upper
 * word of the 64-bit number. Overflow: saturates. */
static inline __attribute__((always_inline)) int32_t over_pivot(int32_t right, int32_t reciprocal,
                                                                unsigned lead)
{
    int64_t product = (int64_t)right * reciprocal;
    unsigned shift = 36 - lead; /* 7 .. 36 */
    if (sizeof(void *) > 4 || shift > 31) {
        return crn_sat32(product >> shift);
    }
    int32_t high = crn_high64(product);
    int32_t most = (int32_t)1 << (shift - 1); /* upper word of the limit */
    if (high >= most || high < -most) {
        return high < 0 ? INT32_MIN : INT32_MAX;
    }
    return crn_narrow64(product, shift);
}

/* Eliminates the equation of edge j of tool k. Pivots and couplings are in Q26 N m, the right side is in Q30
 * N m, and angles are in Q30 rad. Overflow is impossible: the twist stiffness k is below 2^30 (rod_line.c),
 * the curvature terms are below 2^29 each, and the stiffnesses of friction and of a spring that holds the
 * edge are together below 2^30 + 2^20, so the pivot fits an unsigned 32-bit number. Moments saturate. */
static inline __attribute__((always_inline)) void eliminate_edge(const crn_model *model, crn_state *state,
                                                                 uint32_t k, uint32_t inner, uint32_t around,
                                                                 uint32_t j, twist_carry *carry)
{
    const crn_joint *joint = crn_rod_joint(state, j + 1);
    const crn_node_state *node = &state->words.nodes[j];
    crn_work *work = &state->scratch.nodes[j];
    int32_t next = joint->twist_N_m_q26[k];
    int32_t moment = crn_mul(next, joint_angle(node->angle_turn32[k], node[1].angle_turn32[k]), 26);
    resistance sum =
        edge_resistance(model->stiffness_exponent, node, work, &state->line.nodes[j], k, inner, around);
    int32_t right = crn_add_sat(crn_sub_sat(moment, carry->moment), carry->reduced_torque);
    right = crn_add_sat(right, sum.torque_N_m_q30);
    uint32_t pivot =
        (uint32_t)carry->left_q26 + (uint32_t)next + CRN_SPIN_DRAG_N_M_Q26 + (uint32_t)sum.stiffness_q26;
    if (((joint->curved >> k & 1u) | (uint32_t)carry->curve_torque | (uint32_t)carry->curve_q26) != 0) {
        int32_t curve_torque[2] = {0, 0};
        int32_t curve_q26[2] = {0, 0};
        if (joint->curved >> k & 1u) {
            curvature_torque(state, k, j + 1, curve_torque, curve_q26);
        }
        right = crn_add_sat(right, crn_add_sat(carry->curve_torque, curve_torque[0]));
        pivot += (uint32_t)carry->curve_q26 + (uint32_t)curve_q26[0];
        carry->curve_torque = curve_torque[1];
        carry->curve_q26 = curve_q26[1];
    }
    unsigned lead = (unsigned)__builtin_clz(pivot);
    int32_t reciprocal = crn_reciprocal_q30(pivot << lead >> 1);
    /* k / pivot, at most one since the pivot is k or more; 2^-30 is the reserve for the reciprocal's
     * rounding */
    int32_t ratio = (int32_t)(((uint64_t)((uint32_t)next << lead) * (uint32_t)reciprocal) >> 32);
    ratio = ratio > CRN_ONE_Q30 ? CRN_ONE_Q30 : ratio;
    work->u.a.twist_ratio_q30 = ratio;
    work->u.a.twist_angle_q30 = over_pivot(right, reciprocal, lead);
    carry->left_q26 = next - crn_scale_q30(next, ratio);
    carry->moment = moment;
    carry->reduced_torque = crn_mul_q30(right, ratio);
}

/* Turns the material axis d1 of an edge by the small angle a towards the axis d2, to d1 (1 - a^2/2) + d2
 * a. */
static void turn_axis(const crn_vec3 *tangent, int32_t angle_q30, crn_vec3 *axis1)
{
    crn_vec3 axis2 = crn_vec3_cross_unit(tangent, axis1);
    int32_t cosine = CRN_ONE_Q30 - (crn_scale_q30(angle_q30, angle_q30) >> 1);
    for (int c = 0; c < 3; c++) {
        axis1->v[c] = crn_scale_q30(axis1->v[c], cosine) + crn_scale_q30(axis2.v[c], angle_q30);
    }
    crn_frames_orthonormalise(axis1, tangent);
}

/* Solves by back-substitution for the rotations of tool k's edges, from the base to the tip. Edges ahead of
 * tool k, which its tip is about to reach, get the frame of the edge that contains the tip. */
static inline __attribute__((always_inline)) void substitute(crn_state *state, uint32_t k, uint32_t first)
{
    uint32_t na = state->words.free_count;
    int32_t turn = 0; /* rotation of the edge nearer the base */
    uint32_t angle = state->words.nodes[na].angle_turn32[k];
    for (uint32_t n = na; n > first; n--) {
        crn_work *work = &state->scratch.nodes[n - 1];
        crn_node_state *node = &state->words.nodes[n - 1];
        turn = crn_add_sat(work->u.a.twist_angle_q30, crn_scale_q30(turn, work->u.a.twist_ratio_q30));
        turn = crn_clamp(turn, -ANGLE_STEP_MAX_Q30, ANGLE_STEP_MAX_Q30);
        uint32_t behind = angle;
        angle = node->angle_turn32[k] + (uint32_t)crn_scale_q30(turn, TWO_OVER_PI_Q30);
        node->angle_turn32[k] = angle;
        node->spin_q30[k] = turn;
        int32_t torque = crn_mul(crn_rod_joint(state, n)->twist_N_m_q26[k], joint_angle(angle, behind), 26);
        work[1].torque_N_m_q30 = crn_add_sat(work[1].torque_N_m_q30, torque);
        if (n == na) {
            state->scratch.torque_N_m_q30[k] = torque;
        }
        if ((crn_edge_curved(state, n - 1) >> k & 1u) != 0) {
            turn_axis(&node->tangent_q30, turn, &work->u.a.axis1_q30[k]);
        }
    }
    for (uint32_t n = first; n > 0 && n + NEW_EDGES_MAX > first; n--) {
        state->words.nodes[n - 1].angle_turn32[k] = state->words.nodes[first].angle_turn32[k];
        state->words.nodes[n - 1].spin_q30[k] = turn;
    }
}

/* In validation cases, adds a spring of 16 N m/rad that holds the first edge of tool 0. The spring that holds
 * the edge enters the equations in the same form as a rest shape. */
static void hold_turn(const crn_model *model, const crn_state *state, twist_carry *carry)
{
    int32_t miss = (int32_t)(model->hold.turn32 - state->words.nodes[0].angle_turn32[0]);
    carry->curve_torque = crn_sat32(16 * (int64_t)crn_mul_q30(miss, HALF_PI_Q30));
    carry->curve_q26 = 16 << 26;
}

/* The tools inside and around a tool; NO_TOOL: none. */
typedef struct neighbours {
    uint32_t inner, around;
} neighbours;

/* `apart` are the neighbours of tool k at the edges that the middle one of three tools does not reach, and
 * `near` at the others. The compiler must inline this function, so that k and the neighbours are constants in
 * the function's loops. */
static inline __attribute__((always_inline)) void twist_tool(const crn_model *model, crn_state *state,
                                                             uint32_t k, neighbours apart, neighbours near)
{
    twist_carry carry = {0, 0, 0, 0, 0};
    uint32_t na = state->words.free_count;
    uint32_t first = crn_tip_edge(model, state, k);
    state->scratch.torque_N_m_q30[k] = 0;
    if (k == 0 && first == 0 && model->hold.turn) {
        hold_turn(model, state, &carry);
    }
    const uint32_t end = crn_apart_edges(model, state);
    for (uint32_t j = first; j < end; j++) {
        eliminate_edge(model, state, k, apart.inner, apart.around, j, &carry);
    }
    for (uint32_t j = first > end ? first : end; j < na; j++) {
        eliminate_edge(model, state, k, near.inner, near.around, j, &carry);
    }
    substitute(state, k, first);
}

static void twist_two(const crn_model *model, crn_state *state)
{
    twist_tool(model, state, 0, (neighbours){NO_TOOL, 1}, (neighbours){NO_TOOL, 1});
    twist_tool(model, state, 1, (neighbours){0, NO_TOOL}, (neighbours){0, NO_TOOL});
}

static void twist_three(const crn_model *model, crn_state *state)
{
    twist_tool(model, state, 0, (neighbours){NO_TOOL, 2}, (neighbours){NO_TOOL, 1});
    state->scratch.torque_N_m_q30[1] = 0;
    if (crn_has_tool(&state->words, 1)) {
        twist_tool(model, state, 1, (neighbours){0, 2}, (neighbours){0, 2});
    }
    twist_tool(model, state, 2, (neighbours){0, NO_TOOL}, (neighbours){1, NO_TOOL});
}

void crn_rod_twist(const crn_model *model, crn_state *state)
{
    for (uint32_t i = 0; i <= state->words.free_count; i++) {
        state->scratch.nodes[i].torque_N_m_q30 = 0;
    }
    if (model->tool_count == 1) {
        twist_tool(model, state, 0, (neighbours){NO_TOOL, NO_TOOL}, (neighbours){NO_TOOL, NO_TOOL});
    } else if (model->tool_count == 2) {
        twist_two(model, state);
    } else {
        twist_three(model, state);
    }
}

/* Updates the elastic rotation between a pair of tools at each edge, limited to the friction torque mu N r
 * divided by the stiffness. */
void crn_tools_turned(const crn_model *model, crn_state *state)
{
    const uint32_t apart = crn_apart_edges(model, state);
    for (uint32_t pair = 0; pair + 1 < model->tool_count; pair++) {
        for (uint32_t j = 0; j < state->words.free_count; j++) {
            const uint32_t around = j < apart ? 2 : pair + 1;
            crn_node_state *node = &state->words.nodes[j];
            int32_t press = state->scratch.nodes[j].u.a.press_N_m_q30[pair];
            int32_t turned = crn_sub_sat(node->spin_q30[pair], node->spin_q30[around]);
            int32_t reach = crn_add_sat(node->grip_q30[pair], turned);
            /* Q30 N m / 4e-4 N m: x 2500 */
            int32_t most = crn_sat32(crn_product(press, CRN_GRIP_COMPLIANCE_PER_N_M));
            node->grip_q30[pair] = crn_clamp(reach, -most, most);
        }
    }
}
