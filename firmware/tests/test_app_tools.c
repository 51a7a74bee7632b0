/* These tests check several nested tools through bytes on the simulated port. Each hand moves its own tool;
 * the set-up of the tools succeeds or fails as a whole, and a refused set-up names the tool at fault. The
 * device sends the forces of the vessel wall on request. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "firmware/tests/reference/client.h"
#include "firmware/tests/reference/tube_scene.h"

enum { WIRE, CATHETER, GUIDE, TOOLS };

static client host;
static crn_wire_status status;
static crn_wire_reject reject;
static crn_wire_ticks ticks;
static crn_wire_tools tools;

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

/* --- motion --- */

/* The wire is pushed by 30 mm and the catheter by 10 mm, while the guiding catheter is pulled back by 10 mm.
 * In free space each tool follows its own hand; the test allows 0.3 mm for friction between the tools and for
 * the compliance of the coupling to the hand. */
static void each_hand_moves_its_own_tool(void **state)
{
    (void)state;
    uint32_t tick = 0;
    start_three();
    move(&tick, 1000, (const int32_t[]){30, 10, -10});
    move(&tick, 300, (const int32_t[]){0, 0, 0});
    assert_int_equal(ticks.states[49].tools_count, TOOLS);
    expect_inserted(WIRE, 80, 0.3);
    expect_inserted(CATHETER, 60, 0.3);
    expect_inserted(GUIDE, 40, 0.3);
    assert_int_equal(ticks.states[49].lead_tool, WIRE);
}

static void the_tool_whose_tip_is_farthest_leads(void **state)
{
    (void)state;
    uint32_t tick = 0;
    start_three();
    move(&tick, 500, (const int32_t[]){20, 0, 0});
    assert_int_equal(ticks.states[49].lead_tool, WIRE);
    move(&tick, 1000, (const int32_t[]){-20, 10, 0});
    assert_int_equal(ticks.states[49].lead_tool, CATHETER);
    move(&tick, 1000, (const int32_t[]){0, 0, 20});
    assert_int_equal(ticks.states[49].lead_tool, GUIDE);
    expect_inserted(WIRE, 40, 0.3);
}

static void a_session_with_three_tools_gives_the_same_hashes_every_time(void **state)
{
    (void)state;
    crn_wire_tick_state last[2];
    for (int run = 0; run < 2; run++) {
        uint32_t tick = 0;
        client_close(&host);
        client_open(&host, 0);
        start_three();
        move(&tick, 500, (const int32_t[]){25, -10, 5});
        last[run] = ticks.states[49];
    }
    assert_memory_equal(&last[0], &last[1], sizeof last[0]);
}

/* --- set-up --- */

/* A wire of 0.6 mm does not fit into the catheter's lumen of 0.5 mm. The device refuses the tools as a whole,
 * and can still be armed with the old tools. */
static void tools_that_do_not_nest_are_refused_by_name_and_leave_the_old_ones(void **state)
{
    (void)state;
    start_three();
    command(CRN_WIRE_ACTION_RESET);
    client_plain_tools(&tools, 2);
    tools.tools[WIRE].knots[1].radius_outer_um = 600;
    client_tools(&host, &tools);
    expect_reject(CRN_REJECT_TOOL_NESTING, CATHETER, 0);
    command(CRN_WIRE_ACTION_ARM);
    command(CRN_WIRE_ACTION_START);
    host.tool_count = TOOLS;
    client_step(&host, 0, 1, 0, 0);
    assert_true(client_expect_ticks(&host, &ticks));
    assert_int_equal(ticks.states[0].tools_count, TOOLS);
}

/* One wrong value in the message causes the refusal of the whole set of tools, and the refusal names the tool
 * and the knot (the entry of its table of properties). */
static void a_wrong_value_names_its_tool_and_knot(void **state)
{
    (void)state;
    greet();
    for (uint16_t k = 0; k < TOOLS; k++) {
        client_plain_tools(&tools, TOOLS);
        tools.tools[k].knots[1].bend_stiffness_nN_m2 = 5;
        client_tools(&host, &tools);
        expect_reject(CRN_REJECT_TOOL_RANGE, k, 1);
        client_plain_tools(&tools, TOOLS);
        tools.tools[k].knots_count = 1;
        client_tools(&host, &tools);
        expect_reject(CRN_REJECT_TOOL_KNOTS, k, 0);
        client_plain_tools(&tools, TOOLS);
        tools.tools[k].element_tip_um = 100;
        client_tools(&host, &tools);
        expect_reject(CRN_REJECT_TOOL_ELEMENTS, k, 0);
        client_plain_tools(&tools, TOOLS);
        tools.tools[k].knots[1].arc_um = 19000;
        client_tools(&host, &tools);
        assert_true(client_expect_reject(&host, &reject));
        assert_int_equal(reject.code, CRN_REJECT_TOOL_LENGTH);
        assert_int_equal(reject.detail1, k);
    }
    client_command(&host, CRN_WIRE_ACTION_ARM);
    expect_reject(CRN_REJECT_SET_UP_MISSING, 0, 0);
}

/* Each value of a material has its range, and some values exist only for superelastic tools (crn_material in
 * firmware/core/core.h). */
static void a_material_outside_its_ranges_is_refused(void **state)
{
    (void)state;
    enum { ELASTIC = CRN_WIRE_MATERIAL_ELASTIC, METAL, SUPERELASTIC };
    static const struct {
        uint8_t kind;
        uint32_t yield_strain_micro, core_modulus_MPa, hardening_milli, unload_milli, limit_milli;
        bool is_accepted;
    } materials[] = {
        {ELASTIC, 0, 0, 0, 0, 0, true},
        {ELASTIC, 12510, 0, 0, 0, 0, false},
        {ELASTIC, 0, 0, 0, 1, 0, false},
        {METAL, 500, 1000, 0, 0, 0, true},
        {METAL, 50000, 300000, 900, 0, 0, true},
        {METAL, 499, 190000, 75, 0, 0, false},
        {METAL, 50001, 190000, 75, 0, 0, false},
        {METAL, UINT32_MAX, UINT32_MAX, UINT32_MAX, UINT32_MAX, UINT32_MAX, false},
        {METAL, 13900, 999, 75, 0, 0, false},
        {METAL, 13900, 300001, 75, 0, 0, false},
        {METAL, 13900, 190000, 901, 0, 0, false},
        {METAL, 13900, 190000, 75, 500, 0, false},
        {METAL, 13900, 190000, 75, 0, 5000, false},
        {SUPERELASTIC, 12510, 55000, 75, 400, 4900, true},
        {SUPERELASTIC, 12510, 55000, 900, 950, 20000, true},
        {SUPERELASTIC, 12510, 55000, 75, 951, 4900, false},
        {SUPERELASTIC, 12510, 55000, 75, 400, 99, false},
        {SUPERELASTIC, 12510, 55000, 75, 400, 20001, false},
        {SUPERELASTIC, 0, 55000, 75, 400, 4900, false},
        {SUPERELASTIC + 1, 12510, 55000, 75, 400, 4900, false},
        {255, 0, 0, 0, 0, 0, false},
    };
    greet();
    for (size_t i = 0; i < sizeof materials / sizeof materials[0]; i++) {
        client_plain_tools(&tools, TOOLS);
        crn_wire_instrument *tool = &tools.tools[CATHETER];
        tool->material_kind = materials[i].kind;
        tool->yield_strain_micro = materials[i].yield_strain_micro;
        tool->core_modulus_MPa = materials[i].core_modulus_MPa;
        tool->hardening_milli = materials[i].hardening_milli;
        tool->unload_milli = materials[i].unload_milli;
        tool->limit_milli = materials[i].limit_milli;
        client_tools(&host, &tools);
        if (materials[i].is_accepted)
            assert_true(client_expect_status(&host, &status));
        else
            expect_reject(CRN_REJECT_TOOL_RANGE, CATHETER, 0);
    }
}

/* Returns the state after a soft wire sagged under its weight, to some 40/m at the sheath. */
static crn_wire_tick_state sagged(uint8_t kind, uint32_t yield_strain_micro, uint32_t core_modulus_MPa)
{
    uint32_t tick = 0;
    client_close(&host);
    client_open(&host, 0);
    greet();
    client_plain_tools(&tools, 1);
    crn_wire_instrument *wire = &tools.tools[WIRE];
    wire->material_kind = kind;
    wire->yield_strain_micro = yield_strain_micro;
    wire->core_modulus_MPa = core_modulus_MPa;
    for (int i = 0; i < 2; i++)
        wire->knots[i].bend_stiffness_nN_m2 = wire->knots[i].twist_stiffness_nN_m2 = 1000;
    client_tools(&host, &tools);
    assert_true(client_expect_status(&host, &status));
    client_entry(&host, 50000);
    assert_true(client_expect_status(&host, &status));
    command(CRN_WIRE_ACTION_ARM);
    command(CRN_WIRE_ACTION_START);
    memset(hands_at, 0, sizeof hands_at);
    move(&tick, 500, (const int32_t[]){0, 0, 0});
    return ticks.states[49];
}

/* A wire that passes its yield curvature moves otherwise than the elastic one: with EI = 1e-6 N m^2 and 1
 * GPa, the core's radius is 0.19 mm, and the strain 0.0005 is reached at 2.6/m. A wire that stays below its
 * yield curvature, here 1100/m, moves like the elastic one. */
static void the_material_of_the_message_is_that_of_the_core(void **state)
{
    (void)state;
    const crn_wire_tick_state elastic = sagged(CRN_WIRE_MATERIAL_ELASTIC, 0, 0),
                              below = sagged(CRN_WIRE_MATERIAL_METAL, 50000, 300000),
                              beyond = sagged(CRN_WIRE_MATERIAL_METAL, 500, 1000);
    assert_int_equal(elastic.hash_lane0, below.hash_lane0);
    assert_int_equal(elastic.hash_lane1, below.hash_lane1);
    assert_int_not_equal(elastic.hash_lane0, beyond.hash_lane0);
}

static void none_and_four_tools_are_refused(void **state)
{
    (void)state;
    greet();
    memset(&tools, 0, sizeof tools);
    client_tools(&host, &tools);
    expect_reject(CRN_REJECT_TOOL_COUNT, 0, TOOLS);
    uint8_t four[2 + 4 * 22] = {4};
    client_send(&host, CRN_WIRE_TYPE_tools, four, sizeof four);
    assert_true(client_expect_reject(&host, &reject));
    assert_int_equal(reject.code, CRN_REJECT_MALFORMED);
}

/* An `entry` message gives one inserted length per tool; if the number of tools changes, the host must send a
 * new `entry` message. */
static void an_entry_belongs_to_its_number_of_tools(void **state)
{
    (void)state;
    const uint32_t lengths_um[] = {50000, 40000};
    greet();
    client_entry_each(&host, lengths_um, 2);
    expect_reject(CRN_REJECT_SET_UP_MISSING, 0, 0);
    client_plain_tools(&tools, TOOLS);
    client_tools(&host, &tools);
    assert_true(client_expect_status(&host, &status));
    client_entry_each(&host, lengths_um, 2);
    expect_reject(CRN_REJECT_TOOL_COUNT, 2, TOOLS);
    client_entry(&host, 50000);
    assert_true(client_expect_status(&host, &status));
    client_plain_tools(&tools, 2);
    client_tools(&host, &tools);
    assert_true(client_expect_status(&host, &status));
    client_command(&host, CRN_WIRE_ACTION_ARM);
    expect_reject(CRN_REJECT_SET_UP_MISSING, 2, 0);
    client_entry_each(&host, lengths_um, 2);
    assert_true(client_expect_status(&host, &status));
    command(CRN_WIRE_ACTION_ARM);
}

static void the_tool_that_is_too_short_for_its_start_is_named(void **state)
{
    (void)state;
    const uint32_t lengths_um[] = {50000, 300001, 40000};
    greet();
    client_plain_tools(&tools, TOOLS);
    client_tools(&host, &tools);
    assert_true(client_expect_status(&host, &status));
    client_entry_each(&host, lengths_um, TOOLS);
    assert_true(client_expect_status(&host, &status));
    client_command(&host, CRN_WIRE_ACTION_ARM);
    expect_reject(CRN_REJECT_LENGTH_INSERTED, CATHETER, 300000);
}

static void inputs_for_another_number_of_tools_are_refused_and_change_nothing(void **state)
{
    (void)state;
    const int32_t none[TOOLS] = {0};
    start_three();
    host.tool_count = 2;
    client_step(&host, 0, 5, 0, 10);
    expect_reject(CRN_REJECT_TOOL_COUNT, 2, TOOLS);
    client_input(&host, none, none);
    expect_reject(CRN_REJECT_TOOL_COUNT, 2, TOOLS);
    expect_state(CRN_WIRE_STATE_RUNNING);
    assert_int_equal(status.tick, 0);
}

/* --- contacts --- */

static void read_contacts(crn_wire_contacts *contacts)
{
    client_get(&host, CRN_WIRE_GET_CONTACTS);
    assert_int_equal(client_receive(&host), CRN_WIRE_TYPE_contacts);
    assert_true(crn_wire_decode_contacts(host.decoder.payload, host.decoder.payload_bytes, contacts));
}

/* Makes a scene with a tube of 2 mm radius around the x axis, and an entry at the tube's beginning. */
static void send_tube(void)
{
    static uint8_t file[1 << 20];
    const reference_piece straight = {0.3, 0, 0};
    reference_tube *tube = reference_tube_make(&straight, 1, 0.002, 0);
    const size_t bytes = reference_tube_scene(tube, file, sizeof file);
    assert_true(bytes > 0);
    reference_tube_free(tube);
    assert_true(client_load_scene(&host, file, (uint32_t)bytes));
}

/* A straight wire lies on the floor of a horizontal tube. In total, the wall supports the weight of the wire
 * outside the introducer sheath, minus the part of this weight that the sheath supports. Every force of the
 * wall on the wire points up, and the number of forces is the one that the tick reports. The wire lies in
 * blood of 1,060 kg/m^3. */
static void contact_forces_carry_the_weight(void **state)
{
    (void)state;
    static crn_wire_contacts contacts;
    greet();
    client_get(&host, CRN_WIRE_GET_CONTACTS);
    expect_reject(CRN_REJECT_WRONG_STATE, CRN_WIRE_STATE_READY, 0);
    send_tube();
    client_plain_tools(&tools, 1);
    tools.tools[0].knots[0].bend_stiffness_nN_m2 = tools.tools[0].knots[1].bend_stiffness_nN_m2 = 100000;
    client_tools(&host, &tools);
    assert_true(client_expect_status(&host, &status));
    assert_true(client_entry_along(&host, 0, 250000));
    command(CRN_WIRE_ACTION_ARM);
    read_contacts(&contacts);
    assert_int_equal(contacts.contacts_count, 0);
    command(CRN_WIRE_ACTION_START);
    for (uint32_t tick = 0; tick < 2000; tick += 50) {
        client_step(&host, tick, 50, 0, 0);
        assert_true(client_expect_ticks(&host, &ticks));
    }
    read_contacts(&contacts);
    assert_int_equal(contacts.tick, 2000);
    assert_int_equal(contacts.contacts_count, ticks.states[49].contact_count);
    double up_N = 0;
    for (uint16_t i = 0; i < contacts.contacts_count; i++) {
        assert_true(i == 0 || contacts.contacts[i].node > contacts.contacts[i - 1].node);
        assert_true(contacts.contacts[i].force_z_N_q22 >= 0);
        up_N += contacts.contacts[i].force_z_N_q22 / 4194304.0;
    }
    const double radius_m = tools.tools[0].knots[0].radius_outer_um * 1e-6;
    const double weight_N = 0.25 * (0.004 - 1060 * acos(-1.0) * radius_m * radius_m) * 9.81;
    if (up_N < 0.6 * weight_N || up_N > weight_N) {
        fail_msg("the wall carries %.5f N of a weight of %.5f N", up_N, weight_N);
    }
}

#define TEST(name) cmocka_unit_test_setup_teardown(name, set_up, tear_down)

int main(void)
{
    const struct CMUnitTest tests[] = {
        TEST(each_hand_moves_its_own_tool),
        TEST(the_tool_whose_tip_is_farthest_leads),
        TEST(a_session_with_three_tools_gives_the_same_hashes_every_time),
        TEST(tools_that_do_not_nest_are_refused_by_name_and_leave_the_old_ones),
        TEST(a_wrong_value_names_its_tool_and_knot),
        TEST(a_material_outside_its_ranges_is_refused),
        TEST(the_material_of_the_message_is_that_of_the_core),
        TEST(none_and_four_tools_are_refused),
        TEST(an_entry_belongs_to_its_number_of_tools),
        TEST(the_tool_that_is_too_short_for_its_start_is_named),
        TEST(inputs_for_another_number_of_tools_are_refused_and_change_nothing),
        TEST(contact_forces_carry_the_weight),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
