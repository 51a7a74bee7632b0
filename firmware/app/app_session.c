/* This file runs the ticks of a session. A tick computes, in this order, the hands' positions from the
 * encoders, the virtual coupling, the core's step (crn_step), the forces, and the results for the host. */
#include "firmware/app/app_internal.h"

/* --- one tick --- */

/* Writes the core's new fault bits to the fault log; a fault bit stays set. */
void crn_app_log_core_faults(crn_app *app, uint32_t bits)
{
    static const struct {
        uint32_t bit;
        crn_fault_code code;
    } map[] = {
        {CRN_FAULT_SATURATED, CRN_FAULT_CODE_CORE_SATURATED},
        {CRN_FAULT_FEED_LIMIT, CRN_FAULT_CODE_CORE_FEED_LIMIT},
        {CRN_FAULT_STEP_CAPPED, CRN_FAULT_CODE_CORE_STEP_CAPPED},
        {CRN_FAULT_INSERT_END, CRN_FAULT_CODE_CORE_INSERT_END},
        {CRN_FAULT_OUTSIDE, CRN_FAULT_CODE_CORE_OUTSIDE},
    };
    uint32_t news = bits & ~app->faults.core_bits_seen;
    for (size_t i = 0; news != 0 && i < sizeof map / sizeof map[0]; i++) {
        if (news & map[i].bit) crn_app_fault(app, map[i].code, 0, 0);
    }
    app->faults.core_bits_seen |= bits;
}

static crn_wire_tool_state tool_state(const crn_handle *handle, const crn_port_motor *motor)
{
    return (crn_wire_tool_state){
        .handle_axial_N_q22 = handle->axial_N_q22,
        .handle_torque_N_m_q24 = handle->torque_N_m_q24,
        .motor_axial_mN = motor->axial_mN,
        .motor_torque_uN_m = motor->torque_uN_m,
        .inserted_m_q30 = handle->inserted_m_q30,
    };
}

/* The result is rounded. The result cannot overflow, because a balloon's radius in Q30 m is below 2^24. */
static uint16_t um_from_q30(int32_t length_m_q30)
{
    return (uint16_t)(((int64_t)length_m_q30 * 15625 + (1 << 23)) >> 24);
}

static void note_tick(const crn_app *app, const crn_output *output, crn_wire_tick_state *state)
{
    *state = (crn_wire_tick_state){
        .tick = output->tick,
        .hash_lane0 = output->hash_lane[0],
        .hash_lane1 = output->hash_lane[1],
        .tools_count = (uint16_t)app->setup.tool_count,
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
        .balloon_bits = (uint8_t)output->balloon_bits,
        .balloon_kPa = (uint16_t)(output->balloon_Pa / 1000),
        .balloon_diameter_max_um = um_from_q30(2 * output->balloon_radius_max_m_q30),
        .balloon_diameter_min_um = um_from_q30(2 * output->balloon_radius_min_m_q30),
        .balloon_wall_mN = (uint32_t)(((int64_t)output->balloon_wall_N_q22 * 1000) >> 22),
    };
    state->exchange = app->session.exchange;
    state->line_count = (uint16_t)app->setup.tool_count;
    for (uint32_t k = 0; k < app->setup.tool_count; k++) {
        state->line[k] = (uint8_t)crn_state_tool_at(&app->core, k);
        state->tools[k] = tool_state(&output->tools[k], &app->haptics.motors[k]);
    }
}

static int32_t kPa_of(int32_t inflator_raw)
{
    const int32_t most = CRN_PRESSURE_MAX_Pa / 1000;
    return inflator_raw < 0 ? 0 : (inflator_raw > most ? most : inflator_raw);
}

/* When `encoders` is NULL, the positions of the user's hands are unknown, and the app treats the hands as at
 * rest. Returns false if the state is FAULT and no tick was computed. */
static bool tick(crn_app *app, const crn_app_encoders *encoders, const crn_app_order_set *orders,
                 crn_output *output)
{
    crn_haptics_input felt;
    crn_input input = {0};
    if (encoders != NULL && !crn_app_hands_update(app, encoders)) return false;
    crn_app_exchange(app, orders);
    if (encoders != NULL) app->session.inflator_raw = encoders->inflator_raw;
    input.inflator_Pa = kPa_of(app->session.inflator_raw) * 1000;
    input.rhythm = orders->rhythm;
    input.scaffold = orders->scaffold;
    input.strut = orders->strut;
    crn_app_haptics_before(app, &felt, &input);
    crn_step(&app->model, &app->core, &input, output);
    crn_app_haptics_after(app, &felt, output);
    crn_app_log_core_faults(app, output->fault_bits);
    return true;
}

static void stop_when_due(crn_app *app)
{
    if (!app->session.has_stop || app->core.words.tick < app->session.stop_tick) return;
    crn_app_notice(app, CRN_WIRE_EVENT_COMMAND, CRN_WIRE_ACTION_STOP, 1, 0);
    crn_app_stop(app);
}

static void note_buttons(crn_app *app, uint32_t buttons)
{
    if (buttons == app->session.buttons) return;
    crn_app_notice(app, CRN_WIRE_EVENT_BUTTONS, 0, crn_wire_i32_from_u32(buttons),
                   crn_wire_i32_from_u32(app->session.buttons));
    app->session.buttons = buttons;
}

static crn_app_encoders encoders_from_wire(const crn_wire_tick_input *wire)
{
    crn_app_encoders encoders = {
        .buttons = wire->buttons, .syringe_counts = wire->syringe_counts, .inflator_raw = wire->inflator_raw};
    for (uint16_t k = 0; k < wire->hands_count; k++) {
        encoders.hands[k] =
            (crn_port_hand){wire->hands[k].translation_counts, wire->hands[k].rotation_counts};
    }
    return encoders;
}

/* --- LOCKSTEP --- */

/* The app sends its replies in this order: `hash64` while the ticks run, `nodes` if the host requested them,
 * and `ticks` last. After a fault or a STOP, the message `ticks` has fewer ticks than the host requested. */
void crn_app_step(crn_app *app, const uint8_t *payload, size_t length)
{
    static const crn_app_order_set no_orders;
    const uint16_t type = CRN_WIRE_TYPE_step;
    crn_wire_step *step = &app->buffers.request.step;
    CRN_REJECT_IF(app, type, !crn_wire_decode_step(payload, length, step), CRN_REJECT_MALFORMED, length,
                  CRN_WIRE_BYTES_step);
    CRN_REJECT_IF(app, type, app->mode != CRN_WIRE_MODE_LOCKSTEP, CRN_REJECT_WRONG_MODE, app->mode, 0);
    CRN_REJECT_IF(app, type, app->state != CRN_WIRE_STATE_RUNNING, CRN_REJECT_WRONG_STATE, app->state, 0);
    CRN_REJECT_IF(app, type, step->tick != app->core.words.tick, CRN_REJECT_WRONG_TICK, app->core.words.tick,
                  step->tick);
    for (uint16_t i = 0; i < step->inputs_count; i++) {
        CRN_REJECT_IF(app, type, step->inputs[i].hands_count != app->setup.tool_count, CRN_REJECT_TOOL_COUNT,
                      step->inputs[i].hands_count, app->setup.tool_count);
        const crn_wire_order_list *orders = &step->inputs[i].orders;
        if (orders->items_count == 0) continue;
        uint32_t place;
        const uint16_t fault = crn_app_orders_take(app, orders, &app->buffers.reply.orders[i], &place);
        CRN_REJECT_IF(app, type, fault != CRN_REJECT_NONE, fault, orders->items[place].kind,
                      256u * i + place);
    }
    app->buffers.ticks.states_count = 0;
    for (uint16_t i = 0; i < step->inputs_count && app->state == CRN_WIRE_STATE_RUNNING; i++) {
        const crn_app_encoders encoders = encoders_from_wire(&step->inputs[i]);
        const crn_app_order_set *orders =
            step->inputs[i].orders.items_count == 0 ? &no_orders : &app->buffers.reply.orders[i];
        crn_output output;
        note_buttons(app, encoders.buttons);
        if (!tick(app, &encoders, orders, &output)) break;
        note_tick(app, &output, &app->buffers.ticks.states[app->buffers.ticks.states_count++]);
        if (output.tick % CRN_APP_HASH64_EVERY_ticks == 0) crn_app_send_hash64(app);
        stop_when_due(app);
    }
    if (step->want_nodes != 0) crn_app_send_nodes(app);
    crn_app_send_ticks(app);
}

/* --- FREE_RUN --- */

void crn_app_input(crn_app *app, const uint8_t *payload, size_t length)
{
    const uint16_t type = CRN_WIRE_TYPE_input;
    crn_wire_input message;
    CRN_REJECT_IF(app, type, !crn_wire_decode_input(payload, length, &message), CRN_REJECT_MALFORMED, length,
                  CRN_WIRE_BYTES_input);
    const crn_wire_tick_input *input = &message.input;
    CRN_REJECT_IF(app, type, input->hands_count != app->setup.tool_count, CRN_REJECT_TOOL_COUNT,
                  input->hands_count, app->setup.tool_count);
    CRN_REJECT_IF(app, type, input->orders.items_count != 0, CRN_REJECT_ORDER_MISPLACED,
                  input->orders.items_count, 0);
    app->session.mailbox = encoders_from_wire(input);
    app->session.has_mailbox = true;
}

static crn_app_encoders encoders_from_rig(const crn_port_inputs *rig)
{
    crn_app_encoders encoders = {
        .buttons = rig->buttons, .syringe_counts = rig->syringe_counts, .inflator_raw = rig->inflator_raw};
    for (uint32_t k = 0; k < CRN_TOOL_MAX; k++) encoders.hands[k] = rig->hands[k];
    return encoders;
}

static uint16_t fade_milli(const crn_app *app)
{
    return (uint16_t)(crn_watchdog_left_ticks(&app->watchdog) * 1000 / CRN_APP_FADE_ticks);
}

/* Stores all data that the host needs to replay this tick in LOCKSTEP, and to see what the rig did. */
static void note_live(crn_app *app, const crn_app_encoders *encoders, const crn_wire_order_list *orders,
                      const crn_output *output)
{
    crn_wire_live_tick live;
    note_tick(app, output, &live.state);
    crn_wire_tick_input *input = &live.input;
    input->hands_count = (uint16_t)app->setup.tool_count;
    live.force_measured_mN_count = (uint16_t)app->setup.tool_count;
    for (uint32_t k = 0; k < app->setup.tool_count; k++) {
        const crn_port_hand *last = &app->hands.counts[k].last;
        input->hands[k] = (crn_wire_hand){last->translation_counts, last->rotation_counts};
        live.force_measured_mN[k] = crn_app_force_measured(app, k);
    }
    input->buttons = encoders != NULL ? encoders->buttons : 0;
    input->syringe_counts = encoders != NULL ? encoders->syringe_counts : 0;
    input->inflator_raw = app->session.inflator_raw;
    input->orders.items_count = orders->items_count;
    for (uint16_t i = 0; i < orders->items_count; i++) input->orders.items[i] = orders->items[i];
    live.fade_milli = fade_milli(app);
    live.flags = 0;
    if (encoders != NULL) live.flags |= CRN_WIRE_LIVE_HANDS;
    if (app->safety.is_driving) live.flags |= CRN_WIRE_LIVE_POWERED;
    if (app->clock.was_late) live.flags |= CRN_WIRE_LIVE_LATE;
    crn_app_stream_live(app, &live);
}

static void free_run_tick(crn_app *app)
{
    crn_output output;
    crn_app_silence_count(app);
    crn_app_encoders encoders = app->edge.has_rig ? encoders_from_rig(&app->edge.rig) : app->session.mailbox;
    const crn_app_encoders *told = app->edge.has_rig || app->session.has_mailbox ? &encoders : NULL;
    if (told != NULL) note_buttons(app, told->buttons);
    const crn_app_tick_orders *orders = crn_app_orders_next(app);
    if (!tick(app, told, &orders->core, &output)) return;
    note_live(app, told, &orders->wire, &output);
    if (output.tick % CRN_APP_HASH64_EVERY_ticks == 0) crn_app_stream_hash64(app);
    crn_app_stream_tick(app);
}

void crn_app_timer(crn_app *app)
{
    app->link.answers = 0;
    const bool was_running = app->state == CRN_WIRE_STATE_RUNNING; /* before anything may end the run */
    crn_app_clock_begin(app);
    app->edge.has_rig = app->port->inputs(app->port->context, &app->edge.rig);
    if (!app->edge.has_rig) app->edge.rig = (crn_port_inputs){.supply_good = false};
    crn_app_safety_check(app);
    bool is_ticking = app->mode == CRN_WIRE_MODE_FREE_RUN && app->state == CRN_WIRE_STATE_RUNNING;
    if (is_ticking) free_run_tick(app);
    if (is_ticking) stop_when_due(app);
    crn_app_outputs_write(app);
    if (is_ticking) crn_app_clock_end(app);
    crn_app_stream_flush(app);
    if (was_running && app->state != CRN_WIRE_STATE_RUNNING) crn_app_send_status(app, 0);
    app->edges_done++;
}
