/* Any conversation with the app. The input is a list of operations, so that the fuzzer reaches behind the CRC:
 *
 *   op u8:  0 .. 0x7f  a message of that type, properly framed: length u8, payload
 *           0x80       raw bytes into the pipe: length u8, bytes
 *           0x81       let time pass: milliseconds u8 (at most 63)
 *           0x82       a valid session up to RUNNING, in free space: tools u8 (modulo 3, plus 1)
 *           0x83       a valid step: count u8 (at most 15), translation per tick i8 x 64 um for each tool
 *           0x84       the device's own snapshot back to it with one byte changed: mask u8, place u16
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
        client_start_tools(c, (uint16_t)(1 + argument % SELD_WIRE_TOOL_MAX));
    } else if (op == 0x83) {
        step(c, in, argument);
    } else if (op == 0x84) {
        restore_damaged(c, in, argument);
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

/* hello, then `tools` with two knots each, framed as operations: what a mutation of set-up begins with. */
static size_t tools_seed(uint16_t count, uint8_t *bytes)
{
    static seld_wire_tools tools;
    uint8_t payload[256];
    client_plain_tools(&tools, count);
    seld_wire_writer writer = seld_wire_writer_make(payload, sizeof payload);
    if (!seld_wire_put_tools(&writer, &tools)) return 0;
    const uint8_t begin[] = {0x82,
                             0,
                             0x16,
                             1,
                             SELD_WIRE_ACTION_STOP,
                             0x16,
                             1,
                             SELD_WIRE_ACTION_RESET,
                             SELD_WIRE_TYPE_tools,
                             (uint8_t)writer.length};
    memcpy(bytes, begin, sizeof begin);
    memcpy(bytes + sizeof begin, payload, writer.length);
    return sizeof begin + writer.length;
}

size_t fuzz_seed(unsigned index, uint8_t *bytes, size_t capacity)
{
    static const uint8_t seeds[][24] = {
        {0x82, 0, 0x83, 15, 140, 128, 128, 0x83, 15, 100, 128, 128},
        {0x82, 0, 0x16, 1, 3, 0x16, 1, 6, 0x16, 1, 2},
        {0x82, 0, 0x30, 1, 5, 0x30, 1, 2, 0x81, 63},
        {0x82, 0, 0x16, 1, 4, 0x10, 8, 64, 0, 0, 0, 1},
        {0x82, 2, 0x83, 15, 140, 120, 130, 0x83, 15, 100, 150, 128, 0x30, 1, 7, 0x30, 1, 5},
        {0x82, 1, 0x83, 15, 135, 120, 128, 0x84, 1, 130, 0, 0x83, 15, 128, 128, 128},
        {0x82, 2, 0x83, 15, 120, 140, 125, 0x84, 0x80, 16, 1, 0x83, 15, 128, 128, 128},
        {0x82, 2, 0x16, 1, 3, 0x16, 1, 6, 0x16, 1, 2, 0x81, 40},
    };
    const unsigned listed = sizeof seeds / sizeof seeds[0];
    if (capacity < 512 || index >= listed + 2) return 0;
    if (index >= listed) return tools_seed((uint16_t)(index - listed + 1), bytes);
    for (size_t i = 0; i < sizeof seeds[0]; i++) bytes[i] = seeds[index][i];
    return sizeof seeds[0];
}
