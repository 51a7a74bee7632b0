/* Claims: a device refuses FREE_RUN for a set-up whose ticks its processor cannot compute in time, with the
 * figures, and leaves LOCKSTEP to it; and the estimate behind it judges every priced session of
 * firmware/bench/budget.tsv as its measured cycles do. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "firmware/app/app_internal.h"
#include "firmware/tests/reference/client.h"
#include "firmware/tests/reference/tube_scene.h"

enum { FILE_MAX = 1 << 20 };

static client host;
static crn_wire_status status;
static crn_wire_reject reject;

static int set_up(void **state)
{
    (void)state;
    client_open(&host, FILE_MAX);
    return host.sim == NULL;
}

static int tear_down(void **state)
{
    (void)state;
    client_close(&host);
    return 0;
}

/* Loads a straight tube of this length, or none, and straight tools of 300 mm, which lie in it by 50 mm. */
static void prepare(double tube_m, uint16_t tools)
{
    static uint8_t scene[FILE_MAX];
    static crn_wire_tools table;
    client_hello(&host, crn_wire_schema_hash());
    client_receive(&host);
    if (tube_m > 0) {
        const reference_piece straight = {tube_m, 0, 0};
        reference_tube *tube = reference_tube_make(&straight, 1, 0.003, 0);
        const uint32_t bytes = (uint32_t)reference_tube_scene(tube, scene, sizeof scene);
        reference_tube_free(tube);
        assert_true(client_load_scene(&host, scene, bytes));
    }
    client_plain_tools(&table, tools);
    client_tools(&host, &table);
    assert_true(client_expect_status(&host, &status));
    assert_true(client_entry_along(&host, 0, 50000));
}

static void order(uint8_t action)
{
    client_command(&host, action);
    assert_true(client_expect_status(&host, &status));
}

/* Returns the cycles that a device states when it refuses FREE_RUN on a processor with one cycle less. */
static uint32_t needed(uint32_t tick_cycles)
{
    crn_sim_set_tick_cycles(host.sim, tick_cycles);
    client_command(&host, CRN_WIRE_ACTION_FREE_RUN);
    assert_true(client_expect_reject(&host, &reject));
    assert_int_equal(reject.code, CRN_REJECT_TOO_SLOW);
    assert_int_equal(reject.detail2, tick_cycles);
    return reject.detail1;
}

/* Requirement: SR-27 */
static void a_board_that_is_too_slow_refuses_free_run_and_keeps_lockstep(void **state)
{
    (void)state;
    static crn_wire_ticks ticks;
    prepare(0.2, 1);
    order(CRN_WIRE_ACTION_ARM);
    const uint32_t cycles = needed(1000);
    assert_true(cycles > 1000);
    client_get(&host, CRN_WIRE_GET_STATUS);
    assert_true(client_expect_status(&host, &status));
    assert_int_equal(status.state, CRN_WIRE_STATE_ARMED);
    assert_int_equal(status.mode, CRN_WIRE_MODE_LOCKSTEP);
    order(CRN_WIRE_ACTION_START);
    client_step(&host, 0, 10, 0, 20);
    assert_true(client_expect_ticks(&host, &ticks));
    assert_int_equal(ticks.states_count, 10);
}

/* A host may choose the mode before it arms; then ARM refuses, and the device stays READY. */
/* Requirement: SR-27 */
static void arm_in_free_run_is_refused_too(void **state)
{
    (void)state;
    prepare(0.2, 1);
    crn_sim_set_tick_cycles(host.sim, 1000);
    order(CRN_WIRE_ACTION_FREE_RUN);
    client_command(&host, CRN_WIRE_ACTION_ARM);
    assert_true(client_expect_reject(&host, &reject));
    assert_int_equal(reject.code, CRN_REJECT_TOO_SLOW);
    client_get(&host, CRN_WIRE_GET_STATUS);
    assert_true(client_expect_status(&host, &status));
    assert_int_equal(status.state, CRN_WIRE_STATE_READY);
    order(CRN_WIRE_ACTION_LOCKSTEP);
    order(CRN_WIRE_ACTION_ARM);
}

/* Both sides of the border: as many cycles as the tick needs are enough, one fewer is not. */
static void the_border_is_the_cycles_that_the_refusal_states(void **state)
{
    (void)state;
    prepare(0.2, 2);
    order(CRN_WIRE_ACTION_ARM);
    const uint32_t cycles = needed(1);
    assert_int_equal(needed(cycles - 1), cycles);
    crn_sim_set_tick_cycles(host.sim, cycles);
    order(CRN_WIRE_ACTION_FREE_RUN);
    order(CRN_WIRE_ACTION_START);
}

/* The host's process and the emulated device compute as fast as they can. */
static void a_port_that_states_no_cycles_refuses_nothing(void **state)
{
    (void)state;
    prepare(0.2, 3);
    order(CRN_WIRE_ACTION_ARM);
    order(CRN_WIRE_ACTION_FREE_RUN);
    order(CRN_WIRE_ACTION_START);
}

static uint32_t needed_by(double tube_m, uint16_t tools)
{
    client_close(&host);
    client_open(&host, FILE_MAX);
    prepare(tube_m, tools);
    order(CRN_WIRE_ACTION_ARM);
    return needed(1);
}

/* A tool in a short vessel has most of its nodes in the introducer, where they cost little. */
static void more_tools_a_longer_vessel_and_a_wall_need_more_cycles(void **state)
{
    (void)state;
    const uint32_t free_space = needed_by(0, 1), one = needed_by(0.2, 1), two = needed_by(0.2, 2),
                   three = needed_by(0.2, 3), longer = needed_by(0.28, 1), beyond = needed_by(0.4, 1),
                   far_beyond = needed_by(0.5, 1);
    print_message("# %u cycles in free space, %u in 200 mm, %u with two tools, %u with three, %u in 280 mm\n",
                  free_space, one, two, three, longer);
    assert_true(one < two && two < three);
    assert_true(one < longer);
    assert_int_equal(beyond, far_beyond); /* the whole tool lies in either */
    assert_true(free_space < beyond);
    const crn_app_load still = {100, 1, CRN_APP_PLACE_STILL}, beating = {100, 1, CRN_APP_PLACE_BEATING};
    assert_true(crn_app_load_cycles(&still) < crn_app_load_cycles(&beating));
}

/* --- the priced sessions -------------------------------------------------------------------------------- */

typedef struct priced {
    char name[64];
    bool is_beating;
    double cycles, app_cycles, nodes, positions, estimate_cycles, rt1062_permille, rt1176_permille;
} priced;

static priced *find(priced *sessions, size_t *count, const char *context)
{
    char name[64];
    assert_int_equal(sscanf(context, "session=%63s", name), 1);
    for (size_t i = 0; i < *count; i++) {
        if (strcmp(sessions[i].name, name) == 0) return &sessions[i];
    }
    priced *added = &sessions[(*count)++];
    *added = (priced){.is_beating = strstr(context, " beating ") != NULL};
    memcpy(added->name, name, sizeof name);
    return added;
}

static double *column(priced *one, const char *name, const char *context)
{
    const bool is_share = strcmp(name, "chip.share_permille") == 0;
    if (is_share && strstr(context, "board=rt1062") != NULL) return &one->rt1062_permille;
    if (is_share && strstr(context, "board=rt1176") != NULL) return &one->rt1176_permille;
    if (strcmp(name, "chip.cycles") == 0) return &one->cycles;
    if (strcmp(name, "chip.app_cycles") == 0) return &one->app_cycles;
    if (strcmp(name, "chip.nodes") == 0) return &one->nodes;
    if (strcmp(name, "chip.positions") == 0) return &one->positions;
    return strcmp(name, "chip.estimate_cycles") == 0 ? &one->estimate_cycles : NULL;
}

enum { SESSIONS_MAX = 16 };

static size_t read_budget(priced sessions[SESSIONS_MAX])
{
    FILE *file = fopen("firmware/bench/budget.tsv", "r");
    char line[256], name[64], unit[32], context[160];
    double value;
    size_t count = 0;
    assert_non_null(file);
    while (fgets(line, sizeof line, file) != NULL) {
        if (sscanf(line, "%63[^\t]\t%lf\t%31[^\t]\t%159[^\n]", name, &value, unit, context) != 4) continue;
        if (strncmp(context, "session=", 8) != 0) continue;
        assert_true(count < SESSIONS_MAX);
        double *cell = column(find(sessions, &count, context), name, context);
        if (cell != NULL) *cell = value;
    }
    fclose(file);
    return count;
}

static void check_verdict(const priced *one, const char *board, double permille, uint32_t tick_cycles)
{
    const bool fits = permille <= 900; /* as docs/porting.md judges */
    if (fits != (one->estimate_cycles <= tick_cycles))
        fail_msg("%s on %s: %.0f permille measured, %.0f cycles estimated of %u", one->name, board, permille,
                 one->estimate_cycles, tick_cycles);
}

/* The estimate of the emulated device is this formula's, and judges as the measured share does. Its error is
 * that of the whole tick, core and app. In a still vessel, where boards are near their limit, it is at most 2
 * % too low (measured: 0.6 %); the beating sessions are far beyond the limit, and one is 12 % too low. */
static void every_priced_session_is_judged_as_its_measured_cycles_are(void **state)
{
    (void)state;
    static priced sessions[SESSIONS_MAX];
    const size_t count = read_budget(sessions);
    assert_true(count >= 6);
    for (size_t i = 0; i < count; i++) {
        const priced *one = &sessions[i];
        const crn_app_load load = {(uint32_t)one->nodes, (uint32_t)one->positions,
                                   one->is_beating ? CRN_APP_PLACE_BEATING : CRN_APP_PLACE_STILL};
        assert_int_equal(crn_app_load_cycles(&load), (uint32_t)one->estimate_cycles);
        const double error = one->estimate_cycles / (one->cycles + one->app_cycles) - 1;
        print_message("# %s: %.0f nodes, %.0f positions: %.0f cycles estimated, %.0f measured: %+.1f %%\n",
                      one->name, one->nodes, one->positions, one->estimate_cycles,
                      one->cycles + one->app_cycles, 100 * error);
        assert_true(error > (one->is_beating ? -0.15 : -0.02) && error < 0.3);
        check_verdict(one, "i.MX RT1062", one->rt1062_permille, 600000);
        check_verdict(one, "i.MX RT1176", one->rt1176_permille, 1000000);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(a_board_that_is_too_slow_refuses_free_run_and_keeps_lockstep, set_up,
                                        tear_down),
        cmocka_unit_test_setup_teardown(arm_in_free_run_is_refused_too, set_up, tear_down),
        cmocka_unit_test_setup_teardown(the_border_is_the_cycles_that_the_refusal_states, set_up, tear_down),
        cmocka_unit_test_setup_teardown(a_port_that_states_no_cycles_refuses_nothing, set_up, tear_down),
        cmocka_unit_test_setup_teardown(more_tools_a_longer_vessel_and_a_wall_need_more_cycles, set_up,
                                        tear_down),
        cmocka_unit_test(every_priced_session_is_judged_as_its_measured_cycles_are),
    };
    cmocka_set_message_output(CM_OUTPUT_TAP);
    return cmocka_run_group_tests(tests, NULL, NULL);
}
