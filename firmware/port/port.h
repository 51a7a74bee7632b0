/* This header has the functions that a port provides to the app, and those of the app that a port calls.
 * A port owns the memory (one crn_app, two scene slots), the pipe of bytes, and the 1 ms timer:
 *   at power-up      crn_app_init(app, &port)               outputs are off from here on
 *   bytes came in    crn_app_receive(app, bytes, count)     from the main loop, never from an interrupt
 *   1 ms passed      crn_app_timer(app)                     from the main loop, per edge of the timer, late ones too
 * A port may report a wrong clock (crn_app_port_error). In FREE_RUN the timer decides when a tick runs. In
 * every mode and state, the app reads `inputs` and writes `outputs` once per edge of the timer. */
#ifndef CRN_PORT_H
#define CRN_PORT_H

#include "firmware/port/port_built.h"
#include <stdbool.h>
#include <stddef.h>

enum {
    CRN_PORT_TOOL_MAX = 3,      /* tracks: one per tool, from the innermost */
    CRN_PORT_DRIVE_HOLD_ms = 5, /* the power stage drops power this long after the last flip */
    CRN_PORT_SERIAL_BYTES = 24, /* longest serial */
};

/* States whether a sensor's reading is valid, or why it is not. Only OK readings are used. */
typedef enum crn_port_sensor {
    CRN_PORT_SENSOR_OK = 0,
    CRN_PORT_SENSOR_ABSENT, /* not fitted; a motor without a force sensor needs the local unlock */
    CRN_PORT_SENSOR_RANGE,  /* outside its electrical range: cable broken or shorted, amplifier saturated */
    CRN_PORT_SENSOR_ERROR,  /* signal error: illegal step, check sum, no new sample since the last tick */
} crn_port_sensor;

typedef struct crn_port_hand {
    int32_t translation_counts; /* absolute, may wrap; + into the patient */
    int32_t rotation_counts;    /* absolute, may wrap; + right-handed about the direction of insertion */
} crn_port_hand;

/* Holds the readings that the electronics of one track report, apart from its encoders. */
typedef struct crn_port_track {
    int32_t force_raw; /* axial force on the hand in the sensor's counts, + pushes the hand back out */
    uint8_t translation_sensor; /* CRN_PORT_SENSOR_* */
    uint8_t rotation_sensor;
    uint8_t force_sensor;
    bool over_current; /* a motor driver of this track limits its current or has tripped */
} crn_port_track;

typedef struct crn_port_inputs {
    crn_port_hand hands[CRN_PORT_TOOL_MAX];
    crn_port_track tracks[CRN_PORT_TOOL_MAX];
    int32_t syringe_counts; /* plunger of the contrast syringe, absolute, may wrap; + injects */
    int32_t inflator_raw;   /* pressure of the balloon's inflator in the sensor's counts */
    uint8_t syringe_sensor; /* CRN_PORT_SENSOR_* */
    uint8_t inflator_sensor;
    uint32_t buttons;    /* bit 0: X-ray pedal, 1: cine pedal, 2 .. 7: buttons of the rig */
    bool emergency_stop; /* pressed, or its loop is open */
    bool supply_good;    /* the motors' supply is within its range */
    bool stage_on;       /* the power stage drives: supply good, stop released, drive line flipping */
    bool local_unlock;   /* the switch inside the rig; limits can be raised only while it is closed */
} crn_port_inputs;

typedef struct crn_port_motor {
    int32_t axial_mN;    /* + pushes the hand back out */
    int32_t torque_uN_m; /* + opposes positive rotation */
} crn_port_motor;

typedef enum crn_port_lamp {
    CRN_PORT_LAMP_IDLE = 0, /* INIT, READY */
    CRN_PORT_LAMP_ARMED,    /* motors may be powered: slow blinking */
    CRN_PORT_LAMP_RUNNING,
    CRN_PORT_LAMP_FAULT, /* fast blinking */
} crn_port_lamp;

/* Written once per edge of the timer, and at once if a fault removes the motor power. */
typedef struct crn_port_outputs {
    crn_port_motor motors[CRN_PORT_TOOL_MAX]; /* 0 without a tool, and unless RUNNING in FREE_RUN */
    bool drive;   /* level of the drive line: flipped on every edge while power is wanted, else unchanged */
    bool enable;  /* false: remove the power now, without waiting for CRN_PORT_DRIVE_HOLD_ms */
    uint8_t lamp; /* CRN_PORT_LAMP_* */
} crn_port_outputs;

typedef struct crn_port {
    void *context; /* passed back in every call */
    /* Queues one whole frame for the host; returns false, and queues nothing, if there is no space for it. */
    bool (*transmit)(void *context, const uint8_t *frame, size_t frame_bytes);
    size_t (*transmit_room)(void *context); /* length of the longest frame that `transmit` would accept now */
    /* Samples the rig; without a rig returns false, and the app uses `input` messages and powers no motor. */
    bool (*inputs)(void *context, crn_port_inputs *inputs);
    void (*outputs)(void *context, const crn_port_outputs *outputs);
    uint32_t (*now_us)(void *context); /* free-running, wraps at 2^32; measures how long a tick took */
    const char *serial; /* unique to this device, printable ASCII, at most CRN_PORT_SERIAL_BYTES */
    struct crn_instrument *tool_table; /* CRN_TABLE_MAX tools, as the host sent them; no tick reads them */
    uint8_t *scene_slots[2];    /* two buffers: the old scene stays until the new one is checked (near.md) */
    uint32_t scene_slot_bytes;  /* size of each, 4-byte aligned */
    uint32_t scene_large_bytes; /* size of both if they adjoin, for one larger scene in both; 0: none */
    void *near_memory;    /* 32-byte aligned, for the parts of a scene that a tick reads (core/near/near.h) */
    uint32_t near_bytes;  /* size of it; 0: there is none, and scenes are read where they lie */
    uint32_t tick_cycles; /* of the processor in a tick; 0: FREE_RUN takes any set-up (docs/budget.md) */
    uint32_t capabilities;       /* CRN_WIRE_CAPABILITY_* that depend on the port: encoders, motors */
    uint32_t force_uN_per_count; /* of the force sensors, 0 for 1,000; hosts may change it by a quarter */
    crn_port_built built;        /* port_built.h */
} crn_port;

#endif
