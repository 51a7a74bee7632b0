/* These tests check the first contact of a USB host with the device. The device must enumerate at both speeds
 * in the sequences that Linux and Windows use. The device's descriptors must satisfy the standards, and the
 * device's reports must have the lengths that the report descriptor states. The tests read the descriptors
 * only through the mailbox. The checks do not use the table from which the firmware makes the descriptors. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#include "hil_tests/usb/usb_judge.h"
#include "hil_tests/usb/usb_rig.h"

static usb_rig rig;
static uint8_t bytes[1024];
static uint32_t count;

static int set_up(void **state)
{
    (void)state;
    usb_rig_open(&rig, true);
    return 0;
}

static usb_result get_descriptor(uint16_t value, uint16_t index, uint16_t length)
{
    memset(bytes, 0xee, sizeof bytes);
    return usb_rig_control(&rig, 0x80, 6, value, index, length, bytes, &count);
}

static void assert_good(const char *wrong)
{
    if (wrong != NULL) fail_msg("%s", wrong);
}

static usb_result set_address(uint8_t address)
{
    usb_result result = usb_rig_control(&rig, 0x00, 5, address, 0, 0, NULL, NULL);
    rig.host.address = address;
    return result;
}

/* Linux reads 64 bytes of the device descriptor at address 0, resets the device and sets its address. After
 * that, Linux reads the device descriptor again, and then all other descriptors. */
static void linux_way(bool high_speed)
{
    usb_judged judged;
    const crn_mailbox_bus reset = high_speed ? CRN_MAILBOX_RESET_HIGH : CRN_MAILBOX_RESET_FULL;
    assert_true(usb_host_sees_device(&rig.host));
    assert_int_equal(usb_host_bus(&rig.host, reset), USB_OK);
    assert_int_equal(get_descriptor(0x0100, 0, 64), USB_OK);
    assert_int_equal(count, 18);
    assert_int_equal(usb_host_bus(&rig.host, reset), USB_OK);
    assert_int_equal(set_address(9), USB_OK);
    assert_int_equal(get_descriptor(0x0100, 0, 18), USB_OK);
    assert_good(usb_judge_device(bytes, count));
    assert_int_equal(get_descriptor(0x0f00, 0, 5), USB_OK);
    assert_int_equal(get_descriptor(0x0f00, 0, (uint16_t)(bytes[2] | bytes[3] << 8)), USB_OK);
    assert_int_equal(get_descriptor(0x0200, 0, 9), USB_OK);
    assert_int_equal(count, 9);
    const uint16_t total = (uint16_t)(bytes[2] | bytes[3] << 8);
    assert_int_equal(get_descriptor(0x0200, 0, total), USB_OK);
    assert_int_equal(count, total);
    assert_good(usb_judge_configuration(bytes, count, 2, high_speed, &judged));
    assert_int_equal(judged.interface_count, 2);
    assert_int_equal(judged.endpoint_count, 4);
    for (uint16_t index = 0; index < 4; index++)
        assert_int_equal(get_descriptor((uint16_t)(0x0300 | index), index == 0 ? 0 : 0x0409, 255), USB_OK);
    assert_int_equal(usb_rig_control(&rig, 0x00, 9, 1, 0, 0, NULL, NULL), USB_OK);
    assert_int_equal(usb_rig_control(&rig, 0x21, 10, 0, 0, 0, NULL, NULL), USB_OK); /* SET_IDLE */
    assert_int_equal(usb_rig_control(&rig, 0x81, 6, 0x2200, 0, judged.report_descriptor_bytes, bytes, &count),
                     USB_OK);
    assert_int_equal(count, judged.report_descriptor_bytes);
    assert_int_equal(rig.link, CRN_USB_CONFIGURED);
}

static void linux_enumerates_at_high_speed(void **state)
{
    (void)state;
    linux_way(true);
}

static void linux_enumerates_at_full_speed(void **state)
{
    (void)state;
    linux_way(false);
}

/* Windows requests 255 bytes of every descriptor. The configuration descriptor has 64 bytes, exactly one full
 * packet, so the device must send an empty packet after it. Windows also requests three more items: the
 * Microsoft string 0xee, which the device refuses; the Microsoft descriptor set, with the vendor code from
 * the BOS descriptor; and the device qualifier. */
static void windows_enumerates_and_learns_about_winusb(void **state)
{
    (void)state;
    usb_judged judged;
    uint8_t vendor_code = 0, first_interface = 0, device[18];
    uint16_t set_bytes = 0;
    assert_int_equal(usb_host_bus(&rig.host, CRN_MAILBOX_RESET_HIGH), USB_OK);
    assert_int_equal(get_descriptor(0x0100, 0, 64), USB_OK);
    assert_int_equal(usb_host_bus(&rig.host, CRN_MAILBOX_RESET_HIGH), USB_OK);
    assert_int_equal(set_address(1), USB_OK);
    assert_int_equal(get_descriptor(0x0100, 0, 18), USB_OK);
    memcpy(device, bytes, sizeof device);
    assert_int_equal(get_descriptor(0x0200, 0, 255), USB_OK);
    assert_good(usb_judge_configuration(bytes, count, 2, true, &judged));
    assert_int_equal(get_descriptor(0x0f00, 0, 255), USB_OK);
    assert_good(usb_judge_bos(bytes, count, &vendor_code, &set_bytes));
    assert_int_equal(get_descriptor(0x0300, 0, 255), USB_OK);
    assert_int_equal(count, 4);
    assert_int_equal(get_descriptor(0x03ee, 0, 18), USB_STALLED);
    assert_int_equal(get_descriptor(0x0600, 0, 10), USB_OK);
    assert_good(usb_judge_qualifier(bytes, count, device));
    assert_int_equal(usb_rig_control(&rig, 0xc0, vendor_code, 0, 7, set_bytes, bytes, &count), USB_OK);
    assert_int_equal(count, set_bytes);
    assert_good(usb_judge_ms_os(bytes, count, &first_interface));
    assert_int_equal(judged.interface_classes[first_interface], 0xff);
    assert_int_equal(usb_rig_control(&rig, 0x00, 9, 1, 0, 0, NULL, NULL), USB_OK);
}

/* If the host requests fewer bytes than a descriptor has, the device must send only the first bytes of this
 * descriptor, unchanged; the test tries every length. */
static void a_short_read_gets_the_beginning(void **state)
{
    (void)state;
    static const struct {
        uint16_t value, index, length;
    } wanted[] = {{0x0100, 0, 18}, {0x0200, 0, 64}, {0x0302, 0x0409, 26}, {0x0f00, 0, 33}, {0x0600, 0, 10}};
    assert_int_equal(usb_host_bus(&rig.host, CRN_MAILBOX_RESET_HIGH), USB_OK);
    for (size_t i = 0; i < sizeof wanted / sizeof wanted[0]; i++) {
        uint8_t whole[256];
        assert_int_equal(get_descriptor(wanted[i].value, wanted[i].index, 256), USB_OK);
        assert_int_equal(count, wanted[i].length);
        memcpy(whole, bytes, count);
        for (uint16_t length = 0; length <= wanted[i].length + 2; length++) {
            assert_int_equal(get_descriptor(wanted[i].value, wanted[i].index, length), USB_OK);
            assert_int_equal(count, length < wanted[i].length ? length : wanted[i].length);
            assert_memory_equal(bytes, whole, count);
        }
    }
}

/* The descriptor "other-speed configuration" at one speed must equal the configuration at the other speed,
 * except for its type. */
static void the_other_speed_is_what_it_says(void **state)
{
    (void)state;
    usb_judged judged;
    for (int high = 0; high < 2; high++) {
        uint8_t other[256];
        assert_int_equal(usb_rig_configure(&rig, high), USB_OK);
        assert_int_equal(get_descriptor(0x0700, 0, 255), USB_OK);
        assert_good(usb_judge_configuration(bytes, count, 7, !high, &judged));
        const uint32_t other_count = count;
        memcpy(other, bytes, count);
        assert_int_equal(usb_rig_configure(&rig, !high), USB_OK);
        assert_int_equal(get_descriptor(0x0200, 0, 255), USB_OK);
        assert_int_equal(count, other_count);
        other[1] = 2;
        assert_memory_equal(bytes, other, count);
    }
}

/* A device without high speed has no device qualifier and no other-speed configuration (USB 2.0, 9.6.2), and
 * a high-speed reset ends at full speed. */
static void a_full_speed_device_has_no_other_speed(void **state)
{
    (void)state;
    usb_judged judged;
    usb_rig_open(&rig, false);
    assert_int_equal(usb_rig_configure(&rig, true), USB_OK);
    assert_int_equal(get_descriptor(0x0600, 0, 10), USB_STALLED);
    assert_int_equal(get_descriptor(0x0700, 0, 255), USB_STALLED);
    assert_int_equal(get_descriptor(0x0200, 0, 255), USB_OK);
    assert_good(usb_judge_configuration(bytes, count, 2, false, &judged));
}

/* The lengths in the report descriptor, including the report id, must equal the lengths of the reports that
 * GET_REPORT returns and of the reports in the pipe of the HID interface. */
static void reports_have_the_lengths_of_their_descriptor(void **state)
{
    (void)state;
    static const uint32_t expected[][3] = {{1, CRN_HID_ID_state, 63},       {2, CRN_HID_ID_command, 11},
                                           {3, CRN_HID_ID_identity, 24},    {3, CRN_HID_ID_capabilities, 13},
                                           {3, CRN_HID_ID_calibration, 36}, {3, CRN_HID_ID_limits, 24}};
    usb_judged_report reports[USB_JUDGE_REPORT_MAX];
    size_t report_count = 0;
    assert_int_equal(usb_rig_configure(&rig, true), USB_OK);
    assert_int_equal(usb_rig_control(&rig, 0x81, 6, 0x2200, 0, 512, bytes, &count), USB_OK);
    assert_good(usb_judge_reports(bytes, count, reports, &report_count));
    assert_int_equal(report_count, sizeof expected / sizeof expected[0]);
    for (size_t i = 0; i < report_count; i++) {
        assert_int_equal(reports[i].kind, expected[i][0]);
        assert_int_equal(reports[i].id, expected[i][1]);
        assert_int_equal(reports[i].bits, 8 * expected[i][2]);
        if (reports[i].kind == 2) continue; /* an output report cannot be requested */
        const uint16_t value = (uint16_t)(reports[i].kind << 8 | reports[i].id);
        assert_int_equal(usb_rig_control(&rig, 0xa1, 1, value, 0, 256, bytes, &count), USB_OK);
        assert_int_equal(count, 1 + reports[i].bits / 8);
        assert_int_equal(bytes[0], reports[i].id);
    }
    usb_rig_tick(&rig);
    assert_int_equal(usb_host_in(&rig.host, 1, 64, bytes, 64, &count), USB_OK);
    assert_int_equal(count, 64);
}

/* The device's strings must be UTF-16 of the right length, and the serial number must be that of the port. A
 * request for a language that the device does not offer must be refused. */
static void strings_are_utf16_in_english(void **state)
{
    (void)state;
    assert_int_equal(usb_rig_configure(&rig, true), USB_OK);
    assert_int_equal(get_descriptor(0x0303, 0x0409, 255), USB_OK);
    assert_int_equal(count, 2 + 2 * strlen("RIG-0001"));
    assert_int_equal(bytes[0], count);
    assert_int_equal(bytes[1], 3);
    for (size_t i = 0; i < strlen("RIG-0001"); i++) {
        assert_int_equal(bytes[2 + 2 * i], "RIG-0001"[i]);
        assert_int_equal(bytes[3 + 2 * i], 0);
    }
    assert_int_equal(get_descriptor(0x0303, 0x0407, 255), USB_STALLED);
    assert_int_equal(get_descriptor(0x0306, 0x0409, 255), USB_STALLED);
}

/* The reports `identity` and `capabilities` must contain the same values as the device's application. */
static void the_identity_tells_both_hashes(void **state)
{
    (void)state;
    crn_hid_identity identity;
    assert_int_equal(usb_rig_configure(&rig, true), USB_OK);
    assert_int_equal(usb_rig_control(&rig, 0xa1, 1, 0x0300 | CRN_HID_ID_identity, 0, 64, bytes, &count),
                     USB_OK);
    assert_true(crn_hid_decode_identity(bytes + 1, count - 1, &identity));
    assert_true(identity.schema_hash == crn_wire_schema_hash());
    assert_true(identity.report_hash == crn_hid_report_hash());
    assert_int_equal(identity.protocol_major, CRN_WIRE_PROTOCOL_MAJOR);
    assert_int_equal(identity.core_version, 7);
}

/* If the USB stack cannot serve a host, the device must report this failure at power-up. */
static void a_bad_configuration_is_refused_at_power_up(void **state)
{
    (void)state;
    static const char *const bad[] = {"", "with space", "umlaut\xfc", "0123456789012345678901234567890123"};
    crn_usb_config config = rig.usb.config;
    for (size_t i = 0; i < sizeof bad / sizeof bad[0]; i++) {
        config.serial = bad[i];
        assert_false(crn_usb_init(&rig.usb, &config));
    }
    config.serial = "01234567890123456789012345678901";
    assert_true(crn_usb_init(&rig.usb, &config));
    config.queue_bytes = 2 * CRN_WIRE_FRAME_MAX - 1;
    assert_false(crn_usb_init(&rig.usb, &config));
    config.queue_bytes = 2 * CRN_WIRE_FRAME_MAX;
    config.reply_bytes = CRN_WIRE_FRAME_MAX - 1;
    assert_false(crn_usb_init(&rig.usb, &config));
}

#define TEST(name) cmocka_unit_test_setup(name, set_up)

int main(void)
{
    const struct CMUnitTest tests[] = {
        TEST(linux_enumerates_at_high_speed),
        TEST(linux_enumerates_at_full_speed),
        TEST(windows_enumerates_and_learns_about_winusb),
        TEST(a_short_read_gets_the_beginning),
        TEST(the_other_speed_is_what_it_says),
        TEST(a_full_speed_device_has_no_other_speed),
        TEST(reports_have_the_lengths_of_their_descriptor),
        TEST(strings_are_utf16_in_english),
        TEST(the_identity_tells_both_hashes),
        TEST(a_bad_configuration_is_refused_at_power_up),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
