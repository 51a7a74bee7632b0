/* Any conversation with the app. The input is a list of operations, so that the fuzzer reaches behind the CRC:
 *
 *   op u8:  0 .. 0x7f  a message of that type, properly framed: length u8, payload
 *           0x80       raw bytes into the pipe: length u8, bytes
 *           0x81       let time pass: milliseconds u8 (at most 63)
 *           0x82       a valid session up to RUNNING, in free space: tools u8 (modulo 3, plus 1; 0x80: with couplings)
 *           0x83       a valid step: count u8 (at most 15), translation per tick i8 x 64 um for each tool
 *           0x84       the device's own snapshot back to it with one byte changed: mask u8, place u16
 *           0x85       what the rig's sensors say: attached u8, then per track translation, rotation, force i8, sensors u8, and
 *                      lines u8
 *           0x86       FREE_RUN with powered motors: 0 u8
 *           0x87       a pipe with this much room: hundreds of bytes u8
 *
 * At most 64 operations, so that an input ends in time. */
#include "firmware/tests/reference/client.h"

#include <string.h>

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t count);
size_t fuzz_seed(unsigned index, uint8_t *bytes, size_t capacity);

enum { OPERATIONS_MAX = 64, SLOT_BYTES = 4096 };

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

static const uint8_t *take_block(input *in, size_t *length)
{
    const uint8_t *block = in->bytes;
    if (*length > in->left) *length = in->left;
    in->bytes += *length;
    in->left -= *length;
    return block;
}

static void step(client *c, input *in, uint8_t count)
{
    static const int32_t begin[SELD_WIRE_TOOL_MAX];
    seld_wire_status status = {0};
    int32_t per_tick[SELD_WIRE_TOOL_MAX];
    for (int k = 0; k < SELD_WIRE_TOOL_MAX; k++) per_tick[k] = ((int32_t)take(in) - 128) * 64;
    client_get(c, SELD_WIRE_GET_STATUS);
    client_expect_status(c, &status);
    client_step_each(c, status.tick, count % 16, begin, per_tick);
}

/* Behind the CRC of the upload: the head's and the core's own checks decide. */
static void restore_damaged(client *c, input *in, uint8_t mask)
{
    size_t place = take(in);
    place += (size_t)take(in) << 8;
    client_command(c, SELD_WIRE_ACTION_STOP);
    while (client_receive(c) != 0) {
    }
    if (!client_read_snapshot(c) || c->snapshot_bytes == 0) return;
    c->snapshot[place % c->snapshot_bytes] ^= mask;
    client_write_snapshot(c);
    while (client_receive(c) != 0) {
    }
    client_command(c, SELD_WIRE_ACTION_START);
}

static void set_rig(client *c, input *in, uint8_t attached)
{
    static seld_port_inputs rig;
    if (attached == 0) {
        seld_sim_set_inputs(c->sim, NULL);
        return;
    }
    for (int k = 0; k < SELD_PORT_TOOL_MAX; k++) {
        rig.hands[k].translation_counts += ((int32_t)take(in) - 128) * 64;
        rig.hands[k].rotation_counts += ((int32_t)take(in) - 128) * 16;
        rig.tracks[k].force_raw = ((int32_t)take(in) - 128) * 32;
        const uint8_t sensors = take(in);
        rig.tracks[k].translation_sensor = sensors & 3;
        rig.tracks[k].rotation_sensor = sensors >> 2 & 3;
        rig.tracks[k].force_sensor = sensors >> 4 & 3;
        rig.tracks[k].over_current = sensors >> 6 & 1;
    }
    const uint8_t lines = take(in);
    rig.emergency_stop = lines & 1;
    rig.supply_good = !(lines & 2);
    rig.stage_on = !(lines & 4);
    rig.local_unlock = lines & 8;
    seld_sim_set_inputs(c->sim, &rig);
}

static void drain(client *c)
{
    while (client_receive(c) != 0) {
    }
}

static void power(client *c)
{
    const seld_port_inputs rig = seld_sim_healthy_inputs();
    client_command(c, SELD_WIRE_ACTION_STOP);
    client_command(c, SELD_WIRE_ACTION_FREE_RUN);
    seld_sim_set_inputs(c->sim, &rig);
    seld_sim_timer(c->sim, 1);
    drain(c);
    client_arm_motors(c);
    client_command(c, SELD_WIRE_ACTION_START);
}

static void begin_session(client *c, uint8_t argument)
{
    if (argument & 0x80) {
        const seld_wire_track track = client_plain_track();
        const seld_wire_track tracks[] = {track, track, track};
        client_hello(c, seld_wire_schema_hash());
        client_rig(c, tracks, SELD_WIRE_TOOL_MAX);
        drain(c);
    }
    client_start_tools(c, (uint16_t)(1 + (argument & 0x7f) % SELD_WIRE_TOOL_MAX));
}

static void operate(client *c, input *in)
{
    uint8_t op = take(in);
    uint8_t argument = take(in);
    size_t length = argument;
    if (op < 0x80) {
        const uint8_t *payload = take_block(in, &length);
        client_send(c, op, payload, length);
    } else if (op == 0x80) {
        const uint8_t *raw = take_block(in, &length);
        seld_sim_write(c->sim, raw, length);
    } else if (op == 0x81) {
        seld_sim_timer(c->sim, argument % 64);
    } else if (op == 0x82) {
        begin_session(c, argument);
    } else if (op == 0x83) {
        step(c, in, argument);
    } else if (op == 0x84) {
        restore_damaged(c, in, argument);
    } else if (op == 0x85) {
        set_rig(c, in, argument);
    } else if (op == 0x86) {
        power(c);
    } else if (op == 0x87) {
        seld_sim_set_pipe(c->sim, (size_t)argument * 100);
    }
    while (client_receive(c) != 0) {
    }
}

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t count)
{
    static client c;
    input in = {bytes, count};
    client_open(&c, SLOT_BYTES);
    if (c.sim == NULL) return 0;
    for (int i = 0; i < OPERATIONS_MAX && in.left > 0; i++) operate(&c, &in);
    client_close(&c);
    return 0;
}

enum {
    STOP = SELD_WIRE_ACTION_STOP,
    START = SELD_WIRE_ACTION_START,
    RESET = SELD_WIRE_ACTION_RESET,
    FREE = SELD_WIRE_ACTION_FREE_RUN
};

/* A command as an operation: code and tick are 0. */
#define COMMAND(action) 0x16, SELD_WIRE_BYTES_command, action, 0, 0, 0, 0, 0, 0, 0, 0

/* A session, back to READY, then one message framed as an operation: what a mutation of set-up begins with. */
static size_t message_seed(uint8_t type, const seld_wire_writer *writer, uint8_t *bytes)
{
    const uint8_t begin[] = {0x82, 0, COMMAND(STOP), COMMAND(RESET), type, (uint8_t)writer->length};
    memcpy(bytes, begin, sizeof begin);
    memcpy(bytes + sizeof begin, writer->bytes, writer->length);
    return sizeof begin + writer->length;
}

/* `tools` with two knots each, and `rig` with a coupling on each track. */
static size_t tools_seed(uint16_t count, uint8_t *bytes)
{
    static seld_wire_tools tools;
    uint8_t payload[256];
    client_plain_tools(&tools, count);
    seld_wire_writer writer = seld_wire_writer_make(payload, sizeof payload);
    return seld_wire_put_tools(&writer, &tools) ? message_seed(SELD_WIRE_TYPE_tools, &writer, bytes) : 0;
}

static size_t rig_seed(uint16_t count, uint8_t *bytes)
{
    uint8_t payload[256];
    seld_wire_rig rig = {.tracks_count = count};
    for (uint16_t k = 0; k < count; k++) rig.tracks[k] = client_plain_track();
    seld_wire_writer writer = seld_wire_writer_make(payload, sizeof payload);
    return seld_wire_put_rig(&writer, &rig) ? message_seed(SELD_WIRE_TYPE_rig, &writer, bytes) : 0;
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
    if (capacity < 512) return 0;
    switch (index) {
    case 0:
        SEED(0x82, 0, 0x83, 15, 140, 128, 128, 0x83, 15, 100, 128, 128);
    case 1:
        SEED(0x82, 0, COMMAND(STOP), COMMAND(FREE), COMMAND(START));
    case 2:
        SEED(0x82, 0, 0x30, 1, 5, 0x30, 1, 2, 0x81, 63);
    case 3: /* an upload, cut and taken up again */
        SEED(0x82, 0, COMMAND(RESET), 0x10, 8, 64, 0, 0, 0, 1, 2, 3, 4, 0x11, 10, 0, 0, 0, 0, 4, 0, 9, 9, 9,
             9, 0x30, 1, 9, 0x10, 8, 64, 0, 0, 0, 1, 2, 3, 4, 0x12, 4, 64, 0, 0, 0);
    case 4:
        SEED(0x82, 2, 0x83, 15, 140, 120, 130, 0x83, 15, 100, 150, 128, 0x30, 1, 7, 0x30, 1, 5);
    case 5:
        SEED(0x82, 1, 0x83, 15, 135, 120, 128, 0x84, 1, 130, 0, 0x83, 15, 128, 128, 128);
    case 6:
        SEED(0x82, 2, 0x83, 15, 120, 140, 125, 0x84, 0x80, 16, 1, 0x83, 15, 128, 128, 128);
    case 7:
        SEED(0x82, 2, COMMAND(STOP), COMMAND(FREE), COMMAND(START), 0x81, 40);
    case 8: /* coupled, with its snapshot damaged in the coupling's part */
        SEED(0x82, 0x80, 0x83, 15, 140, 128, 128, 0x84, 4, 50, 0, 0x83, 15, 120, 128, 128, 0x84, 0x40, 100, 0,
             0x83, 15, 1, 1, 1);
    case 9: /* powered, a hand that moves, then a sensor that fails */
        SEED(0x82, 0x80, 0x86, 0, 0x85, 1, 140, 130, 128, 0, 128, 128, 128, 0, 128, 128, 128, 0, 0, 0x81, 20,
             0x85, 1, 140, 130, 160, 16, 128, 128, 128, 0, 128, 128, 128, 0, 0, 0x81, 5, COMMAND(RESET));
    case 10: /* a stream with events and pictures through a narrow pipe */
        SEED(0x82, 0x82, 0x26, 3, 1, 2, 0, 0x86, 0, 0x87, 60, 0x81, 63, 0x81, 63, 0x87, 255, 0x81, 63, 0x30,
             1, 8, 0x30, 1, 10);
    case 11: /* the two steps, with a wrong code and a STOP to come */
        SEED(0x82, 0x80, 0x86, 0, 0x16, 9, 3, 0, 0, 0, 0, 30, 0, 0, 0, 0x81, 50, 0x16, 9, 7, 0, 0, 0, 0, 0, 0,
             0, 0, 0x16, 9, 8, 1, 2, 3, 4, 0, 0, 0, 0, COMMAND(START));
    default:
        if (index < 14) return tools_seed((uint16_t)(index - 11), bytes);
        return index < 17 ? rig_seed((uint16_t)(index - 13), bytes) : 0;
    }
}
