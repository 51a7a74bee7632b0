/* This file computes the reference and material axes of the edges at the predicted configuration.
 *
 * Each edge has a reference axis u, which all tools share. The code carries the reference axis u over from
 * edge to edge, from the introducer sheath to the tip, without rotation about the tangent (Bishop frame). A
 * tool's material axis is d1 = cos(angle) u + sin(angle) (t x u), where u is the reference axis and t the
 * tangent, so the twist of a joint is simply the difference of two angles (docs/rod.md, "twist"). */
#include "firmware/core/rod.h"

enum {
    LACK_FAST_Q30 = 1 << 28, /* 1 - t.t' up to 1/4 (41 degrees per joint): series for 1 / (1 + t.t') */
    FOLD_Q30 = 1 << 28,      /* 1 + t.t' below 1/4 (beyond 139 degrees): no transport, only a projection */
};

/* All vectors of this file have unit length and all factors are below one, so sums and products fit Q30. */
static void add_scaled(crn_vec3 *sum, const crn_vec3 *direction_q30, int32_t amount)
{
    for (int k = 0; k < 3; k++) {
        sum->v[k] += crn_scale_q30(amount, direction_q30->v[k]);
    }
}

void crn_frames_orthonormalise(crn_vec3 *axis, const crn_vec3 *tangent)
{
    add_scaled(axis, tangent, -crn_vec3_dot_unit(axis, tangent));
    int32_t excess = (int32_t)((crn_vec3_dot64(*axis, *axis) - ((int64_t)1 << 60)) >> 31);
    for (int k = 0; k < 3; k++) {
        axis->v[k] = crn_scale_q30(axis->v[k], CRN_ONE_Q30 - excess);
    }
}

/* Carries the reference axis over to the next edge across a sharp bend. Up to a bend of 139 degrees the axis
 * is transported exactly; beyond that angle the old axis is only projected. */
static crn_vec3 transport_sharply(crn_vec3 axis, const crn_vec3 *from, const crn_vec3 *to, int32_t tilt,
                                  int32_t lack)
{
    uint32_t sum = ((uint32_t)CRN_ONE_Q30 << 1) - (uint32_t)lack; /* 1 + t.t' */
    if (sum < FOLD_Q30) {
        add_scaled(&axis, to, -tilt);
        return crn_vec3_normalise(axis, *from, NULL);
    }
    int32_t ratio_q27 = crn_quotient(tilt, (int32_t)(sum > INT32_MAX ? INT32_MAX : sum), 27);
    for (int k = 0; k < 3; k++) {
        int64_t moved = (int64_t)ratio_q27 * from->v[k] + (int64_t)ratio_q27 * to->v[k];
        axis.v[k] = crn_sat32(axis.v[k] - crn_rshift_round64(moved, 27));
    }
    crn_frames_orthonormalise(&axis, to);
    return axis;
}

/* Returns u - (u.t') / (1 + t.t') (t + t'), which is the parallel transport of the axis u from the tangent t
 * to the tangent t'. */
static crn_vec3 transport(crn_vec3 axis, const crn_vec3 *from, const crn_vec3 *to)
{
    int32_t tilt = crn_vec3_dot_unit(&axis, to);
    int32_t lack = crn_sub_sat(CRN_ONE_Q30, crn_vec3_dot_unit(from, to));
    if (lack > LACK_FAST_Q30) {
        return transport_sharply(axis, from, to, tilt, lack);
    }
    /* 1 / (1 + c) = 1/2 + lack/4 + lack^2/8 + lack^3/16 */
    int32_t square = crn_scale_q30(lack, lack);
    int32_t inverse = (CRN_ONE_Q30 >> 1) + (lack >> 2) + (square >> 3) + (crn_scale_q30(square, lack) >> 4);
    int32_t amount = -crn_scale_q30(tilt, inverse);
    for (int k = 0; k < 3; k++) {
        int32_t middle_q29 = crn_asr32(from->v[k], 1) + crn_asr32(to->v[k], 1); /* half the sum, within one */
        axis.v[k] += crn_mulh(amount, middle_q29) * 8;
    }
    return axis;
}

/* Computes the material axis d1 of an edge from the edge's reference axis and angle. */
static void material_axis(const crn_vec3 *reference, const crn_vec3 *tangent, uint32_t angle_turn32,
                          crn_vec3 *axis1)
{
    int32_t sine, cosine;
    crn_sincos_turn32(angle_turn32, &sine, &cosine);
    crn_vec3 across = crn_vec3_cross_unit(tangent, reference);
    for (int k = 0; k < 3; k++) {
        axis1->v[k] = crn_scale_q30(reference->v[k], cosine) + crn_scale_q30(across.v[k], sine);
    }
    crn_frames_orthonormalise(axis1, tangent);
}

/* Computes the edges' reference axes from the introducer sheath to the tip, and the tools' material axes at
 * edges where a curved rest shape needs them. */
void crn_frames_carry(const crn_model *model, crn_state *state)
{
    crn_node_state *nodes = state->words.nodes;
    uint32_t na = state->words.free_count;
    crn_vec3 reference = model->base_axis1_q30;
    uint32_t last = 0; /* no edge beyond it needs an axis */
    while (last <= na && crn_edge_curved(state, last) == 0) {
        last++;
    }
    for (uint32_t n = na + 1; n > last; n--) {
        uint32_t j = n - 1;
        if (j < na) {
            reference = transport(reference, &nodes[j + 1].tangent_q30, &nodes[j].tangent_q30);
        }
        uint32_t curved = crn_edge_curved(state, j);
        if (curved == 0) {
            continue;
        }
        crn_frames_orthonormalise(&reference, &nodes[j].tangent_q30);
        for (uint32_t k = 0; k < model->tool_count; k++) {
            if (curved >> k & 1u) {
                material_axis(&reference, &nodes[j].tangent_q30, nodes[j].angle_turn32[k],
                              &state->scratch.nodes[j].u.a.axis1_q30[k]);
            }
        }
    }
}
