// Tests the controls of the suite (the window of a live session). Every control must have a key, a sentence
// and a row in docs/suite.md, and keys, buttons and pedals must act in the same way. A control that is
// pressed and released between two drawings of the window must still act. Every standard view must have a
// control.
#include <algorithm>
#include <csetjmp>
#include <cstdarg>
#include <cstddef>
#include <cstdint>
#include <fstream>
#include <map>
#include <set>
#include <string>
#include <vector>

#include <GLFW/glfw3.h>

#include "host/base/text.hpp"
#include "host/live/oximeter.hpp"
#include "host/room/presets.hpp"
#include "host/suite/pages.hpp"
#include "host/suite/ui_text.hpp"
#include "host/suite/user_input.hpp"

// The header cmocka.h comes last, because its macros (fail, ...) would change other headers.
extern "C" {
#include <cmocka.h>
}

namespace
{

using crn::ControlId, crn::RoomAction, crn::RoomCommand;
using Commands = std::vector<RoomCommand>;

void tap(crn::UserInput &input, int key, int modifiers = 0)
{
    input.key(key, GLFW_PRESS, modifiers);
    input.key(key, GLFW_RELEASE, modifiers);
}

void every_control_has_a_key_of_its_own_and_says_what_it_does(void **)
{
    std::set<std::string_view> names;
    std::set<std::pair<int, int>> keys;
    for (const crn::Control &row : crn::controls()) {
        const std::string name(row.name);
        if (!names.insert(row.name).second) fail_msg("two controls are called '%s'", name.c_str());
        if (row.key == 0 || !keys.insert({row.key, row.modifiers}).second)
            fail_msg("'%s' has no key of its own", name.c_str());
        if (row.what.size() < 20 || row.what.back() != '.') fail_msg("'%s' has no sentence", name.c_str());
        assert_ptr_equal(crn::control_of_key(row.key, row.modifiers), &row);
        assert_ptr_equal(&crn::control(row.id), &row);
    }
}

void a_gamepad_button_has_one_control(void **)
{
    std::map<int, std::string_view> buttons;
    for (const crn::Control &row : crn::controls()) {
        if (row.pad < 0) continue;
        if (!buttons.emplace(row.pad, row.name).second)
            fail_msg("gamepad button %d has two controls", row.pad);
        assert_ptr_equal(crn::control_of_pad(row.pad), &row);
        assert_false(row.pad_text.empty());
    }
    assert_true(buttons.size() >= 10);
    assert_null(crn::control_of_pad(-1));
}

void the_document_has_the_table_of_controls(void **)
{
    const std::string document = crn::read_text_file("docs/suite.md");
    const std::string table = crn::controls_document();
    if (document.find(table) != std::string::npos) return;
    const char *wanted = "/tmp/cournand_controls.md";
    std::ofstream(wanted) << table;
    fail_msg("docs/suite.md differs from the table of controls; it must contain what is in %s", wanted);
}

// On each screen a key has only one control, and each control has a key and a sentence.
void every_control_of_the_other_screens_has_keys_of_its_own(void **)
{
    std::set<std::pair<crn::ScreenId, int>> keys;
    for (const crn::ScreenControl &row : crn::screen_controls()) {
        const std::string name(row.name);
        if (row.key == 0 || row.keys() < 1) fail_msg("'%s' has no key", name.c_str());
        for (int key = row.key; key <= row.key_last; ++key) {
            if (!keys.insert({row.screen, key}).second)
                fail_msg("a key of '%s' has two controls", name.c_str());
            assert_ptr_equal(crn::screen_control_of_key(row.screen, key), &row);
        }
        if (row.what.size() < 15 || row.what.back() != '.') fail_msg("'%s' has no sentence", name.c_str());
    }
    assert_null(crn::screen_control_of_key(crn::ScreenId::prep, GLFW_KEY_9));
    assert_string_equal(crn::screen_key_text(crn::ScreenControlId::card, 8).c_str(), "9");
    assert_string_equal(crn::screen_key_text(crn::ScreenControlId::card, 9).c_str(), "");
    assert_string_equal(crn::screen_key_text(crn::ScreenControlId::recording, 1).c_str(), "F2");
    assert_string_equal(crn::screen_key_text(crn::ScreenControlId::practice, 2).c_str(), "C");
}

void the_document_has_the_table_of_the_other_screens(void **)
{
    const std::string table = crn::screen_controls_document();
    if (crn::read_text_file("docs/suite.md").find(table) != std::string::npos) return;
    fail_msg("docs/suite.md differs from the controls of the other screens; it must contain:\n%s",
             table.c_str());
}

// With 14 cards, the tenth card is the first card of the second page, which is the last page.
void every_card_is_on_a_page_with_a_key_for_it(void **)
{
    assert_int_equal(crn::cards_per_page(), 9);
    assert_int_equal(crn::turned_page(0, 1, 14), 1);
    assert_int_equal(crn::turned_page(1, 1, 14), 1);
    assert_int_equal(crn::turned_page(1, -1, 14), 0);
    assert_int_equal(crn::turned_page(0, -1, 14), 0);
    assert_int_equal(crn::turned_page(0, 1, 9), 0);
    assert_int_equal(crn::turned_page(1, 0, 9), 0); // five cards are gone
    assert_int_equal(crn::turned_page(3, 1, 0), 0);
}

// A line of text is broken at a blank, never inside "3.0"; a word that is too wide is not broken, and an
// indentation is kept.
void lines_break_at_blanks_only(void **)
{
    const auto lines = [](const char *text) {
        return crn::joined_lines(crn::lines_of(
            text, 12.0f, [](const std::string &line) { return static_cast<float>(line.size()); }));
    };
    assert_string_equal(lines("a stent of 3.0 by 18 mm").c_str(), "a stent of\n3.0 by 18 mm");
    assert_string_equal(lines("/tmp/folder/name.rec is written").c_str(), "/tmp/folder/name.rec\nis written");
    assert_string_equal(lines("  one\ntwo  three").c_str(), "  one\ntwo  three");
    assert_string_equal(lines("").c_str(), "");
}

void a_notice_in_the_window_has_no_tick(void **)
{
    assert_string_equal(crn::without_moment("NO STENT LEFT to load (at 70 ms)").c_str(),
                        "NO STENT LEFT to load");
    assert_string_equal(crn::without_moment("refused (at once)").c_str(), "refused (at once)");
    assert_string_equal(crn::without_moment(" ms)").c_str(), " ms)");
}

void keys_choose_the_tool_they_move(void **)
{
    crn::UserInput input(2);
    assert_int_equal(input.chosen_tool(), 0);
    tap(input, GLFW_KEY_2);
    assert_int_equal(input.chosen_tool(), 1);
    tap(input, GLFW_KEY_3); // there is no third tool
    assert_int_equal(input.chosen_tool(), 1);
    tap(input, GLFW_KEY_TAB);
    assert_int_equal(input.chosen_tool(), 0);
    tap(input, GLFW_KEY_TAB, GLFW_MOD_SHIFT);
    assert_int_equal(input.chosen_tool(), 1);
    tap(input, GLFW_KEY_G);
    assert_true(input.moves_all());
    tap(input, GLFW_KEY_1);
    assert_false(input.moves_all());
    crn::UserInput alone(1);
    for (int key : {GLFW_KEY_TAB, GLFW_KEY_G, GLFW_KEY_2}) tap(alone, key);
    assert_int_equal(alone.chosen_tool(), 0);
    assert_false(alone.moves_all());
}

void a_held_key_moves_only_the_chosen_tool_until_it_is_released(void **)
{
    crn::UserInput input(2);
    input.take();
    tap(input, GLFW_KEY_2);
    input.key(GLFW_KEY_UP, GLFW_PRESS, 0);
    auto hands = input.take().hands;
    assert_int_equal(hands.size(), 2);
    assert_int_equal(hands[0].push_um_per_s, 0);
    assert_int_equal(hands[1].push_um_per_s, 30000);
    assert_true(input.take().hands.empty()); // nothing has changed
    input.key(GLFW_KEY_LEFT_SHIFT, GLFW_PRESS, GLFW_MOD_SHIFT);
    assert_int_equal(input.take().hands[1].push_um_per_s, 6000); // slowly
    input.key(GLFW_KEY_UP, GLFW_RELEASE, GLFW_MOD_SHIFT);
    assert_int_equal(input.take().hands[1].push_um_per_s, 0);
    input.analog(-0.5, 1.0);
    input.key(GLFW_KEY_LEFT_SHIFT, GLFW_RELEASE, 0);
    hands = input.take().hands;
    assert_int_equal(hands[1].push_um_per_s, -15000);
    assert_int_equal(hands[1].turn_counts_per_s, 32768);
}

// A quick tap of a pedal or a key, such as one from a test, may lie between two drawings of the window. The
// tapped pedal is down in one call of take() and up in the next.
void a_pedal_that_is_tapped_between_two_screens_acts_once(void **)
{
    crn::UserInput input(1);
    input.take();
    tap(input, GLFW_KEY_SPACE);
    assert_true(input.take().commands == (Commands{{RoomAction::fluoro_pedal, {1, 0, 0}}}));
    assert_true(input.take().commands == (Commands{{RoomAction::fluoro_pedal, {0, 0, 0}}}));
    assert_true(input.take().commands.empty());
    tap(input, GLFW_KEY_UP);
    assert_int_equal(input.take().hands[0].push_um_per_s, 30000);
    assert_int_equal(input.take().hands[0].push_um_per_s, 0);
}

void a_pedal_that_two_inputs_hold_is_up_when_both_are_released(void **)
{
    crn::UserInput input(1);
    input.take();
    input.key(GLFW_KEY_C, GLFW_PRESS, 0);
    input.press(ControlId::acquire); // the button on the screen
    assert_int_equal(input.take().commands.size(), 1);
    input.key(GLFW_KEY_C, GLFW_RELEASE, 0);
    assert_true(input.take().commands.empty());
    input.release(ControlId::acquire);
    assert_true(input.take().commands == (Commands{{RoomAction::acquire_pedal, {0, 0, 0}}}));
}

// A window that loses the keyboard focus receives no release of keys.
void without_the_keyboard_nothing_stays_pressed(void **)
{
    crn::UserInput input(1);
    for (int key : {GLFW_KEY_UP, GLFW_KEY_SPACE, GLFW_KEY_E, GLFW_KEY_U}) input.key(key, GLFW_PRESS, 0);
    crn::UserWishes wishes = input.take();
    assert_int_equal(wishes.commands.size(), 2);
    assert_int_equal(*wishes.inflation_kPa_per_s, 100);
    input.release_all();
    wishes = input.take();
    assert_true(wishes.commands ==
                (Commands{{RoomAction::fluoro_pedal, {0, 0, 0}}, {RoomAction::inject, {0, 4000, 0}}}));
    assert_int_equal(*wishes.inflation_kPa_per_s, 0);
    assert_int_equal(wishes.hands[0].push_um_per_s, 0);
}

void a_new_session_gets_the_pedals_that_are_still_down(void **)
{
    crn::UserInput input(1);
    input.latch_pedal();
    assert_true(input.take().commands == (Commands{{RoomAction::fluoro_pedal, {1, 0, 0}}}));
    assert_true(input.take().commands.empty());
    tap(input, GLFW_KEY_R);
    assert_true(input.take_own() == std::vector<ControlId>{ControlId::restart});
    input.begin_session();
    assert_int_equal(input.take().commands.size(), 1);
}

void the_injection_takes_the_selected_rate(void **)
{
    crn::UserInput input(1);
    tap(input, GLFW_KEY_Y);
    assert_true(input.injection_ml_s() == 8.0);
    input.key(GLFW_KEY_E, GLFW_PRESS, 0);
    assert_true(input.take().commands == (Commands{{RoomAction::inject, {crn::inject_max_ul, 8000, 0}}}));
}

crn_wire_exchange exchange_of(crn::UserInput &input)
{
    const auto orders = input.take().orders;
    assert_int_equal(orders.size(), 1);
    assert_int_equal(orders[0].kind, CRN_WIRE_KIND_exchange);
    return orders[0].exchange;
}

// In this test the tools 2 and 4 of a table with five tools are in use, and the middle position has no tool.
void keys_load_a_tool_of_the_table_at_the_chosen_position(void **)
{
    crn::UserInput input(3);
    input.see_line({2, 0, 4}, 5);
    assert_int_equal(input.to_load(), 1);
    tap(input, GLFW_KEY_SLASH); // the tools on the line are passed over
    assert_int_equal(input.to_load(), 3);
    tap(input, GLFW_KEY_SLASH);
    assert_int_equal(input.to_load(), 5);
    tap(input, GLFW_KEY_SLASH);
    assert_int_equal(input.to_load(), 1);
    tap(input, GLFW_KEY_SLASH, GLFW_MOD_SHIFT);
    assert_int_equal(input.to_load(), 5);
    input.select_to_load(4); // it is on the line
    assert_int_equal(input.to_load(), 5);
    input.select_to_load(3);
    tap(input, GLFW_KEY_2);
    tap(input, GLFW_KEY_INSERT);
    const crn_wire_exchange load = exchange_of(input);
    assert_int_equal(load.position, 1);
    assert_int_equal(load.tool, 3);
}

void a_key_takes_the_chosen_tool_off_the_line(void **)
{
    crn::UserInput input(2);
    input.see_line({1, 2}, 2);
    assert_int_equal(input.to_load(), 0); // nothing is on the table
    tap(input, GLFW_KEY_2);
    tap(input, GLFW_KEY_DELETE);
    const crn_wire_exchange off = exchange_of(input);
    assert_int_equal(off.position, 1);
    assert_int_equal(off.tool, 0);
    input.see_line({1, 0}, 2); // it was carried out
    assert_int_equal(input.to_load(), 2);
}

void the_tool_that_was_exchanged_is_the_next_one_to_load(void **)
{
    crn::UserInput input(1);
    input.see_line({1}, 4);
    input.select_to_load(3);
    tap(input, GLFW_KEY_INSERT);
    assert_int_equal(exchange_of(input).tool, 3);
    input.see_line({3}, 4);
    assert_int_equal(input.to_load(), 1);
}

void heart_and_breath_are_orders_to_the_core(void **)
{
    crn::UserInput input(1);
    for (int key : {GLFW_KEY_4, GLFW_KEY_6, GLFW_KEY_7, GLFW_KEY_8}) tap(input, key);
    const auto orders = input.take().orders;
    assert_int_equal(orders.size(), 4);
    assert_true(input.take().orders.empty());
}

// The control of a standard view gives three commands to the room: for the detector's distance, the angles
// and the field.
void every_standard_view_has_a_control(void **)
{
    const crn::Room room;
    std::vector<Commands> reached;
    for (const crn::Control &row : crn::controls()) reached.push_back(crn::commands_of(row.id, room, {}));
    for (const crn::ViewPreset &view : crn::view_presets()) {
        const Commands wanted = {{RoomAction::distance, {view.sid_um, 750'000, 0}},
                                 {RoomAction::angles, {view.primary_mdeg, view.secondary_mdeg, 0}},
                                 {RoomAction::field, {view.field_um, 0, 0}}};
        if (std::find(reached.begin(), reached.end(), wanted) == reached.end())
            fail_msg("no control goes to the view %s", std::string(view.name).c_str());
    }
}

// Every key must become a command to the X-ray room. Pressing a key moves the motors' target position by one
// step, but not beyond the limit of the axis.
void keys_are_commands_to_the_room(void **)
{
    crn::Room room;
    room.give(0, {RoomAction::angles, {118000, 0, 0}});
    room.advance(0, nullptr);
    const crn::RoomScreen screen(room);
    const struct {
        int key, modifiers;
        RoomCommand command;
    } cases[] = {{GLFW_KEY_D, 0, {RoomAction::angles, {120000, 0, 0}}},
                 {GLFW_KEY_A, 0, {RoomAction::angles, {113000, 0, 0}}},
                 {GLFW_KEY_S, 0, {RoomAction::angles, {118000, -5000, 0}}},
                 {GLFW_KEY_0, 0, {RoomAction::angles, {0, 0, 0}}},
                 {GLFW_KEY_I, 0, {RoomAction::table, {0, 20000, 0}}},
                 {GLFW_KEY_PAGE_UP, 0, {RoomAction::table, {0, 0, -10000}}},
                 {GLFW_KEY_HOME, 0, {RoomAction::distance, {1100000, 750000, 0}}},
                 {GLFW_KEY_EQUAL, 0, {RoomAction::field, {250000, 0, 0}}},
                 {GLFW_KEY_KP_ADD, 0, {RoomAction::field, {250000, 0, 0}}},
                 {GLFW_KEY_LEFT_BRACKET, 0, {RoomAction::blades, {870, 970, 0}}},
                 {GLFW_KEY_LEFT_BRACKET, GLFW_MOD_CONTROL, {RoomAction::blades, {970, 870, 0}}},
                 {GLFW_KEY_Q, 0, {RoomAction::iris, {1, 0, 0}}},
                 {GLFW_KEY_P, 0, {RoomAction::fluoro_rate, {3000, 0, 0}}},
                 {GLFW_KEY_X, 0, {RoomAction::program, {1, 0, 0}}},
                 {GLFW_KEY_O, 0, {RoomAction::cine_rate, {3000, 0, 0}}},
                 {GLFW_KEY_V, 0, {RoomAction::review, {1, 0, 0}}},
                 {GLFW_KEY_PERIOD, 0, {RoomAction::review, {2, 0, 0}}},
                 {GLFW_KEY_B, 0, {RoomAction::store, {10000, 0, 0}}},
                 {GLFW_KEY_N, 0, {RoomAction::mask, {0, 0, 0}}},
                 {GLFW_KEY_RIGHT, GLFW_MOD_CONTROL, {RoomAction::shift, {50, 0, 0}}},
                 {GLFW_KEY_M, 0, {RoomAction::roadmap, {2, 0, 0}}},
                 {GLFW_KEY_T, 0, {RoomAction::follow, {1, 0, 0}}},
                 {GLFW_KEY_Z, 0, {RoomAction::halt, {0, 0, 0}}},
                 {GLFW_KEY_9, 0, {RoomAction::load_stent, {0, 0, 0}}},
                 {GLFW_KEY_BACKSPACE, 0, {RoomAction::acknowledge, {0, 0, 0}}}};
    crn::UserInput input(1);
    for (const auto &c : cases) {
        tap(input, c.key, c.modifiers);
        const std::vector<ControlId> actions = input.take().actions;
        assert_int_equal(actions.size(), 1);
        if (crn::commands_of(actions[0], room, screen.status()) != Commands{c.command})
            fail_msg("key %d is another command", c.key);
        assert_true(crn::refusal(c.command).empty());
    }
}

// A step beyond the first or the last frame of a run wraps round to the other end.
void frames_are_stepped_from_the_one_on_the_screen(void **)
{
    const crn::Room room;
    crn::RoomStatus shown;
    shown.run = 3;
    shown.frames = 10;
    shown.frame = 9;
    assert_true(crn::commands_of(ControlId::frame_on, room, shown) ==
                (Commands{{RoomAction::review, {2, 3, 0}}}));
    assert_true(crn::commands_of(ControlId::frame_back, room, shown) ==
                (Commands{{RoomAction::review, {2, 3, 8}}}));
    shown.source = crn::ScreenSource::loop;
    assert_true(crn::commands_of(ControlId::loop, room, shown) ==
                (Commands{{RoomAction::review, {0, 0, 0}}}));
}

} // namespace

static void saturation_falls_while_the_breath_is_held(void **)
{
    crn::Oximeter oximeter;
    oximeter.look(1000, false);
    assert_float_equal(oximeter.saturation_pct(), 98.0, 0.0);
    oximeter.look(21'000, true); // 20 s: the store of the lungs
    assert_float_equal(oximeter.saturation_pct(), 98.0, 1e-9);
    oximeter.look(71'000, true);
    assert_float_equal(oximeter.saturation_pct(), 90.0, 1e-9);
    oximeter.look(81'000, false); // 10 s of breathing make good for 50 s
    assert_float_equal(oximeter.saturation_pct(), 98.0, 1e-9);
}

int main()
{
    const CMUnitTest tests[] = {
        cmocka_unit_test(saturation_falls_while_the_breath_is_held),
        cmocka_unit_test(every_control_has_a_key_of_its_own_and_says_what_it_does),
        cmocka_unit_test(a_gamepad_button_has_one_control),
        cmocka_unit_test(the_document_has_the_table_of_controls),
        cmocka_unit_test(every_control_of_the_other_screens_has_keys_of_its_own),
        cmocka_unit_test(the_document_has_the_table_of_the_other_screens),
        cmocka_unit_test(every_card_is_on_a_page_with_a_key_for_it),
        cmocka_unit_test(lines_break_at_blanks_only),
        cmocka_unit_test(a_notice_in_the_window_has_no_tick),
        cmocka_unit_test(keys_choose_the_tool_they_move),
        cmocka_unit_test(a_held_key_moves_only_the_chosen_tool_until_it_is_released),
        cmocka_unit_test(a_pedal_that_is_tapped_between_two_screens_acts_once),
        cmocka_unit_test(a_pedal_that_two_inputs_hold_is_up_when_both_are_released),
        cmocka_unit_test(without_the_keyboard_nothing_stays_pressed),
        cmocka_unit_test(a_new_session_gets_the_pedals_that_are_still_down),
        cmocka_unit_test(the_injection_takes_the_selected_rate),
        cmocka_unit_test(keys_load_a_tool_of_the_table_at_the_chosen_position),
        cmocka_unit_test(a_key_takes_the_chosen_tool_off_the_line),
        cmocka_unit_test(the_tool_that_was_exchanged_is_the_next_one_to_load),
        cmocka_unit_test(heart_and_breath_are_orders_to_the_core),
        cmocka_unit_test(every_standard_view_has_a_control),
        cmocka_unit_test(keys_are_commands_to_the_room),
        cmocka_unit_test(frames_are_stepped_from_the_one_on_the_screen),
    };
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
