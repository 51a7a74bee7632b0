/* This file computes the forces between coaxial tools and the forces on the hands that hold them
 * (docs/rod.md, "tools").
 *
 * The tools share one centreline, so the code does not compute a contact between the inner tool and the outer
 * tool's bore. A tool presses on the tool around it with the force that its bending and its axial force put
 * on the nodes that the two tools share. Friction between the two tools, at most the coefficient mu times the
 * normal force N, then resists sliding and turning, in both directions. For each pair of tools, one friction
 * displacement along the centreline represents sliding, and one friction displacement per edge represents
 * turning (rod_twist.c). Of three tools, the innermost one touches the outermost one ahead of the middle
 * one's tip.
 *
 * Through a lip or a bend without friction, the pull c = T + M kappa / 2 passes unchanged: T is the axial
 * force, M the bending moment and kappa the curvature (Bigoni et al. 2014, Mechanics Research
 * Communications). The pull of the inner tools is that of the whole line where they come out of the foremost
 * tip of the tools around them. From there towards the hand, friction changes it node by node, so it grows as
 * e^(mu angle) in a bend (the capstan of Euler and Eytelwein).
 *
 * If a tool does not lead, the force on the hand that holds it is the change of the elastic energy of all
 * tools as this tool slides along a centreline of fixed shape. Where the tool's properties change, the force
 * on the hand is the jump of psi = |M + P|^2 / (2 EI) - S / 2, where M is the bending moment, and P and S are
 * sums over all tools that depend on their unloaded curvatures. For the formula of psi, P = sum EI_m kappa_m
 * and S = sum EI_m kappa_m^2 are summed over all tools m at a point, where kappa_m is the unloaded curvature
 * and EI_m the bending stiffness of tool m. In continuum mechanics, such a force at an abrupt change of a
 * rod's cross-section is called a configurational force. */
#include "firmware/core/rod.h"

/* --- how hard tools press on each other ----------------------------------------------------------------- */

enum {
    MOMENT_MAX_N_m_Q30 = 1 << 29, /* 0.5 N m: differences of two fit 32 bits */
};

/* Subtracts the stiffness W times a rest rotation from a moment. */
static void take_turn(const crn_vec3 *turn_q30, int32_t bend_N_m_q26, crn_vec3 *moment)
{
    for (int c = 0; c < 3; c++) {
        int64_t rest = ((int64_t)turn_q30->v[c] * bend_N_m_q26) >> 26;
        moment->v[c] = crn_limited_to(moment->v[c] - rest, MOMENT_MAX_N_m_Q30);
    }
}

/* Returns the rest rotation of the tools 0 .. `pair` at joint i. */
static crn_vec3 inner_turn(const crn_state *state, const crn_joint *joint, uint32_t pair, uint32_t i)
{
    crn_vec3 turn = {{0, 0, 0}};
    for (uint32_t k = 0; k <= pair; k++) {
        if (joint->curved >> k & 1u) {
            turn = crn_vec3_add(turn, crn_rod_tool_turn(state, joint, k, i));
        }
    }
    return turn;
}

/* Computes the part of joint i's moment that the tools 0 .. `pair` bear: their fraction of W b, less the
 * moment of their rest shapes. Q30 N m. */
static inline void inner_moment(const crn_state *state, uint32_t pair, uint32_t i, crn_vec3 *moment)
{
    const crn_joint *joint = crn_rod_joint(state, i);
    const crn_vec3 *whole = &state->scratch.nodes[i].moment_N_m_q30;
    int32_t share_q30 = joint->inner_share_q15[pair] << 15;
    for (int c = 0; c < 3; c++) {
        moment->v[c] = crn_scale_q30(whole->v[c], share_q30);
    }
    if ((joint->curved & ((2u << pair) - 1u)) != 0) {
        crn_vec3 turn = inner_turn(state, joint, pair, i);
        take_turn(&turn, joint->bend_N_m_q26, moment);
    }
}

/* Returns the axial force of all tools together in an edge, + in tension, Q22 N. */
static int32_t line_axial(const crn_state *state, uint32_t edge)
{
    const int64_t axial_q47 =
        crn_product(state->line.nodes[edge].axial_stiffness_N_q17, state->scratch.nodes[edge].strain_q30);
    return crn_limited_to(crn_asr64(axial_q47, 25), CRN_TENSION_MAX_N_Q22);
}

/* Returns 3/2 of moment times curvature at a node, Q22 N: the pull less the axial force of an edge. Half of
 * moment times curvature is the pull's own part of bending. The rest is missing in the axial force of edges,
 * because bending acts on their vectors, and so also along them, with half of moment times curvature from
 * each of an edge's joints. Format: Q30 N m x Q29 rad x Q18 1/m; the moment is below 2^29 and the bend below
 * 2^30, so the sum is below 2^61. Overflow: limited. */
static inline int32_t bending_pull(const crn_vec3 *moment, const crn_vec3 *bend_q29, int32_t per_m_q18)
{
    const int64_t sum_q59 = crn_vec3_dot64(*moment, *bend_q29);
    const int64_t pull_q47 = crn_product(crn_narrow64(sum_q59, 30), per_m_q18); /* Q29 x Q18 */
    return crn_limited_to(crn_asr64(pull_q47 + (pull_q47 >> 1), 25), CRN_TENSION_MAX_N_Q22);
}

/* Moment of joint i, which all tools bear together. Q30 N m, limited. */
static inline void total_moment(const crn_model *model, const crn_state *state, uint32_t i, crn_vec3 *moment)
{
    const crn_joint *joint = crn_rod_joint(state, i);
    *moment = state->scratch.nodes[i].moment_N_m_q30;
    if (joint->curved != 0) {
        crn_vec3 turn = crn_rod_line_turn(model, state, joint, i);
        take_turn(&turn, joint->bend_N_m_q26, moment);
    }
}

/* Returns 3/2 of moment times curvature of the whole line at joint i; 0 at its free end. */
static int32_t line_bending_pull(const crn_model *model, const crn_state *state, uint32_t i)
{
    if (i == 0) {
        return 0;
    }
    crn_vec3 moment;
    total_moment(model, state, i, &moment);
    const crn_vec3 bend_q29 = crn_joint_bend(state, i);
    return bending_pull(&moment, &bend_q29, model->mesh[i].inverse_length_per_m_q18);
}

/* Returns the pull of the line just ahead of a tip that it comes out of. The edges at the tip carry what the
 * tip presses on the wall, so the pull is read some edges ahead. A line that has just come out has no such
 * edge; its pull grows from 0 while the second edge comes out. */
static int32_t pull_ahead(const crn_model *model, const crn_state *state, uint32_t around)
{
    enum { AHEAD_edges = 3 };
    const uint32_t tip = crn_tip_edge(model, state, around);
    if (tip == 0 || tip >= state->words.free_count) {
        return 0;
    }
    const uint32_t edge = tip > AHEAD_edges ? tip - AHEAD_edges : 0;
    const int32_t bending =
        line_bending_pull(model, state, edge) / 2 + line_bending_pull(model, state, edge + 1) / 2;
    const int32_t pull = crn_clamp(crn_add_sat(line_axial(state, edge), bending), -CRN_TENSION_MAX_N_Q22,
                                   CRN_TENSION_MAX_N_Q22);
    const int32_t first_m_q30 = model->mesh[0].length_m_q30;
    const int32_t more_m_q30 = state->line.offset_m_q30[around] - first_m_q30;
    return more_m_q30 < first_m_q30 ? crn_scale_q30(pull, crn_quotient(more_m_q30, first_m_q30, 30)) : pull;
}

/* Returns the pull of the tools 0 .. `pair` where they come out of the foremost tip of the tools around them;
 * 0 if none does. */
static int32_t pull_outside(const crn_model *model, const crn_state *state, uint32_t pair)
{
    const int32_t *offset_m_q30 = state->line.offset_m_q30;
    uint32_t front = pair + 1;
    for (uint32_t k = front + 1; k < model->tool_count; k++) {
        front = offset_m_q30[k] < offset_m_q30[front] ? k : front;
    }
    bool comes_out = false;
    for (uint32_t k = 0; k <= pair; k++) {
        comes_out |= offset_m_q30[k] < offset_m_q30[front];
    }
    return comes_out ? pull_ahead(model, state, front) : 0;
}

/* Moments of the inner tools at a node's joint and at the two joints around it. */
typedef struct moments {
    crn_vec3 before, here, after;
} moments;

/* Returns the force in Q22 N that the inner tools put on a node across the line. Their bending gives it from
 * the moments of the joints around the node, and their axial force, which is the pull less the part of
 * bending, acts along the node's two edges. Overflow is impossible: differences of moments fit 31 bits and 1
 * / edge length is below 2^31, so the first two products are below 2^62 together, and the third one is below
 * 2^58. */
static inline int32_t pressing_force(const moments *m, int32_t a_per_m_q18, int32_t c_per_m_q18,
                                     int32_t pull_N_q22, const crn_vec3 *ahead_q30,
                                     const crn_vec3 *behind_q30)
{
    crn_vec3 force, bend_q29;
    for (int k = 0; k < 3; k++) {
        bend_q29.v[k] = crn_asr32(behind_q30->v[k], 1) - crn_asr32(ahead_q30->v[k], 1);
    }
    const int32_t axial_N_q22 = pull_N_q22 - bending_pull(&m->here, &bend_q29, c_per_m_q18);
    for (int k = 0; k < 3; k++) {
        int64_t sum = crn_product(m->here.v[k] - m->before.v[k], a_per_m_q18);
        sum = crn_product_add(sum, m->here.v[k] - m->after.v[k], c_per_m_q18);
        sum += crn_asr64(crn_product(axial_N_q22, bend_q29.v[k]), 3); /* Q51 -> Q48 */
        force.v[k] = crn_limited_shift(sum, 26, 30);
    }
    return crn_length_of(&force);
}

/* Returns the length over which a tool bears on the tool around it where its moment has a step. A tool that
 * leaves one wall of the lumen in a bend of the radius R reaches the other wall, at the clearance delta,
 * after sqrt(2 R delta). If the pressing force were not spread over this length, a finer mesh would give a
 * larger force where the moment has a step (docs/rod.md, "Between tools"). Format: Q30 m. Overflow is
 * impossible: the clearance is at most 2 mm = 2^21, the radius below 2^26. */
static int32_t bearing_length(const crn_tool *inner, const crn_tool *around)
{
    const int32_t gap_m_q30 = around->bore_m_q30 - inner->shaft_radius_m_q30;
    if (gap_m_q30 <= 0) {
        return CRN_BEARING_MIN_M_Q30;
    }
    const int64_t square = 2 * crn_product(CRN_BEARING_BEND_M_Q30, gap_m_q30);
    const int32_t length_m_q30 = crn_root_of((uint64_t)square);
    return length_m_q30 > CRN_BEARING_MIN_M_Q30 ? length_m_q30 : CRN_BEARING_MIN_M_Q30;
}

static inline void soften(int32_t share_q30, crn_vec3 *moment, const crn_vec3 *ahead)
{
    for (int c = 0; c < 3; c++) {
        moment->v[c] = ahead->v[c] + crn_scale_q30(moment->v[c] - ahead->v[c], share_q30);
    }
}

/* Returns the stiffness of the friction against turning. The friction displacement (bristle) of length
 * `reach` has its own stiffness against turning while it is within the limit mu N r (friction limit times
 * lever arm); beyond this limit, the stiffness is the limit divided by `reach`. The value of `reach` follows
 * from the rotations of the last tick. Overflow is impossible, because the quotient limit / reach, which is
 * used only beyond the limit, is below 4e-4 N m. */
static inline uint16_t grip_stiffness(const crn_node_state *node, uint32_t pair, uint32_t around,
                                      int32_t limit_N_m_q30)
{
    int32_t turned = crn_sub_sat(node->spin_q30[pair], node->spin_q30[around]);
    int32_t reach = crn_add_sat(node->grip_q30[pair], turned);
    reach = reach < 0 ? crn_sub_sat(0, reach) : reach;
    if (reach <= crn_product(limit_N_m_q30, CRN_GRIP_COMPLIANCE_PER_N_M)) {
        return limit_N_m_q30 > 0 ? CRN_GRIP_STIFFNESS_N_M_Q26 : 0;
    }
    return (uint16_t)crn_quotient(limit_N_m_q30, reach, 26);
}

/* Returns how quickly a moment passes to the next tool along an edge: length / (length + bearing length). */
static inline int32_t bearing_share(int32_t length_m_q30, int32_t bearing_m_q30)
{
    return crn_quotient(length_m_q30, length_m_q30 + bearing_m_q30, 30);
}

/* The contact of the tools 0 .. `pair` with the tool directly around them: edges first .. last - 1. Its slide
 * is that of tool `pair` in tool `around`, kept with the tool of the number `slot`. */
typedef struct touch {
    uint32_t pair, around, slot, first, last;
} touch;

/* Slot 0: tool 0 in tool 1. Slot 1: tools 0 and 1 in tool 2. Slot 2: tool 0 in tool 2, where tool 1 does not
 * lie between them. */
static touch touch_of(const crn_model *model, const crn_state *state, uint32_t slot)
{
    const uint32_t na = state->words.free_count;
    touch t = {slot == 1, slot == 0 ? 1 : 2, slot, na, na};
    if (t.around >= model->tool_count) {
        return t;
    }
    const uint32_t apart = crn_apart_edges(model, state);
    const uint32_t inner = crn_tip_edge(model, state, t.pair), outer = crn_tip_edge(model, state, t.around);
    t.first = inner > outer ? inner : outer;
    if (slot < 2 && t.first < apart) {
        t.first = apart;
    }
    if (slot == 2) {
        t.last = apart > t.first ? apart : t.first;
    }
    return t;
}

/* What a contact passes on towards the hand: the pull behind its last node, and half of that node's friction.
 */
typedef struct passed_on {
    int32_t pull_N_q22, half_N_q22;
} passed_on;

/* Computes, for every edge of a contact, the limit mu N r of the friction torque (friction coefficient,
 * normal force, lever arm) and the friction's stiffness against turning. The function also sums the friction
 * limits mu N of all edges; this sum limits sliding. The pull at a node is that of the edge ahead, changed by
 * half of the friction of the node ahead. `from` is what another contact, directly ahead, passes on; null:
 * the contact begins at a lip. */
static passed_on grip_edges(const crn_model *model, crn_state *state, const touch *t, const passed_on *from)
{
    const uint32_t na = state->words.free_count, pair = t->pair, first = t->first;
    const int32_t friction_q30 = crn_tool_on(model, t->around)->lumen_friction_q30;
    const int32_t radius_m_q39 = crn_tool_on(model, pair)->shaft_radius_m_q30 << 9; /* at most 2 mm */
    const int32_t bearing_m_q30 = bearing_length(crn_tool_on(model, pair), crn_tool_on(model, t->around));
    const int32_t slide_q30 = state->words.tools[t->slot].slide_share_q30;
    int32_t pull_N_q22 = state->words.tools[t->slot].tip_axial_N_q22;
    int32_t half_N_q22 = from != NULL ? from->half_N_q22 : 0;
    int32_t length_m_q30 = 0, share_q30 = 0;
    int64_t sum_N_q22 = 0;
    moments m = {{{0, 0, 0}}, {{0, 0, 0}}, {{0, 0, 0}}};
    if (first > 1) {
        inner_moment(state, pair, first - 1, &m.before);
    }
    if (first > 0 && first <= na) {
        inner_moment(state, pair, first, &m.here);
    }
    for (uint32_t j = first; j < t->last; j++) {
        const crn_mesh_node *mesh = &model->mesh[j];
        crn_assembly *work = &state->scratch.nodes[j].u.a;
        const crn_node_state *node = &state->words.nodes[j];
        if (mesh->length_m_q30 != length_m_q30) {
            length_m_q30 = mesh->length_m_q30;
            share_q30 = bearing_share(length_m_q30, bearing_m_q30);
        }
        inner_moment(state, pair, j + 1, &m.after);
        soften(share_q30, &m.after, &m.here);
        /* The node ahead of a lip lies outside of the lumen. */
        const uint32_t ahead = j > first || from != NULL ? j - 1 : j;
        const int32_t middle_N_q22 = crn_sub_sat(pull_N_q22, half_N_q22);
        int32_t force = pressing_force(&m, model->mesh[j > 0 ? j - 1 : 0].inverse_length_per_m_q18,
                                       mesh->inverse_length_per_m_q18, middle_N_q22,
                                       &state->words.nodes[ahead].tangent_q30, &node->tangent_q30);
        int32_t limit = crn_scale_q30(force, friction_q30);
        int32_t press = crn_mulh(limit, radius_m_q39) * 2; /* Q22 N x Q39 m -> Q30 N m */
        const int32_t drag_N_q22 = crn_mul_q30(limit, slide_q30);
        pull_N_q22 =
            crn_clamp(crn_sub_sat(pull_N_q22, drag_N_q22), -CRN_TENSION_MAX_N_Q22, CRN_TENSION_MAX_N_Q22);
        half_N_q22 = drag_N_q22 / 2;
        sum_N_q22 += limit;
        work->press_N_m_q30[pair] = press;
        work->grip_N_m_q26[pair] = grip_stiffness(node, pair, t->around, press);
        m.before = m.here;
        m.here = m.after;
    }
    state->scratch.grip_limit_N_q22[t->slot] = crn_sat32(sum_N_q22);
    return (passed_on){pull_N_q22, half_N_q22};
}

/* Follows the pull with which a contact begins. The force of a stiff edge trembles from tick to tick, so the
 * state keeps it smoothed over 8 ms, as the forces on the hands are. */
static void follow_pull(crn_tool_state *tool, int32_t now_N_q22)
{
    enum { FOLLOW = 8 };
    tool->tip_axial_N_q22 += (now_N_q22 - tool->tip_axial_N_q22) / FOLLOW;
}

/* No tool touches another one with the tools 0 .. `pair` inside at the edges ahead of `first`. */
static void free_edges(crn_state *state, uint32_t pair, uint32_t first)
{
    for (uint32_t j = 0; j < first; j++) {
        state->scratch.nodes[j].u.a.press_N_m_q30[pair] = 0;
        state->scratch.nodes[j].u.a.grip_N_m_q26[pair] = 0;
    }
}

/* Where tool 0 touches tool 2 ahead of tool 1's tip, its pull at the end of that contact is the one with
 * which both other contacts begin: nothing pulls at the tip of tool 1. */
void crn_tools_grip(const crn_model *model, crn_state *state)
{
    if (model->tool_count == 1) {
        return;
    }
    crn_bending_moments(state);
    const touch ahead = touch_of(model, state, 2);
    const bool is_apart = ahead.first < ahead.last;
    passed_on passed = {0, 0};
    if (model->tool_count > 2) {
        follow_pull(&state->words.tools[2], is_apart ? pull_outside(model, state, 0) : 0);
        passed = grip_edges(model, state, &ahead, NULL);
    }
    for (uint32_t slot = 0; slot + 1 < model->tool_count; slot++) {
        const touch t = touch_of(model, state, slot);
        follow_pull(&state->words.tools[slot],
                    is_apart ? passed.pull_N_q22 : pull_outside(model, state, slot));
        free_edges(state, slot, slot == 0 && is_apart ? ahead.first : t.first);
        (void)grip_edges(model, state, &t, is_apart ? &passed : NULL);
    }
}

/* --- forces on the hand of a tool that does not lead ---------------------------------------------------- */

/* Sums EI, P and S, as defined at the top of this file, over all tools at one point. */
typedef struct section {
    int32_t bend_q35;
    crn_vec3 curved_N_m_q30; /* P */
    int32_t stored_N_q22;    /* S */
} section;

/* Adds tool k, at its arc length `arc_m_q30`, to the sums for the cross-section at joint i. */
static void add_tool(const crn_model *model, const crn_state *state, uint32_t k, int32_t arc_m_q30,
                     uint32_t i, section *sum)
{
    const crn_tool *tool = crn_tool_on(model, k);
    uint32_t span = 0;
    crn_span_seek(tool, &span, arc_m_q30);
    const crn_span *s = &tool->spans[span];
    int32_t fraction = crn_span_fraction(s, arc_m_q30);
    int32_t bend = crn_span_value(s, CRN_BEND_N_M2_Q35, fraction);
    int32_t curve1 = crn_mul_q30(crn_span_value(s, CRN_CURVE1_PER_M_Q20, fraction), state->words.release_q30);
    int32_t curve2 = crn_mul_q30(crn_span_value(s, CRN_CURVE2_PER_M_Q20, fraction), state->words.release_q30);
    if ((state->words.set.used_bits >> k & 1u) != 0) {
        int32_t set_per_m_q20[2];
        crn_set_curvature(model, &state->words, k, arc_m_q30, set_per_m_q20);
        curve1 = crn_add_sat(curve1, set_per_m_q20[0]);
        curve2 = crn_add_sat(curve2, set_per_m_q20[1]);
    }
    sum->bend_q35 = crn_add_sat(sum->bend_q35, bend);
    if ((curve1 | curve2) == 0 || (crn_edge_curved(state, i) >> k & 1u) == 0) {
        return;
    }
    const crn_vec3 *axis1 = &state->scratch.nodes[i].u.a.axis1_q30[k];
    crn_vec3 axis2 = crn_vec3_cross_unit(&state->words.nodes[i].tangent_q30, axis1);
    int32_t moment1 = crn_mul(bend, curve1, 25); /* Q35 x Q20 -> Q30 */
    int32_t moment2 = crn_mul(bend, curve2, 25);
    for (int c = 0; c < 3; c++) {
        int32_t part = crn_add_sat(crn_mul_q30(axis1->v[c], moment1), crn_mul_q30(axis2.v[c], moment2));
        sum->curved_N_m_q30.v[c] = crn_add_sat(sum->curved_N_m_q30.v[c], part);
    }
    /* Q30 N m x Q20 1/m -> Q22 N */
    int32_t stored = crn_add_sat(crn_mul(moment1, curve1, 28), crn_mul(moment2, curve2, 28));
    sum->stored_N_q22 = crn_add_sat(sum->stored_N_q22, stored);
}

/* psi of a section under the moment M, Q22 N. */
static int32_t potential(const section *s, const crn_vec3 *moment_N_m_q30)
{
    int64_t sum = 0;
    for (int c = 0; c < 3; c++) {
        int32_t load = crn_add_sat(moment_N_m_q30->v[c], s->curved_N_m_q30.v[c]);
        int32_t curvature = crn_quotient(load, s->bend_q35, 25); /* Q30 / Q35 -> Q20 1/m */
        sum += ((int64_t)load * curvature) >> 28;
    }
    return crn_sat32((sum - s->stored_N_q22) >> 1);
}

/* Jump of psi over joint i where only the stiffness changes and no tool has a rest shape:
 *   |M|^2 / 2 (1 / E - 1 / E') = |M|^2 / (2 E') change / E,  E = EI before and E' = EI after
 * Format: change in Q35 N m^2, below E. */
static int32_t straight_handle(const crn_vec3 *moment_N_m_q30, int32_t before_q35, int32_t change_q35)
{
    int32_t after_q35 = before_q35 + change_q35;
    unsigned lead = crn_clz32((uint32_t)after_q35) - 1; /* 0 .. 24 */
    int64_t inverse = crn_reciprocal_q30((uint32_t)after_q35 << lead);
    int64_t sum = 0;
    for (int c = 0; c < 3; c++) {
        int32_t curvature =
            crn_sat32((moment_N_m_q30->v[c] * inverse) >> (36 - lead)); /* Q30 / Q35 -> Q20 1/m */
        sum += ((int64_t)moment_N_m_q30->v[c] * curvature) >> 28;
    }
    return crn_mul(crn_sat32(sum), crn_quotient(change_q35, before_q35, 30), 31);
}

/* Returns the bending moment at joint i, computed from the neighbouring joints. Bending moments are
 * continuous along the tools, but the moment computed from the cell itself lags behind while a tip slides
 * through the cell. Q30 N m. */
static crn_vec3 moment_around(const crn_model *model, const crn_state *state, uint32_t i)
{
    crn_vec3 ahead, behind, moment;
    total_moment(model, state, i > 1 ? i - 1 : i, &ahead);
    total_moment(model, state, i < state->words.free_count ? i + 1 : i, &behind);
    for (int c = 0; c < 3; c++) {
        moment.v[c] = (ahead.v[c] + behind.v[c]) / 2;
    }
    return moment;
}

/* Returns joint i's contribution to the force on the hand that holds tool k: the value psi (defined at the
 * top of this file) at the beginning of the joint's cell minus psi at its end. */
static int32_t joint_handle(const crn_model *model, const crn_state *state, uint32_t k, uint32_t i,
                            int32_t from, int32_t to)
{
    section others = {0, {{0, 0, 0}}, 0};
    for (uint32_t m = 0; m < model->tool_count; m++) {
        int32_t arc = model->mesh[i].arc_m_q30 - state->line.offset_m_q30[m];
        if (m != k && arc >= 0) {
            add_tool(model, state, m, arc, i, &others);
        }
    }
    if (others.bend_q35 == 0) {
        return 0; /* its tip is level with the leading one */
    }
    section before = others;
    section after = others;
    if (from > 0) {
        add_tool(model, state, k, from, i, &before);
    }
    add_tool(model, state, k, to, i, &after);
    crn_vec3 moment = moment_around(model, state, i);
    return crn_sub_sat(potential(&before, &moment), potential(&after, &moment));
}

/* A curved tool that lies in the straight introducer sheath stores elastic energy. Returns the force on the
 * hand that holds a curved tool; the force results, at the sheath's distal end, from the elastic energy per
 * length of the tool in the straight sheath. */
static int32_t mouth_handle(const crn_model *model, const crn_state *state, uint32_t k, int32_t arc_m_q30)
{
    section own = {0, {{0, 0, 0}}, 0};
    add_tool(model, state, k, arc_m_q30, state->words.free_count - 1, &own);
    return -(own.stored_N_q22 / 2);
}

/* Returns whether a tip lies inside the cell of joint i (half an edge to either side of the joint). */
static bool holds_tip(const crn_model *model, const crn_state *state, uint32_t i)
{
    for (uint32_t m = 0; m < model->tool_count; m++) {
        int32_t tip = state->line.offset_m_q30[m];
        if (tip > model->mesh[i - 1].cell_end_m_q30 && tip < model->mesh[i].cell_end_m_q30) {
            return true;
        }
    }
    return false;
}

/* Returns joint i's contribution to the force on the hand that holds tool k, as joint_handle() does, for a
 * cell within one span of tool k (a part between two knots). The function takes the bending stiffness EI from
 * the joint, and the change of EI along the tool from the span between two knots. */
static int32_t smooth_handle(const crn_model *model, const crn_state *state, uint32_t k, uint32_t i,
                             const crn_span *span, int32_t from, int32_t to)
{
    /* the change follows from the length within the span, which only the tool's own end can cut */
    int32_t way = (to < span->end_m_q30 ? to : span->end_m_q30) - from;
    int32_t part = way > 0 ? (int32_t)(((int64_t)way * span->inverse_mantissa) >> span->shift) : 0;
    int32_t change = crn_scale_q30(span->delta[CRN_BEND_N_M2_Q35], part);
    int32_t cell = model->mesh[i].cell_end_m_q30 - model->mesh[i - 1].cell_end_m_q30;
    /* Q26 N m x Q30 m -> Q35 N m^2 */
    int32_t before = crn_mul(state->line.nodes[i].joint.bend_N_m_q26, cell, 21) - change / 2;
    int32_t size = change < 0 ? -change : change;
    if (before <= size || crn_edge_curved(state, i) != 0 || holds_tip(model, state, i)) {
        return joint_handle(model, state, k, i, from, to);
    }
    if (change == 0) {
        return 0;
    }
    crn_vec3 moment;
    total_moment(model, state, i, &moment);
    return straight_handle(&moment, before, change);
}

static int32_t elastic_handle(const crn_model *model, const crn_state *state, uint32_t k)
{
    int32_t inserted = crn_lead_inserted(model, &state->words);
    int32_t offset = state->line.offset_m_q30[k];
    const crn_tool *tool = crn_tool_on(model, k);
    const crn_span *last = &tool->spans[tool->span_count - 1];
    const crn_span *span = tool->spans;
    int32_t sum = 0;
    for (uint32_t i = 1; i <= state->words.free_count; i++) {
        /* The half cell between the tip and the middle of the first edge has no joint of its own, so the
         * first joint represents this half cell. */
        int32_t from = (i > 1 ? model->mesh[i - 1].cell_end_m_q30 : 0) - offset;
        int32_t to = model->mesh[i].cell_end_m_q30;
        to = (to < inserted ? to : inserted) - offset;
        if (to <= 0 || from >= to) {
            continue;
        }
        while (span < last && span->end_m_q30 <= from) {
            span++;
        }
        const bool has_set = (state->words.set.used_bits >> k & 1u) != 0;
        if (from <= 0 || has_set || (span < last && to > span->end_m_q30)) {
            sum = crn_add_sat(sum, joint_handle(model, state, k, i, from, to));
        } else if (!span->flat) {
            sum = crn_add_sat(sum, smooth_handle(model, state, k, i, span, from, to));
        } else if (span == last) {
            break; /* the properties do not change from here on */
        }
    }
    return inserted > offset ? crn_add_sat(sum, mouth_handle(model, state, k, inserted - offset)) : 0;
}

void crn_tools_handles(const crn_model *model, crn_state *state)
{
    uint32_t lead = crn_lead_tool(model, &state->words);
    state->scratch.mouth_axial_N_q22 = crn_mouth_axial(model, state);
    for (uint32_t k = 0; k < CRN_TOOL_MAX; k++) {
        bool follows = k < model->tool_count && k != lead;
        state->scratch.axial_N_q22[k] = follows ? elastic_handle(model, state, k) : 0;
    }
}

/* --- after the solve ------------------------------------------------------------------------------------ */

/* Follows the part of the largest friction that the elastic slide has. The largest friction depends on this
 * part: the more friction holds the inner tool, the harder it pulls towards the hand, and presses. In a bend
 * of mu times angle = a, it grows faster than the part, by a e^a / (e^a - 1), so a part that took its new
 * value at once would swing from tick to tick for a > 1. Taken over by an eighth, it is steady for a < 15. */
static void follow_share(crn_tool_state *inner, int32_t most_m_q33)
{
    enum { FOLLOW = 8 };
    const int32_t part_q30 = most_m_q33 > 0 ? crn_quotient(inner->slide_grip_m_q33, most_m_q33, 30) : 0;
    const int32_t share_q30 = crn_clamp(part_q30, -CRN_ONE_Q30, CRN_ONE_Q30);
    /* halves, because the difference may be 2 */
    const int32_t way_q29 = crn_asr32(share_q30, 1) - crn_asr32(inner->slide_share_q30, 1);
    inner->slide_share_q30 += way_q29 / (FOLLOW / 2);
}

/* Computes the friction of sliding of each contact between tools. A friction displacement between two tools
 * puts equal and opposite forces along the centreline on the two hands that hold these tools. */
void crn_tools_slide(const crn_model *model, crn_state *state)
{
    const uint32_t slots = model->tool_count == CRN_TOOL_MAX ? CRN_TOOL_MAX : model->tool_count - 1;
    for (uint32_t slot = 0; slot < slots; slot++) {
        crn_tool_state *inner = &state->words.tools[slot];
        const uint32_t pair = slot == 1 ? 1 : 0, around = slot == 0 ? 1 : 2;
        /* N Q22 / (2000 N/m) -> m Q33: 2^11 / 2000 = 1 + 25166 / 2^20 */
        int64_t limit_N_q22 = state->scratch.grip_limit_N_q22[slot];
        int64_t most = limit_N_q22 + ((limit_N_q22 * 25166) >> 20);
        int64_t slid = (int64_t)inner->slide_grip_m_q33 + state->scratch.slide_m_q33[pair] -
                       state->scratch.slide_m_q33[around];
        const int32_t most_m_q33 = most < INT32_MAX ? (int32_t)most : INT32_MAX;
        inner->slide_grip_m_q33 = crn_limited_to(slid, most_m_q33);
        follow_share(inner, most_m_q33);
        int32_t drag = (int32_t)(((int64_t)inner->slide_grip_m_q33 * CRN_FRICTION_STIFFNESS_N_m) >> 11);
        int32_t *axial = state->scratch.axial_N_q22;
        axial[pair] = crn_add_sat(axial[pair], drag);
        axial[around] = crn_sub_sat(axial[around], drag);
    }
}
