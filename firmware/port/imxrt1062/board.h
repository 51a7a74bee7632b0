/* This port has never run on hardware. This header has declarations that the files of this port share, and
 * values that a builder sets for their rig.
 *
 *   boot_header.c  what the processor's ROM reads from the flash     start.c    reset, memory, vectors, exceptions
 *   self_test.c    memories and image before anything else
 *   memory_map.c   caches and protection                             clocks.c   600 MHz, tick, time, watchdog, serial
 *   pins.c         what every pin is                                 console.c  text on LPUART6
 *   scene_ram.c    the PSRAM for scenes                              usb_phy.c, usb_udc.c   the USB controller
 *   clock_check.c  timer against the frames of USB
 *   encoders.c     quadrature decoders                               sensors.c  ADC
 *   motors.c       PWM and its fault input                           rig.c      port inputs and outputs
 *   main.c         memory, the port's table, the loop */
#ifndef CRN_IMXRT1062_BOARD_H
#define CRN_IMXRT1062_BOARD_H

#include "firmware/port/port.h"
#include "firmware/port/udc.h"

/* --- of the rig: measured and set by its builder, docs/porting.md --------------------------------------- */
enum {
    BOARD_AXIAL_FULL_mN = 12000,    /* force of an axial motor at full duty */
    BOARD_TORQUE_FULL_uN_m = 30000, /* torque of a rotation motor at full duty */
    /* largest force and torque that the port orders, whatever the app asks for: the limits of the hand */
    BOARD_AXIAL_MAX_mN = 8000,
    BOARD_TORQUE_MAX_uN_m = 20000,
    BOARD_CURRENT_MAX_raw = 3000, /* limit of a track's current sensor: a reading above it is over-current */
    BOARD_SUPPLY_MIN_raw = 2400,  /* range of the supply's divider in which the motors' supply is good */
    BOARD_SUPPLY_MAX_raw = 3500,
    /* range of force and pressure sensors: a reading outside means a broken cable */
    BOARD_SENSOR_MIN_raw = 100,
    BOARD_SENSOR_MAX_raw = 3995,
    BOARD_FORCE_ZERO_raw = 2048,     /* counts that are subtracted; calibration gives the exact zero */
    BOARD_FORCE_uN_per_count = 9766, /* 20 N at full scale; a host corrects it by a quarter at most */
    BOARD_TRANSLATION_pm_per_count = 1000000, /* likewise */
    BOARD_ROTATION_counts_per_turn = 65536,
    BOARD_OPTIONS = 0, /* CRN_WIRE_OPTION_*: the encoders that count in the opposite direction */
    /* measured damping of the rig itself, the least of the tracks; hosts may state more only with */
    BOARD_DAMPING_mN_s_per_m = 0,
    /* the local unlock. 0 means not measured: no coupling without the unlock */
    BOARD_DAMPING_nN_m_s_per_rad = 0,
    /* the longest lag of the tracks; hosts may state less only with the unlock */
    BOARD_ACTUATOR_LAG_us = 2000,
    BOARD_DEBOUNCE_ticks = 5,
    /* an emergency stop acts at once; its release counts only after this time */
    BOARD_STOP_RELEASE_ticks = 50,
};

/* --- of the board --------------------------------------------------------------------------------------- */
enum {
    BOARD_CLOCK_HZ = 600000000,
    BOARD_PERIPHERAL_HZ = 150000000, /* clock of PWM, decoders and ADC */
    BOARD_CRYSTAL_HZ = 24000000,     /* clock of tick, time and console */
    BOARD_WAIT_MAX = 1000000, /* iterations of a loop that waits for the hardware at start-up; more mean that
                                 it is broken */
    BOARD_SLOT_BYTES = 4 << 20,   /* size of one scene in the PSRAM; a larger one takes both slots */
    BOARD_NEAR_BYTES = 372 << 10, /* of the OCRAM, cached: parts of the scene (firmware/core/near/near.h) */
    BOARD_SERIAL_BYTES = 24,
};

int main(void);

/* Waits for `register & mask` to become `value`; returns false if this takes too long. It is for start-up
 * only. */
static inline bool board_wait(volatile uint32_t *where, uint32_t mask, uint32_t value)
{
    for (int i = 0; i < BOARD_WAIT_MAX; i++) {
        if ((*where & mask) == value) return true;
    }
    return false;
}

/* memory_map.c */
void memory_map_start(void);

/* clocks.c */
bool clocks_start(void); /* false: a PLL does not lock, and the rig must not run */
void clocks_start_tick(void);
void clocks_tick(void);          /* the interrupt */
uint32_t clocks_edges(void);     /* milliseconds that have begun */
uint32_t clocks_edges_due(void); /* milliseconds that have begun and are not processed yet */
void clocks_edge_done(void);
uint32_t clocks_now_us(void *context);
uint32_t clocks_cycles(void); /* cycles of the processor; wraps after 7 s */
void clocks_feed_watchdog(void);
bool clocks_was_watchdog(void); /* true when the last reset came from a watchdog */
void clocks_serial(char serial[BOARD_SERIAL_BYTES + 1]);

/* pins.c */
void pins_start(void);

/* self_test.c: called from the flash, before data memory is in use; the instruction memory with its code is
 * far */
#if defined(__arm__)
#define SELF_TEST_CALL __attribute__((long_call))
#else
#define SELF_TEST_CALL /* the tests of the port on the PC */
#endif
SELF_TEST_CALL uint32_t self_test_memory(void); /* address of a bad word, 0: none; erases all */
SELF_TEST_CALL uint32_t self_test_image(void);  /* difference of its CRC-32, 0: it is whole */
SELF_TEST_CALL __attribute__((noreturn)) void self_test_stop(const char *what, uint32_t value);

/* console.c */
void console_start(void);
void console_text(const char *text);
void console_number(const char *name, uint32_t value);
void console_hex(const char *name, uint32_t value);

/* scene_ram.c */
bool scene_ram_start(void); /* false: there is no PSRAM */

/* usb_phy.c, usb_udc.c */
bool usb_phy_start(void);
const crn_udc *usb_udc_start(void);
uint32_t usb_udc_frame(void); /* number of the host's last frame, 0 .. 2,047 */

/* clock_check.c: called with the edges begun and the frame's number. Not 0: frames less edges of a window,
 * which differ by more than two good clocks can */
int32_t clock_check(uint32_t edges, uint32_t frame);

/* encoders.c */
typedef struct encoders_reading {
    int32_t counts;
    uint8_t sensor; /* CRN_PORT_SENSOR_* */
} encoders_reading;
enum { ENCODERS_SYRINGE = 2 * CRN_PORT_TOOL_MAX, ENCODERS_COUNT };
void encoders_start(void);
encoders_reading encoders_read(uint32_t which); /* 2 k: translation of track k, 2 k + 1: its rotation */

/* sensors.c */
typedef struct sensors_sample {
    bool is_good; /* false: a conversion did not end, or the ADC failed its own calibration */
    uint16_t force_raw[CRN_PORT_TOOL_MAX], current_raw[CRN_PORT_TOOL_MAX], inflator_raw, supply_raw;
} sensors_sample;
void sensors_start(void);
sensors_sample sensors_read(void);

/* motors.c */
void motors_start(void);
void motors_write(const crn_port_motor motors[CRN_PORT_TOOL_MAX]);
void motors_off(void);         /* can be called in any state of the processor */
bool motors_fault(void);       /* the fault line is low, or was since the last motors_clear_fault */
void motors_clear_fault(void); /* no effect while the input still reports the fault */

/* rig.c */
bool rig_inputs(void *context, crn_port_inputs *inputs);
void rig_outputs(void *context, const crn_port_outputs *outputs);
void rig_outputs_off(void); /* can be called in any state of the processor */

#endif
