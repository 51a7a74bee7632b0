/* This program tests the library hidapi, as Debian ships it, with a loop-back device
 * (hil_tests/usb/usb_peer.h): feature reports, state reports for every tick, and commands with their answers.
 * The program is built once for hidapi's hidraw back end and once for its libusb back end. Prints TAP. */
#include <stdlib.h>
#include <string.h>
#include <wchar.h>

#include <hidapi/hidapi.h>

#include "hil_tests/library/check.h"
#include "shared/wire/hid.h"

enum { TIMEOUT_ms = 2000, REPORTS = 1000, COMMANDS = 200 };

static hid_device *device;

static bool open_device(const char *serial)
{
    wchar_t wide[64] = {0};
    if (serial != NULL) mbstowcs(wide, serial, 63);
    device = hid_open(CHECK_VENDOR_ID, CHECK_PRODUCT_ID, serial != NULL ? wide : NULL);
    return device != NULL;
}

static bool identity_is_ours(void)
{
    unsigned char bytes[64] = {CRN_HID_ID_identity};
    crn_hid_identity identity;
    const int count = hid_get_feature_report(device, bytes, sizeof bytes);
    return count >= 1 + CRN_HID_BYTES_identity &&
           crn_hid_decode_identity(bytes + 1, (size_t)count - 1, &identity) &&
           identity.report_hash == crn_hid_report_hash();
}

static bool read_limits(crn_hid_limits *limits)
{
    unsigned char bytes[64] = {CRN_HID_ID_limits};
    const int count = hid_get_feature_report(device, bytes, sizeof bytes);
    return count >= 1 + CRN_HID_BYTES_limits && crn_hid_decode_limits(bytes + 1, (size_t)count - 1, limits);
}

static bool write_limits(const crn_hid_limits *limits)
{
    unsigned char bytes[1 + CRN_HID_BYTES_limits] = {CRN_HID_ID_limits};
    crn_wire_writer writer = crn_wire_writer_make(bytes + 1, sizeof bytes - 1);
    return crn_hid_put_limits(&writer, limits) &&
           hid_send_feature_report(device, bytes, sizeof bytes) == (int)sizeof bytes;
}

/* The program lowers limits and reads them back; the device must refuse to raise them. */
static bool settings_work(void)
{
    crn_hid_limits limits, read;
    if (!read_limits(&limits)) return false;
    limits.tracks[2].force_limit_mN -= 1;
    if (!write_limits(&limits) || !read_limits(&read)) return false;
    if (read.tracks[2].force_limit_mN != limits.tracks[2].force_limit_mN) return false;
    limits.tracks[2].force_limit_mN += 1;
    return !write_limits(&limits);
}

static bool read_state(crn_hid_state *state)
{
    unsigned char bytes[64];
    const int count = hid_read_timeout(device, bytes, sizeof bytes, TIMEOUT_ms);
    return count == 64 && bytes[0] == CRN_HID_ID_state && crn_hid_decode_state(bytes + 1, 63, state);
}

/* The program skips reports from before the test; after that, it checks the report of every tick. */
static bool states_follow(void)
{
    crn_hid_state state;
    unsigned char bytes[64];
    while (hid_read_timeout(device, bytes, sizeof bytes, 0) > 0) {
    }
    if (!read_state(&state)) return false;
    uint32_t tick = state.tick, lost = 0;
    const int64_t begin = check_now_us();
    for (int i = 0; i < REPORTS; i++) {
        if (!read_state(&state) || state.tick <= tick) return false;
        lost += state.tick - tick - 1;
        tick = state.tick;
    }
    const int64_t us = check_now_us() - begin;
    check_note("link.hid_reports_per_s %lld", (long long)REPORTS * 1000000 / us);
    check_note("link.hid_ticks_lost %u of %u", (unsigned)lost, (unsigned)(REPORTS + lost));
    /* On a busy machine, hidapi loses a few reports. If two programs read the reports of one device, each
     * program gets only every second report. A machine that is too slow for 1,000 reports per second also
     * loses reports. Therefore `make test` only prints the fraction of lost reports, whereas `make hil-mock`
     * fails if too many reports are lost. */
    return getenv("UNPACED") != NULL || lost < REPORTS / 2;
}

/* For each command that the program sends, a state report must return the command's number. */
static bool commands_are_answered(void)
{
    const int64_t begin = check_now_us();
    for (int i = 0; i < COMMANDS; i++) {
        unsigned char bytes[1 + CRN_HID_BYTES_command] = {CRN_HID_ID_command};
        const crn_hid_command command = {.number = (uint8_t)(1 + i % 255), .action = 0, .value1 = i};
        crn_wire_writer writer = crn_wire_writer_make(bytes + 1, sizeof bytes - 1);
        crn_hid_state state = {0};
        if (!crn_hid_put_command(&writer, &command)) return false;
        if (hid_write(device, bytes, sizeof bytes) != (int)sizeof bytes) {
            check_note("command %d was not taken: %ls", i, hid_error(device));
            return false;
        }
        const int64_t end = check_now_us() + TIMEOUT_ms * 1000;
        while (state.command_number != command.number) {
            if (check_now_us() <= end && read_state(&state)) continue;
            check_note("command %d was not answered; the state says %u", i, state.command_number);
            return false;
        }
    }
    const int64_t us = check_now_us() - begin;
    check_note("link.hid_roundtrips_per_s %lld", (long long)COMMANDS * 1000000 / us);
    return true;
}

int main(int argc, char **argv)
{
    const char *serial = check_serial(argc, argv);
    if (!check(hid_init() == 0 && open_device(serial), "the HID interface is found and opened"))
        return check_end();
    check(identity_is_ours(), "the identity report has our report hash");
    check(settings_work(), "limits are lowered, read back, and not raised");
    check(states_follow(), "state reports come in the order of their ticks, and nobody else takes them");
    check(commands_are_answered(), "every command is answered in a state report");
    hid_close(device);
    hid_exit();
    return check_end();
}
