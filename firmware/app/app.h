/* The firmware app runs the simulation core inside a device. The app contains the tick modes, encoders,
 * virtual coupling, force output, safety, faults and the wire protocol. The app's code is the same on every
 * port (the part for one kind of hardware). The app checks everything that comes over the wire protocol
 * before using it, and a refused request changes nothing.
 *
 *          accepted HELLO        ARM             START
 *   INIT ----------------> READY ----> ARMED ----------> RUNNING
 *                            ^          | ^ <---- STOP ------+      with a rig in FREE_RUN, START powers the motors;
 *                            |          v |                  |      CONFIRM must have answered ARM_MOTORS
 *                            +-- RESET --+----- FAULT <------+      every stopping fault: motors off, latched
 */
#ifndef CRN_APP_H
#define CRN_APP_H

#include "firmware/app/haptics/haptics.h"
#include "firmware/app/safety/clock.h"
#include "firmware/app/safety/permission.h"
#include "firmware/app/safety/safety.h"
#include "firmware/app/safety/watchdog.h"
#include "firmware/core/core_state.h"
#include "firmware/port/port.h"
#include "shared/wire/wire_frame.h"

enum {
    CRN_APP_LIVE_BATCH_ticks = 16, /* one `live` frame per 16 ms */
    CRN_APP_LIVE_QUEUE_ticks = 256,
    CRN_APP_EVENT_QUEUE = 32,
    /* The ring buffer has space for CRN_APP_LIVE_QUEUE_ticks encoded ticks of three tools, and for a hundred
     * commands that belong to these ticks. */
    CRN_APP_LIVE_QUEUE_BYTES =
        CRN_APP_LIVE_QUEUE_ticks *
            ((int)CRN_WIRE_BYTES_live_tick - (int)CRN_WIRE_MAX_order_list_items * (int)CRN_WIRE_BYTES_order) +
        100 * (int)CRN_WIRE_BYTES_order,
    CRN_APP_ORDER_QUEUE = 8, /* FREE_RUN: ticks to come whose orders have arrived */
    CRN_APP_HASH64_EVERY_ticks = 100,
    CRN_APP_FAULT_MAX = 32,
    CRN_APP_SNAPSHOT_TOOL_BYTES = 120,
    CRN_APP_SNAPSHOT_HEAD_BYTES = 12 + CRN_APP_SNAPSHOT_TOOL_BYTES * CRN_TOOL_MAX,
    CRN_APP_SNAPSHOT_BYTES = CRN_APP_SNAPSHOT_HEAD_BYTES + (int)sizeof(crn_state_words),
};

/* Describes an upload, that is, a block of bytes that arrives in chunks. */
typedef struct crn_upload {
    uint32_t expected_bytes;
    uint32_t received_bytes;
    uint32_t crc32;
    bool open;
} crn_upload;

/* Holds the readings of the encoders at the user's hands, from the rig's sensors or from the host. */
typedef struct crn_app_encoders {
    crn_port_hand hands[CRN_TOOL_MAX];
    uint32_t buttons;
    int32_t syringe_counts, inflator_raw;
} crn_app_encoders;

/* How one track is configured. The parts of the app (hands, haptics and safety) keep the values that they
 * derive from the configuration of the rig's tracks (one per tool). */
typedef struct crn_app_track {
    crn_wire_track wire;         /* in force, as read back */
    crn_wire_track built;        /* as the rig's builder stated it */
    crn_wire_track vouched;      /* last confirmed by a person at the rig, or by an accepted coupling */
    uint32_t scale_pm_per_count; /* scales that the builder or a person at the rig stated */
    uint32_t scale_counts_per_turn;
} crn_app_track;

/* Holds the messages that wait for space in the pipe to the host. In the queue, ticks are encoded as in a
 * `live` message, so a tick without commands takes no space for commands. */
typedef struct crn_app_queue {
    uint32_t first, count; /* ring of live ticks */
    uint32_t begin, used;  /* ring of their bytes */
    uint32_t ticks_lost;
    uint32_t event_first, event_count, event_number, events_lost;
    uint16_t nodes_every_ticks;
    uint32_t nodes_due_in;
    bool wants_events, is_picture_due;
    uint32_t pictures_dropped;
    crn_wire_notice events[CRN_APP_EVENT_QUEUE];
    uint16_t tick_bytes[CRN_APP_LIVE_QUEUE_ticks];
    uint8_t ticks[CRN_APP_LIVE_QUEUE_BYTES];
} crn_app_queue;

/* Holds the commands to the core for one tick, already checked and converted to the form that the core
 * accepts. The struct crn_app_order_set does not contain the positions of the user's hands. */
typedef struct crn_app_order_set {
    crn_rhythm_order rhythm;
    crn_scaffold scaffold;
    crn_strut_order strut;
    bool has_exchange;
    crn_exchange_order exchange;
} crn_app_order_set;

/* Holds the commands for one tick of FREE_RUN, both as the core needs them and as the tick's `live` message
 * reports them. */
typedef struct crn_app_tick_orders {
    crn_wire_order_list wire;
    crn_app_order_set core;
} crn_app_tick_orders;

/* The conversation with the host. */
typedef struct crn_app_link {
    bool is_greeted;
    bool sequence_is_known;
    uint16_t sequence_in, sequence_out;
    uint16_t answers; /* sequence number of the request that is being answered; 0: of none */
    uint32_t sequence_gaps, transmit_dropped;
    crn_wire_decoder decoder;
} crn_app_link;

/* The set-up that the host has sent before ARM. */
typedef struct crn_app_setup {
    uint32_t tool_count; /* positions of the line; 0: none yet */
    uint32_t table_count;
    uint32_t line[CRN_TOOL_MAX]; /* at the start: number in the table of the tool at each position; 0: free */
    bool has_scene, has_entry;
    uint8_t scene_slot; /* the slot in use; the other one receives an upload */
    crn_upload scene_upload;
    uint32_t scene_bytes, scene_crc32, tools_crc32, entry_crc32;
    crn_app_track tracks[CRN_TOOL_MAX];
    crn_entry entry;
    uint32_t inserted_um[CRN_TOOL_MAX];
    uint32_t inserted_count; /* lengths that came with the entry */
    crn_lumen lumen;
    crn_motion motion;                  /* of the lumen, when it moves */
    crn_lesion lesions[CRN_LESION_MAX]; /* of the lumen, that can yield */
    crn_walls walls;                    /* of the lumen, if they give way */
} crn_app_setup;

/* Holds the state of one session, except the states of the core, the hands and the haptics. */
typedef struct crn_app_session {
    bool has_stop;
    uint32_t stop_tick; /* tick of a STOP that is still to come */
    uint32_t buttons;   /* of the last tick */
    bool has_mailbox;   /* the host has sent an `input` since START */
    crn_app_encoders mailbox;
    crn_app_tick_orders orders[CRN_APP_ORDER_QUEUE]; /* FREE_RUN: ring, of the ticks to come */
    uint32_t order_first, order_count;
    uint8_t exchange;     /* CRN_WIRE_EXCHANGE_* of the last tick */
    int32_t inflator_raw; /* of the last tick; the pressure stays while none is reported */
    crn_upload snapshot_upload;
} crn_app_session;

/* Holds the readings of the rig at the present edge of the timer. */
typedef struct crn_app_edge {
    bool has_rig;
    crn_port_inputs rig;
} crn_app_edge;

/* The fault log and the cause of state FAULT. */
typedef struct crn_app_faults {
    uint16_t stopped_by; /* CRN_FAULT_CODE_* of the first fault that stopped */
    uint16_t count;
    uint32_t core_bits_seen;
    crn_wire_fault_entry entries[CRN_APP_FAULT_MAX];
} crn_app_faults;

/* Messages being read and written. Once a request or a timer edge has been handled, only the buffer `ticks`
 * is still needed. */
typedef struct crn_app_buffers {
    union {
        crn_wire_scene_chunk scene_chunk;
        crn_wire_tools tools;
        crn_wire_step step;
        crn_wire_snapshot_chunk snapshot_chunk;
    } request;
    union {
        crn_wire_nodes nodes;
        crn_wire_node_table node_table;
        crn_wire_contacts contacts;
        crn_wire_fault_log fault_log;
        crn_wire_snapshot_chunk snapshot_chunk;
        crn_instrument tools[CRN_TABLE_MAX];                /* being checked, before anything is answered */
        crn_app_order_set orders[CRN_WIRE_MAX_step_inputs]; /* of a step's inputs, until its ticks are done */
    } reply;
    crn_wire_ticks ticks; /* filled tick by tick while other replies go out */
    uint8_t payload[CRN_WIRE_PAYLOAD_MAX];
    uint8_t frame[CRN_WIRE_FRAME_MAX];
} crn_app_buffers;

typedef struct crn_app {
    const crn_port *port;
    uint8_t state;       /* CRN_WIRE_STATE_* */
    uint8_t mode;        /* CRN_WIRE_MODE_* */
    uint32_t edges_done; /* by crn_app_timer, each to its very end; a port feeds its watchdog by this count */
    crn_permission permission;
    crn_watchdog watchdog;
    crn_clock clock;
    crn_app_edge edge;
    crn_safety safety;
    crn_hands hands;
    crn_haptics haptics;
    crn_app_session session;
    crn_app_faults faults;
    crn_app_setup setup;
    crn_app_link link;
    /* big blocks last */
    crn_app_queue queue;
    crn_app_buffers buffers;
    crn_model model;
    crn_state core;
} crn_app;

/* Powers up the app: its state is INIT, the motors are off, and neither a scene nor tools are loaded. `port`
 * must outlive the app. */
void crn_app_init(crn_app *app, const crn_port *port);

/* Receives bytes from the host, in pieces of any size. The replies leave through port->transmit before
 * crn_app_receive returns. */
void crn_app_receive(crn_app *app, const uint8_t *bytes, size_t count);

/* A host may also send requests without frames, as HID reports. The app checks a HID request as if it had
 * come in a frame. A HID request does not disturb a frame that has arrived only in part. The app
 * answers a HID request by a frame whose field `answers` is 0, because a HID request has no frame number. */

/* The function accepts only STOP and RESET, and returns true when the state is then no longer RUNNING, or is
 * READY after RESET. */
bool crn_app_order(crn_app *app, uint8_t action);

/* Applies the message `rig`, which contains settings for one or more tracks, beginning with track 0;
 * afterwards app->setup.tracks contains the accepted values. */
void crn_app_configure(crn_app *app, const crn_wire_rig *rig);

/* Returns the size of the largest scene that the port's memory holds. */
uint32_t crn_app_scene_bytes_max(const crn_port *port);

/* A program that runs the device in its own process can give the device a scene without an upload. The
 * scene's bytes stay in the program's memory, where many devices may share them; they must neither change nor
 * be freed while a device uses the scene. `crc32` is the CRC-32 of the bytes; the address of the bytes must
 * be a multiple of 4. The function returns false if the state is not READY, or if the scene is not valid; the
 * device then has no scene. */
bool crn_app_scene_share(crn_app *app, const uint8_t *bytes, uint32_t byte_count, uint32_t crc32);

/* A program that runs the device in its own process, such as the simulated port, can take a snapshot by
 * crn_app_snapshot_take and restore a snapshot by crn_app_snapshot_put. A snapshot has CRN_APP_SNAPSHOT_BYTES
 * bytes, the same as in the messages of the wire protocol, without frames and checksums. To take or put a
 * snapshot, the mode must be LOCKSTEP, and the state must be ARMED or RUNNING. The function
 * crn_app_snapshot_put checks the bytes in the same way as bytes that a host sends. When
 * crn_app_snapshot_take or crn_app_snapshot_put returns false, the session has not changed, but an unfinished
 * upload may have ended. */
bool crn_app_snapshot_take(crn_app *app, uint8_t *bytes);
bool crn_app_snapshot_put(crn_app *app, const uint8_t *bytes);

/* Returns the force in mN that a track's sensor measures at this timer edge, or 0 without a working sensor.
 */
int32_t crn_app_force_measured(const crn_app *app, uint32_t track);

/* One millisecond has passed. The function crn_app_timer reads the rig's sensors, checks the readings,
 * computes a tick in FREE_RUN and RUNNING, and writes the outputs. */
void crn_app_timer(crn_app *app);

/* The port has found by itself that its clock or memory is wrong. The device reports INTERNAL with the line 0
 * and `value`, and the motors lose their power. */
void crn_app_port_error(crn_app *app, int32_t value);

#endif
