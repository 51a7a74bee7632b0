/* The parts of one tick, in the order core_step.c calls them. Private to firmware/core. docs/rod.md has the
 * equations. May include: core_state.h. */
#ifndef SELD_ROD_H
#define SELD_ROD_H

#include "firmware/core/core_state.h"

/* num / den for den > 0. Format: same Q in -> Q(q), q <= 30. Overflow: saturates. Error: 2^-29 relative. */
static inline int32_t seld_quotient(int32_t num, int32_t den, unsigned q)
{
    unsigned lead = seld_clz32((uint32_t)den) - 1;
    int64_t inverse = seld_reciprocal_q30((uint32_t)den << lead); /* 2^61 / (den 2^lead) */
    return seld_sat32(seld_rshift_round64(num * inverse, 61 - lead - q));
}

/* rod_feed.c: hand -> feed and base angle, nodes freed or captured, predicted configuration and inertia. */
void seld_rod_feed(const seld_model *model, seld_state *state, const seld_input *input);

/* rod_force.c: edges (tangents, strain, axial forces) at the predicted configuration; then, with the twisting moments
 * known, bending and twist forces and the rows of the matrix. */
void seld_rod_stretch(const seld_model *model, seld_state *state);
void seld_rod_bend(const seld_model *model, seld_state *state);

/* The joint at node i as this tick sees it: clipped at the mouth for i = na-1 and na. */
static inline const seld_joint *seld_rod_joint(const seld_model *model, const seld_state *state, uint32_t i)
{
    uint32_t na = state->words.free_count;
    return i + 1 < na ? &model->joints[i] : &state->scratch.mouth[i + 1 - na];
}

/* Has the joint a rest shape that its frames must be known for? */
static inline bool seld_rod_is_curved(const seld_joint *joint)
{
    return (joint->turn1_q30 | joint->turn2_q30) != 0;
}

/* One edge's half of a joint's rest turning vector g, times the share that is in force. Q30. */
void seld_rod_rest_turn(const seld_joint *joint, int32_t release_q30, const seld_vec3 *axis1,
                        const seld_vec3 *tangent, seld_vec3 *half);

/* rod_contact.c: wall contact and friction at the predicted configuration. */
void seld_contact_assemble(const seld_model *model, seld_state *state);
/* Looks for contacts the prediction missed, given the solution and its largest component; returns how many it added. */
uint32_t seld_contact_missed(const seld_model *model, seld_state *state, int32_t largest_m_q33);
/* Friction bristles after the solve; fills the output's contact fields. */
void seld_contact_finish(const seld_model *model, seld_state *state, seld_output *output);

/* rod_solve.c: block LDL^T from tip to base and back; solution in scratch, Q33 m. */
void seld_rod_solve(const seld_model *model, seld_state *state);

/* rod_twist.c: material frames and twisting moments at the predicted configuration. */
void seld_rod_twist(const seld_model *model, seld_state *state);

/* rod_advance.c: new positions; fills the output's length error. */
void seld_rod_advance(const seld_model *model, seld_state *state, seld_output *output);

/* core_state.c: the cheap hash of every tick. */
void seld_state_hash_lanes(const seld_state *state, uint32_t lane[2]);

#endif
