/* This file treats a tip with a tight curve as a rigid body. In each tick a rigid tip moves like the node
 * behind it. If the tip touches nothing, the tip also repeats its own rotation of the last tick.
 *
 * If a tightly curved tip of radius R slid along its own curve by ds in each tick, it would turn by ds / R in
 * each tick. If the tip's rotation were not predicted, the tip would lag when the hand turns it, because the
 * matrix keeps the directions of rest rotations fixed in space. For a tip of length s and curvature kappa on
 * a wire of length L, the solve recovers only about 1 / (kappa^2 s L) of the missing rotation in each tick
 * (docs/rod.md, "feed"). For a tip that touches the wall, the code predicts no rotation. At the wall the
 * solve stops the tip's rotation; if further rotation were predicted, the tip would tremble. */
#include "firmware/core/rod.h"

enum {
    TURN_LOST_SHIFT = 4,     /* a sixteenth of the last tick's rotation is lost */
    WAY_MAX_M_Q33 = 1717987, /* 0.2 mm: displacement of a node by one of the three rotations; with more, a
                                step might exceed what a state may hold */
    /* (0.03 mm)^2: sum of squared distances from an axis below which nothing turns */
    LEVER_LEAST_M2_Q60 = 1 << 30,
    AXIS_LEAST_M_Q24 = 64, /* 4 um: smallest sum of distances that determines a plane */
};

/* Returns the number of nodes from the tip that move as one rigid body. Within 40 mm of the tip, the rigid
 * part reaches to the last joint at which the rest shape is curved more tightly than 110 / m (a J, a pigtail,
 * the first bend of a guiding catheter). If the rigid part of the tip slid by ds along its own curve of
 * radius R, it would turn by ds / R in each tick. To undo the rotation of a tip of curvature kappa and length
 * s on a wire of length L, the solve needs EI kappa^2 s / (EI / L) ticks, because its matrix keeps rest
 * rotations fixed in space. Before the tip was treated as a rigid body, a J-shaped tip of 1.5 mm radius on 50
 * mm of soft wire lagged by 20 mm at a feed of 30 mm/s. Overflow is impossible: rotations are below 1.3 rad,
 * and the length of a cell is below 2^24 in Q30 m. */
static uint32_t count_rigid(const crn_model *model, const crn_state *state, uint32_t free_count)
{
    uint32_t rigid = 0;
    for (uint32_t i = 1; i < free_count && model->mesh[i].arc_m_q30 < CRN_TIP_CURVES_M_Q30; i++) {
        const crn_joint *joint = &state->line.nodes[i].joint;
        if (joint->curved == 0) {
            continue;
        }
        int64_t tight = (int64_t)(model->mesh[i].cell_end_m_q30 - model->mesh[i - 1].cell_end_m_q30) *
                        CRN_TIP_CURVE_PER_m;
        for (uint32_t k = 0; k < model->tool_count; k++) {
            int64_t turn1 = crn_rest_and_set(joint->turn1_q30[k], joint->set_q14[k][0]);
            int64_t turn2 = crn_rest_and_set(joint->turn2_q30[k], joint->set_q14[k][1]);
            if (turn1 * turn1 + turn2 * turn2 >= tight * tight) {
                rigid = i + 1;
            }
        }
    }
    return rigid < free_count ? rigid : free_count - 1;
}

/* Removes the rotation about an axis through node `root` from the remaining motion of the tip. The function
 * adds to the slide that part of the tip's rotation which is predicted to continue. In this function,
 * `drift_m_q33` holds the tip's motion relative to the motion of node `root`. The angle of rotation follows
 * from least squares: sum (a x r).w / sum (a x r)^2. Returns the vector sum of the products a x r, in Q24 m.
 * Overflow is impossible: lever arms are below 2^26.7 in Q30 (96 mm, where a restored state has edges twice
 * as long), motions are below 2^26.9 in Q33, and there are fewer than 2^8 nodes, so sums stay below 2^62. */
static crn_vec3 turn_about(crn_state *state, uint32_t root, const crn_vec3 *axis_q30)
{
    const crn_vec3 *centre = &state->words.nodes[root].position_m_q30;
    int64_t along = 0, square = 0, sum[3] = {0, 0, 0};
    int32_t most = 0;
    for (uint32_t i = 0; i < root; i++) {
        crn_work *work = &state->scratch.nodes[i];
        crn_vec3 arm = crn_vec3_sub(state->words.nodes[i].position_m_q30, *centre);
        crn_vec3 around = crn_vec3_cross_unit(axis_q30, &arm);
        along += crn_vec3_dot64(around, work->drift_m_q33);
        square += crn_vec3_dot64(around, around);
        for (int k = 0; k < 3; k++) {
            int32_t size = around.v[k] < 0 ? -around.v[k] : around.v[k];
            most = size > most ? size : most;
            sum[k] += around.v[k];
        }
    }
    const crn_vec3 total = {
        {crn_sat32(crn_asr64(sum[0], 6)), crn_sat32(crn_asr64(sum[1], 6)), crn_sat32(crn_asr64(sum[2], 6))}};
    if (square < LEVER_LEAST_M2_Q60) {
        return total;
    }
    unsigned shift = 34 - crn_clz64((uint64_t)square); /* square in 30 bits */
    int32_t turn_q30 = crn_quotient(crn_sat32(crn_asr64(along, shift + 3)), (int32_t)(square >> shift), 30);
    int32_t limit = crn_quotient(WAY_MAX_M_Q33 / 8, most, 30);
    turn_q30 = crn_clamp(turn_q30, -limit, limit);
    for (uint32_t i = 0; i < root; i++) {
        crn_work *work = &state->scratch.nodes[i];
        crn_vec3 arm = crn_vec3_sub(state->words.nodes[i].position_m_q30, *centre);
        crn_vec3 around = crn_vec3_cross_unit(axis_q30, &arm);
        for (int k = 0; k < 3; k++) {
            int32_t way_m_q33 = (int32_t)crn_rshift_round64((int64_t)around.v[k] * turn_q30, 27);
            work->drift_m_q33.v[k] -= way_m_q33;
            work->slide_m_q33.v[k] += way_m_q33 - crn_mulh(way_m_q33, 1 << (32 - TURN_LOST_SHIFT));
        }
    }
    return total;
}

uint32_t crn_tip_predict(const crn_model *model, crn_state *state, uint32_t free_count)
{
    const uint32_t rigid = count_rigid(model, state, free_count);
    if (rigid == 0) {
        return 0;
    }
    const crn_node_state *root = &state->words.nodes[rigid];
    uint32_t touching = 0;
    for (uint32_t i = 0; i < rigid; i++) {
        crn_work *work = &state->scratch.nodes[i];
        touching |= state->words.nodes[i].contact;
        work->slide_m_q33 = (crn_vec3){{0, 0, 0}};
        work->drift_m_q33 = crn_vec3_sub(state->words.nodes[i].step_m_q33, root->step_m_q33);
    }
    if (touching != CRN_CONTACT_NONE || model->hold.pinned || model->hold.turn) {
        return rigid;
    }
    /* The tip's rotation is predicted first about the direction in which the wire leaves the tip. After that,
     * the tip's rotation is predicted about two axes across the wire: one in the tip's plane, and one
     * perpendicular to this plane. */
    crn_vec3 out = turn_about(state, rigid, &root->tangent_q30);
    int32_t size = 0;
    out = crn_vec3_normalise(out, root->tangent_q30, &size);
    if (size >= AXIS_LEAST_M_Q24) {
        crn_vec3 in = crn_vec3_cross_unit(&root->tangent_q30, &out);
        (void)turn_about(state, rigid, &out);
        (void)turn_about(state, rigid, &in);
    }
    return rigid;
}
