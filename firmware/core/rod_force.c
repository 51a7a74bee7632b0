/* This file computes the elastic forces at the predicted configuration x* (docs/rod.md, "energy" and "rows");
 * the matrix is in rod_solve.c.
 *
 *     edge    w = (x*[i+1] - x*[i]) / l,  strain from |w|^2 by series (no root),  F = EA strain
 *             S = (k_s - k_g) t t^T + k_g I,  k_g = max(F, 0) / l plus what twist adds there, at most k_s
 *     joint   b = w[i] - w[i-1],  v = W (b - g),  f[i-1] -= a v,  f[i] += (a + c) v,  f[i+1] -= c v
 *
 * The vector g is the sum of the tools' rest rotations, that is, of the angles of their stress-free shapes.
 * The twisting moment tau of the tools bends their common centreline with the force F = tau kb / 2, where kb
 * = 2 t x t' / (1 + t.t') is the curvature vector of a joint between edges with the tangents t and t'. */
#include "firmware/core/lanes.h"
#include "firmware/core/rod.h"

enum {
    STRAIN_SMALL_Q30 = 1 << 27, /* up to 12.5 % strain a series gives the direction too, */
    STRAIN_MAX_Q30 = 1 << 28,   /* up to 25 % a root gives it: 13 % were seen where the soft end of a wire
                                   folds; clamped beyond */
    W_MAX_Q30 = 1503238553,     /* 1.4: |w|^2 and the square of a difference of two fit 64 bits */
    TENSION_STIFF_MAX_N_Q22 = 32 << 22,
    /* Limits the force of one joint on one node. Straightening the curve of a 6F guiding catheter (R is 7 mm)
     * in elements of 1 mm needs 52 N. The largest force seen was 91 N, when hands pushed this curve through
     * the sheath's distal end, which bends it the other way. Twice the limit PART_MAX_N_Q22 fits 32 bits. */
    PART_MAX_N_Q22 = 240 << 22,
};

/* Adds one force component. Overflow: the sum of the forces saturates at 512 N; the solve (rod_solve.c)
 * limits forces to a smaller value. */
static inline void add(crn_vec3 *sum, int k, int32_t value)
{
    sum->v[k] = crn_add_sat(sum->v[k], value);
}

/* Two functions return the strain sqrt(1 + 2e) - 1 and the inverse length of an edge from e = (|w|^2 - 1) /
 * 2, where w is the edge's vector divided by its unloaded length. The series has the error e^4 * 5/8, which
 * is at most 2.4e-3 for a strain e of 25 %, 1.5e-4 for 12.5 %, and below 1e-8 for 1 %. */
static int32_t strain_of(int32_t e)
{
    int32_t e2 = crn_scale_q30(e, e);
    return e - (e2 >> 1) + (crn_scale_q30(e2, e) >> 1);
}
static int32_t inverse_stretch_of(int32_t e)
{
    int32_t e2 = crn_scale_q30(e, e);
    return CRN_ONE_Q30 - e + e2 + (e2 >> 1) - ((crn_scale_q30(e2, e) * 5) >> 1);
}

/* Returns the vector w of the edge between two positions, which is the difference of the positions divided by
 * the edge's unstretched length l. Format: positions Q30 m, 1/l Q18 -> Q30 (floor: the same in all
 * directions, so that it bends no joint). Overflow: saturates component by component. */
static crn_vec3 relative(int32_t inverse_per_m_q18, const crn_vec3 *from, const crn_vec3 *to)
{
    crn_vec3 w;
    uint32_t unseen = 0; /* the strain reports it */
    for (int k = 0; k < 3; k++) {
        int64_t product = (int64_t)crn_sub_sat(to->v[k], from->v[k]) * inverse_per_m_q18 + (1 << 17);
        w.v[k] = crn_limit64(product, 18, 1 << 17, 0, &unseen);
    }
    return w;
}

/* Computes the vector w, the tangent t and the strain of the edge between two positions. The square of the
 * length of w is at most 3 x 2^62, which fits an unsigned 64-bit number. */
static int32_t stretch_of(int32_t inverse_per_m_q18, const crn_vec3 *from, const crn_vec3 *to, crn_vec3 *w,
                          crn_vec3 *t, uint32_t *fault_bits)
{
    *w = relative(inverse_per_m_q18, from, to);
    uint64_t square = (uint64_t)((int64_t)w->v[0] * w->v[0]) + (uint64_t)((int64_t)w->v[1] * w->v[1]) +
                      (uint64_t)((int64_t)w->v[2] * w->v[2]);
    int64_t excess = (int64_t)(square - ((uint64_t)1 << 60)); /* twice e, Q60 */
    int32_t high = crn_high64(excess);
    if (high >= STRAIN_SMALL_Q30 / 2 || high < -STRAIN_SMALL_Q30 / 2) {
        if (high < STRAIN_MAX_Q30 / 2 && high >= -STRAIN_MAX_Q30 / 2) {
            *t = crn_vec3_normalise(*w, *t, NULL);
            return strain_of(crn_narrow64(excess, 31));
        }
        *fault_bits |= CRN_FAULT_SATURATED;
        for (int k = 0; k < 3; k++) {
            w->v[k] = crn_clamp(w->v[k], -W_MAX_Q30, W_MAX_Q30);
        }
        *t = crn_vec3_normalise(*w, *t, NULL);
        return strain_of(crn_vec3_dot64(*w, *w) > (int64_t)1 << 60 ? STRAIN_MAX_Q30 : -STRAIN_MAX_Q30);
    }
    int32_t e = crn_narrow64(excess, 31);
    int32_t inverse = inverse_stretch_of(e);
    for (int k = 0; k < 3; k++) {
        t->v[k] = crn_scale_q30(w->v[k], inverse);
    }
    return strain_of(e);
}

/* Returns the geometric stiffness k_g of an edge in Q(a), which is its tension / length, and 0 when the edge
 * is in compression. */
static int32_t geometric_stiffness(int32_t tension_N_q22, int32_t inverse_per_m_q18, unsigned exponent)
{
    if (tension_N_q22 <= 0) {
        return 0;
    }
    int32_t pull = tension_N_q22 < TENSION_STIFF_MAX_N_Q22 ? tension_N_q22 : TENSION_STIFF_MAX_N_Q22;
    int32_t stiffness_q8 = crn_mulh(pull, inverse_per_m_q18); /* below 2^26: 2^27 N Q22 x 2^31 */
    return exponent >= 8 ? stiffness_q8 << (exponent - 8) : stiffness_q8 >> (8 - exponent);
}

/* Computes the geometry and the axial force F of edge i, and adds +-F t to its two nodes. */
static void edge_forces(const crn_model *model, crn_state *state, uint32_t i)
{
    crn_work *here = &state->scratch.nodes[i];
    crn_work *next = here + 1;
    int32_t inverse = model->mesh[i].inverse_length_per_m_q18;
    crn_vec3 *tangent = &state->words.nodes[i].tangent_q30;
    here->strain_q30 = stretch_of(inverse, &here->position_m_q30, &next->position_m_q30,
                                  &here->u.a.stretch_q30, tangent, &state->words.fault_bits);
    /* Q17 N x Q30 -> Q22 N */
    int32_t tension = crn_limit64((int64_t)state->line.nodes[i].axial_stiffness_N_q17 * here->strain_q30, 25,
                                  CRN_TENSION_MAX_N_Q22 >> 7, CRN_FAULT_SATURATED, &state->words.fault_bits);
    here->geometric = geometric_stiffness(tension, inverse, model->stiffness_exponent);
    for (int k = 0; k < 3; k++) {
        int32_t pull = crn_scale_q30(tension, tangent->v[k]);
        add(&here->force_N_q22, k, pull);
        add(&next->force_N_q22, k, -pull);
    }
}

#if CRN_HAS_LANES
/* As stretch_of(), for lanes. Returns the strain, and writes w and the tangent; *tangent_q30 has the sign. */
CRN_LANES_INLINE int32_t lanes_stretch_of(int32_t inverse_per_m_q18, const crn_work *from, crn_vec3 *w,
                                          crn_vec3 *t, crn_lanes *tangent_q30, uint32_t *fault_bits)
{
    const crn_lanes way =
        crn_lanes_sat32(crn_lanes_read(from[1].position_m_q30.v) - crn_lanes_read(from->position_m_q30.v));
    const crn_lanes product =
        crn_lanes_product(way, crn_lanes_all(inverse_per_m_q18)) + crn_lanes_all(1 << 17);
    const crn_lanes edge = crn_lanes_sat32(crn_lanes_asr(product, 18));
    const crn_lanes squares = crn_lanes_product(edge, edge);
    const uint64_t square = (uint64_t)squares[0] + (uint64_t)squares[1] + (uint64_t)squares[2];
    const int64_t excess = (int64_t)(square - ((uint64_t)1 << 60));
    const int32_t high = crn_high64(excess);
    if (high >= STRAIN_SMALL_Q30 / 2 || high < -STRAIN_SMALL_Q30 / 2) {
        const int32_t strain =
            stretch_of(inverse_per_m_q18, &from->position_m_q30, &from[1].position_m_q30, w, t, fault_bits);
        *tangent_q30 = (crn_lanes){t->v[0], t->v[1], t->v[2], 0};
        return strain;
    }
    const int32_t e = crn_narrow64(excess, 31);
    *tangent_q30 = crn_lanes_scale_q30(edge, crn_lanes_all(inverse_stretch_of(e)));
    crn_lanes_write3(w->v, edge);
    crn_lanes_write3(t->v, *tangent_q30);
    return strain_of(e);
}

/* As edge_forces() for all edges. The force on the node behind an edge stays in a register. */
CRN_LANES_TARGET static void lanes_stretch(const crn_model *model, crn_state *state)
{
    crn_work *here = state->scratch.nodes;
    crn_lanes force = crn_lanes_read(here->force_N_q22.v);
    for (uint32_t i = 0; i < state->words.free_count; i++, here++) {
        const int32_t inverse = model->mesh[i].inverse_length_per_m_q18;
        crn_lanes tangent;
        here->strain_q30 =
            lanes_stretch_of(inverse, here, &here->u.a.stretch_q30, &state->words.nodes[i].tangent_q30,
                             &tangent, &state->words.fault_bits);
        const int32_t tension =
            crn_limit64((int64_t)state->line.nodes[i].axial_stiffness_N_q17 * here->strain_q30, 25,
                        CRN_TENSION_MAX_N_Q22 >> 7, CRN_FAULT_SATURATED, &state->words.fault_bits);
        here->geometric = geometric_stiffness(tension, inverse, model->stiffness_exponent);
        const crn_lanes pull = crn_lanes_scale_q30(crn_lanes_all(tension), tangent);
        crn_lanes_write3(here->force_N_q22.v, crn_lanes_sat32(force + pull));
        force = crn_lanes_sat32(crn_lanes_read(here[1].force_N_q22.v) - pull);
    }
    crn_lanes_write3(here->force_N_q22.v, force);
}
#endif

static void stretch_edges(const crn_model *model, crn_state *state)
{
#if CRN_HAS_LANES
    if (model->has_lanes) {
        lanes_stretch(model, state);
        return;
    }
#endif
    for (uint32_t i = 0; i < state->words.free_count; i++) {
        edge_forces(model, state, i);
    }
}

void crn_rod_stretch(const crn_model *model, crn_state *state)
{
    uint32_t na = state->words.free_count;
    stretch_edges(model, state);
    /* The edge behind node na (the first held node) is straight inside the introducer sheath. */
    state->scratch.nodes[na].u.a.stretch_q30 = state->words.nodes[na].tangent_q30;
}

void crn_rod_rest_turn(const crn_joint *joint, uint32_t tool, int32_t release_q30, const crn_vec3 *axis1,
                       const crn_vec3 *tangent, crn_vec3 *half)
{
    crn_vec3 axis2 = crn_vec3_cross_unit(tangent, axis1);
    int32_t turn1 =
        crn_rest_and_set(crn_scale_q30(joint->turn1_q30[tool], release_q30), joint->set_q14[tool][0]);
    int32_t turn2 =
        crn_rest_and_set(crn_scale_q30(joint->turn2_q30[tool], release_q30), joint->set_q14[tool][1]);
    for (int k = 0; k < 3; k++) {
        int64_t sum = (int64_t)crn_scale_q30(turn1, axis1->v[k]) + crn_scale_q30(turn2, axis2.v[k]);
        half->v[k] = (int32_t)(sum >> 1);
    }
}

/* Computes 1 / (1 + c) and `lack` = 1 - c in Q30, where c is the cosine of the angle between two edges. For
 * small angles, 1 / (1 + c) with the cosine c = 1 - lack is the series 1/2 + lack/4 + lack^2/8, which is
 * accurate to 1e-4 at 40 degrees. For angles above 90 degrees, the function returns the values for 90
 * degrees. Rounding may make the cosine of nearly straight edges more than one, so `lack` is limited to 0 ..
 * 1. Overflow: impossible, 7/8 at most. */
static int32_t inverse_of_one_and(int32_t cosine_q30, int32_t *lack_q30)
{
    const int32_t lack = CRN_ONE_Q30 - crn_clamp(cosine_q30, 0, CRN_ONE_Q30);
    *lack_q30 = lack;
    return (CRN_ONE_Q30 >> 1) + (lack >> 2) + (crn_scale_q30(lack, lack) >> 3);
}

/* Returns the force term tau kb / 2 = tau (t x t') / (1 + t.t'), with which the twisting moment tau bends the
 * tool at a joint between edges with the tangents t and t'. Format: tau Q30 N m -> Q30 N m. Overflow is
 * impossible, because the factor of the twisting moment tau is at most 7/8. */
static crn_vec3 twist_force(int32_t torque_N_m_q30, const crn_vec3 *before, const crn_vec3 *after)
{
    int32_t lack = 0;
    int32_t inverse = inverse_of_one_and(crn_vec3_dot_unit(before, after), &lack);
    int32_t scaled = crn_scale_q30(torque_N_m_q30, inverse);
    crn_vec3 across = crn_vec3_cross_unit(before, after);
    for (int k = 0; k < 3; k++) {
        across.v[k] = crn_scale_q30(scaled, across.v[k]);
    }
    return across;
}

/* If the two edges of a bent joint tilt by d and d' out of the plane of the joint, the joint twists by |kb| /
 * 2 times the length of d + d', where kb is the curvature vector of the joint. Where a tool's curved rest
 * shape fixes its material frames, the twist stiffness GJ resists the twist of a bent joint. The resistance
 * to twist at a joint adds its force to the right side of the linear system, and k |kb|^2 / 4 (|d|^2 +
 * |d'|^2) to the matrix (k: twist stiffness, kb: curvature vector, d and d': tilts of the two edges). The
 * matrix term of the resistance to twist is at least half of the resistance. With the matrix term for twist
 * an oscillation does not grow, and the other terms of the matrix damp it. Without the matrix term of the
 * resistance to twist, a J-shaped wire tip of 1.5 mm radius oscillated by 11 um for ever (docs/rod.md,
 * "rows"). Tools that are straight at the joint when free of stress turn freely and add nothing to the twist
 * resistance. Overflow is impossible: the sum of the tools' twisting moments is limited to 32 bits, and the
 * product of this sum and a factor of at most 7/8 fits. The sum of the matrix term for twist and the
 * geometric stiffness k_g is limited to the edge's axial stiffness. */
static void resist_twist(const crn_model *model, crn_state *state, const crn_joint *joint, uint32_t i)
{
    const crn_node_state *node = &state->words.nodes[i];
    int64_t twist_N_m_q26 = 0;
    for (uint32_t k = 0; k < model->tool_count; k++) {
        twist_N_m_q26 += joint->curved >> k & 1u ? joint->twist_N_m_q26[k] : 0;
    }
    int32_t lack = 0;
    const int32_t inverse =
        inverse_of_one_and(crn_vec3_dot_unit(&node[-1].tangent_q30, &node->tangent_q30), &lack);
    const int32_t held_N_m_q26 = crn_scale_q30(crn_sat32(twist_N_m_q26), crn_scale_q30(lack, inverse));
    for (uint32_t edge = i - 1; edge <= i && edge < state->words.free_count; edge++) {
        const int32_t a = model->mesh[edge].inverse_length_per_m_q18;
        const int32_t spring = state->line.nodes[edge].spring;
        int32_t *geometric = &state->scratch.nodes[edge].geometric;
        const int32_t sum = crn_add_sat(
            *geometric, crn_to_exponent(crn_bend_spring_q8(held_N_m_q26, a, a), model->stiffness_exponent));
        *geometric = sum < spring ? sum : spring;
    }
}

/* Returns v / l, one component of the force that a joint exerts on a neighbouring node. The force of a joint
 * on a node is limited to 240 N, thirty times the force that a hand can cause by bending. Format: Q30 N m x
 * Q18 -> Q22 N, rounded. */
static inline int32_t part(int32_t moment_N_m_q30, int32_t inverse_per_m_q18, uint32_t *fault_bits)
{
    int64_t force = (int64_t)moment_N_m_q30 * inverse_per_m_q18 + (1 << 25);
    return crn_limit64(force, 26, PART_MAX_N_Q22 / 64, CRN_FAULT_SATURATED, fault_bits);
}

/* Returns the bending moment W b of a joint. Format: Q26 N m x Q28 -> Q30 N m, floor. Overflow: the moment
 * saturates at 2 N m, which gives 240 N on an edge of 8 mm. */
static inline int32_t moment_of(int32_t bend_N_m_q26, int32_t turn_q28)
{
    uint32_t unseen = 0; /* the force reports it */
    return crn_limit64((int64_t)bend_N_m_q26 * turn_q28 + (1 << 23), 24, 1 << 23, 0, &unseen);
}

crn_vec3 crn_rod_tool_turn(const crn_state *state, const crn_joint *joint, uint32_t tool, uint32_t i)
{
    const crn_work *here = &state->scratch.nodes[i];
    int32_t release = state->words.release_q30;
    crn_vec3 half_ahead, half_here;
    crn_rod_rest_turn(joint, tool, release, &here[-1].u.a.axis1_q30[tool],
                      &state->words.nodes[i - 1].tangent_q30, &half_ahead);
    crn_rod_rest_turn(joint, tool, release, &here->u.a.axis1_q30[tool], &state->words.nodes[i].tangent_q30,
                      &half_here);
    return crn_vec3_add(half_ahead, half_here);
}

crn_vec3 crn_rod_line_turn(const crn_model *model, const crn_state *state, const crn_joint *joint, uint32_t i)
{
    crn_vec3 turn = {{0, 0, 0}};
    for (uint32_t k = 0; k < model->tool_count; k++) {
        if (joint->curved >> k & 1u) {
            turn = crn_vec3_add(turn, crn_rod_tool_turn(state, joint, k, i));
        }
    }
    return turn;
}

/* Adds the forces of bending and twist at the joint of node i (1 .. na). Format: W Q26 x b Q28 -> v Q30 N m;
 * a Q18 x v Q30 -> Q22 N. b loses two bits of the edges' Q30, below the step of a position. The two ends of
 * an edge get the same rounded force with opposite signs, so momentum is exactly conserved. */
static void joint_forces(const crn_model *model, crn_state *state, uint32_t i)
{
    crn_work *here = &state->scratch.nodes[i];
    crn_work *ahead = here - 1;
    const crn_joint *joint = crn_rod_joint(state, i);
    int32_t a = model->mesh[i - 1].inverse_length_per_m_q18;
    int32_t c = model->mesh[i].inverse_length_per_m_q18;
    uint32_t *faults = &state->words.fault_bits;
    crn_vec3 turn = {{0, 0, 0}};
    if (joint->curved != 0) {
        turn = crn_rod_line_turn(model, state, joint, i);
        resist_twist(model, state, joint, i);
    }
    crn_vec3 twisting = {{0, 0, 0}};
    if (here->torque_N_m_q30 != 0) {
        twisting = twist_force(here->torque_N_m_q30, &state->words.nodes[i - 1].tangent_q30,
                               &state->words.nodes[i].tangent_q30);
    }
    for (int k = 0; k < 3; k++) {
        int32_t bend_q28 = crn_asr32(here->u.a.stretch_q30.v[k], 2) -
                           crn_asr32(ahead->u.a.stretch_q30.v[k], 2) - crn_asr32(turn.v[k], 2);
        int32_t moment = moment_of(joint->bend_N_m_q26, bend_q28);
        int32_t front = part(crn_sub_sat(moment, twisting.v[k]), a, faults);
        int32_t back = part(crn_add_sat(moment, twisting.v[k]), c, faults);
        add(&ahead->force_N_q22, k, -front);
        add(&here->force_N_q22, k, front + back);
        add(&here[1].force_N_q22, k, -back);
    }
}

#if CRN_HAS_LANES
/* As part(), with the sign. Lanes of *limited become -1 where the force reaches its limit. */
CRN_LANES_INLINE crn_lanes lanes_part(crn_lanes moment_N_m_q30, int32_t inverse_per_m_q18, crn_lanes *limited)
{
    const crn_lanes product =
        crn_lanes_product(moment_N_m_q30, crn_lanes_all(inverse_per_m_q18)) + crn_lanes_all(1 << 25);
    const crn_lanes force = crn_lanes_asr(product, 26);
    *limited |= (force > crn_lanes_all(PART_MAX_N_Q22 - 1)) | (crn_lanes_all(-PART_MAX_N_Q22) > force);
    return crn_lanes_clamp(force, PART_MAX_N_Q22);
}

/* As twist_force(), with the sign. */
CRN_LANES_INLINE crn_lanes lanes_twist_force(int32_t torque_N_m_q30, const crn_vec3 *before,
                                             const crn_vec3 *after)
{
    int32_t lack = 0;
    const int32_t inverse = inverse_of_one_and(crn_vec3_dot_unit(before, after), &lack);
    const crn_lanes across = crn_lanes_cross_unit(crn_lanes_read(before->v), crn_lanes_read(after->v));
    return crn_lanes_scale_q30(crn_lanes_all(crn_scale_q30(torque_N_m_q30, inverse)), across);
}

/* Returns the bending moment of a joint, as moment_of() does, with the sign. */
CRN_LANES_INLINE crn_lanes lanes_moment(const crn_model *model, crn_state *state, const crn_joint *joint,
                                        uint32_t i)
{
    const crn_work *here = &state->scratch.nodes[i];
    crn_words4 ahead, behind;
    __builtin_memcpy(&ahead, here[-1].u.a.stretch_q30.v, sizeof ahead);
    __builtin_memcpy(&behind, here->u.a.stretch_q30.v, sizeof behind);
    crn_words4 bend_q28 = (behind >> 2) - (ahead >> 2);
    if (joint->curved != 0) {
        const crn_vec3 turn = crn_rod_line_turn(model, state, joint, i);
        resist_twist(model, state, joint, i);
        bend_q28 -= (crn_words4){turn.v[0], turn.v[1], turn.v[2], 0} >> 2;
    }
    const crn_lanes bend = __builtin_convertvector(bend_q28, crn_lanes);
    const crn_lanes product = crn_lanes_product(bend, crn_lanes_all(joint->bend_N_m_q26));
    return crn_lanes_sat32(crn_lanes_asr(product + crn_lanes_all(1 << 23), 24));
}

/* As joint_forces() for all joints. The forces on two nodes stay in registers. */
CRN_LANES_TARGET static void lanes_bend(const crn_model *model, crn_state *state)
{
    crn_work *here = &state->scratch.nodes[1];
    const crn_node_state *node = &state->words.nodes[1];
    crn_lanes limited = crn_lanes_all(0);
    crn_lanes ahead_force = crn_lanes_read(here[-1].force_N_q22.v),
              force = crn_lanes_read(here->force_N_q22.v);
    for (uint32_t i = 1; i <= state->words.free_count; i++, here++, node++) {
        const crn_joint *joint = crn_rod_joint(state, i);
        const crn_lanes moment = lanes_moment(model, state, joint, i);
        crn_lanes twisting = crn_lanes_all(0);
        if (here->torque_N_m_q30 != 0) {
            twisting = lanes_twist_force(here->torque_N_m_q30, &node[-1].tangent_q30, &node->tangent_q30);
        }
        const crn_lanes front = lanes_part(crn_lanes_sat32(moment - twisting),
                                           model->mesh[i - 1].inverse_length_per_m_q18, &limited);
        const crn_lanes back =
            lanes_part(crn_lanes_sat32(moment + twisting), model->mesh[i].inverse_length_per_m_q18, &limited);
        crn_lanes_write3(here[-1].force_N_q22.v, crn_lanes_sat32(ahead_force - front));
        ahead_force = crn_lanes_sat32(force + front + back);
        force = crn_lanes_sat32(crn_lanes_read(here[1].force_N_q22.v) - back);
    }
    crn_lanes_write3(here[-1].force_N_q22.v, ahead_force);
    crn_lanes_write3(here->force_N_q22.v, force);
    if ((limited[0] | limited[1] | limited[2]) != 0) {
        state->words.fault_bits |= CRN_FAULT_SATURATED;
    }
}
#endif

void crn_rod_bend(const crn_model *model, crn_state *state)
{
#if CRN_HAS_LANES
    if (model->has_lanes) {
        lanes_bend(model, state);
        return;
    }
#endif
    for (uint32_t i = 1; i <= state->words.free_count; i++) {
        joint_forces(model, state, i);
    }
}

/* Tools with the curvature kappa at the distal end of the introducer sheath push on the sheath along its axis
 * with the force EI kappa^2 / 2, because the part that is fed in has to be straight. The push of bent tools
 * on the sheath is the configurational force of a sliding sleeve (Bigoni et al. 2014, Mechanics Research
 * Communications). The sheath's distal end cuts the cell of one joint, and `part` is the length of this cell
 * outside the sheath. A joint whose cell is cut to the length `part` has the bending stiffness W = EI / part,
 * and the angle between its edges is the curvature kappa times `part`. Format: Q26 N m x Q30^2 -> Q30 N m, /
 * Q30 m -> Q22 N. */
int32_t crn_mouth_axial(const crn_model *model, const crn_state *state)
{
    uint32_t na = state->words.free_count;
    int32_t inserted = crn_lead_inserted(model, &state->words);
    uint32_t cut = inserted > model->mesh[na - 1].cell_end_m_q30 ? na : na - 1;
    int32_t part = inserted - model->mesh[cut - 1].cell_end_m_q30;
    const crn_joint *joint = &state->scratch.mouth[cut + 1 - na];
    int32_t whole = state->line.nodes[cut].joint.bend_N_m_q26;
    int64_t square = 0;
    for (int k = 0; k < 3; k++) {
        int64_t bend = (int64_t)state->scratch.nodes[cut].u.a.stretch_q30.v[k] -
                       state->scratch.nodes[cut - 1].u.a.stretch_q30.v[k];
        square += (bend * bend) >> 30;
    }
    int32_t energy = crn_mul(crn_sat32(square >> 1), joint->bend_N_m_q26, 26);
    /* the part that the joint's stiffness represents */
    int32_t cell = model->mesh[cut].cell_end_m_q30 - model->mesh[cut - 1].cell_end_m_q30;
    int32_t least = crn_mul(cell, crn_quotient(whole, joint->bend_N_m_q26, 30), 30);
    return -crn_quotient(energy, part > least ? part : least, 22);
}

/* Computes the bending moments W b of all joints at the predicted configuration, as if all tools were
 * straight when free of stress. Format: b in Q29 so that it fits, W Q26 -> Q30 N m, limited. */
void crn_bending_moments(crn_state *state)
{
    for (uint32_t i = 1; i <= state->words.free_count; i++) {
        crn_work *here = &state->scratch.nodes[i];
        int32_t bend_N_m_q26 = crn_rod_joint(state, i)->bend_N_m_q26;
        const crn_vec3 bend = crn_joint_bend(state, i);
        for (int c = 0; c < 3; c++) {
            here->moment_N_m_q30.v[c] = crn_limited_shift(crn_product(bend.v[c], bend_N_m_q26), 25, 29);
        }
    }
}
