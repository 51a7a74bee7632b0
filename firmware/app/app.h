/* The firmware app: the core inside a device. Tick modes, encoders, virtual coupling, force output, safety,
 * faults and the wire; the same code on every port. Everything that comes over the wire is hostile until
 * checked, and a refused request changes nothing.
 *
 *          accepted HELLO        ARM             START
 *   INIT ----------------> READY ----> ARMED ----------> RUNNING
 *                            ^          | ^ <---- STOP ------+      in FREE_RUN with a rig START powers the motors, and is
 *                            |          v |                  |      refused unless ARM_MOTORS was answered by CONFIRM
 *                            +-- RESET --+----- FAULT <------+      every stopping fault: motors off, latched
 */
#ifndef CRN_APP_H
#define CRN_APP_H

#include "firmware/core/core_state.h"
#include "firmware/port/port.h"
#include "shared/wire/wire_frame.h"

enum {
    CRN_APP_FORCE_LIMIT_mN = 8000, /* three times the hardest push of a hand (0.8 N) and a stuck wire's 2 N */
    CRN_APP_TORQUE_LIMIT_uN_m = 20000,   /* a hand turns a 0.9 mm wire with about 5 mN m */
    CRN_APP_FORCE_SLEW_mN_per_tick = 50, /* 50 N/s: full scale in 160 ms */
    CRN_APP_TORQUE_SLEW_uN_m_per_tick = 125,
    CRN_APP_JUMP_um = 5000, /* 5 m/s: no hand does that */
    CRN_APP_HOST_SILENT_ticks =
        30,                  /* a frame is due within this; then CRN_APP_FADE_ticks until no force is left */
    CRN_APP_FADE_ticks = 12, /* with 8 ms for the lag of a motor: no force 50 ms after the last frame */
    CRN_APP_CODE_ticks = 2000,     /* between ARM_MOTORS and CONFIRM, and between CONFIRM and START */
    CRN_APP_LIVE_BATCH_ticks = 16, /* one `live` frame per 16 ms */
    CRN_APP_LIVE_QUEUE_ticks = 256,
    CRN_APP_EVENT_QUEUE = 32,
    CRN_APP_RHYTHM_QUEUE = 8, /* what is asked of heart and breath in FREE_RUN, one per tick */
    CRN_APP_HASH64_EVERY_ticks = 100,
    CRN_APP_ASKED_ticks = 8, /* how long ago a force may have been asked for that is measured now */
    CRN_APP_FAULT_MAX = 32,
    CRN_APP_SNAPSHOT_TOOL_BYTES = 108,
    CRN_APP_SNAPSHOT_HEAD_BYTES = 12 + CRN_APP_SNAPSHOT_TOOL_BYTES * CRN_TOOL_MAX,
    CRN_APP_SNAPSHOT_BYTES = CRN_APP_SNAPSHOT_HEAD_BYTES + (int)sizeof(crn_state_words),
};

/* A block of bytes that arrives in chunks. */
typedef struct crn_upload {
    uint32_t expected_bytes;
    uint32_t received_bytes;
    uint32_t crc32;
    bool open;
} crn_upload;

/* What the hands did, from the rig's sensors or from the host. */
typedef struct crn_app_encoders {
    crn_port_hand hands[CRN_TOOL_MAX];
    uint32_t buttons;
    int32_t syringe_counts, inflator_raw;
} crn_app_encoders;

/* Position of one tool's hand from its encoder counts. */
typedef struct crn_app_hand {
    bool is_known; /* false until the first reading, which only sets the zero */
    crn_port_hand last;
    int64_t translation_counts; /* since the start */
    int64_t rotation_counts;
} crn_app_hand;

/* Spring, damper and friction of one axis in its own units: way in Q30 m and force in Q22 N, or way in 2^-32
 * turn and torque in Q24 N m. Force per way is stiffness / 2^shift. */
typedef struct crn_app_axis {
    int64_t stiffness; /* 0: no coupling */
    int64_t damping;   /* the same format, per way of one tick */
    int64_t estimate_max;
    int64_t lead_max; /* way at the force limit: beyond it the hand slips */
    int32_t seal;     /* friction of sheath and valve */
    int32_t force_max;
    int32_t step_max;   /* way of the tool in one tick */
    int32_t sense_step; /* ways below this tell nothing about stiffness */
    uint32_t shift;
    uint32_t relax_shift; /* stiffness shown is forgotten within 2^this of way */
} crn_app_axis;

/* State of one axis of the coupling; part of the snapshot. */
typedef struct crn_app_spring {
    bool is_set;       /* false: the first tick takes hand and tool as they are */
    int32_t reference; /* hand less tool without force; modulo 2^32 */
    int32_t lead;      /* way of the hand beyond the tool after the last tick */
    int32_t lead_before;
    int32_t force;    /* of the tool on the hand, last tick */
    int32_t way;      /* of the tool, last tick's end; modulo 2^32 */
    int64_t estimate; /* stiffness that the tool has shown */
    int32_t output;   /* what the coupling asks the motor for */
} crn_app_spring;

/* Energy between motor and hand; part of the snapshot. */
typedef struct crn_app_energy {
    int64_t taken_pJ;   /* put in by the hand less given back, at most what may be stored */
    int32_t hand_m_q30; /* where the hand was */
    uint32_t hand_turn32;
    uint32_t scale_q16; /* share of the force, 65 536 while passive */
    bool is_set;
} crn_app_energy;

/* From one turn of a carriage to the next. */
typedef struct crn_app_swing {
    uint32_t ticks;
    int32_t low_mN, high_mN; /* of what the motor was given */
    int64_t way_nm, hand_pJ; /* + into the patient; what the hand put in */
    int64_t hand_mN_ms;      /* sum of the hand's force */
} crn_app_swing;

/* A carriage that goes forth and back. */
typedef struct crn_app_cycle {
    crn_app_swing now, last;
    int64_t at_nm, far_nm; /* from the last turn: where it is, and the farthest */
    int32_t direction;     /* 0: not known yet */
    uint32_t driven_ticks; /* of swings that the motor kept up */
} crn_app_cycle;

/* What the checks of one track remember; only while a rig is attached. */
typedef struct crn_app_watch {
    int32_t asked_mN[CRN_APP_ASKED_ticks]; /* ring of what was asked for */
    uint32_t over_ticks, current_ticks, mismatch_ticks;
    uint32_t unbalance_ticks; /* of a force on the carriage that nobody holds, and what came of it */
    int32_t unbalance_mN, speed_counts;
    int64_t moved_counts, speed_nm, way_nm;
    bool stands;
    bool had_force_sensor;
    crn_port_hand last;
    int32_t moved[CRN_APP_ASKED_ticks]; /* ring of what the carriage moved, counts + into the patient */
    uint32_t loose_ticks;               /* of a force that no hand holds, less those of one that is held */
    uint32_t untouched_ticks, fast_ticks, passivity_ticks;
    int32_t speed_begin_um_s; /* when the hand released it */
    int64_t impulse_uN_s;     /* of the motor since then */
    crn_app_cycle cycle;
} crn_app_watch;

/* One tool's encoders and actuators, set by the `rig` message. */
typedef struct crn_app_track {
    crn_wire_track wire; /* as read back */
    uint64_t translation_m_q46_per_count;
    uint64_t rotation_turn48_per_count; /* one turn = 2^48 */
    uint32_t translation_jump_counts;   /* largest believable change in one tick */
    uint32_t rotation_jump_counts;
    crn_wire_track built;        /* as the rig's builder stated it */
    crn_wire_track vouched;      /* as somebody at the rig, or a coupling that was taken, had it last */
    uint32_t scale_pm_per_count; /* what a count is: the builder's word, or that of somebody at the rig */
    uint32_t scale_counts_per_turn;
    int32_t force_limit_mN;
    int32_t torque_limit_uN_m;
    crn_app_axis axes[2]; /* along and about the line */
} crn_app_track;

enum { CRN_APP_ALONG, CRN_APP_ABOUT };

/* Messages that wait for room on the way to the host. */
typedef struct crn_app_queue {
    uint32_t first, count; /* ring of live ticks */
    uint32_t ticks_lost;
    uint32_t event_first, event_count, event_number, events_lost;
    uint16_t nodes_every_ticks;
    uint32_t nodes_due_in;
    bool wants_events, is_picture_due;
    uint32_t pictures_dropped;
    crn_wire_notice events[CRN_APP_EVENT_QUEUE];
    crn_wire_live_tick ticks[CRN_APP_LIVE_QUEUE_ticks];
} crn_app_queue;

/* What a tick is asked for besides the hands. */
typedef struct crn_app_wish {
    crn_rhythm_order rhythm;
    crn_scaffold scaffold;
    crn_strut_order strut;
} crn_app_wish;

/* The conversation with the host. */
typedef struct crn_app_link {
    bool is_greeted;
    bool sequence_is_known;
    uint16_t sequence_in, sequence_out;
    uint16_t answers; /* sequence number of the request that is being answered; 0: of none */
    uint32_t sequence_gaps, transmit_dropped;
    uint32_t silent_ticks; /* since the last valid frame, in FREE_RUN */
    crn_wire_decoder decoder;
} crn_app_link;

/* What the host has set up before ARM. */
typedef struct crn_app_setup {
    uint32_t tool_count; /* 0: none yet */
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
    crn_instrument tools[CRN_TOOL_MAX]; /* from the innermost */
} crn_app_setup;

/* What one session remembers beside the core and the haptics. */
typedef struct crn_app_session {
    crn_app_hand hands[CRN_TOOL_MAX];
    bool has_stop;
    uint32_t stop_tick; /* tick of a STOP that is still to come */
    uint32_t buttons;   /* of the last tick */
    bool has_mailbox;   /* the host has sent an `input` since START */
    crn_app_encoders mailbox;
    crn_app_wish orders[CRN_APP_RHYTHM_QUEUE]; /* FREE_RUN: of the ticks to come */
    uint32_t order_count;
    int32_t inflator_raw; /* of the last tick; the pressure stays while nobody reports one */
    crn_upload snapshot_upload;
} crn_app_session;

/* Between hands and tools: coupling, energy, and the forces that the motors are asked for. */
typedef struct crn_haptics {
    crn_app_spring springs[CRN_TOOL_MAX][2];
    crn_app_energy energies[CRN_TOOL_MAX];
    crn_port_motor motors[CRN_TOOL_MAX]; /* asked for; in LOCKSTEP only reported */
    int32_t fade_from[CRN_TOOL_MAX][2];  /* forces when the host fell silent */
    uint32_t passivity_ticks;
} crn_haptics;

/* What the checks of every edge remember, and the power of the motors. */
typedef struct crn_safety {
    bool is_driving;
    bool drive_level; /* of the drive line, flipped once per edge while power is wanted */
    bool stage_was_on;
    bool stage_is_reported;              /* STAGE_STUCK is in the log */
    uint32_t drive_ticks, idle_ticks;    /* since power was requested, or since it no longer is */
    uint32_t asked_at;                   /* place in the rings of what was asked for */
    crn_port_motor driven[CRN_TOOL_MAX]; /* given to the port at the last edge; 0 without power */
    crn_app_watch watches[CRN_TOOL_MAX];
} crn_safety;

/* This edge's sample of the rig. */
typedef struct crn_app_edge {
    bool has_rig;
    crn_port_inputs rig;
} crn_app_edge;

/* The two steps before START may power the motors. */
typedef struct crn_permission {
    bool is_given;      /* CONFIRM came: the next START powers the motors */
    uint32_t code;      /* 0: none is valid */
    uint32_t age_ticks; /* of the code, or of the permission */
    uint32_t code_count;
} crn_permission;

/* How long edges and ticks take. */
typedef struct crn_clock {
    uint32_t edge_us, backlog_us, tick_us_max, tick_overruns;
    bool has_edge, was_late;
} crn_clock;

/* The fault log and the cause of state FAULT. */
typedef struct crn_app_faults {
    uint16_t stopped_by; /* CRN_FAULT_CODE_* of the first fault that stopped */
    uint16_t count;
    uint32_t core_bits_seen;
    crn_wire_fault_entry entries[CRN_APP_FAULT_MAX];
} crn_app_faults;

/* Messages being read and written; nothing in here outlives the handling of a request or an edge, but for
 * `ticks` and `snapshot`. */
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
        crn_wire_live live;
        crn_instrument tools[CRN_TOOL_MAX]; /* being checked, before anything is answered */
    } reply;
    crn_wire_ticks ticks; /* filled tick by tick while other replies go out */
    uint8_t payload[CRN_WIRE_PAYLOAD_MAX];
    uint8_t frame[CRN_WIRE_FRAME_MAX];
    uint8_t snapshot[CRN_APP_SNAPSHOT_BYTES];
} crn_app_buffers;

typedef struct crn_app {
    const crn_port *port;
    uint8_t state;       /* CRN_WIRE_STATE_* */
    uint8_t mode;        /* CRN_WIRE_MODE_* */
    uint32_t edges_done; /* by crn_app_timer, each to its very end; a port feeds its watchdog by this count */
    crn_permission permission;
    crn_clock clock;
    crn_app_edge edge;
    crn_safety safety;
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

/* Power-up: state INIT, motors off, no scene, no tools. `port` must outlive the app. */
void crn_app_init(crn_app *app, const crn_port *port);

/* Bytes from the host, in pieces of any size. Replies leave through port->transmit before it returns. */
void crn_app_receive(crn_app *app, const uint8_t *bytes, size_t count);

/* The host's word by another way than frames (HID), judged as if it had come in one; whatever of a frame has
 * come stays. What the app answers goes out as a frame that answers nothing. */

/* STOP or RESET, nothing else. True: not RUNNING, READY after it. */
bool crn_app_order(crn_app *app, uint8_t action);

/* `rig`, the configuration of the first tracks; app->setup.tracks shows what was taken. */
void crn_app_configure(crn_app *app, const crn_wire_rig *rig);

/* What a track's force sensor says in this edge's sample, mN; 0 without a sensor that is well. */
int32_t crn_app_force_measured(const crn_app *app, uint32_t track);

/* One millisecond has passed: samples the rig, checks it, does a tick in FREE_RUN and RUNNING, writes the
 * outputs. */
void crn_app_timer(crn_app *app);

#endif
