/* These tests check the exchange of tools through bytes on the simulated port. The host sets up a table of
 * tools and a line (the tools inserted one inside another). An order `exchange` is carried out before its
 * tick, and the state that the tick reports contains the answer. A refused exchange changes nothing except
 * the answer in the tick's state. A FREE_RUN session with exchanges replays in LOCKSTEP bit for bit, and a
 * snapshot says which tools are nested. After an exchange the force on the hand goes to zero, as when the
 * hand lets go. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "firmware/app/app.h"
#include "firmware/tests/reference/bench_session.h"

enum { WIRE = 1, CATHETER, GUIDE, OTHER_WIRE, OTHER_CATHETER, TABLE = 5 };
enum { INNER, MIDDLE, OUTER, POSITIONS };

static crn_wire_tools tools;
static crn_wire_reject reject;
static int32_t hands_um[POSITIONS];
static uint32_t tick_now;

/* The table contains a wire, a catheter, a guide, a second wire and a second catheter. */
static void make_tools(const uint8_t *line, uint16_t line_count)
{
    client_plain_tools(&tools, 3);
    tools.tools[OTHER_WIRE - 1] = tools.tools[WIRE - 1];
    tools.tools[OTHER_CATHETER - 1] = tools.tools[CATHETER - 1];
    tools.tools[OTHER_WIRE - 1].knots[0].bend_stiffness_nN_m2 /= 2;
    tools.tools_count = TABLE;
    tools.line_count = line_count;
    memcpy(tools.line, line, line_count);
}

static void set_up_line(const uint8_t *line, const uint32_t *inserted_um)
{
    make_tools(line, POSITIONS);
    client_tools(&b.host, &tools);
    assert_true(client_expect_status(&b.host, &status));
    client_entry_each(&b.host, inserted_um, POSITIONS);
    assert_true(client_expect_status(&b.host, &status));
    memset(hands_um, 0, sizeof hands_um);
    tick_now = 0;
}

/* Begins a session with a wire inside a guide; the position between them has no tool, and the wire is
 * inserted by `wire_um`. */
static void begin(uint32_t wire_um)
{
    static const uint8_t line[] = {WIRE, 0, GUIDE};
    const uint32_t inserted_um[] = {wire_um, 0, 80000};
    bench_drain(&b);
    set_up_line(line, inserted_um);
    start_lockstep();
}

static void fill(crn_wire_tick_input *input)
{
    input->hands_count = POSITIONS;
    for (int k = 0; k < POSITIONS; k++) input->hands[k].translation_counts = hands_um[k];
}

/* Computes one tick with an order to exchange a tool, and returns the answer to this order. */
static uint8_t exchange(uint8_t position, uint8_t tool)
{
    static crn_wire_step step;
    step = (crn_wire_step){.tick = tick_now++, .inputs_count = 1};
    fill(&step.inputs[0]);
    step.inputs[0].orders.items_count = 1;
    step.inputs[0].orders.items[0] = crn_wire_order_of_exchange((crn_wire_exchange){position, tool});
    send_step(&step);
    assert_true(client_expect_ticks(&b.host, &ticks));
    assert_int_equal(ticks.states_count, 1);
    return ticks.states[0].exchange;
}

/* Computes `count` ticks, at most 64, in which one hand moves by `um` per tick. */
static void move(int position, int32_t um, uint16_t count)
{
    static crn_wire_step step;
    step = (crn_wire_step){.tick = tick_now, .inputs_count = count};
    for (uint16_t i = 0; i < count; i++) {
        hands_um[position] += um;
        fill(&step.inputs[i]);
    }
    send_step(&step);
    assert_true(client_expect_ticks(&b.host, &ticks));
    assert_int_equal(ticks.states_count, count);
    tick_now += count;
}

static const crn_wire_tick_state *last(void)
{
    return &ticks.states[ticks.states_count - 1];
}

static void a_line_that_names_no_tool_is_refused(void **state)
{
    (void)state;
    static const uint8_t lines[][POSITIONS] = {{0, 0, 0}, {WIRE, 0, TABLE + 1}, {WIRE, 0, WIRE}};
    bench_drain(&b);
    for (size_t i = 0; i < sizeof lines / sizeof lines[0]; i++) {
        make_tools(lines[i], POSITIONS);
        client_tools(&b.host, &tools);
        assert_true(client_expect_reject(&b.host, &reject));
        assert_int_equal(reject.code, CRN_REJECT_TOOL_LINE);
        assert_int_equal(reject.detail1, TABLE);
    }
    static const uint8_t wrong[] = {GUIDE, 0, WIRE};
    make_tools(wrong, POSITIONS);
    client_tools(&b.host, &tools);
    assert_true(client_expect_reject(&b.host, &reject));
    assert_int_equal(reject.code, CRN_REJECT_TOOL_NESTING);
    assert_int_equal(reject.detail1, WIRE - 1); /* the outer one of the two, by its place in the table */
    make_tools(wrong, 0);
    client_tools(&b.host, &tools);
    assert_true(client_expect_reject(&b.host, &reject));
    assert_int_equal(reject.code, CRN_REJECT_TOOL_COUNT); /* five tools without a line */
}

static void a_tick_carries_its_exchange_out_and_says_so(void **state)
{
    (void)state;
    begin(100000);
    assert_int_equal(exchange(MIDDLE, CATHETER), CRN_WIRE_EXCHANGE_DONE);
    assert_int_equal(last()->line_count, POSITIONS);
    assert_int_equal(last()->line[INNER], WIRE);
    assert_int_equal(last()->line[MIDDLE], CATHETER);
    assert_int_equal(last()->line[OUTER], GUIDE);
    for (int i = 0; i < 8; i++) move(MIDDLE, 200, 50);
    assert_int_equal(last()->exchange, CRN_WIRE_EXCHANGE_NONE);
    assert_true(last()->tools[MIDDLE].inserted_m_q30 > 0.07 * 1073741824.0);
    assert_int_equal(exchange(MIDDLE, OTHER_CATHETER), CRN_WIRE_EXCHANGE_INSIDE);
    assert_int_equal(last()->line[MIDDLE], CATHETER);
    for (int i = 0; i < 9; i++) move(MIDDLE, -200, 50);
    assert_int_equal(exchange(MIDDLE, OTHER_CATHETER), CRN_WIRE_EXCHANGE_DONE);
    assert_int_equal(exchange(MIDDLE, 0), CRN_WIRE_EXCHANGE_DONE);
    assert_int_equal(last()->line[MIDDLE], 0);
    assert_int_equal(exchange(MIDDLE, 0), CRN_WIRE_EXCHANGE_FREE);
}

static void a_refused_exchange_leaves_the_tick_as_it_would_be(void **state)
{
    (void)state;
    begin(100000);
    assert_int_equal(exchange(INNER, OTHER_WIRE), CRN_WIRE_EXCHANGE_INSIDE);
    const uint32_t lanes[2] = {last()->hash_lane0, last()->hash_lane1};
    command(CRN_WIRE_ACTION_STOP);
    command(CRN_WIRE_ACTION_RESET);
    begin(100000);
    move(INNER, 0, 1);
    assert_int_equal(last()->hash_lane0, lanes[0]);
    assert_int_equal(last()->hash_lane1, lanes[1]);
}

static void an_exchange_with_numbers_out_of_range_refuses_the_step(void **state)
{
    (void)state;
    static const crn_wire_exchange hostile[] = {
        {POSITIONS, WIRE}, {255, 0}, {MIDDLE, TABLE + 1}, {INNER, 255}};
    begin(100000);
    for (size_t i = 0; i < sizeof hostile / sizeof hostile[0]; i++) {
        static crn_wire_step step;
        step = (crn_wire_step){.tick = 0, .inputs_count = 2};
        fill(&step.inputs[0]);
        fill(&step.inputs[1]);
        step.inputs[1].orders.items_count = 1;
        step.inputs[1].orders.items[0] = crn_wire_order_of_exchange(hostile[i]);
        send_step(&step);
        assert_true(client_expect_reject(&b.host, &reject));
        assert_int_equal(reject.code, CRN_REJECT_ORDER_RANGE);
        assert_int_equal(reject.detail1, CRN_WIRE_KIND_exchange);
        assert_int_equal(reject.detail2, 256);
    }
    assert_int_equal(bench_status(&b).tick, 0);
}

static void a_snapshot_has_the_tools_on_the_line(void **state)
{
    (void)state;
    begin(100000);
    assert_int_equal(exchange(MIDDLE, OTHER_CATHETER), CRN_WIRE_EXCHANGE_DONE);
    move(MIDDLE, 200, 60);
    assert_true(client_read_snapshot(&b.host));
    const uint32_t tick = tick_now;
    const int32_t hand = hands_um[MIDDLE];
    move(MIDDLE, 200, 60);
    const crn_wire_tick_state before = *last();
    command(CRN_WIRE_ACTION_STOP);
    command(CRN_WIRE_ACTION_RESET);
    begin(100000);
    command(CRN_WIRE_ACTION_STOP);
    client_write_snapshot(&b.host);
    assert_true(client_expect_status(&b.host, &status));
    command(CRN_WIRE_ACTION_START);
    tick_now = tick;
    hands_um[MIDDLE] = hand;
    move(MIDDLE, 200, 60);
    assert_memory_equal(&before, last(), sizeof before);
}

static void load_and_take_off(int ms)
{
    const int tools_of[] = {CATHETER, 0, OTHER_CATHETER, OTHER_CATHETER};
    for (int k = 0; k < 3; k++) b.rig.hands[k].translation_counts = ms * 20 * (k == MIDDLE);
    if (ms % 100 != 50) return;
    const crn_wire_order order =
        crn_wire_order_of_exchange((crn_wire_exchange){MIDDLE, (uint8_t)tools_of[ms / 100]});
    client_orders(&b.host, &order, 1);
}

static void free_run_with_exchanges_replays_bit_for_bit(void **state)
{
    (void)state;
    static const uint8_t line[] = {WIRE, 0, GUIDE};
    static const uint32_t inserted_um[] = {100000, 0, 80000};
    bench_drain(&b);
    set_up_line(line, inserted_um);
    const crn_wire_track uncoupled = {.translation_pm_per_count = 1000000,
                                      .rotation_counts_per_turn = 65536,
                                      .force_gain_milli = 1000,
                                      .force_limit_mN = 8000,
                                      .torque_limit_uN_m = 20000};
    const crn_wire_track tracks[] = {uncoupled, uncoupled, uncoupled};
    client_rig(&b.host, tracks, 3);
    assert_true(client_expect_status(&b.host, &status));
    command(CRN_WIRE_ACTION_ARM);
    command(CRN_WIRE_ACTION_START);
    const uint32_t count = record(load_and_take_off);
    uint32_t answers[CRN_WIRE_EXCHANGE_BURST + 1] = {0};
    for (uint32_t i = 0; i < count; i++) answers[session[i].state.exchange]++;
    assert_int_equal(answers[CRN_WIRE_EXCHANGE_DONE], 3); /* on, off, and on */
    assert_int_equal(answers[CRN_WIRE_EXCHANGE_ON_LINE], 1);
    replays(count);
}

/* --- the hand that holds the tool --- */

static void start_coupled(void)
{
    static const uint8_t line[] = {WIRE, CATHETER, GUIDE};
    static const uint32_t inserted_um[] = {100000, 2000, 80000};
    const crn_wire_track track = client_plain_track();
    const crn_wire_track tracks[] = {track, track, track};
    bench_drain(&b);
    set_up_line(line, inserted_um);
    client_rig(&b.host, tracks, 3);
    assert_true(client_expect_status(&b.host, &status));
    start_lockstep();
}

/* A hand pulls with a few newtons on a tool that is already completely withdrawn. When the tool is
 * removed, the force on the hand goes to zero in 32 ticks. The force falls by at most a tenth of its first
 * value per tick, and stays zero while the hand moves on. */
static void the_force_on_the_hand_ramps_to_zero(void **state)
{
    (void)state;
    start_coupled();
    for (int i = 0; i < 4; i++) move(MIDDLE, -60, 50);
    const int32_t pulled_mN = last()->tools[MIDDLE].motor_axial_mN;
    assert_true(pulled_mN < -1000);
    assert_int_equal(exchange(MIDDLE, 0), CRN_WIRE_EXCHANGE_DONE);
    int32_t before_mN = pulled_mN;
    for (int t = 0; t < 40; t++) {
        const int32_t force_mN = last()->tools[MIDDLE].motor_axial_mN;
        assert_in_range(force_mN - before_mN + 1, 0, abs(pulled_mN) / 10 + 1);
        before_mN = force_mN;
        move(MIDDLE, t < 20 ? 0 : 100, 1);
    }
    assert_int_equal(last()->tools[MIDDLE].motor_axial_mN, 0);
}

/* The hand moves while it holds no tool, because the position of its tool is empty. A new tool that is put on
 * an empty position begins where the hand is. The new tool does not move and gives no force until the hand
 * moves again; then it follows the hand. */
static void a_new_tool_begins_at_the_present_counts(void **state)
{
    (void)state;
    start_coupled();
    for (int i = 0; i < 4; i++) move(MIDDLE, -60, 50);
    assert_int_equal(exchange(MIDDLE, 0), CRN_WIRE_EXCHANGE_DONE);
    for (int i = 0; i < 4; i++) move(MIDDLE, 300, 60);
    assert_int_equal(exchange(MIDDLE, OTHER_CATHETER), CRN_WIRE_EXCHANGE_DONE);
    const int32_t began = last()->tools[MIDDLE].inserted_m_q30;
    move(MIDDLE, 0, 60);
    assert_int_equal(last()->tools[MIDDLE].inserted_m_q30, began);
    assert_int_equal(last()->tools[MIDDLE].motor_axial_mN, 0);
    for (int i = 0; i < 4; i++) move(MIDDLE, 100, 50);
    const double way_mm = (last()->tools[MIDDLE].inserted_m_q30 - began) / 1073741824.0 * 1e3;
    if (way_mm < 19.5 || way_mm > 20.5) fail_msg("way = %g mm, expected 20", way_mm);
}

#define TEST(name) cmocka_unit_test_setup_teardown(name, set_up, tear_down)
int main(void)
{
    const struct CMUnitTest tests[] = {
        TEST(a_line_that_names_no_tool_is_refused),
        TEST(a_tick_carries_its_exchange_out_and_says_so),
        TEST(a_refused_exchange_leaves_the_tick_as_it_would_be),
        TEST(an_exchange_with_numbers_out_of_range_refuses_the_step),
        TEST(a_snapshot_has_the_tools_on_the_line),
        TEST(free_run_with_exchanges_replays_bit_for_bit),
        TEST(the_force_on_the_hand_ramps_to_zero),
        TEST(a_new_tool_begins_at_the_present_counts),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
