/* This header computes the friction of one node on the vessel wall: its largest force and its stiffness in
 * the matrix (docs/rod.md, "Contact"). */
#ifndef CRN_CORE_ROD_FRICTION_H
#define CRN_CORE_ROD_FRICTION_H

#include "firmware/core/rod.h"

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

#endif
