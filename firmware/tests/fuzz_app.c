/* Any conversation with the app. The input is a list of operations, so that the fuzzer reaches behind the CRC:
 *
 *   op u8:  0 .. 0x7f  a message of that type, properly framed: length u8, payload
 *           0x80       raw bytes into the pipe: length u8, bytes
 *           0x81       let time pass: milliseconds u8 (at most 63)
 *           0x82       a valid session up to RUNNING, in free space
 *           0x83       a valid step: count u8 (at most 15), translation per tick i8 x 64 um
 *
 * At most 64 operations, so that an input ends in time. */
#include "firmware/tests/reference/client.h"

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
        client_start_session(c);
    } else if (op == 0x83) {
        seld_wire_status status = {0};
        int32_t per_tick = ((int32_t)take(in) - 128) * 64;
        client_get(c, SELD_WIRE_GET_STATUS);
        client_expect_status(c, &status);
        client_step(c, status.tick, argument % 16, 0, per_tick);
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

size_t fuzz_seed(unsigned index, uint8_t *bytes, size_t capacity)
{
    static const uint8_t seeds[][12] = {
        {0x82, 0, 0x83, 15, 140, 0x83, 15, 100},
        {0x82, 0, 0x16, 1, 3, 0x16, 1, 6, 0x16, 1, 2},
        {0x82, 0, 0x30, 1, 5, 0x30, 1, 2, 0x81, 63},
        {0x82, 0, 0x16, 1, 4, 0x10, 8, 64, 0, 0, 0, 1},
    };
    if (index >= sizeof seeds / sizeof seeds[0] || capacity < sizeof seeds[0]) return 0;
    for (size_t i = 0; i < sizeof seeds[0]; i++) bytes[i] = seeds[index][i];
    return sizeof seeds[0];
}
