/* Ticks. One tick is: encoders -> hands -> coupling -> crn_step -> forces -> results for the host. */
#include "firmware/app/app_internal.h"

/* --- one tick --- */

/* The core's new sticky bits go to the fault log. */
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

/* Rounded. Overflow: impossible, a balloon's radius is below 2^24. */
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
    for (uint32_t k = 0; k < app->setup.tool_count; k++) {
        state->tools[k] = tool_state(&output->tools[k], &app->haptics.motors[k]);
    }
}

static int32_t kPa_of(int32_t inflator_raw)
{
    const int32_t most = CRN_PRESSURE_MAX_Pa / 1000;
    return inflator_raw < 0 ? 0 : (inflator_raw > most ? most : inflator_raw);
}

/* `encoders` NULL: nobody reports where the hands are, and they rest. False: the state is FAULT, and no tick
 * was done. */
static bool tick(crn_app *app, const crn_app_encoders *encoders, const crn_app_wish *order,
                 crn_output *output)
{
    crn_haptics_input felt;
    crn_input input = {0};
    if (encoders != NULL && !crn_app_hands_update(app, encoders)) return false;
    if (encoders != NULL) app->session.inflator_raw = encoders->inflator_raw;
    input.inflator_Pa = kPa_of(app->session.inflator_raw) * 1000;
    input.rhythm = order->rhythm;
    input.scaffold = order->scaffold;
    input.strut = order->strut;
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

static crn_app_encoders encoders_from_wire(const crn_wire_encoders *wire)
{
    crn_app_encoders encoders = {
        .buttons = wire->buttons, .syringe_counts = wire->syringe_counts, .inflator_raw = wire->inflator_raw};
    for (uint16_t k = 0; k < wire->hands_count; k++) {
        encoders.hands[k] =
            (crn_port_hand){wire->hands[k].translation_counts, wire->hands[k].rotation_counts};
    }
    return encoders;
}

/* False: no such place in the scene. */
static bool scaffold_from_wire(const crn_app *app, const crn_wire_scaffold *wire, crn_scaffold *order)
{
    *order = (crn_scaffold){0, 0, 0, 0};
    if (wire->lesion == 0) return wire->first == 0 && wire->last == 0 && wire->open_q15 == 0;
    *order = (crn_scaffold){wire->lesion - 1u, wire->first, wire->last, wire->open_q15 << 15};
    return wire->first <= wire->last && wire->last < crn_model_stations(&app->model, order->lesion) &&
           wire->open_q15 >= 1 && wire->open_q15 <= 1 << 15;
}

static crn_strut_order strut_from_wire(const crn_wire_strut *wire)
{
    return (crn_strut_order){wire->number,
                             {wire->x_um, wire->y_um, wire->z_um},
                             wire->inside_um,
                             wire->thickness_um,
                             wire->joined};
}

/* What an input asks for; refuses with a code and the values at fault. */
static uint16_t order_from_wire(const crn_app *app, const crn_wire_encoders *wire, crn_app_wish *order,
                                uint16_t values[2])
{
    const crn_wire_scaffold scaffold = {wire->scaffold_lesion, wire->scaffold_first, wire->scaffold_last,
                                        wire->scaffold_open_q15};
    order->rhythm = (crn_rhythm_order){wire->rhythm_action, wire->rhythm_value};
    values[0] = wire->rhythm_action;
    values[1] = wire->rhythm_value;
    if (!crn_rhythm_order_is_valid(&order->rhythm)) return CRN_REJECT_RHYTHM_RANGE;
    values[0] = wire->scaffold_lesion;
    values[1] = wire->scaffold_last;
    if (!scaffold_from_wire(app, &scaffold, &order->scaffold)) return CRN_REJECT_SCAFFOLD_RANGE;
    const crn_wire_strut strut = {wire->strut_number,      wire->strut_joined, wire->strut_x_um,
                                  wire->strut_y_um,        wire->strut_z_um,   wire->strut_inside_um,
                                  wire->strut_thickness_um};
    order->strut = strut_from_wire(&strut);
    values[0] = wire->strut_number;
    values[1] = wire->strut_inside_um;
    return crn_strut_order_is_valid(&order->strut) ? CRN_REJECT_NONE : CRN_REJECT_STRUT_RANGE;
}

/* --- LOCKSTEP --- */

/* The replies are hash64 while the ticks run, nodes if they were requested, and ticks last. After a fault or
 * a STOP `ticks` is shorter than requested. */
void crn_app_step(crn_app *app, const uint8_t *payload, size_t length)
{
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
        crn_app_wish order;
        uint16_t values[2];
        const uint16_t fault = order_from_wire(app, &step->inputs[i], &order, values);
        CRN_REJECT_IF(app, type, fault != CRN_REJECT_NONE, fault, values[0], values[1]);
    }
    app->buffers.ticks.states_count = 0;
    for (uint16_t i = 0; i < step->inputs_count && app->state == CRN_WIRE_STATE_RUNNING; i++) {
        const crn_app_encoders encoders = encoders_from_wire(&step->inputs[i]);
        crn_output output;
        crn_app_wish order;
        uint16_t values[2];
        (void)order_from_wire(app, &step->inputs[i], &order, values);
        note_buttons(app, encoders.buttons);
        if (!tick(app, &encoders, &order, &output)) break;
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
    crn_wire_input input;
    CRN_REJECT_IF(app, CRN_WIRE_TYPE_input, !crn_wire_decode_input(payload, length, &input),
                  CRN_REJECT_MALFORMED, length, CRN_WIRE_BYTES_input);
    CRN_REJECT_IF(app, CRN_WIRE_TYPE_input, input.encoders.hands_count != app->setup.tool_count,
                  CRN_REJECT_TOOL_COUNT, input.encoders.hands_count, app->setup.tool_count);
    CRN_REJECT_IF(app, CRN_WIRE_TYPE_input,
                  input.encoders.rhythm_action != 0 || input.encoders.rhythm_value != 0,
                  CRN_REJECT_RHYTHM_RANGE, input.encoders.rhythm_action, input.encoders.rhythm_value);
    CRN_REJECT_IF(app, CRN_WIRE_TYPE_input, input.encoders.scaffold_lesion != 0, CRN_REJECT_SCAFFOLD_RANGE,
                  input.encoders.scaffold_lesion, input.encoders.scaffold_last);
    CRN_REJECT_IF(app, CRN_WIRE_TYPE_input, input.encoders.strut_number != 0, CRN_REJECT_STRUT_RANGE,
                  input.encoders.strut_number, input.encoders.strut_inside_um);
    app->session.mailbox = encoders_from_wire(&input.encoders);
    app->session.has_mailbox = true;
}

/* An `input` may be repeated or dropped, a request to heart and breath may not: it waits for its tick. */
void crn_app_rhythm(crn_app *app, const uint8_t *payload, size_t length)
{
    const uint16_t type = CRN_WIRE_TYPE_rhythm;
    crn_wire_rhythm wire;
    CRN_REJECT_IF(app, type, !crn_wire_decode_rhythm(payload, length, &wire), CRN_REJECT_MALFORMED, length,
                  CRN_WIRE_BYTES_rhythm);
    CRN_REJECT_IF(app, type, app->mode != CRN_WIRE_MODE_FREE_RUN, CRN_REJECT_WRONG_MODE, app->mode, 0);
    CRN_REJECT_IF(app, type, app->state != CRN_WIRE_STATE_RUNNING, CRN_REJECT_WRONG_STATE, app->state, 0);
    const crn_rhythm_order order = {wire.action, wire.value};
    CRN_REJECT_IF(app, type, order.action == CRN_RHYTHM_KEEP || !crn_rhythm_order_is_valid(&order),
                  CRN_REJECT_RHYTHM_RANGE, order.action, order.value);
    CRN_REJECT_IF(app, type, app->session.order_count == CRN_APP_RHYTHM_QUEUE, CRN_REJECT_RHYTHM_FULL,
                  order.action, order.value);
    app->session.orders[app->session.order_count++] = (crn_app_wish){.rhythm = order};
    crn_app_send_status(app, type);
}

/* Waits for its tick as well. */
void crn_app_scaffold(crn_app *app, const uint8_t *payload, size_t length)
{
    const uint16_t type = CRN_WIRE_TYPE_scaffold;
    crn_wire_scaffold wire;
    CRN_REJECT_IF(app, type, !crn_wire_decode_scaffold(payload, length, &wire), CRN_REJECT_MALFORMED, length,
                  CRN_WIRE_BYTES_scaffold);
    CRN_REJECT_IF(app, type, app->mode != CRN_WIRE_MODE_FREE_RUN, CRN_REJECT_WRONG_MODE, app->mode, 0);
    CRN_REJECT_IF(app, type, app->state != CRN_WIRE_STATE_RUNNING, CRN_REJECT_WRONG_STATE, app->state, 0);
    crn_app_wish order = {.rhythm = {0, 0}};
    CRN_REJECT_IF(app, type, wire.lesion == 0 || !scaffold_from_wire(app, &wire, &order.scaffold),
                  CRN_REJECT_SCAFFOLD_RANGE, wire.lesion, wire.last);
    CRN_REJECT_IF(app, type, app->session.order_count == CRN_APP_RHYTHM_QUEUE, CRN_REJECT_RHYTHM_FULL,
                  wire.lesion, wire.last);
    app->session.orders[app->session.order_count++] = order;
    crn_app_send_status(app, type);
}

void crn_app_strut(crn_app *app, const uint8_t *payload, size_t length)
{
    const uint16_t type = CRN_WIRE_TYPE_strut;
    crn_wire_strut wire;
    CRN_REJECT_IF(app, type, !crn_wire_decode_strut(payload, length, &wire), CRN_REJECT_MALFORMED, length,
                  CRN_WIRE_BYTES_strut);
    CRN_REJECT_IF(app, type, app->mode != CRN_WIRE_MODE_FREE_RUN, CRN_REJECT_WRONG_MODE, app->mode, 0);
    CRN_REJECT_IF(app, type, app->state != CRN_WIRE_STATE_RUNNING, CRN_REJECT_WRONG_STATE, app->state, 0);
    const crn_app_wish order = {.strut = strut_from_wire(&wire)};
    CRN_REJECT_IF(app, type, wire.number == 0 || !crn_strut_order_is_valid(&order.strut),
                  CRN_REJECT_STRUT_RANGE, wire.number, wire.inside_um);
    CRN_REJECT_IF(app, type, app->session.order_count == CRN_APP_RHYTHM_QUEUE, CRN_REJECT_RHYTHM_FULL,
                  wire.number, wire.inside_um);
    app->session.orders[app->session.order_count++] = order;
    crn_app_send_status(app, type);
}

/* The order of this tick of FREE_RUN. */
static crn_app_wish next_order(crn_app *app)
{
    const crn_app_wish none = {.rhythm = {0, 0}},
                       order = app->session.order_count > 0 ? app->session.orders[0] : none;
    for (uint32_t i = 1; i < app->session.order_count; i++)
        app->session.orders[i - 1] = app->session.orders[i];
    if (app->session.order_count > 0) app->session.order_count--;
    return order;
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

/* What the host needs to replay this tick in LOCKSTEP and to see what the rig did. */
static void note_live(crn_app *app, const crn_app_encoders *encoders, const crn_app_wish *order,
                      const crn_output *output)
{
    crn_wire_live_tick *live = crn_app_stream_next(app);
    *live = (crn_wire_live_tick){.fade_milli = fade_milli(app)};
    note_tick(app, output, &live->state);
    live->input.rhythm_action = (uint8_t)order->rhythm.action;
    live->input.rhythm_value = (uint16_t)order->rhythm.value;
    if (order->scaffold.open_q30 > 0) {
        live->input.scaffold_lesion = (uint8_t)(order->scaffold.lesion + 1);
        live->input.scaffold_first = (uint8_t)order->scaffold.first;
        live->input.scaffold_last = (uint8_t)order->scaffold.last;
        live->input.scaffold_open_q15 = (uint16_t)(order->scaffold.open_q30 >> 15);
    }
    if (order->strut.number != 0) {
        live->input.strut_number = (uint8_t)order->strut.number;
        live->input.strut_joined = (uint8_t)order->strut.is_joined;
        live->input.strut_x_um = order->strut.centre_um[0];
        live->input.strut_y_um = order->strut.centre_um[1];
        live->input.strut_z_um = order->strut.centre_um[2];
        live->input.strut_inside_um = (uint16_t)order->strut.inside_um;
        live->input.strut_thickness_um = (uint16_t)order->strut.thickness_um;
    }
    live->input.inflator_raw = app->session.inflator_raw;
    live->input.hands_count = (uint16_t)app->setup.tool_count;
    live->force_measured_mN_count = (uint16_t)app->setup.tool_count;
    for (uint32_t k = 0; k < app->setup.tool_count; k++) {
        const crn_port_hand *last = &app->hands.counts[k].last;
        live->input.hands[k] = (crn_wire_hand){last->translation_counts, last->rotation_counts};
        live->force_measured_mN[k] = crn_app_force_measured(app, k);
    }
    if (encoders != NULL) {
        live->input.buttons = encoders->buttons;
        live->input.syringe_counts = encoders->syringe_counts;
    }
    if (encoders != NULL) live->flags |= CRN_WIRE_LIVE_HANDS;
    if (app->safety.is_driving) live->flags |= CRN_WIRE_LIVE_POWERED;
    if (app->clock.was_late) live->flags |= CRN_WIRE_LIVE_LATE;
}

static void free_run_tick(crn_app *app)
{
    crn_output output;
    crn_app_silence_count(app);
    crn_app_encoders encoders = app->edge.has_rig ? encoders_from_rig(&app->edge.rig) : app->session.mailbox;
    const crn_app_encoders *told = app->edge.has_rig || app->session.has_mailbox ? &encoders : NULL;
    if (told != NULL) note_buttons(app, told->buttons);
    const crn_app_wish order = next_order(app);
    if (!tick(app, told, &order, &output)) return;
    note_live(app, told, &order, &output);
    if (output.tick % CRN_APP_HASH64_EVERY_ticks == 0) crn_app_stream_hash64(app);
    crn_app_stream_tick(app);
}

void crn_app_timer(crn_app *app)
{
    app->link.answers = 0;
    const bool was_running = app->state == CRN_WIRE_STATE_RUNNING; /* before anything may end it */
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
