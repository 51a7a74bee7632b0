/* These tests check endpoint 0 of the device. The device must answer every standard request as USB 2.0
 * chapter 9 requires, and refuse a forbidden request with STALL without any other change. No sequence of
 * transfer stages may leave endpoint 0 unusable. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#include "hil_tests/usb/usb_rig.h"

static usb_rig rig;
static uint8_t bytes[1024];
static uint32_t count;

static int set_up(void **state)
{
    (void)state;
    usb_rig_open(&rig, true);
    return usb_rig_configure(&rig, true) != USB_OK;
}

static usb_result ask(uint8_t type, uint8_t request, uint16_t value, uint16_t index, uint16_t length)
{
    memset(bytes, 0, sizeof bytes);
    return usb_rig_control(&rig, type, request, value, index, length, bytes, &count);
}

static usb_result halt(uint8_t address)
{
    return ask(0x02, 3, 0, address, 0);
}

static unsigned endpoint_status(uint8_t address)
{
    assert_int_equal(ask(0x82, 0, 0, address, 2), USB_OK);
    return bytes[0];
}

static void status_requests_answer(void **state)
{
    (void)state;
    static const uint8_t endpoints[] = {0x00, 0x80, 0x81, 0x01, 0x82, 0x02};
    assert_int_equal(ask(0x80, 0, 0, 0, 2), USB_OK);
    assert_int_equal(bytes[0], 1); /* self-powered, no remote wake-up */
    assert_int_equal(count, 2);
    for (uint16_t interface = 0; interface < 2; interface++) {
        assert_int_equal(ask(0x81, 0, 0, interface, 2), USB_OK);
        assert_int_equal(ask(0x81, 10, 0, interface, 1), USB_OK); /* GET_INTERFACE */
        assert_int_equal(bytes[0], 0);
        assert_int_equal(ask(0x01, 11, 0, interface, 0), USB_OK); /* SET_INTERFACE */
    }
    for (size_t i = 0; i < sizeof endpoints; i++) assert_int_equal(endpoint_status(endpoints[i]), 0);
    assert_int_equal(ask(0x80, 8, 0, 0, 1), USB_OK); /* GET_CONFIGURATION */
    assert_int_equal(bytes[0], 1);
}

typedef struct request {
    uint8_t type, request;
    uint16_t value, index, length;
} request;

static const request refused[] = {
    {0x80, 0, 1, 0, 2},               /* GET_STATUS: value is 0 */
    {0x80, 0, 0, 1, 2},               /* for the device: index is 0 */
    {0x80, 0, 0, 0, 1},               /* has two bytes */
    {0x81, 0, 0, 2, 2},               /* no such interface */
    {0x82, 0, 0, 0x83, 2},            /* no such endpoint */
    {0x82, 0, 0, 0x8001, 2},          /* nor this */
    {0x83, 0, 0, 0, 2},               /* nor this recipient */
    {0x00, 0, 0, 0, 0},               /* wrong direction */
    {0x00, 1, 1, 0, 0},               /* CLEAR_FEATURE: remote wake-up is not offered */
    {0x00, 3, 1, 0, 0},               /* SET_FEATURE: the same */
    {0x00, 3, 2, 0, 0},               /* test mode 0 */
    {0x00, 3, 2, 0x0500, 0},          /* test mode 5: for hubs */
    {0x00, 3, 2, 0x0101, 0},          /* the low byte of the index is 0 */
    {0x00, 1, 2, 0x0100, 0},          /* only power-down ends test mode */
    {0x02, 3, 0, 0x00, 0},            /* endpoint 0 is not halted by request */
    {0x02, 3, 1, 0x81, 0},            /* no such feature */
    {0x02, 1, 0, 0x05, 0},            /* no such endpoint */
    {0x01, 3, 0, 0, 0},               /* interfaces have no features */
    {0x00, 2, 0, 0, 0},               /* no such request */
    {0x00, 5, 128, 0, 0},             /* SET_ADDRESS: at most 127 */
    {0x00, 5, 7, 0, 0},               /* and not while configured */
    {0x80, 6, 0x0101, 0, 18},         /* there is one device descriptor */
    {0x80, 6, 0x0201, 0, 9},          /* and one configuration */
    {0x80, 6, 0x0400, 0, 9},          /* interfaces cannot be requested alone */
    {0x80, 6, 0x0500, 0, 7},          /* nor endpoints */
    {0x80, 6, 0x0000, 0, 7},          /* no such type */
    {0x80, 6, 0xff00, 0, 7},          /* nor this */
    {0x81, 6, 0x2200, 1, 64},         /* the stream is not an HID interface */
    {0x81, 6, 0x2201, 0, 64},         /* there is one report descriptor */
    {0x81, 6, 0x2300, 0, 64},         /* and no physical one */
    {0x00, 7, 0x0100, 0, 18},         /* SET_DESCRIPTOR */
    {0x00, 9, 2, 0, 0},               /* SET_CONFIGURATION: 0 or 1 */
    {0x00, 9, 1, 1, 0},               /* index is 0 */
    {0x01, 11, 1, 0, 0},              /* SET_INTERFACE: setting 0 only */
    {0x01, 11, 0, 2, 0},              /* no such interface */
    {0x81, 10, 0, 2, 1},              /* GET_INTERFACE: the same */
    {0x82, 12, 0, 0x81, 2},           /* SYNCH_FRAME is for isochronous endpoints */
    {0xa1, 1, 0x0100, 0, 64},         /* GET_REPORT: no report 0 */
    {0xa1, 1, 0x0202, 0, 64},         /* output reports are not read */
    {0xa1, 1, 0x0301, 0, 64},         /* report 1 is not a feature */
    {0xa1, 1, 0x0101, 1, 64},         /* the stream has no reports */
    {0xa1, 3, 0, 0, 1},               /* GET_PROTOCOL: no boot device */
    {0x21, 11, 0, 0, 0},              /* SET_PROTOCOL: the same */
    {0x21, 9, 0x0310, 0, 25},         /* SET_REPORT: the identity is read only */
    {0x21, 9, 0x0312, 0, 36},         /* shorter than required by the id */
    {0x21, 9, 0x0312, 0, 257},        /* longer than any */
    {0x21, 9, 0x0312, 1, 37},         /* wrong interface */
    {0x21, 9, 0x0201, 0, 12},         /* no such output report */
    {0xc0, 0x20, 0, 4, 64},           /* Microsoft set: index 7 */
    {0xc0, 0x20, 1, 7, 64},           /* value 0 */
    {0x40, 0x20, 0, 7, 0},            /* wrong direction */
    {0x40, 0x21, 0, 0, 0},            /* unplug: at least 1 ms */
    {0x40, 0x21, 10001, 0, 0},        /* at most 10 s */
    {0xc0, 0x21, 5, 0, 0},            /* wrong direction */
    {0xc0, 0x77, 0, 0, 4},            /* no such request */
    {0x60, 0, 0, 0, 0},               /* no such kind */
    {0xff, 0xff, 0xffff, 0xffff, 64}, /* nothing of it */
};

/* The device must refuse the request with STALL, must answer the next request, and must not have changed
 * anything. */
static void what_is_not_allowed_is_refused_and_changes_nothing(void **state)
{
    (void)state;
    for (size_t i = 0; i < sizeof refused / sizeof refused[0]; i++) {
        const request *r = &refused[i];
        const uint32_t before = rig.usb.requests_refused;
        usb_result result = ask(r->type, r->request, r->value, r->index, r->length);
        if (result != USB_STALLED)
            fail_msg("request %02x %02x %04x %04x %u: %s", r->type, r->request, r->value, r->index, r->length,
                     usb_result_name(result));
        assert_int_equal(rig.usb.requests_refused, before + 1);
        assert_int_equal(ask(0x80, 8, 0, 0, 1), USB_OK);
        assert_int_equal(bytes[0], 1);
    }
    assert_int_equal(rig.calibration.tracks[0].translation_pm_per_count, 10000000);
    assert_int_equal(rig.commands, 0);
    assert_int_equal(rig.link, CRN_USB_CONFIGURED);
    assert_int_equal(rig.mailbox.device.test_selector, 0);
}

/* Before SET_CONFIGURATION, the device must refuse requests to interfaces and endpoints. */
static void an_address_alone_allows_little(void **state)
{
    (void)state;
    assert_int_equal(ask(0x00, 9, 0, 0, 0), USB_OK);
    assert_int_equal(rig.link, CRN_USB_DETACHED);
    assert_int_equal(ask(0x80, 8, 0, 0, 1), USB_OK);
    assert_int_equal(bytes[0], 0);
    assert_int_equal(ask(0x81, 0, 0, 0, 2), USB_STALLED);
    assert_int_equal(ask(0x82, 0, 0, 0x81, 2), USB_STALLED);
    assert_int_equal(ask(0x82, 0, 0, 0x00, 2), USB_OK);
    assert_int_equal(ask(0x81, 10, 0, 0, 1), USB_STALLED);
    assert_int_equal(ask(0x01, 11, 0, 0, 0), USB_STALLED);
    assert_int_equal(ask(0x02, 3, 0, 0x81, 0), USB_STALLED);
    assert_int_equal(ask(0xa1, 1, 0x0101, 0, 64), USB_STALLED);
    assert_int_equal(usb_host_packet_in(&rig.host, 1, bytes, 64, &count), USB_SILENT);
    assert_int_equal(usb_host_packet_out(&rig.host, 2, bytes, 64), USB_SILENT);
    assert_int_equal(usb_host_bus(&rig.host, CRN_MAILBOX_RESET_HIGH), USB_OK);
    assert_int_equal(ask(0x00, 9, 1, 0, 0), USB_STALLED); /* address 0 may not be configured */
}

/* The device's address must change only after the status stage: the transfer ends at the old address, and the
 * next transfer begins at the new address. */
static void the_address_changes_after_the_status_stage(void **state)
{
    (void)state;
    assert_int_equal(usb_host_bus(&rig.host, CRN_MAILBOX_RESET_HIGH), USB_OK);
    for (uint8_t address = 127; address > 120; address--) {
        assert_int_equal(ask(0x00, 5, address, 0, 0), USB_OK);
        assert_int_equal(ask(0x80, 8, 0, 0, 1), USB_SILENT);
        rig.host.address = address;
        assert_int_equal(ask(0x80, 8, 0, 0, 1), USB_OK);
    }
    /* If the host never reaches the status stage, the device's address must not change. */
    static const uint8_t setup[8] = {0x00, 5, 3, 0, 0, 0, 0, 0};
    crn_mailbox_reply reply;
    usb_host_token(&rig.host, CRN_MAILBOX_SETUP, 0, 0, setup, 8, &reply, NULL, 0, &count);
    assert_int_equal(reply, CRN_MAILBOX_ACK);
    assert_int_equal(ask(0x80, 8, 0, 0, 1), USB_OK);
}

/* A halted endpoint must answer STALL and report its halt. After the halt is cleared, the endpoint must begin
 * with DATA0; meanwhile the other endpoints must continue to work. */
static void a_halt_is_set_seen_and_cleared(void **state)
{
    (void)state;
    static const uint8_t endpoints[] = {0x81, 0x01, 0x82, 0x02};
    for (size_t i = 0; i < sizeof endpoints; i++) {
        const uint8_t address = endpoints[i], number = address & 0x0f;
        const bool is_in = (address & 0x80) != 0;
        assert_int_equal(halt(address), USB_OK);
        assert_int_equal(endpoint_status(address), 1);
        for (size_t k = 0; k < sizeof endpoints; k++)
            if (k != i) assert_int_equal(endpoint_status(endpoints[k]), 0);
        usb_rig_tick(&rig);
        usb_rig_settle(&rig);
        assert_int_equal(is_in ? usb_host_packet_in(&rig.host, number, bytes, 512, &count)
                               : usb_host_packet_out(&rig.host, number, bytes, 8),
                         USB_STALLED);
        assert_int_equal(usb_host_clear_halt(&rig.host, address), USB_OK);
        assert_int_equal(endpoint_status(address), 0);
    }
    /* After their halts are cleared, all four endpoints must work again. If the device's data toggles
     * differed from the host's, packets would now be dropped or refused. */
    static const uint8_t command[12] = {CRN_HID_ID_command, 1, 6, 0};
    usb_rig_tick(&rig);
    assert_int_equal(usb_host_in(&rig.host, 1, 64, bytes, 64, &count), USB_OK);
    assert_int_equal(usb_host_out(&rig.host, 1, 64, command, sizeof command), USB_OK);
    usb_rig_settle(&rig);
    assert_int_equal(rig.commands, 1);
    assert_int_equal(usb_host_in(&rig.host, 2, 512, bytes, 512, &count), USB_OK);
    assert_int_equal(count, 1);
    assert_int_equal(usb_host_out(&rig.host, 2, 512, (const uint8_t *)"\1\1", 3), USB_OK);
    assert_int_equal(usb_host_in(&rig.host, 2, 512, bytes, 512, &count), USB_OK);
    assert_int_equal(count, 3);
}

/* The request CLEAR_FEATURE must also restart an endpoint that is not halted, with DATA0 (USB 2.0, 9.4.5). */
static void clearing_what_is_not_halted_resets_the_toggle(void **state)
{
    (void)state;
    for (int packets = 1; packets < 4; packets++) {
        for (int i = 0; i < packets; i++) {
            usb_rig_tick(&rig);
            assert_int_equal(usb_host_in(&rig.host, 1, 64, bytes, 64, &count), USB_OK);
        }
        assert_int_equal(usb_host_clear_halt(&rig.host, 0x81), USB_OK);
        usb_rig_tick(&rig);
        assert_int_equal(usb_host_in(&rig.host, 1, 64, bytes, 64, &count), USB_OK); /* checks the toggle */
        assert_int_equal(usb_host_clear_halt(&rig.host, 0x81), USB_OK);
    }
}

/* If a setup packet comes instead of any stage of any transfer, the device must end this transfer and answer
 * the new request. */
static void a_setup_packet_ends_what_was_under_way(void **state)
{
    (void)state;
    static const uint8_t set_report[8] = {0x21, 9, CRN_HID_ID_limits, 3, 0, 0, 25, 0};
    static const uint8_t get_configuration[8] = {0x80, 6, 0, 2, 0, 0, 255, 0};
    static const uint8_t set_idle[8] = {0x21, 10, 0, 4, 0, 0, 0, 0};
    static const uint8_t *const setups[] = {set_report, get_configuration, set_idle};
    for (int i = 0; i < 3; i++) {
        for (int stages = 0; stages < 2; stages++) {
            crn_mailbox_reply reply = CRN_MAILBOX_NAK;
            usb_host_token(&rig.host, CRN_MAILBOX_SETUP, 0, 0, setups[i], 8, &reply, NULL, 0, &count);
            assert_int_equal(reply, CRN_MAILBOX_ACK);
            rig.host.toggle_in[0] = rig.host.toggle_out[0] = true;
            if (stages == 1 && i == 0) assert_int_equal(usb_host_packet_out(&rig.host, 0, bytes, 8), USB_OK);
            if (stages == 1 && i == 1)
                assert_int_equal(usb_host_packet_in(&rig.host, 0, bytes, 64, &count), USB_OK);
            assert_int_equal(ask(0x80, 6, 0x0100, 0, 18), USB_OK);
            assert_int_equal(bytes[1], 1);
        }
    }
    assert_int_equal(rig.limits.tracks[0].force_limit_mN, 8000);
}

/* The host may end a data stage early by its status stage. */
static void a_data_stage_may_end_early(void **state)
{
    (void)state;
    static const uint8_t get_set[8] = {0xc0, CRN_USB_REQUEST_MS_OS, 0, 0, 7, 0, 178, 0};
    crn_mailbox_reply reply;
    usb_host_token(&rig.host, CRN_MAILBOX_SETUP, 0, 0, get_set, 8, &reply, NULL, 0, &count);
    rig.host.toggle_in[0] = rig.host.toggle_out[0] = true;
    assert_int_equal(usb_host_packet_in(&rig.host, 0, bytes, 64, &count), USB_OK);
    assert_int_equal(usb_host_packet_out(&rig.host, 0, NULL, 0), USB_OK);
    assert_int_equal(ask(0x80, 8, 0, 0, 1), USB_OK);
}

/* If a host sends more or less data than it announced, the device must refuse the request and keep its
 * settings. */
static void a_data_stage_of_the_wrong_length_is_refused(void **state)
{
    (void)state;
    static const uint8_t set_report[8] = {0x21, 9, CRN_HID_ID_limits, 3, 0, 0, 25, 0};
    static const uint8_t lengths[] = {0, 1, 24, 26, 64};
    for (size_t i = 0; i < sizeof lengths; i++) {
        crn_mailbox_reply reply;
        memset(bytes, 0, sizeof bytes);
        bytes[0] = CRN_HID_ID_limits;
        usb_host_token(&rig.host, CRN_MAILBOX_SETUP, 0, 0, set_report, 8, &reply, NULL, 0, &count);
        rig.host.toggle_in[0] = rig.host.toggle_out[0] = true;
        usb_result result = usb_host_packet_out(&rig.host, 0, bytes, lengths[i]);
        if (result == USB_OK) result = usb_host_packet_in(&rig.host, 0, bytes, 64, &count);
        assert_int_equal(result, USB_STALLED);
        assert_int_equal(rig.limits.tracks[0].force_limit_mN, 8000);
        assert_int_equal(ask(0x80, 8, 0, 0, 1), USB_OK);
    }
}

static void test_modes_are_handed_to_the_controller(void **state)
{
    (void)state;
    assert_int_equal(ask(0x00, 3, 2, 0x0400, 0), USB_OK);
    assert_int_equal(rig.mailbox.device.test_selector, 4);
    usb_rig_open(&rig, true);
    assert_int_equal(usb_rig_configure(&rig, false), USB_OK);
    assert_int_equal(ask(0x00, 3, 2, 0x0400, 0), USB_STALLED); /* full speed has none */
    assert_int_equal(rig.mailbox.device.test_selector, 0);
}

/* After a lost acknowledgement, the sender repeats the packet. No byte may be lost, and the device must not
 * execute a request twice. */
static void lost_acknowledgements_change_nothing(void **state)
{
    (void)state;
    static const uint8_t first[8] = {CRN_HID_ID_command, 9, 1};
    for (uint32_t every = 2; every < 6; every++) {
        rig.host.lose_in = rig.host.lose_out = every;
        assert_int_equal(ask(0x80, 6, 0x0200, 0, 255), USB_OK);
        assert_int_equal(count, 64);
        memcpy(bytes, first, sizeof first);
        assert_int_equal(usb_rig_control(&rig, 0x21, 9, 0x0200 | CRN_HID_ID_command, 0, 12, bytes, &count),
                         USB_OK);
        assert_int_equal(rig.commands, every - 1);
    }
    assert_true(rig.host.repeats > 4);
}

#define TEST(name) cmocka_unit_test_setup(name, set_up)

int main(void)
{
    const struct CMUnitTest tests[] = {
        TEST(status_requests_answer),
        TEST(what_is_not_allowed_is_refused_and_changes_nothing),
        TEST(an_address_alone_allows_little),
        TEST(the_address_changes_after_the_status_stage),
        TEST(a_halt_is_set_seen_and_cleared),
        TEST(clearing_what_is_not_halted_resets_the_toggle),
        TEST(a_setup_packet_ends_what_was_under_way),
        TEST(a_data_stage_may_end_early),
        TEST(a_data_stage_of_the_wrong_length_is_refused),
        TEST(test_modes_are_handed_to_the_controller),
        TEST(lost_acknowledgements_change_nothing),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
