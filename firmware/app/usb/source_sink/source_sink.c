/* What the endpoints do in the images for Linux' test module usbtest (docs/usb.md, "The kernel's own judge").
 * In these images this file is linked in place of usb_hid.c, usb_stream.c and usb_vendor.c, and the table of
 * this folder in place of usb_table.def. All other files of the stack are those of the shipped images. No
 * shipped image contains anything of this folder.
 *
 *   IN endpoints      a source: full packets of the pattern
 *   OUT endpoints     a sink: it compares every packet with the pattern, and halts at the first wrong byte
 *   endpoint 0        0x5b writes up to 256 bytes, 0x5c reads them back, 0x5d chooses the pattern (wValue) and
 *                     clears the count of the sinks' bytes, which 0x5e reads (4 bytes)
 *
 * Byte i of a packet is 0 (pattern 0) or i mod 63 (pattern 1), as in usbtest. The bulk transfers given to the
 * controller are 1 to 8 packets long by turns, so that their ends fall anywhere in the host's transfers. */
#include "firmware/app/usb/usb_internal.h"

enum {
    REQUEST_WRITE = 0x5b, /* these two are those of Intel's compliance device */
    REQUEST_READ = 0x5c,
    REQUEST_PATTERN = 0x5d,
    REQUEST_RECEIVED = 0x5e,
    PATTERN_MAX = 1,
    PATTERN_PERIOD = 63,
    SOURCE_PACKETS_MAX = 8,
    SINK_PACKETS_MAX = 4,
    ALIGNMENT = 32, /* of the controller's buffers */
};

/* Lies in the memory of the queue to the host, which a port has put where its controller can read and
 * write. */
typedef struct workshop {
    _Alignas(ALIGNMENT) uint8_t source[SOURCE_PACKETS_MAX * CRN_USB_STREAM_PACKET];
    _Alignas(ALIGNMENT) uint8_t sink[SINK_PACKETS_MAX * CRN_USB_STREAM_PACKET];
    uint8_t written[CRN_USB_CONTROL_BYTES];
    uint32_t written_bytes;
    uint32_t source_turn, sink_turn;
    uint32_t received_bytes;
    uint8_t pattern;
} workshop;

static workshop *workshop_of(const crn_usb *usb)
{
    const uintptr_t begin = (uintptr_t)usb->config.queue + ALIGNMENT - 1;
    return (workshop *)(begin - begin % ALIGNMENT);
}

static bool has_workshop(const crn_usb *usb)
{
    return usb->config.queue_bytes >= sizeof(workshop) + ALIGNMENT;
}

static uint32_t bulk_packet_bytes(const crn_usb *usb)
{
    return crn_usb_endpoints[CRN_USB_STREAM_IN].packet_bytes[usb->speed];
}

static uint8_t pattern_byte(const workshop *shop, uint32_t place_in_packet)
{
    return shop->pattern == 0 ? 0 : (uint8_t)(place_in_packet % PATTERN_PERIOD);
}

/* --- source --- */
static void fill_source(crn_usb *usb)
{
    workshop *shop = workshop_of(usb);
    const uint32_t packet_bytes = bulk_packet_bytes(usb);
    for (uint32_t i = 0; i < sizeof shop->source; i++) shop->source[i] = pattern_byte(shop, i % packet_bytes);
}

void crn_usb_stream_begin(crn_usb *usb, bool to_host)
{
    usb->queue_begin = usb->queue_count = usb->sending = usb->held_begin = usb->held_end = 0;
    if (to_host && has_workshop(usb)) fill_source(usb);
}

void crn_usb_stream_send(crn_usb *usb)
{
    if (!has_workshop(usb) || !crn_usb_pipe_is_free(usb, CRN_USB_STREAM_IN)) return;
    workshop *shop = workshop_of(usb);
    const uint32_t packets = 1 + shop->source_turn++ % SOURCE_PACKETS_MAX;
    crn_usb_pipe_arm(usb, CRN_USB_STREAM_IN, shop->source, packets * bulk_packet_bytes(usb));
}

void crn_usb_stream_sent(crn_usb *usb, uint32_t bytes)
{
    (void)usb;
    (void)bytes;
}

/* A packet of an interrupt endpoint has 64 bytes, and the bulk packets' pattern begins with the same ones. */
void crn_usb_hid_send(crn_usb *usb)
{
    if (!has_workshop(usb) || !crn_usb_pipe_is_free(usb, CRN_USB_STATUS_IN)) return;
    crn_usb_pipe_arm(usb, CRN_USB_STATUS_IN, workshop_of(usb)->source,
                     crn_usb_endpoints[CRN_USB_STATUS_IN].packet_bytes[usb->speed]);
}

void crn_usb_hid_begin(crn_usb *usb)
{
    (void)usb;
}

void crn_usb_hid_queue(crn_usb *usb, const crn_hid_state *state)
{
    usb->state = *state;
}

/* --- sink --- */
static bool is_pattern(const workshop *shop, const uint8_t *bytes, uint32_t count, uint32_t packet_bytes)
{
    for (uint32_t i = 0; i < count; i++)
        if (bytes[i] != pattern_byte(shop, i % packet_bytes)) return false;
    return true;
}

void crn_usb_stream_received(crn_usb *usb, uint32_t bytes)
{
    workshop *shop = workshop_of(usb);
    shop->received_bytes += bytes;
    if (!is_pattern(shop, shop->sink, bytes, bulk_packet_bytes(usb)))
        crn_usb_pipe_halt(usb, CRN_USB_STREAM_OUT);
}

bool crn_usb_stream_deliver(crn_usb *usb)
{
    if (!has_workshop(usb) || !crn_usb_pipe_is_free(usb, CRN_USB_STREAM_OUT)) return false;
    workshop *shop = workshop_of(usb);
    const uint32_t packets = 1 + shop->sink_turn++ % SINK_PACKETS_MAX;
    crn_usb_pipe_arm(usb, CRN_USB_STREAM_OUT, shop->sink, packets * bulk_packet_bytes(usb));
    return false;
}

void crn_usb_hid_received(crn_usb *usb, uint32_t bytes)
{
    const uint32_t packet_bytes = crn_usb_endpoints[CRN_USB_STATUS_OUT].packet_bytes[usb->speed];
    workshop_of(usb)->received_bytes += bytes;
    if (is_pattern(workshop_of(usb), usb->report_out, bytes, packet_bytes))
        crn_usb_pipe_arm(usb, CRN_USB_STATUS_OUT, usb->report_out, sizeof usb->report_out);
    else
        crn_usb_pipe_halt(usb, CRN_USB_STATUS_OUT);
}

/* --- endpoint 0 --- */
bool crn_usb_hid_takes(const crn_usb *usb, const crn_usb_setup *setup)
{
    return has_workshop(usb) && setup->type == (CRN_USB_TYPE_VENDOR | CRN_USB_TO_DEVICE) &&
           setup->request == REQUEST_WRITE && setup->value == 0 && setup->index == 0;
}

bool crn_usb_hid_data(crn_usb *usb, const crn_usb_setup *setup, const uint8_t *bytes, size_t count)
{
    workshop *shop = workshop_of(usb);
    (void)setup;
    for (size_t i = 0; i < count; i++) shop->written[i] = bytes[i];
    shop->written_bytes = (uint32_t)count;
    return true;
}

static bool choose_pattern(crn_usb *usb, const crn_usb_setup *setup)
{
    if (setup->value > PATTERN_MAX || setup->length != 0) return false;
    workshop_of(usb)->pattern = (uint8_t)setup->value;
    workshop_of(usb)->received_bytes = 0;
    fill_source(usb);
    return true;
}

bool crn_usb_vendor(crn_usb *usb, const crn_usb_setup *setup, crn_wire_writer *reply)
{
    const uint8_t to_device = CRN_USB_TYPE_VENDOR | CRN_USB_TO_DEVICE;
    if (!has_workshop(usb) || setup->index != 0) return false;
    const workshop *shop = workshop_of(usb);
    if (setup->type == to_device && setup->request == REQUEST_PATTERN) return choose_pattern(usb, setup);
    if (setup->value != 0) return false;
    if (setup->type == to_device && setup->request == REQUEST_WRITE) /* 0 bytes */
        return crn_usb_hid_data(usb, setup, NULL, 0);
    if (setup->type != (to_device | CRN_USB_TYPE_IN)) return false;
    if (setup->request == REQUEST_RECEIVED) {
        crn_wire_write(reply, shop->received_bytes, 4);
        return true;
    }
    if (setup->request != REQUEST_READ) return false;
    crn_usb_put_bytes(reply, shop->written, shop->written_bytes);
    return true;
}

/* --- what the rig's functions offer and these do not --- */
bool crn_usb_hid_request(crn_usb *usb, const crn_usb_setup *setup, crn_wire_writer *reply)
{
    (void)usb;
    (void)setup;
    (void)reply;
    return false;
}

void crn_usb_hid_put_descriptor(crn_wire_writer *reply)
{
    (void)reply;
}

bool crn_usb_hid_class_descriptor(const crn_usb_setup *setup, crn_wire_writer *reply)
{
    (void)setup;
    (void)reply;
    return false;
}

uint32_t crn_usb_queue_room(const crn_usb *usb)
{
    (void)usb;
    return 0;
}

bool crn_usb_transmit(crn_usb *usb, const uint8_t *frame, size_t frame_bytes)
{
    (void)usb;
    (void)frame;
    (void)frame_bytes;
    return false;
}
