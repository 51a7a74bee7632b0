/* This fuzz target exposes the whole app to messages of arbitrary hosts and to readings of arbitrary rigs,
 * through a test port. The input is a list of operations, so that the fuzzer gets past the CRC:
 *
 *   op u8:  0 .. 0x7f  a message of that type, properly framed: length u8, payload
 *           0x80       raw bytes into the pipe: length u8, bytes
 *           0x81       milliseconds pass: u8 modulo 24, each sampling the rig
 *           0x82       another device: u8 modulo the number of devices below, in the state after a valid set-up
 *           0x83       a step: ticks u8 modulo 6, then per tool translation i8 x 64 um a tick
 *           0x84       a good snapshot with bytes changed: count u8 modulo 4, then mask u8, place u16 each
 *           0x85       sensor values of the rig: attached u8, then per track translation, rotation, force i8,
 *                      sensors u8, and lines u8
 *           0x86       FREE_RUN with powered motors, by both steps: 0 u8
 *           0x87       a pipe with this much room: hundreds of bytes u8
 *           0x88       a long message: type u8, length u16, payload
 *           0x89       an order without a frame, as HID sends it: action u8
 *           0x8a       every millisecond's work takes this long: u8 x 50 us
 *           0x8b       a step of one tick with an exchange: position u8 modulo 4, tool u8 modulo 10, translations
 *                      as for a step
 *           0x8c       the device that has a table of tools beside its line: 0 u8
 *
 * A fuzz input has at most 48 operations, so that a run with one input is short. The program builds devices
 * once and copies them, because building a set of tools for every input took a hundred times as long as the
 * fuzzed operations. After every write of the outputs, the guarantees of docs/faults.md must hold. The motors
 * have power only in FREE_RUN and RUNNING, and no force exceeds its limit and slew limit. Without motor
 * power, the drive line (the square wave that keeps the power stage on) does not change. */
#include "firmware/app/app.h"
#include "firmware/tests/reference/client.h"

#include <stdlib.h>
#include <string.h>

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t count);
size_t fuzz_seed(unsigned index, uint8_t *bytes, size_t capacity);

enum { OPERATIONS_MAX = 48, SLOT_BYTES = 4096, ROOM_BYTES = 1 << 18, DEVICES = 8, SENT_MAX = 100000 };

static crn_app app, devices[DEVICES]; /* the last one has a table of tools beside its line */
static crn_instrument tools_now[CRN_TABLE_MAX], tools_of[DEVICES][CRN_TABLE_MAX];
/* of coupled devices with one, two and three tools */
static uint8_t snapshots[CRN_TOOL_MAX][CRN_APP_SNAPSHOT_BYTES];
static uint8_t slots[2][SLOT_BYTES], near_memory[1 << 18] __attribute__((aligned(32)));
static struct rig {
    crn_port_inputs inputs;
    bool is_attached, last_drive;
    crn_port_motor last[CRN_PORT_TOOL_MAX];
    uint32_t now_us, work_us;
    size_t room, sent;
} rig;

static void promise(bool kept)
{
    if (!kept) abort();
}

/* --- the port --- */

static size_t transmit_room(void *context)
{
    (void)context;
    return rig.room;
}

static client *listener; /* set while devices are built */
static uint8_t heard[1 << 17];
static size_t heard_begin, heard_end;

static bool transmit(void *context, const uint8_t *frame, size_t frame_bytes)
{
    (void)context;
    promise(frame_bytes > 1 && frame[frame_bytes - 1] == 0 && memchr(frame, 0, frame_bytes - 1) == NULL);
    if (frame_bytes > rig.room) return false;
    rig.sent += frame_bytes;
    if (listener == NULL) return true;
    if (heard_begin == heard_end) heard_begin = heard_end = 0;
    promise(frame_bytes <= sizeof heard - heard_end);
    memcpy(heard + heard_end, frame, frame_bytes);
    heard_end += frame_bytes;
    return true;
}

static bool inputs(void *context, crn_port_inputs *sample)
{
    (void)context;
    rig.now_us += rig.work_us;
    if (rig.is_attached) *sample = rig.inputs;
    return rig.is_attached;
}

static int32_t size_of(int32_t value)
{
    return value < 0 ? -value : value;
}

/* Checks that a force stays within its limit, and that one write of the outputs raises it by no more than the
 * slew limit. A force may start from zero and fall to zero in one write, and may change its sign if it stays
 * below the slew limit. */
static void check_motor(int32_t value, int32_t last, int32_t limit, int32_t slew)
{
    promise(size_of(value) <= limit);
    promise(size_of(value) <= slew || (size_of(value) <= size_of(last) + slew && (value > 0) == (last > 0)));
}

static void outputs(void *context, const crn_port_outputs *out)
{
    (void)context;
    promise(!out->enable || (app.state == CRN_WIRE_STATE_RUNNING && app.mode == CRN_WIRE_MODE_FREE_RUN &&
                             rig.is_attached && app.link.is_greeted));
    promise(out->enable || out->drive == rig.last_drive);
    promise(out->lamp <= CRN_PORT_LAMP_FAULT);
    for (int k = 0; k < CRN_PORT_TOOL_MAX; k++) {
        const crn_port_motor *motor = &out->motors[k];
        promise(out->enable || (motor->axial_mN == 0 && motor->torque_uN_m == 0));
        check_motor(motor->axial_mN, rig.last[k].axial_mN, CRN_APP_FORCE_LIMIT_mN,
                    CRN_APP_FORCE_SLEW_mN_per_tick);
        check_motor(motor->torque_uN_m, rig.last[k].torque_uN_m, CRN_APP_TORQUE_LIMIT_uN_m,
                    CRN_APP_TORQUE_SLEW_uN_m_per_tick);
        promise(size_of(motor->axial_mN) <= app.haptics.tracks[k].force_limit_mN &&
                size_of(motor->torque_uN_m) <= app.haptics.tracks[k].torque_limit_uN_m);
        rig.last[k] = *motor;
    }
    rig.last_drive = out->drive;
}

static uint32_t now_us(void *context)
{
    (void)context;
    return rig.now_us;
}

static const crn_port port = {
    .tool_table = tools_now,
    .transmit = transmit,
    .transmit_room = transmit_room,
    .inputs = inputs,
    .outputs = outputs,
    .now_us = now_us,
    .serial = "fuzz",
    .scene_slots = {slots[0], slots[1]},
    .scene_slot_bytes = SLOT_BYTES,
    .near_memory = near_memory,
    .near_bytes = sizeof near_memory,
};

static void millisecond(void)
{
    rig.now_us += CRN_TICK_us;
    crn_app_timer(&app);
}

/* --- messages --- */

static void send(uint16_t type, const uint8_t *payload, size_t length)
{
    static uint8_t frame[CRN_WIRE_FRAME_MAX];
    const crn_wire_header header = {(uint16_t)(app.link.sequence_in + 1), 0, type};
    crn_app_receive(&app, frame, crn_wire_frame_encode(&header, payload, length, frame, sizeof frame));
}

static void command(uint8_t action, uint32_t code)
{
    uint8_t payload[CRN_WIRE_BYTES_command];
    const crn_wire_command message = {action, code, 0};
    crn_wire_writer writer = crn_wire_writer_make(payload, sizeof payload);
    crn_wire_put_command(&writer, &message);
    send(CRN_WIRE_TYPE_command, payload, writer.length);
}

static void power(void)
{
    command(CRN_WIRE_ACTION_STOP, 0);
    command(CRN_WIRE_ACTION_FREE_RUN, 0);
    rig.is_attached = true;
    rig.inputs = (crn_port_inputs){.supply_good = true, .stage_on = true};
    millisecond();
    command(CRN_WIRE_ACTION_ARM_MOTORS, 0);
    command(CRN_WIRE_ACTION_CONFIRM, app.permission.code);
    command(CRN_WIRE_ACTION_START, 0);
}

/* --- devices: fresh; one, two and three tools; with couplings; powered; waiting for a scene --- */

static void write_pipe(void *context, const uint8_t *bytes, size_t count)
{
    (void)context;
    crn_app_receive(&app, bytes, count);
}

static size_t read_pipe(void *context, uint8_t *bytes, size_t capacity)
{
    (void)context;
    size_t count = heard_end - heard_begin < capacity ? heard_end - heard_begin : capacity;
    memcpy(bytes, heard + heard_begin, count);
    heard_begin += count;
    return count;
}

/* Uses short tools of few elements, because one tick with them takes a tenth of the time of a tick with real
 * tools. */
static void short_tools(crn_wire_tools *tools, uint16_t count)
{
    client_plain_tools(tools, count);
    for (uint16_t k = 0; k < count; k++) {
        crn_wire_instrument *tool = &tools->tools[k];
        tool->element_tip_um = tool->element_shaft_um = 8000;
        tool->element_fine_um = 0;
        tool->knots[1].arc_um = 60000;
    }
}

/* Makes a table of eight tools; a wire lies in a guide, and the middle position between them has no tool. */
static void table_of_tools(crn_wire_tools *tools)
{
    short_tools(tools, 3);
    for (uint16_t k = 3; k < CRN_WIRE_TABLE_MAX; k++) tools->tools[k] = tools->tools[k % 3];
    tools->tools_count = CRN_WIRE_TABLE_MAX;
    tools->line_count = 3;
    tools->line[0] = 1;
    tools->line[2] = 3;
}

enum { A_TABLE = 99 }; /* instead of a number of tools */

static void build_device(client *c, uint16_t tools_count, bool is_coupled)
{
    static crn_wire_tools tools;
    crn_wire_status status;
    client_hello(c, crn_wire_schema_hash());
    promise(client_receive(c) == CRN_WIRE_TYPE_hello_reply);
    if (is_coupled) {
        crn_wire_track track = client_plain_track();
        track.seal_mN = 2000; /* the seal holds the tool, so that a push is felt at once */
        const crn_wire_track tracks[] = {track, track, track};
        client_rig(c, tracks, CRN_WIRE_TOOL_MAX);
        promise(client_expect_status(c, &status));
    }
    if (tools_count == A_TABLE)
        table_of_tools(&tools);
    else
        short_tools(&tools, tools_count);
    client_tools(c, &tools);
    promise(client_expect_status(c, &status));
    client_entry(c, 20000);
    promise(client_expect_status(c, &status));
    client_command(c, CRN_WIRE_ACTION_ARM);
    promise(client_expect_status(c, &status));
    client_command(c, CRN_WIRE_ACTION_START);
    promise(client_expect_status(c, &status) && status.state == CRN_WIRE_STATE_RUNNING);
}

static void forget(void)
{
    heard_begin = heard_end = 0;
    rig = (struct rig){.room = ROOM_BYTES};
}

static void take_snapshot(uint8_t *snapshot)
{
    const uint8_t what = CRN_WIRE_GET_SNAPSHOT;
    heard_begin = heard_end = 0;
    send(CRN_WIRE_TYPE_get, &what, 1);
    memcpy(snapshot, app.core.scratch.spare, CRN_APP_SNAPSHOT_BYTES);
}

static void build_devices(void)
{
    static client c;
    const client_pipe pipe = {NULL, write_pipe, read_pipe};
    listener = &c;
    for (int i = 0; i < DEVICES; i++) {
        const bool has_table = i == DEVICES - 1;
        client_open_pipe(&c, &pipe);
        forget();
        crn_app_init(&app, &port);
        const uint16_t plan = has_table ? A_TABLE : (uint16_t)(1 + (i - 1) % CRN_WIRE_TOOL_MAX);
        if (i > 0) build_device(&c, plan, i > 3);
        if (i == 4) power(); /* one coupled tool, with power, and a hand that pushes */
        for (int ms = 0; i == 4 && ms < 20; ms++) {
            rig.inputs.hands[0].translation_counts += 200;
            rig.inputs.tracks[0].force_raw = app.haptics.motors[0].axial_mN;
            millisecond();
        }
        if (i == 6) command(CRN_WIRE_ACTION_STOP, 0);
        devices[i] = app;
        memcpy(tools_of[i], tools_now, sizeof tools_now);
        if (i > 3 && !has_table) take_snapshot(snapshots[i - 4]);
    }
    promise(devices[4].safety.is_driving && devices[4].haptics.motors[0].axial_mN > 500);
    listener = NULL;
}

static void take_device(uint8_t number)
{
    forget();
    app = devices[number];
    memcpy(tools_now, tools_of[number], sizeof tools_now);
    rig.last_drive = app.safety.drive_level;
    for (int k = 0; k < CRN_PORT_TOOL_MAX && app.safety.is_driving; k++)
        rig.last[k] = (crn_port_motor){app.haptics.motors[k].axial_mN, app.haptics.motors[k].torque_uN_m};
    rig.is_attached = app.edge.has_rig;
    rig.inputs = app.edge.rig;
    rig.now_us = app.clock.edge_us;
}

/* --- operations --- */

typedef struct input {
    const uint8_t *bytes;
    size_t left;
} input;

static uint8_t take(input *in)
{
    if (in->left == 0) return 0;
    in->left--;
    return *in->bytes++;
}

static uint16_t take16(input *in)
{
    const uint8_t low = take(in);
    return (uint16_t)(low | take(in) << 8);
}

static int32_t take_signed(input *in, int32_t scale)
{
    return ((int32_t)take(in) - 128) * scale;
}

static const uint8_t *take_block(input *in, size_t *length)
{
    const uint8_t *block = in->bytes;
    if (*length > in->left) *length = in->left;
    in->bytes += *length;
    in->left -= *length;
    return block;
}

static void step(input *in, uint8_t count, const crn_wire_exchange *exchange)
{
    static crn_wire_step message;
    static uint8_t payload[CRN_WIRE_BYTES_step];
    int32_t per_tick[CRN_WIRE_TOOL_MAX];
    for (uint32_t k = 0; k < app.setup.tool_count; k++) per_tick[k] = take_signed(in, 64);
    message =
        (crn_wire_step){.tick = app.core.words.tick, .want_nodes = count & 0x80, .inputs_count = count % 6};
    for (uint16_t i = 0; i < message.inputs_count; i++) {
        message.inputs[i].hands_count = (uint16_t)app.setup.tool_count;
        for (uint32_t k = 0; k < app.setup.tool_count; k++)
            message.inputs[i].hands[k].translation_counts = (i + 1) * per_tick[k];
    }
    if (exchange != NULL) {
        message.inputs[0].orders.items_count = 1;
        message.inputs[0].orders.items[0] = crn_wire_order_of_exchange(*exchange);
    }
    crn_wire_writer writer = crn_wire_writer_make(payload, sizeof payload);
    promise(crn_wire_put_step(&writer, &message));
    send(CRN_WIRE_TYPE_step, payload, writer.length);
}

/* Restores a damaged snapshot as if all its chunks had arrived with the right CRC. Only the checks of the
 * snapshot's header and of the core can then refuse it. */
static void restore_damaged(input *in, uint8_t count)
{
    command(CRN_WIRE_ACTION_STOP, 0);
    if (app.state != CRN_WIRE_STATE_ARMED || app.setup.tool_count == 0) return;
    memcpy(app.core.scratch.spare, snapshots[app.setup.tool_count - 1], CRN_APP_SNAPSHOT_BYTES);
    for (uint8_t i = 0; i < count % 4; i++) {
        const uint8_t mask = take(in);
        app.core.scratch.spare[take16(in) % CRN_APP_SNAPSHOT_BYTES] ^= mask;
    }
    const uint32_t bytes = CRN_APP_SNAPSHOT_BYTES;
    app.session.snapshot_upload =
        (crn_upload){bytes, bytes, crn_wire_crc32(0, app.core.scratch.spare, bytes), true};
    const uint8_t end[] = {bytes & 0xff, bytes >> 8 & 0xff, bytes >> 16 & 0xff, 0};
    send(CRN_WIRE_TYPE_snapshot_end, end, sizeof end);
    command(CRN_WIRE_ACTION_START, 0);
}

static void set_rig(input *in, uint8_t attached)
{
    rig.is_attached = attached != 0;
    if (attached == 0) return;
    for (int k = 0; k < CRN_PORT_TOOL_MAX; k++) {
        crn_port_hand *hand = &rig.inputs.hands[k];
        crn_port_track *track = &rig.inputs.tracks[k];
        hand->translation_counts =
            (int32_t)((uint32_t)hand->translation_counts + (uint32_t)take_signed(in, 64));
        hand->rotation_counts = (int32_t)((uint32_t)hand->rotation_counts + (uint32_t)take_signed(in, 16));
        track->force_raw = take_signed(in, 32);
        const uint8_t sensors = take(in);
        track->translation_sensor = sensors & 3;
        track->rotation_sensor = sensors >> 2 & 3;
        track->force_sensor = sensors >> 4 & 3;
        track->over_current = sensors >> 6 & 1;
    }
    const uint8_t lines = take(in);
    rig.inputs.emergency_stop = lines & 1;
    rig.inputs.supply_good = !(lines & 2);
    rig.inputs.stage_on = !(lines & 4);
    rig.inputs.local_unlock = lines & 8;
}

static void operate(input *in)
{
    const uint8_t op = take(in), argument = take(in);
    size_t length = argument;
    if (op < 0x80) {
        const uint8_t *payload = take_block(in, &length);
        send(op, payload, length);
    } else if (op == 0x80) {
        const uint8_t *raw = take_block(in, &length);
        crn_app_receive(&app, raw, length);
    } else if (op == 0x81) {
        for (int ms = 0; ms < argument % 24; ms++) millisecond();
    } else if (op == 0x82) {
        take_device(argument % (DEVICES - 1));
    } else if (op == 0x83) {
        step(in, argument, NULL);
    } else if (op == 0x84) {
        restore_damaged(in, argument);
    } else if (op == 0x85) {
        set_rig(in, argument);
    } else if (op == 0x86) {
        power();
    } else if (op == 0x87) {
        rig.room = (size_t)argument * 100;
    } else if (op == 0x88) {
        length = take16(in);
        const uint8_t *payload = take_block(in, &length);
        send(argument, payload, length < CRN_WIRE_PAYLOAD_MAX ? length : CRN_WIRE_PAYLOAD_MAX);
    } else if (op == 0x89) {
        crn_app_order(&app, argument);
    } else if (op == 0x8a) {
        rig.work_us = argument * 50u;
    } else if (op == 0x8b) {
        const crn_wire_exchange order = {argument % 4, take(in) % 10};
        step(in, 1, &order);
    } else if (op == 0x8c) {
        take_device(DEVICES - 1);
    }
}

static void check_books(void)
{
    promise(app.state <= CRN_WIRE_STATE_FAULT && app.mode <= CRN_WIRE_MODE_FREE_RUN);
    promise(app.setup.table_count <= CRN_TABLE_MAX && app.session.exchange <= CRN_WIRE_EXCHANGE_BURST);
    promise(app.setup.tool_count <= CRN_TOOL_MAX && app.faults.count <= CRN_APP_FAULT_MAX);
    promise(app.queue.count <= CRN_APP_LIVE_QUEUE_ticks && app.queue.event_count <= CRN_APP_EVENT_QUEUE);
    promise(app.setup.scene_upload.received_bytes <= app.setup.scene_upload.expected_bytes);
    promise(app.session.snapshot_upload.received_bytes <= app.session.snapshot_upload.expected_bytes);
    promise(!app.safety.is_driving || app.state == CRN_WIRE_STATE_RUNNING);
    for (uint16_t i = 0; i < app.faults.count; i++)
        promise(app.faults.entries[i].code != CRN_FAULT_CODE_INTERNAL);
}

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t count)
{
    if (devices[0].port == NULL) build_devices();
    input in = {bytes, count};
    take_device(0);
    for (int i = 0; i < OPERATIONS_MAX && in.left > 0 && rig.sent < SENT_MAX; i++) {
        operate(&in);
        check_books();
    }
    return 0;
}

/* --- seeds --- */

enum {
    STOP = CRN_WIRE_ACTION_STOP,
    START = CRN_WIRE_ACTION_START,
    RESET = CRN_WIRE_ACTION_RESET,
    FREE = CRN_WIRE_ACTION_FREE_RUN
};

/* Makes one operation of a fuzz input: a `command` message with the given action, code 0 and tick 0. */
#define COMMAND(action) 0x16, CRN_WIRE_BYTES_command, action, 0, 0, 0, 0, 0, 0, 0, 0

/* Makes a fuzz input that brings the device into the state READY and then sends one long set-up message, so
 * that the fuzzer's mutations start from a valid set-up message. */
static size_t message_seed(uint8_t type, const crn_wire_writer *writer, uint8_t *bytes)
{
    const uint8_t begin[] = {0x82, 1,    COMMAND(STOP),           COMMAND(RESET),
                             0x88, type, (uint8_t)writer->length, (uint8_t)(writer->length >> 8)};
    memcpy(bytes, begin, sizeof begin);
    memcpy(bytes + sizeof begin, writer->bytes, writer->length);
    return sizeof begin + writer->length;
}

/* Makes a typical commercial wire: a shaped tip, a taper and a shaft, with 2 + `knots` knots. */
static void shaped_wire(crn_wire_tools *tools, uint16_t knots)
{
    short_tools(tools, 1);
    crn_wire_instrument *wire = &tools->tools[0];
    const crn_wire_knot shaft = wire->knots[0];
    wire->knots_count = (uint16_t)(2 + knots);
    for (uint16_t i = 0; i < wire->knots_count; i++) {
        crn_wire_knot *knot = &wire->knots[i];
        *knot = shaft;
        knot->arc_um = 80000u * i / (knots + 1u);
        knot->bend_stiffness_nN_m2 = 20000u + 90000u * i;
        knot->twist_stiffness_nN_m2 = knot->bend_stiffness_nN_m2;
        if (i < 3) knot->rest_curvature1_per_m_milli = 60000;
    }
    wire->element_tip_um = 2000;
    wire->element_fine_um = 10000;
}

/* Makes a fuzz input with a `tools` message: up to CRN_WIRE_TOOL_MAX plain tools of two knots, or a shaped
 * wire. */
static size_t tools_seed(uint16_t which, uint8_t *bytes)
{
    static crn_wire_tools tools;
    static uint8_t payload[CRN_WIRE_BYTES_tools];
    if (which <= CRN_WIRE_TOOL_MAX)
        short_tools(&tools, which);
    else
        shaped_wire(&tools, which);
    crn_wire_writer writer = crn_wire_writer_make(payload, sizeof payload);
    return crn_wire_put_tools(&writer, &tools) ? message_seed(CRN_WIRE_TYPE_tools, &writer, bytes) : 0;
}

static size_t rig_seed(uint16_t count, uint8_t *bytes)
{
    uint8_t payload[CRN_WIRE_BYTES_rig];
    crn_wire_rig message = {.tracks_count = count};
    for (uint16_t k = 0; k < count; k++) message.tracks[k] = client_plain_track();
    crn_wire_writer writer = crn_wire_writer_make(payload, sizeof payload);
    return crn_wire_put_rig(&writer, &message) ? message_seed(CRN_WIRE_TYPE_rig, &writer, bytes) : 0;
}

static size_t seed_of(const uint8_t *seed, size_t count, uint8_t *bytes)
{
    memcpy(bytes, seed, count);
    return count;
}

#define SEED(...)                                                                                            \
    do {                                                                                                     \
        static const uint8_t seed[] = {__VA_ARGS__};                                                         \
        return seed_of(seed, sizeof seed, bytes);                                                            \
    } while (0)

size_t fuzz_seed(unsigned index, uint8_t *bytes, size_t capacity)
{
    if (capacity < 4096) return 0;
    switch (index) {
    case 0:
        SEED(0x82, 1, 0x83, 5, 140, 0x83, 5, 100);
    case 1:
        SEED(0x82, 1, COMMAND(STOP), COMMAND(FREE), COMMAND(START), 0x81, 23);
    case 2:
        SEED(0x82, 1, 0x30, 1, 5, 0x30, 1, 2, 0x81, 23);
    case 3: /* an upload that is interrupted and resumed */
        SEED(0x82, 1, COMMAND(RESET), 0x10, 8, 64, 0, 0, 0, 1, 2, 3, 4, 0x11, 10, 0, 0, 0, 0, 4, 0, 9, 9, 9,
             9, 0x30, 1, 9, 0x10, 8, 64, 0, 0, 0, 1, 2, 3, 4, 0x12, 4, 64, 0, 0, 0);
    case 4:
        SEED(0x82, 3, 0x83, 5, 140, 120, 130, 0x83, 0x85, 100, 150, 128, 0x30, 1, 7, 0x30, 1, 3);
    case 5: /* snapshots, damaged in hands, motors, couplings, energies and in the core */
        SEED(0x82, 2, 0x83, 5, 135, 120, 0x84, 1, 1, 130, 0, 0x83, 5, 128, 128);
    case 6:
        SEED(0x82, 5, 0x83, 5, 120, 140, 0x84, 3, 4, 50, 0, 0x40, 100, 0, 0x80, 110, 1, 0x83, 5, 128, 128);
    case 7:
        SEED(0x82, 3, 0x84, 0, 0, 0x84, 2, 0x80, 80, 1, 1, 0, 9, 0x83, 5, 1, 1, 1);
    case 8: /* with power: a hand that moves, then a sensor that fails */
        SEED(0x82, 4, 0x85, 1, 140, 130, 140, 0, 128, 128, 128, 0, 128, 128, 128, 0, 0, 0x81, 8, 0x85, 1, 140,
             130, 160, 16, 128, 128, 128, 0, 128, 128, 128, 0, 0, 0x81, 5, COMMAND(RESET));
    case 9: /* a stream with events and pictures through a narrow pipe */
        SEED(0x82, 4, 0x26, 3, 1, 2, 0, 0x87, 60, 0x81, 23, 0x81, 23, 0x87, 255, 0x81, 23, 0x30, 1, 8, 0x30,
             1, 10, 0x30, 1, 6);
    case 10: /* the two steps, with a wrong code and a STOP at a later tick */
        SEED(0x82, 6, 0x86, 0, 0x16, 9, 3, 0, 0, 0, 0, 30, 0, 0, 0, 0x81, 12, 0x16, 9, 7, 0, 0, 0, 0, 0, 0, 0,
             0, 0x16, 9, 8, 1, 2, 3, 4, 0, 0, 0, 0, COMMAND(START));
    case 11: /* a host that falls silent and returns; orders by HID */
        SEED(0x82, 4, 0x81, 23, 0x81, 23, 0x30, 1, 1, 0x81, 9, 0x89, 3, 0x89, 4, 0x86, 0);
    case 12: /* work that takes too long, and a processor that was halted */
        SEED(0x82, 4, 0x8a, 21, 0x81, 3, 0x8a, 120, 0x81, 2, COMMAND(RESET));
    case 13: /* orders in FREE_RUN: strut rings, two joined, the first with a heart rate, an invalid one,
                one removed; then back into LOCKSTEP with a snapshot */
        SEED(0x82, 4, 0x27, 24, 2, 3, 1, 1, 0, 0, 0, 0, 32, 78, 0, 0, 0, 0, 0, 0, 220, 5, 80, 0, 1, 1, 90, 0,
             0x27, 20, 1, 3, 2, 0, 0, 0, 0, 0, 240, 85, 0, 0, 0, 0, 0, 0, 220, 5, 80, 0, 0x81, 4, 0x27, 20, 1,
             3, 65, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1, 0, 80, 0, 0x27, 20, 1, 3, 1, 0, 0, 0, 0, 0, 0,
             0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0x81, 4, 0x30, 1, 5);
    case 14: /* exchanges: a catheter comes, goes in, is refused to leave, comes out and leaves; wrong ones */
        SEED(0x8c, 0, 0x8b, 1, 2, 128, 128, 128, 0x83, 5, 128, 140, 128, 0x8b, 1, 0, 128, 128, 128, 0x83, 5,
             128, 100, 128, 0x83, 5, 128, 100, 128, 0x8b, 1, 5, 128, 128, 128, 0x8b, 1, 0, 128, 128, 128,
             0x8b, 3, 1, 128, 128, 128, 0x8b, 0, 9, 128, 128, 128, 0x30, 1, 5, 0x83, 0x85, 128, 128, 128);
    case 15: /* exchanges in FREE_RUN with power, and a damaged snapshot */
        SEED(0x8c, 0, 0x86, 0, 0x27, 4, 1, 4, 1, 2, 0x81, 8, 0x27, 4, 1, 4, 1, 0, 0x81, 8, 0x27, 4, 1, 4, 1,
             9, 0x84, 2, 0x80, 80, 1, 1, 0, 9);
    default:
        if (index < 21) return tools_seed((uint16_t)(index - 15), bytes);
        return index < 24 ? rig_seed((uint16_t)(index - 20), bytes) : 0;
    }
}
