/* This port has never run on hardware. This program is the device on an i.MX RT1062 (Teensy 4.1). The file
 * contains the memory, the port's table of functions, and the loop that passes bytes and timer edges to the
 * app. The code of this file allocates no memory, and its only interrupt handler increments a counter.
 *
 *   loop:  USB -> crn_app_receive
 *          an edge is due -> crn_app_timer (reads inputs, writes outputs), then the state report
 *
 * One round of the main loop handles at most a few packets and one timer edge, so neither kind of work delays
 * the other indefinitely. */
#include "firmware/port/imxrt1062/board.h"
#include "firmware/port/usb/rig_usb.h"

static crn_app app __attribute__((section(".hot"), aligned(8)));
static crn_rig_usb usb __attribute__((section(".dma"), aligned(32)));
static uint8_t slots[2][BOARD_SLOT_BYTES] __attribute__((section(".scenes"), aligned(32)));
static crn_instrument tool_table[CRN_TABLE_MAX] __attribute__((section(".near"), aligned(32)));
static uint8_t near_memory[BOARD_NEAR_BYTES] __attribute__((section(".near"), aligned(32)));
static char serial[BOARD_SERIAL_BYTES + 1];
_Static_assert((int)BOARD_SERIAL_BYTES == (int)CRN_PORT_SERIAL_BYTES, "the serial fits");

static struct {
    uint32_t tick_cycles_max; /* for a debugger: the longest tick */
} seen;

static crn_port port = {
    .context = &usb,
    .tool_table = tool_table,
    .transmit = crn_rig_usb_transmit,
    .transmit_room = crn_rig_usb_room,
    .inputs = rig_inputs,
    .outputs = rig_outputs,
    .now_us = clocks_now_us,
    .serial = serial,
    .scene_slots = {slots[0], slots[1]},
    .near_memory = near_memory,
    .near_bytes = BOARD_NEAR_BYTES,
    .tick_cycles = BOARD_CLOCK_HZ / 1000,
    .capabilities = CRN_WIRE_CAPABILITY_ENCODERS | CRN_WIRE_CAPABILITY_MOTORS,
    .force_uN_per_count = BOARD_FORCE_uN_per_count,
    .built = {.translation_pm_per_count = BOARD_TRANSLATION_pm_per_count,
              .rotation_counts_per_turn = BOARD_ROTATION_counts_per_turn,
              .damping_mN_s_per_m = BOARD_DAMPING_mN_s_per_m,
              .damping_nN_m_s_per_rad = BOARD_DAMPING_nN_m_s_per_rad,
              .actuator_lag_us = BOARD_ACTUATOR_LAG_us,
              .options = BOARD_OPTIONS},
};

static void greet(bool has_scenes)
{
    console_number("cournand on imxrt1062: core ", CRN_CORE_VERSION);
    console_number(", protocol ", CRN_WIRE_PROTOCOL_MAJOR);
    console_number(".", CRN_WIRE_PROTOCOL_MINOR);
    console_text(", serial ");
    console_text(serial);
    console_text(has_scenes ? "\n"
                            : "\nno PSRAM answers: scenes cannot be loaded; solder one, docs/porting.md\n");
    if (clocks_was_watchdog()) console_text("the last start ended by the watchdog\n");
}

/* Handles broken hardware: the function reports the fault, keeps all outputs off, and lets the watchdog
 * restart the device. */
static void give_up(const char *what)
{
    rig_outputs_off();
    console_text(what);
    for (;;) {
    }
}

static void tick(void)
{
    if (clocks_edges_due() == 0) return;
    uint32_t begin = clocks_cycles();
    crn_app_timer(&app);
    const int32_t difference = clock_check(clocks_edges(), usb_udc_frame());
    if (difference != 0) crn_app_port_error(&app, difference);
    crn_rig_usb_timer(&usb);
    uint32_t cycles = clocks_cycles() - begin;
    if (cycles > seen.tick_cycles_max) seen.tick_cycles_max = cycles;
    clocks_edge_done();
}

/* Only timer edges that the app has completed reset the watchdog. If the timer has stopped, neither a running
 * main loop nor a host that keeps sending bytes can reset the watchdog. */
/* Requirement: SR-21 */
static void feed_watchdog(void)
{
    static uint32_t fed;
    if (app.edges_done == fed) return;
    fed = app.edges_done;
    clocks_feed_watchdog();
}

int main(void)
{
    bool has_clock = clocks_start(); /* enables the clocks of everything below */
    pins_start();
    console_start();
    if (!has_clock) give_up("the processor's clock does not lock\n");
    bool has_scenes = scene_ram_start();
    memory_map_start();
    port.scene_slot_bytes = has_scenes ? BOARD_SLOT_BYTES : 0;
    port.scene_large_bytes = 2 * port.scene_slot_bytes;
    clocks_serial(serial);
    encoders_start();
    sensors_start();
    motors_start();
    greet(has_scenes);
    if (!usb_phy_start()) give_up("the USB clock does not lock\n");
    const crn_udc *udc = usb_udc_start();
    if (udc == NULL) give_up("the USB controller stays in reset\n");
    crn_app_init(&app, &port);
    if (!crn_rig_usb_init(&usb, &app, udc)) give_up("the serial number is not printable\n");
    crn_rig_usb_connect(&usb, true);
    clocks_start_tick();
    for (;;) {
        (void)crn_rig_usb_poll(&usb);
        tick();
        feed_watchdog();
    }
}
