/* These tests exchange only bytes with a device, so the same test cases can also run with QEMU and with a
 * rig. The tests cut the byte stream into arbitrary pieces and lose some bytes; a lost byte may destroy only
 * the frame that contained it. A session must give equal state hashes every time. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#include "firmware/tests/reference/client.h"

static client host;
static crn_wire_status status;
static crn_wire_ticks ticks;

static int set_up(void **state)
{
    (void)state;
    client_open(&host, 0);
    return host.sim == NULL;
}

static int tear_down(void **state)
{
    (void)state;
    client_close(&host);
    return 0;
}

static void a_session_gives_the_same_hashes_every_time(void **state)
{
    (void)state;
    crn_wire_tick_state last[2];
    for (int run = 0; run < 2; run++) {
        client_close(&host);
        client_open(&host, 0);
        assert_true(client_start_session(&host));
        for (uint32_t tick = 0; tick < 640; tick += 64) {
            client_step(&host, tick, 64, (int32_t)tick * 25, 25);
            assert_true(client_expect_ticks(&host, &ticks));
        }
        last[run] = ticks.states[63];
    }
    assert_memory_equal(&last[0], &last[1], sizeof last[0]);
}

static void batches_of_one_and_of_many_give_the_same_hashes(void **state)
{
    (void)state;
    assert_true(client_start_session(&host));
    client_step(&host, 0, 64, 0, 25);
    assert_true(client_expect_ticks(&host, &ticks));
    crn_wire_tick_state expected = ticks.states[63];
    client_close(&host);
    client_open(&host, 0);
    assert_true(client_start_session(&host));
    for (uint32_t tick = 0; tick < 64; tick++) {
        client_step(&host, tick, 1, (int32_t)tick * 25, 25);
        assert_true(client_expect_ticks(&host, &ticks));
    }
    assert_memory_equal(&expected, &ticks.states[0], sizeof expected);
}

static void bytes_may_come_one_by_one(void **state)
{
    (void)state;
    const uint8_t get_status[] = {CRN_WIRE_GET_STATUS};
    const crn_wire_header header = {500, 0, CRN_WIRE_TYPE_get};
    assert_true(client_start_session(&host));
    size_t bytes = crn_wire_frame_encode(&header, get_status, 1, host.frame, sizeof host.frame);
    for (size_t i = 0; i < bytes; i++) crn_sim_write(host.sim, host.frame + i, 1);
    assert_true(client_expect_status(&host, &status));
    assert_int_equal(host.decoder.header.answers, 500);
}

/* The test cuts a frame after every possible number of bytes. The device must answer the next frame, and its
 * status must report the lost bytes. */
static void a_frame_cut_anywhere_costs_only_itself(void **state)
{
    (void)state;
    assert_true(client_start_session(&host));
    const uint8_t get_status[] = {CRN_WIRE_GET_STATUS};
    const uint8_t zero = 0;
    const crn_wire_header header = {9, 0, CRN_WIRE_TYPE_get};
    size_t bytes = crn_wire_frame_encode(&header, get_status, 1, host.frame, sizeof host.frame);
    for (size_t cut = 1; cut + 1 < bytes; cut++) {
        size_t again = crn_wire_frame_encode(&header, get_status, 1, host.frame, sizeof host.frame);
        crn_sim_write(host.sim, host.frame, cut);
        crn_sim_write(host.sim, &zero, 1);
        crn_sim_write(host.sim, host.frame, again);
        assert_true(client_expect_status(&host, &status));
        assert_int_equal(status.frames_bad, cut);
        assert_int_equal(client_receive(&host), 0);
    }
}

/* When a host never reads, the pipe becomes full. If the pipe is full, the device counts the messages that it
 * could not send, and still carries out commands. */
static void a_host_that_does_not_read_loses_frames_and_nothing_else(void **state)
{
    (void)state;
    assert_true(client_start_session(&host));
    for (int i = 0; i < 400; i++) client_get(&host, CRN_WIRE_GET_NODE_TABLE);
    for (int i = 0; i < 50; i++) client_get(&host, CRN_WIRE_GET_SNAPSHOT);
    while (client_receive(&host) != 0) {
    }
    client_step(&host, 0, 1, 0, 0);
    assert_true(client_expect_ticks(&host, &ticks));
    client_get(&host, CRN_WIRE_GET_STATUS);
    assert_true(client_expect_status(&host, &status));
    assert_true(status.transmit_dropped > 0);
    assert_int_equal(status.tick, 1);
}

static void nodes_run_from_the_tip_into_the_inserter(void **state)
{
    (void)state;
    static crn_wire_nodes nodes;
    static crn_wire_node_table table;
    assert_true(client_start_session(&host));
    client_get(&host, CRN_WIRE_GET_NODES);
    assert_int_equal(client_receive(&host), CRN_WIRE_TYPE_nodes);
    assert_true(crn_wire_decode_nodes(host.decoder.payload, host.decoder.payload_bytes, &nodes));
    client_get(&host, CRN_WIRE_GET_NODE_TABLE);
    assert_int_equal(client_receive(&host), CRN_WIRE_TYPE_node_table);
    assert_true(crn_wire_decode_node_table(host.decoder.payload, host.decoder.payload_bytes, &table));
    /* 50 mm outside along +y, so the tip is at y = 50 mm and the last node is at or behind the inserter's
     * distal end */
    assert_in_range(nodes.positions[0].y_m_q30, 53687091 - 1100, 53687091 + 1100);
    assert_true(nodes.positions[nodes.positions_count - 1].y_m_q30 <= 0);
    assert_true(nodes.positions_count <= table.arcs_m_q30_count);
    assert_int_equal(table.arcs_m_q30[0], 0);
}

#define TEST(name) cmocka_unit_test_setup_teardown(name, set_up, tear_down)

int main(void)
{
    const struct CMUnitTest tests[] = {
        TEST(a_session_gives_the_same_hashes_every_time),
        TEST(batches_of_one_and_of_many_give_the_same_hashes),
        TEST(bytes_may_come_one_by_one),
        TEST(a_frame_cut_anywhere_costs_only_itself),
        TEST(a_host_that_does_not_read_loses_frames_and_nothing_else),
        TEST(nodes_run_from_the_tip_into_the_inserter),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
