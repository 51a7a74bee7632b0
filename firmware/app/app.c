/* This file powers up the app, turns received bytes into frames, and gives each frame to the function that
 * handles its message. */
#include "firmware/app/app.h"
#include "firmware/app/app_internal.h"

_Static_assert((int)CRN_RHYTHM_HEART_RATE == (int)CRN_WIRE_RHYTHM_HEART_RATE &&
                   (int)CRN_RHYTHM_VARIABILITY == (int)CRN_WIRE_RHYTHM_VARIABILITY &&
                   (int)CRN_RHYTHM_PREMATURE == (int)CRN_WIRE_RHYTHM_PREMATURE &&
                   (int)CRN_RHYTHM_ASYSTOLE == (int)CRN_WIRE_RHYTHM_ASYSTOLE &&
                   (int)CRN_RHYTHM_BREATH_RATE == (int)CRN_WIRE_RHYTHM_BREATH_RATE &&
                   (int)CRN_RHYTHM_BREATH_HOLD == (int)CRN_WIRE_RHYTHM_BREATH_HOLD &&
                   (int)CRN_RHYTHM_IS_PREMATURE == (int)CRN_WIRE_RHYTHM_IS_PREMATURE &&
                   (int)CRN_RHYTHM_NEXT_PREMATURE == (int)CRN_WIRE_RHYTHM_NEXT_PREMATURE &&
                   (int)CRN_RHYTHM_WANTS_ASYSTOLE == (int)CRN_WIRE_RHYTHM_WANTS_ASYSTOLE &&
                   (int)CRN_RHYTHM_IS_RESTING == (int)CRN_WIRE_RHYTHM_IS_RESTING &&
                   (int)CRN_RHYTHM_HOLDS_BREATH == (int)CRN_WIRE_RHYTHM_HOLDS_BREATH,
               "core and wire agree about what heart and breath are asked for and what they are");
_Static_assert((int)CRN_TOOL_MAX == (int)CRN_PORT_TOOL_MAX && (int)CRN_TOOL_MAX == (int)CRN_WIRE_TOOL_MAX,
               "core, port and wire agree about the number of tools");

void crn_app_init(crn_app *app, const crn_port *port)
{
    unsigned char *bytes = (unsigned char *)app;
    for (size_t i = 0; i < sizeof *app; i++) bytes[i] = 0;
    app->port = port;
    app->state = CRN_WIRE_STATE_INIT;
    app->mode = CRN_WIRE_MODE_LOCKSTEP;
    crn_wire_decoder_init(&app->link.decoder);
    for (uint32_t k = 0; k < CRN_TOOL_MAX; k++) {
        crn_app_track_default(&app->setup.tracks[k], port);
        crn_app_track_apply(app, k);
    }
    crn_hands_reset(&app->hands);
    crn_haptics_reset(&app->haptics);
    crn_app_motors_off(app);
}

static void host_spoke(crn_app *app)
{
    if (crn_watchdog_feed(&app->watchdog)) crn_app_notice(app, CRN_WIRE_EVENT_HOST, 0, 0, 0);
}

/* Returns true while the motors have power, unless the host has been silent so long that the motors' forces
 * have faded to zero. */
static bool is_led(const crn_app *app)
{
    return app->safety.is_driving && crn_watchdog_left_ticks(&app->watchdog) > 0;
}

/* While one program controls powered motors, a second program could connect with HELLO. The second program
 * would next send RESET, which would end the first program's session with the device. While one program
 * controls powered motors, the device refuses another program's HELLO. A refused HELLO does not count as a
 * message of the program in control. A host that speaks another version of the protocol may not give the
 * device any command, even in the middle of a session. */
static void hello(crn_app *app, const uint8_t *payload, size_t length)
{
    crn_wire_hello hello;
    CRN_REJECT_IF(app, CRN_WIRE_TYPE_hello, !crn_wire_decode_hello(payload, length, &hello),
                  CRN_REJECT_MALFORMED, length, CRN_WIRE_BYTES_hello);
    const bool is_understood =
        hello.protocol_major == CRN_WIRE_PROTOCOL_MAJOR && hello.schema_hash == crn_wire_schema_hash();
    CRN_REJECT_IF(app, CRN_WIRE_TYPE_hello, is_understood && is_led(app), CRN_REJECT_BUSY,
                  app->watchdog.silent_ticks, 0);
    app->link.is_greeted = is_understood;
    if (is_understood) host_spoke(app);
    crn_permission_spend(&app->permission); /* a permission of another conversation is not for this one */
    if (app->link.is_greeted && app->state == CRN_WIRE_STATE_INIT)
        crn_app_set_state(app, CRN_WIRE_STATE_READY);
    if (!app->link.is_greeted && app->state == CRN_WIRE_STATE_RUNNING) {
        crn_app_stop(app); /* no other host could stop the motors */
    }
    crn_app_send_hello_reply(app, app->link.is_greeted);
}

static bool is_built(const crn_app *app)
{
    return app->state == CRN_WIRE_STATE_ARMED || app->state == CRN_WIRE_STATE_RUNNING;
}

static void get(crn_app *app, const uint8_t *payload, size_t length)
{
    const uint16_t type = CRN_WIRE_TYPE_get;
    crn_wire_get request;
    CRN_REJECT_IF(app, type, !crn_wire_decode_get(payload, length, &request), CRN_REJECT_MALFORMED, length,
                  CRN_WIRE_BYTES_get);
    bool needs_model = request.what == CRN_WIRE_GET_NODES || request.what == CRN_WIRE_GET_NODE_TABLE ||
                       request.what == CRN_WIRE_GET_HASH64 || request.what == CRN_WIRE_GET_SNAPSHOT ||
                       request.what == CRN_WIRE_GET_CONTACTS;
    CRN_REJECT_IF(app, type, needs_model && !is_built(app), CRN_REJECT_WRONG_STATE, app->state, 0);
    switch (request.what) {
    case CRN_WIRE_GET_STATUS:
        crn_app_send_status(app, type);
        break;
    case CRN_WIRE_GET_NODES:
        crn_app_send_nodes(app);
        break;
    case CRN_WIRE_GET_NODE_TABLE:
        crn_app_send_node_table(app);
        break;
    case CRN_WIRE_GET_HASH64:
        crn_app_send_hash64(app);
        break;
    case CRN_WIRE_GET_SNAPSHOT:
        crn_app_snapshot_send(app);
        break;
    case CRN_WIRE_GET_FAULT_LOG:
        crn_app_send_fault_log(app);
        break;
    case CRN_WIRE_GET_CONTACTS:
        crn_app_send_contacts(app);
        break;
    case CRN_WIRE_GET_RIG:
        crn_app_send_rig(app);
        break;
    case CRN_WIRE_GET_SET_UP:
        crn_app_send_set_up(app);
        break;
    case CRN_WIRE_GET_SENSORS:
        crn_app_send_sensors(app);
        break;
    default:
        crn_app_reject(app, type, CRN_REJECT_ACTION_UNKNOWN, request.what, 0);
    }
}

static void dispatch(crn_app *app, uint16_t type, const uint8_t *payload, size_t length)
{
    if (type == CRN_WIRE_TYPE_hello) {
        hello(app, payload, length);
        return;
    }
    CRN_REJECT_IF(app, type, !app->link.is_greeted, CRN_REJECT_NOT_GREETED, type, 0);
    switch (type) {
    case CRN_WIRE_TYPE_scene_begin:
        crn_app_scene_begin(app, payload, length);
        break;
    case CRN_WIRE_TYPE_scene_chunk:
        crn_app_scene_chunk(app, payload, length);
        break;
    case CRN_WIRE_TYPE_scene_end:
        crn_app_scene_end(app, payload, length);
        break;
    case CRN_WIRE_TYPE_tools:
        crn_app_tools(app, payload, length);
        break;
    case CRN_WIRE_TYPE_entry:
        crn_app_entry(app, payload, length);
        break;
    case CRN_WIRE_TYPE_rig:
        crn_app_rig(app, payload, length);
        break;
    case CRN_WIRE_TYPE_command:
        crn_app_command(app, payload, length);
        break;
    case CRN_WIRE_TYPE_step:
        crn_app_step(app, payload, length);
        break;
    case CRN_WIRE_TYPE_stream:
        crn_app_stream(app, payload, length);
        break;
    case CRN_WIRE_TYPE_input:
        crn_app_input(app, payload, length);
        break;
    case CRN_WIRE_TYPE_orders:
        crn_app_orders(app, payload, length);
        break;
    case CRN_WIRE_TYPE_get:
        get(app, payload, length);
        break;
    case CRN_WIRE_TYPE_snapshot_begin:
        crn_app_snapshot_begin(app, payload, length);
        break;
    case CRN_WIRE_TYPE_snapshot_chunk:
        crn_app_snapshot_chunk(app, payload, length);
        break;
    case CRN_WIRE_TYPE_snapshot_end:
        crn_app_snapshot_end(app, payload, length);
        break;
    default:
        crn_app_reject(app, type, CRN_REJECT_UNKNOWN_TYPE, type, 0);
    }
}

static void take_frame(crn_app *app)
{
    uint16_t sequence = app->link.decoder.header.sequence;
    bool follows = sequence == (uint16_t)(app->link.sequence_in + 1) ||
                   (sequence == 1 && app->link.sequence_in == UINT16_MAX);
    if (app->link.sequence_is_known && !follows) app->link.sequence_gaps++;
    app->link.sequence_in = sequence;
    app->link.sequence_is_known = true;
    if (app->link.is_greeted && app->link.decoder.header.type != CRN_WIRE_TYPE_hello) host_spoke(app);
    app->link.answers = sequence;
    dispatch(app, app->link.decoder.header.type, app->link.decoder.payload, app->link.decoder.payload_bytes);
    app->link.answers = 0;
}

/* Requirement: SR-19 */
void crn_app_receive(crn_app *app, const uint8_t *bytes, size_t count)
{
    for (size_t i = 0, taken; i < count; i += taken) {
        if (crn_wire_decoder_take(&app->link.decoder, bytes + i, count - i, &taken) == CRN_WIRE_FRAME)
            take_frame(app);
    }
}

/* --- a host that speaks without frames --- */

static bool may_speak(crn_app *app, uint16_t type)
{
    if (!app->link.is_greeted) {
        crn_app_reject(app, type, CRN_REJECT_NOT_GREETED, type, 0);
        return false;
    }
    host_spoke(app);
    return true;
}

bool crn_app_order(crn_app *app, uint8_t action)
{
    const bool is_stop = action == CRN_WIRE_ACTION_STOP;
    if (!is_stop && action != CRN_WIRE_ACTION_RESET) return false;
    const crn_wire_command command = {.action = action};
    if (may_speak(app, CRN_WIRE_TYPE_command)) crn_app_command_take(app, &command);
    return is_stop ? app->state != CRN_WIRE_STATE_RUNNING : app->state == CRN_WIRE_STATE_READY;
}

void crn_app_configure(crn_app *app, const crn_wire_rig *rig)
{
    if (may_speak(app, CRN_WIRE_TYPE_rig)) crn_app_rig_take(app, rig);
}
