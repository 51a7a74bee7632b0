/* States, modes and ticks. One tick: encoders -> hands -> seld_step -> forces -> tick_state. Called by: app.c. */
#include "firmware/app/app_internal.h"

/* --- states --- */

enum { START_DEPTH_MAX_M_Q30 = 322123 /* 0.3 mm: the wall pushes that back without a jolt */ };

/* No tool may begin with more outside than it has. False: refused. */
static bool lengths_fit(seld_app *app)
{
    for (uint32_t k = 0; k < app->tool_count; k++) {
        uint32_t length_um = app->tools[k].knots[app->tools[k].knot_count - 1].arc_um;
        if (app->inserted_um[k] <= length_um) continue;
        seld_app_reject(app, SELD_WIRE_TYPE_command, SELD_REJECT_LENGTH_INSERTED, k, length_um);
        return false;
    }
    return true;
}

static uint32_t longest_um(const seld_app *app)
{
    uint32_t longest = 0;
    for (uint32_t k = 0; k < app->tool_count; k++) {
        if (app->inserted_um[k] > longest) longest = app->inserted_um[k];
    }
    return longest;
}

/* Constants and rest state from what was set up; READY -> ARMED. */
static void arm(seld_app *app)
{
    const uint16_t type = SELD_WIRE_TYPE_command;
    SELD_REJECT_IF(app, type, app->state != SELD_WIRE_STATE_READY, SELD_REJECT_WRONG_STATE, app->state, 0);
    SELD_REJECT_IF(app, type, app->tool_count == 0 || !app->has_entry, SELD_REJECT_SET_UP_MISSING,
                   app->tool_count, app->has_entry);
    seld_build_place place = {0, 0};
    seld_build_status status = seld_model_build(&app->model, app->tools, app->tool_count,
                                                app->has_scene ? &app->lumen : NULL, &app->entry, &place);
    if (status != SELD_BUILD_OK) {
        seld_app_reject_build(app, type, status, &place);
        return;
    }
    if (!lengths_fit(app)) return;
    seld_state_init(&app->model, &app->core, app->inserted_um);
    int32_t depth_m_q30 = seld_state_depth(&app->model, &app->core);
    SELD_REJECT_IF(app, type, depth_m_q30 > START_DEPTH_MAX_M_Q30, SELD_REJECT_START_IN_WALL,
                   (uint32_t)(((uint64_t)(uint32_t)depth_m_q30 * 1000000u) >> 30), longest_um(app));
    seld_app_hands_reset(app);
    seld_app_motors_reset(app);
    seld_app_motors_off(app);
    app->core_faults_seen = 0;
    app->ticks.states_count = 0;
    app->state = SELD_WIRE_STATE_ARMED;
    seld_app_send_status(app, type);
}

/* Leave `from` for `to`, or refuse. In FREE_RUN nobody listened to the hands before START: where they are now is their
 * new reference, and the motors begin at nothing. In LOCKSTEP a session stopped goes on exactly where it was. */
static void move_state(seld_app *app, uint8_t from, uint8_t to)
{
    SELD_REJECT_IF(app, SELD_WIRE_TYPE_command, app->state != from, SELD_REJECT_WRONG_STATE, app->state, 0);
    app->state = to;
    app->silent_ticks = 0;
    if (app->mode == SELD_WIRE_MODE_FREE_RUN) {
        seld_app_hands_take_reference(app);
        seld_app_motors_reset(app);
        app->has_mailbox = false;
    }
    seld_app_motors_off(app);
    seld_app_send_status(app, SELD_WIRE_TYPE_command);
}

static void reset(seld_app *app)
{
    app->state = SELD_WIRE_STATE_READY;
    app->fault_code = SELD_FAULT_CODE_NONE;
    app->snapshot_upload.open = false;
    app->ticks.states_count = 0;
    seld_app_motors_off(app);
    seld_app_send_status(app, SELD_WIRE_TYPE_command);
}

static void set_mode(seld_app *app, uint8_t mode)
{
    bool is_at_rest = app->state == SELD_WIRE_STATE_READY || app->state == SELD_WIRE_STATE_ARMED;
    SELD_REJECT_IF(app, SELD_WIRE_TYPE_command, !is_at_rest, SELD_REJECT_WRONG_STATE, app->state, 0);
    app->mode = mode;
    seld_app_motors_reset(app);
    seld_app_send_status(app, SELD_WIRE_TYPE_command);
}

void seld_app_command(seld_app *app, const uint8_t *payload, size_t length)
{
    const uint16_t type = SELD_WIRE_TYPE_command;
    seld_wire_command command;
    SELD_REJECT_IF(app, type, !seld_wire_decode_command(payload, length, &command), SELD_REJECT_MALFORMED,
                   length, SELD_WIRE_BYTES_command);
    switch (command.action) {
    case SELD_WIRE_ACTION_ARM:
        arm(app);
        break;
    case SELD_WIRE_ACTION_START:
        move_state(app, SELD_WIRE_STATE_ARMED, SELD_WIRE_STATE_RUNNING);
        break;
    case SELD_WIRE_ACTION_STOP:
        move_state(app, SELD_WIRE_STATE_RUNNING, SELD_WIRE_STATE_ARMED);
        break;
    case SELD_WIRE_ACTION_RESET:
        reset(app);
        break;
    case SELD_WIRE_ACTION_LOCKSTEP:
        set_mode(app, SELD_WIRE_MODE_LOCKSTEP);
        break;
    case SELD_WIRE_ACTION_FREE_RUN:
        set_mode(app, SELD_WIRE_MODE_FREE_RUN);
        break;
    default:
        seld_app_reject(app, type, SELD_REJECT_ACTION_UNKNOWN, command.action, 0);
    }
}

/* --- one tick --- */

/* The core's sticky bits that are new go to the fault log. */
static void log_core_faults(seld_app *app, uint32_t bits)
{
    static const struct {
        uint32_t bit;
        seld_fault_code code;
    } map[] = {
        {SELD_FAULT_SATURATED, SELD_FAULT_CODE_CORE_SATURATED},
        {SELD_FAULT_FEED_LIMIT, SELD_FAULT_CODE_CORE_FEED_LIMIT},
        {SELD_FAULT_STEP_CAPPED, SELD_FAULT_CODE_CORE_STEP_CAPPED},
        {SELD_FAULT_INSERT_END, SELD_FAULT_CODE_CORE_INSERT_END},
        {SELD_FAULT_OUTSIDE, SELD_FAULT_CODE_CORE_OUTSIDE},
    };
    uint32_t news = bits & ~app->core_faults_seen;
    for (size_t i = 0; news != 0 && i < sizeof map / sizeof map[0]; i++) {
        if (news & map[i].bit) seld_app_fault(app, map[i].code, 0, 0);
    }
    app->core_faults_seen |= bits;
}

static seld_wire_tool_state tool_state(const seld_handle *handle, const seld_port_motor *motor)
{
    return (seld_wire_tool_state){
        .handle_axial_N_q22 = handle->axial_N_q22,
        .handle_torque_N_m_q24 = handle->torque_N_m_q24,
        .motor_axial_mN = motor->axial_mN,
        .motor_torque_uN_m = motor->torque_uN_m,
        .inserted_m_q30 = handle->inserted_m_q30,
    };
}

static void note_tick(seld_app *app, const seld_output *output)
{
    SELD_REQUIRE(app, app->ticks.states_count < SELD_WIRE_MAX_ticks_states, app->ticks.states_count);
    if (app->ticks.states_count >= SELD_WIRE_MAX_ticks_states) return;
    seld_wire_tick_state *state = &app->ticks.states[app->ticks.states_count++];
    *state = (seld_wire_tick_state){
        .tick = output->tick,
        .hash_lane0 = output->hash_lane[0],
        .hash_lane1 = output->hash_lane[1],
        .tools_count = (uint16_t)app->tool_count,
        .lead_tool = output->lead_tool,
        .penetration_max_m_q30 = output->penetration_max_m_q30,
        .strain_max_q30 = output->strain_max_q30,
        .contact_count = output->contact_count,
        .solve_count = output->solve_count,
        .core_fault_bits = output->fault_bits,
    };
    for (uint32_t k = 0; k < app->tool_count; k++) {
        state->tools[k] = tool_state(&output->tools[k], &app->motors[k]);
    }
}

bool seld_app_tick(seld_app *app, const seld_app_encoders *encoders)
{
    if (encoders != NULL && !seld_app_hands_update(app, encoders)) return false;
    seld_input input;
    seld_output output;
    seld_app_hands_input(app, &input);
    seld_step(&app->model, &app->core, &input, &output);

    bool is_silent = app->mode == SELD_WIRE_MODE_FREE_RUN && app->silent_ticks >= SELD_APP_HOST_SILENT_ticks;
    for (uint32_t k = 0; k < app->tool_count; k++) {
        seld_app_motor_update(&app->motors[k], &app->tracks[k], &output.tools[k], is_silent);
    }
    log_core_faults(app, output.fault_bits);
    note_tick(app, &output);
    if (output.tick % SELD_APP_HASH64_EVERY_ticks == 0) seld_app_send_hash64(app);
    return app->state == SELD_WIRE_STATE_RUNNING;
}

static seld_app_encoders encoders_from_wire(const seld_wire_encoders *wire)
{
    seld_app_encoders encoders = {.buttons = wire->buttons};
    for (uint16_t k = 0; k < wire->hands_count; k++) {
        encoders.hands[k] =
            (seld_port_hand){wire->hands[k].translation_counts, wire->hands[k].rotation_counts};
    }
    return encoders;
}

/* --- LOCKSTEP --- */

/* Replies: hash64 on the way, nodes when wanted, ticks last. After a fault `ticks` is shorter than asked. */
void seld_app_step(seld_app *app, const uint8_t *payload, size_t length)
{
    const uint16_t type = SELD_WIRE_TYPE_step;
    seld_wire_step *step = &app->request.step;
    SELD_REJECT_IF(app, type, !seld_wire_decode_step(payload, length, step), SELD_REJECT_MALFORMED, length,
                   SELD_WIRE_BYTES_step);
    SELD_REJECT_IF(app, type, app->mode != SELD_WIRE_MODE_LOCKSTEP, SELD_REJECT_WRONG_MODE, app->mode, 0);
    SELD_REJECT_IF(app, type, app->state != SELD_WIRE_STATE_RUNNING, SELD_REJECT_WRONG_STATE, app->state, 0);
    SELD_REJECT_IF(app, type, step->tick != app->core.words.tick, SELD_REJECT_WRONG_TICK,
                   app->core.words.tick, step->tick);
    for (uint16_t i = 0; i < step->inputs_count; i++) {
        SELD_REJECT_IF(app, type, step->inputs[i].hands_count != app->tool_count, SELD_REJECT_TOOL_COUNT,
                       step->inputs[i].hands_count, app->tool_count);
    }
    app->ticks.states_count = 0;
    for (uint16_t i = 0; i < step->inputs_count; i++) {
        const seld_app_encoders encoders = encoders_from_wire(&step->inputs[i]);
        if (!seld_app_tick(app, &encoders)) break;
    }
    if (step->want_nodes != 0) seld_app_send_nodes(app);
    seld_app_send_ticks(app);
}

/* --- FREE_RUN --- */

void seld_app_input(seld_app *app, const uint8_t *payload, size_t length)
{
    seld_wire_input input;
    SELD_REJECT_IF(app, SELD_WIRE_TYPE_input, !seld_wire_decode_input(payload, length, &input),
                   SELD_REJECT_MALFORMED, length, SELD_WIRE_BYTES_input);
    SELD_REJECT_IF(app, SELD_WIRE_TYPE_input, input.encoders.hands_count != app->tool_count,
                   SELD_REJECT_TOOL_COUNT, input.encoders.hands_count, app->tool_count);
    app->mailbox = encoders_from_wire(&input.encoders);
    app->has_mailbox = true;
}

static seld_app_encoders encoders_from_rig(const seld_port_inputs *inputs)
{
    seld_app_encoders encoders = {.buttons = inputs->buttons};
    for (uint32_t k = 0; k < SELD_TOOL_MAX; k++) encoders.hands[k] = inputs->hands[k];
    return encoders;
}

void seld_app_timer(seld_app *app)
{
    seld_port_inputs inputs;
    bool has_rig = app->port->inputs(app->port->context, &inputs);
    if (app->mode != SELD_WIRE_MODE_FREE_RUN || app->state != SELD_WIRE_STATE_RUNNING) {
        seld_app_motors_off(app);
        return;
    }
    app->answers = 0;
    if (app->silent_ticks < SELD_APP_HOST_SILENT_ticks) {
        app->silent_ticks++;
        if (app->silent_ticks == SELD_APP_HOST_SILENT_ticks)
            seld_app_fault(app, SELD_FAULT_CODE_HOST_SILENT, SELD_APP_HOST_SILENT_ticks, 0);
    }
    seld_app_encoders encoders = app->mailbox;
    if (has_rig) encoders = encoders_from_rig(&inputs);
    bool is_running = seld_app_tick(app, has_rig || app->has_mailbox ? &encoders : NULL);
    if (is_running && has_rig) seld_app_motors_drive(app);
    bool is_batch_full = app->ticks.states_count >= SELD_APP_FREE_RUN_BATCH_ticks;
    if (is_batch_full || (!is_running && app->ticks.states_count > 0)) seld_app_send_ticks(app);
    if (!is_running) seld_app_send_status(app, 0);
}
