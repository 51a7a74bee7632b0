/* Ticks. One tick: encoders -> hands -> coupling -> seld_step -> forces -> what the host is told. Called by: app.c, the port. */
#include "firmware/app/app_internal.h"

/* --- one tick --- */

/* The core's sticky bits that are new go to the fault log. */
void seld_app_log_core_faults(seld_app *app, uint32_t bits)
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

static void note_tick(const seld_app *app, const seld_output *output, seld_wire_tick_state *state)
{
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
        .heart_phase32 = output->heart_phase32,
        .breath_phase32 = output->breath_phase32,
        .beat_ms = output->beat_ms,
        .interval_ms = output->interval_ms,
        .rhythm_bits = (uint8_t)output->rhythm_bits,
    };
    for (uint32_t k = 0; k < app->tool_count; k++) {
        state->tools[k] = tool_state(&output->tools[k], &app->motors[k]);
    }
}

/* `encoders` NULL: nobody says where the hands are, they rest. False: FAULT, no tick was done. */
static bool tick(seld_app *app, const seld_app_encoders *encoders, seld_rhythm_order rhythm,
                 seld_output *output)
{
    seld_input hands, input;
    if (encoders != NULL && !seld_app_hands_update(app, encoders)) return false;
    seld_app_hands_input(app, &hands);
    hands.rhythm = rhythm;
    input = hands;
    seld_app_coupling_before(app, &input);
    seld_step(&app->model, &app->core, &input, output);
    seld_app_coupling_after(app, output);
    seld_app_motors_update(app, &hands, output);
    seld_app_log_core_faults(app, output->fault_bits);
    return true;
}

static void stop_when_due(seld_app *app)
{
    if (!app->has_stop || app->core.words.tick < app->stop_tick) return;
    seld_app_notice(app, SELD_WIRE_EVENT_COMMAND, SELD_WIRE_ACTION_STOP, 1, 0);
    seld_app_stop(app);
}

static void note_buttons(seld_app *app, uint32_t buttons)
{
    if (buttons == app->buttons) return;
    seld_app_notice(app, SELD_WIRE_EVENT_BUTTONS, 0, seld_wire_i32_from_u32(buttons),
                    seld_wire_i32_from_u32(app->buttons));
    app->buttons = buttons;
}

static seld_app_encoders encoders_from_wire(const seld_wire_encoders *wire)
{
    seld_app_encoders encoders = {
        .buttons = wire->buttons, .syringe_counts = wire->syringe_counts, .inflator_raw = wire->inflator_raw};
    for (uint16_t k = 0; k < wire->hands_count; k++) {
        encoders.hands[k] =
            (seld_port_hand){wire->hands[k].translation_counts, wire->hands[k].rotation_counts};
    }
    return encoders;
}

static seld_rhythm_order rhythm_from_wire(const seld_wire_encoders *wire)
{
    return (seld_rhythm_order){wire->rhythm_action, wire->rhythm_value};
}

/* --- LOCKSTEP --- */

/* Replies: hash64 on the way, nodes when wanted, ticks last. After a fault or a STOP `ticks` is shorter than asked. */
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
        const seld_rhythm_order rhythm = rhythm_from_wire(&step->inputs[i]);
        SELD_REJECT_IF(app, type, !seld_rhythm_order_is_valid(&rhythm), SELD_REJECT_RHYTHM_RANGE,
                       rhythm.action, rhythm.value);
    }
    app->ticks.states_count = 0;
    for (uint16_t i = 0; i < step->inputs_count && app->state == SELD_WIRE_STATE_RUNNING; i++) {
        const seld_app_encoders encoders = encoders_from_wire(&step->inputs[i]);
        seld_output output;
        note_buttons(app, encoders.buttons);
        if (!tick(app, &encoders, rhythm_from_wire(&step->inputs[i]), &output)) break;
        note_tick(app, &output, &app->ticks.states[app->ticks.states_count++]);
        if (output.tick % SELD_APP_HASH64_EVERY_ticks == 0) seld_app_send_hash64(app);
        stop_when_due(app);
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
    SELD_REJECT_IF(app, SELD_WIRE_TYPE_input,
                   input.encoders.rhythm_action != 0 || input.encoders.rhythm_value != 0,
                   SELD_REJECT_RHYTHM_RANGE, input.encoders.rhythm_action, input.encoders.rhythm_value);
    app->mailbox = encoders_from_wire(&input.encoders);
    app->has_mailbox = true;
}

/* An `input` may be repeated or dropped, a request to heart and breath may not: it waits for its tick. */
void seld_app_rhythm(seld_app *app, const uint8_t *payload, size_t length)
{
    const uint16_t type = SELD_WIRE_TYPE_rhythm;
    seld_wire_rhythm wire;
    SELD_REJECT_IF(app, type, !seld_wire_decode_rhythm(payload, length, &wire), SELD_REJECT_MALFORMED, length,
                   SELD_WIRE_BYTES_rhythm);
    SELD_REJECT_IF(app, type, app->mode != SELD_WIRE_MODE_FREE_RUN, SELD_REJECT_WRONG_MODE, app->mode, 0);
    SELD_REJECT_IF(app, type, app->state != SELD_WIRE_STATE_RUNNING, SELD_REJECT_WRONG_STATE, app->state, 0);
    const seld_rhythm_order order = {wire.action, wire.value};
    SELD_REJECT_IF(app, type, order.action == SELD_RHYTHM_KEEP || !seld_rhythm_order_is_valid(&order),
                   SELD_REJECT_RHYTHM_RANGE, order.action, order.value);
    SELD_REJECT_IF(app, type, app->order_count == SELD_APP_RHYTHM_QUEUE, SELD_REJECT_RHYTHM_FULL,
                   order.action, order.value);
    app->orders[app->order_count++] = order;
    seld_app_send_status(app, type);
}

/* The order of this tick of FREE_RUN. */
static seld_rhythm_order next_order(seld_app *app)
{
    const seld_rhythm_order order = app->order_count > 0 ? app->orders[0] : (seld_rhythm_order){0, 0};
    for (uint32_t i = 1; i < app->order_count; i++) app->orders[i - 1] = app->orders[i];
    if (app->order_count > 0) app->order_count--;
    return order;
}

static seld_app_encoders encoders_from_rig(const seld_port_inputs *rig)
{
    seld_app_encoders encoders = {
        .buttons = rig->buttons, .syringe_counts = rig->syringe_counts, .inflator_raw = rig->inflator_raw};
    for (uint32_t k = 0; k < SELD_TOOL_MAX; k++) encoders.hands[k] = rig->hands[k];
    return encoders;
}

static void count_silence(seld_app *app)
{
    if (app->silent_ticks >= SELD_APP_HOST_SILENT_ticks + SELD_APP_FADE_ticks) return;
    if (++app->silent_ticks != SELD_APP_HOST_SILENT_ticks) return;
    seld_app_fault(app, SELD_FAULT_CODE_HOST_SILENT, SELD_APP_HOST_SILENT_ticks, 0);
    seld_app_notice(app, SELD_WIRE_EVENT_HOST, 1, 0, 0);
}

static uint16_t fade_milli(const seld_app *app)
{
    if (app->silent_ticks < SELD_APP_HOST_SILENT_ticks) return 1000;
    uint32_t left = SELD_APP_HOST_SILENT_ticks + SELD_APP_FADE_ticks - app->silent_ticks;
    return (uint16_t)(left * 1000 / SELD_APP_FADE_ticks);
}

/* What the host needs to replay this tick in LOCKSTEP, and to see what the rig did. */
static void note_live(seld_app *app, const seld_app_encoders *encoders, seld_rhythm_order rhythm,
                      const seld_output *output)
{
    seld_wire_live_tick *live = seld_app_stream_next(app);
    *live = (seld_wire_live_tick){.fade_milli = fade_milli(app)};
    note_tick(app, output, &live->state);
    live->input.rhythm_action = (uint8_t)rhythm.action;
    live->input.rhythm_value = (uint16_t)rhythm.value;
    live->input.hands_count = (uint16_t)app->tool_count;
    live->force_measured_mN_count = (uint16_t)app->tool_count;
    for (uint32_t k = 0; k < app->tool_count; k++) {
        const seld_port_hand *last = &app->hands[k].last;
        live->input.hands[k] = (seld_wire_hand){last->translation_counts, last->rotation_counts};
        live->force_measured_mN[k] = seld_app_force_measured(app, k);
    }
    if (encoders != NULL) {
        live->input.buttons = encoders->buttons;
        live->input.syringe_counts = encoders->syringe_counts;
        live->input.inflator_raw = encoders->inflator_raw;
    }
    if (encoders != NULL) live->flags |= SELD_WIRE_LIVE_HANDS;
    if (app->is_driving) live->flags |= SELD_WIRE_LIVE_POWERED;
    if (app->was_late) live->flags |= SELD_WIRE_LIVE_LATE;
}

static void free_run_tick(seld_app *app)
{
    seld_output output;
    count_silence(app);
    seld_app_encoders encoders = app->has_rig ? encoders_from_rig(&app->rig) : app->mailbox;
    const seld_app_encoders *told = app->has_rig || app->has_mailbox ? &encoders : NULL;
    if (told != NULL) note_buttons(app, told->buttons);
    const seld_rhythm_order rhythm = next_order(app);
    if (!tick(app, told, rhythm, &output)) return;
    note_live(app, told, rhythm, &output);
    if (output.tick % SELD_APP_HASH64_EVERY_ticks == 0) seld_app_stream_hash64(app);
    seld_app_stream_tick(app);
}

void seld_app_timer(seld_app *app)
{
    app->answers = 0;
    const bool was_running = app->state == SELD_WIRE_STATE_RUNNING; /* before anything may end it */
    seld_app_clock_begin(app);
    app->has_rig = app->port->inputs(app->port->context, &app->rig);
    if (!app->has_rig) app->rig = (seld_port_inputs){.supply_good = false};
    seld_app_safety_check(app);
    bool is_ticking = app->mode == SELD_WIRE_MODE_FREE_RUN && app->state == SELD_WIRE_STATE_RUNNING;
    if (is_ticking) free_run_tick(app);
    if (is_ticking) stop_when_due(app);
    seld_app_outputs_write(app);
    if (is_ticking) seld_app_clock_end(app);
    seld_app_stream_flush(app);
    if (was_running && app->state != SELD_WIRE_STATE_RUNNING) seld_app_send_status(app, 0);
}
