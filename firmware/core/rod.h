/* This header declares the parts of one tick, in the order in which core_step.c calls them. The header is
 * private to firmware/core; docs/rod.md has the equations. */
#ifndef CRN_ROD_H
#define CRN_ROD_H

#include "firmware/core/core_state.h"

/* Marks functions that the compiler must not inline into the loops that call them, so that rare cases take no
 * processor registers from the common cases. */
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

/* Moves *span on to the span in which an arc length of the tool lies; beyond the tool's end, to the last one.
 */
static inline void crn_span_seek(const crn_tool *tool, uint32_t *span, int32_t arc_m_q30)
{
    while (*span + 1 < tool->span_count && tool->spans[*span].end_m_q30 <= arc_m_q30) {
        (*span)++;
    }
}

/* Returns where an arc length lies within a span of a tool, as a fraction in Q30, limited to the span's ends.
 */
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

/* length / stiffness. Format: Q30 m / Q35 N m^2 -> Q32 1 / (N m). Overflow is impossible, because the largest
 * compliance, 8 mm / 1e-7 N m^2, is only 2^49 in the number format used here. */
static inline int64_t crn_compliance_q32(int32_t length_m_q30, int32_t stiffness_q35)
{
    unsigned lead = crn_clz32((uint32_t)stiffness_q35) - 1; /* at most 19: stiffness >= 1e-7 N m^2 */
    int64_t inverse = crn_reciprocal_q30((uint32_t)stiffness_q35 << lead);
    return (length_m_q30 * inverse) >> (24 - lead);
}

/* Returns 2^q / value for value > 0. Overflow: saturates. Error: 2^-29 relative. */
static inline int32_t crn_inverse_of(int64_t value, unsigned q)
{
    unsigned lead = crn_clz64((uint64_t)value);
    int64_t inverse = crn_reciprocal_q30((uint32_t)(((uint64_t)value << lead) >> 33));
    int shift = 94 - (int)lead - (int)q; /* value = mantissa 2^(33 - lead), inverse = 2^61 / mantissa */
    if (shift <= 0) {
        return shift == 0 ? crn_sat32(inverse) : INT32_MAX;
    }
    return shift > 62 ? 0 : crn_sat32(crn_rshift_round64(inverse, (unsigned)shift));
}

/* Returns length / compliance, which is the series average of a stiffness over this length. Format: Q30 m /
 * Q32 1/(N m) -> Q35 N m^2. Overflow: saturates. The relative error of the result is 1 / `compliance`,
 * because the compliance is rounded to an integer. */
static inline int32_t crn_series_stiffness_q35(int32_t length_m_q30, int64_t compliance)
{
    unsigned lead = crn_clz64((uint64_t)compliance);
    int64_t inverse = crn_reciprocal_q30((uint32_t)(((uint64_t)compliance << lead) >> 33));
    int shift = 57 - (int)lead; /* 2^37 length / compliance, compliance = mantissa 2^(33 - lead) */
    return shift <= 0 ? INT32_MAX : crn_sat32(crn_rshift_round64(length_m_q30 * inverse, (unsigned)shift));
}

/* Limits the rest rotation of a node's cell to 1.2 rad, which the number format and the limit of the joint's
 * force permit. The file core_build.c refuses a tool whose stress-free shape turns by more than 1.2 rad in
 * one of the tool's own cells. A hook-shaped tip reaches the limit of 1.2 rad only inside a stiffer tool that
 * extends farther, because there the mesh has the long cells of that tool's shaft. */
static inline int32_t crn_limit_turn(int32_t turn_q30)
{
    return crn_clamp(turn_q30, -CRN_TURN_OF_CELL_MAX_Q30, CRN_TURN_OF_CELL_MAX_Q30);
}

/* Returns the rest rotation g of a joint. In the stress-free shape, the direction of the tool changes by the
 * angle `turn` at the joint. At the angle `turn`, the unit vectors along the two edges differ by 2 sin(turn /
 * 2). The rotation g is applied along the mean of the two edges' axes, whose length is cos(turn / 2). The
 * length g of the rest rotation vector is 2 tan(turn / 2) = turn (1 + turn^2 / 12 + turn^4 / 120), where
 * `turn` is the angle of the unloaded tool at a joint. The error of the series for the rest rotation g is 0.1
 * % at 1 rad. */
static inline int32_t crn_rest_turn_of(int32_t turn_q30)
{
    int32_t square = crn_mul_q30(turn_q30, turn_q30);
    int32_t series = crn_add_sat(89478485, crn_mul_q30(square, 8947849)); /* 1/12 and 1/120 in Q30 */
    return crn_add_sat(turn_q30, crn_mul_q30(turn_q30, crn_mul_q30(square, series)));
}

/* Returns the spring stiffness W a c of a joint in N/m, with 8 fractional bits. Overflow is impossible: W is
 * below 2^31 and a c is at most 2.5e7 (2^28.6 in Q4), so the product is below 2^60. */
static inline int64_t crn_bend_spring_q8(int32_t bend_N_m_q26, int32_t a_per_m_q18, int32_t c_per_m_q18)
{
    int64_t ac_q4 = ((int64_t)a_per_m_q18 * c_per_m_q18) >> 32;
    return (ac_q4 * bend_N_m_q26) >> 22;
}

/* Returns the axial spring stiffness EA / length of an edge. W is the bending stiffness of the softer of the
 * edge's two joints. The returned spring stiffness is limited to the largest axial stiffness of the model and
 * to 512 W a^2, where W is a joint's bending stiffness and 1/a the edge's length. If the axial stiffness were
 * far above 512 W a^2 (W: bending stiffness of a joint, 1/a: length of an edge), the determinant of a matrix
 * block would lose its significant bits. The returned spring stiffness has the unit N/m with 8 fractional
 * bits. */
static inline int64_t crn_axial_spring_q8(const crn_model *model, uint32_t edge, int32_t bend_N_m_q26)
{
    int32_t inverse = model->mesh[edge].inverse_length_per_m_q18;
    int64_t cap = ((int64_t)model->axial_max_N_q17 * inverse) >> 27;
    int64_t most = crn_bend_spring_q8(bend_N_m_q26, inverse, inverse) << 9;
    return most < cap ? most : cap;
}

/* Converts a stiffness with 8 fractional bits to Q(a), rounded. */
static inline int32_t crn_to_exponent(int64_t value_q8, unsigned exponent)
{
    return crn_sat32(exponent >= 8 ? value_q8 << (exponent - 8) : crn_rshift_round64(value_q8, 8 - exponent));
}

/* Returns the mass per length of the blood that the outermost tool moves along: what its outside displaces,
 * which the weights of the tools leave out, and as much again around it (the added mass of a cylinder that
 * moves across). Format: Q30 m squared -> Q34 kg/m. Overflow is impossible: 2 mm and 2 000 kg/m^3 give 2^56
 * before the shift. */
static inline int64_t crn_added_mass_q34(const crn_model *model, int32_t radius_m_q30)
{
    return (crn_product(radius_m_q30, radius_m_q30) * model->added_kg_m3) >> 26;
}

/* Sets the weight of a node, and its inertia, which has the blood that moves along. A part of a cell with a
 * wide tool's tip could come out lighter than any tool may be; it gets the mass of the lightest tool, 0.5
 * g/m. */
static inline void crn_set_mass(const crn_model *model, crn_line_node *node, int64_t weight_kg_per_m_q34,
                                int32_t length_m_q30)
{
    enum { LIGHTEST_KG_PER_M_Q34 = 8589935 };
    int64_t mass = weight_kg_per_m_q34 + crn_added_mass_q34(model, node->radius_m_q30);
    mass = mass > LIGHTEST_KG_PER_M_Q34 ? mass : LIGHTEST_KG_PER_M_Q34;
    node->weight_kg_q40 = crn_sat32(crn_rshift_round64(weight_kg_per_m_q34 * length_m_q30, 24));
    node->mass_kg_q40 = crn_sat32(crn_rshift_round64(mass * length_m_q30, 24));
}

/* Returns the inertia term m / h^2 (node's mass over the square of the tick) in Q(a) N/m, with a <= 14. A
 * mass in Q40 kg, multiplied by 1e6 2^10 / 2^32, gives a stiffness in Q18 N/m. The matrix and the right side
 * must contain the same rounded inertia term, because a difference of 2 % between them would cancel the
 * damping. Overflow: impossible, below 2^29. */
static inline int32_t crn_line_inertia(const crn_model *model, const crn_line_node *line)
{
    return crn_asr32(crn_mulh(line->mass_kg_q40, 1024000000), 18 - model->stiffness_exponent);
}

/* --- parts of the tick ---------------------------------------------------------------------------------- */

/* Returns the smallest inserted length that the simulation allows: three elements beyond the introducer
 * sheath's distal end. */
static inline int32_t crn_least_inserted(const crn_model *model)
{
    return model->mesh[3].arc_m_q30 + 1024;
}

/* Returns true if a tool is at the given position of the line (the set of nested tools). */
static inline bool crn_has_tool(const crn_state_words *words, uint32_t position)
{
    return words->exchange.line[position] != 0;
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

/* Returns the leading tool, which is the tool whose tip is farthest in the vessel; of several such tools it
 * is the innermost. */
static inline uint32_t crn_lead_tool(const crn_model *model, const crn_state_words *words)
{
    uint32_t lead = 0;
    for (uint32_t k = 1; k < model->tool_count; k++) {
        lead = words->tools[k].inserted_m_q30 > words->tools[lead].inserted_m_q30 ? k : lead;
    }
    return lead;
}

/* Returns the number of the edge that contains tool k's tip, or free_count when the tip lies behind the last
 * free edge. That edge may reach into the introducer sheath by up to its length. */
static inline uint32_t crn_tip_edge(const crn_model *model, const crn_state *state, uint32_t k)
{
    uint32_t j = 0;
    while (j < state->words.free_count && model->mesh[j + 1].arc_m_q30 <= state->line.offset_m_q30[k]) {
        j++;
    }
    return j;
}

/* Returns the number of edges, from the leading tip, at which tool 1 does not lie between the tools 0 and 2.
 */
static inline uint32_t crn_apart_edges(const crn_model *model, const crn_state *state)
{
    if (model->tool_count < CRN_TOOL_MAX) {
        return 0;
    }
    return crn_has_tool(&state->words, 1) ? crn_tip_edge(model, state, 1) : state->words.free_count;
}

/* Returns a set of bits. Bit k is 1 when the stress-free shape of tool k is curved at one of the joints of
 * edge j, so that the tool's material frame must be known there. */
static inline uint32_t crn_edge_curved(const crn_state *state, uint32_t j)
{
    return state->line.nodes[j].joint.curved | state->line.nodes[j + 1].joint.curved;
}

/* --- the tools on the line (exchange.c) ------------------------------------------------------------------
 */

/* Copies the tool with the given number in the table to a position of the model's line (the set of nested
 * tools); the number 0 empties the position. */
void crn_exchange_put(crn_model *model, uint32_t position, uint32_t number);

/* Puts the tools that a valid state names into the model, as its nested tools. */
void crn_exchange_take_line(crn_model *model, const crn_state_words *words);

/* Checks the numbers of the nested tools in a restored state. */
bool crn_exchange_is_valid(const crn_model *model, const crn_state_words *words);

/* These functions return two values of a restored state whose tools are valid but not yet in the model. The
 * first value is how far the tool at a position may be inserted (Q30 m), and the second value is the number
 * of balls of the balloon. */
int32_t crn_exchange_inserted_max(const crn_model *model, const crn_state_words *words, uint32_t position);
uint32_t crn_exchange_balls(const crn_model *model, const crn_state_words *words);

/* --- parts of the tick, continued ----------------------------------------------------------------------- */

/* Holds integrals of properties over a part of one tool. */
typedef struct crn_stretch {
    int64_t bend_q32,
        twist_q32; /* ds / EI, ds / GJ: 1 / (N m); in a divided cell bend is the share of ds in EI_k / EI */
    int64_t turn1_q30, turn2_q30;
} crn_stretch;

/* Returns the integrals of a tool's properties between two of its own arc lengths, from the given span on
 * (rod_line.c). */
crn_stretch crn_tool_integrate(const crn_tool *tool, uint32_t span, int32_t from, int32_t to);

/* Computes the combined joints, edges and surfaces of all tools at their present positions (rod_line.c). A
 * node keeps its values while, in its cell, each tool stays where it was, stays away, or slides within a part
 * of constant properties. The values are those of a pass that builds every node. */
void crn_line_update(const crn_model *model, crn_state *state);

/* Returns the axial compliance of the combined tools from the leading tip to node i, in Q40 m/N, saturated.
 */
static inline int32_t crn_line_compliance(const crn_line *line, uint32_t i)
{
    if (i <= line->steady) {
        return line->nodes[i].compliance_m_N_q40;
    }
    return crn_sat32(line->nodes[line->steady].compliance_m_N_q40 +
                     (int64_t)(i - line->steady) * line->edge_compliance_m_N_q40);
}

/* Converts the motion of the user's hands to feeds and base angles of the tools (rod_feed.c). This function
 * of rod_feed.c also frees or captures nodes at the introducer sheath, and computes the predicted
 * configuration and the inertia. */
void crn_rod_feed(const crn_model *model, crn_state *state, const crn_input *input);

/* The function crn_rod_stretch computes tangents, strains and axial forces of the edges at the predicted
 * configuration. Once the twisting moments are known, crn_rod_bend computes the bending and twisting forces
 * (rod_force.c). */
void crn_rod_stretch(const crn_model *model, crn_state *state);
void crn_rod_bend(const crn_model *model, crn_state *state);

/* Returns the number of nodes from the tip that move as one rigid body in this tick, at most free_count - 1
 * (rod_tip.c). The function also predicts how far the tip's rotation displaces each node of the rigid part,
 * and writes the displacement to `slide_m_q33` of the scratch memory. */
uint32_t crn_tip_predict(const crn_model *model, crn_state *state, uint32_t free_count);

/* Adds a correction to the shift of the nodes between the tip and edge i. The correction makes the edge as
 * long at the predicted configuration x* as it is at the present configuration x (rod_length.c).
 * `slide_m_q33` is node i's slide without this correction; node i + 1 is already at x*. */
void crn_slide_keep_length(const crn_model *model, const crn_state *state, uint32_t i,
                           const crn_vec3 *slide_m_q33, crn_vec3 *shift_m_q33);

/* From the hand to the tip, corrects the deviation that the solve found, edge by edge, so that turning edges
 * keep their length (rod_length.c). The caller passes the largest component of the deviation. */
void crn_rod_keep_lengths(const crn_model *model, crn_state *state, int32_t largest_m_q33);

/* Returns the joint at node i for this tick. The distal end of the introducer sheath cuts off a part of the
 * cells of two joints, at the nodes na-1 and na. */
static inline const crn_joint *crn_rod_joint(const crn_state *state, uint32_t i)
{
    uint32_t na = state->words.free_count;
    return i + 1 < na ? &state->line.nodes[i].joint : &state->scratch.mouth[i + 1 - na];
}

/* The rest rotation of tool k at a joint is divided between the joint's two edges. Returns one half of the
 * rest rotation, multiplied by the fraction `release_q30` that is applied now. The rest rotation is the angle
 * between the two edges of the joint in the tool's stress-free shape. Format: Q30 rad. */
void crn_rod_rest_turn(const crn_joint *joint, uint32_t tool, int32_t release_q30, const crn_vec3 *axis1,
                       const crn_vec3 *tangent, crn_vec3 *half);

/* Returns the displacement of the surface of a tool of the given radius when the tool turns. Format: Q30 m x
 * Q30 rad -> Q33 m. Overflow is impossible: the displacement of the surface is at most 2 mm x 0.5 rad = 1
 * mm. */
static inline int32_t crn_surface_way(int32_t radius_m_q30, int32_t turn_q30)
{
    return (int32_t)(((int64_t)radius_m_q30 * turn_q30 + (1 << 26)) >> 27);
}

/* Two functions return the rest rotation of joint i in the frames of the present tick. The first function
 * returns the rest rotation for one tool, and the second for all tools whose rest shape is curved at the
 * joint. Format: Q30 rad. */
crn_vec3 crn_rod_tool_turn(const crn_state *state, const crn_joint *joint, uint32_t tool, uint32_t i);
crn_vec3 crn_rod_line_turn(const crn_model *model, const crn_state *state, const crn_joint *joint,
                           uint32_t i);

/* Computes the reference axes of all edges, from the introducer sheath to the tip, and the tools' material
 * axes where a curved rest shape needs them (rod_twist.c). */
void crn_frames_carry(const crn_model *model, crn_state *state);
/* Makes the axis orthogonal to the tangent t and of unit length, to first order. The remaining error of the
 * axis is the square of its initial error. */
void crn_frames_orthonormalise(crn_vec3 *axis, const crn_vec3 *tangent);

/* Computes the rotations and twisting moments of the tools at the predicted configuration, against the
 * friction of the wall (rod_twist.c). */
void crn_rod_twist(const crn_model *model, crn_state *state);

/* The first function computes the moments of all joints, from which friction between tools follows. The
 * second one returns the axial force of the introducer sheath on bent tools (rod_force.c). */
void crn_bending_moments(crn_state *state);
int32_t crn_mouth_axial(const crn_model *model, const crn_state *state);

/* These functions follow what a bend leaves in a tool (rod_set.c). The function crn_set_apply puts the sets
 * into the joints of this tick; crn_set_mark marks joints whose material axes are needed because a set may
 * begin there; crn_set_follow changes the sets, once the axes are known. The function crn_set_forget clears
 * the sets of a position whose tool leaves the line. */
void crn_set_apply(const crn_model *model, crn_state *state);
void crn_set_mark(const crn_model *model, crn_state *state);
void crn_set_follow(const crn_model *model, crn_state *state);
/* Returns the curvatures towards d1 and d2 of the set of tool k at its own arc length, Q20 1/m. */
void crn_set_curvature(const crn_model *model, const crn_state_words *words, uint32_t k, int32_t arc_m_q30,
                       int32_t per_m_q20[2]);
void crn_set_forget(crn_state_words *words, uint32_t position);
bool crn_set_is_valid(const crn_model *model, const crn_state_words *words);

/* The rotation of the rest shape and of the set together, limited to that of the largest rest shape. */
static inline int32_t crn_rest_and_set(int32_t rest_q30, int32_t set_q14)
{
    enum { MOST_Q30 = 1475000000 };
    return set_q14 == 0 ? rest_q30
                        : crn_clamp(crn_add_sat(rest_q30, set_q14 * (1 << 16)), -MOST_Q30, MOST_Q30);
}

/* These functions compute the forces between tools, and the forces on the hands, except the hand that holds
 * the leading tool (rod_tools.c; crn_tools_turned: rod_twist.c). The functions run in this order:
 * crn_tools_grip (how hard tools press on each other) before the twist, crn_tools_turned after the twist,
 * crn_tools_handles before the solve, and crn_tools_slide after the solve.
 */
void crn_tools_grip(const crn_model *model, crn_state *state);
void crn_tools_turned(const crn_model *model, crn_state *state);
void crn_tools_handles(const crn_model *model, crn_state *state);
void crn_tools_slide(const crn_model *model, crn_state *state);

/* Samples the vessel wall at the moment of the given state, for callers outside a tick: at a point, as if no
 * tool pushed the wall aside, and at a node, with the way that the wall has given there. */
crn_lumen_sample crn_wall_sample(const crn_model *model, const crn_state *state,
                                 const crn_vec3 *position_m_q30);
crn_lumen_sample crn_wall_sample_at_node(const crn_model *model, const crn_state *state, uint32_t node);
/* Returns the normal force at a contact depth, Q22 N, and the stiffness there. */
int32_t crn_contact_force(int32_t depth_m_q30);
static inline int32_t crn_contact_stiffness_N_m(int32_t depth_m_q30)
{
    return CRN_CONTACT_STIFFNESS_N_m +
           (depth_m_q30 > CRN_CONTACT_DEEP_M_Q30 ? CRN_CONTACT_STIFFNESS_DEEP_N_m : 0);
}

/* The function crn_contact_find finds the contacts with the wall and their stiffnesses at the predicted
 * configuration. Once the rotation of the tool's surface is known, crn_contact_forces computes the forces of
 * the contacts (rod_contact.c). */
void crn_contact_find(const crn_model *model, crn_state *state);
void crn_contact_forces(const crn_model *model, crn_state *state);
/* Searches the solution of the linear system for contacts with the wall that were not found at the predicted
 * configuration. The caller passes the largest component of the solution. Returns the number of contacts that
 * were added. */
uint32_t crn_contact_missed(const crn_model *model, crn_state *state, int32_t largest_m_q33);
/* Returns the largest factor, at most 1, by which the solution can be multiplied so that no node with a
 * missed contact is deeper than 0.1 mm in the wall. The caller passes the largest component of the solution,
 * after the general limit of a node's motion per tick was applied. Format: Q30. */
int32_t crn_contact_share(const crn_model *model, crn_state *state, int32_t largest_m_q33);
/* Updates the friction displacements (bristles) after the solve, and fills the output's contact fields. */
void crn_contact_finish(const crn_model *model, crn_state *state, crn_output *output);

/* Solves the linear system of the tick by block LDL^T decomposition, from tip to base and back (rod_solve.c).
 * The solution is written to the scratch memory, in Q33 m. */
void crn_rod_solve(const crn_model *model, crn_state *state);
#if CRN_HAS_LANES
/* Eliminates all rows by lanes; returns true if a force had to be limited (rod_lanes.c). */
bool crn_rod_eliminate_lanes(const crn_model *model, crn_state *state);
#endif
/* Returns the axial force that the tools exert on the two nodes inside the introducer sheath, after the
 * solve; a positive force pushes outwards, towards the hand. Q22 N. */
int32_t crn_rod_handle_axial(const crn_model *model, const crn_state *state);

/* Computes the new positions of the nodes and fills the output's length error (rod_length.c). */
void crn_rod_advance(const crn_model *model, crn_state *state, crn_output *output);

/* Computes a hash of the state that is cheap enough to be computed in every tick (core_state.c). */
void crn_state_hash_lanes(const crn_state *state, uint32_t lane[2]);

/* --- the friction of a node on the vessel wall: its largest force and its stiffness (docs/rod.md, "Contact")
 * -- */

/* Component along n. Format: Q33 . Q30 -> Q33. Overflow is impossible: displacements are below 2^30. */
static inline int32_t along(const crn_vec3 *a, const crn_vec3 *n)
{
    return crn_vec3_dot_unit(a, n);
}

static inline crn_vec3 without(const crn_vec3 *a, const crn_vec3 *n, int32_t part)
{
    return crn_vec3_make(a->v[0] - crn_scale_q30(part, n->v[0]), a->v[1] - crn_scale_q30(part, n->v[1]),
                         a->v[2] - crn_scale_q30(part, n->v[2]));
}

static inline crn_vec3 tangential(const crn_vec3 *a, const crn_vec3 *n)
{
    return without(a, n, along(a, n));
}

/* Returns an upper bound of a vector's length. The bound of a vector's length is half of this sum: the
 * largest component's magnitude plus the magnitudes of all three components. Overflow: saturates. */
static inline int32_t length_at_most(const crn_vec3 *a)
{
    int64_t sum = 0, most = 0;
    for (int k = 0; k < 3; k++) {
        const int64_t size = a->v[k] < 0 ? -(int64_t)a->v[k] : a->v[k];
        sum += size;
        most = size > most ? size : most;
    }
    return crn_sat32((sum + most + 1) / 2);
}

static inline int32_t friction_of(const crn_node_state *node, const crn_line_node *line)
{
    return node->contact == CRN_CONTACT_SLIPS ? line->kinetic_q30 : line->static_q30;
}

/* Returns the length of the friction displacement (bristle) at which friction reaches its limit: mu N / k_t,
 * the limit divided by the friction stiffness. Format: Q22 N -> Q33 m: 2^11 / 2000 = 1 + 25166 / 2^20.
 * Overflow: impossible, 128 N. */
static inline int32_t bristle_limit(int32_t limit_N_q22)
{
    return limit_N_q22 + crn_mulh(limit_N_q22, 25166 << 12);
}

/* Returns the limit of the friction force on a slipping node. In each tick the friction limit of a slipping
 * node is CRN_FRICTION_GROWTH times k_t |z|, plus CRN_FRICTION_FRESH. If the limit were mu times the force at
 * the predicted depth, a node that hops on the wall by micrometres would rub with many times its real force,
 * because each micrometre of depth adds 5 mN. When the friction limits followed from the predicted depth,
 * neighbouring nodes also hopped, and feeding a soft wire at 40 mm/s took six times the push that correct
 * friction needs. Format: Q33 m -> Q22 N, 2000 / 2^11. Overflow: impossible in 64 bits. */
static inline int32_t growing_limit(const crn_node_state *node, int32_t limit_N_q22)
{
    const int64_t last_m_q33 = length_at_most(&node->bristle_m_q33);
    const int64_t most_N_q22 =
        ((last_m_q33 * (CRN_FRICTION_GROWTH * CRN_FRICTION_STIFFNESS_N_m)) >> 11) + CRN_FRICTION_FRESH_N_Q22;
    return most_N_q22 < limit_N_q22 ? (int32_t)most_N_q22 : limit_N_q22;
}

/* Returns 1/|a| for a vector a, given |a|^2 > 0, as a reciprocal root and a shift:
 * 1/|a| = root_q30 2^(half_lead - 62). */
static inline int32_t inverse_root(int64_t square, unsigned *half_lead)
{
    unsigned lead = (unsigned)__builtin_clzll((uint64_t)square) & ~1u;
    *half_lead = lead >> 1;
    return crn_rsqrt_q30((uint32_t)(((uint64_t)square << lead) >> 32));
}

/* Returns the friction stiffness k_f in Q(a). The friction stiffness k_f is k_t while the length `reach` of
 * the friction displacement is within its limit, and otherwise mu N / reach, where mu N is the friction
 * limit. Format: N Q22 / m Q33 -> Q(a): N root 2^(half_lead - 62) 2^(11 + a). */
static inline int32_t friction_stiffness(const crn_model *model, int32_t limit_N_q22,
                                         const crn_vec3 *reach_m_q33)
{
    int32_t most = bristle_limit(limit_N_q22);
    int64_t square = crn_vec3_dot64(*reach_m_q33, *reach_m_q33);
    if (square <= crn_product(most, most)) {
        return model->friction;
    }
    unsigned half_lead;
    int32_t root = inverse_root(square, &half_lead);
    int64_t stiffness = crn_asr64(crn_product(limit_N_q22, root), 51 - model->stiffness_exponent - half_lead);
    return stiffness > model->friction ? model->friction : (int32_t)stiffness;
}

/* Format: same in and out. Overflow: the caller keeps |value| and the limit `most` below 2^62. */
static inline int32_t crn_limited_to(int64_t value, int64_t most)
{
    if ((uint64_t)(value + most) <= (uint64_t)most * 2) { /* one comparison for the usual case */
        return (int32_t)value;
    }
    return (int32_t)(value > 0 ? most : -most);
}

/* Returns a / 2^n, limited to the range from -2^log2_most to 2^log2_most, for 32 - log2_most < n < 32. To
 * detect an overflow on a 32-bit machine, the code examines only the upper word of the 64-bit number. */
static inline int32_t crn_limited_shift(int64_t a, unsigned n, unsigned log2_most)
{
    if (sizeof(void *) > 4) {
        return crn_limited_to(a >> n, (int64_t)1 << log2_most);
    }
    int32_t high = crn_high64(a);
    uint32_t most_high = (uint32_t)1 << (log2_most + n - 32);
    if ((uint32_t)high + most_high < 2 * most_high) {
        return crn_narrow64(a, n);
    }
    return high < 0 ? -((int32_t)1 << log2_most) : (int32_t)1 << log2_most;
}

/* Returns the root of a number below 2^62 with a relative error of 2^-16. */
static inline int32_t crn_root_of(uint64_t square)
{
    if (square == 0) {
        return 0;
    }
    unsigned lead = (unsigned)__builtin_clzll(square) & ~1u;
    uint64_t top = (square << lead) >> 32;
    /* sqrt(top 2^(32 - lead)) = top / sqrt(top) 2^(16 - lead / 2), 1 / sqrt(top) = root 2^-46 */
    uint64_t root = (uint64_t)crn_rsqrt_q30((uint32_t)top);
    return (int32_t)((top * root) >> (30 + (lead >> 1)));
}

/* Returns the length of a vector. Format: same in and out. Overflow is impossible for vector components
 * within 2^30. */
static inline int32_t crn_length_of(const crn_vec3 *a)
{
    return crn_root_of((uint64_t)crn_vec3_dot64(*a, *a));
}

/* Returns the rotation between the edges of joint i. Format: Q29 so that it fits. */
static inline crn_vec3 crn_joint_bend(const crn_state *state, uint32_t i)
{
    const crn_work *here = &state->scratch.nodes[i];
    crn_vec3 bend_q29;
    for (int c = 0; c < 3; c++) {
        bend_q29.v[c] =
            crn_asr32(here->u.a.stretch_q30.v[c], 1) - crn_asr32(here[-1].u.a.stretch_q30.v[c], 1);
    }
    return bend_q29;
}

#endif
