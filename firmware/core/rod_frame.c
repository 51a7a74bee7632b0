/* After the solve: new positions and tangents, material axes carried along, and the quasi-static twist.
 *
 * Axes: d1 is transported from the old tangent to the new one without turning about it. Twist: the angle m of
 * joint i is the turn from frame i-1 to frame i; unknown turns theta minimise sum k/2 (m + theta[i] -
 * theta[i-1])^2 plus the bending energy's dependence on the rest curvature, which turns with the frames: this
 * is how a J tip follows the hand. One tridiagonal solve from tip to base; the inserter's edge is held at the
 * hand's angle, so torque reaches the tip within the tick (docs/rod.md, "twist"). May include: rod.h. Called
 * by: core_step.c. */
#include "firmware/core/rod.h"

enum {
    TRANSPORT_FAST_Q30 = 1 << 28, /* |d1 . t'| beyond 1/4 takes the exact path */
    ANGLE_STEP_MAX_Q30 = 1 << 29, /* twist correction of one edge in one tick: 0.5 rad */
    SINE_MAX_Q30 = 759250125,     /* joint angles are read up to 45 degrees of twist per joint */
};

/* Vectors here are unit or below 1.9 in length, amounts below one: sums and products stay inside Q30. */
static void add_scaled(seld_vec3 *sum, const seld_vec3 *direction_q30, int32_t amount)
{
    for (int k = 0; k < 3; k++) {
        sum->v[k] += seld_scale_q30(amount, direction_q30->v[k]);
    }
}

static int32_t dot_q30(const seld_vec3 *a, const seld_vec3 *b)
{
    return seld_vec3_dot_unit(a, b);
}

/* First-order repair: orthogonal to t, unit length. Leaves an error of the square of what it finds. */
static void orthonormalise(seld_vec3 *axis, const seld_vec3 *tangent)
{
    add_scaled(axis, tangent, -dot_q30(axis, tangent));
    int32_t excess = (int32_t)((seld_vec3_dot64(*axis, *axis) - ((int64_t)1 << 60)) >> 31);
    int32_t scale = SELD_ONE_Q30 - excess;
    for (int k = 0; k < 3; k++) {
        axis->v[k] = seld_scale_q30(axis->v[k], scale);
    }
}

/* Exact fallback for large turns: the part of d1 across t', or of d2's neighbour when d1 lies along it. */
static void transport_exactly(seld_vec3 *axis, const seld_vec3 *from, const seld_vec3 *to)
{
    seld_vec3 across = *axis;
    add_scaled(&across, to, -dot_q30(axis, to));
    seld_vec3 other = seld_vec3_cross(*from, *to, 30);
    *axis = seld_vec3_normalise(across, seld_vec3_normalise(other, *axis, NULL), NULL);
}

static void transport(seld_vec3 *axis, const seld_vec3 *from, const seld_vec3 *to)
{
    int32_t tilt = dot_q30(axis, to);
    if (tilt > TRANSPORT_FAST_Q30 || tilt < -TRANSPORT_FAST_Q30) {
        transport_exactly(axis, from, to);
    } else {
        /* 1 / (1 + t.t') = 1/2 + lack/4 + lack^2/8 */
        int32_t lack = SELD_ONE_Q30 - dot_q30(from, to);
        int32_t inverse = (SELD_ONE_Q30 >> 1) + (lack >> 2) + (int32_t)(((int64_t)lack * lack) >> 33);
        int32_t amount = -seld_scale_q30(tilt, inverse);
        add_scaled(axis, from, amount);
        add_scaled(axis, to, amount);
    }
    orthonormalise(axis, to);
}

static void move_node(seld_state *state, uint32_t i)
{
    seld_node_state *node = &state->words.nodes[i];
    const seld_work *work = &state->scratch.nodes[i];
    for (int k = 0; k < 3; k++) {
        int32_t step = work->solution_m_q33.v[k] + work->slide_m_q33.v[k];
        node->step_m_q33.v[k] = step;
        node->position_m_q30.v[k] = seld_add_sat(node->position_m_q30.v[k], (step + 4) >> 3);
    }
}

void seld_rod_advance(const seld_model *model, seld_state *state, seld_output *output)
{
    uint32_t na = state->words.free_count;
    for (uint32_t i = 0; i < na; i++) {
        move_node(state, i);
    }
    int64_t excess = 0; /* sum of strain x length, Q60 m: 2 m at 12.5 % stays below 2^59 */
    for (uint32_t i = 0; i < na; i++) {
        seld_node_state *node = &state->words.nodes[i];
        seld_work *work = &state->scratch.nodes[i];
        seld_vec3 before = node->tangent_q30;
        int32_t strain = seld_rod_edge(&model->edges[i], &node->position_m_q30, &node[1].position_m_q30,
                                       &work->stretch_q30, &node->tangent_q30, &state->words.fault_bits);
        excess += (int64_t)strain * model->edges[i].length_m_q30;
        transport(&node->axis1_q30, &before, &node->tangent_q30);
    }
    state->scratch.nodes[na].stretch_q30 = state->words.nodes[na].tangent_q30;
    int32_t excess_m_q30 = seld_sat32(seld_rshift_round64(excess, 30));
    output->strain_max_q30 = seld_quotient(excess_m_q30, model->nodes[na].arc_m_q30, 30);
}

/* Angle of joint i. Format: Q30 rad. Error: 1e-5 rad at 0.2 rad, 1e-3 at 0.7. */
static int32_t joint_angle(const seld_node_state *ahead, const seld_node_state *here)
{
    seld_vec3 axis2 = seld_vec3_cross_unit(&here->tangent_q30, &here->axis1_q30);
    int32_t lack = SELD_ONE_Q30 - dot_q30(&ahead->tangent_q30, &here->tangent_q30);
    int32_t inverse = (SELD_ONE_Q30 >> 1) + (lack >> 2) + (int32_t)(((int64_t)lack * lack) >> 33);
    int32_t tilt =
        seld_scale_q30(dot_q30(&ahead->axis1_q30, &here->tangent_q30), dot_q30(&ahead->tangent_q30, &axis2));
    int32_t sine = seld_scale_q30(tilt, inverse) - dot_q30(&ahead->axis1_q30, &axis2);
    sine = sine > SINE_MAX_Q30 ? SINE_MAX_Q30 : (sine < -SINE_MAX_Q30 ? -SINE_MAX_Q30 : sine);
    /* asin: s + s^3/6 + 3 s^5/40 */
    int32_t square = seld_scale_q30(sine, sine);
    int32_t series = 178956971 + seld_scale_q30(square, 80530637);
    return sine + seld_scale_q30(seld_scale_q30(sine, square), series);
}

/* What rest curvature adds to the twist equations of the two edges of joint i: torque W (b - g).(t x half) on
 * the right, max(0, W b.half) on the diagonal. */
static void curvature_torque(const seld_model *model, const seld_state *state, uint32_t i,
                             int32_t *torque_N_m_q30, int32_t *stiffness_q26)
{
    const seld_joint *joint = seld_rod_joint(model, state, i);
    const seld_node_state *node = &state->words.nodes[i];
    const seld_work *work = &state->scratch.nodes[i];
    seld_vec3 half[2];
    seld_rod_rest_turn(joint, &node[-1].axis1_q30, &node[-1].tangent_q30, &half[0]);
    seld_rod_rest_turn(joint, &node->axis1_q30, &node->tangent_q30, &half[1]);
    seld_vec3 bend = seld_vec3_sub(work->stretch_q30, work[-1].stretch_q30);
    seld_vec3 excess = seld_vec3_sub(bend, seld_vec3_add(half[0], half[1]));
    for (int side = 0; side < 2; side++) {
        seld_vec3 turned = seld_vec3_cross_unit(&node[side - 1].tangent_q30, &half[side]);
        torque_N_m_q30[side] = seld_mul(dot_q30(&excess, &turned), joint->bend_N_m_q26, 26);
        int32_t stiffness = seld_scale_q30(joint->bend_N_m_q26, dot_q30(&bend, &half[side]));
        stiffness_q26[side] = stiffness > 0 ? stiffness : 0;
    }
}

/* value / pivot, the pivot given by its leading zeros and reciprocal. Format: with both in one Q and q = 30 a
 * ratio in Q30; value in Q30 N m over Q26 N m with q = 26 an angle in Q30. */
static int32_t over_pivot(int32_t value, int64_t reciprocal_q30, unsigned lead, unsigned q)
{
    return seld_sat32(seld_rshift_round64(value * reciprocal_q30, 62 - lead - q));
}

/* Rotate d1 about the tangent by a small angle: d1 (1 - a^2/2) + d2 a, repaired to unit length. */
static void turn_axis(seld_node_state *node, int32_t angle_q30)
{
    if (angle_q30 == 0) {
        return;
    }
    seld_vec3 axis2 = seld_vec3_cross_unit(&node->tangent_q30, &node->axis1_q30);
    int32_t cosine = SELD_ONE_Q30 - (seld_scale_q30(angle_q30, angle_q30) >> 1);
    for (int k = 0; k < 3; k++) {
        node->axis1_q30.v[k] =
            seld_scale_q30(node->axis1_q30.v[k], cosine) + seld_scale_q30(axis2.v[k], angle_q30);
    }
    orthonormalise(&node->axis1_q30, &node->tangent_q30);
}

/* Elimination from the tip. Pivots and couplings in Q26 N m, right side in Q30 N m, angles in Q30 rad. */
static void eliminate_twist(const seld_model *model, seld_state *state)
{
    uint32_t na = state->words.free_count;
    seld_node_state *nodes = state->words.nodes;
    seld_work *work = state->scratch.nodes;
    int32_t coupling = 0, torque = 0;            /* k and k m of the joint ahead */
    int32_t carried_torque = 0, carried_q26 = 0; /* curvature terms of this edge from the joint ahead */
    int32_t reduced_q26 = 0, reduced_torque = 0; /* what elimination of the edge ahead leaves here */
    for (uint32_t j = 0; j < na; j++) {
        const seld_joint *joint = seld_rod_joint(model, state, j + 1);
        int32_t next = joint->twist_N_m_q26;
        int32_t angle = joint_angle(&nodes[j], &nodes[j + 1]);
        nodes[j + 1].torque_N_m_q30 = angle; /* holds the angle until the solve is done */
        int32_t moment = seld_mul(next, angle, 26);
        int32_t curve_torque[2] = {0, 0};
        int32_t curve_q26[2] = {0, 0};
        if ((joint->turn1_q30 | joint->turn2_q30) != 0) {
            curvature_torque(model, state, j + 1, curve_torque, curve_q26);
        }
        int64_t pivot =
            (int64_t)coupling + next + SELD_SPIN_DRAG_N_M_Q26 + carried_q26 + curve_q26[0] - reduced_q26;
        pivot = pivot > INT32_MAX ? INT32_MAX : pivot;
        int32_t right =
            seld_sat32((int64_t)moment - torque + carried_torque + curve_torque[0] + reduced_torque);
        unsigned lead = seld_clz32((uint32_t)pivot);
        int64_t reciprocal = seld_reciprocal_q30((uint32_t)pivot << lead >> 1);
        int32_t ratio = over_pivot(next, reciprocal, lead, 30);
        work[j].twist_ratio_q30 = ratio;
        work[j].twist_angle_q30 = over_pivot(right, reciprocal, lead, 26);
        reduced_q26 = seld_scale_q30(next, ratio); /* ratio <= 1: the pivot is the coupling and more */
        reduced_torque = seld_scale_q30(right, ratio);
        coupling = next;
        torque = moment;
        carried_torque = curve_torque[1];
        carried_q26 = curve_q26[1];
    }
}

void seld_rod_twist(const seld_model *model, seld_state *state)
{
    uint32_t na = state->words.free_count;
    seld_node_state *nodes = state->words.nodes;
    eliminate_twist(model, state);
    int32_t behind = 0; /* turn of the edge nearer the base */
    for (uint32_t n = na; n > 0; n--) {
        seld_work *work = &state->scratch.nodes[n - 1];
        int32_t angle = seld_add_sat(work->twist_angle_q30, seld_scale_q30(behind, work->twist_ratio_q30));
        angle = angle > ANGLE_STEP_MAX_Q30 ? ANGLE_STEP_MAX_Q30
                                           : (angle < -ANGLE_STEP_MAX_Q30 ? -ANGLE_STEP_MAX_Q30 : angle);
        const seld_joint *joint = seld_rod_joint(model, state, n);
        int64_t after = (int64_t)nodes[n].torque_N_m_q30 + behind - angle;
        nodes[n].torque_N_m_q30 = seld_mul(joint->twist_N_m_q26, seld_sat32(after), 26);
        turn_axis(&nodes[n - 1], angle);
        behind = angle;
    }
}
