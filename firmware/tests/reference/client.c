#include "firmware/tests/reference/client.h"

#include <string.h>

void client_open(client *c, uint32_t scene_slot_bytes)
{
    memset(c, 0, sizeof *c);
    c->sim = seld_sim_create(scene_slot_bytes);
    seld_wire_decoder_init(&c->decoder);
}

void client_close(client *c)
{
    seld_sim_destroy(c->sim);
    c->sim = NULL;
}

void client_send(client *c, uint16_t type, const uint8_t *payload, size_t length)
{
    c->sequence = c->sequence == UINT16_MAX ? 1 : (uint16_t)(c->sequence + 1);
    const seld_wire_header header = {c->sequence, 0, type};
    size_t bytes = seld_wire_frame_encode(&header, payload, length, c->frame, sizeof c->frame);
    seld_sim_write(c->sim, c->frame, bytes);
}

uint16_t client_receive(client *c)
{
    uint8_t byte;
    while (seld_sim_read(c->sim, &byte, 1) == 1) {
        if (seld_wire_decoder_push(&c->decoder, byte) == SELD_WIRE_FRAME) return c->decoder.header.type;
    }
    return 0;
}

#define SEND(c, name, value)                                                                                 \
    do {                                                                                                     \
        seld_wire_writer writer = seld_wire_writer_make((c)->payload, sizeof(c)->payload);                   \
        seld_wire_put_##name(&writer, value);                                                                \
        client_send(c, SELD_WIRE_TYPE_##name, writer.bytes, writer.length);                                  \
    } while (0)

void client_hello(client *c, uint64_t schema_hash)
{
    const seld_wire_hello hello = {SELD_WIRE_PROTOCOL_MAJOR, SELD_WIRE_PROTOCOL_MINOR, schema_hash};
    SEND(c, hello, &hello);
}

void client_command(client *c, uint8_t action)
{
    const seld_wire_command command = {action};
    SEND(c, command, &command);
}

void client_get(client *c, uint8_t what)
{
    const seld_wire_get get = {what};
    SEND(c, get, &get);
}

void client_instrument(client *c, const seld_wire_instrument *instrument)
{
    SEND(c, instrument, instrument);
}

void client_entry(client *c, uint32_t inserted_um)
{
    const seld_wire_entry entry = {0, 0, 0, 0, 1 << 30, 0, inserted_um};
    SEND(c, entry, &entry);
}

void client_step(client *c, uint32_t tick, uint16_t count, int32_t translation_begin,
                 int32_t translation_per_tick)
{
    seld_wire_step step = {.tick = tick, .want_nodes = 0, .inputs_count = count};
    for (uint16_t i = 0; i < count; i++) { /* the counter wraps like the hardware's */
        uint32_t counts = (uint32_t)translation_begin + (uint32_t)translation_per_tick * i;
        step.inputs[i] = (seld_wire_encoders){seld_wire_i32_from_u32(counts), 0, 0};
    }
    SEND(c, step, &step);
}

bool client_expect_status(client *c, seld_wire_status *status)
{
    return client_receive(c) == SELD_WIRE_TYPE_status &&
           seld_wire_decode_status(c->decoder.payload, c->decoder.payload_bytes, status);
}

bool client_expect_reject(client *c, seld_wire_reject *reject)
{
    return client_receive(c) == SELD_WIRE_TYPE_reject &&
           seld_wire_decode_reject(c->decoder.payload, c->decoder.payload_bytes, reject);
}

bool client_expect_ticks(client *c, seld_wire_ticks *ticks)
{
    uint16_t type = client_receive(c);
    while (type == SELD_WIRE_TYPE_hash64) type = client_receive(c);
    return type == SELD_WIRE_TYPE_ticks &&
           seld_wire_decode_ticks(c->decoder.payload, c->decoder.payload_bytes, ticks);
}

void client_plain_instrument(seld_wire_instrument *instrument)
{
    const seld_wire_knot tip = {0, 1000000, 800000, 4000, 445, 100, 120, 0, 0};
    memset(instrument, 0, sizeof *instrument);
    instrument->axial_stiffness_max_N = 5000;
    instrument->element_tip_um = 2000;
    instrument->element_shaft_um = 4000;
    instrument->element_fine_um = 20000;
    instrument->knots_count = 2;
    instrument->knots[0] = tip;
    instrument->knots[1] = tip;
    instrument->knots[1].arc_um = 300000;
}

bool client_start_session(client *c)
{
    seld_wire_instrument instrument;
    seld_wire_status status;
    client_plain_instrument(&instrument);
    client_hello(c, seld_wire_schema_hash());
    if (client_receive(c) != SELD_WIRE_TYPE_hello_reply) return false;
    client_instrument(c, &instrument);
    if (!client_expect_status(c, &status)) return false;
    client_entry(c, 50000);
    if (!client_expect_status(c, &status)) return false;
    client_command(c, SELD_WIRE_ACTION_ARM);
    if (!client_expect_status(c, &status)) return false;
    client_command(c, SELD_WIRE_ACTION_START);
    return client_expect_status(c, &status) && status.state == SELD_WIRE_STATE_RUNNING;
}
