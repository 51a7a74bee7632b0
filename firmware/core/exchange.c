/* Between two ticks, this file takes tools out of the set of nested tools (the line) and puts tools of the
 * table into it. All tools of the table share one mesh, and a tool is exchanged only while its tip is inside
 * the introducer sheath. A tool whose tip is inside the sheath adds nothing to any free node, so an exchange
 * moves no node and does not change the other tools. */
#include "firmware/core/rod.h"

/* --- the model's line ----------------------------------------------------------------------------------- */

void crn_exchange_put(crn_model *model, uint32_t position, uint32_t number)
{
    if (model->balloon.ball_count > 0 && model->balloon.tool == position) {
        model->balloon = (crn_balloon_model){0};
    }
    if (number == 0) {
        return;
    }
    const crn_table_tool *tool = &model->table[number - 1];
    model->on_line[position] = number - 1;
    if (tool->balloon.ball_count > 0) {
        model->balloon = tool->balloon;
        model->balloon.tool = position;
    }
}

void crn_exchange_take_line(crn_model *model, const crn_state_words *words)
{
    model->balloon = (crn_balloon_model){0};
    for (uint32_t k = 0; k < model->tool_count; k++) {
        crn_exchange_put(model, k, words->exchange.line[k]);
    }
}

/* --- a restored state ----------------------------------------------------------------------------------- */

static bool is_first_line(const crn_model *model, const crn_exchange_state *exchange)
{
    for (uint32_t k = 0; k < CRN_TOOL_MAX; k++) {
        if (exchange->line[k] != model->line[k]) {
            return false;
        }
    }
    return true;
}

/* The tools of a restored state must fit into each other, because the core computes nested tools only. */
bool crn_exchange_is_valid(const crn_model *model, const crn_state_words *words)
{
    const crn_exchange_state *exchange = &words->exchange;
    const crn_table_tool *inner = NULL;
    uint32_t balloons = 0;
    if (!crn_line_numbers_are_valid(model->table_count, exchange->line, model->tool_count)) {
        return false;
    }
    /* Before the first exchange, the hash does not say which tools are nested, so a restored state must have
     * the model's own tools. */
    if (exchange->count == 0 && !is_first_line(model, exchange)) {
        return false;
    }
    for (uint32_t k = 0; k < CRN_TOOL_MAX; k++) {
        const uint32_t number = exchange->line[k];
        if (number == 0) {
            if (k < model->tool_count && words->tools[k].inserted_m_q30 != CRN_WITHDRAWN_M_Q30) {
                return false;
            }
            continue;
        }
        if (k >= model->tool_count) {
            return false;
        }
        const crn_table_tool *tool = &model->table[number - 1];
        if (inner != NULL && inner->outer_um > tool->bore_um) {
            return false;
        }
        balloons += tool->balloon.ball_count > 0;
        inner = tool;
    }
    return balloons <= 1 && exchange->burst_bits >> model->table_count == 0;
}

int32_t crn_exchange_inserted_max(const crn_model *model, const crn_state_words *words, uint32_t position)
{
    const uint32_t number = words->exchange.line[position];
    return number == 0 ? CRN_WITHDRAWN_M_Q30 : model->table[number - 1].tool.inserted_max_m_q30;
}

uint32_t crn_exchange_balls(const crn_model *model, const crn_state_words *words)
{
    uint32_t count = 0;
    for (uint32_t k = 0; k < model->tool_count; k++) {
        const uint32_t number = words->exchange.line[k];
        count += number == 0 ? 0 : model->table[number - 1].balloon.ball_count;
    }
    return count;
}

/* --- what is possible ----------------------------------------------------------------------------------- */

/* Returns the tool at a position of the line (the set of nested tools), or NULL if no tool is at this
 * position. */
static const crn_table_tool *tool_at(const crn_model *model, const crn_state_words *words, uint32_t position)
{
    const uint32_t number = words->exchange.line[position];
    return number == 0 ? NULL : &model->table[number - 1];
}

static crn_exchange_status check_numbers(const crn_model *model, const crn_state_words *words,
                                         const crn_exchange_order *order)
{
    if (order->position >= model->tool_count) {
        return CRN_EXCHANGE_NO_POSITION;
    }
    if (order->tool > model->table_count) {
        return CRN_EXCHANGE_NO_TOOL;
    }
    if (order->tool == 0) {
        return words->exchange.line[order->position] == 0 ? CRN_EXCHANGE_FREE : CRN_EXCHANGE_DONE;
    }
    for (uint32_t k = 0; k < model->tool_count; k++) {
        if (words->exchange.line[k] == order->tool) {
            return CRN_EXCHANGE_ON_LINE;
        }
    }
    return CRN_EXCHANGE_DONE;
}

/* Checks that the tool may be taken out of the set of nested tools (the line). The leading tool can only be
 * replaced, and only at the shortest inserted length that the simulation allows; the other tools are then
 * inside the introducer sheath. */
static crn_exchange_status check_leaving(const crn_model *model, const crn_state_words *words,
                                         const crn_exchange_order *order)
{
    const uint32_t k = order->position;
    if (words->exchange.line[k] == 0) {
        return CRN_EXCHANGE_DONE;
    }
    const bool leads = crn_lead_tool(model, words) == k;
    const int32_t most_m_q30 = leads ? crn_least_inserted(model) : 0;
    if (words->tools[k].inserted_m_q30 > most_m_q30) {
        return CRN_EXCHANGE_INSIDE;
    }
    if (leads && order->tool == 0) {
        return CRN_EXCHANGE_LEADS;
    }
    const bool is_inflated = model->balloon.ball_count > 0 && model->balloon.tool == k &&
                             words->balloon.pressure_Pa > CRN_BALLOON_UNFOLD_Pa;
    return is_inflated ? CRN_EXCHANGE_INFLATED : CRN_EXCHANGE_DONE;
}

/* Checks that the new tool fits between the tools inside and around it. */
static crn_exchange_status check_nesting(const crn_model *model, const crn_state_words *words,
                                         const crn_exchange_order *order)
{
    const crn_table_tool *tool = &model->table[order->tool - 1];
    for (uint32_t k = 0; k < model->tool_count; k++) {
        const crn_table_tool *other = tool_at(model, words, k);
        if (other == NULL || k == order->position) {
            continue;
        }
        if (k > order->position && tool->outer_um > other->bore_um) {
            return CRN_EXCHANGE_TOO_WIDE;
        }
        if (k < order->position && other->outer_um > tool->bore_um) {
            return CRN_EXCHANGE_TOO_NARROW;
        }
    }
    return CRN_EXCHANGE_DONE;
}

/* Returns the length, in um, of the part of a tool that is outside the patient and the introducer sheath. */
static int64_t outside_um(const crn_table_tool *tool, int32_t inserted_m_q30)
{
    return (int64_t)tool->whole_um - (((int64_t)inserted_m_q30 * 1000000) >> 30);
}

/* Checks that a tool can pass over the end of a tool inside it. No tool can pass over the hub in which a tube
 * ends. A wire must reach out of the patient by at least the length that the passing tool needs on the wire,
 * because somebody has to hold the wire meanwhile. */
static crn_exchange_status check_passing(const crn_table_tool *inner, int32_t inserted_m_q30,
                                         const crn_table_tool *tool)
{
    if (inner->bore_um > 0) {
        return CRN_EXCHANGE_HUB;
    }
    const uint32_t needed_um = tool->rail_um > 0 ? tool->rail_um : tool->whole_um;
    bool is_short = inner->whole_um > 0 && outside_um(inner, inserted_m_q30) < (int64_t)needed_um;
    return is_short ? CRN_EXCHANGE_SHORT : CRN_EXCHANGE_DONE;
}

/* Checks whether the tool that is removed, and the tool that is put in its place, can pass over all tools
 * inside them. */
static crn_exchange_status check_inner(const crn_model *model, const crn_state_words *words,
                                       const crn_exchange_order *order)
{
    const crn_table_tool *moved[2] = {tool_at(model, words, order->position),
                                      order->tool > 0 ? &model->table[order->tool - 1] : NULL};
    for (uint32_t k = 0; k < order->position; k++) {
        const crn_table_tool *inner = tool_at(model, words, k);
        for (int i = 0; i < 2 && inner != NULL; i++) {
            crn_exchange_status status = moved[i] == NULL
                                             ? CRN_EXCHANGE_DONE
                                             : check_passing(inner, words->tools[k].inserted_m_q30, moved[i]);
            if (status != CRN_EXCHANGE_DONE) {
                return status;
            }
        }
    }
    return CRN_EXCHANGE_DONE;
}

static crn_exchange_status check_balloon(const crn_model *model, const crn_state_words *words,
                                         const crn_exchange_order *order)
{
    if (model->table[order->tool - 1].balloon.ball_count == 0) {
        return CRN_EXCHANGE_DONE;
    }
    if (model->balloon.ball_count > 0 && model->balloon.tool != order->position) {
        return CRN_EXCHANGE_BALLOON;
    }
    bool has_burst = (words->exchange.burst_bits >> (order->tool - 1) & 1u) != 0;
    return has_burst ? CRN_EXCHANGE_BURST : CRN_EXCHANGE_DONE;
}

crn_exchange_status crn_exchange_check(const crn_model *model, const crn_state *state,
                                       const crn_exchange_order *order)
{
    const crn_state_words *words = &state->words;
    crn_exchange_status status = check_numbers(model, words, order);
    if (status == CRN_EXCHANGE_DONE) {
        status = check_leaving(model, words, order);
    }
    if (status == CRN_EXCHANGE_DONE && order->tool != 0) {
        status = check_nesting(model, words, order);
    }
    if (status == CRN_EXCHANGE_DONE) {
        status = check_inner(model, words, order);
    }
    if (status == CRN_EXCHANGE_DONE && order->tool != 0) {
        status = check_balloon(model, words, order);
    }
    return status;
}

/* --- an exchange ---------------------------------------------------------------------------------------- */

/* Clears everything that the state contains about the tool at a position, except the angle at which the hand
 * holds the tool. While the inner tool reaches beyond the sheath, the elastic friction displacement against
 * this tool is kept. The friction displacement is bounded, and the new tool's first slip replaces it. */
static void forget_tool(const crn_model *model, crn_state_words *words, uint32_t position)
{
    crn_tool_state *tool = &words->tools[position];
    tool->handle_axial_N_q22 = 0;
    tool->slide_grip_m_q33 = 0;
    tool->slide_share_q30 = 0;
    tool->tip_axial_N_q22 = 0;
    for (uint32_t i = 0; i < words->free_count + 3; i++) {
        crn_node_state *node = &words->nodes[i];
        node->angle_turn32[position] = 0u - tool->base_turn32;
        node->spin_q30[position] = 0;
        if (position < CRN_PAIR_MAX) {
            node->grip_q30[position] = 0;
        }
    }
    crn_set_forget(words, position);
    if (model->balloon.ball_count > 0 && model->balloon.tool == position) {
        if ((words->balloon.bits & CRN_BALLOON_BURST) != 0) {
            words->exchange.burst_bits |= 1u << (words->exchange.line[position] - 1);
        }
        words->balloon = (crn_balloon_state){0};
    }
}

/* Puts the tip of the tool at a position into the introducer sheath. The distance between the hand and the
 * tool does not change. */
static void withdraw(crn_tool_state *tool)
{
    const int32_t change = CRN_WITHDRAWN_M_Q30 - tool->inserted_m_q30;
    tool->hand_offset_m_q30 = crn_add_sat(tool->hand_offset_m_q30, change);
    tool->inserted_m_q30 = CRN_WITHDRAWN_M_Q30;
}

crn_exchange_status crn_exchange(crn_model *model, crn_state *state, const crn_exchange_order *order)
{
    const crn_exchange_status status = crn_exchange_check(model, state, order);
    if (status != CRN_EXCHANGE_DONE) {
        return status;
    }
    crn_state_words *words = &state->words;
    const uint32_t k = order->position;
    const bool leads = words->exchange.line[k] != 0 && crn_lead_tool(model, words) == k;
    forget_tool(model, words, k);
    if (leads) {
        words->release_q30 = 0; /* the new tool takes its own shape as slowly as at the start */
    } else {
        withdraw(&words->tools[k]);
    }
    words->exchange.line[k] = order->tool;
    words->exchange.count++;
    crn_exchange_put(model, k, order->tool);
    state->line.count = 0; /* combines the tools anew */
    crn_line_update(model, state);
    return CRN_EXCHANGE_DONE;
}
