/* This program is the device on ARM's MPS2 board (AN500, Cortex-M7) with an emulated rig. The file contains
 * the memory, the port's table of functions, and the loop that passes bytes and timer edges to the app. The
 * code of this file allocates no memory, and its interrupt handlers only increment counters.
 *
 *   loop:  bytes came -> crn_app_receive     USB tokens -> crn_rig_usb_poll     an edge is due -> crn_app_timer
 *
 * One round of the main loop handles at most one block of bytes from the host and one timer edge, so neither
 * kind of work delays the other indefinitely. */
#include "firmware/app/app.h"
#include "firmware/port/mailbox/mailbox_udc.h"
#include "firmware/port/mps2_an500/device/device.h"
#include "firmware/port/usb/rig_usb.h"

static crn_app app __attribute__((section(".hot"), aligned(8)));
static crn_mailbox_udc controller;
static crn_rig_usb usb;
static bool usb_has_more; /* the next round has work even without a demand of the host */
static uint8_t slots[2][RIG_SLOT_BYTES] __attribute__((section(".scenes"), aligned(8)));
static char serial[CRN_PORT_SERIAL_BYTES + 1] = "AN500-0001";

static bool has_worked; /* work was done since the watchdog was fed */
enum {
    LOOK_EVERY_rounds = 65536
}; /* an idle round takes some 50 instructions; the watchdog waits for 1.5 x 10^9 cycles */

static uint32_t now_us(void *context)
{
    (void)context;
    return clock_us();
}

/* A host that has configured the device by USB controls the device, even while the USB bus sleeps. Without a
 * host on the USB, the device sends and receives through the ring buffers in the memory page of the emulated
 * rig. A program that uses the ring buffers instead of the USB can count the instructions of the device. */
static bool transmit(void *context, const uint8_t *frame, size_t frame_bytes)
{
    return crn_rig_usb_is_configured(&usb) ? crn_rig_usb_transmit(context, frame, frame_bytes)
                                           : pipe_transmit(context, frame, frame_bytes);
}

static size_t transmit_room(void *context)
{
    return crn_rig_usb_is_configured(&usb) ? crn_rig_usb_room(context) : pipe_room(context);
}

static crn_instrument tool_table[CRN_TABLE_MAX];

static crn_port port = {
    .tool_table = tool_table,
    .context = &usb,
    .transmit = transmit,
    .transmit_room = transmit_room,
    .inputs = rig_inputs_read,
    .outputs = rig_outputs_write,
    .now_us = now_us,
    .serial = serial,
    .scene_slots = {slots[0], slots[1]},
    .scene_slot_bytes = RIG_SLOT_BYTES,
    .built = {.damping_mN_s_per_m = 1000, .damping_nN_m_s_per_rad = 2000}, /* of hil_tests/plant */
};

_Static_assert((int)RIG_TRACK_COUNT == (int)CRN_PORT_TOOL_MAX &&
                   (int)RIG_SERIAL_BYTES == (int)CRN_PORT_SERIAL_BYTES,
               "page and port agree");

/* Returns the serial number of the emulated device, if the program that started the emulator has set one. */
static void take_serial(void)
{
    if (!rig_is_there() || rig->host.serial[0] == '\0') return;
    for (int i = 0; i < RIG_SERIAL_BYTES; i++) {
        char letter = rig->host.serial[i];
        serial[i] = letter == '\0' || (letter > ' ' && letter <= '~') ? letter : '?';
    }
}

static void tell_crash(void)
{
    rig_crash *crash = &rig->device.crash;
    if (crash->exception == 0) return;
    console_number("the last start ended by exception ", crash->exception);
    console_hex(" at pc 0x", crash->pc, 8);
    console_text(crash->exception == 2 ? ": watchdog\n" : "\n");
}

static void greet(void)
{
    console_number("cournand on mps2_an500: core ", CRN_CORE_VERSION);
    console_number(", protocol ", CRN_WIRE_PROTOCOL_MAJOR);
    console_number(".", CRN_WIRE_PROTOCOL_MINOR);
    console_hex(", schema ", crn_wire_schema_hash(), 16);
    console_text(", serial ");
    console_text(serial);
    console_number("\napp ", sizeof app);
    console_number(" bytes, two scene slots of ", RIG_SLOT_BYTES);
    console_number(" bytes, start ", rig->device.boot_count);
    console_text(rig_is_there() ? ", with a rig\n" : ", without a rig\n");
    tell_crash();
}

/* Ends the time measurement of the device's work on bytes that the host sent. */
static void end_receiving(uint32_t begin)
{
    rig_write(&rig->device.receive_counts, rig->device.receive_counts + (clock_counts() - begin));
    rig_write(&rig->device.clock_us, clock_us());
    has_worked = true;
    usb_has_more = true; /* the app's reply */
}

static void receive(void)
{
    const uint8_t *bytes;
    size_t count = pipe_received(&bytes);
    if (count == 0) return;
    uint32_t begin = clock_work_begin();
    crn_app_receive(&app, bytes, count);
    end_receiving(begin);
    pipe_release(count);
}

/* Only bytes that reached the app count as work, because a host's polls for data that are not ready do not
 * concern the rig's model (the plant). The loop reads the clock only if there may be work for the device. In
 * an emulator, one reading of the clock takes longer than everything else in a round of the loop.
 */
static void poll_usb(void)
{
    const crn_mailbox_demand demand = crn_mailbox_udc_demand(&controller);
    if (demand == CRN_MAILBOX_IDLE && !usb_has_more) return;
    const bool may_work = usb_has_more || demand == CRN_MAILBOX_BRINGS_WORK;
    const uint32_t works = usb.works;
    uint32_t begin = may_work ? clock_work_begin() : 0;
    usb_has_more = crn_rig_usb_poll(&usb);
    if (usb.works != works) end_receiving(may_work ? begin : clock_work_begin());
}

static void tick(void)
{
    if (clock_edges_due() == 0) return;
    clock_edge_begin();
    uint32_t begin = clock_counts();
    crn_app_timer(&app);
    crn_rig_usb_timer(&usb);
    usb_has_more = true; /* a report, and the app's messages */
    uint32_t counts = clock_counts() - begin;
    rig_write(&rig->device.clock_us, clock_us());
    rig_write(&rig->device.edge_counts, counts);
    if (counts > rig->device.edge_counts_max) rig_write(&rig->device.edge_counts_max, counts);
    rig_write(&rig->device.stack_free, stack_free());
    clock_edge_done();
}

/* Only timer edges that the app has completed reset the watchdog. If the timer has stopped, neither a running
 * main loop nor a host that keeps sending bytes can reset the watchdog. The watchdog is also reset while the
 * device waits for the next millisecond of the rig's model (the plant). */
static void feed_watchdog(uint32_t round)
{
    static uint32_t fed;
    const bool looks = has_worked || round % LOOK_EVERY_rounds == 0;
    if (app.edges_done == fed && !(looks && clock_waits_for_plant())) return;
    fed = app.edges_done;
    has_worked = false;
    clock_feed_watchdog();
}

int main(void)
{
    rig_outputs_off();
    console_start();
    rig_write(&rig->device.magic, 0);
    take_serial();
    if (rig_is_there()) port.capabilities = CRN_WIRE_CAPABILITY_ENCODERS | CRN_WIRE_CAPABILITY_MOTORS;
    rig->device.version = RIG_VERSION;
    rig->device.app_bytes = sizeof app;
    rig->device.edge_counts = rig->device.edge_counts_max = 0;
    rig_write(&rig->device.boot_count, rig->device.boot_count + 1);
    greet();
    pipe_start();
    crn_app_init(&app, &port);
    crn_mailbox_udc_init(&controller, (crn_mailbox *)RIG_MEMORY_ADDRESS, true);
    bool has_usb = crn_rig_usb_init(&usb, &app, &controller.udc);
    console_text(has_usb ? "USB: on the bus\n" : "USB: off, the serial is not printable\n");
    crn_rig_usb_connect(&usb, has_usb);
    clock_start();
    rig_write(&rig->device.magic, RIG_MAGIC);
    for (uint32_t round = 0;; round++) {
        receive();
        poll_usb();
        tick();
        feed_watchdog(round);
    }
}
