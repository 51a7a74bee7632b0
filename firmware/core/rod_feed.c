/* This file computes the predicted configuration of the tools from the positions of the user's hands. The
 * code computes the length by which each tool is fed in this tick, and which nodes this feed frees from the
 * introducer sheath or captures in it. The code also computes the position that every node would have if the
 * tools only slid along their centreline: x* = x - T ds, where ds is the displacement of the leading tip. The
 * linear system is then solved only for the deviation of each node from its predicted position x*, so a fast
 * feed adds no force to the right side of the linear system (docs/rod.md, "feed"). */
#include "firmware/core/lanes.h"
#include "firmware/core/rod.h"

enum {
    FOLD_Q28 = 265751102, /* 0.99: cos^2 of half a turn of 11.5 degrees from edge to edge */
    FOLLOW_SHIFT = 2,     /* the feed covers a quarter of the hand's lead each tick */
    /* 4e-5 m/N: compliance of the contact that blocks the tip, k_c + k_deep = 25 kN/m */
    WALL_COMPLIANCE_m_N_Q40 = 43980465,
    TURN32_TO_Q30_RAD = 1686629713, /* pi / 2 in Q30 */
};

/* Returns the feed at which the force H on a tool's handle reaches its limit F_max. The feed is the remaining
 * force F_max - H times the combined compliance of the wall and the tool's free part. If the force exceeds
 * its limit, the feed is negative, and the tool slips back slowly through the hand. Format: N Q22 x m/N Q40
 * -> m Q30. Overflow: the feed saturates at the largest feed that is permitted in a tick. */
static int32_t stall_limit(int32_t margin_N_q22, uint32_t compliance_m_N_q40)
{
    const int32_t slip_max = CRN_FEED_MAX_M_Q30 / 16;
    if (margin_N_q22 <= 0) {
        int64_t back = ((int64_t)margin_N_q22 * compliance_m_N_q40) >> 32;
        return back < -slip_max ? -slip_max : (int32_t)back;
    }
    int64_t limit = (int64_t)(((uint64_t)(uint32_t)margin_N_q22 * compliance_m_N_q40) >> 32);
    return limit > CRN_FEED_MAX_M_Q30 ? CRN_FEED_MAX_M_Q30 : (int32_t)limit;
}

/* Returns the compliance that the hand feels, that is, the hand's displacement per newton, in Q40 m/N. The
 * returned value is the compliance of the wall and of the tool's free part, or a smaller compliance that was
 * observed in the last ticks. If the wall's friction holds the front of the wire, the hand moves only the
 * rear part, and the observed compliance is smaller than that of the whole wire. The observed compliance may
 * grow by only 1/128 per tick. Because the observed compliance grows slowly, a single tick in which the tool
 * moves easily (after a snap or a pause) does not make a stiff tool seem soft (docs/rod.md, "stall"). */
static uint32_t line_compliance(const crn_state *state)
{
    enum { SEEN_FROM_M_Q30 = 107, LEAST_m_N_Q40 = WALL_COMPLIANCE_m_N_Q40 / 16 }; /* 0.1 um; 400 kN/m */
    const crn_state_words *words = &state->words;
    uint32_t whole = (uint32_t)crn_line_compliance(&state->line, words->free_count) + WALL_COMPLIANCE_m_N_Q40;
    uint64_t older = words->line_compliance_m_N_q40 + (uint64_t)(words->line_compliance_m_N_q40 / 128);
    uint32_t most = older < whole ? (uint32_t)older : whole;
    int64_t way = words->line_feed_m_q30;
    int64_t change = words->line_change_N_q22;
    way = way < 0 ? -way : way;
    change = change < 0 ? -change : change;
    if (way >= SEEN_FROM_M_Q30 && change > 0) {
        /* Q30 m / Q22 N -> Q40: 2^32 way / change; below 2 where it matters */
        uint32_t seen = (uint32_t)crn_quotient((int32_t)way, crn_sat32(change), 30) * 2u;
        seen = seen > UINT32_MAX / 2 ? seen : seen * 2u;
        most = seen < most ? seen : most;
    }
    return most > LEAST_m_N_Q40 ? most : LEAST_m_N_Q40;
}

/* Limits the feed of a tool so that the force on the user's hand stays within its limit. The function also
 * limits the feed of the leading tip, so that the sum of the forces on all hands stays within its limit.
 * Without the limit of the leading tip's feed, two tools whose tips touch the same wall would increase each
 * other's force from tick to tick. */
static int32_t limit_feed(const crn_model *model, const crn_state *state, uint32_t k, int32_t feed_m_q30)
{
    const crn_state_words *words = &state->words;
    const crn_tool_state *tool = &words->tools[k];
    uint32_t compliance = words->line_compliance_m_N_q40;
    int32_t push = stall_limit(crn_sub_sat(model->stall_N_q22, tool->handle_axial_N_q22), compliance);
    int32_t pull = stall_limit(crn_add_sat(model->stall_N_q22, tool->handle_axial_N_q22), compliance);
    int32_t behind = crn_lead_inserted(model, words) - tool->inserted_m_q30;
    int32_t line = stall_limit(crn_sub_sat(model->stall_N_q22, words->line_axial_N_q22), compliance);
    line = crn_add_sat(behind, line);
    return crn_clamp(feed_m_q30, -pull, push < line ? push : line);
}

/* Returns the feed of one tool in this tick, in Q30 m. The hand may move ahead of its tool by four times the
 * largest feed of a tick. If the hand is ahead of its tool by more than four times the largest feed, the hand
 * slips along the tool, as a hand slips on a wire or a wire slips in the rig's rollers. A tool stalls (is not
 * fed further) when it pushes or pulls as hard as a hand can. */
static int32_t choose_feed(const crn_model *model, crn_state *state, uint32_t k, int32_t hand_m_q30)
{
    const int32_t lead_max = 4 * CRN_FEED_MAX_M_Q30;
    crn_state_words *words = &state->words;
    crn_tool_state *tool = &words->tools[k];
    if (!crn_has_tool(words, k)) { /* a tool that is put here begins where the hand then is */
        tool->hand_offset_m_q30 = crn_sub_sat(tool->inserted_m_q30, hand_m_q30);
        return 0;
    }
    int64_t lead = (int64_t)hand_m_q30 + tool->hand_offset_m_q30 - tool->inserted_m_q30;
    if (lead > lead_max || lead < -lead_max) {
        int64_t kept = lead > 0 ? lead_max : -(int64_t)lead_max;
        tool->hand_offset_m_q30 = crn_sat32(tool->hand_offset_m_q30 - (lead - kept));
        words->fault_bits |= CRN_FAULT_FEED_LIMIT;
        lead = kept;
    }
    int32_t feed = limit_feed(model, state, k, (int32_t)lead / (1 << FOLLOW_SHIFT));
    int32_t wanted = tool->inserted_m_q30 + feed;
    int32_t allowed = crn_clamp(wanted, CRN_WITHDRAWN_M_Q30, crn_tool_on(model, k)->inserted_max_m_q30);
    if (allowed != wanted) {
        words->fault_bits |= CRN_FAULT_INSERT_END;
    }
    return allowed - tool->inserted_m_q30;
}

/* Feeds every tool. The inserted length of the tools never gets shorter than a few elements, so the last tool
 * to be withdrawn stops at this length. */
static void feed_tools(const crn_model *model, crn_state *state, const crn_input *input)
{
    crn_state_words *words = &state->words;
    const int32_t least = crn_least_inserted(model);
    int32_t before = crn_lead_inserted(model, words);
    uint32_t longest = 0;
    int32_t feed[CRN_TOOL_MAX];
    words->line_compliance_m_N_q40 = line_compliance(state);
    for (uint32_t k = 0; k < model->tool_count; k++) {
        feed[k] = choose_feed(model, state, k, input->hands[k].feed_m_q30);
    }
    for (uint32_t k = 0; k < model->tool_count; k++) {
        words->tools[k].inserted_m_q30 += feed[k];
        longest = words->tools[k].inserted_m_q30 > words->tools[longest].inserted_m_q30 ? k : longest;
    }
    int32_t short_by = least - words->tools[longest].inserted_m_q30;
    if (short_by > 0) {
        words->tools[longest].inserted_m_q30 += short_by;
        feed[longest] += short_by;
        words->fault_bits |= CRN_FAULT_INSERT_END;
    }
    int32_t line = crn_lead_inserted(model, words) - before;
    state->scratch.feed_m_q33 = line * 8;
    for (uint32_t k = 0; k < model->tool_count; k++) {
        state->scratch.slide_m_q33[k] = (feed[k] - line) * 8;
    }
}

/* Turns the tools' material frames in the introducer sheath towards the angles of the user's hands. In each
 * tick the frames turn by a quarter of the angle by which they lag behind the hand, at most at 20 rad/s. */
static void turn_bases(const crn_model *model, crn_state *state, const crn_input *input)
{
    for (uint32_t k = 0; k < model->tool_count; k++) {
        crn_tool_state *tool = &state->words.tools[k];
        int32_t lead = (int32_t)(input->hands[k].turn32 - tool->base_turn32);
        int32_t turn = crn_clamp(lead / (1 << FOLLOW_SHIFT), -CRN_TURN_MAX_TURN32, CRN_TURN_MAX_TURN32);
        tool->base_turn32 += (uint32_t)turn;
        state->scratch.turn_q30[k] = -crn_mul_q30(turn, TURN32_TO_Q30_RAD);
    }
}

/* Returns the position of a node inside the introducer sheath. The node lies on the sheath's axis, at the
 * distance arc - s behind the sheath's distal end. */
static crn_vec3 position_inside(const crn_model *model, int32_t inserted_m_q30, uint32_t node)
{
    int32_t behind = model->mesh[node].arc_m_q30 - inserted_m_q30;
    crn_vec3 p = model->entry.position_m_q30;
    for (int k = 0; k < 3; k++) {
        p.v[k] -= crn_mul_q30(behind, model->entry.direction_q30.v[k]);
    }
    return p;
}

/* Places node i and the edge behind it inside the introducer sheath, where the tools are straight and
 * unloaded and move with the feed. */
static void place_inside(const crn_model *model, crn_state *state, int32_t inserted_m_q30, uint32_t i)
{
    crn_node_state *node = &state->words.nodes[i];
    crn_work *work = &state->scratch.nodes[i];
    for (int k = 0; k < 3; k++) {
        node->tangent_q30.v[k] = -model->entry.direction_q30.v[k];
        node->step_m_q33.v[k] = crn_mul_q30(state->scratch.feed_m_q33, model->entry.direction_q30.v[k]);
    }
    node->position_m_q30 = position_inside(model, inserted_m_q30, i);
    for (uint32_t k = 0; k < CRN_TOOL_MAX; k++) {
        node->angle_turn32[k] = 0u - state->words.tools[k].base_turn32;
        node->spin_q30[k] = state->scratch.turn_q30[k];
    }
    for (uint32_t k = 0; k < CRN_PAIR_MAX; k++) {
        node->grip_q30[k] = 0;
    }
    node->bristle_m_q33 = (crn_vec3){{0, 0, 0}};
    node->contact = CRN_CONTACT_NONE;
    work->position_m_q30 = node->position_m_q30;
    work->slide_m_q33 = node->step_m_q33;
    work->drift_m_q33 = (crn_vec3){{0, 0, 0}};
    work->force_N_q22 = (crn_vec3){{0, 0, 0}};
}

/* Adds the rounding error of each node's weight (gravity) to the weight of the next node, so that the total
 * weight is exact. */
typedef struct weight_carry {
    int64_t rest[3];
} weight_carry;

static void add_weight(const crn_model *model, const crn_line_node *line, weight_carry *carry,
                       crn_vec3 *force)
{
    for (int k = 0; k < 3; k++) {
        /* kg Q40 x m/s^2 Q20 -> N Q22 */
        int64_t exact = (int64_t)line->weight_kg_q40 * model->gravity_m_s2_q20[k] + carry->rest[k];
        int64_t rounded = crn_rshift_round64(exact, 38);
        carry->rest[k] = exact - rounded * ((int64_t)1 << 38);
        force->v[k] = crn_sat32(force->v[k] + rounded);
    }
}

/* Frees a node from the introducer sheath in this tick. The freed node's predicted position x* is on the
 * sheath's axis at the new feed, its previous position is x* less the slide, and its weight acts from this
 * tick on. */
static void free_node(crn_state *state, uint32_t i)
{
    crn_work *work = &state->scratch.nodes[i];
    for (int k = 0; k < 3; k++) {
        state->words.nodes[i].position_m_q30.v[k] =
            work->position_m_q30.v[k] - ((work->slide_m_q33.v[k] + 4) >> 3);
    }
}

/* Computes the mean T of the tangents of the two edges at a node. Returns the square of the length of the
 * mean tangent T in Q28, which is cos^2 of half the joint's angle. */
static inline int32_t mean_tangent(const crn_state *state, uint32_t i, crn_vec3 *mean_q30)
{
    const crn_vec3 *ahead = &state->words.nodes[i > 0 ? i - 1 : 0].tangent_q30;
    const crn_vec3 *behind = &state->words.nodes[i].tangent_q30;
    int32_t square_q28 = 0;
    for (int k = 0; k < 3; k++) {
        mean_q30->v[k] = crn_asr32(ahead->v[k], 1) + crn_asr32(behind->v[k], 1);
        square_q28 = crn_mulh_add(square_q28, mean_q30->v[k], mean_q30->v[k]);
    }
    return square_q28;
}

/* Computes the slide of a node in a fold (a sharp bend), T / T^2 ds, where T is the mean tangent of the
 * node's edges and ds the feed. The slide in a fold moves the node along each of its two edges as far as the
 * other end of this edge moves. For bends of a right angle or more, the slide in a fold is limited to twice
 * the slide of a straight tool. Overflow is impossible, because a fold increases a slide of 0.5 mm to at most
 * 0.71 mm. */
CRN_RARE static void slide_round(crn_vec3 *slide_m_q33, int32_t square_q28)
{
    const int32_t factor_q28 = square_q28 > 1 << 27 ? crn_quotient(1 << 28, square_q28, 28) : 1 << 29;
    for (int k = 0; k < 3; k++) {
        slide_m_q33->v[k] = crn_mul(slide_m_q33->v[k], factor_q28, 28);
    }
}

/* Puts node i at its predicted position x* = x + slide, and adds the inertia m/h^2 ((1 - gamma h) u - slide)
 * to the right side (m: mass, h: tick, gamma: drag, u: motion in the last tick). Overflow is impossible.
 * Slides stay below 2^24 in Q33 m: the feed contributes at most 0.71 mm, the tip's rotation at most 0.6 mm,
 * and the shift at most 0.5 mm. Displacements per tick are below 2^25 (the step limit and the shift permit
 * 1.25 mm more than the slide), their differences are below 2^26, and eight times these differences are below
 * 2^29. */
static inline void predict_node(const crn_model *model, crn_state *state, uint32_t i,
                                const crn_vec3 *slide_m_q33)
{
    crn_node_state *node = &state->words.nodes[i];
    crn_work *work = &state->scratch.nodes[i];
    const int32_t inertia_q18 = crn_line_inertia(model, &state->line.nodes[i])
                                << (18 - model->stiffness_exponent);
    for (int k = 0; k < 3; k++) {
        const int32_t slide = slide_m_q33->v[k];
        const int32_t drift = node->step_m_q33.v[k] - slide;
        const int32_t kept = crn_mulh_add(drift, node->step_m_q33.v[k], -4 * CRN_DAMPING_KEEP_Q30);
        work->slide_m_q33.v[k] = slide;
        work->drift_m_q33.v[k] = drift;
        work->position_m_q30.v[k] = node->position_m_q30.v[k] + ((slide + 4) >> 3);
        work->force_N_q22.v[k] = crn_mulh(inertia_q18, kept * 8); /* Q18 N/m x Q36 m */
    }
}

/* Holds the shift of the nodes on the tip's side of folds (sharp bends); this shift keeps the length of the
 * edges in these folds. */
typedef struct fold_shift {
    crn_vec3 shift_m_q33;
    bool was_fold;  /* the node behind belongs to a fold, */
    bool is_passed; /* some node behind belongs to a fold */
} fold_shift;

/* Computes the slide of a node that lies in a fold (a sharp bend) or between a fold and the tip. `is_inside`
 * is true if the edge behind the node also slides and is not part of the rigid tip. */
CRN_RARE static void slide_apart(const crn_model *model, const crn_state *state, uint32_t i, bool is_inside,
                                 int32_t square_q28, fold_shift *fold, crn_vec3 *slide_m_q33)
{
    const bool is_fold = square_q28 < FOLD_Q28;
    if (is_fold) {
        slide_round(slide_m_q33, square_q28);
    }
    const crn_vec3 alone = *slide_m_q33;
    *slide_m_q33 = crn_vec3_add(alone, fold->shift_m_q33);
    if (is_inside && (is_fold || fold->was_fold)) {
        crn_slide_keep_length(model, state, i, slide_m_q33, &fold->shift_m_q33);
        *slide_m_q33 = crn_vec3_add(alone, fold->shift_m_q33);
    }
    fold->was_fold = is_fold;
    fold->is_passed |= is_fold;
}

#if CRN_HAS_LANES
/* As slide_nodes() for nodes whose slide is neither in a fold nor part of the rigid tip, from the hand
 * towards the tip. Returns how many nodes towards the tip remain. */
CRN_LANES_TARGET static uint32_t lanes_slide_nodes(const crn_model *model, crn_state *state, uint32_t count,
                                                   uint32_t rigid)
{
    const crn_words4 four = {4, 4, 4, 4};
    const crn_lanes back_m_q35 = crn_lanes_all(-4 * state->scratch.feed_m_q33);
    const crn_lanes keep = crn_lanes_all(-4 * CRN_DAMPING_KEEP_Q30);
    for (uint32_t i = count; i-- > rigid;) {
        crn_node_state *node = &state->words.nodes[i];
        crn_work *work = &state->scratch.nodes[i];
        const crn_words4 ahead = crn_words_read(node[i > 0 ? -1 : 0].tangent_q30.v),
                         behind = crn_words_read(node->tangent_q30.v);
        const crn_lanes mean = __builtin_convertvector((ahead >> 1) + (behind >> 1), crn_lanes);
        const crn_lanes squares = crn_lanes_mulh(mean, mean);
        if ((int32_t)squares[0] + (int32_t)squares[1] + (int32_t)squares[2] < FOLD_Q28) {
            return i + 1;
        }
        const crn_words4 slide = crn_lanes_halves(crn_lanes_mulh(back_m_q35, mean));
        const crn_words4 step = crn_words_read(node->step_m_q33.v), drift = step - slide;
        const crn_words4 lost =
            crn_lanes_halves(crn_lanes_mulh(__builtin_convertvector(step, crn_lanes), keep));
        const crn_words4 kept = drift + lost;
        const int32_t inertia_q18 = crn_line_inertia(model, &state->line.nodes[i])
                                    << (18 - model->stiffness_exponent);
        crn_words_write3(work->position_m_q30.v,
                         crn_words_read(node->position_m_q30.v) + ((slide + four) >> 3));
        crn_words_write3(work->slide_m_q33.v, slide);
        crn_words_write3(work->drift_m_q33.v, drift);
        crn_words_write3(work->force_N_q22.v,
                         crn_lanes_halves(crn_lanes_mulh(
                             crn_lanes_all(inertia_q18),
                             __builtin_convertvector((crn_words4)((crn_words4_u32)kept << 3), crn_lanes))));
    }
    return rigid;
}

/* As add_weight() for all free nodes. */
CRN_LANES_TARGET static void lanes_add_weights(const crn_model *model, crn_state *state)
{
    const int32_t *g = model->gravity_m_s2_q20;
    const crn_lanes gravity = {g[0], g[1], g[2], 0};
    crn_lanes rest = crn_lanes_all(0);
    for (uint32_t i = 0; i < state->words.free_count; i++) {
        int32_t *force = state->scratch.nodes[i].force_N_q22.v;
        const crn_lanes exact =
            crn_lanes_product(crn_lanes_all(state->line.nodes[i].weight_kg_q40), gravity) + rest;
        const crn_lanes rounded = crn_lanes_asr(exact + crn_lanes_all((int64_t)1 << 37), 38);
        rest = exact - (crn_lanes)((crn_lanes_u64)rounded << 38);
        crn_lanes_write3(force, crn_lanes_sat32(crn_lanes_read(force) + rounded));
    }
}
#endif

/* Moves nodes 0 .. count-1 by the slide -T ds. Nodes 0 .. rigid-1 move like node `rigid`. The first `rigid`
 * nodes also move by the displacement that the tip's rotation causes and that the scratch memory contains. In
 * a fold (a sharp bend), the function also keeps the lengths of the edges: the change that corrects an edge's
 * length shifts all nodes between this edge and the tip. The loop over the nodes therefore runs from the hand
 * towards the tip. */
static void slide_nodes(const crn_model *model, crn_state *state, uint32_t count, uint32_t rigid)
{
    const int32_t back_m_q35 = -4 * state->scratch.feed_m_q33;
    fold_shift fold = {{{0, 0, 0}}, false, false};
    bool is_inside = false;
#if CRN_HAS_LANES
    if (model->has_lanes) {
        const uint32_t left = lanes_slide_nodes(model, state, count, rigid);
        is_inside = left < count;
        count = left;
    }
#endif
    for (uint32_t i = count; i-- > 0;) {
        crn_vec3 mean, slide;
        const int32_t square_q28 = mean_tangent(state, i < rigid ? rigid : i, &mean);
        for (int k = 0; k < 3; k++) {
            slide.v[k] = crn_mulh(back_m_q35, mean.v[k]);
        }
        if (square_q28 < FOLD_Q28 || fold.is_passed) {
            slide_apart(model, state, i, i >= rigid && is_inside, square_q28, &fold, &slide);
        }
        if (i < rigid) {
            slide = crn_vec3_add(slide, state->scratch.nodes[i].slide_m_q33);
        }
        predict_node(model, state, i, &slide);
        is_inside = true;
    }
}

/* Returns the factor by which a joint's stiffness may grow when the end of the introducer sheath covers a
 * part of the joint's cell (clips it). The joint's entries in the matrix must stay below 2^26, because a
 * diagonal entry below 2^29 contains the sum of four such entries (core_build.c). The bending stiffness W
 * must stay below 16 N m. */
static int32_t clip_room(const crn_joint *joint)
{
    int32_t entry = joint->p > joint->r ? joint->p : joint->r;
    int32_t by_entry = entry <= (1 << 26) / CRN_CLIP_MAX ? CRN_CLIP_MAX : crn_quotient(1 << 26, entry, 0);
    int32_t by_bend = joint->bend_N_m_q26 <= (1 << 30) / CRN_CLIP_MAX
                          ? CRN_CLIP_MAX
                          : crn_quotient(1 << 30, joint->bend_N_m_q26, 0);
    int32_t room = by_entry < by_bend ? by_entry : by_bend;
    return room > CRN_CLIP_SURE ? room : CRN_CLIP_SURE;
}

/* Each of the two joints at the introducer sheath's distal end represents only the part of its cell that lies
 * outside the sheath (the joint is "clipped"). The stiffness W of a clipped joint grows by the factor cell /
 * part, and the joint's rest rotation shrinks by the factor part / cell. The number format of the matrix
 * limits how small the part of a cell outside the sheath may be. If the part of a joint's cell outside the
 * sheath is smaller than the number format allows, the joint bends as if the tool outside the sheath were
 * longer by the difference. */
static void clip_joint(const crn_model *model, crn_state *state, int32_t inserted_m_q30, uint32_t i)
{
    crn_joint *joint = &state->scratch.mouth[i + 1 - state->words.free_count];
    *joint = state->line.nodes[i].joint;
    int32_t from = model->mesh[i - 1].cell_end_m_q30;
    int32_t cell = model->mesh[i].cell_end_m_q30 - from;
    int32_t part = inserted_m_q30 - from;
    if (part >= cell) {
        return;
    }
    int32_t least = crn_quotient(cell, clip_room(joint), 0);
    int32_t factor_q24 = crn_quotient(cell, part > least ? part : least, 24);
    joint->bend_N_m_q26 = crn_mul(joint->bend_N_m_q26, factor_q24, 24);
    joint->p = crn_mul(joint->p, factor_q24, 24);
    joint->q = crn_mul(joint->q, factor_q24, 24);
    joint->r = crn_mul(joint->r, factor_q24, 24);
    int32_t share_q24 = part <= 0 ? 0 : crn_quotient(part, cell, 24);
    for (uint32_t k = 0; k < model->tool_count; k++) {
        joint->turn1_q30[k] = crn_mul(joint->turn1_q30[k], share_q24, 24);
        joint->turn2_q30[k] = crn_mul(joint->turn2_q30[k], share_q24, 24);
        joint->set_q14[k][0] = (int16_t)crn_mul(joint->set_q14[k][0], share_q24, 24);
        joint->set_q14[k][1] = (int16_t)crn_mul(joint->set_q14[k][1], share_q24, 24);
    }
}

/* Returns the number of nodes beyond the introducer sheath's distal end once the tip has advanced to arc
 * length s beyond this end. The feed of one tick moves at most eight nodes past the introducer sheath's
 * distal end. */
static uint32_t count_free(const crn_model *model, uint32_t count, int32_t inserted_m_q30)
{
    for (int step = 0; step < 8 && model->mesh[count].arc_m_q30 < inserted_m_q30; step++) {
        count++;
    }
    for (int step = 0; step < 8 && model->mesh[count - 1].arc_m_q30 >= inserted_m_q30; step++) {
        count--;
    }
    return count;
}

static void load_nodes(const crn_model *model, crn_state *state)
{
    weight_carry carry = {{0, 0, 0}};
    uint32_t i = 0;
#if CRN_HAS_LANES
    if (model->has_lanes) {
        lanes_add_weights(model, state);
        i = state->words.free_count;
    }
#endif
    for (; i < state->words.free_count; i++) {
        add_weight(model, &state->line.nodes[i], &carry, &state->scratch.nodes[i].force_N_q22);
    }
    for (int k = 0; k < 3; k++) {
        crn_vec3 *force = &state->scratch.nodes[0].force_N_q22;
        force->v[k] = crn_add_sat(force->v[k], model->tip_load_N_q22.v[k]);
    }
}

void crn_rod_feed(const crn_model *model, crn_state *state, const crn_input *input)
{
    crn_state_words *words = &state->words;
    crn_line_update(model, state); /* gives the stall its compliance after a restored state */
    feed_tools(model, state, input);
    turn_bases(model, state, input);
    if (words->release_q30 < CRN_ONE_Q30) {
        words->release_q30 += CRN_RELEASE_STEP_Q30;
    }
    int32_t inserted = crn_lead_inserted(model, words);
    uint32_t before = words->free_count;
    uint32_t now = count_free(model, before, inserted);
    words->free_count = now;
    crn_line_update(model, state);
    crn_set_apply(model, state);
    uint32_t sliding = before < now ? before : now;
    uint32_t rigid = crn_tip_predict(model, state, sliding);
    slide_nodes(model, state, sliding, rigid);
    for (uint32_t i = sliding; i < now + 3; i++) {
        place_inside(model, state, inserted, i);
        if (i < now) {
            free_node(state, i);
        }
    }
    load_nodes(model, state);
    clip_joint(model, state, inserted, now - 1);
    clip_joint(model, state, inserted, now);
}
