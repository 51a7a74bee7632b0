/* These tests check the complete device on USB. Over its two bulk endpoints, the device must give the same
 * answers and the same state hashes as over any other pipe. The HID interface reports the device's state and
 * can remove motor power. The HID interface refuses every setting that the wire protocol would refuse. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#include "firmware/tests/reference/client.h"
#include "hil_tests/usb/usb_device.h"

enum { STATUS = 1 };

static usb_device device;
static client host;
static uint8_t bytes[256];
static uint32_t count;

static int set_up(void **state)
{
    (void)state;
    const client_pipe pipe = {&device, usb_device_write, usb_device_read};
    if (!usb_device_open(&device)) return -1;
    client_open_pipe(&host, &pipe);
    return 0;
}

static usb_result hid(uint8_t type, uint8_t request, uint16_t value, uint16_t length)
{
    const usb_request setup = {type, request, value, 0, length};
    return usb_host_control(&device.host, &setup, bytes, &count);
}

static void order(uint8_t number, uint8_t action)
{
    const crn_hid_command command = {.number = number, .action = action};
    uint8_t report[1 + CRN_HID_BYTES_command] = {CRN_HID_ID_command};
    crn_wire_writer writer = crn_wire_writer_make(report + 1, sizeof report - 1);
    crn_hid_put_command(&writer, &command);
    assert_int_equal(usb_host_out(&device.host, STATUS, 64, report, sizeof report), USB_OK);
    usb_device_settle(&device);
}

static crn_hid_state next_state(void)
{
    crn_hid_state state = {0};
    usb_device_tick(&device);
    do {
        assert_int_equal(usb_host_in(&device.host, STATUS, 64, bytes, 64, &count), USB_OK);
        assert_true(crn_hid_decode_state(bytes + 1, count - 1, &state));
    } while (device.rig_usb.usb.report_count > 0 || device.rig_usb.usb.is_armed[CRN_USB_STATUS_IN]);
    return state;
}

static void run_session(client *c, crn_wire_ticks *last)
{
    assert_true(client_start_tools(c, 3));
    for (uint32_t tick = 0; tick < 320; tick += 64) {
        client_step(c, tick, 64, (int32_t)tick * 25, 25);
        assert_true(client_expect_ticks(c, last));
        assert_int_equal(last->states_count, 64);
    }
}

/* A session over USB tokens must give, bit for bit, the same state hashes as the same session over the
 * simulator's pipe. */
static void a_session_over_usb_gives_the_hashes_of_any_other_pipe(void **state)
{
    (void)state;
    static crn_wire_ticks over_usb, over_sim;
    static client sim;
    device.host.lose_in = 7; /* and lost acknowledgements change nothing */
    device.host.lose_out = 5;
    run_session(&host, &over_usb);
    assert_true(device.host.repeats > 10);
    client_open(&sim, 0);
    run_session(&sim, &over_sim);
    client_close(&sim);
    assert_memory_equal(&over_usb.states[63], &over_sim.states[63], sizeof over_usb.states[63]);
    assert_true(over_usb.states[63].hash_lane0 != 0);
}

static void the_serial_number_is_that_of_the_port(void **state)
{
    (void)state;
    const usb_request get = {0x80, 6, 0x0303, 0x0409, 255};
    assert_int_equal(usb_host_control(&device.host, &get, bytes, &count), USB_OK);
    assert_int_equal(count, 2 + 2 * strlen("USB-0001"));
    for (size_t i = 0; i < strlen("USB-0001"); i++) assert_int_equal(bytes[2 + 2 * i], "USB-0001"[i]);
    crn_wire_hello_reply reply;
    client_hello(&host, crn_wire_schema_hash());
    assert_int_equal(client_receive(&host), CRN_WIRE_TYPE_hello_reply);
    assert_true(crn_wire_decode_hello_reply(host.decoder.payload, host.decoder.payload_bytes, &reply));
    assert_memory_equal(reply.serial, "USB-0001", strlen("USB-0001"));
}

/* The longest answer of a device is a snapshot. If a host requests three snapshots and reads them only later,
 * the host must receive all three snapshots completely. */
static void no_answer_is_lost_when_the_host_reads_late(void **state)
{
    (void)state;
    assert_true(client_start_tools(&host, 3));
    crn_wire_status status;
    for (int i = 0; i < 3; i++) client_get(&host, CRN_WIRE_GET_SNAPSHOT);
    int ends = 0;
    for (uint16_t type = client_receive(&host); type != 0; type = client_receive(&host))
        ends += type == CRN_WIRE_TYPE_snapshot_end;
    assert_int_equal(ends, 3);
    client_get(&host, CRN_WIRE_GET_STATUS);
    assert_true(client_expect_status(&host, &status));
    assert_int_equal(status.transmit_dropped, 0);
    assert_int_equal(status.frames_bad, 0);
}

/* HID follows the app's state. The commands STOP and RESET must work over HID, whereas a command that could
 * give power to a motor must not. */
static void hid_shows_the_state_and_takes_power_away(void **state)
{
    (void)state;
    crn_hid_state report = next_state();
    assert_int_equal(report.state, CRN_WIRE_STATE_INIT);
    order(1, CRN_WIRE_ACTION_RESET); /* no host has sent HELLO yet */
    report = next_state();
    assert_int_equal(report.command_number, 1);
    assert_int_equal(report.command_result, CRN_REJECT_WRONG_STATE);
    while (client_receive(&host) != 0) {
    }
    assert_true(client_start_session(&host));
    client_step(&host, 0, 10, 0, 25);
    report = next_state();
    assert_int_equal(report.state, CRN_WIRE_STATE_RUNNING);
    assert_int_equal(report.mode, CRN_WIRE_MODE_LOCKSTEP);
    assert_int_equal(report.tick, 10);
    for (uint8_t action = 0; action < 12; action++) {
        if (action == CRN_WIRE_ACTION_STOP || action == CRN_WIRE_ACTION_RESET) continue;
        order((uint8_t)(10 + action), action);
        report = next_state();
        assert_int_equal(report.command_number, 10 + action);
        assert_int_equal(report.command_result, CRN_REJECT_ACTION_UNKNOWN);
        assert_int_equal(report.state, CRN_WIRE_STATE_RUNNING);
    }
    order(31, CRN_WIRE_ACTION_STOP);
    report = next_state();
    assert_int_equal(report.command_number, 31);
    assert_int_equal(report.command_result, 0);
    assert_int_equal(report.state, CRN_WIRE_STATE_ARMED);
    order(32, CRN_WIRE_ACTION_RESET);
    report = next_state();
    assert_int_equal(report.command_result, 0);
    assert_int_equal(report.state, CRN_WIRE_STATE_READY);
}

/* A STOP over HID takes effect at once, even if the wire protocol has received only part of a frame, and does
 * not disturb the byte stream. When the remaining bytes of the frame arrive, the device must answer the
 * frame, and no sequence number may be missing. */
static void stop_by_hid_passes_a_frame_that_is_half_there(void **state)
{
    (void)state;
    crn_wire_status status;
    const uint8_t get[] = {CRN_WIRE_GET_STATUS};
    assert_true(client_start_session(&host));
    const crn_wire_header header = {(uint16_t)(host.sequence + 1), 0, CRN_WIRE_TYPE_get};
    const size_t frame_bytes = crn_wire_frame_encode(&header, get, 1, host.frame, sizeof host.frame);
    usb_device_write(&device, host.frame, frame_bytes - 4);
    order(1, CRN_WIRE_ACTION_STOP);
    assert_int_equal(next_state().state, CRN_WIRE_STATE_ARMED);
    usb_device_write(&device, host.frame + frame_bytes - 4, 4);
    host.sequence++;
    client_get(&host, CRN_WIRE_GET_STATUS);
    while (client_expect_status(&host, &status) && host.decoder.header.answers != host.sequence) {
    }
    assert_int_equal(host.decoder.header.answers, host.sequence);
    assert_int_equal(status.frames_bad, 0);
    assert_int_equal(status.sequence_gaps, 0);
    assert_int_equal(status.state, CRN_WIRE_STATE_ARMED);
}

static usb_result set_limit(uint32_t force_limit_mN)
{
    crn_hid_limits limits;
    const uint16_t value = 0x0300 | CRN_HID_ID_limits;
    assert_int_equal(hid(0xa1, 1, value, 64), USB_OK);
    assert_true(crn_hid_decode_limits(bytes + 1, count - 1, &limits));
    limits.tracks[1].force_limit_mN = force_limit_mN;
    crn_wire_writer writer = crn_wire_writer_make(bytes + 1, sizeof bytes - 1);
    crn_hid_put_limits(&writer, &limits);
    return hid(0x21, 9, value, 1 + CRN_HID_BYTES_limits);
}

/* Settings over HID must follow the rules of the message `rig` of the wire protocol: the device accepts them
 * only after HELLO and only in the state READY, and limits can only be lowered. */
static void settings_by_hid_obey_the_rules_of_the_wire(void **state)
{
    (void)state;
    crn_hid_calibration calibration;
    const uint16_t value = 0x0300 | CRN_HID_ID_calibration;
    assert_int_equal(set_limit(5000), USB_STALLED);
    /* which answers no request of the stream */
    assert_int_equal(client_receive(&host), CRN_WIRE_TYPE_reject);
    assert_int_equal(host.decoder.header.answers, 0);
    client_hello(&host, crn_wire_schema_hash());
    assert_int_equal(client_receive(&host), CRN_WIRE_TYPE_hello_reply);
    assert_int_equal(set_limit(5000), USB_OK);
    assert_int_equal(device.app.setup.tracks[1].wire.force_limit_mN, 5000);
    assert_int_equal(set_limit(5001), USB_STALLED);
    assert_int_equal(device.app.setup.tracks[1].wire.force_limit_mN, 5000);
    assert_int_equal(hid(0xa1, 1, value, 64), USB_OK);
    assert_true(crn_hid_decode_calibration(bytes + 1, count - 1, &calibration));
    calibration.tracks[2].translation_pm_per_count = 2500000;
    crn_wire_writer writer = crn_wire_writer_make(bytes + 1, sizeof bytes - 1);
    crn_hid_put_calibration(&writer, &calibration);
    assert_int_equal(hid(0x21, 9, value, 1 + CRN_HID_BYTES_calibration), USB_OK);
    assert_int_equal(device.app.setup.tracks[2].wire.translation_pm_per_count, 2500000);
    calibration.tracks[2].rotation_counts_per_turn = 3; /* out of range */
    writer = crn_wire_writer_make(bytes + 1, sizeof bytes - 1);
    crn_hid_put_calibration(&writer, &calibration);
    assert_int_equal(hid(0x21, 9, value, 1 + CRN_HID_BYTES_calibration), USB_STALLED);
    assert_int_equal(device.app.setup.tracks[2].wire.rotation_counts_per_turn, 65536);
    while (client_receive(&host) != 0) {
    }
    assert_true(client_start_session(&host));
    assert_int_equal(set_limit(4000), USB_STALLED); /* RUNNING */
    assert_int_equal(device.app.setup.tracks[1].wire.force_limit_mN, 5000);
    assert_int_equal(device.app.link.sequence_gaps, 0);
}

static usb_result set_gain(uint32_t gain_milli)
{
    crn_hid_calibration calibration;
    const uint16_t value = 0x0300 | CRN_HID_ID_calibration;
    assert_int_equal(hid(0xa1, 1, value, 64), USB_OK);
    assert_true(crn_hid_decode_calibration(bytes + 1, count - 1, &calibration));
    calibration.tracks[0].force_gain_milli = gain_milli;
    crn_wire_writer writer = crn_wire_writer_make(bytes + 1, sizeof bytes - 1);
    crn_hid_put_calibration(&writer, &calibration);
    return hid(0x21, 9, value, 1 + CRN_HID_BYTES_calibration);
}

/* A damping of 1 N s/m permits a coupling of 800 N/m if the motor's lag is 0.5 ms. The device must refuse a
 * HID report that doubles the stiffness that the hand feels, just as it refuses the same change in the
 * message `rig` of the wire protocol. */
static void a_gain_that_is_not_passive_is_refused_by_hid(void **state)
{
    (void)state;
    crn_wire_status status;
    crn_wire_track track = client_plain_track();
    track.actuator_lag_us = 500;
    track.coupling_N_per_m = 800;
    track.coupling_uN_m_per_rad = track.coupling_nN_m_s_per_rad = 0;
    client_hello(&host, crn_wire_schema_hash());
    assert_int_equal(client_receive(&host), CRN_WIRE_TYPE_hello_reply);
    client_rig(&host, &track, 1);
    assert_true(client_expect_status(&host, &status));
    assert_int_equal(set_gain(2000), USB_STALLED);
    assert_int_equal(device.app.setup.tracks[0].wire.force_gain_milli, 1000);
    assert_int_equal(set_gain(500), USB_OK);
    assert_int_equal(device.app.setup.tracks[0].wire.force_gain_milli, 500);
}

/* In a FREE_RUN session a state report must come for every tick, in order. */
static void free_run_ticks_come_by_hid_one_by_one(void **state)
{
    (void)state;
    assert_true(client_start_session(&host));
    client_command(&host, CRN_WIRE_ACTION_STOP);
    client_command(&host, CRN_WIRE_ACTION_FREE_RUN);
    client_command(&host, CRN_WIRE_ACTION_START);
    uint32_t tick = next_state().tick;
    for (int i = 0; i < 50; i++) {
        const crn_hid_state report = next_state();
        assert_int_equal(report.tick, tick + 1);
        assert_int_equal(report.mode, CRN_WIRE_MODE_FREE_RUN);
        tick = report.tick;
    }
}

#define TEST(name) cmocka_unit_test_setup(name, set_up)

int main(void)
{
    const struct CMUnitTest tests[] = {
        TEST(a_session_over_usb_gives_the_hashes_of_any_other_pipe),
        TEST(the_serial_number_is_that_of_the_port),
        TEST(no_answer_is_lost_when_the_host_reads_late),
        TEST(hid_shows_the_state_and_takes_power_away),
        TEST(stop_by_hid_passes_a_frame_that_is_half_there),
        TEST(settings_by_hid_obey_the_rules_of_the_wire),
        TEST(a_gain_that_is_not_passive_is_refused_by_hid),
        TEST(free_run_ticks_come_by_hid_one_by_one),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
