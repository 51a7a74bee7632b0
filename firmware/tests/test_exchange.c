/* These tests check the exchange of nested tools (docs/rod.md, "exchange"). An exchange moves no node and
 * does not change the other tools; a refused exchange changes nothing at all. A tool that was inserted by an
 * exchange behaves bit for bit as if the session had begun with this tool. Each impossible exchange is
 * refused with the code of its own reason, and random orders never make the state invalid. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "firmware/core/balloon.h"
#include "firmware/tests/reference/random.h"
#include "firmware/tests/reference/rod_rig.h"

static const double Q30 = 1073741824.0;

/* Gives the numbers of the tools in the tests' table, as an order to exchange tools names them. The second
 * wire is short: it is 1.2 m long. */
enum { STIFF_WIRE = 1, SHORT_WIRE, BALLOON, MONORAIL, GUIDE, THICK_WIRE, NARROW_GUIDE, TABLE_COUNT = 7 };
enum { INNER, MIDDLE, OUTER };

static crn_instrument tube_of(double bend_N_m2, uint32_t outer_um, uint32_t bore_um, uint32_t whole_um)
{
    crn_instrument tool = reference_wire(bend_N_m2, 900000, 4000, 0.1);
    tool.element_tip_um = 1000;
    tool.element_shaft_um = 3000; /* no cell at the sheath's end reaches the tip of a withdrawn tool */
    tool.element_fine_um = 40000;
    tool.lumen_friction_milli = 50;
    tool.whole_um = whole_um;
    for (uint32_t i = 0; i < tool.knot_count; i++) {
        tool.knots[i].radius_outer_um = outer_um;
        tool.knots[i].radius_inner_um = bore_um;
    }
    return tool;
}

static void add_balloon(crn_instrument *tool)
{
    tool->balloon = (crn_balloon){.point_count = 4,
                                  .distal_um = 6000,
                                  .proximal_um = 24000,
                                  .burst_kPa = 1700,
                                  .pressure_kPa = {600, 800, 1200, 1600},
                                  .diameter_um = {2920, 3000, 3120, 3230}};
}

static void make_table(crn_instrument table[TABLE_COUNT])
{
    table[STIFF_WIRE - 1] = tube_of(6e-5, 178, 0, 3000000);
    table[SHORT_WIRE - 1] = tube_of(2e-5, 178, 0, 1200000);
    table[BALLOON - 1] = tube_of(1e-5, 450, 210, 1400000);
    add_balloon(&table[BALLOON - 1]);
    table[MONORAIL - 1] = tube_of(1.5e-5, 460, 210, 1400000);
    table[MONORAIL - 1].rail_um = 250000;
    add_balloon(&table[MONORAIL - 1]);
    table[GUIDE - 1] = tube_of(3e-4, 1040, 900, 1000000);
    table[THICK_WIRE - 1] = tube_of(1e-4, 445, 0, 2600000);
    table[NARROW_GUIDE - 1] = tube_of(3e-4, 1040, 440, 1000000);
}

static rig *rig_with(const uint32_t line[CRN_TOOL_MAX], const crn_lumen *lumen, const uint32_t inserted_um[])
{
    rig *r = calloc(1, sizeof *r);
    crn_instrument table[TABLE_COUNT];
    crn_entry entry = reference_entry();
    crn_build_place place;
    make_table(table);
    assert_int_equal(
        crn_model_build_table(&r->model, table, TABLE_COUNT, line, CRN_TOOL_MAX, lumen, &entry, &place),
        CRN_BUILD_OK);
    crn_state_init(&r->model, &r->state, inserted_um);
    return r;
}

static crn_exchange_status exchange(rig *r, uint32_t position, uint32_t tool)
{
    const crn_exchange_order order = {position, tool};
    return crn_exchange(&r->model, &r->state, &order);
}

static void rest(rig *r, int ticks)
{
    for (int t = 0; t < ticks; t++) rig_step(r);
}

/* Moves the hand that holds the tool at one position by `way_m` at 0.4 m/s, and waits until the tool has
 * followed. */
static void move(rig *r, uint32_t position, double way_m)
{
    const int ticks = (int)ceil(fabs(way_m) / 0.4e-3);
    const int32_t from = r->input.hands[position].feed_m_q30;
    for (int t = 1; t <= ticks; t++) {
        r->input.hands[position].feed_m_q30 = from + (int32_t)lround(way_m * t / ticks * Q30);
        rig_step(r);
    }
    rest(r, 100);
}

static double inserted_mm(const rig *r, uint32_t position)
{
    return r->state.words.tools[position].inserted_m_q30 / Q30 * 1e3;
}

static reference_tube *straight_tube(void)
{
    const reference_piece pieces[] = {{0.5, 0, 0}};
    return reference_tube_make(pieces, 1, 3.6e-3, 1);
}

/* Makes a guide inserted by 200 mm with a wire inside; the position between them has no tool. */
static rig *wire_in_guide(reference_tube *tube)
{
    static const uint32_t line[] = {STIFF_WIRE, 0, GUIDE}, inserted_um[] = {260000, 0, 200000};
    rig *r = rig_with(line, &tube->lumen, inserted_um);
    rest(r, 300);
    return r;
}

static void table_that_is_the_line_gives_todays_model(void **context)
{
    (void)context;
    static const uint32_t line[] = {1, 2, 3};
    crn_instrument table[TABLE_COUNT];
    crn_entry entry = reference_entry();
    crn_build_place place;
    crn_model *a = malloc(sizeof *a), *b = malloc(sizeof *b);
    make_table(table);
    const crn_instrument tools[3] = {table[STIFF_WIRE - 1], table[BALLOON - 1], table[GUIDE - 1]};
    assert_int_equal(crn_model_build(a, tools, 3, NULL, &entry, &place), CRN_BUILD_OK);
    assert_int_equal(crn_model_build_table(b, tools, 3, line, 3, NULL, &entry, &place), CRN_BUILD_OK);
    assert_memory_equal(a, b, sizeof *a);
    free(a);
    free(b);
}

/* Compares two states, before and after an exchange: all values of the nodes, and of every tool position
 * except one, must be equal. */
static void assert_others_kept(const crn_state_words *before, const crn_state_words *after, uint32_t except)
{
    assert_int_equal(before->free_count, after->free_count);
    for (uint32_t i = 0; i < after->free_count + 3; i++) {
        const crn_node_state *a = &before->nodes[i], *b = &after->nodes[i];
        assert_memory_equal(a, b, offsetof(crn_node_state, angle_turn32));
        assert_int_equal(a->contact, b->contact);
        for (uint32_t k = 0; k < CRN_TOOL_MAX; k++) {
            if (k == except) continue;
            assert_int_equal(a->angle_turn32[k], b->angle_turn32[k]);
            assert_int_equal(a->spin_q30[k], b->spin_q30[k]);
        }
    }
    for (uint32_t k = 0; k < CRN_TOOL_MAX; k++) {
        if (k != except) assert_memory_equal(&before->tools[k], &after->tools[k], sizeof(crn_tool_state));
    }
}

static void exchange_keeps_the_other_tools_bit_for_bit(void **context)
{
    (void)context;
    reference_tube *tube = straight_tube();
    rig *r = wire_in_guide(tube);
    crn_state_words *before = malloc(sizeof *before);
    *before = r->state.words;
    assert_int_equal(exchange(r, MIDDLE, BALLOON), CRN_EXCHANGE_DONE);
    assert_others_kept(before, &r->state.words, MIDDLE);
    assert_int_equal(crn_state_tool_at(&r->state, MIDDLE), BALLOON);
    move(r, MIDDLE, 0.1);
    move(r, MIDDLE, -0.2);
    *before = r->state.words;
    assert_int_equal(exchange(r, MIDDLE, MONORAIL), CRN_EXCHANGE_DONE);
    assert_others_kept(before, &r->state.words, MIDDLE);
    *before = r->state.words;
    assert_int_equal(exchange(r, MIDDLE, 0), CRN_EXCHANGE_DONE);
    assert_others_kept(before, &r->state.words, MIDDLE);
    free(before);
    free(r);
    reference_tube_free(tube);
}

/* Two sets of nested tools differ by a catheter that an exchange has put into one of them. The catheter's tip
 * is still inside the sheath, but the guide now rubs on the catheter instead of on the wire. None of the
 * hands moves. The largest measured difference of a node's position was 27 nm after 50 ticks; the test allows
 * 100 nm. */
static void exchange_moves_no_node_in_the_next_ticks(void **context)
{
    (void)context;
    reference_tube *tube = straight_tube();
    rig *with = wire_in_guide(tube), *without = wire_in_guide(tube);
    assert_int_equal(exchange(with, MIDDLE, BALLOON), CRN_EXCHANGE_DONE);
    double most_nm = 0;
    for (int t = 0; t < 50; t++) {
        rig_step(with);
        rig_step(without);
        for (uint32_t i = 0; i < with->state.words.free_count; i++) {
            for (int c = 0; c < 3; c++) {
                most_nm = fmax(most_nm, fabs((crn_state_position(&with->state, i).v[c] -
                                              crn_state_position(&without->state, i).v[c]) /
                                             Q30 * 1e9));
            }
        }
    }
    check_below("difference of a node, nm", most_nm, 100);
    free(with);
    free(without);
    reference_tube_free(tube);
}

/* Withdraws the inner tool completely, and then puts the hand exactly where it holds the withdrawn tool. */
static void withdraw_exactly(rig *r)
{
    move(r, INNER, -0.0055);
    r->input.hands[INNER].feed_m_q30 = CRN_WITHDRAWN_M_Q30;
    rest(r, 50);
}

/* A wire is withdrawn and removed, another wire is put in its place and removed, and the first wire is put in
 * again. After the last exchange, the state is bit for bit as if the first wire had stayed all the time. */
static void tool_that_came_by_exchange_is_the_tool_that_stayed(void **context)
{
    (void)context;
    static const uint32_t line[] = {STIFF_WIRE, 0, GUIDE}, inserted_um[] = {0, 0, 200000};
    reference_tube *tube = straight_tube();
    rig *a = rig_with(line, &tube->lumen, inserted_um), *b = rig_with(line, &tube->lumen, inserted_um);
    withdraw_exactly(a);
    withdraw_exactly(b);
    assert_int_equal(exchange(a, INNER, 0), CRN_EXCHANGE_DONE);
    rest(a, 20);
    assert_int_equal(exchange(a, INNER, SHORT_WIRE), CRN_EXCHANGE_DONE);
    rest(a, 20);
    assert_int_equal(exchange(a, INNER, STIFF_WIRE), CRN_EXCHANGE_DONE);
    rest(b, 40);
    for (int i = 0; i < 3; i++) {
        move(a, INNER, 0.05);
        move(b, INNER, 0.05);
        a->state.words.exchange = b->state.words.exchange; /* what remains of the history */
        assert_true(crn_state_hash64(&a->state) == crn_state_hash64(&b->state));
    }
    assert_true(inserted_mm(a, INNER) > 100);
    free(a);
    free(b);
    reference_tube_free(tube);
}

/* A tool leaves no force, no friction and no rotation to the one that takes its place. Its hand keeps its
 * angle. */
static void nothing_of_a_tool_that_left_stays(void **context)
{
    (void)context;
    static const uint32_t line[] = {STIFF_WIRE, 0, GUIDE}, inserted_um[] = {0, 0, 200000};
    rig *r = rig_with(line, NULL, inserted_um);
    withdraw_exactly(r);
    crn_tool_state *tool = &r->state.words.tools[INNER];
    const uint32_t angle_turn32 = tool->base_turn32 = 12345678;
    tool->handle_axial_N_q22 = tool->slide_grip_m_q33 = tool->slide_share_q30 = tool->tip_axial_N_q22 = 1
                                                                                                        << 20;
    for (uint32_t i = 0; i < r->state.words.free_count + 3; i++) {
        crn_node_state *node = &r->state.words.nodes[i];
        node->spin_q30[INNER] = node->grip_q30[INNER] = 1 << 20;
    }
    assert_int_equal(exchange(r, INNER, SHORT_WIRE), CRN_EXCHANGE_DONE);
    assert_true(tool->handle_axial_N_q22 == 0 && tool->slide_grip_m_q33 == 0);
    assert_true(tool->slide_share_q30 == 0 && tool->tip_axial_N_q22 == 0);
    assert_int_equal(tool->base_turn32, angle_turn32);
    for (uint32_t i = 0; i < r->state.words.free_count + 3; i++) {
        const crn_node_state *node = &r->state.words.nodes[i];
        assert_true(node->spin_q30[INNER] == 0 && node->grip_q30[INNER] == 0);
        assert_int_equal(node->angle_turn32[INNER], 0u - angle_turn32);
    }
    free(r);
}

static void assert_refused(rig *r, uint32_t position, uint32_t tool, crn_exchange_status status)
{
    rig *before = malloc(sizeof *before);
    *before = *r;
    const crn_exchange_order order = {position, tool};
    const crn_exchange_status found = crn_exchange_check(&r->model, &r->state, &order);
    if (found != status) fail_msg("position %u, tool %u: %d, expected %d", position, tool, found, status);
    assert_int_equal(crn_exchange(&r->model, &r->state, &order), status);
    assert_memory_equal(&before->model, &r->model, sizeof r->model);
    assert_memory_equal(&before->state.words, &r->state.words, sizeof r->state.words);
    free(before);
}

static void impossible_exchanges_are_refused_by_name(void **context)
{
    (void)context;
    reference_tube *tube = straight_tube();
    rig *r = wire_in_guide(tube);
    assert_refused(r, 3, BALLOON, CRN_EXCHANGE_NO_POSITION);
    assert_refused(r, UINT32_MAX, 0, CRN_EXCHANGE_NO_POSITION);
    assert_refused(r, MIDDLE, TABLE_COUNT + 1, CRN_EXCHANGE_NO_TOOL);
    assert_refused(r, MIDDLE, 0, CRN_EXCHANGE_FREE);
    assert_refused(r, MIDDLE, GUIDE, CRN_EXCHANGE_ON_LINE);
    assert_refused(r, INNER, SHORT_WIRE, CRN_EXCHANGE_INSIDE);
    assert_refused(r, OUTER, 0, CRN_EXCHANGE_INSIDE);
    assert_refused(r, MIDDLE, NARROW_GUIDE, CRN_EXCHANGE_TOO_WIDE);
    assert_refused(r, MIDDLE, SHORT_WIRE, CRN_EXCHANGE_TOO_NARROW);
    free(r);
    reference_tube_free(tube);
}

static void wire_that_is_too_short_holds_no_catheter_over_the_wire(void **context)
{
    (void)context;
    static const uint32_t line[] = {SHORT_WIRE, 0, GUIDE}, inserted_um[] = {260000, 0, 200000};
    rig *r = rig_with(line, NULL, inserted_um);
    assert_refused(r, MIDDLE, BALLOON, CRN_EXCHANGE_SHORT);             /* 940 mm outside, 1400 mm needed */
    assert_int_equal(exchange(r, MIDDLE, MONORAIL), CRN_EXCHANGE_DONE); /* 250 mm needed */
    free(r);
}

static void nothing_passes_over_a_hub(void **context)
{
    (void)context;
    static const uint32_t line[] = {STIFF_WIRE, BALLOON, GUIDE}, inserted_um[] = {260000, 230000, 20000};
    rig *r = rig_with(line, NULL, inserted_um);
    move(r, OUTER, -0.04);
    assert_refused(r, OUTER, NARROW_GUIDE, CRN_EXCHANGE_TOO_NARROW);
    assert_refused(r, OUTER, 0, CRN_EXCHANGE_HUB);
    free(r);
}

/* The only tool is replaced when its inserted length is as short as it can be. After the exchange, the new
 * tool can be inserted as far as if the session had begun with it. The test allows a difference of 2 mm, by
 * which the hand slips at the end of the insertion. */
static void last_tool_can_be_replaced_but_not_taken_off(void **context)
{
    (void)context;
    static const uint32_t line[] = {STIFF_WIRE, 0, 0}, other[] = {THICK_WIRE, 0, 0},
                          inserted_um[] = {50000, 0, 0};
    rig *r = rig_with(line, NULL, inserted_um), *fresh = rig_with(other, NULL, inserted_um);
    assert_refused(r, INNER, THICK_WIRE, CRN_EXCHANGE_INSIDE);
    move(r, INNER, -0.1);
    move(fresh, INNER, -0.1);
    assert_refused(r, INNER, 0, CRN_EXCHANGE_LEADS);
    assert_int_equal(exchange(r, INNER, THICK_WIRE), CRN_EXCHANGE_DONE);
    move(r, INNER, 0.1);
    move(fresh, INNER, 0.1);
    check_below("difference of the inserted length, mm",
                fabs(inserted_mm(r, INNER) - inserted_mm(fresh, INNER)), 2);
    assert_true(inserted_mm(r, INNER) > 50);
    free(r);
    free(fresh);
}

/* A guide is exchanged over a wire that is not withdrawn: the tip of the wire moves by less than 0.2 mm. */
static void guide_is_swapped_over_the_wire(void **context)
{
    (void)context;
    static const uint32_t line[] = {STIFF_WIRE, 0, GUIDE}, inserted_um[] = {260000, 0, 100000};
    rig *r = rig_with(line, NULL, inserted_um);
    crn_model_set_gravity(&r->model, 0, 0, 0);
    const double before = inserted_mm(r, INNER);
    move(r, OUTER, -0.11);
    assert_int_equal(exchange(r, OUTER, NARROW_GUIDE), CRN_EXCHANGE_DONE);
    move(r, OUTER, 0.1);
    check_below("way of the wire, mm", fabs(inserted_mm(r, INNER) - before), 0.2);
    assert_true(inserted_mm(r, OUTER) > 80);
    free(r);
}

static void balloons_are_refused_while_inflated_and_once_burst(void **context)
{
    (void)context;
    static const uint32_t line[] = {STIFF_WIRE, BALLOON, GUIDE}, inserted_um[] = {260000, 230000, 100000};
    rig *r = rig_with(line, NULL, inserted_um);
    r->input.inflator_Pa = 1800000;
    rest(r, 3000);
    assert_true((r->output.balloon_bits & CRN_BALLOON_BURST) != 0);
    r->input.inflator_Pa = 0;
    rest(r, 3000);
    move(r, MIDDLE, -0.25);
    r->input.inflator_Pa = 600000;
    r->state.words.balloon.pressure_Pa = 600000;
    assert_refused(r, MIDDLE, 0, CRN_EXCHANGE_INFLATED);
    r->input.inflator_Pa = r->state.words.balloon.pressure_Pa = 0;
    assert_int_equal(exchange(r, MIDDLE, 0), CRN_EXCHANGE_DONE);
    assert_refused(r, MIDDLE, BALLOON, CRN_EXCHANGE_BURST);
    assert_int_equal(exchange(r, MIDDLE, MONORAIL), CRN_EXCHANGE_DONE);
    rest(r, 10);
    assert_int_equal(r->output.balloon_bits & CRN_BALLOON_BURST, 0);
    free(r);
}

static void second_balloon_is_refused(void **context)
{
    (void)context;
    crn_instrument table[2] = {tube_of(1e-5, 450, 210, 0), tube_of(1e-5, 600, 500, 0)};
    static const uint32_t line[] = {1, 0}, both[] = {1, 2}, inserted_um[] = {100000, 0};
    crn_entry entry = reference_entry();
    crn_build_place place;
    rig *r = calloc(1, sizeof *r);
    add_balloon(&table[0]);
    add_balloon(&table[1]);
    assert_int_equal(crn_model_build_table(&r->model, table, 2, both, 2, NULL, &entry, &place),
                     CRN_BUILD_BALLOON);
    assert_int_equal(place.tool, 1);
    assert_int_equal(crn_model_build_table(&r->model, table, 2, line, 2, NULL, &entry, &place), CRN_BUILD_OK);
    crn_state_init(&r->model, &r->state, inserted_um);
    assert_refused(r, 1, 2, CRN_EXCHANGE_HUB);
    for (int i = 0; i < 2; i++) table[0].knots[i].radius_inner_um = 0;
    assert_int_equal(crn_model_build_table(&r->model, table, 2, line, 2, NULL, &entry, &place), CRN_BUILD_OK);
    assert_refused(r, 1, 2, CRN_EXCHANGE_BALLOON);
    free(r);
}

/* Friction acts between a wire and the guide around it even if the position between them has no tool: the
 * results are equal bit for bit, whichever position the guide has. */
static void free_position_between_two_tools_changes_nothing(void **context)
{
    (void)context;
    static const uint32_t apart[] = {STIFF_WIRE, 0, GUIDE}, together[] = {STIFF_WIRE, GUIDE, 0};
    static const uint32_t inserted_apart_um[] = {260000, 0, 200000}, inserted_um[] = {260000, 200000, 0};
    reference_tube *tube = reference_three_bends(4e-3, 1);
    rig *a = rig_with(apart, &tube->lumen, inserted_apart_um);
    rig *b = rig_with(together, &tube->lumen, inserted_um);
    for (int t = 0; t < 1500; t++) {
        const int32_t way = (int32_t)(0.0001 * Q30 * t);
        a->input.hands[INNER] = b->input.hands[INNER] = (crn_hand_pose){way, (uint32_t)t << 21};
        a->input.hands[OUTER] = b->input.hands[MIDDLE] = (crn_hand_pose){way / 2, 0};
        rig_step(a);
        rig_step(b);
        for (uint32_t i = 0; i < a->state.words.free_count; i++) {
            assert_memory_equal(&a->state.words.nodes[i].position_m_q30,
                                &b->state.words.nodes[i].position_m_q30, sizeof(crn_vec3));
        }
        assert_int_equal(a->output.tools[INNER].axial_N_q22, b->output.tools[INNER].axial_N_q22);
        assert_int_equal(a->output.tools[OUTER].torque_N_m_q24, b->output.tools[MIDDLE].torque_N_m_q24);
    }
    free(a);
    free(b);
    reference_tube_free(tube);
}

/* A saved state contains the numbers of the nested tools, so the state can be restored into a model with
 * other nested tools. */
static void saved_line_is_restored_bit_for_bit(void **context)
{
    (void)context;
    reference_tube *tube = straight_tube();
    rig *a = wire_in_guide(tube), *b = wire_in_guide(tube);
    assert_int_equal(exchange(a, MIDDLE, MONORAIL), CRN_EXCHANGE_DONE);
    move(a, MIDDLE, 0.05);
    uint8_t *bytes = malloc(crn_state_bytes());
    crn_state_save(&a->state, bytes);
    assert_true(crn_state_restore(&b->model, &b->state, bytes));
    b->input = a->input;
    for (int t = 0; t < 200; t++) {
        a->input.hands[MIDDLE].feed_m_q30 += 200000;
        b->input.hands[MIDDLE].feed_m_q30 += 200000;
        rig_step(a);
        rig_step(b);
    }
    assert_true(crn_state_hash64(&a->state) == crn_state_hash64(&b->state));
    free(bytes);
    free(a);
    free(b);
    reference_tube_free(tube);
}

static void lines_that_cannot_be_are_not_restored(void **context)
{
    (void)context;
    reference_tube *tube = straight_tube();
    rig *r = wire_in_guide(tube);
    uint8_t *bytes = malloc(crn_state_bytes());
    const crn_exchange_state good = r->state.words.exchange;
    static const uint32_t bad[][CRN_TOOL_MAX] = {{STIFF_WIRE, 0, STIFF_WIRE},
                                                 {STIFF_WIRE, 0, 8},
                                                 {STIFF_WIRE, 0, NARROW_GUIDE + 90},
                                                 {0, 0, 0},
                                                 {GUIDE, 0, STIFF_WIRE},
                                                 {STIFF_WIRE, GUIDE, NARROW_GUIDE}};
    for (size_t i = 0; i < sizeof bad / sizeof bad[0]; i++) {
        memcpy(r->state.words.exchange.line, bad[i], sizeof bad[i]);
        crn_state_save(&r->state, bytes);
        assert_false(crn_state_restore(&r->model, &r->state, bytes));
    }
    r->state.words.exchange = good;
    r->state.words.exchange.burst_bits = 1u << TABLE_COUNT;
    crn_state_save(&r->state, bytes);
    assert_false(crn_state_restore(&r->model, &r->state, bytes));
    r->state.words.exchange = good;
    crn_state_save(&r->state, bytes);
    assert_true(crn_state_restore(&r->model, &r->state, bytes));
    free(bytes);
    free(r);
    reference_tube_free(tube);
}

/* Before the first exchange, the hash does not contain the numbers of the nested tools, so wrong numbers in a
 * restored state would not change the hash. */
static void another_line_needs_an_exchange(void **context)
{
    (void)context;
    reference_tube *tube = straight_tube();
    rig *r = wire_in_guide(tube);
    uint8_t *bytes = malloc(crn_state_bytes());
    r->state.words.exchange.line[MIDDLE] = MONORAIL;
    crn_state_save(&r->state, bytes);
    assert_false(crn_state_restore(&r->model, &r->state, bytes));
    r->state.words.exchange.count = 1;
    crn_state_save(&r->state, bytes);
    assert_true(crn_state_restore(&r->model, &r->state, bytes));
    free(bytes);
    free(r);
    reference_tube_free(tube);
}

/* Every exchange changes the hash, even an exchange that leaves all other words of the state unchanged. */
static void exchange_enters_the_hash(void **context)
{
    (void)context;
    reference_tube *tube = straight_tube();
    rig *r = wire_in_guide(tube);
    uint32_t before[2], after[2];
    const uint64_t hash = crn_state_hash64(&r->state);
    crn_state_hash_lanes(&r->state, before);
    assert_int_equal(exchange(r, MIDDLE, BALLOON), CRN_EXCHANGE_DONE);
    crn_state_hash_lanes(&r->state, after);
    assert_true(crn_state_hash64(&r->state) != hash);
    assert_memory_not_equal(before, after, sizeof before);
    free(r);
    reference_tube_free(tube);
}

/* Hands move at random, and random orders arrive, most of which are refused. After every order, the state
 * passes all checks of a restore, and every tool stays in the vessel. The allowed depth in the wall is 0.2
 * mm, the depth beyond which the wall is stiffer. */
static void random_orders_never_break_the_line(void **context)
{
    (void)context;
    const uint64_t seed = 20261126;
    reference_random random = reference_random_seed(seed);
    reference_tube *tube = reference_three_bends(4e-3, 1);
    static const uint32_t line[] = {STIFF_WIRE, 0, GUIDE}, inserted_um[] = {30000, 0, 20000};
    rig *r = rig_with(line, &tube->lumen, inserted_um);
    uint8_t *bytes = malloc(crn_state_bytes());
    int32_t way[CRN_TOOL_MAX] = {0};
    uint32_t done = 0, orders = 0;
    for (int t = 0; t < 12000; t++) {
        for (uint32_t k = 0; k < CRN_TOOL_MAX; k++) {
            if (reference_random_below(&random, 100) == 0) {
                way[k] = (int32_t)reference_random_below(&random, 800000) - 400000;
            }
            r->input.hands[k].feed_m_q30 += way[k];
            r->input.hands[k].turn32 += (uint32_t)way[k] * 8;
        }
        for (int i = 0; i < 2; i++, orders++) {
            const uint32_t position = reference_random_below(&random, 4),
                           tool = reference_random_below(&random, 9);
            done += exchange(r, position, tool) == CRN_EXCHANGE_DONE;
        }
        rig_step(r);
        if (r->output.penetration_max_m_q30 > 0.0005 * Q30) {
            fail_msg("seed %llu, tick %d: %g mm in the wall", (unsigned long long)seed, t,
                     r->output.penetration_max_m_q30 / Q30 * 1e3);
        }
        if (t % 50 == 0) {
            crn_state_save(&r->state, bytes);
            if (!crn_state_restore(&r->model, &r->state, bytes))
                fail_msg("seed %llu, tick %d", (unsigned long long)seed, t);
        }
    }
    print_message("%u orders, %u carried out\n", orders, done);
    assert_true(done >= 100);
    free(bytes);
    free(r);
    reference_tube_free(tube);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(table_that_is_the_line_gives_todays_model),
        cmocka_unit_test(exchange_keeps_the_other_tools_bit_for_bit),
        cmocka_unit_test(exchange_moves_no_node_in_the_next_ticks),
        cmocka_unit_test(tool_that_came_by_exchange_is_the_tool_that_stayed),
        cmocka_unit_test(nothing_of_a_tool_that_left_stays),
        cmocka_unit_test(impossible_exchanges_are_refused_by_name),
        cmocka_unit_test(wire_that_is_too_short_holds_no_catheter_over_the_wire),
        cmocka_unit_test(nothing_passes_over_a_hub),
        cmocka_unit_test(last_tool_can_be_replaced_but_not_taken_off),
        cmocka_unit_test(guide_is_swapped_over_the_wire),
        cmocka_unit_test(balloons_are_refused_while_inflated_and_once_burst),
        cmocka_unit_test(second_balloon_is_refused),
        cmocka_unit_test(free_position_between_two_tools_changes_nothing),
        cmocka_unit_test(saved_line_is_restored_bit_for_bit),
        cmocka_unit_test(lines_that_cannot_be_are_not_restored),
        cmocka_unit_test(another_line_needs_an_exchange),
        cmocka_unit_test(exchange_enters_the_hash),
        cmocka_unit_test(random_orders_never_break_the_line),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
