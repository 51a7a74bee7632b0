/* These tests check the wire protocol's messages for balloon and stent. One count of the inflator's sensor is
 * a pressure of one kilopascal in the balloon. A message with an invalid balloon table, or with a stent where
 * there is no lesion, is refused as a whole. The balloon pressures that were recorded in a FREE_RUN session
 * replay bit for bit. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#include "firmware/app/app.h"
#include "firmware/tests/reference/bench_session.h"

static crn_wire_reject reject;

/* Makes one wire with a balloon whose size is 3 x 18 mm at 8 bar and whose diameter is 0.89 mm when it is
 * folded. */
static void balloon_tools(crn_wire_tools *tools)
{
    static const crn_wire_balloon_point table[] = {{600, 2920}, {800, 3000}, {1200, 3120}};
    client_plain_tools(tools, 1);
    tools->tools[0].balloon_distal_um = 4000;
    tools->tools[0].balloon_proximal_um = 22000;
    tools->tools[0].balloon_burst_kPa = 1800;
    tools->tools[0].balloon_count = 3;
    memcpy(tools->tools[0].balloon, table, sizeof table);
}

static void send_balloon(void)
{
    static crn_wire_tools tools;
    balloon_tools(&tools);
    bench_drain(&b);
    client_tools(&b.host, &tools);
    assert_true(client_expect_status(&b.host, &status));
    client_entry(&b.host, 50000);
    assert_true(client_expect_status(&b.host, &status));
}

static void step_at(uint32_t tick, int32_t inflator_raw)
{
    static crn_wire_step step;
    step = (crn_wire_step){.tick = tick, .inputs_count = 1};
    step.inputs[0] = (crn_wire_tick_input){.hands_count = 1, .inflator_raw = inflator_raw};
    send_step(&step);
    assert_true(client_expect_ticks(&b.host, &ticks));
}

/* In open space the balloon has the diameter that its table gives for 8 bar, within the table's rounding.
 * Pressures below 0 have no effect, and the balloon bursts above its limit. */
static void a_count_of_the_inflator_is_a_kilopascal(void **state)
{
    (void)state;
    bench_drain(&b);
    send_balloon();
    start_lockstep();
    uint32_t tick = 0;
    while (tick < 400) step_at(tick++, 800);
    const crn_wire_tick_state *last = &ticks.states[0];
    assert_int_equal(last->balloon_kPa, 800);
    assert_in_range(last->balloon_diameter_max_um, 2999, 3001);
    assert_in_range(last->balloon_diameter_min_um, 2999, 3001);
    assert_int_equal(last->balloon_wall_mN, 0);
    assert_int_equal(last->balloon_bits, 0);
    step_at(tick++, INT32_MIN);
    assert_int_equal(ticks.states[0].balloon_kPa, 0);
    step_at(tick++, INT32_MAX);
    assert_int_equal(ticks.states[0].balloon_bits, 1);
    step_at(tick++, 800);
    assert_int_equal(ticks.states[0].balloon_kPa, 0);
}

static void tools_with_a_table_that_is_none_are_refused(void **state)
{
    (void)state;
    static crn_wire_tools tools;
    bench_drain(&b);
    for (int fault = 0; fault < 3; fault++) {
        balloon_tools(&tools);
        if (fault == 0) tools.tools[0].balloon[1].pressure_kPa = 600;
        if (fault == 1) tools.tools[0].balloon_burst_kPa = 1200;
        if (fault == 2) tools.tools[0].balloon_proximal_um = UINT32_MAX;
        client_tools(&b.host, &tools);
        assert_true(client_expect_reject(&b.host, &reject));
        assert_int_equal(reject.code, CRN_REJECT_TOOL_BALLOON);
        assert_int_equal(reject.detail1, 0);
    }
}

/* Sends two inputs in one message; only the second input contains the command. */
static void ask_for_strut(crn_wire_step *step, const crn_wire_strut *strut)
{
    *step = (crn_wire_step){.tick = 0, .inputs_count = 2};
    for (int k = 0; k < 2; k++) step->inputs[k].hands_count = 1;
    step->inputs[1].orders.items_count = 1;
    step->inputs[1].orders.items[0] = crn_wire_order_of_strut(*strut);
    send_step(step);
}

static void a_stent_where_no_lesion_is_is_refused_whole(void **state)
{
    (void)state;
    start_lockstep();
    static const crn_wire_scaffold bad[] = {{1, 0, 0, 1}, {0, 0, 0, 1}, {0, 1, 0, 0}, {255, 0, 255, 65535}};
    for (size_t i = 0; i < sizeof bad / sizeof bad[0]; i++) {
        static crn_wire_step step;
        step = (crn_wire_step){.tick = 0, .inputs_count = 2};
        for (int k = 0; k < 2; k++) step.inputs[k].hands_count = 1;
        step.inputs[1].orders.items_count = 1;
        step.inputs[1].orders.items[0] = crn_wire_order_of_scaffold(bad[i]);
        send_step(&step);
        assert_true(client_expect_reject(&b.host, &reject));
        assert_int_equal(reject.code, CRN_REJECT_ORDER_RANGE);
        assert_int_equal(reject.detail1, CRN_WIRE_KIND_scaffold);
        assert_int_equal(reject.detail2, 256);
        assert_int_equal(bench_status(&b).tick, 0);
    }
}

/* A host can command a ring of stent struts even if no scene is loaded. A command for an invalid strut ring
 * is refused before any tick is computed. The refusal gives the kind of the command and its position in the
 * list of commands. */
static void struts_that_are_none_are_refused_whole(void **state)
{
    (void)state;
    start_lockstep();
    static const crn_wire_strut bad[] = {{65, 0, 0, 0, 0, 1500, 80}, {1, 0, 0, 0, 0, 199, 80},
                                         {1, 2, 0, 0, 0, 1500, 80},  {1, 0, 1900001, 0, 0, 1500, 80},
                                         {1, 0, 0, 0, 0, 0, 80},     {0, 0, 0, 1, 0, 0, 0}};
    static crn_wire_step step;
    for (size_t i = 0; i < sizeof bad / sizeof bad[0]; i++) {
        ask_for_strut(&step, &bad[i]);
        assert_true(client_expect_reject(&b.host, &reject));
        assert_int_equal(reject.code, CRN_REJECT_ORDER_RANGE);
        assert_int_equal(reject.detail1, CRN_WIRE_KIND_strut);
        assert_int_equal(reject.detail2, 256);
        assert_int_equal(bench_status(&b).tick, 0);
    }
    ask_for_strut(&step, &(crn_wire_strut){64, 0, 0, -1900000, 0, 1500, 80});
    assert_true(client_expect_ticks(&b.host, &ticks));
    assert_int_equal(ticks.states_count, 2);
}

static void place_ring(uint8_t number, uint16_t inside_um)
{
    const crn_wire_order order = crn_wire_order_of_strut(
        (crn_wire_strut){number, number < 3, 0, 20000 + 2000 * number, 0, inside_um, 80});
    client_orders(&b.host, &order, 1);
}

static void place_rings(int ms)
{
    if (ms >= 100 && ms < 103) place_ring((uint8_t)(ms - 99), 1500);
    if (ms == 200) place_ring(2, 1800);
}

/* In FREE_RUN the message `orders` transmits the commands for stent struts. Each command is recorded in the
 * input of the tick that applied the command, so the recorded session can be replayed. */
static void struts_of_free_run_replay_in_lockstep_bit_for_bit(void **state)
{
    (void)state;
    bench_drain(&b);
    send_balloon();
    start_free_run();
    const uint32_t count = record(place_rings);
    uint32_t rings = 0;
    for (uint32_t i = 0; i < count; i++) rings += session[i].input.orders.items_count;
    assert_int_equal(rings, 4);
    place_ring(64, 199);
    assert_true(client_expect_reject(&b.host, &reject));
    assert_int_equal(reject.code, CRN_REJECT_ORDER_RANGE);
    replays(count);
}

/* The pressure of the rig's inflator rises in steps and then stays constant; the recording ends while the
 * balloon is inflated. */
static void pump(int ms)
{
    b.rig.inflator_raw = ms < 150 ? 5 * ms : 900;
}

static void pressures_of_free_run_replay_in_lockstep_bit_for_bit(void **state)
{
    (void)state;
    bench_drain(&b);
    send_balloon();
    start_free_run();
    const uint32_t count = record(pump);
    assert_true(count > 350);
    assert_int_equal(session[count - 1].state.balloon_kPa, 900);
    assert_true(session[count - 1].state.balloon_diameter_max_um > 2900);
    replays(count);
}

#define TEST(name) cmocka_unit_test_setup_teardown(name, set_up, tear_down)

int main(void)
{
    const struct CMUnitTest tests[] = {
        TEST(a_count_of_the_inflator_is_a_kilopascal),
        TEST(tools_with_a_table_that_is_none_are_refused),
        TEST(a_stent_where_no_lesion_is_is_refused_whole),
        TEST(struts_that_are_none_are_refused_whole),
        TEST(struts_of_free_run_replay_in_lockstep_bit_for_bit),
        TEST(pressures_of_free_run_replay_in_lockstep_bit_for_bit),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
