/* Never run on hardware. What the files of this port share, and what a builder sets for his rig.
 *
 *   boot_header.c  what the processor's ROM reads from the flash     start.c    reset, memory, vectors, exceptions
 *   memory_map.c   caches and protection                             clocks.c   600 MHz, tick, time, watchdog, serial
 *   pins.c         what every pin is                                 console.c  text on LPUART6
 *   scene_ram.c    the PSRAM for scenes                              usb_phy.c, usb_udc.c   the USB controller
 *   encoders.c     quadrature decoders                               sensors.c  ADC
 *   motors.c       PWM and its fault input                           rig.c      port inputs and outputs
 *   main.c         memory, the port's table, the loop
 */
#ifndef CRN_IMXRT1062_BOARD_H
#define CRN_IMXRT1062_BOARD_H

#include "firmware/port/port.h"
#include "firmware/port/udc.h"

/* --- of the rig: measured and set by its builder, docs/porting.md
 * ------------------------------------------------------ */
enum {
    BOARD_AXIAL_FULL_mN = 12000,    /* force of an axial motor at full duty */
    BOARD_TORQUE_FULL_uN_m = 30000, /* torque of a rotation motor at full duty */
    BOARD_CURRENT_MAX_raw = 3000,   /* of a track's current sensor: over this is over-current */
    BOARD_SUPPLY_MIN_raw = 2400,    /* of the supply's divider: the motors' supply is good between these */
    BOARD_SUPPLY_MAX_raw = 3500,
    BOARD_SENSOR_MIN_raw = 100, /* of force and pressure sensors: outside is a broken cable */
    BOARD_SENSOR_MAX_raw = 3995,
    BOARD_FORCE_ZERO_raw = 2048,     /* counts that are subtracted; the exact zero comes by calibration */
    BOARD_FORCE_uN_per_count = 9766, /* 20 N at full scale; a host corrects it by a quarter at most */
    BOARD_TRANSLATION_pm_per_count = 1000000, /* likewise */
    BOARD_ROTATION_counts_per_turn = 65536,
    BOARD_OPTIONS = 0, /* CRN_WIRE_OPTION_*: which encoders count the other way */
    BOARD_DAMPING_mN_s_per_m =
        0, /* own damping as measured, the least of the tracks: hosts state more only with */
    BOARD_DAMPING_nN_m_s_per_rad = 0, /* the local unlock; 0, not measured: no coupling without the unlock */
    BOARD_ACTUATOR_LAG_us = 2000,     /* the longest of the tracks: hosts state less only with the unlock */
    BOARD_DEBOUNCE_ticks = 5,
    BOARD_STOP_RELEASE_ticks = 50, /* an emergency stop counts at once; its release only after this */
};

/* --- of the board
 * ----------------------------------------------------------------------------------------------------------
 */
enum {
    BOARD_CLOCK_HZ = 600000000,
    BOARD_PERIPHERAL_HZ = 150000000, /* of PWM, decoders, ADC */
    BOARD_CRYSTAL_HZ = 24000000,     /* of tick, time, console */
    BOARD_WAIT_MAX = 1000000, /* turns of a loop that waits for the hardware at start-up: then it is broken */
    BOARD_SLOT_BYTES = 4 << 20, /* of one scene in the PSRAM */
    BOARD_SERIAL_BYTES = 24,
};

int main(void);

/* Waits for `register & mask` to become `value`; false: it did not. Start-up only. */
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
bool clocks_start(void); /* false: a PLL does not lock; the rig must not run */
void clocks_start_tick(void);
void clocks_tick(void);          /* the interrupt */
uint32_t clocks_edges_due(void); /* milliseconds that have begun and are not done */
void clocks_edge_done(void);
uint32_t clocks_now_us(void *context);
uint32_t clocks_cycles(void); /* of the processor; wraps after 7 s */
void clocks_feed_watchdog(void);
bool clocks_was_watchdog(void); /* the last reset came from a watchdog */
void clocks_serial(char serial[BOARD_SERIAL_BYTES + 1]);

/* pins.c */
void pins_start(void);

/* console.c */
void console_start(void);
void console_text(const char *text);
void console_number(const char *name, uint32_t value);
void console_hex(const char *name, uint32_t value);

/* scene_ram.c */
bool scene_ram_start(void); /* false: there is none */

/* usb_phy.c, usb_udc.c */
bool usb_phy_start(void);
const crn_udc *usb_udc_start(void);

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
void motors_off(void);   /* from any state of the processor */
bool motors_fault(void); /* the fault input has turned the outputs off since the last motors_clear_fault */
void motors_clear_fault(void); /* no effect while the input still says so */

/* rig.c */
bool rig_inputs(void *context, crn_port_inputs *inputs);
void rig_outputs(void *context, const crn_port_outputs *outputs);
void rig_outputs_off(void); /* from any state of the processor */

#endif
