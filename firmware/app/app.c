/* Power-up and dispatch: bytes -> frames -> handlers. Called by: firmware/port. */
#include "firmware/app/app.h"
#include "firmware/app/app_internal.h"

_Static_assert((int)SELD_RHYTHM_HEART_RATE == (int)SELD_WIRE_RHYTHM_HEART_RATE &&
                   (int)SELD_RHYTHM_VARIABILITY == (int)SELD_WIRE_RHYTHM_VARIABILITY &&
                   (int)SELD_RHYTHM_PREMATURE == (int)SELD_WIRE_RHYTHM_PREMATURE &&
                   (int)SELD_RHYTHM_ASYSTOLE == (int)SELD_WIRE_RHYTHM_ASYSTOLE &&
                   (int)SELD_RHYTHM_BREATH_RATE == (int)SELD_WIRE_RHYTHM_BREATH_RATE &&
                   (int)SELD_RHYTHM_BREATH_HOLD == (int)SELD_WIRE_RHYTHM_BREATH_HOLD &&
                   (int)SELD_RHYTHM_IS_PREMATURE == (int)SELD_WIRE_RHYTHM_IS_PREMATURE &&
                   (int)SELD_RHYTHM_NEXT_PREMATURE == (int)SELD_WIRE_RHYTHM_NEXT_PREMATURE &&
                   (int)SELD_RHYTHM_WANTS_ASYSTOLE == (int)SELD_WIRE_RHYTHM_WANTS_ASYSTOLE &&
                   (int)SELD_RHYTHM_IS_RESTING == (int)SELD_WIRE_RHYTHM_IS_RESTING &&
                   (int)SELD_RHYTHM_HOLDS_BREATH == (int)SELD_WIRE_RHYTHM_HOLDS_BREATH,
               "core and wire agree about what heart and breath are asked for and what they are");
_Static_assert((int)SELD_TOOL_MAX == (int)SELD_PORT_TOOL_MAX && (int)SELD_TOOL_MAX == (int)SELD_WIRE_TOOL_MAX,
               "core, port and wire agree about the number of tools");

void seld_app_init(seld_app *app, const seld_port *port)
{
    unsigned char *bytes = (unsigned char *)app;
    for (size_t i = 0; i < sizeof *app; i++) bytes[i] = 0;
    app->port = port;
    app->state = SELD_WIRE_STATE_INIT;
    app->mode = SELD_WIRE_MODE_LOCKSTEP;
    seld_wire_decoder_init(&app->decoder);
    for (uint32_t k = 0; k < SELD_TOOL_MAX; k++) seld_app_track_default(&app->tracks[k], port);
    seld_app_hands_reset(app);
    seld_app_coupling_reset(app);
    seld_app_motors_off(app);
}

static void host_spoke(seld_app *app)
{
    if (app->silent_ticks >= SELD_APP_HOST_SILENT_ticks) seld_app_notice(app, SELD_WIRE_EVENT_HOST, 0, 0, 0);
    app->silent_ticks = 0;
}

/* A host is there that leads motors with power: its silence has not ended the forces yet. */
static bool is_led(const seld_app *app)
{
    return app->is_driving && app->silent_ticks < SELD_APP_HOST_SILENT_ticks + SELD_APP_FADE_ticks;
}

/* A program that begins its own conversation in the middle of that would end the other's with its next word, RESET: it is refused, which
 * is no sign of life of the one that leads. A host that speaks another language may not command anything, even in the middle of a session. */
static void hello(seld_app *app, const uint8_t *payload, size_t length)
{
    seld_wire_hello hello;
    SELD_REJECT_IF(app, SELD_WIRE_TYPE_hello, !seld_wire_decode_hello(payload, length, &hello),
                   SELD_REJECT_MALFORMED, length, SELD_WIRE_BYTES_hello);
    const bool is_understood =
        hello.protocol_major == SELD_WIRE_PROTOCOL_MAJOR && hello.schema_hash == seld_wire_schema_hash();
    SELD_REJECT_IF(app, SELD_WIRE_TYPE_hello, is_understood && is_led(app), SELD_REJECT_BUSY,
                   app->silent_ticks, 0);
    app->is_greeted = is_understood;
    if (is_understood) host_spoke(app);
    app->arm_code = 0; /* what another conversation was allowed is not for this one */
    app->motors_armed = false;
    if (app->is_greeted && app->state == SELD_WIRE_STATE_INIT) seld_app_set_state(app, SELD_WIRE_STATE_READY);
    if (!app->is_greeted && app->state == SELD_WIRE_STATE_RUNNING) {
        seld_app_stop(app); /* nobody is left who could stop the motors */
    }
    seld_app_send_hello_reply(app, app->is_greeted);
}

static bool is_built(const seld_app *app)
{
    return app->state == SELD_WIRE_STATE_ARMED || app->state == SELD_WIRE_STATE_RUNNING;
}

static void get(seld_app *app, const uint8_t *payload, size_t length)
{
    const uint16_t type = SELD_WIRE_TYPE_get;
    seld_wire_get request;
    SELD_REJECT_IF(app, type, !seld_wire_decode_get(payload, length, &request), SELD_REJECT_MALFORMED, length,
                   SELD_WIRE_BYTES_get);
    bool needs_model = request.what == SELD_WIRE_GET_NODES || request.what == SELD_WIRE_GET_NODE_TABLE ||
                       request.what == SELD_WIRE_GET_HASH64 || request.what == SELD_WIRE_GET_SNAPSHOT ||
                       request.what == SELD_WIRE_GET_CONTACTS;
    SELD_REJECT_IF(app, type, needs_model && !is_built(app), SELD_REJECT_WRONG_STATE, app->state, 0);
    switch (request.what) {
    case SELD_WIRE_GET_STATUS:
        seld_app_send_status(app, type);
        break;
    case SELD_WIRE_GET_NODES:
        seld_app_send_nodes(app);
        break;
    case SELD_WIRE_GET_NODE_TABLE:
        seld_app_send_node_table(app);
        break;
    case SELD_WIRE_GET_HASH64:
        seld_app_send_hash64(app);
        break;
    case SELD_WIRE_GET_SNAPSHOT:
        seld_app_snapshot_send(app);
        break;
    case SELD_WIRE_GET_FAULT_LOG:
        seld_app_send_fault_log(app);
        break;
    case SELD_WIRE_GET_CONTACTS:
        seld_app_send_contacts(app);
        break;
    case SELD_WIRE_GET_RIG:
        seld_app_send_rig(app);
        break;
    case SELD_WIRE_GET_SET_UP:
        seld_app_send_set_up(app);
        break;
    case SELD_WIRE_GET_SENSORS:
        seld_app_send_sensors(app);
        break;
    default:
        seld_app_reject(app, type, SELD_REJECT_ACTION_UNKNOWN, request.what, 0);
    }
}

static void dispatch(seld_app *app, uint16_t type, const uint8_t *payload, size_t length)
{
    if (type == SELD_WIRE_TYPE_hello) {
        hello(app, payload, length);
        return;
    }
    SELD_REJECT_IF(app, type, !app->is_greeted, SELD_REJECT_NOT_GREETED, type, 0);
    switch (type) {
    case SELD_WIRE_TYPE_scene_begin:
        seld_app_scene_begin(app, payload, length);
        break;
    case SELD_WIRE_TYPE_scene_chunk:
        seld_app_scene_chunk(app, payload, length);
        break;
    case SELD_WIRE_TYPE_scene_end:
        seld_app_scene_end(app, payload, length);
        break;
    case SELD_WIRE_TYPE_tools:
        seld_app_tools(app, payload, length);
        break;
    case SELD_WIRE_TYPE_entry:
        seld_app_entry(app, payload, length);
        break;
    case SELD_WIRE_TYPE_rig:
        seld_app_rig(app, payload, length);
        break;
    case SELD_WIRE_TYPE_command:
        seld_app_command(app, payload, length);
        break;
    case SELD_WIRE_TYPE_step:
        seld_app_step(app, payload, length);
        break;
    case SELD_WIRE_TYPE_stream:
        seld_app_stream(app, payload, length);
        break;
    case SELD_WIRE_TYPE_input:
        seld_app_input(app, payload, length);
        break;
    case SELD_WIRE_TYPE_scaffold:
        seld_app_scaffold(app, payload, length);
        break;
    case SELD_WIRE_TYPE_strut:
        seld_app_strut(app, payload, length);
        break;
    case SELD_WIRE_TYPE_rhythm:
        seld_app_rhythm(app, payload, length);
        break;
    case SELD_WIRE_TYPE_get:
        get(app, payload, length);
        break;
    case SELD_WIRE_TYPE_snapshot_begin:
        seld_app_snapshot_begin(app, payload, length);
        break;
    case SELD_WIRE_TYPE_snapshot_chunk:
        seld_app_snapshot_chunk(app, payload, length);
        break;
    case SELD_WIRE_TYPE_snapshot_end:
        seld_app_snapshot_end(app, payload, length);
        break;
    default:
        seld_app_reject(app, type, SELD_REJECT_UNKNOWN_TYPE, type, 0);
    }
}

static void take_frame(seld_app *app)
{
    uint16_t sequence = app->decoder.header.sequence;
    bool follows =
        sequence == (uint16_t)(app->sequence_in + 1) || (sequence == 1 && app->sequence_in == UINT16_MAX);
    if (app->sequence_is_known && !follows) app->sequence_gaps++;
    app->sequence_in = sequence;
    app->sequence_is_known = true;
    if (app->is_greeted && app->decoder.header.type != SELD_WIRE_TYPE_hello) host_spoke(app);
    app->answers = sequence;
    dispatch(app, app->decoder.header.type, app->decoder.payload, app->decoder.payload_bytes);
    app->answers = 0;
}

void seld_app_receive(seld_app *app, const uint8_t *bytes, size_t count)
{
    for (size_t i = 0; i < count; i++) {
        if (seld_wire_decoder_push(&app->decoder, bytes[i]) == SELD_WIRE_FRAME) take_frame(app);
    }
}

/* --- a host that speaks without frames --- */

static bool may_speak(seld_app *app, uint16_t type)
{
    if (!app->is_greeted) {
        seld_app_reject(app, type, SELD_REJECT_NOT_GREETED, type, 0);
        return false;
    }
    host_spoke(app);
    return true;
}

bool seld_app_order(seld_app *app, uint8_t action)
{
    const bool is_stop = action == SELD_WIRE_ACTION_STOP;
    if (!is_stop && action != SELD_WIRE_ACTION_RESET) return false;
    const seld_wire_command command = {.action = action};
    if (may_speak(app, SELD_WIRE_TYPE_command)) seld_app_command_take(app, &command);
    return is_stop ? app->state != SELD_WIRE_STATE_RUNNING : app->state == SELD_WIRE_STATE_READY;
}

void seld_app_configure(seld_app *app, const seld_wire_rig *rig)
{
    if (may_speak(app, SELD_WIRE_TYPE_rig)) seld_app_rig_take(app, rig);
}
