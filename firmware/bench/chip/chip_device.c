/* The whole device without a board: the app and the core of the image that ships for the i.MX RT1062, in the
 * memories of that board (chip.ld). The program `chip` (tools/chip) calls these functions in an emulated
 * Cortex-M7, and exchanges bytes with the app through two buffers. */
#include "firmware/app/app_internal.h"

#include <string.h>

enum {
    CHIP_IN_BYTES = 1 << 17,
    CHIP_OUT_BYTES = 1 << 18,
    CHIP_SLOT_BYTES = 4 << 20,
    CHIP_NEAR_BYTES = 372 << 10
};

static crn_app app __attribute__((section(".hot"), aligned(8)));
uint8_t chip_slots[2][CHIP_SLOT_BYTES] __attribute__((section(".scenes"), aligned(32)));
static crn_instrument tool_table[CRN_TABLE_MAX] __attribute__((section(".near"), aligned(32)));
static uint8_t near_memory[CHIP_NEAR_BYTES] __attribute__((section(".near"), aligned(32)));
uint8_t chip_in[CHIP_IN_BYTES] __attribute__((section(".host"), aligned(8)));
uint8_t chip_out[CHIP_OUT_BYTES] __attribute__((section(".host"), aligned(8)));
uint32_t chip_out_count;
static uint32_t time_us;

void chip_start(void);
void chip_receive(uint32_t count);
uint32_t chip_restore(void);
uint32_t chip_nodes(void);
uint32_t chip_positions(void);
uint32_t chip_estimate(void);

static size_t transmit_room(void *context)
{
    (void)context;
    return sizeof chip_out - chip_out_count;
}

static bool transmit(void *context, const uint8_t *frame, size_t frame_bytes)
{
    if (frame_bytes > transmit_room(context)) return false;
    memcpy(chip_out + chip_out_count, frame, frame_bytes);
    chip_out_count += (uint32_t)frame_bytes;
    return true;
}

static bool inputs(void *context, crn_port_inputs *readings)
{
    (void)context;
    (void)readings;
    return false; /* no rig: the host sends the hands */
}

static void outputs(void *context, const crn_port_outputs *values)
{
    (void)context;
    (void)values;
}

static uint32_t now_us(void *context)
{
    (void)context;
    return time_us;
}

static const crn_port port = {
    .tool_table = tool_table,
    .transmit = transmit,
    .transmit_room = transmit_room,
    .inputs = inputs,
    .outputs = outputs,
    .now_us = now_us,
    .serial = "chip",
    .scene_slots = {chip_slots[0], chip_slots[1]},
    .scene_slot_bytes = CHIP_SLOT_BYTES,
    .scene_large_bytes = 2 * CHIP_SLOT_BYTES,
    .near_memory = near_memory,
    .near_bytes = CHIP_NEAR_BYTES,
};

void chip_start(void)
{
    crn_app_init(&app, &port);
}

/* Gives the app the first bytes of chip_in; what it answers lies in chip_out. */
void chip_receive(uint32_t count)
{
    crn_app_receive(&app, chip_in, count);
}

/* Sets the running session to the snapshot in chip_in; returns 0 when the app refuses it. */
uint32_t chip_restore(void)
{
    return crn_app_snapshot_put(&app, chip_in);
}

/* The nodes and positions from which the app estimates the cycles of a tick, and its estimate
 * (firmware/app/app_budget.c). */
uint32_t chip_nodes(void)
{
    return crn_app_load_of(&app).nodes;
}

uint32_t chip_positions(void)
{
    return crn_app_load_of(&app).positions;
}

uint32_t chip_estimate(void)
{
    const crn_app_load load = crn_app_load_of(&app);
    return crn_app_load_cycles(&load);
}
