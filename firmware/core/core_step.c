/* This file runs one tick, part by part; docs/tick.md explains the parts in the order of this code. */
#include "firmware/core/balloon.h"
#include "firmware/core/lesion.h"
#include "firmware/core/near/near.h"

/* Returns, in Q33 m, the largest component of any node's deviation. A node's deviation is measured from the
 * position that the node would have if the tools only slid along their centreline. */
static int32_t largest_deviation(const crn_state *state)
{
    int32_t largest = 0;
    for (uint32_t i = 0; i < state->words.free_count; i++) {
        for (int k = 0; k < 3; k++) {
            int32_t part = state->scratch.nodes[i].solution_m_q33.v[k];
            part = part < 0 ? -part : part;
            largest = part > largest ? part : largest;
        }
    }
    return largest;
}

static void scale_step(crn_state *state, int32_t share_q30)
{
    for (uint32_t i = 0; i < state->words.free_count; i++) {
        for (int k = 0; k < 3; k++) {
            int32_t *part = &state->scratch.nodes[i].solution_m_q33.v[k];
            *part = crn_scale_q30(*part, share_q30);
        }
    }
}

/* Scales down the deviation of all nodes when one of two limits is exceeded. The first limit on a tick's step
 * is exceeded if a node would deviate from its slide along the tool by more than 0.5 mm and by more than 1.5
 * times the tick's feed. The second limit on a tick's step is exceeded if a node would end inside a wall at
 * rest where no contact was found. One scale factor for all nodes keeps the shape; a separate limit for each
 * node would add energy (docs/rod.md, "contact"). When consecutive ticks miss a contact, the deviation is
 * scaled down only in the first of these ticks. If the deviation were scaled down in every tick that misses a
 * contact, the tools would be held back tick after tick. The function returns whether the solve missed a
 * contact. */
static bool cut_step(const crn_model *model, crn_state *state, int32_t largest_m_q33)
{
    const int32_t feed =
        state->scratch.feed_m_q33 < 0 ? -state->scratch.feed_m_q33 : state->scratch.feed_m_q33;
    const int32_t cap = 3 * feed / 2 > CRN_STEP_CAP_M_Q33 ? 3 * feed / 2 : CRN_STEP_CAP_M_Q33;
    int32_t share_q30 = CRN_ONE_Q30;
    if (largest_m_q33 > cap) {
        state->words.fault_bits |= CRN_FAULT_STEP_CAPPED;
        share_q30 = crn_quotient(cap, largest_m_q33, 30);
    }
    bool missed = false;
    if (model->lumen != NULL && model->lumen->motion == NULL) {
        const int32_t to_wall_q30 =
            crn_contact_share(model, state, largest_m_q33 < cap ? largest_m_q33 : cap);
        missed = to_wall_q30 < share_q30;
        share_q30 = missed && state->words.has_missed == 0 ? to_wall_q30 : share_q30;
    }
    if (share_q30 < CRN_ONE_Q30) {
        scale_step(state, share_q30);
    }
    return missed;
}

/* Solves the tick. If a contact with a moving wall was missed, the linear system of the tick is solved a
 * second time. If the code scaled the nodes' deviation down instead of solving a second time, the tools would
 * be held back in every tick of a heartbeat. Returns the largest component by which any node deviates from
 * its slide along the tool. */
static int32_t solve(const crn_model *model, crn_state *state, crn_output *output)
{
    crn_rod_solve(model, state);
    output->solve_count = 1;
    const int32_t largest_m_q33 = largest_deviation(state);
    if (model->lumen == NULL || model->lumen->motion == NULL ||
        crn_contact_missed(model, state, largest_m_q33) == 0) {
        return largest_m_q33;
    }
    crn_rod_solve(model, state);
    output->solve_count = 2;
    return largest_deviation(state);
}

/* The force on the hand that holds the leading tool is the force of all tools together on the introducer
 * sheath, less the forces on the other hands. The forces on the hands that do not hold the leading tool are
 * filtered with a time constant of 8 ms, because the bending moment at a sliding tool's tip is not steady. */
static void share_handles(const crn_model *model, crn_state *state, int32_t line_axial_N_q22)
{
    enum { FOLLOW = 8 };
    uint32_t lead = crn_lead_tool(model, &state->words);
    int64_t rest = line_axial_N_q22;
    for (uint32_t k = 0; k < model->tool_count; k++) {
        crn_tool_state *tool = &state->words.tools[k];
        if (k != lead) {
            int64_t change = (int64_t)state->scratch.axial_N_q22[k] - tool->handle_axial_N_q22;
            tool->handle_axial_N_q22 += (int32_t)(change / FOLLOW);
            rest -= tool->handle_axial_N_q22;
        }
    }
    state->words.tools[lead].handle_axial_N_q22 = crn_sat32(rest);
    state->words.line_change_N_q22 = crn_sub_sat(line_axial_N_q22, state->words.line_axial_N_q22);
    state->words.line_axial_N_q22 = line_axial_N_q22;
    state->words.line_feed_m_q30 = state->scratch.feed_m_q33 / 8;
}

static void report(const crn_model *model, const crn_state *state, crn_output *output)
{
    const crn_state_words *words = &state->words;
    output->tick = words->tick;
    output->lead_tool = (uint16_t)crn_lead_tool(model, words);
    output->fault_bits = words->fault_bits;
    output->heart_phase32 = words->rhythm.heart_phase32;
    output->breath_phase32 = words->rhythm.breath_phase32;
    output->beat_ms = words->rhythm.beat_ms;
    output->interval_ms = words->rhythm.interval_ms;
    output->rhythm_bits = words->rhythm.bits;
    for (uint32_t k = 0; k < CRN_TOOL_MAX; k++) {
        const crn_tool_state *tool = &words->tools[k];
        output->tools[k] = (crn_handle){tool->handle_axial_N_q22, -(state->scratch.torque_N_m_q30[k] / 64),
                                        tool->inserted_m_q30};
    }
    crn_state_hash_lanes(state, output->hash_lane);
}

/* Advances heart and breath by one tick. The later parts of this tick use the position that the wall has at
 * the end of the tick. */
static void beat(const crn_model *model, crn_state *state, const crn_input *input)
{
    const crn_rhythm before = state->words.rhythm;
    crn_rhythm_step(&state->words.rhythm, &input->rhythm);
    if (model->lumen != NULL && model->lumen->motion != NULL) {
        crn_motion_pose_begin(model->lumen->motion, &state->scratch.pose, &before, &state->words.rhythm);
        state->scratch.wall_shrink_q30 = crn_motion_shrink_q30(&model->steepness, &state->scratch.pose.now);
    }
}

void crn_step(const crn_model *model, crn_state *state, const crn_input *input, crn_output *output)
{
    if (model->lumen != NULL && model->lumen->near != NULL) {
        model->lumen->near->tick++;
    }
    beat(model, state, input);
    if (input->scaffold.open_q30 > 0) {
        (void)crn_state_scaffold(model, state, &input->scaffold);
    }
    if (input->strut.number != 0) {
        (void)crn_state_strut(state, &input->strut);
    }
    if (state->words.struts.used != 0) {
        crn_struts_step(state);
    }
    crn_rod_feed(model, state, input);
    crn_rod_stretch(model, state);
    crn_set_mark(model, state);
    crn_contact_find(model, state);
    crn_balloon_find(model, state, input->inflator_Pa);
    crn_lesions_give_way(model, state);
    crn_frames_carry(model, state);
    crn_tools_grip(model, state);
    crn_rod_twist(model, state);
    crn_tools_turned(model, state);
    crn_set_follow(model, state);
    crn_rod_bend(model, state);
    crn_tools_handles(model, state);
    crn_contact_forces(model, state);
    crn_balloon_forces(model, state);
    const int32_t largest_m_q33 = solve(model, state, output);
    int32_t line_axial_N_q22 =
        crn_add_sat(crn_rod_handle_axial(model, state), state->scratch.mouth_axial_N_q22);
    const bool missed = cut_step(model, state, largest_m_q33);
    output->solve_count = missed ? 2 : output->solve_count;
    crn_rod_keep_lengths(model, state, largest_m_q33);
    state->words.has_missed = missed;
    crn_contact_finish(model, state, output);
    crn_wall_step(model, state);
    crn_balloon_finish(model, state, output);
    crn_tools_slide(model, state);
    share_handles(model, state, line_axial_N_q22);
    crn_rod_advance(model, state, output);
    state->words.tick++;
    report(model, state, output);
}
