/* The whole hardware contract: what a port gives the app, and what it calls.
 *
 * A port owns the memory (one seld_app, two scene slots), the pipe of bytes, and the 1 ms timer:
 *
 *   at power-up      seld_app_init(app, &port)
 *   bytes came in    seld_app_receive(app, bytes, count)     from the main loop, never from an interrupt
 *   1 ms passed      seld_app_timer(app)                     from the main loop; owns the tick in FREE_RUN
 *
 * A port reaches nothing else of the app. May include: nothing. Called by: firmware/app, firmware/port/<port>.
 */
#ifndef SELD_PORT_H
#define SELD_PORT_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

enum { SELD_PORT_TOOL_MAX = 3 }; /* tracks: one per tool, from the innermost */

typedef struct seld_port_hand {
    int32_t translation_counts; /* absolute, may wrap; + into the patient */
    int32_t rotation_counts;    /* absolute, may wrap; + right-handed about the direction of insertion */
} seld_port_hand;

typedef struct seld_port_encoders {
    seld_port_hand hands[SELD_PORT_TOOL_MAX];
    uint32_t buttons; /* bit 0: X-ray pedal */
} seld_port_encoders;

typedef struct seld_port_motor {
    int32_t axial_mN;    /* + pushes the hand back out */
    int32_t torque_uN_m; /* + opposes positive rotation */
} seld_port_motor;

typedef struct seld_port {
    void *context; /* handed back in every call */

    /* Queue one whole frame for the host. False: no room; the app counts it and goes on. */
    bool (*transmit)(void *context, const uint8_t *frame, size_t frame_bytes);

    /* Read the rig's encoders. False: this port has none; the app then uses the host's `input` messages. */
    bool (*encoders)(void *context, seld_port_encoders *encoders);

    /* Ask the actuators of every track for force and torque; called every tick. `drive` false: remove power; every
     * value is 0 then, and so is that of a track without a tool. */
    void (*motors)(void *context, const seld_port_motor motors[SELD_PORT_TOOL_MAX], bool drive);

    uint8_t *scene_slots[2];   /* two buffers: the old scene stays valid until the new one is validated */
    uint32_t scene_slot_bytes; /* size of each, 4-byte aligned */
    uint32_t capabilities;     /* SELD_WIRE_CAPABILITY_* that depend on the port: encoders, motors */
} seld_port;

#endif
