/* From the hand to the predicted configuration: how far the instrument is fed this tick, which nodes that
 * frees or captures, and where every node would be if the rod only slid along itself (x* = x - T ds). The
 * solve then finds the deviation from that slide, so that a fast feed puts no force of its own into the right
 * side (docs/rod.md, "feed"). May include: rod.h. Called by: core_step.c. */
#include "firmware/core/rod.h"

enum {
    FOLLOW_SHIFT = 2, /* the feed covers a quarter of the hand's lead each tick */
    WALL_COMPLIANCE_m_N_Q40 =
        43980465, /* 4e-5 m/N: the contact that blocks the tip, k_c + k_deep = 25 kN/m */
};

static int32_t clamp32(int32_t value, int32_t low, int32_t high)
{
    return value < low ? low : (value > high ? high : value);
}

/* Feed that brings the handle to its force limit: (F_max - H) x compliance of the free part and the wall.
 * Format: N Q22 x m/N Q40 -> m Q30. Overflow: saturates at the feed limit. */
static int32_t stall_limit(int32_t margin_N_q22, uint32_t compliance_m_N_q40)
{
    if (margin_N_q22 <= 0) {
        return 0;
    }
    int64_t limit = (int64_t)(((uint64_t)(uint32_t)margin_N_q22 * compliance_m_N_q40) >> 32);
    return limit > SELD_FEED_MAX_M_Q30 ? SELD_FEED_MAX_M_Q30 : (int32_t)limit;
}

/* Feed of this tick in metres Q30. The hand may lead by four times the largest feed; beyond that it slips, as
 * a hand does on a wire or a wire in the rig's rollers. */
static int32_t choose_feed(const seld_model *model, seld_state_words *words, int32_t hand_m_q30)
{
    const int32_t lead_max = 4 * SELD_FEED_MAX_M_Q30;
    int64_t lead = (int64_t)hand_m_q30 + words->hand_offset_m_q30 - words->inserted_m_q30;
    if (lead > lead_max || lead < -lead_max) {
        int64_t kept = lead > 0 ? lead_max : -(int64_t)lead_max;
        words->hand_offset_m_q30 = seld_sat32(words->hand_offset_m_q30 - (lead - kept));
        words->fault_bits |= SELD_FAULT_FEED_LIMIT;
        lead = kept;
    }
    int32_t feed = (int32_t)lead / (1 << FOLLOW_SHIFT);
    uint32_t compliance = model->compliance_m_N_q40[words->free_count] + WALL_COMPLIANCE_m_N_Q40;
    int32_t push = stall_limit(seld_sub_sat(model->stall_N_q22, words->handle_axial_N_q22), compliance);
    int32_t pull = stall_limit(seld_add_sat(model->stall_N_q22, words->handle_axial_N_q22), compliance);
    feed = clamp32(feed, -pull, push);
    int32_t least = model->nodes[3].arc_m_q30 + 1024;
    int32_t most = model->nodes[model->node_count - 3].arc_m_q30;
    int32_t wanted = words->inserted_m_q30 + feed;
    int32_t allowed = clamp32(wanted, least, most);
    if (allowed != wanted) {
        words->fault_bits |= SELD_FAULT_INSERT_END;
    }
    return allowed - words->inserted_m_q30;
}

/* The inserter's material frame follows the hand's angle a quarter of the way each tick, at most 20 rad/s. */
static void turn_base(seld_state_words *words, uint32_t hand_turn32)
{
    int32_t lead = (int32_t)(hand_turn32 - words->base_turn32);
    int32_t turn = clamp32(lead / (1 << FOLLOW_SHIFT), -SELD_TURN_MAX_TURN32, SELD_TURN_MAX_TURN32);
    words->base_turn32 += (uint32_t)turn;
}

/* Position of a node inside the inserter: on its axis, arc - s behind the mouth. */
static seld_vec3 position_inside(const seld_model *model, const seld_state_words *words, uint32_t node)
{
    int32_t behind = model->nodes[node].arc_m_q30 - words->inserted_m_q30;
    seld_vec3 p = model->entry.position_m_q30;
    for (int k = 0; k < 3; k++) {
        p.v[k] -= seld_mul_q30(behind, model->entry.direction_q30.v[k]);
    }
    return p;
}

/* Node i and the edge behind it as they are inside the inserter: straight, unloaded, moving with the feed. */
static void place_inside(const seld_model *model, seld_state *state, uint32_t i)
{
    seld_node_state *node = &state->words.nodes[i];
    seld_work *work = &state->scratch.nodes[i];
    for (int k = 0; k < 3; k++) {
        node->tangent_q30.v[k] = -model->entry.direction_q30.v[k];
        node->step_m_q33.v[k] = seld_mul_q30(state->scratch.feed_m_q33, model->entry.direction_q30.v[k]);
    }
    node->position_m_q30 = position_inside(model, &state->words, i);
    node->angle_turn32 = 0u - state->words.base_turn32;
    node->bristle_m_q33 = (seld_vec3){{0, 0, 0}};
    node->contact = SELD_CONTACT_NONE;
    work->position_m_q30 = node->position_m_q30;
    work->slide_m_q33 = node->step_m_q33;
    work->drift_m_q33 = (seld_vec3){{0, 0, 0}};
    work->force_N_q22 = (seld_vec3){{0, 0, 0}};
}

/* A node freed this tick: x* is on the axis at the new feed, it came from there less the slide, under its weight. */
static void free_node(const seld_model *model, seld_state *state, uint32_t i)
{
    seld_work *work = &state->scratch.nodes[i];
    work->force_N_q22 = model->nodes[i].weight_N_q22;
    for (int k = 0; k < 3; k++) {
        state->words.nodes[i].position_m_q30.v[k] =
            work->position_m_q30.v[k] - ((work->slide_m_q33.v[k] + 4) >> 3);
    }
}

/* x* = x - T ds with the node's tangent T, and the inertia's right side m/h^2 ((1 - gamma h) u - slide).
 * Overflow: displacements per tick stay below 2^23 m Q33 (cap), inertia below 2^29: products below 2^60. */
static void slide_node(const seld_model *model, seld_state *state, uint32_t i)
{
    const seld_node *constant = &model->nodes[i];
    seld_node_state *node = &state->words.nodes[i];
    seld_work *work = &state->scratch.nodes[i];
    const seld_vec3 *ahead = &state->words.nodes[i > 0 ? i - 1 : 0].tangent_q30;
    int32_t feed = state->scratch.feed_m_q33;
    unsigned shift = model->stiffness_exponent + 11; /* Q(a) N/m x Q33 m -> Q22 N */
    for (int k = 0; k < 3; k++) {
        int32_t tangent = (int32_t)(((int64_t)ahead->v[k] + node->tangent_q30.v[k]) >> 1);
        int32_t slide = -seld_scale_q30(feed, tangent);
        int32_t drift = node->step_m_q33.v[k] - slide;
        int32_t kept = drift - seld_scale_q30(node->step_m_q33.v[k], SELD_DAMPING_KEEP_Q30);
        work->slide_m_q33.v[k] = slide;
        work->drift_m_q33.v[k] = drift;
        work->position_m_q30.v[k] = node->position_m_q30.v[k] + ((slide + 4) >> 3);
        work->force_N_q22.v[k] = constant->weight_N_q22.v[k] +
                                 (int32_t)seld_rshift_round64((int64_t)constant->inertia * kept, shift);
    }
}

/* The two joints at the mouth own only the part of their cell that lies outside it: W grows by cell / part,
 * the rest turning shrinks by part / cell. At least a tenth of the cell is kept for the stiffness. */
static void clip_joint(const seld_model *model, seld_state *state, uint32_t i)
{
    seld_joint *joint = &state->scratch.mouth[i + 1 - state->words.free_count];
    *joint = model->joints[i];
    int32_t from = model->nodes[i].arc_m_q30 - model->edges[i - 1].length_m_q30 / 2;
    int32_t cell = (model->edges[i - 1].length_m_q30 + model->edges[i].length_m_q30) / 2;
    int32_t part = state->words.inserted_m_q30 - from;
    if (part >= cell) {
        return;
    }
    int32_t tenth = (int32_t)(((int64_t)cell * 6554) >> 16);
    int32_t factor_q24 = seld_quotient(cell, part > tenth ? part : tenth, 24);
    joint->bend_N_m_q26 = seld_mul(joint->bend_N_m_q26, factor_q24, 24);
    joint->p = seld_mul(joint->p, factor_q24, 24);
    joint->q = seld_mul(joint->q, factor_q24, 24);
    joint->r = seld_mul(joint->r, factor_q24, 24);
    int32_t share_q24 = part <= 0 ? 0 : seld_quotient(part, cell, 24);
    joint->turn1_q30 = seld_mul(joint->turn1_q30, share_q24, 24);
    joint->turn2_q30 = seld_mul(joint->turn2_q30, share_q24, 24);
}

/* Nodes beyond the mouth once the tip has advanced to arc length s. A tick's feed passes at most eight nodes.
 */
static uint32_t count_free(const seld_model *model, const seld_state_words *words)
{
    uint32_t count = words->free_count;
    for (int step = 0; step < 8 && model->nodes[count].arc_m_q30 < words->inserted_m_q30; step++) {
        count++;
    }
    for (int step = 0; step < 8 && model->nodes[count - 1].arc_m_q30 >= words->inserted_m_q30; step++) {
        count--;
    }
    return count;
}

void seld_rod_feed(const seld_model *model, seld_state *state, const seld_input *input)
{
    seld_state_words *words = &state->words;
    int32_t feed = choose_feed(model, words, input->hand_feed_m_q30);
    state->scratch.feed_m_q33 = feed * 8;
    words->inserted_m_q30 += feed;
    turn_base(words, input->hand_turn32);
    if (words->release_q30 < SELD_ONE_Q30) {
        words->release_q30 += SELD_RELEASE_STEP_Q30;
    }
    uint32_t before = words->free_count;
    uint32_t now = count_free(model, words);
    words->free_count = now;
    uint32_t sliding = before < now ? before : now;
    for (uint32_t i = 0; i < sliding; i++) {
        slide_node(model, state, i);
    }
    for (uint32_t i = sliding; i < now + 3; i++) {
        place_inside(model, state, i);
        if (i < now) {
            free_node(model, state, i);
        }
    }
    for (int k = 0; k < 3; k++) {
        seld_vec3 *force = &state->scratch.nodes[0].force_N_q22;
        force->v[k] = seld_add_sat(force->v[k], model->tip_load_N_q22.v[k]);
    }
    clip_joint(model, state, now - 1);
    clip_joint(model, state, now);
}
