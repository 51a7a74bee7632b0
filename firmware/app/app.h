/* The firmware app: the core inside a device. Tick modes, encoders, force output, faults and the wire; the same code on
 * every port. Everything that comes over the wire is hostile until checked, and a refused request changes nothing.
 *
 *          accepted HELLO        ARM             START
 *   INIT ----------------> READY ----> ARMED ----------> RUNNING
 *                            ^           ^ <---- STOP ------+
 *                            |           |                  |
 *                            +-- RESET --+---- FAULT <------+  (encoder jump, own error: motors off)
 *
 * May include: firmware/core, firmware/port/port.h, shared. Called by: firmware/port.
 */
#ifndef SELD_APP_H
#define SELD_APP_H

#include "firmware/core/core_state.h"
#include "firmware/port/port.h"
#include "shared/wire/wire_frame.h"

enum {
    SELD_APP_FORCE_LIMIT_mN =
        8000, /* three times the hardest push of a hand (0.8 N) and a stuck wire's 2 N */
    SELD_APP_TORQUE_LIMIT_uN_m = 20000,   /* a hand turns a 0.9 mm wire with about 5 mN m */
    SELD_APP_FORCE_SLEW_mN_per_tick = 50, /* 50 N/s: full scale in 160 ms */
    SELD_APP_TORQUE_SLEW_uN_m_per_tick = 125,
    SELD_APP_JUMP_um = 5000, /* 5 m/s: no hand does that */
    SELD_APP_HOST_SILENT_ticks = 250,
    SELD_APP_FREE_RUN_BATCH_ticks = 16, /* one `ticks` frame per 16 ms */
    SELD_APP_HASH64_EVERY_ticks = 100,
    SELD_APP_FAULT_MAX = 32,
    SELD_APP_SNAPSHOT_HEAD_BYTES = 12 + 36 * SELD_TOOL_MAX,
    SELD_APP_SNAPSHOT_BYTES = SELD_APP_SNAPSHOT_HEAD_BYTES + (int)sizeof(seld_state_words),
};

/* A block of bytes that arrives in chunks. */
typedef struct seld_upload {
    uint32_t expected_bytes;
    uint32_t received_bytes;
    uint32_t crc32;
    bool open;
} seld_upload;

/* What the hands did, from the rig's sensors or from the host. */
typedef struct seld_app_encoders {
    seld_port_hand hands[SELD_TOOL_MAX];
    uint32_t buttons;
} seld_app_encoders;

/* Position of one tool's hand from its encoder counts. */
typedef struct seld_app_hand {
    bool is_known; /* false until the first reading, which only sets the zero */
    seld_port_hand last;
    int64_t translation_counts; /* since the start */
    int64_t rotation_counts;
} seld_app_hand;

/* One tool's encoders and actuators, set by the `rig` message. */
typedef struct seld_app_track {
    uint64_t translation_m_q46_per_count;
    uint64_t rotation_turn48_per_count; /* one turn = 2^48 */
    uint32_t translation_jump_counts;   /* largest believable change in one tick */
    uint32_t rotation_jump_counts;
    uint32_t force_gain_milli;
    int32_t force_limit_mN;
    int32_t torque_limit_uN_m;
} seld_app_track;

typedef struct seld_app {
    const seld_port *port;
    uint8_t state; /* SELD_WIRE_STATE_* */
    uint8_t mode;  /* SELD_WIRE_MODE_* */
    bool is_greeted;
    uint16_t fault_code;

    /* link */
    seld_wire_decoder decoder;
    uint16_t sequence_in, sequence_out, answers;
    bool sequence_is_known;
    uint32_t sequence_gaps, transmit_dropped;
    uint32_t silent_ticks;
    bool has_mailbox; /* the host has sent an `input` since START */
    seld_app_encoders mailbox;

    /* set-up */
    seld_upload scene_upload;
    uint8_t scene_slot; /* the slot in use; the other one is staged into */
    bool has_scene, has_entry;
    uint32_t tool_count; /* 0: none yet */
    seld_lumen lumen;
    seld_instrument tools[SELD_TOOL_MAX]; /* from the innermost */
    seld_entry entry;
    uint32_t inserted_um[SELD_TOOL_MAX];
    uint32_t inserted_count; /* lengths that came with the entry */
    seld_app_track tracks[SELD_TOOL_MAX];

    /* session */
    seld_app_hand hands[SELD_TOOL_MAX];
    seld_port_motor motors[SELD_TOOL_MAX]; /* asked for; in LOCKSTEP only reported */
    bool drive_level; /* of the drive line, flipped once per edge while power is wanted */
    uint32_t core_faults_seen;
    seld_upload snapshot_upload;
    uint16_t fault_count;
    seld_wire_fault_entry faults[SELD_APP_FAULT_MAX];

    /* big blocks last */
    union {
        seld_wire_scene_chunk scene_chunk;
        seld_wire_tools tools;
        seld_wire_step step;
        seld_wire_snapshot_chunk snapshot_chunk;
    } request;
    union {
        seld_wire_nodes nodes;
        seld_wire_node_table node_table;
        seld_wire_contacts contacts;
        seld_wire_fault_log fault_log;
        seld_wire_snapshot_chunk snapshot_chunk;
        seld_instrument tools[SELD_TOOL_MAX]; /* being checked, before anything is answered */
    } reply;
    seld_wire_ticks ticks; /* filled tick by tick while other replies go out */
    uint8_t payload[SELD_WIRE_PAYLOAD_MAX];
    uint8_t frame[SELD_WIRE_FRAME_MAX];
    uint8_t snapshot[SELD_APP_SNAPSHOT_BYTES];
    seld_model model;
    seld_state core;
} seld_app;

/* Power-up: state INIT, motors off, no scene, no tools. `port` must outlive the app. */
void seld_app_init(seld_app *app, const seld_port *port);

/* Bytes from the host, in pieces of any size. Replies leave through port->transmit before it returns. */
void seld_app_receive(seld_app *app, const uint8_t *bytes, size_t count);

/* One millisecond has passed. Does a tick in FREE_RUN and RUNNING, keeps the motors off otherwise. */
void seld_app_timer(seld_app *app);

#endif
