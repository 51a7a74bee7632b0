/* Material frames and the quasi-static twist, at the predicted configuration.
 *
 * A reference axis is carried without turning from the inserter's edge to the tip (Bishop frame), so that a joint's
 * twist is just the difference of two angles about the tangent: d1 = cos(angle) u + sin(angle) (t x u). Unknown
 * corrections theta minimise sum k/2 (m + theta[i] - theta[i-1])^2 plus the bending energy's dependence on the rest
 * curvature, which turns with the frames: this is how a J tip follows the hand. One tridiagonal solve from tip to base;
 * the inserter's edge is held at the hand's angle, so torque reaches the tip within the tick (docs/rod.md, "twist").
 * May include: rod.h. Called by: core_step.c. */
#include "firmware/core/rod.h"

enum {
    LACK_FAST_Q30 = 1 << 28,      /* 1 - t.t' up to 1/4 (41 degrees per joint): series for 1 / (1 + t.t') */
    FOLD_Q30 = 1 << 28,           /* 1 + t.t' below 1/4 (beyond 139 degrees): no transport, only projection */
    ANGLE_STEP_MAX_Q30 = 1 << 29, /* correction of one edge in one tick: 0.5 rad */
    HALF_PI_Q30 = 1686629713,
    TWO_OVER_PI_Q30 = 683565276,
};

/* Vectors here are unit, amounts below one: sums and products stay inside Q30. */
static void add_scaled(seld_vec3 *sum, const seld_vec3 *direction_q30, int32_t amount)
{
    for (int k = 0; k < 3; k++) {
        sum->v[k] += seld_scale_q30(amount, direction_q30->v[k]);
    }
}

/* First-order repair: orthogonal to t, unit length. Leaves an error of the square of what it finds. */
static void orthonormalise(seld_vec3 *axis, const seld_vec3 *tangent)
{
    add_scaled(axis, tangent, -seld_vec3_dot_unit(axis, tangent));
    int32_t excess = (int32_t)((seld_vec3_dot64(*axis, *axis) - ((int64_t)1 << 60)) >> 31);
    for (int k = 0; k < 3; k++) {
        axis->v[k] = seld_scale_q30(axis->v[k], SELD_ONE_Q30 - excess);
    }
}

/* Transport across a sharp bend: the exact factor up to 139 degrees, beyond it the projection of the old axis. */
static seld_vec3 transport_sharply(seld_vec3 axis, const seld_vec3 *from, const seld_vec3 *to, int32_t tilt,
                                   int32_t lack)
{
    uint32_t sum = ((uint32_t)SELD_ONE_Q30 << 1) - (uint32_t)lack; /* 1 + t.t' */
    if (sum < FOLD_Q30) {
        add_scaled(&axis, to, -tilt);
        return seld_vec3_normalise(axis, *from, NULL);
    }
    int32_t ratio_q27 = seld_quotient(tilt, (int32_t)(sum > INT32_MAX ? INT32_MAX : sum), 27);
    for (int k = 0; k < 3; k++) {
        int64_t moved = (int64_t)ratio_q27 * from->v[k] + (int64_t)ratio_q27 * to->v[k];
        axis.v[k] = seld_sat32(axis.v[k] - seld_rshift_round64(moved, 27));
    }
    orthonormalise(&axis, to);
    return axis;
}

/* u - (u.t') / (1 + t.t') (t + t'): parallel transport from t to t'. */
static seld_vec3 transport(seld_vec3 axis, const seld_vec3 *from, const seld_vec3 *to)
{
    int32_t tilt = seld_vec3_dot_unit(&axis, to);
    int32_t lack = SELD_ONE_Q30 - seld_vec3_dot_unit(from, to);
    if (lack > LACK_FAST_Q30) {
        return transport_sharply(axis, from, to, tilt, lack);
    }
    /* 1 / (1 + c) = 1/2 + lack/4 + lack^2/8 + lack^3/16 */
    int32_t square = seld_scale_q30(lack, lack);
    int32_t inverse = (SELD_ONE_Q30 >> 1) + (lack >> 2) + (square >> 3) + (seld_scale_q30(square, lack) >> 4);
    int32_t amount = -seld_scale_q30(tilt, inverse);
    add_scaled(&axis, from, amount);
    add_scaled(&axis, to, amount);
    return axis;
}

/* d1 of an edge from its reference axis and angle. */
static void material_axis(const seld_vec3 *reference, const seld_vec3 *tangent, uint32_t angle_turn32,
                          seld_vec3 *axis1)
{
    int32_t sine, cosine;
    seld_sincos_turn32(angle_turn32, &sine, &cosine);
    seld_vec3 across = seld_vec3_cross_unit(tangent, reference);
    for (int k = 0; k < 3; k++) {
        axis1->v[k] = seld_scale_q30(reference->v[k], cosine) + seld_scale_q30(across.v[k], sine);
    }
    orthonormalise(axis1, tangent);
}

/* Reference axes from the inserter to the tip, and material axes where the rest shape needs them. */
static void carry_axes(const seld_model *model, seld_state *state)
{
    seld_node_state *nodes = state->words.nodes;
    uint32_t na = state->words.free_count;
    seld_vec3 reference = model->base_axis1_q30;
    for (uint32_t n = na + 1; n > 0; n--) {
        uint32_t j = n - 1;
        if (j < na) {
            reference = transport(reference, &nodes[j + 1].tangent_q30, &nodes[j].tangent_q30);
        }
        if (seld_rod_is_curved(&model->joints[j]) || seld_rod_is_curved(&model->joints[j + 1])) {
            orthonormalise(&reference, &nodes[j].tangent_q30);
            material_axis(&reference, &nodes[j].tangent_q30, nodes[j].angle_turn32,
                          &state->scratch.nodes[j].axis1_q30);
        }
    }
}

/* Twist of a joint. Format: difference of binary angles -> Q30 rad, saturated at 2 rad (114 degrees in one joint). */
static int32_t joint_angle(const seld_node_state *ahead, const seld_node_state *here)
{
    return seld_mul_q30((int32_t)(here->angle_turn32 - ahead->angle_turn32), HALF_PI_Q30);
}

/* What rest curvature adds to the twist equations of the two edges of joint i: torque W (b - g).(t x half) on the
 * right, max(0, W b.half) on the diagonal. */
static void curvature_torque(const seld_model *model, const seld_state *state, uint32_t i,
                             int32_t *torque_N_m_q30, int32_t *stiffness_q26)
{
    const seld_joint *joint = seld_rod_joint(model, state, i);
    const seld_node_state *node = &state->words.nodes[i];
    const seld_work *work = &state->scratch.nodes[i];
    seld_vec3 half[2];
    seld_rod_rest_turn(joint, state->words.release_q30, &work[-1].axis1_q30, &node[-1].tangent_q30, &half[0]);
    seld_rod_rest_turn(joint, state->words.release_q30, &work->axis1_q30, &node->tangent_q30, &half[1]);
    seld_vec3 bend = seld_vec3_sub(work->stretch_q30, work[-1].stretch_q30);
    seld_vec3 excess = seld_vec3_sub(bend, seld_vec3_add(half[0], half[1]));
    for (int side = 0; side < 2; side++) {
        seld_vec3 turned = seld_vec3_cross_unit(&node[side - 1].tangent_q30, &half[side]);
        int32_t lever = seld_sat32(seld_rshift_round64(seld_vec3_dot64(excess, turned), 30));
        int32_t hold = seld_sat32(seld_rshift_round64(seld_vec3_dot64(bend, half[side]), 30));
        torque_N_m_q30[side] = seld_mul(lever, joint->bend_N_m_q26, 26);
        stiffness_q26[side] = hold > 0 ? seld_mul_q30(joint->bend_N_m_q26, hold) : 0;
    }
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

/* Row of edge j. Pivots and couplings in Q26 N m, right side in Q30 N m, angles in Q30 rad. */
static void eliminate_edge(const seld_model *model, seld_state *state, uint32_t j, twist_carry *carry)
{
    const seld_joint *joint = seld_rod_joint(model, state, j + 1);
    seld_work *work = &state->scratch.nodes[j];
    int32_t next = joint->twist_N_m_q26;
    int32_t angle = joint_angle(&state->words.nodes[j], &state->words.nodes[j + 1]);
    int32_t moment = seld_mul(next, angle, 26);
    int32_t curve_torque[2] = {0, 0};
    int32_t curve_q26[2] = {0, 0};
    if (seld_rod_is_curved(joint)) {
        curvature_torque(model, state, j + 1, curve_torque, curve_q26);
    }
    int64_t pivot = (int64_t)carry->coupling_q26 + next + SELD_SPIN_DRAG_N_M_Q26 + carry->curve_q26 +
                    curve_q26[0] - carry->reduced_q26;
    pivot = pivot > INT32_MAX ? INT32_MAX : pivot;
    int32_t right = seld_sat32((int64_t)moment - carry->moment + carry->curve_torque + curve_torque[0] +
                               carry->reduced_torque);
    unsigned lead = seld_clz32((uint32_t)pivot);
    int64_t reciprocal = seld_reciprocal_q30((uint32_t)pivot << lead >> 1);
    int32_t ratio = over_pivot(next, reciprocal, lead, 30);
    work[1].torque_N_m_q30 = angle; /* holds the angle until the solve is done */
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

/* Turns edge j and, where the rest shape needs it, its material axis: d1 (1 - a^2/2) + d2 a. */
static void turn_edge(const seld_model *model, seld_state *state, uint32_t j, int32_t angle_q30)
{
    seld_node_state *node = &state->words.nodes[j];
    node->angle_turn32 += (uint32_t)seld_scale_q30(angle_q30, TWO_OVER_PI_Q30);
    if (!seld_rod_is_curved(&model->joints[j]) && !seld_rod_is_curved(&model->joints[j + 1])) {
        return;
    }
    seld_vec3 *axis1 = &state->scratch.nodes[j].axis1_q30;
    seld_vec3 axis2 = seld_vec3_cross_unit(&node->tangent_q30, axis1);
    int32_t cosine = SELD_ONE_Q30 - (seld_scale_q30(angle_q30, angle_q30) >> 1);
    for (int k = 0; k < 3; k++) {
        axis1->v[k] = seld_scale_q30(axis1->v[k], cosine) + seld_scale_q30(axis2.v[k], angle_q30);
    }
    orthonormalise(axis1, &node->tangent_q30);
}

void seld_rod_twist(const seld_model *model, seld_state *state)
{
    uint32_t na = state->words.free_count;
    carry_axes(model, state);
    twist_carry carry = {0, 0, 0, 0, 0, 0};
    for (uint32_t j = 0; j < na; j++) {
        eliminate_edge(model, state, j, &carry);
    }
    int32_t behind = 0; /* turn of the edge nearer the base */
    for (uint32_t n = na; n > 0; n--) {
        seld_work *work = &state->scratch.nodes[n - 1];
        int64_t angle = work->twist_angle_q30 + (int64_t)seld_scale_q30(behind, work->twist_ratio_q30);
        int32_t turn = angle > ANGLE_STEP_MAX_Q30
                           ? ANGLE_STEP_MAX_Q30
                           : (angle < -ANGLE_STEP_MAX_Q30 ? -ANGLE_STEP_MAX_Q30 : (int32_t)angle);
        int64_t after = (int64_t)work[1].torque_N_m_q30 + behind - turn;
        work[1].torque_N_m_q30 =
            seld_mul(seld_rod_joint(model, state, n)->twist_N_m_q26, seld_sat32(after), 26);
        turn_edge(model, state, n - 1, turn);
        behind = turn;
    }
}
