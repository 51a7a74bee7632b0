/* This header describes the emulated rig as one page of shared memory with encoders, sensors, switches,
 * motors and the pipe of bytes. The device's program uses the page as registers; outside the emulator, a
 * model of the rig (the plant) fills and reads the page.
 *
 *   0x60000000  64 KiB   USB tokens (shared/mailbox)
 *   0x60010000   4 KiB   rig_device_half, written by the device only
 *   0x60011000   4 KiB   rig_host_half, written by the plant only
 *   0x60020000  64 KiB   bytes to the device    0x60030000  64 KiB  bytes to the host
 *   0x60040000  two scene slots
 *
 * All fields of the rig page are little-endian 32-bit words. Some words of the page announce that other words
 * are new: `edge`, `edge_done`, the heads and tails of the rings, and the magic numbers. The functions
 * rig_write() and rig_read() write the announcing words with release semantics and read them with acquire
 * semantics. The device and the plant (the model of the rig) do not trust each other's half of the page: a
 * number out of its range is treated as a broken sensor.
 *
 * The plant makes the milliseconds. The plant (the model of the rig) fills its inputs, then increments
 * `edge`; the device runs the tick, writes its outputs and repeats the number in `edge_done`. A program that
 * runs the plant and the device alternately simulates the rig independently of real time.
 *
 * C11 and C++20 (gcc, clang). */
#ifndef CRN_RIG_PAGE_H
#define CRN_RIG_PAGE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#define RIG_MEMORY_ADDRESS 0x60000000u /* address of the memory that a file backs */

enum {
    RIG_MEMORY_BYTES = 16 << 20,
    RIG_PAGE_OFFSET = 0x10000,
    RIG_PAGE_BYTES = 0x30000,
    RIG_HOST_OFFSET = 0x1000, /* in the page */
    RIG_RING_BYTES = 0x10000, /* a power of 2 */
    RIG_SLOTS_OFFSET = RIG_PAGE_OFFSET + RIG_PAGE_BYTES,
    RIG_SLOT_BYTES = (RIG_MEMORY_BYTES - RIG_SLOTS_OFFSET) / 2,

    RIG_MAGIC = 0x31474952, /* "RIG1" */
    RIG_VERSION = 1,
    RIG_TRACK_COUNT = 3,
    RIG_SERIAL_BYTES = 24,
    RIG_INPUT_TRIES = 8, /* a sample that is being written is read again */
    RIG_CLOCK_HZ = 25000000,
};

/* The source of milliseconds. */
typedef enum rig_tick_source {
    RIG_TICK_TIMER = 0, /* the board's own timer */
    RIG_TICK_PLANT = 1, /* `edge` */
} rig_tick_source;

/* Bits of rig_inputs.switches. */
enum {
    RIG_EMERGENCY_STOP = 1,
    RIG_SUPPLY_GOOD = 2,
    RIG_STAGE_ON = 4,
    RIG_LOCAL_UNLOCK = 8,
};

typedef struct rig_track_inputs {
    uint32_t translation_counts, rotation_counts;               /* two's complement, may wrap */
    uint32_t force_raw;                                         /* two's complement */
    uint32_t translation_sensor, rotation_sensor, force_sensor; /* CRN_PORT_SENSOR_* */
    uint32_t over_current;
} rig_track_inputs;

typedef struct rig_inputs {
    rig_track_inputs tracks[RIG_TRACK_COUNT];
    uint32_t syringe_counts, syringe_sensor;
    uint32_t inflator_raw, inflator_sensor;
    uint32_t buttons;
    uint32_t switches;
} rig_inputs;

typedef struct rig_outputs {
    uint32_t axial_mN[RIG_TRACK_COUNT], torque_uN_m[RIG_TRACK_COUNT]; /* two's complement */
    uint32_t drive;                                                   /* level of the drive line */
    uint32_t enable;
    uint32_t lamp;
} rig_outputs;

/* Record of an exception. The record of an exception survives a reset; after the reset, the console prints
 * this record. */
typedef struct rig_crash {
    uint32_t exception; /* number, 2: watchdog, 3: hard fault; 0: none */
    uint32_t pc, lr, status, address;
} rig_crash;

typedef struct rig_device_half {
    uint32_t magic; /* written last at power-up */
    uint32_t version;
    uint32_t boot_count; /* a new number means that the device restarted and has lost its history */
    uint32_t app_bytes;
    uint32_t edge_done;
    uint32_t to_device_tail, to_host_head; /* counts of bytes; wrap */
    /* The fields receive_counts, edge_counts and edge_counts_max contain the processor time that the device's
     * work took, in counts of RIG_CLOCK_HZ; with -icount shift=7 an instruction takes 3.2 counts. */
    uint32_t receive_counts; /* sum over all received bytes, including the work that they caused */
    uint32_t edge_counts;    /* of the last edge */
    uint32_t edge_counts_max;
    rig_outputs outputs;
    rig_crash crash;
    uint32_t clock_us; /* the device's own time at the end of its last piece of work; wraps */
    uint32_t
        stack_free; /* bytes below the stack that nothing has written since power-up, found within a second */
} rig_device_half;

typedef struct rig_host_half {
    uint32_t magic; /* 0: no rig is connected */
    uint32_t version;
    uint32_t tick_source; /* rig_tick_source */
    uint32_t edge;
    uint32_t milliseconds; /* of the rig; wraps. More than one since the last edge: the device was halted */
    uint32_t to_device_head, to_host_tail;
    uint32_t inputs_begin, inputs_end; /* equal, and still equal after reading: a complete sample */
    rig_inputs inputs;
    char serial[RIG_SERIAL_BYTES]; /* serial number of the device; empty: its own */
} rig_host_half;

typedef struct rig_page {
    rig_device_half device;
    uint8_t gap1[RIG_HOST_OFFSET - sizeof(rig_device_half)];
    rig_host_half host;
    uint8_t gap2[0x10000 - RIG_HOST_OFFSET - sizeof(rig_host_half)];
    uint8_t to_device[RIG_RING_BYTES];
    uint8_t to_host[RIG_RING_BYTES];
} rig_page;

#ifdef __cplusplus
static_assert(sizeof(rig_page) == RIG_PAGE_BYTES, "the page fills its place");
#else
_Static_assert(sizeof(rig_page) == RIG_PAGE_BYTES, "the page fills its place");
#endif

/* Reads a word that the other side writes; the processor makes no later read before this one. */
static inline uint32_t rig_read(const uint32_t *word)
{
    return __atomic_load_n(word, __ATOMIC_ACQUIRE);
}

/* Writes a word of this side's half of the page; the processor makes this write after all earlier writes. */
static inline void rig_write(uint32_t *word, uint32_t value)
{
    __atomic_store_n(word, value, __ATOMIC_RELEASE);
}

#endif
