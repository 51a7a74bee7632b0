/* This file implements the states and modes of the app and the commands ARM, START, STOP, RESET, LOCKSTEP and
 * FREE_RUN. This file also implements the two confirmation steps that must precede a START with powered
 * motors. */
#include "firmware/app/app_internal.h"

enum { START_DEPTH_MAX_M_Q30 = 322123 /* 0.3 mm: the wall pushes such a tool back without a jolt */ };

void crn_app_set_state(crn_app *app, uint8_t state)
{
    uint8_t old = app->state;
    app->state = state;
    if (old != state) crn_app_notice(app, CRN_WIRE_EVENT_STATE, state, old, 0);
}

/* --- ARM: constants and rest state from what was set up --- */

/* Checks that no tool begins with an inserted length that exceeds the tool's own length; returns false when
 * the set-up was refused. */
static bool lengths_fit(crn_app *app)
{
    for (uint32_t k = 0; k < app->setup.tool_count; k++) {
        if (app->setup.line[k] == 0) continue;
        const uint32_t number = app->setup.line[k] - 1;
        const crn_instrument *tool = &app->port->tool_table[number];
        uint32_t length_um = tool->knots[tool->knot_count - 1].arc_um;
        if (app->setup.inserted_um[k] <= length_um) continue;
        crn_app_reject(app, CRN_WIRE_TYPE_command, CRN_REJECT_LENGTH_INSERTED, number, length_um);
        return false;
    }
    return true;
}

static uint32_t longest_um(const crn_app *app)
{
    uint32_t longest = 0;
    for (uint32_t k = 0; k < app->setup.tool_count; k++) {
        if (app->setup.line[k] != 0 && app->setup.inserted_um[k] > longest)
            longest = app->setup.inserted_um[k];
    }
    return longest;
}

static void arm(crn_app *app)
{
    const uint16_t type = CRN_WIRE_TYPE_command;
    CRN_REJECT_IF(app, type, app->state != CRN_WIRE_STATE_READY, CRN_REJECT_WRONG_STATE, app->state, 0);
    CRN_REJECT_IF(app, type, app->setup.tool_count == 0 || !app->setup.has_entry, CRN_REJECT_SET_UP_MISSING,
                  app->setup.tool_count, app->setup.has_entry);
    crn_build_place place = {0, 0};
    const crn_lumen *lumen = app->setup.has_scene ? &app->setup.lumen : NULL;
    crn_build_status status = crn_app_build(app, lumen, &app->setup.entry, &place);
    if (status != CRN_BUILD_OK) {
        crn_app_reject_build(app, type, status, &place);
        return;
    }
    if (!lengths_fit(app)) return;
    if (app->mode == CRN_WIRE_MODE_FREE_RUN && !crn_app_is_in_time(app)) return;
    crn_state_init(&app->model, &app->core, app->setup.inserted_um);
    int32_t depth_m_q30 = crn_state_depth(&app->model, &app->core);
    CRN_REJECT_IF(app, type, depth_m_q30 > START_DEPTH_MAX_M_Q30, CRN_REJECT_START_IN_WALL,
                  (uint32_t)(((uint64_t)(uint32_t)depth_m_q30 * 1000000u) >> 30), longest_um(app));
    crn_hands_reset(&app->hands);
    crn_haptics_reset(&app->haptics);
    crn_haptics_rest(&app->haptics);
    crn_app_motors_off(app);
    crn_app_stream_clear(app);
    app->faults.core_bits_seen = 0;
    app->buffers.ticks.states_count = 0;
    app->session.has_stop = false;
    crn_app_set_state(app, CRN_WIRE_STATE_ARMED);
    crn_app_send_status(app, type);
}

/* --- ARM_MOTORS and CONFIRM --- */

static bool may_arm_motors(crn_app *app)
{
    const uint16_t type = CRN_WIRE_TYPE_command;
    if (app->mode != CRN_WIRE_MODE_FREE_RUN) {
        crn_app_reject(app, type, CRN_REJECT_WRONG_MODE, app->mode, 0);
        return false;
    }
    if (app->state != CRN_WIRE_STATE_ARMED) {
        crn_app_reject(app, type, CRN_REJECT_WRONG_STATE, app->state, 0);
        return false;
    }
    if (!app->edge.has_rig || crn_app_driven_tracks(app) == 0) {
        crn_app_reject(app, type, CRN_REJECT_NO_RIG, app->edge.has_rig, app->setup.tool_count);
        return false;
    }
    crn_fault_code code = crn_app_safety_ready(app);
    if (code != CRN_FAULT_CODE_NONE) crn_app_reject(app, type, CRN_REJECT_NOT_SAFE, code, 0);
    return code == CRN_FAULT_CODE_NONE;
}

static void arm_motors(crn_app *app)
{
    crn_permission_spend(&app->permission);
    if (!may_arm_motors(app)) return;
    crn_permission_offer(&app->permission, app->port->now_us(app->port->context));
    crn_app_send_status(app, CRN_WIRE_TYPE_command);
}

static void confirm(crn_app *app, uint32_t code)
{
    const bool is_right = crn_permission_answer(&app->permission, code);
    CRN_REJECT_IF(app, CRN_WIRE_TYPE_command, !is_right, CRN_REJECT_CODE_WRONG, app->permission.age_ticks,
                  code);
    if (!may_arm_motors(app)) return;
    crn_permission_give(&app->permission);
    crn_app_send_status(app, CRN_WIRE_TYPE_command);
}

/* --- START, STOP, RESET, modes --- */

/* Makes the next reading of the hands' positions the new zero position of the coupling, where the coupling
 * gives no force. */
static void forget_hands(crn_app *app)
{
    crn_hands_take_reference(&app->hands);
    crn_haptics_reset(&app->haptics);
}

/* In FREE_RUN the app does not read the hands' positions before START, so FREE_RUN begins with a new zero
 * position of the coupling and with zero motor forces. In LOCKSTEP, a session continues after a STOP from
 * exactly the state in which it stopped. After a change of mode, the next reading of the hands' positions
 * becomes the new zero position of the coupling. If the device has restored a snapshot that was taken in the
 * state ARMED, START begins with exactly the restored state. A FREE_RUN session that continues from a
 * snapshot taken in the state ARMED replays bit for bit. */
static void begin_listening(crn_app *app)
{
    app->watchdog.silent_ticks = 0;
    app->session.order_count = 0;
    app->session.inflator_raw = 0;
    app->session.has_stop = false;
    if (app->mode != CRN_WIRE_MODE_FREE_RUN) return;
    forget_hands(app);
    crn_haptics_rest(&app->haptics);
    app->session.has_mailbox = false;
}

static void start(crn_app *app)
{
    const uint16_t type = CRN_WIRE_TYPE_command;
    CRN_REJECT_IF(app, type, app->state != CRN_WIRE_STATE_ARMED, CRN_REJECT_WRONG_STATE, app->state, 0);
    bool powers = app->mode == CRN_WIRE_MODE_FREE_RUN && app->edge.has_rig && crn_app_driven_tracks(app) > 0;
    CRN_REJECT_IF(app, type, powers && !app->permission.is_given, CRN_REJECT_NOT_CONFIRMED, 0, 0);
    if (powers && !may_arm_motors(app)) return;
    crn_app_motors_off(app); /* spends the permission */
    begin_listening(app);
    if (powers) crn_app_motors_on(app);
    crn_app_set_state(app, CRN_WIRE_STATE_RUNNING);
    crn_app_send_status(app, type);
}

/* This sends nothing to the host; the caller reports the STOP. */
void crn_app_stop(crn_app *app)
{
    app->session.has_stop = false;
    crn_app_motors_off(app);
    crn_app_set_state(app, CRN_WIRE_STATE_ARMED);
    if (app->mode != CRN_WIRE_MODE_FREE_RUN) return;
    crn_hands_take_reference(&app->hands);
    crn_haptics_rest(&app->haptics);
}

/* A STOP for a later tick is stored, and the function stop_when_due carries it out. */
static void stop(crn_app *app, uint32_t tick)
{
    CRN_REJECT_IF(app, CRN_WIRE_TYPE_command, app->state != CRN_WIRE_STATE_RUNNING, CRN_REJECT_WRONG_STATE,
                  app->state, 0);
    app->session.has_stop = tick > app->core.words.tick;
    app->session.stop_tick = tick;
    if (!app->session.has_stop) crn_app_stop(app);
    crn_app_send_status(app, CRN_WIRE_TYPE_command);
}

static void reset(crn_app *app)
{
    crn_app_motors_off(app);
    app->faults.stopped_by = CRN_FAULT_CODE_NONE;
    app->session.snapshot_upload.open = false;
    app->buffers.ticks.states_count = 0;
    app->session.has_stop = false;
    crn_app_set_state(app, CRN_WIRE_STATE_READY);
    crn_app_send_status(app, CRN_WIRE_TYPE_command);
}

static void set_mode(crn_app *app, uint8_t mode)
{
    bool is_at_rest = app->state == CRN_WIRE_STATE_READY || app->state == CRN_WIRE_STATE_ARMED;
    CRN_REJECT_IF(app, CRN_WIRE_TYPE_command, !is_at_rest, CRN_REJECT_WRONG_STATE, app->state, 0);
    /* In READY no model is built yet, so ARM decides. */
    if (mode == CRN_WIRE_MODE_FREE_RUN && app->state == CRN_WIRE_STATE_ARMED && !crn_app_is_in_time(app))
        return;
    crn_app_motors_off(app);
    if (mode != app->mode) forget_hands(app);
    app->mode = mode;
    crn_haptics_rest(&app->haptics);
    crn_app_send_status(app, CRN_WIRE_TYPE_command);
}

void crn_app_command_take(crn_app *app, const crn_wire_command *command)
{
    crn_app_notice(app, CRN_WIRE_EVENT_COMMAND, command->action, 0, 0);
    switch (command->action) {
    case CRN_WIRE_ACTION_ARM:
        arm(app);
        break;
    case CRN_WIRE_ACTION_START:
        start(app);
        break;
    case CRN_WIRE_ACTION_STOP:
        stop(app, command->tick);
        break;
    case CRN_WIRE_ACTION_RESET:
        reset(app);
        break;
    case CRN_WIRE_ACTION_LOCKSTEP:
        set_mode(app, CRN_WIRE_MODE_LOCKSTEP);
        break;
    case CRN_WIRE_ACTION_FREE_RUN:
        set_mode(app, CRN_WIRE_MODE_FREE_RUN);
        break;
    case CRN_WIRE_ACTION_ARM_MOTORS:
        arm_motors(app);
        break;
    case CRN_WIRE_ACTION_CONFIRM:
        confirm(app, command->code);
        break;
    default:
        crn_app_reject(app, CRN_WIRE_TYPE_command, CRN_REJECT_ACTION_UNKNOWN, command->action, 0);
    }
}

void crn_app_command(crn_app *app, const uint8_t *payload, size_t length)
{
    crn_wire_command command;
    CRN_REJECT_IF(app, CRN_WIRE_TYPE_command, !crn_wire_decode_command(payload, length, &command),
                  CRN_REJECT_MALFORMED, length, CRN_WIRE_BYTES_command);
    crn_app_command_take(app, &command);
}
