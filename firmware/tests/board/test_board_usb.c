/* This program tests the USB controller driver of the real board (firmware/port/imxrt1062/usb_udc.c) on a
 * model of the controller (board_usb_model.h). Nobody has run this driver on hardware. The tests show that a
 * host on the bus sees exactly what the USB stack requests, packet by packet, and that the host's actions
 * arrive as the events of firmware/port/udc.h. The model of the controller cannot show anything that the
 * chip's manual does not state. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "firmware/app/usb/usb.h"
#include "firmware/tests/board/board_usb_model.h"

/* --- helpers -------------------------------------------------------------------------------------------- */
static const crn_udc *udc;
static crn_udc_event event;

static bool poll(void)
{
    return udc->poll(udc->context, &event);
}

/* Powers up the controller, connects it to the bus, and lets the host reset the bus at high speed. */
static void begin(void)
{
    memset(&model, 0xa5, sizeof model); /* contents from before the reset have no meaning */
    memset(&memory, 0xa5, sizeof memory);
    memset(&controller, 0, sizeof controller);
    model.flushes_outlived = 0;
    model.next_setup = NULL;
    udc = usb_udc_start();
    assert_non_null(udc);
    udc->connect(udc->context, true);
    *cell(USB_OTGSC) = MASK(USB_OTGSC_BSV);
    host_reset_begins();
    assert_false(poll());
    host_reset_ends(SPEED_HIGH);
    assert_true(poll());
    assert_int_equal(event.kind, CRN_UDC_RESET);
    assert_int_equal(event.speed, CRN_UDC_HIGH_SPEED);
    assert_false(poll());
}

static void expect_done(uint8_t endpoint, uint32_t bytes)
{
    assert_true(poll());
    assert_int_equal(event.kind, CRN_UDC_DONE);
    assert_int_equal(event.endpoint, endpoint);
    assert_int_equal(event.bytes, bytes);
    assert_false(poll());
}

static uint8_t pattern(uint32_t i)
{
    return (uint8_t)(i * 167 + i / 251);
}

/* The test lets the transfer's buffer begin at every kind of offset in a memory page. */
static _Alignas(4096) uint8_t area[TRANSFER_BYTES_MAX + 2 * PAGE_BYTES];
static uint8_t packet[1024];
static uint32_t count;

/* --- start, reset, sleep -------------------------------------------------------------------------------- */
static void it_starts_as_a_device_that_nobody_sees(void **state)
{
    (void)state;
    memset(&model, 0, sizeof model);
    udc = usb_udc_start();
    assert_non_null(udc);
    assert_int_equal(*cell(USB_USBMODE) & MASK(USB_USBMODE_CM), BITS(USB_USBMODE_CM, MODE_DEVICE));
    assert_int_equal(*cell(USB_USBCMD) & (MASK(USB_USBCMD_RS) | MASK(USB_USBCMD_ITC)), 0);
    assert_int_equal((uintptr_t)memory.heads % 2048, 0); /* the controller's table */
    assert_int_equal(host_in(0, packet, &count), HOST_SILENT);
    udc->connect(udc->context, true);
    assert_int_equal(host_in(0, packet, &count), HOST_NAKED);
    udc->connect(udc->context, false);
    assert_int_equal(host_in(0, packet, &count), HOST_SILENT);
}

static void a_reset_voids_everything_and_tells_the_speed(void **state)
{
    (void)state;
    for (uint32_t speed = 0; speed <= SPEED_HIGH; speed += SPEED_HIGH) {
        begin();
        assert_true(udc->open(udc->context, 0x82, CRN_UDC_BULK, 512));
        udc->arm(udc->context, 0x82, area, 100);
        udc->set_address(udc->context, 77);
        assert_int_equal(*cell(USB_DEVICEADDR), 77u << 25);
        host_reset_begins();
        assert_false(poll());
        assert_int_equal(*cell(USB_DEVICEADDR), 0);
        assert_int_equal(host_in(2, packet, &count), HOST_SILENT);
        host_reset_ends(speed);
        assert_true(poll());
        assert_int_equal(event.kind, CRN_UDC_RESET);
        assert_int_equal(event.speed, speed == SPEED_HIGH ? CRN_UDC_HIGH_SPEED : CRN_UDC_FULL_SPEED);
        assert_false(poll());
    }
}

/* In this test the main loop is busy during a whole reset of the bus. */
static void a_reset_that_is_seen_late_is_one_reset(void **state)
{
    (void)state;
    begin();
    host_reset_begins();
    host_reset_ends(SPEED_HIGH);
    assert_true(poll());
    assert_int_equal(event.kind, CRN_UDC_RESET);
    assert_false(poll());
}

static void sleep_waking_and_the_cable_are_told_once(void **state)
{
    (void)state;
    begin();
    *cell(USB_PORTSC1) |= MASK(USB_PORTSC1_SUSP);
    *cell(USB_USBSTS) |= MASK(USB_USBSTS_SLI);
    assert_true(poll());
    assert_int_equal(event.kind, CRN_UDC_SUSPEND);
    assert_false(poll());
    *cell(USB_PORTSC1) &= ~MASK(USB_PORTSC1_SUSP);
    *cell(USB_USBSTS) |= MASK(USB_USBSTS_PCI);
    assert_true(poll());
    assert_int_equal(event.kind, CRN_UDC_RESUME);
    assert_false(poll());
    udc->arm(udc->context, 0, area, 64);
    *cell(USB_OTGSC) = 0;
    assert_true(poll());
    assert_int_equal(event.kind, CRN_UDC_UNPLUG);
    assert_int_equal(*cell(USB_ENDPTSTAT), 0);
    assert_false(poll());
    *cell(USB_OTGSC) = MASK(USB_OTGSC_BSV);
    assert_false(poll());
}

static void a_test_mode_is_the_ports(void **state)
{
    (void)state;
    begin();
    udc->test(udc->context, 4);
    assert_int_equal(*cell(USB_PORTSC1) & MASK(USB_PORTSC1_PTC), BITS(USB_PORTSC1_PTC, 4));
}

/* --- setup packets -------------------------------------------------------------------------------------- */
static void a_setup_packet_comes_whole_and_voids_endpoint_0(void **state)
{
    (void)state;
    static const uint8_t setup[8] = {0x80, 6, 0, 1, 0, 0, 64, 0};
    begin();
    udc->arm(udc->context, 0x80, area, 18);
    udc->arm(udc->context, 0, area, 0);
    host_setup(setup);
    assert_true(poll());
    assert_int_equal(event.kind, CRN_UDC_SETUP);
    assert_memory_equal(event.setup, setup, 8);
    assert_int_equal(*cell(USB_ENDPTSTAT), 0);
    assert_false(poll());
}

/* The bytes of a setup packet must all come from one packet; in this test the second packet comes while the
 * driver reads the first. */
static void a_setup_packet_that_another_overtakes_is_not_mixed_with_it(void **state)
{
    (void)state;
    static const uint8_t first[8] = {0x80, 6, 0, 1, 0, 0, 64, 0}, second[8] = {0x00, 5, 9, 0, 0, 0, 0, 0};
    begin();
    host_setup(first);
    model.next_setup = second;
    assert_true(poll());
    assert_memory_equal(event.setup, second, 8);
    /* A transfer that was armed for an earlier setup packet is never sent; the driver reports the last setup
     * packet. */
    udc->arm(udc->context, 0x80, area, 18);
    assert_int_equal(host_in(0, packet, &count), HOST_NAKED);
    assert_true(poll());
    assert_int_equal(event.kind, CRN_UDC_SETUP);
    assert_memory_equal(event.setup, second, 8);
    udc->arm(udc->context, 0x80, area, 0);
    assert_int_equal(host_in(0, packet, &count), HOST_ACKED);
    assert_int_equal(count, 0);
    expect_done(0x80, 0);
}

static void a_stall_of_endpoint_0_ends_with_the_next_setup_packet(void **state)
{
    (void)state;
    static const uint8_t setup[8] = {0x80, 6, 0, 1, 0, 0, 64, 0};
    begin();
    udc->arm(udc->context, 0x80, area, 18);
    udc->stall(udc->context, 0);
    assert_int_equal(host_in(0, packet, &count), HOST_STALLED);
    assert_int_equal(host_out(0, packet, 0), HOST_STALLED);
    host_setup(setup);
    assert_true(poll());
    assert_int_equal(host_in(0, packet, &count), HOST_NAKED);
    assert_int_equal(host_out(0, packet, 0), HOST_NAKED);
}

/* --- transfers ------------------------------------------------------------------------------------------ */
/* Every byte arrives, for every length and from every offset in a page, in packets of 512 bytes and a last
 * packet that is short or full. */
static void bytes_leave_as_they_lie_in_memory(void **state)
{
    (void)state;
    static const uint32_t lengths[] =
        {0, 1, 511, 512, 513, 4096, 16383, TRANSFER_BYTES_MAX, TRANSFER_BYTES_MAX + 1},
                          begins[] = {0, 1, 2048, 4095};
    begin();
    assert_true(udc->open(udc->context, 0x82, CRN_UDC_BULK, 512));
    for (uint32_t i = 0; i < sizeof area; i++) area[i] = pattern(i);
    for (size_t l = 0; l < sizeof lengths / sizeof *lengths; l++) {
        for (size_t b = 0; b < sizeof begins / sizeof *begins; b++) {
            const uint32_t length = lengths[l] < TRANSFER_BYTES_MAX ? lengths[l] : TRANSFER_BYTES_MAX;
            udc->arm(udc->context, 0x82, area + begins[b], lengths[l]);
            for (uint32_t sent = 0, end = 0; !end;) {
                assert_false(poll());
                assert_int_equal(host_in(2, packet, &count), HOST_ACKED);
                for (uint32_t i = 0; i < count; i++)
                    assert_int_equal(packet[i], pattern(begins[b] + sent + i));
                sent += count;
                end = sent == length;
            }
            assert_int_equal(host_in(2, packet, &count), HOST_NAKED);
            expect_done(0x82, length);
        }
    }
}

static void bytes_come_until_the_buffer_is_full_or_a_packet_is_short(void **state)
{
    (void)state;
    static uint8_t bytes[512];
    begin();
    assert_true(udc->open(udc->context, 2, CRN_UDC_BULK, 512));
    for (uint32_t i = 0; i < sizeof bytes; i++) bytes[i] = pattern(i);
    assert_int_equal(host_out(2, bytes, 512), HOST_NAKED);
    for (uint32_t last = 0; last <= 512; last += 256) {
        memset(area, 0, sizeof area);
        udc->arm(udc->context, 2, area + 32, 1024);
        assert_int_equal(host_out(2, bytes, 512), HOST_ACKED);
        assert_false(poll());
        assert_int_equal(host_out(2, bytes, last), HOST_ACKED);
        assert_int_equal(host_out(2, bytes, 1), HOST_NAKED);
        expect_done(2, 512 + last);
        assert_memory_equal(area + 32, bytes, 512);
        assert_memory_equal(area + 32 + 512, bytes, last);
        assert_int_equal(area[32 + 512 + last], 0);
    }
}

static void endpoints_end_in_one_poll_each_and_none_is_lost(void **state)
{
    (void)state;
    begin();
    assert_true(udc->open(udc->context, 2, CRN_UDC_BULK, 512));
    assert_true(udc->open(udc->context, 0x82, CRN_UDC_BULK, 512));
    assert_true(udc->open(udc->context, 0x81, CRN_UDC_INTERRUPT, 64));
    udc->arm(udc->context, 2, area, 512);
    udc->arm(udc->context, 0x82, area + 512, 5);
    udc->arm(udc->context, 0x81, area + 1024, 64);
    assert_int_equal(host_out(2, packet, 3), HOST_ACKED);
    assert_int_equal(host_in(2, packet, &count), HOST_ACKED);
    assert_int_equal(host_in(1, packet, &count), HOST_ACKED);
    assert_int_equal(count, 64);
    uint32_t seen = 0;
    while (poll()) seen |= bit_of(event.endpoint);
    assert_int_equal(seen, bit_of(2) | bit_of(0x82) | bit_of(0x81));
}

/* If the bus disturbs a transfer, the driver restarts it; if the host sends more bytes than requested, the
 * driver refuses the transfer permanently. */
static void a_broken_transfer_is_repeated_and_a_longer_one_stalls(void **state)
{
    (void)state;
    static uint8_t bytes[512] = {9};
    begin();
    assert_true(udc->open(udc->context, 2, CRN_UDC_BULK, 512));
    udc->arm(udc->context, 2, area, 64);
    for (uint32_t error = 1 << 3; error <= 1 << 5; error <<= 2) {
        retire(pipe_of(2), 64, error);
        assert_false(poll());
        assert_true((*cell(USB_ENDPTSTAT) & bit_of(2)) != 0);
    }
    assert_int_equal(host_out(2, bytes, 64), HOST_ACKED);
    expect_done(2, 64);
    udc->arm(udc->context, 2, area, 64);
    assert_int_equal(host_out(2, bytes, 65), HOST_ACKED);
    assert_false(poll());
    assert_int_equal(host_out(2, bytes, 64), HOST_STALLED);
}

static void an_endpoint_that_is_opened_begins_afresh(void **state)
{
    (void)state;
    begin();
    assert_false(udc->open(udc->context, 0, CRN_UDC_BULK, 64));
    assert_false(udc->open(udc->context, 8, CRN_UDC_BULK, 64));
    assert_true(udc->open(udc->context, 0x82, CRN_UDC_BULK, 512));
    udc->arm(udc->context, 0x82, area, 10);
    assert_int_equal(host_in(2, packet, &count), HOST_ACKED);
    assert_int_equal(model.toggle[5], 1);
    expect_done(0x82, 10);
    udc->arm(udc->context, 0x82, area, 10);
    udc->stall(udc->context, 0x82);
    assert_int_equal(host_in(2, packet, &count), HOST_STALLED);
    model.flushes_outlived = 2; /* a packet is still under way */
    assert_true(udc->open(udc->context, 0x82, CRN_UDC_BULK, 512));
    assert_int_equal(model.toggle[5], 0);
    assert_int_equal(host_in(2, packet, &count), HOST_NAKED);
    assert_false(poll());
    udc->close(udc->context, 0x82);
    assert_int_equal(host_in(2, packet, &count), HOST_SILENT);
}

/* If only one direction of an endpoint number is used, the other direction must not be of the type control
 * (the manual's note to ENDPTCTRL). */
static void no_half_of_an_endpoint_is_left_a_control_one(void **state)
{
    (void)state;
    begin();
    for (int in = 0; in < 2; in++) {
        assert_true(udc->open(udc->context, (uint8_t)(3 + in) | (in ? CRN_UDC_IN : 0), CRN_UDC_BULK, 512));
        const uint32_t control = *cell(USB_ENDPTCTRL0 + 4 * (3 + (uint32_t)in));
        assert_int_not_equal(control & MASK(USB_ENDPTCTRL_0_TXT), 0);
        assert_int_not_equal(control & MASK(USB_ENDPTCTRL_0_RXT), 0);
    }
}

/* --- the stack on this controller ----------------------------------------------------------------------- */
static struct device {
    crn_usb usb;
    uint8_t queue[1 << 15];
    crn_usb_link link;
} device;

static void send_back(void *context, const uint8_t *bytes, size_t length)
{
    (void)context;
    if (length > 1)
        crn_usb_transmit(&device.usb, bytes, length); /* to the app, too, a stream begins with a zero */
}

static void note_link(void *context, crn_usb_link link)
{
    (void)context;
    device.link = link;
}

static void settle(void)
{
    for (int i = 0; i < 100 && crn_usb_poll(&device.usb); i++) {
    }
}

/* Carries out a whole control transfer in which the host sends no data bytes to the device; returns the bytes
 * of the device's answer in `packet`. */
static uint32_t request(uint8_t type, uint8_t number, uint16_t value, uint16_t length)
{
    const uint8_t setup[8] = {type, number, (uint8_t)value,  (uint8_t)(value >> 8),
                              0,    0,      (uint8_t)length, (uint8_t)(length >> 8)};
    uint32_t total = 0;
    host_setup(setup);
    settle();
    while (type & CRN_UDC_IN) {
        assert_int_equal(host_in(0, packet + total, &count), HOST_ACKED);
        settle();
        total += count;
        if (count < CRN_UDC_CONTROL_PACKET_BYTES || total == length) break;
    }
    if (type & CRN_UDC_IN)
        assert_int_equal(host_out(0, NULL, 0), HOST_ACKED);
    else
        assert_int_equal(host_in(0, packet, &count), HOST_ACKED);
    settle();
    return total;
}

/* The host gives the device an address, reads its descriptors and configures it. A frame that the host sends
 * through the bulk endpoints comes back to the host, as in the test with the token mailbox (docs/usb.md). */
static void the_stack_enumerates_and_talks_on_this_controller(void **state)
{
    (void)state;
    static const crn_usb_app app = {.receive = send_back, .link = note_link};
    uint8_t frame[700], back[1024] = {0};
    begin();
    const crn_usb_config config = {.udc = udc,
                                   .app = &app,
                                   .serial = "BOARD-1",
                                   .queue = device.queue,
                                   .queue_bytes = sizeof device.queue,
                                   .reply_bytes = CRN_WIRE_FRAME_MAX};
    assert_true(crn_usb_init(&device.usb, &config));
    crn_usb_connect(&device.usb, true);
    host_reset_begins();
    settle();
    host_reset_ends(SPEED_HIGH);
    settle();
    assert_int_equal(request(0x00, 5, 11, 0), 0); /* SET_ADDRESS */
    assert_int_equal(*cell(USB_DEVICEADDR), 11u << 25);
    assert_int_equal(request(0x80, 6, 0x0100, 18), 18); /* the device */
    assert_int_equal(packet[8] | packet[9] << 8, CRN_USB_VENDOR_ID);
    const uint32_t all = request(0x80, 6, 0x0200, 512); /* the configuration fills a packet */
    assert_true(all >= CRN_UDC_CONTROL_PACKET_BYTES);
    assert_int_equal(packet[2] | packet[3] << 8, all);
    assert_int_equal(request(0x00, 9, 1, 0), 0); /* SET_CONFIGURATION */
    assert_int_equal(device.link, CRN_USB_CONFIGURED);
    memset(frame, 'x', sizeof frame);
    frame[sizeof frame - 1] = 0;
    for (uint32_t sent = 0; sent < sizeof frame; sent += 512) {
        const uint32_t left = (uint32_t)sizeof frame - sent;
        assert_int_equal(host_out(2, frame + sent, left < 512 ? left : 512), HOST_ACKED);
        settle();
    }
    uint32_t got = 0;
    while (host_in(2, packet, &count) == HOST_ACKED) {
        assert_true(got + count <= sizeof back);
        memcpy(back + got, packet, count);
        got += count;
        settle();
    }
    assert_int_equal(got, sizeof frame + 1); /* a stream begins with a zero */
    assert_int_equal(back[0], 0);
    assert_memory_equal(back + 1, frame, sizeof frame);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(it_starts_as_a_device_that_nobody_sees),
        cmocka_unit_test(a_reset_voids_everything_and_tells_the_speed),
        cmocka_unit_test(a_reset_that_is_seen_late_is_one_reset),
        cmocka_unit_test(sleep_waking_and_the_cable_are_told_once),
        cmocka_unit_test(a_test_mode_is_the_ports),
        cmocka_unit_test(a_setup_packet_comes_whole_and_voids_endpoint_0),
        cmocka_unit_test(a_setup_packet_that_another_overtakes_is_not_mixed_with_it),
        cmocka_unit_test(a_stall_of_endpoint_0_ends_with_the_next_setup_packet),
        cmocka_unit_test(bytes_leave_as_they_lie_in_memory),
        cmocka_unit_test(bytes_come_until_the_buffer_is_full_or_a_packet_is_short),
        cmocka_unit_test(endpoints_end_in_one_poll_each_and_none_is_lost),
        cmocka_unit_test(a_broken_transfer_is_repeated_and_a_longer_one_stalls),
        cmocka_unit_test(an_endpoint_that_is_opened_begins_afresh),
        cmocka_unit_test(no_half_of_an_endpoint_is_left_a_control_one),
        cmocka_unit_test(the_stack_enumerates_and_talks_on_this_controller),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
