/* These tests check safety and snapshots with several tools, through bytes on the simulated port. Each tool
 * has its own force limits, slew limits and faults, and snapshots contain all of them. In FREE_RUN, the
 * device stays safe if a hand moves while the session is stopped, and if the host is silent. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "firmware/app/app.h"
#include "firmware/tests/reference/client.h"

enum { WIRE, CATHETER, GUIDE, TOOLS };

static client host;
static crn_wire_status status;
static crn_wire_reject reject;
static crn_wire_ticks ticks;

static int set_up(void **state)
{
    (void)state;
    client_open(&host, 1 << 20);
    return host.sim == NULL;
}

static int tear_down(void **state)
{
    (void)state;
    client_close(&host);
    return 0;
}

static void expect_reject(uint16_t code, uint32_t detail1, uint32_t detail2)
{
    assert_true(client_expect_reject(&host, &reject));
    if (reject.code != code || reject.detail1 != detail1 || reject.detail2 != detail2) {
        fail_msg("refused with %s [%u, %u], expected %s [%u, %u]", crn_wire_reject_name(reject.code),
                 reject.detail1, reject.detail2, crn_wire_reject_name(code), detail1, detail2);
    }
}

static void expect_state(uint8_t expected)
{
    client_get(&host, CRN_WIRE_GET_STATUS);
    assert_true(client_expect_status(&host, &status));
    if (status.state != expected) {
        fail_msg("state %s, expected %s", crn_wire_state_name(status.state), crn_wire_state_name(expected));
    }
}

static void command(uint8_t action)
{
    client_command(&host, action);
    assert_true(client_expect_status(&host, &status));
}

static void greet(void)
{
    client_hello(&host, crn_wire_schema_hash());
    assert_int_equal(client_receive(&host), CRN_WIRE_TYPE_hello_reply);
}

static double inserted_mm(int tool)
{
    return ticks.states[ticks.states_count - 1].tools[tool].inserted_m_q30 / 1073741824.0 * 1e3;
}

static void expect_inserted(int tool, double expected_mm, double tolerance_mm)
{
    if (abs((int)((inserted_mm(tool) - expected_mm) * 1000)) > tolerance_mm * 1000) {
        fail_msg("tool %d: inserted = %.3f mm, expected %.3f +- %.1f", tool, inserted_mm(tool), expected_mm,
                 tolerance_mm);
    }
}

/* Runs `ticks` ticks at constant speeds of the three hands, from their present positions. */
static int32_t hands_at[TOOLS];
static void move(uint32_t *tick, uint32_t count, const int32_t *per_tick)
{
    for (uint32_t done = 0; done < count; done += 50) {
        client_step_each(&host, *tick, 50, hands_at, per_tick);
        assert_true(client_expect_ticks(&host, &ticks));
        assert_int_equal(ticks.states_count, 50);
        for (int k = 0; k < TOOLS; k++) hands_at[k] += 50 * per_tick[k];
        *tick += 50;
    }
}

static void start_three(void)
{
    memset(hands_at, 0, sizeof hands_at);
    assert_true(client_start_tools(&host, TOOLS));
}

/* --- safety --- */

/* The second hand's position jumps by 6 mm: all tools stop, and the fault names the tool and the counts. */
static void a_jump_of_one_hand_stops_all_and_names_it(void **state)
{
    (void)state;
    static crn_wire_fault_log log;
    uint32_t tick = 0;
    start_three();
    move(&tick, 50, (const int32_t[]){10, 10, 10});
    hands_at[CATHETER] += 6000;
    client_step_each(&host, tick, 1, hands_at, (const int32_t[]){0, 0, 0});
    assert_true(client_expect_ticks(&host, &ticks));
    assert_int_equal(ticks.states_count, 0);
    expect_state(CRN_WIRE_STATE_FAULT);
    client_get(&host, CRN_WIRE_GET_FAULT_LOG);
    assert_int_equal(client_receive(&host), CRN_WIRE_TYPE_fault_log);
    assert_true(crn_wire_decode_fault_log(host.decoder.payload, host.decoder.payload_bytes, &log));
    assert_int_equal(log.entries[0].code, CRN_FAULT_CODE_ENCODER_JUMP_TRANSLATION);
    assert_int_equal(log.entries[0].value1, CATHETER);
    assert_int_equal(log.entries[0].value2, 6010);
}

static bool is_coupled;
static void send_rig(const uint32_t *limits_mN, uint16_t count)
{
    crn_wire_track tracks[TOOLS];
    for (uint16_t k = 0; k < count; k++) {
        tracks[k] = client_plain_track();
        tracks[k].force_gain_milli = 4000;
        tracks[k].force_limit_mN = limits_mN[k];
        tracks[k].coupling_N_per_m = is_coupled ? 400 : 0; /* what a gain of 4 leaves of 1 N s/m */
        tracks[k].coupling_mN_s_per_m = is_coupled ? 50 : 0;
        tracks[k].coupling_uN_m_per_rad = tracks[k].coupling_nN_m_s_per_rad = 0;
    }
    client_rig(&host, tracks, count);
}

/* The host's message sets the force limit of the third track higher than is allowed, so the device refuses
 * the message. The first two tracks also keep their old force limits, although the message lowers these
 * limits to allowed values. */
/* Requirement: SR-19 */
static void a_rig_is_taken_over_whole_or_not_at_all(void **state)
{
    (void)state;
    greet();
    send_rig((const uint32_t[]){500, 400, 9000}, 3);
    expect_reject(CRN_REJECT_RIG_RANGE, GUIDE, 3);
    send_rig((const uint32_t[]){8000, 8000, 8000}, 3);
    assert_true(client_expect_status(&host, &status));
    send_rig((const uint32_t[]){60}, 1);
    assert_true(client_expect_status(&host, &status));
    send_rig((const uint32_t[]){61}, 1);
    expect_reject(CRN_REJECT_RIG_RANGE, WIRE, 3);
    send_rig((const uint32_t[]){60, 8000}, 2);
    assert_true(client_expect_status(&host, &status));
}

/* A motor's force may fall at once, but grows by at most the slew limit per tick. */
static bool grows_within(int32_t last, int32_t now, int32_t slew)
{
    return now <= (last > 0 ? last : 0) + slew && now >= (last < 0 ? last : 0) - slew;
}

/* All hands move with a sudden jerk while the force gain is 4. In every tick, the force of every motor must
 * stay within its own limit and slew limit; more than one motor must be active. */
/* Requirement: SR-01, SR-02 */
static void motors_stay_within_their_own_limit_and_slew(void **state)
{
    (void)state;
    const int32_t limits_mN[TOOLS] = {60, 8000, 90};
    int32_t last[TOOLS] = {0}, largest[TOOLS] = {0};
    greet();
    send_rig((const uint32_t[]){60, 8000, 90}, TOOLS);
    assert_true(client_expect_status(&host, &status));
    start_three();
    for (uint32_t tick = 0; tick < 640;) {
        const int32_t step = (tick / 64) % 2 ? -400 : 400;
        client_step_each(&host, tick, 64, hands_at, (const int32_t[]){step, -step / 2, step / 4});
        assert_true(client_expect_ticks(&host, &ticks));
        hands_at[WIRE] += 64 * step;
        hands_at[CATHETER] -= 64 * (step / 2);
        hands_at[GUIDE] += 64 * (step / 4);
        for (int i = 0; i < ticks.states_count; i++, tick++) {
            for (int k = 0; k < TOOLS; k++) {
                int32_t now = ticks.states[i].tools[k].motor_axial_mN;
                assert_true(abs(now) <= limits_mN[k] && grows_within(last[k], now, 50));
                largest[k] = abs(now) > largest[k] ? abs(now) : largest[k];
                last[k] = now;
            }
        }
    }
    assert_true(largest[WIRE] > 0 && largest[CATHETER] > 0 && largest[GUIDE] > 0);
}

/* --- snapshots --- */

/* Three users' hands hold three heavy tools (100 g/m) upright. Each tool weighs 0.25 N, so every motor is
 * commanded to give four times this weight, 1 N. If the snapshot lost a motor's last force, the motor would
 * need 20 ticks to reach this force again. */
static void start_upright(uint16_t count)
{
    static crn_wire_tools tools;
    memset(hands_at, 0, sizeof hands_at);
    greet();
    send_rig((const uint32_t[]){8000, 8000, 8000}, TOOLS);
    assert_true(client_expect_status(&host, &status));
    client_plain_tools(&tools, count);
    for (uint16_t k = 0; k < count; k++) {
        for (int i = 0; i < 2; i++) tools.tools[k].knots[i].mass_mg_per_m = 100000;
    }
    client_tools(&host, &tools);
    assert_true(client_expect_status(&host, &status));
    assert_true(client_entry_along(&host, 2, 250000));
    command(CRN_WIRE_ACTION_ARM);
    command(CRN_WIRE_ACTION_START);
}

static void expect_weight(int32_t axial_mN)
{
    if (axial_mN < 800 || axial_mN > 1200) fail_msg("motor = %d mN, expected 981 +- 20 %%", axial_mN);
}

/* Every result of every tick in the continued session, including the motors' forces, equals that of the
 * uninterrupted session. */
static void a_snapshot_of_three_tools_continues_bit_for_bit(void **state)
{
    (void)state;
    static crn_wire_ticks expected;
    uint32_t tick = 0;
    const int32_t moves[] = {60, -40, 25};
    start_upright(TOOLS);
    move(&tick, 150, moves);
    assert_true(client_read_snapshot(&host));
    int32_t at[TOOLS];
    memcpy(at, hands_at, sizeof at);
    move(&tick, 50, moves);
    expected = ticks;
    assert_true(abs(expected.states[0].tools[WIRE].motor_axial_mN) > 100);
    command(CRN_WIRE_ACTION_STOP);
    client_write_snapshot(&host);
    assert_true(client_expect_status(&host, &status));
    assert_int_equal(status.tick, 150);
    command(CRN_WIRE_ACTION_START);
    memcpy(hands_at, at, sizeof at);
    tick = 150;
    move(&tick, 50, moves);
    assert_memory_equal(&expected, &ticks, sizeof expected);
}

static void a_lockstep_session_goes_on_after_stop_as_if_it_had_not_stopped(void **state)
{
    (void)state;
    crn_wire_tick_state last[2];
    for (int run = 0; run < 2; run++) {
        uint32_t tick = 0;
        client_close(&host);
        client_open(&host, 0);
        start_upright(TOOLS);
        move(&tick, 100, (const int32_t[]){60, -40, 25});
        if (run == 1) {
            command(CRN_WIRE_ACTION_STOP);
            crn_sim_timer(host.sim, 20);
            command(CRN_WIRE_ACTION_START);
        }
        move(&tick, 50, (const int32_t[]){60, -40, 25});
        last[run] = ticks.states[0];
    }
    assert_memory_equal(&last[0], &last[1], sizeof last[0]);
}

/* The device refuses a snapshot if a field of any tool in the snapshot's header is damaged, or if the
 * snapshot has fewer tools than the session. */
/* Requirement: SR-19 */
static void a_damaged_or_foreign_snapshot_leaves_the_state(void **state)
{
    (void)state;
    uint32_t tick = 0;
    start_three();
    move(&tick, 50, (const int32_t[]){10, 10, 10});
    assert_true(client_read_snapshot(&host));
    command(CRN_WIRE_ACTION_STOP);
    for (int k = 0; k < TOOLS; k++) {
        const size_t known = 12 + CRN_APP_SNAPSHOT_TOOL_BYTES * (size_t)k, sum = known + 19,
                     motor = known + 31;
        for (size_t i = 0; i < 3; i++) {
            size_t byte = i == 0 ? known : i == 1 ? sum : motor;
            uint8_t kept = host.snapshot[byte];
            host.snapshot[byte] = 0x7f;
            client_write_snapshot(&host);
            assert_true(client_expect_reject(&host, &reject));
            assert_int_equal(reject.code, CRN_REJECT_SNAPSHOT_INVALID);
            host.snapshot[byte] = kept;
        }
    }
    host.snapshot[8] = 2;
    client_write_snapshot(&host);
    assert_true(client_expect_reject(&host, &reject));
    assert_int_equal(reject.code, CRN_REJECT_SNAPSHOT_INVALID);
    host.snapshot[8] = TOOLS;
    client_write_snapshot(&host);
    assert_true(client_expect_status(&host, &status));
    assert_int_equal(status.tick, 50);
}

/* --- FREE_RUN --- */

static void start_free_run(uint16_t tool_count)
{
    assert_true(client_start_tools(&host, tool_count));
    command(CRN_WIRE_ACTION_STOP);
    command(CRN_WIRE_ACTION_FREE_RUN);
    command(CRN_WIRE_ACTION_START);
}

static void take_ticks(void)
{
    while (client_expect_ticks(&host, &ticks)) {
    }
}

/* One hand was far from its zero position before the session began, and another hand moves while the session
 * is stopped. The device must not treat a hand motion before the session or during a stop as a jump of the
 * encoder, and such a motion must not move a tool. */
static void what_hands_do_while_stopped_is_no_motion(void **state)
{
    (void)state;
    const int32_t still[TOOLS] = {0};
    start_free_run(TOOLS);
    crn_sim_timer(host.sim, 16);
    client_input(&host, (const int32_t[]){700000, -300000, 123456}, still);
    crn_sim_timer(host.sim, 16);
    client_input(&host, (const int32_t[]){700100, -300000, 123456}, still);
    crn_sim_timer(host.sim, 320);
    take_ticks();
    expect_state(CRN_WIRE_STATE_RUNNING);
    expect_inserted(WIRE, 50.1, 0.05);
    command(CRN_WIRE_ACTION_STOP);
    client_input(&host, (const int32_t[]){800000, 0, 0}, still);
    command(CRN_WIRE_ACTION_START);
    crn_sim_timer(host.sim, 16);
    client_input(&host, (const int32_t[]){900000, 400000, 0}, (const int32_t[]){50000, 0, 0});
    crn_sim_timer(host.sim, 160);
    take_ticks();
    expect_state(CRN_WIRE_STATE_RUNNING);
    expect_inserted(WIRE, 50.1, 0.05);
    expect_inserted(CATHETER, 50, 0.05);
}

/* The motor holds the weight of an upright wire. When the host falls silent, the motor's force stays
 * unchanged for 30 ticks and then fades to zero in 20 ticks. The motor's force stays at zero although the
 * wire's weight remains, and returns with the host's next frame. */
static void forces_fade_when_the_host_is_silent_and_come_back(void **state)
{
    (void)state;
    const int32_t still[TOOLS] = {0};
    crn_port_inputs rig = crn_sim_healthy_inputs();
    rig.local_unlock = true; /* for the gain of 4 */
    crn_sim_set_inputs(host.sim, &rig);
    crn_sim_timer(host.sim, 1);
    is_coupled = true;
    start_upright(1);
    is_coupled = false;
    command(CRN_WIRE_ACTION_STOP);
    command(CRN_WIRE_ACTION_FREE_RUN);
    crn_sim_timer(host.sim, 1);
    assert_true(client_arm_motors(&host));
    command(CRN_WIRE_ACTION_START);
    for (int i = 0; i < 1000; i++) {
        client_input(&host, still, still);
        crn_sim_timer(host.sim, 1);
    }
    expect_weight(crn_sim_read_motors(host.sim).axial_mN[WIRE]);
    crn_sim_timer(host.sim, 28);
    expect_weight(crn_sim_read_motors(host.sim).axial_mN[WIRE]);
    for (int i = 0; i < 21; i++) {
        int32_t last = crn_sim_read_motors(host.sim).axial_mN[WIRE];
        crn_sim_timer(host.sim, 1);
        assert_true(crn_sim_read_motors(host.sim).axial_mN[WIRE] <= last);
    }
    assert_int_equal(crn_sim_read_motors(host.sim).axial_mN[WIRE], 0);
    crn_sim_timer(host.sim, 1000);
    crn_sim_motors faded = crn_sim_read_motors(host.sim);
    assert_int_equal(faded.axial_mN[WIRE], 0);
    assert_int_equal(faded.torque_uN_m[WIRE], 0);
    assert_int_equal(faded.drive, 1);
    take_ticks();
    assert_true(ticks.states[0].tools[WIRE].handle_axial_N_q22 > 800000); /* the weight is still there */
    expect_state(CRN_WIRE_STATE_RUNNING);
    for (int i = 0; i < 60; i++) {
        int32_t last = crn_sim_read_motors(host.sim).axial_mN[WIRE];
        client_input(&host, still, still);
        crn_sim_timer(host.sim, 1);
        assert_true(grows_within(last, crn_sim_read_motors(host.sim).axial_mN[WIRE], 50));
    }
    expect_weight(crn_sim_read_motors(host.sim).axial_mN[WIRE]);
}

static void a_track_without_a_tool_is_not_driven(void **state)
{
    (void)state;
    start_free_run(2);
    for (int32_t i = 0; i < 200; i++) {
        client_input(&host, (const int32_t[]){400 * i, -200 * i, 0}, (const int32_t[]){0, 0, 0});
        crn_sim_timer(host.sim, 1);
        assert_int_equal(crn_sim_read_motors(host.sim).axial_mN[GUIDE], 0);
        assert_int_equal(crn_sim_read_motors(host.sim).torque_uN_m[GUIDE], 0);
    }
}

#define TEST(name) cmocka_unit_test_setup_teardown(name, set_up, tear_down)

int main(void)
{
    const struct CMUnitTest tests[] = {
        TEST(a_jump_of_one_hand_stops_all_and_names_it),
        TEST(a_rig_is_taken_over_whole_or_not_at_all),
        TEST(motors_stay_within_their_own_limit_and_slew),
        TEST(a_snapshot_of_three_tools_continues_bit_for_bit),
        TEST(a_lockstep_session_goes_on_after_stop_as_if_it_had_not_stopped),
        TEST(a_damaged_or_foreign_snapshot_leaves_the_state),
        TEST(what_hands_do_while_stopped_is_no_motion),
        TEST(forces_fade_when_the_host_is_silent_and_come_back),
        TEST(a_track_without_a_tool_is_not_driven),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
