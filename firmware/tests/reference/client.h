/* A minimal host for tests: sends messages to a sim and reads its frames, through bytes only.
 * May include: shared/wire, the sim's public header. Called by: firmware/tests, hil_tests, fuzz targets. */
#ifndef SELD_TEST_CLIENT_H
#define SELD_TEST_CLIENT_H

#include "firmware/port/sim/sim.h"
#include "shared/wire/wire_frame.h"

typedef struct client {
    seld_sim *sim;
    seld_wire_decoder decoder;
    uint16_t sequence;
    uint8_t payload[SELD_WIRE_PAYLOAD_MAX];
    uint8_t frame[SELD_WIRE_FRAME_MAX];
} client;

/* A sim that has been powered up; client_close ends it. */
void client_open(client *c, uint32_t scene_slot_bytes);
void client_close(client *c);

/* Frame `length` payload bytes as a message and hand it to the device. */
void client_send(client *c, uint16_t type, const uint8_t *payload, size_t length);

/* The next frame of the device into c->decoder; its type, or 0 when the device has said everything. */
uint16_t client_receive(client *c);

/* Typed senders for the messages tests need. */
void client_hello(client *c, uint64_t schema_hash);
void client_command(client *c, uint8_t action);
void client_get(client *c, uint8_t what);
void client_instrument(client *c, const seld_wire_instrument *instrument);
void client_entry(client *c, uint32_t inserted_um);
void client_step(client *c, uint32_t tick, uint16_t count, int32_t translation_begin,
                 int32_t translation_per_tick);

/* What the device answered last, of that kind. False when the next frame is something else. */
bool client_expect_status(client *c, seld_wire_status *status);
bool client_expect_reject(client *c, seld_wire_reject *reject);
bool client_expect_ticks(client *c, seld_wire_ticks *ticks); /* skips hash64 */

/* A straight wire of 300 mm that every check accepts. */
void client_plain_instrument(seld_wire_instrument *instrument);

/* hello, instrument, entry, ARM and START in free space. False when something was refused. */
bool client_start_session(client *c);

#endif
