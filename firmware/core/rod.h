/* This header declares the parts of one tick, in the order in which core_step.c calls them. The header is
 * private to firmware/core; docs/rod.md has the equations. */
#ifndef CRN_ROD_H
#define CRN_ROD_H

#include "firmware/core/core_state.h"

/* Marks functions that must not be inlined into the loops that call them, so that rare cases cost the common
 * cases no registers. */
#define CRN_RARE __attribute__((noinline, cold))

/* Returns the quotient num / den for den > 0. Format: same Q in -> Q(q), q <= 30. Overflow: saturates. Error:
 * 2^-29 relative. */
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

/* Returns where an arc length lies within a span, as a fraction in Q30, clamped to the span's ends. */
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

/* Returns the spring stiffness W a c in N/m with 8 fractional bits. Overflow is impossible: W < 2^31, and a c
 * <= 2.5e7 (2^28.6 in Q4), so the product is below 2^60. */
static inline int64_t crn_bend_spring_q8(int32_t bend_N_m_q26, int32_t a_per_m_q18, int32_t c_per_m_q18)
{
    int64_t ac_q4 = ((int64_t)a_per_m_q18 * c_per_m_q18) >> 32;
    return (ac_q4 * bend_N_m_q26) >> 22;
}

/* Returns EA / length of an edge between joints of which the softer one has the bending stiffness W. The
 * result is limited to the cap, and to 512 W a^2, because far above that the determinant of a block loses its
 * bits. The unit is N/m with 8 fractional bits. */
static inline int64_t crn_axial_spring_q8(const crn_model *model, uint32_t edge, int32_t bend_N_m_q26)
{
    int32_t inverse = model->mesh[edge].inverse_length_per_m_q18;
    int64_t cap = ((int64_t)model->axial_max_N_q17 * inverse) >> 27;
    int64_t most = crn_bend_spring_q8(bend_N_m_q26, inverse, inverse) << 9;
    return most < cap ? most : cap;
}

/* Converts a value with 8 fractional bits to Q(a), rounded. */
static inline int32_t crn_to_exponent(int64_t value_q8, unsigned exponent)
{
    return crn_sat32(exponent >= 8 ? value_q8 << (exponent - 8) : crn_rshift_round64(value_q8, 8 - exponent));
}

/* Returns m / h^2 in Q(a) N/m, a <= 14; a mass in Q40 kg times 1e6 2^10 / 2^32 is N/m in Q18. The matrix and
 * the right side need the same rounded value, because a difference of 2 % would cancel the damping. Overflow:
 * impossible, below 2^29. */
static inline int32_t crn_line_inertia(const crn_model *model, const crn_line_node *line)
{
    return crn_asr32(crn_mulh(line->mass_kg_q40, 1024000000), 18 - model->stiffness_exponent);
}

/* --- parts of the tick ---------------------------------------------------------------------------------- */

/* Returns the length of the shortest possible line: three elements beyond the introducer sheath's distal
 * end. */
static inline int32_t crn_least_inserted(const crn_model *model)
{
    return model->mesh[3].arc_m_q30 + 1024;
}

/* Returns the length from the introducer sheath's distal end to the leading tip. */
static inline int32_t crn_lead_inserted(const crn_model *model, const crn_state_words *words)
{
    int32_t lead = words->tools[0].inserted_m_q30;
    for (uint32_t k = 1; k < model->tool_count; k++) {
        lead = words->tools[k].inserted_m_q30 > lead ? words->tools[k].inserted_m_q30 : lead;
    }
    return lead;
}

/* Returns the leading tool, which is the innermost of those that are farthest in. */
static inline uint32_t crn_lead_tool(const crn_model *model, const crn_state_words *words)
{
    uint32_t lead = 0;
    for (uint32_t k = 1; k < model->tool_count; k++) {
        lead = words->tools[k].inserted_m_q30 > words->tools[lead].inserted_m_q30 ? k : lead;
    }
    return lead;
}

/* Returns a set of bits: bit k says that tool k has a rest shape at one of the joints of edge j, so that the
 * tool's material frame must be known there. */
static inline uint32_t crn_edge_curved(const crn_state *state, uint32_t j)
{
    return state->line.nodes[j].joint.curved | state->line.nodes[j + 1].joint.curved;
}

/* Computes joints, edges and surfaces of all tools together at their present positions (rod_line.c). The
 * function does nothing while no tool slides against another. */
void crn_line_update(const crn_model *model, crn_state *state);

/* Returns the axial compliance of the line from its tip to node i, Q40 m/N, saturated. */
static inline int32_t crn_line_compliance(const crn_line *line, uint32_t i)
{
    if (i <= line->steady) {
        return line->nodes[i].compliance_m_N_q40;
    }
    return crn_sat32(line->nodes[line->steady].compliance_m_N_q40 +
                     (int64_t)(i - line->steady) * line->edge_compliance_m_N_q40);
}

/* Converts the hands' motion to feeds and base angles, frees or captures nodes, and computes the predicted
 * configuration and the inertia (rod_feed.c). */
void crn_rod_feed(const crn_model *model, crn_state *state, const crn_input *input);

/* crn_rod_stretch computes tangents, strain and axial forces of the edges at the predicted configuration.
 * Once the twisting moments are known, crn_rod_bend computes the forces of bending and twist
 * (rod_force.c). */
void crn_rod_stretch(const crn_model *model, crn_state *state);
void crn_rod_bend(const crn_model *model, crn_state *state);

/* Returns the number of nodes from the tip that move as one rigid body in this tick, at most free_count - 1
 * (rod_tip.c). The function also predicts the displacement of each of these nodes by the tip's rotation, in
 * `slide_m_q33` of the scratch. */
uint32_t crn_tip_predict(const crn_model *model, crn_state *state, uint32_t free_count);

/* Adds a correction to the shift of the nodes ahead of edge i, so that the edge is as long at the predicted
 * configuration x* as at the present one, x (rod_length.c). `slide_m_q33` is node i's slide without this
 * correction; node i + 1 is already at x*. */
void crn_slide_keep_length(const crn_model *model, const crn_state *state, uint32_t i,
                           const crn_vec3 *slide_m_q33, crn_vec3 *shift_m_q33);

/* Does the same for the deviation that the solve found, from the hand to the tip (rod_length.c). The caller
 * passes the deviation's largest component. */
void crn_rod_keep_lengths(const crn_model *model, crn_state *state, int32_t largest_m_q33);

/* Returns the joint at node i for this tick; for i = na-1 and na the joint is clipped at the introducer
 * sheath's distal end. */
static inline const crn_joint *crn_rod_joint(const crn_state *state, uint32_t i)
{
    uint32_t na = state->words.free_count;
    return i + 1 < na ? &state->line.nodes[i].joint : &state->scratch.mouth[i + 1 - na];
}

/* Computes one edge's half of tool k's rest rotation at a joint, times the share `release_q30` that is
 * applied. The rest rotation is the angle between the two edges of the joint in the tool's stress-free shape.
 * Format: Q30 rad. */
void crn_rod_rest_turn(const crn_joint *joint, uint32_t tool, int32_t release_q30, const crn_vec3 *axis1,
                       const crn_vec3 *tangent, crn_vec3 *half);

/* Returns the displacement of the surface of a tool of this radius when the tool turns. Format: Q30 m x Q30
 * rad -> Q33 m. Overflow is impossible: the displacement is at most 2 mm x 0.5 rad = 1 mm. */
static inline int32_t crn_surface_way(int32_t radius_m_q30, int32_t turn_q30)
{
    return (int32_t)(((int64_t)radius_m_q30 * turn_q30 + (1 << 26)) >> 27);
}

/* These functions return the rest rotation of joint i in this tick's frames: that of one tool, and that of
 * all tools with a rest shape at the joint. Format: Q30 rad. */
crn_vec3 crn_rod_tool_turn(const crn_state *state, const crn_joint *joint, uint32_t tool, uint32_t i);
crn_vec3 crn_rod_line_turn(const crn_model *model, const crn_state *state, const crn_joint *joint,
                           uint32_t i);

/* Computes the reference axes from the introducer sheath to the tip, and the material axes where a rest shape
 * needs them (rod_frames.c). */
void crn_frames_carry(const crn_model *model, crn_state *state);
/* Makes the axis orthogonal to t and of unit length, to first order. The remaining error is the square of the
 * initial error. */
void crn_frames_orthonormalise(crn_vec3 *axis, const crn_vec3 *tangent);

/* Computes the rotations and twisting moments of the tools at the predicted configuration, against the
 * friction of the wall (rod_twist.c). */
void crn_rod_twist(const crn_model *model, crn_state *state);

/* These functions compute the forces between tools, and on the hands of tools that do not lead (rod_tools.c).
 * The function crn_tools_grip (how hard tools press on each other) runs before the twist, crn_tools_turned
 * after the twist, crn_tools_handles before the solve, and crn_tools_slide after the solve. */
void crn_tools_grip(const crn_model *model, crn_state *state);
void crn_tools_turned(const crn_model *model, crn_state *state);
void crn_tools_handles(const crn_model *model, crn_state *state);
void crn_tools_slide(const crn_model *model, crn_state *state);

/* Samples the wall as it is at the state's moment, for callers outside a tick. */
crn_lumen_sample crn_wall_sample(const crn_model *model, const crn_state *state,
                                 const crn_vec3 *position_m_q30);

/* crn_contact_find finds contacts and their stiffnesses at the predicted configuration. Once the rotation of
 * the surface is known, crn_contact_forces computes their forces (rod_contact.c). */
void crn_contact_find(const crn_model *model, crn_state *state);
void crn_contact_forces(const crn_model *model, crn_state *state);
/* Looks for contacts that the prediction missed, from the solution and the solution's largest component;
 * returns how many contacts it added. */
uint32_t crn_contact_missed(const crn_model *model, crn_state *state, int32_t largest_m_q33);
/* Returns the part of the solution, at most 1, that may be applied before a node with a missed contact is 0.1
 * mm deep. The caller passes the largest component of the solution that is applied in any case. Format:
 * Q30. */
int32_t crn_contact_share(const crn_model *model, crn_state *state, int32_t largest_m_q33);
/* Updates the friction bristles after the solve and fills the output's contact fields. */
void crn_contact_finish(const crn_model *model, crn_state *state, crn_output *output);

/* Solves the linear system by block LDL^T, from tip to base and back (rod_solve.c). The solution is in the
 * scratch, in Q33 m. */
void crn_rod_solve(const crn_model *model, crn_state *state);
/* Returns the force of the line on the two nodes that the introducer sheath holds, along the sheath's axis,
 * after the solve; a positive force pushes outwards. Q22 N. */
int32_t crn_rod_handle_axial(const crn_model *model, const crn_state *state);

/* Computes the new positions and fills the output's length error (rod_advance.c). */
void crn_rod_advance(const crn_model *model, crn_state *state, crn_output *output);

/* Computes the cheap hash of every tick (core_state.c). */
void crn_state_hash_lanes(const crn_state *state, uint32_t lane[2]);

#endif
