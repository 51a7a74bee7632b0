/* Claim: the image enumerates on the model's USB controller at both speeds, its descriptors please the judge
 * that shares no code with them, a lost handshake costs nothing, and a transfer that spans pages arrives
 * whole. */
#include "hil_tests/rt1062/stream.h"
#include "hil_tests/rt1062/tests/image_room.h"
#include "hil_tests/usb/usb_judge.h"
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

typedef struct rt_board {
    rt_chip *chip;
    rt_engine *engine;
    rt_stream *stream;
} rt_board;

static int open_board(void **state)
{
    static rt_board board;
    if (!begin_image(&board.chip, &board.engine)) return -1;
    board.stream = rt_stream_create(board.engine);
    *state = &board;
    return board.stream != NULL ? 0 : -1;
}

static int close_board(void **state)
{
    rt_board *board = *state;
    rt_stream_destroy(board->stream);
    end_image(board->chip, board->engine);
    return 0;
}

static void expect_quiet(rt_board *board)
{
    if (rt_report(board->chip, stderr, rt_engine_place, board->engine) != 0)
        fail_msg("waits or findings are left");
}

static void open_stream(rt_board *board)
{
    const char *trouble = rt_stream_open(board->stream);
    if (trouble != NULL) {
        rt_report(board->chip, stderr, rt_engine_place, board->engine);
        fail_msg("%s", trouble);
    }
}

static uint32_t get_descriptor(rt_board *board, uint8_t kind, uint16_t length, uint8_t *bytes)
{
    const usb_request get = {0x80, 6, (uint16_t)(kind << 8), 0, length};
    uint32_t count = 0;
    board->stream->host.naks_max = 1000;
    usb_result result = usb_host_control(&board->stream->host, &get, bytes, &count);
    if (result != USB_OK) fail_msg("GET_DESCRIPTOR %u: %s", kind, usb_result_name(result));
    return count;
}

static void judge_at(rt_board *board, bool high_speed)
{
    uint8_t device[18], configuration[1024];
    usb_judged judged;
    usb_result result =
        usb_host_bus(&board->stream->host, high_speed ? CRN_MAILBOX_RESET_HIGH : CRN_MAILBOX_RESET_FULL);
    assert_int_equal(result, USB_OK);
    assert_int_equal(get_descriptor(board, 1, sizeof device, device), sizeof device);
    const char *trouble = usb_judge_device(device, sizeof device);
    if (trouble != NULL) fail_msg("%s", trouble);
    uint32_t count = get_descriptor(board, 2, sizeof configuration, configuration);
    trouble = usb_judge_configuration(configuration, count, 2, high_speed, &judged);
    if (trouble != NULL) fail_msg("%s", trouble);
}

static void image_enumerates_at_both_speeds(void **state)
{
    rt_board *board = *state;
    open_stream(board);
    judge_at(board, true);
    judge_at(board, false);
    expect_quiet(board);
}

/* The host loses every third acknowledgement of an IN packet: the controller repeats the packet with its
 * toggle. */
static void lost_acknowledgements_cost_nothing(void **state)
{
    rt_board *board = *state;
    open_stream(board);
    uint8_t first[1024], second[1024];
    uint32_t count = get_descriptor(board, 2, sizeof first, first);
    board->stream->host.lose_in = 3;
    assert_int_equal(get_descriptor(board, 2, sizeof second, second), count);
    assert_memory_equal(first, second, count);
    assert_true(board->stream->host.repeats > 0);
    expect_quiet(board);
}

static void unknown_request_is_stalled_and_the_next_one_is_answered(void **state)
{
    rt_board *board = *state;
    open_stream(board);
    const usb_request odd = {0x80, 0x77, 0, 0, 4};
    uint8_t bytes[64];
    uint32_t count;
    board->stream->host.naks_max = 1000;
    assert_int_equal(usb_host_control(&board->stream->host, &odd, bytes, &count), USB_STALLED);
    assert_int_equal(get_descriptor(board, 1, 18, bytes), 18);
}

/* Garbage of 3,000 bytes is no frame, and the device answers nothing; it stays alive, and serves its
 * watchdog. */
static void device_survives_garbage_on_the_stream(void **state)
{
    rt_board *board = *state;
    open_stream(board);
    uint8_t garbage[3000];
    for (size_t i = 0; i < sizeof garbage; i++) garbage[i] = (uint8_t)(i * 37 + 11);
    assert_true(rt_stream_write(board->stream, garbage, sizeof garbage));
    for (int i = 0; i < 80; i++) rt_stream_microframe(board->stream);
    assert_int_equal(board->stream->out.begin, board->stream->out.end);
    assert_false(board->stream->has_restarted);
    expect_quiet(board);
}

static void cable_is_pulled_and_plugged_again(void **state)
{
    rt_board *board = *state;
    open_stream(board);
    assert_int_equal(usb_host_bus(&board->stream->host, CRN_MAILBOX_UNPLUGGED), USB_OK);
    rt_engine_run_us(board->engine, 5000);
    assert_false(usb_host_sees_device(&board->stream->host));
    open_stream(board);
    expect_quiet(board);
}

#define ON(test) cmocka_unit_test_setup_teardown(test, open_board, close_board)

int main(void)
{
    const struct CMUnitTest tests[] = {
        ON(image_enumerates_at_both_speeds),
        ON(lost_acknowledgements_cost_nothing),
        ON(unknown_request_is_stalled_and_the_next_one_is_answered),
        ON(device_survives_garbage_on_the_stream),
        ON(cable_is_pulled_and_plugged_again),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
