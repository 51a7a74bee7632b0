#include "firmware/tests/reference/haptic_rig.h"

#include <math.h>
#include <string.h>

#include "firmware/app/app_internal.h"

enum { SUBSTEPS = 20 };

/* --- the port --- */

static bool transmit(void *context, const uint8_t *frame, size_t bytes)
{
    haptic_rig *rig = context;
    for (size_t i = 0; i < bytes; i++) {
        if (crn_wire_decoder_push(&rig->decoder, frame[i]) != CRN_WIRE_FRAME) continue;
        if (rig->decoder.header.type == CRN_WIRE_TYPE_reject) rig->refusals++;
        if (rig->decoder.header.type == CRN_WIRE_TYPE_status)
            crn_wire_decode_status(rig->decoder.payload, rig->decoder.payload_bytes, &rig->status);
    }
    return true;
}

static size_t room(void *context)
{
    (void)context;
    return SIZE_MAX / 2;
}

static bool inputs(void *context, crn_port_inputs *sample)
{
    haptic_rig *rig = context;
    *sample = rig->inputs;
    sample->stage_on = rig->stage_hold_ms > 0;
    return true;
}

static void outputs(void *context, const crn_port_outputs *wanted)
{
    haptic_rig *rig = context;
    if (wanted->drive != rig->outputs.drive) rig->stage_hold_ms = CRN_PORT_DRIVE_HOLD_ms;
    if (!wanted->enable) rig->stage_hold_ms = 0;
    rig->outputs = *wanted;
}

static uint32_t now_us(void *context)
{
    return ((haptic_rig *)context)->time_us;
}

/* --- a host --- */

#define SAY(rig, name, value)                                                                                \
    do {                                                                                                     \
        static uint8_t say_payload[CRN_WIRE_PAYLOAD_MAX], say_frame[CRN_WIRE_FRAME_MAX];                     \
        crn_wire_writer say_writer = crn_wire_writer_make(say_payload, sizeof say_payload);                  \
        const crn_wire_header say_header = {1, 0, CRN_WIRE_TYPE_##name};                                     \
        crn_wire_put_##name(&say_writer, value);                                                             \
        size_t say_bytes =                                                                                   \
            crn_wire_frame_encode(&say_header, say_payload, say_writer.length, say_frame, sizeof say_frame); \
        crn_app_receive(&(rig)->app, say_frame, say_bytes);                                                  \
    } while (0)

static void command(haptic_rig *rig, uint8_t action, uint32_t code)
{
    const crn_wire_command message = {.action = action, .code = code};
    SAY(rig, command, &message);
}

static void set_up(haptic_rig *rig, const crn_lumen *lumen, const crn_wire_instrument *wire,
                   uint32_t inserted_um, const crn_wire_track *track)
{
    static crn_wire_tools tools;
    const crn_wire_hello hello = {CRN_WIRE_PROTOCOL_MAJOR, CRN_WIRE_PROTOCOL_MINOR, crn_wire_schema_hash()};
    const crn_wire_rig tracks = {.tracks_count = 1, .tracks = {*track}};
    const crn_wire_entry entry = {
        .direction_x_q30 = 1 << 30, .inserted_um_count = 1, .inserted_um = {inserted_um}};
    SAY(rig, hello, &hello);
    SAY(rig, rig, &tracks);
    tools.tools_count = 1;
    tools.tools[0] = *wire;
    SAY(rig, tools, &tools);
    SAY(rig, entry, &entry);
    if (lumen != NULL) { /* the state in which validation leaves a scene */
        rig->app.setup.lumen = *lumen;
        rig->app.setup.has_scene = true;
    }
}

bool haptic_begin(haptic_rig *rig, const crn_lumen *lumen, const crn_wire_instrument *wire,
                  uint32_t inserted_um, const crn_wire_track *track, const haptic_hand *hand)
{
    memset(rig, 0, sizeof *rig);
    rig->port = (crn_port){.context = rig,
                           .transmit = transmit,
                           .transmit_room = room,
                           .inputs = inputs,
                           .outputs = outputs,
                           .now_us = now_us,
                           .serial = "haptic",
                           .tool_table = rig->tool_table};
    rig->inputs.supply_good = true;
    rig->hand = *hand;
    rig->random = 1;
    crn_wire_decoder_init(&rig->decoder);
    crn_app_init(&rig->app, &rig->port);
    set_up(rig, lumen, wire, inserted_um, track);
    command(rig, CRN_WIRE_ACTION_FREE_RUN, 0);
    command(rig, CRN_WIRE_ACTION_ARM, 0);
    haptic_tick(rig, 0);
    command(rig, CRN_WIRE_ACTION_ARM_MOTORS, 0);
    command(rig, CRN_WIRE_ACTION_CONFIRM, rig->status.arm_code);
    command(rig, CRN_WIRE_ACTION_START, 0);
    return rig->refusals == 0 && rig->status.state == CRN_WIRE_STATE_RUNNING && rig->status.motors_armed;
}

/* --- physics --- */

/* Coulomb friction stops a carriage whose motion would otherwise reverse within the step. */
static double slowed(double speed_m_s, double force_N, double step_s)
{
    const double mass = HAPTIC_MASS_g * 1e-3, friction = HAPTIC_FRICTION_mN * 1e-3;
    double free_m_s = speed_m_s + force_N / mass * step_s, loss = friction / mass * step_s;
    if (fabs(free_m_s) <= loss) return 0;
    return free_m_s - copysign(loss, free_m_s);
}

static void move(haptic_rig *rig, double step_s)
{
    double wanted_N = rig->stage_hold_ms > 0 ? rig->outputs.motors[0].axial_mN * 1e-3 : 0;
    rig->motor_N += (wanted_N - rig->motor_N) * step_s / (HAPTIC_MOTOR_LAG_us * 1e-6);
    rig->hand_N = rig->hand.stiffness_N_m * (rig->wanted_m - rig->carriage_m) +
                  rig->hand.damping_N_s_m * (rig->wanted_m_s - rig->carriage_m_s);
    double force = rig->hand_N - rig->motor_N - HAPTIC_DAMPING_mN_s_m * 1e-3 * rig->carriage_m_s;
    rig->carriage_m_s = slowed(rig->carriage_m_s, force, step_s);
    rig->carriage_m += rig->carriage_m_s * step_s;
}

static double noise(haptic_rig *rig)
{
    rig->random = rig->random * 1664525u + 1013904223u;
    return (rig->random >> 8) / 16777216.0 - 0.5;
}

void haptic_tick(haptic_rig *rig, double wanted_m)
{
    const crn_wire_get get = {CRN_WIRE_GET_STATUS};
    const double from_m = rig->wanted_m;
    rig->wanted_m_s = (wanted_m - from_m) * 1000;
    for (int i = 1; i <= SUBSTEPS; i++) {
        rig->wanted_m = from_m + (wanted_m - from_m) * i / SUBSTEPS;
        move(rig, 1e-3 / SUBSTEPS);
    }
    rig->wanted_m = wanted_m;
    if (rig->stage_hold_ms > 0) rig->stage_hold_ms--;
    rig->time_us += 1000;
    rig->inputs.hands[0].translation_counts = (int32_t)floor(rig->carriage_m * 1e6 + noise(rig));
    rig->inputs.tracks[0].force_raw = (int32_t)lround(rig->hand_N * 1e3 + 10 * noise(rig));
    if (rig->time_us % 8000 == 0 && rig->app.link.is_greeted) SAY(rig, get, &get);
    crn_app_timer(&rig->app);
}
