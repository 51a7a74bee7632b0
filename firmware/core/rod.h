/* The parts of one tick, in the order in which core_step.c calls them. Private to firmware/core. docs/rod.md
 * has the equations. */
#ifndef CRN_ROD_H
#define CRN_ROD_H

#include "firmware/core/core_state.h"

/* Marks functions to be kept out of the loops that call them: rare cases must not cost the common ones
 * registers. */
#define CRN_RARE __attribute__((noinline, cold))

/* Returns num / den for den > 0. Format: same Q in -> Q(q), q <= 30. Overflow: saturates. Error: 2^-29
 * relative. */
static inline int32_t crn_quotient(int32_t num, int32_t den, unsigned q)
{
    unsigned lead = crn_clz32((uint32_t)den) - 1;
    int64_t inverse = crn_reciprocal_q30((uint32_t)den << lead); /* 2^61 / (den 2^lead) */
    return crn_sat32(crn_rshift_round64(num * inverse, 61 - lead - q));
}

static inline int32_t crn_clamp(int32_t value, int32_t low, int32_t high)
{
    return value < low ? low : (value > high ? high : value);
}

/* --- a tool's properties along its arc length ----------------------------------------------------------- */

/* Fraction of an arc length within a span, Q30, clamped to the span's ends. */
static inline int32_t crn_span_fraction(const crn_span *span, int32_t arc_m_q30)
{
    int32_t beyond = arc_m_q30 - span->begin_m_q30;
    if (beyond <= 0) {
        return 0;
    }
    if (arc_m_q30 >= span->end_m_q30) {
        return CRN_ONE_Q30;
    }
    return (int32_t)(((int64_t)beyond * span->inverse_mantissa) >> span->shift);
}

static inline int32_t crn_span_value(const crn_span *span, crn_property which, int32_t fraction_q30)
{
    return span->from[which] + crn_scale_q30(span->delta[which], fraction_q30);
}

/* W a c in N/m with 8 fractional bits. Overflow: W < 2^31 and a c <= 2.5e7 (Q4: 2^28.6): below 2^60. */
static inline int64_t crn_bend_spring_q8(int32_t bend_N_m_q26, int32_t a_per_m_q18, int32_t c_per_m_q18)
{
    int64_t ac_q4 = ((int64_t)a_per_m_q18 * c_per_m_q18) >> 32;
    return (ac_q4 * bend_N_m_q26) >> 22;
}

/* EA / length of an edge between joints of which the softer one has W. It is at most 512 W a^2, because far
 * above that the determinant of a block loses its bits, and at most the cap. The unit is N/m with 8
 * fractional bits. */
static inline int64_t crn_axial_spring_q8(const crn_model *model, uint32_t edge, int32_t bend_N_m_q26)
{
    int32_t inverse = model->mesh[edge].inverse_length_per_m_q18;
    int64_t cap = ((int64_t)model->axial_max_N_q17 * inverse) >> 27;
    int64_t most = crn_bend_spring_q8(bend_N_m_q26, inverse, inverse) << 9;
    return most < cap ? most : cap;
}

/* Shift from 8 fractional bits to Q(a), rounded. */
static inline int32_t crn_to_exponent(int64_t value_q8, unsigned exponent)
{
    return crn_sat32(exponent >= 8 ? value_q8 << (exponent - 8) : crn_rshift_round64(value_q8, 8 - exponent));
}

/* m / h^2 in Q(a) N/m, a <= 14: kg in Q40 times 1e6 2^10 / 2^32 is N/m in Q18. The matrix and the right side
 * need the same rounded value: a difference of 2 % undoes the damping. Overflow: impossible, below 2^29. */
static inline int32_t crn_line_inertia(const crn_model *model, const crn_line_node *line)
{
    return crn_asr32(crn_mulh(line->mass_kg_q40, 1024000000), 18 - model->stiffness_exponent);
}

/* --- parts of the tick ---------------------------------------------------------------------------------- */

/* Returns the shortest line: three elements beyond the inserter's distal end. */
static inline int32_t crn_least_inserted(const crn_model *model)
{
    return model->mesh[3].arc_m_q30 + 1024;
}

/* Length of the leading tip beyond the inserter's distal end. */
static inline int32_t crn_lead_inserted(const crn_model *model, const crn_state_words *words)
{
    int32_t lead = words->tools[0].inserted_m_q30;
    for (uint32_t k = 1; k < model->tool_count; k++) {
        lead = words->tools[k].inserted_m_q30 > lead ? words->tools[k].inserted_m_q30 : lead;
    }
    return lead;
}

/* The leading tool: the innermost of those that are farthest in. */
static inline uint32_t crn_lead_tool(const crn_model *model, const crn_state_words *words)
{
    uint32_t lead = 0;
    for (uint32_t k = 1; k < model->tool_count; k++) {
        lead = words->tools[k].inserted_m_q30 > words->tools[lead].inserted_m_q30 ? k : lead;
    }
    return lead;
}

/* Bit k: tool k has a rest shape at one of the joints of edge j, so that its frame must be known there. */
static inline uint32_t crn_edge_curved(const crn_state *state, uint32_t j)
{
    return state->line.nodes[j].joint.curved | state->line.nodes[j + 1].joint.curved;
}

/* rod_line.c: joints, edges and surfaces of the tools together at their present positions; it does nothing
 * while no tool slides against another. */
void crn_line_update(const crn_model *model, crn_state *state);

/* Compliance of the line along itself from its tip to node i, Q40 m/N, saturated. */
static inline int32_t crn_line_compliance(const crn_line *line, uint32_t i)
{
    if (i <= line->steady) {
        return line->nodes[i].compliance_m_N_q40;
    }
    return crn_sat32(line->nodes[line->steady].compliance_m_N_q40 +
                     (int64_t)(i - line->steady) * line->edge_compliance_m_N_q40);
}

/* rod_feed.c: hands -> feeds and base angles, nodes freed or captured, predicted configuration and
 * inertia. */
void crn_rod_feed(const crn_model *model, crn_state *state, const crn_input *input);

/* rod_force.c: edges (tangents, strain, axial forces) at the predicted configuration; then, with the twisting
 * moments known, bending and twist forces. */
void crn_rod_stretch(const crn_model *model, crn_state *state);
void crn_rod_bend(const crn_model *model, crn_state *state);

/* rod_tip.c: number of nodes from the tip that move on as one rigid body in this tick, at most free_count -
 * 1. It also predicts the rotation of each of them: `slide_m_q33` of the scratch. */
uint32_t crn_tip_predict(const crn_model *model, crn_state *state, uint32_t free_count);

/* rod_length.c: adds a correction to the shift of the nodes ahead, so that edge i is as long at x* as it is
 * at x. `slide_m_q33` is node i's slide without this addition; node i + 1 is at x* already. */
void crn_slide_keep_length(const crn_model *model, const crn_state *state, uint32_t i,
                           const crn_vec3 *slide_m_q33, crn_vec3 *shift_m_q33);

/* rod_length.c: the same for the solve's deviation, from the hand to the tip; the caller passes the
 * deviation's largest component. */
void crn_rod_keep_lengths(const crn_model *model, crn_state *state, int32_t largest_m_q33);

/* The joint at node i as this tick sees it: clipped at the inserter's distal end for i = na-1 and na. */
static inline const crn_joint *crn_rod_joint(const crn_state *state, uint32_t i)
{
    uint32_t na = state->words.free_count;
    return i + 1 < na ? &state->line.nodes[i].joint : &state->scratch.mouth[i + 1 - na];
}

/* One edge's half of the rest turning vector of tool k at a joint, times the share that is applied. Q30. */
void crn_rod_rest_turn(const crn_joint *joint, uint32_t tool, int32_t release_q30, const crn_vec3 *axis1,
                       const crn_vec3 *tangent, crn_vec3 *half);

/* Displacement of the surface of a turning tool of this radius. Format: Q30 m x Q30 rad -> Q33 m. Overflow: 2
 * mm x 0.5 rad = 1 mm. */
static inline int32_t crn_surface_way(int32_t radius_m_q30, int32_t turn_q30)
{
    return (int32_t)(((int64_t)radius_m_q30 * turn_q30 + (1 << 26)) >> 27);
}

/* Rest turning of joint i at this tick's frames: that of one tool, and that of all tools with a rest shape
 * there. Q30. */
crn_vec3 crn_rod_tool_turn(const crn_state *state, const crn_joint *joint, uint32_t tool, uint32_t i);
crn_vec3 crn_rod_line_turn(const crn_model *model, const crn_state *state, const crn_joint *joint,
                           uint32_t i);

/* rod_frames.c: reference axes from the inserter to the tip, and material axes where a rest shape needs
 * them. */
void crn_frames_carry(const crn_model *model, crn_state *state);
/* First-order repair: makes the axis orthogonal to t and of unit length. The remaining error is the square of
 * the error found. */
void crn_frames_orthonormalise(crn_vec3 *axis, const crn_vec3 *tangent);

/* rod_twist.c: rotations and twisting moments at the predicted configuration; the wall's friction resists. */
void crn_rod_twist(const crn_model *model, crn_state *state);

/* rod_tools.c: forces between tools, and on the hands of those that do not lead. `grip` (how hard tools press
 * on each other) runs before the twist, `turned` after it, `handles` before the solve, and `slide` after
 * it. */
void crn_tools_grip(const crn_model *model, crn_state *state);
void crn_tools_turned(const crn_model *model, crn_state *state);
void crn_tools_handles(const crn_model *model, crn_state *state);
void crn_tools_slide(const crn_model *model, crn_state *state);

/* Returns the contact sample of the wall at the state's moment, for readers outside a tick. */
crn_lumen_sample crn_wall_sample(const crn_model *model, const crn_state *state,
                                 const crn_vec3 *position_m_q30);

/* rod_contact.c: finds contacts and their stiffnesses at the predicted configuration, and computes their
 * forces once the rotation of the surface is known. */
void crn_contact_find(const crn_model *model, crn_state *state);
void crn_contact_forces(const crn_model *model, crn_state *state);
/* Looks for contacts that the prediction missed, given the solution and its largest component; returns how
 * many it added. */
uint32_t crn_contact_missed(const crn_model *model, crn_state *state, int32_t largest_m_q33);
/* The part of the solution, at most 1, that may be applied before such a node is 0.1 mm deep. The caller
 * passes the largest component that is applied in any case. Format: Q30. */
int32_t crn_contact_share(const crn_model *model, crn_state *state, int32_t largest_m_q33);
/* Updates the friction bristles after the solve and fills the output's contact fields. */
void crn_contact_finish(const crn_model *model, crn_state *state, crn_output *output);

/* rod_solve.c solves by block LDL^T from tip to base and back; the solution is in scratch, Q33 m. */
void crn_rod_solve(const crn_model *model, crn_state *state);
/* Force of the line on the two nodes that the inserter holds, along its axis, after the solve; positive
 * pushes out. Q22 N. */
int32_t crn_rod_handle_axial(const crn_model *model, const crn_state *state);

/* rod_advance.c: computes the new positions and fills the output's length error. */
void crn_rod_advance(const crn_model *model, crn_state *state, crn_output *output);

/* core_state.c: the cheap hash that every tick computes. */
void crn_state_hash_lanes(const crn_state *state, uint32_t lane[2]);

#endif
