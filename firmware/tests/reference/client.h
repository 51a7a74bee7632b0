/* This header declares a minimal host for tests. The host sends messages to a simulated device and reads the
 * device's frames, through bytes only. */
#ifndef CRN_TEST_CLIENT_H
#define CRN_TEST_CLIENT_H

#include "firmware/port/sim/sim.h"
#include "shared/wire/wire_frame.h"

/* Describes a connection to a device other than the simulated device; the function `read` returns 0 when the
 * device has no more bytes to send. */
typedef struct client_pipe {
    void *context;
    void (*write)(void *context, const uint8_t *bytes, size_t count);
    size_t (*read)(void *context, uint8_t *bytes, size_t capacity);
} client_pipe;

typedef struct client {
    crn_sim *sim; /* NULL: the pipe leads to the device */
    client_pipe pipe;
    crn_wire_decoder decoder;
    uint16_t sequence;
    uint16_t tool_count; /* set by the last client_tools or client_start_tools */
    uint8_t payload[CRN_WIRE_PAYLOAD_MAX];
    uint8_t frame[CRN_WIRE_FRAME_MAX];
    uint8_t snapshot[1 << 17];
    uint32_t snapshot_bytes;
} client;

/* Opens a simulated device that has been powered up; client_close ends its use. */
void client_open(client *c, uint32_t scene_slot_bytes);
void client_open_pipe(client *c, const client_pipe *pipe);
void client_close(client *c);

/* Makes a frame around `length` payload bytes and sends the frame to the device. */
void client_send(client *c, uint16_t type, const uint8_t *payload, size_t length);

/* Reads the device's next frame into c->decoder. Returns the frame's type, or 0 if the device has no more
 * frames to send. */
uint16_t client_receive(client *c);

/* These functions send the message types that tests need. */
void client_hello(client *c, uint64_t schema_hash);
void client_command(client *c, uint8_t action);
void client_stop_at(client *c, uint32_t tick);
void client_confirm(client *c, uint32_t code);
bool client_arm_motors(client *c); /* both steps; false when the device refused one */
void client_get(client *c, uint8_t what);
void client_stream(client *c, uint8_t events, uint16_t nodes_every_ticks);
void client_rig(client *c, const crn_wire_track *tracks, uint16_t count);

/* Returns the settings of a track with 1 um and 1/65 536 turn per count, forces without gain, the highest
 * limits, and a coupling of 1 N/mm on a rig with enough damping. */
crn_wire_track client_plain_track(void);
void client_tools(client *c, const crn_wire_tools *tools);
void client_entry(client *c, uint32_t inserted_um); /* the same for every tool */
void client_entry_each(client *c, const uint32_t *inserted_um, uint16_t count);
bool client_entry_along(client *c, int axis, uint32_t inserted_um); /* waits for the answer */
bool client_load_scene(client *c, const uint8_t *bytes, uint32_t count);
/* Sends a step in which the hand moves tool 0 while the other tools do not move. */
void client_step(client *c, uint32_t tick, uint16_t count, int32_t translation_begin,
                 int32_t translation_per_tick);
/* Sends a step with `count` inputs in which the hands move every tool k; the translation in input i is
 * begin[k] + i * per_tick[k] counts. */
void client_step_each(client *c, uint32_t tick, uint16_t count, const int32_t *begin,
                      const int32_t *per_tick);
void client_input(client *c, const int32_t *translation, const int32_t *rotation);
void client_orders(client *c, const crn_wire_order *orders, uint16_t count);

/* Reads a whole snapshot from the device into c->snapshot. The function client_write_snapshot sends the
 * snapshot in c->snapshot to the device and leaves the device's last answer in the pipe. Returns false if a
 * frame of the snapshot is missing or refused. */
bool client_read_snapshot(client *c);
void client_write_snapshot(client *c);

/* Each client_expect function reads the device's next frame, which must be of the kind in the function's
 * name. Returns false if the next frame is of another kind. */
bool client_expect_status(client *c, crn_wire_status *status);
bool client_expect_reject(client *c, crn_wire_reject *reject);
bool client_expect_ticks(client *c, crn_wire_ticks *ticks); /* in either mode; it skips hash64 */
bool client_expect_live(client *c, crn_wire_live *live);    /* skips hash64 */

/* Makes straight tools of 300 mm that every check accepts: a wire, a catheter around it, and a guiding
 * catheter around both. */
void client_plain_tools(crn_wire_tools *tools, uint16_t count);

/* Begins a session in free space: sends HELLO, the tools, an entry that inserts 50 mm of each tool, ARM and
 * START. Returns false if the device refused one of the messages. */
bool client_start_tools(client *c, uint16_t count);
bool client_start_session(client *c); /* with one tool */

#endif
