/* These tests check the data in the USB pipes of the device. The bytes of the stream must arrive complete and
 * in order, whatever the packet size is and whichever packets are lost. If a host does not read, the device
 * must wait and keep its data. If a transfer is interrupted by a reset, a halt, a suspend or an unplugged
 * cable, only the frames in that transfer may be lost. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#include "firmware/tests/reference/random.h"
#include "hil_tests/usb/usb_rig.h"

enum { STREAM = 2, STATUS = 1, PACKET = 512 };

static usb_rig rig;
static uint8_t bytes[1 << 16];
static uint32_t count;

static void open_stream(void)
{
    usb_rig_open(&rig, true);
    assert_int_equal(usb_rig_configure(&rig, true), USB_OK);
    assert_int_equal(usb_host_packet_in(&rig.host, STREAM, bytes, PACKET, &count), USB_OK);
    assert_int_equal(count, 1); /* the zero that begins a stream */
    assert_int_equal(bytes[0], 0);
}

static int set_up(void **state)
{
    (void)state;
    open_stream();
    return 0;
}

/* Writes `length` bytes, of which only the last byte is zero, as in a frame of the wire protocol. */
static void make_frame(reference_random *random, uint8_t *frame, uint32_t length)
{
    for (uint32_t i = 0; i + 1 < length; i++) frame[i] = (uint8_t)(1 + reference_random_below(random, 255));
    frame[length - 1] = 0;
}

static void echo(const uint8_t *frame, uint32_t length)
{
    static uint8_t back[1 << 14];
    assert_int_equal(usb_host_out(&rig.host, STREAM, PACKET, frame, length), USB_OK);
    uint32_t got = 0;
    while (got < length) { /* in one read, or two where the queue's ring wraps */
        assert_int_equal(
            usb_host_in(&rig.host, STREAM, PACKET, back + got, (uint32_t)sizeof back - got, &count), USB_OK);
        got += count;
    }
    assert_int_equal(got, length);
    assert_memory_equal(back, frame, length);
}

/* The test uses lengths around every multiple of the packet size. An empty packet must follow if the last
 * packet is full, because the host's read would not end without it. */
static void frames_of_any_length_come_back(void **state)
{
    (void)state;
    static uint8_t frame[CRN_WIRE_FRAME_MAX];
    reference_random random = reference_random_seed(1);
    for (uint32_t length = 2; length < 20; length++) {
        make_frame(&random, frame, length);
        echo(frame, length);
    }
    for (uint32_t packets = 1; packets * PACKET + 2 < CRN_WIRE_FRAME_MAX; packets++) {
        for (uint32_t length = packets * PACKET - 2; length <= packets * PACKET + 2; length++) {
            make_frame(&random, frame, length);
            echo(frame, length);
        }
    }
    make_frame(&random, frame, CRN_WIRE_FRAME_MAX);
    echo(frame, CRN_WIRE_FRAME_MAX);
    assert_int_equal(rig.frames_lost, 0);
}

static uint32_t fill_stream(reference_random *random, uint8_t *sent, uint32_t capacity)
{
    uint32_t length = 0;
    for (;;) {
        uint32_t frame =
            2 + reference_random_below(random, reference_random_below(random, 4) == 0 ? 5000 : 60);
        if (length + frame > capacity) return length;
        make_frame(random, sent + length, frame);
        length += frame;
    }
}

/* The test sends 64 KiB of frames in packets of random length (also empty ones), with reads at random times
 * and lost acknowledgements. */
static void random_packets(uint64_t seed)
{
    reference_random random = reference_random_seed(seed);
    static uint8_t sent[1 << 16], back[1 << 16];
    const uint32_t length = fill_stream(&random, sent, sizeof sent);
    uint32_t written = 0, read = 0, idle = 0;
    rig.host.naks_max = 1; /* a packet that is held is tried again later */
    rig.host.lose_in = 2 + reference_random_below(&random, 9);
    rig.host.lose_out = 2 + reference_random_below(&random, 9);
    while (read < length && idle < 100000) {
        if (written < length && reference_random_below(&random, 2)) {
            uint32_t packet =
                reference_random_below(&random, 8) == 0 ? 0 : 1 + reference_random_below(&random, PACKET);
            if (packet > length - written) packet = length - written;
            usb_result result = usb_host_packet_out(&rig.host, STREAM, sent + written, packet);
            assert_true(result == USB_OK || result == USB_NAKED);
            if (result == USB_OK) written += packet;
        } else {
            usb_result result = usb_host_packet_in(&rig.host, STREAM, bytes, PACKET, &count);
            assert_true(result == USB_OK || result == USB_NAKED);
            if (result == USB_OK) {
                assert_true(count <= length - read);
                memcpy(back + read, bytes, count);
                read += count;
            }
        }
        idle++;
    }
    assert_int_equal(read, length);
    assert_memory_equal(back, sent, length);
    assert_int_equal(rig.frames_lost, 0);
}

static void random_packets_arrive_whole_and_in_order(void **state)
{
    (void)state;
    for (uint64_t seed = 1; seed <= 40; seed++) {
        open_stream();
        print_message("random_packets(%u)\n", (unsigned)seed);
        random_packets(seed);
    }
}

/* The host writes and never reads. When there might be no space for a reply, the device must answer NAK to
 * the host's packets, and must not lose any packet. */
static void a_host_that_does_not_read_is_held(void **state)
{
    (void)state;
    static uint8_t frame[4000];
    reference_random random = reference_random_seed(3);
    uint32_t written = 0;
    usb_result result = USB_OK;
    make_frame(&random, frame, sizeof frame);
    for (int i = 0; i < 20 && result == USB_OK; i++) {
        result = usb_host_out(&rig.host, STREAM, PACKET, frame, sizeof frame);
        if (result == USB_OK) written++;
    }
    assert_int_equal(result, USB_NAKED);
    assert_int_equal(rig.frames_lost, 0);
    assert_in_range(written, 2, 6); /* the queue holds the longest answer, which grew with protocol 6 */
    /* Every frame that the device accepted must come back to the host; the frame that the device interrupted
     * by NAK stays incomplete.
     * */
    uint32_t got = 0;
    while (got < written * sizeof frame) {
        assert_int_equal(usb_host_packet_in(&rig.host, STREAM, bytes + got, PACKET, &count), USB_OK);
        got += count;
    }
    assert_int_equal(got, written * sizeof frame);
    for (uint32_t i = 0; i < written; i++) assert_memory_equal(bytes + i * sizeof frame, frame, sizeof frame);
    assert_int_equal(rig.frames_lost, 0);
}

/* If the queue has no space for a whole frame, the device must refuse the frame and put no part of it into
 * the queue. Before the device refuses a frame, it must report how much space is free. */
static void a_full_queue_refuses_whole_frames(void **state)
{
    (void)state;
    static const uint8_t filler[1000] = {1};
    uint32_t taken = 0;
    while (crn_usb_transmit(&rig.usb, filler, sizeof filler)) taken++;
    assert_int_equal(taken, USB_RIG_QUEUE_BYTES / sizeof filler);
    assert_int_equal(crn_usb_queue_room(&rig.usb), USB_RIG_QUEUE_BYTES - taken * sizeof filler);
    assert_int_equal(rig.usb.frames_refused, 1);
    assert_true(crn_usb_transmit(&rig.usb, filler, crn_usb_queue_room(&rig.usb)));
    uint32_t got = 0;
    while (got < USB_RIG_QUEUE_BYTES) {
        assert_int_equal(usb_host_in(&rig.host, STREAM, PACKET, bytes, sizeof bytes, &count), USB_OK);
        got += count;
    }
    assert_int_equal(got, USB_RIG_QUEUE_BYTES);
    assert_int_equal(crn_usb_queue_room(&rig.usb), USB_RIG_QUEUE_BYTES);
}

static void nobody_is_configured_so_nothing_is_queued(void **state)
{
    (void)state;
    assert_int_equal(usb_host_bus(&rig.host, CRN_MAILBOX_RESET_HIGH), USB_OK);
    assert_int_equal(rig.link, CRN_USB_DETACHED);
    assert_int_equal(crn_usb_queue_room(&rig.usb), 0);
    assert_false(crn_usb_transmit(&rig.usb, (const uint8_t *)"\1", 2));
}

/* Lists interruptions of a conversation. After every kind of interruption the host must be able to begin
 * again. */
typedef enum interruption {
    RESET,
    HALT_IN,
    HALT_OUT,
    CONFIGURE,
    INTERFACE,
    UNPLUG,
    REBOOT,
    INTERRUPTIONS
} interruption;

static void interrupt(interruption kind)
{
    rig.host.lose_in = rig.host.lose_out = 0;
    switch (kind) {
    case HALT_IN:
        usb_rig_control(&rig, 0x02, 3, 0, 0x82, 0, NULL, NULL);
        assert_int_equal(usb_host_clear_halt(&rig.host, 0x82), USB_OK);
        assert_int_equal(usb_host_clear_halt(&rig.host, 0x02), USB_OK);
        return;
    case HALT_OUT:
        usb_rig_control(&rig, 0x02, 3, 0, 0x02, 0, NULL, NULL);
        assert_int_equal(usb_host_clear_halt(&rig.host, 0x02), USB_OK);
        assert_int_equal(usb_host_clear_halt(&rig.host, 0x82), USB_OK);
        return;
    case CONFIGURE:
        assert_int_equal(usb_rig_control(&rig, 0x00, 9, 1, 0, 0, NULL, NULL), USB_OK);
        break;
    case INTERFACE:
        assert_int_equal(usb_rig_control(&rig, 0x01, 11, 0, 1, 0, NULL, NULL), USB_OK);
        break;
    case UNPLUG:
        assert_int_equal(usb_host_bus(&rig.host, CRN_MAILBOX_UNPLUGGED), USB_OK);
        assert_int_equal(rig.link, CRN_USB_DETACHED);
        assert_int_equal(usb_rig_configure(&rig, true), USB_OK);
        return;
    case REBOOT:
        usb_rig_reboot(&rig, true);
        assert_int_not_equal(rig.mailbox.device.boot_count, rig.host.boot_count);
        assert_int_equal(usb_rig_configure(&rig, true), USB_OK);
        return;
    default:
        assert_int_equal(usb_rig_configure(&rig, true), USB_OK);
        return;
    }
    memset(rig.host.toggle_in, 0, sizeof rig.host.toggle_in);
    memset(rig.host.toggle_out, 0, sizeof rig.host.toggle_out);
}

/* Reads all bytes that wait for the host; the first byte must be the zero that begins a stream. */
static void drain_new_stream(void)
{
    uint32_t total = 0;
    rig.host.naks_max = 3;
    while (usb_host_packet_in(&rig.host, STREAM, bytes + total, PACKET, &count) == USB_OK) total += count;
    rig.host.naks_max = USB_RIG_NAKS_MAX;
    assert_true(total > 0);
    assert_int_equal(bytes[0], 0);
}

/* The test interrupts the exchange of data after every possible number of packets in each direction. After
 * the interruption a new stream begins, and the next frame must come back. */
static void interruptions_cost_only_what_was_under_way(void **state)
{
    (void)state;
    static uint8_t frame[3000];
    reference_random random = reference_random_seed(11);
    make_frame(&random, frame, sizeof frame);
    for (int kind = 0; kind < INTERRUPTIONS; kind++) {
        for (int packets_out = 0; packets_out <= 6; packets_out++) {
            for (int packets_in = 0; packets_in <= (packets_out == 6 ? 5 : 0); packets_in++) {
                uint32_t sent = 0;
                open_stream();
                for (int i = 0; i < packets_out; i++) {
                    uint32_t packet =
                        (uint32_t)sizeof frame - sent < PACKET ? (uint32_t)sizeof frame - sent : PACKET;
                    assert_int_equal(usb_host_packet_out(&rig.host, STREAM, frame + sent, packet), USB_OK);
                    sent += packet;
                }
                for (int i = 0; i < packets_in; i++)
                    assert_int_equal(usb_host_packet_in(&rig.host, STREAM, bytes, PACKET, &count), USB_OK);
                interrupt((interruption)kind);
                drain_new_stream();
                echo(frame, sizeof frame);
                assert_int_equal(rig.link, CRN_USB_CONFIGURED);
            }
        }
    }
}

/* --- HID ------------------------------------------------------------------------------------------------ */
static uint32_t next_report_tick(void)
{
    crn_hid_state report;
    assert_int_equal(usb_host_packet_in(&rig.host, STATUS, bytes, 64, &count), USB_OK);
    assert_int_equal(count, 64);
    assert_int_equal(bytes[0], CRN_HID_ID_state);
    assert_true(crn_hid_decode_state(bytes + 1, count - 1, &report));
    return report.tick;
}

/* The device must send exactly one state report for every tick. If a host reads late, it must get up to 64 ms
 * of waiting reports, and in addition the one report that is being transferred. */
static void state_reports_follow_the_ticks(void **state)
{
    (void)state;
    rig.host.naks_max = 3;
    assert_int_equal(usb_host_packet_in(&rig.host, STATUS, bytes, 64, &count), USB_NAKED);
    for (uint32_t tick = 1; tick <= 100; tick++) {
        usb_rig_tick(&rig);
        assert_int_equal(next_report_tick(), tick);
        assert_int_equal(usb_host_packet_in(&rig.host, STATUS, bytes, 64, &count), USB_NAKED);
    }
    for (uint32_t tick = 101; tick <= 400; tick++) {
        usb_rig_tick(&rig);
        usb_rig_settle(&rig);
    }
    assert_int_equal(next_report_tick(), 101);
    assert_int_equal(rig.usb.reports_dropped, 400 - 101 - CRN_USB_REPORT_QUEUE);
    for (uint32_t tick = 401 - CRN_USB_REPORT_QUEUE; tick <= 400; tick++)
        assert_int_equal(next_report_tick(), tick);
    assert_int_equal(usb_host_packet_in(&rig.host, STATUS, bytes, 64, &count), USB_NAKED);
}

/* Every field of a state report must have the same value after encoding and decoding, at both ends of its
 * range. */
static void state_reports_carry_every_field(void **state)
{
    (void)state;
    crn_hid_state sent = {.tick = UINT32_MAX, .state = 4, .mode = 1, .fault_code = 0xabcd, .buttons = 0x81};
    crn_hid_state report;
    sent.command_number = 255;
    sent.command_result = 7;
    sent.syringe_counts = INT32_MIN;
    sent.inflator_raw = INT32_MAX;
    sent.lines = 0x1f;
    sent.fault_count = 200;
    for (int k = 0; k < 3; k++)
        sent.tracks[k] = (crn_hid_track){INT32_MIN + k, INT32_MAX - k, (int16_t)(-8000 - k), INT16_MAX,
                                         (int16_t)(INT16_MIN + k)};
    crn_usb_timer(&rig.usb, &sent);
    assert_int_equal(usb_host_packet_in(&rig.host, STATUS, bytes, 64, &count), USB_OK);
    assert_true(crn_hid_decode_state(bytes + 1, count - 1, &report));
    assert_int_equal(report.tick, sent.tick);
    assert_int_equal(report.state, sent.state);
    assert_int_equal(report.mode, sent.mode);
    assert_int_equal(report.fault_code, sent.fault_code);
    assert_int_equal(report.command_number, sent.command_number);
    assert_int_equal(report.command_result, sent.command_result);
    assert_int_equal(report.buttons, sent.buttons);
    for (int k = 0; k < 3; k++) {
        assert_int_equal(report.tracks[k].translation_counts, sent.tracks[k].translation_counts);
        assert_int_equal(report.tracks[k].rotation_counts, sent.tracks[k].rotation_counts);
        assert_int_equal(report.tracks[k].motor_axial_mN, sent.tracks[k].motor_axial_mN);
        assert_int_equal(report.tracks[k].motor_torque_uN_m, sent.tracks[k].motor_torque_uN_m);
        assert_int_equal(report.tracks[k].sensor_axial_mN, sent.tracks[k].sensor_axial_mN);
    }
    assert_int_equal(report.syringe_counts, sent.syringe_counts);
    assert_int_equal(report.inflator_raw, sent.inflator_raw);
    assert_int_equal(report.lines, sent.lines);
    assert_int_equal(report.fault_count, sent.fault_count);
}

static void commands_come_by_pipe_and_by_control(void **state)
{
    (void)state;
    static const uint8_t command[12] = {
        CRN_HID_ID_command, 5, 3, 1, 0xff, 0xff, 0xff, 0xff, 0x10, 0x27, 0, 0};
    assert_int_equal(usb_host_out(&rig.host, STATUS, 64, command, sizeof command), USB_OK);
    usb_rig_settle(&rig);
    assert_int_equal(rig.commands, 1);
    assert_int_equal(rig.command.number, 5);
    assert_int_equal(rig.command.action, 3);
    assert_int_equal(rig.command.track, 1);
    assert_int_equal(rig.command.value1, -1);
    assert_int_equal(rig.command.value2, 10000);
    memcpy(bytes, command, sizeof command);
    bytes[1] = 6;
    assert_int_equal(usb_rig_control(&rig, 0x21, 9, 0x0200 | CRN_HID_ID_command, 0, 12, bytes, NULL), USB_OK);
    assert_int_equal(rig.commands, 2);
    assert_int_equal(rig.command.number, 6);
}

/* The device must count invalid reports and still accept the next report. A padded report is accepted. */
static void broken_commands_are_counted_and_the_pipe_stays_open(void **state)
{
    (void)state;
    uint8_t command[64] = {CRN_HID_ID_command, 1};
    assert_int_equal(usb_host_packet_out(&rig.host, STATUS, command, 0), USB_OK);
    assert_int_equal(usb_host_packet_out(&rig.host, STATUS, command, 11), USB_OK);
    command[0] = CRN_HID_ID_state;
    assert_int_equal(usb_host_packet_out(&rig.host, STATUS, command, 12), USB_OK);
    usb_rig_settle(&rig);
    assert_int_equal(rig.usb.reports_refused, 3);
    assert_int_equal(rig.commands, 0);
    command[0] = CRN_HID_ID_command;
    assert_int_equal(usb_host_packet_out(&rig.host, STATUS, command, 64), USB_OK);
    usb_rig_settle(&rig);
    assert_int_equal(rig.commands, 1);
}

/* Limits can be lowered but not raised; if the device refuses a HID report with limits, it must not apply any
 * part of this report. */
static void settings_are_read_back_and_refused(void **state)
{
    (void)state;
    crn_hid_limits limits, back;
    const uint16_t value = 0x0300 | CRN_HID_ID_limits;
    assert_int_equal(usb_rig_control(&rig, 0xa1, 1, value, 0, 64, bytes, &count), USB_OK);
    assert_true(crn_hid_decode_limits(bytes + 1, count - 1, &limits));
    limits.tracks[1].force_limit_mN = 3000;
    crn_wire_writer writer = crn_wire_writer_make(bytes + 1, 63);
    crn_hid_put_limits(&writer, &limits);
    assert_int_equal(usb_rig_control(&rig, 0x21, 9, value, 0, 25, bytes, NULL), USB_OK);
    limits.tracks[0].force_limit_mN = 1000;
    limits.tracks[1].force_limit_mN = 3001;
    writer = crn_wire_writer_make(bytes + 1, 63);
    crn_hid_put_limits(&writer, &limits);
    assert_int_equal(usb_rig_control(&rig, 0x21, 9, value, 0, 25, bytes, NULL), USB_STALLED);
    assert_int_equal(usb_rig_control(&rig, 0xa1, 1, value, 0, 64, bytes, &count), USB_OK);
    assert_true(crn_hid_decode_limits(bytes + 1, count - 1, &back));
    assert_int_equal(back.tracks[0].force_limit_mN, 8000);
    assert_int_equal(back.tracks[1].force_limit_mN, 3000);
}

/* --- the bus -------------------------------------------------------------------------------------------- */
/* While the bus is suspended, the device must send no new report. After the bus resumes, the device must
 * continue where it stopped, with complete frames and correct data toggles. */
static void suspend_keeps_everything(void **state)
{
    (void)state;
    static const uint8_t frame[] = {7, 7, 7, 0};
    assert_int_equal(usb_host_out(&rig.host, STREAM, PACKET, frame, sizeof frame), USB_OK);
    usb_rig_settle(&rig);
    assert_int_equal(usb_host_bus(&rig.host, CRN_MAILBOX_SUSPENDED), USB_OK);
    assert_int_equal(rig.link, CRN_USB_SUSPENDED);
    assert_true(crn_usb_transmit(&rig.usb, frame, sizeof frame));
    usb_rig_tick(&rig);
    usb_rig_settle(&rig);
    assert_false(rig.usb.is_armed[CRN_USB_STATUS_IN]);
    assert_int_equal(usb_host_bus(&rig.host, CRN_MAILBOX_RESUMED), USB_OK);
    assert_int_equal(rig.link, CRN_USB_CONFIGURED);
    assert_int_equal(usb_host_in(&rig.host, STREAM, PACKET, bytes, 4, &count), USB_OK);
    assert_memory_equal(bytes, frame, sizeof frame);
    assert_int_equal(usb_host_in(&rig.host, STREAM, PACKET, bytes, 4, &count), USB_OK);
    assert_memory_equal(bytes, frame, sizeof frame);
    rig.host.naks_max = 3;
    assert_int_equal(usb_host_packet_in(&rig.host, STATUS, bytes, 64, &count), USB_NAKED);
    usb_rig_tick(&rig);
    assert_int_equal(next_report_tick(), 2);
    /* A reset also wakes it. */
    assert_int_equal(usb_host_bus(&rig.host, CRN_MAILBOX_SUSPENDED), USB_OK);
    assert_int_equal(usb_rig_configure(&rig, true), USB_OK);
    assert_int_equal(rig.link, CRN_USB_CONFIGURED);
}

/* The device must disconnect itself when the host requests it, and come back after the requested number of
 * milliseconds. */
static void the_device_unplugs_itself_on_request(void **state)
{
    (void)state;
    assert_int_equal(usb_rig_control(&rig, 0x40, CRN_USB_REQUEST_UNPLUG, 250, 0, 0, NULL, NULL), USB_OK);
    usb_rig_settle(&rig);
    assert_false(usb_host_sees_device(&rig.host));
    assert_int_equal(rig.link, CRN_USB_DETACHED);
    assert_int_equal(usb_host_packet_in(&rig.host, STATUS, bytes, 64, &count), USB_SILENT);
    for (int i = 0; i < 249; i++) usb_rig_tick(&rig);
    assert_false(usb_host_sees_device(&rig.host));
    usb_rig_tick(&rig);
    assert_true(usb_host_sees_device(&rig.host));
    assert_int_equal(usb_rig_control(&rig, 0x80, 8, 0, 0, 1, bytes, &count), USB_SILENT); /* before a reset */
    assert_int_equal(usb_rig_configure(&rig, true), USB_OK);
    drain_new_stream();
    echo((const uint8_t *)"\1\2\3", 4);
}

/* The device disconnects itself at the third packet of a transfer of five packets. The host sees the transfer
 * end in the middle, and the app never receives the third packet. */
static void the_device_unplugs_itself_within_a_transfer(void **state)
{
    (void)state;
    static uint8_t frame[5 * 512];
    memset(frame, 'x', sizeof frame);
    const uint32_t before = rig.bytes_in;
    assert_int_equal(usb_rig_control(&rig, 0x40, CRN_USB_REQUEST_UNPLUG, 20, 3, 0, NULL, NULL), USB_OK);
    usb_rig_settle(&rig);
    assert_true(usb_host_sees_device(&rig.host));
    assert_int_not_equal(usb_host_out(&rig.host, STREAM, 512, frame, sizeof frame), USB_OK);
    assert_int_equal(rig.bytes_in - before, 2 * 512);
    assert_false(usb_host_sees_device(&rig.host));
    assert_int_equal(rig.link, CRN_USB_DETACHED);
    for (int i = 0; i < 20; i++) usb_rig_tick(&rig);
    assert_int_equal(usb_rig_configure(&rig, true), USB_OK);
    drain_new_stream();
    echo((const uint8_t *)"\1\2\3", 4);
}

/* The test suspends and resumes a disconnected device, and sends tokens without a bus reset. The device must
 * not answer tokens that come without a bus reset, and must work again after the host has configured it. */
static void a_bus_out_of_order_is_survived(void **state)
{
    (void)state;
    assert_int_equal(usb_host_bus(&rig.host, CRN_MAILBOX_UNPLUGGED), USB_OK);
    assert_int_equal(usb_host_bus(&rig.host, CRN_MAILBOX_RESUMED), USB_OK);
    assert_int_equal(usb_host_bus(&rig.host, CRN_MAILBOX_SUSPENDED), USB_OK);
    assert_int_equal(usb_host_bus(&rig.host, (crn_mailbox_bus)99), USB_OK);
    assert_int_equal(usb_host_packet_out(&rig.host, STREAM, bytes, 10), USB_SILENT);
    assert_int_equal(rig.link, CRN_USB_DETACHED);
    assert_int_equal(usb_rig_configure(&rig, true), USB_OK);
    drain_new_stream();
    echo((const uint8_t *)"\1\2\3", 4);
}

/* The test sends tokens that no real host sends: too long, to endpoints that do not exist, or of an unknown
 * kind. The device must not answer invalid tokens, and must continue to work. */
static void malformed_tokens_are_not_answered(void **state)
{
    (void)state;
    static const struct {
        uint32_t kind, endpoint, flags, count;
    } tokens[] = {{CRN_MAILBOX_OUT, STREAM, 0, PACKET + 1},
                  {CRN_MAILBOX_OUT, STREAM, 0, UINT32_MAX},
                  {CRN_MAILBOX_OUT, 16, 0, 1},
                  {CRN_MAILBOX_IN, 0xffffffff, 0, 0},
                  {CRN_MAILBOX_SETUP, 0, 0, 7},
                  {CRN_MAILBOX_SETUP, 0, CRN_MAILBOX_DATA1, 8},
                  {CRN_MAILBOX_SETUP, 1, 0, 8},
                  {0, 0, 0, 0},
                  {0xdeadbeef, 0, 0, 0}};
    for (size_t i = 0; i < sizeof tokens / sizeof tokens[0]; i++) {
        crn_mailbox_host_half *half = &rig.mailbox.host;
        crn_mailbox_write(&half->token_kind, tokens[i].kind);
        crn_mailbox_write(&half->token_endpoint, tokens[i].endpoint);
        crn_mailbox_write(&half->token_flags, tokens[i].flags);
        crn_mailbox_write(&half->token_bytes, tokens[i].count);
        crn_mailbox_write(&half->token_address, 5);
        crn_mailbox_write(&half->token, crn_mailbox_read(&half->token) + 1);
        usb_rig_settle(&rig);
        assert_int_equal(crn_mailbox_read(&rig.mailbox.device.token_done), crn_mailbox_read(&half->token));
        assert_int_equal(crn_mailbox_read(&rig.mailbox.device.reply), CRN_MAILBOX_SILENCE);
    }
    echo((const uint8_t *)"\1\2\3", 4);
}

#define TEST(name) cmocka_unit_test_setup(name, set_up)

int main(void)
{
    const struct CMUnitTest tests[] = {
        TEST(frames_of_any_length_come_back),
        TEST(random_packets_arrive_whole_and_in_order),
        TEST(a_host_that_does_not_read_is_held),
        TEST(a_full_queue_refuses_whole_frames),
        TEST(nobody_is_configured_so_nothing_is_queued),
        TEST(interruptions_cost_only_what_was_under_way),
        TEST(state_reports_follow_the_ticks),
        TEST(state_reports_carry_every_field),
        TEST(commands_come_by_pipe_and_by_control),
        TEST(broken_commands_are_counted_and_the_pipe_stays_open),
        TEST(settings_are_read_back_and_refused),
        TEST(suspend_keeps_everything),
        TEST(the_device_unplugs_itself_on_request),
        TEST(the_device_unplugs_itself_within_a_transfer),
        TEST(a_bus_out_of_order_is_survived),
        TEST(malformed_tokens_are_not_answered),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
