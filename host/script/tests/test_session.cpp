// Tests session scripts: a script must become exactly the motion that it describes, and the motion must be
// smooth. If a script has a mistake, the error message must give its position.
#include <array>
#include <cmath>
#include <csetjmp>
#include <cstdarg>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <string>
#include <vector>

#include "host/base/text.hpp"
#include "host/script/session.hpp"

// The header cmocka.h comes last, because its macros (fail, ...) would change other headers.
extern "C" {
#include <cmocka.h>
}

namespace
{

std::vector<crn_wire_tick_input> play(const std::string &text)
{
    const crn::Session session = crn::parse_session(text, "test");
    crn::SessionPlayer player(session, 1);
    std::vector<crn_wire_tick_input> inputs;
    while (!player.is_done() && inputs.size() < 1000000) inputs.push_back(player.next());
    return inputs;
}

void expect_error(const std::string &text, const std::string &expected)
{
    try {
        crn::parse_session(text, "a.session");
    } catch (const crn::FileError &error) {
        if (std::string(error.what()).find(expected) == std::string::npos) {
            fail_msg("message '%s' does not hold '%s'", error.what(), expected.c_str());
        }
        return;
    }
    fail_msg("'%s' was accepted", text.c_str());
}

// A move of 120 mm is 120 000 counts. The move takes 120 mm / 40 mm/s = 3 s and, in addition, one ramp of 0.2
// s.
void advance_goes_exactly_the_distance_in_the_stated_time(void **)
{
    const auto inputs = play("advance 120 mm at 40 mm/s");
    assert_int_equal(inputs.size(), 3200);
    assert_int_equal(inputs.back().hands[0].translation_counts, 120000);
}

// The speed of the hand may exceed the script's speed by at most one count per tick, because of rounding, and
// may not change its sign. In one tick the speed may change by at most the steepest slope of a smoothstep,
// 1.5 x speed / ramp, plus two counts because of rounding.
void motion_is_smooth_and_never_faster_than_stated(void **)
{
    const struct {
        const char *text;
        double speed_counts_per_tick, ramp_ticks;
    } cases[] = {{"advance 120 mm at 40 mm/s", 40, 200},
                 {"advance 2 mm at 100 mm/s", 100, 20},
                 {"advance 1 m at 0.5 m/s", 500, 200}};
    for (const auto &c : cases) {
        double last = 0, last_step = 0;
        for (const auto &input : play(c.text)) {
            const double step = input.hands[0].translation_counts - last;
            assert_true(step >= 0 && step <= c.speed_counts_per_tick + 1);
            assert_true(std::fabs(step - last_step) <= 1.5 * c.speed_counts_per_tick / c.ramp_ticks + 2);
            last_step = step;
            last = input.hands[0].translation_counts;
        }
    }
}

void withdraw_and_negative_turns_go_the_other_way(void **)
{
    const auto inputs = play("withdraw 1 cm at 10 mm/s while rotate -90 deg at 90 deg/s");
    assert_int_equal(inputs.back().hands[0].translation_counts, -10000);
    assert_int_equal(inputs.back().hands[0].rotation_counts, -16384);
}

// The tested move consists of three strokes with two pauses of 150 ms.
void strokes_add_up_to_the_whole(void **)
{
    const auto whole = play("advance 100 mm at 50 mm/s"),
               strokes = play("advance 100 mm at 50 mm/s in strokes of 40 mm");
    assert_int_equal(strokes.back().hands[0].translation_counts, 100000);
    assert_int_equal(strokes.size(), whole.size() + 2 * 200 + 2 * 150);
}

void moves_joined_by_while_run_together(void **)
{
    const auto both = play("advance 40 mm at 40 mm/s while rotate 90 deg at 45 deg/s");
    assert_int_equal(both.size(), 2200);
    assert_int_equal(both[1300].hands[0].translation_counts, 40000);
}

// The tool meets the `until` condition of this script at 100 mm. After the condition is met, the hand may
// still move while it slows down during one ramp: 30 mm/s x 0.1 s = 3 mm.
void until_stops_within_one_ramp(void **)
{
    const crn::Session session = crn::parse_session("advance until inserted 100 mm at 30 mm/s", "test");
    crn::SessionPlayer player(session, 1);
    double inserted_m = 0.02;
    std::uint32_t tick = 0;
    while (!player.is_done() && tick < 100000) {
        inserted_m = 0.02 + player.next().hands[0].translation_counts * 1e-6;
        if (++tick % crn::SessionPlayer::observe_every_ticks == 0) player.observe({&inserted_m, 1});
    }
    assert_true(inserted_m >= 0.1 && inserted_m < 0.1 + 0.003 + 16 * 30e-6);
    assert_int_equal(player.given_up_lines().size(), 0);
}

void until_that_is_never_reached_is_given_up_and_reported(void **)
{
    const crn::Session session = crn::parse_session("\nadvance until inserted 100 mm", "test");
    crn::SessionPlayer player(session, 1);
    std::uint32_t tick = 0;
    while (!player.is_done() && tick < 100000) {
        player.next();
        if (++tick % crn::SessionPlayer::observe_every_ticks == 0) player.observe(std::array{0.02});
    }
    assert_true(tick < 61000);
    assert_int_equal(player.given_up_lines().size(), 1);
    assert_int_equal(player.given_up_lines()[0], 2);
}

void views_change_between_moves(void **)
{
    const crn::Session session = crn::parse_session(
        "fluoro on\nc-arm LAO 30 CAU 10\nwait 1 s\nc-arm RAO 20\ntable y 25 cm\nfield 20 cm\nwait 1 s",
        "test");
    crn::SessionPlayer player(session, 1);
    using crn::RoomAction, crn::RoomCommand;
    const std::vector<RoomCommand> first = player.take_commands();
    assert_int_equal(player.next().buttons, 1);
    assert_true(first == (std::vector<RoomCommand>{{RoomAction::fluoro_pedal, {1, 0, 0}},
                                                   {RoomAction::angles, {30000, -10000, 0}}}));
    for (int i = 1; i < 1000; i++) {
        assert_true(player.take_commands().empty());
        player.next();
    }
    assert_true(player.take_commands() == (std::vector<RoomCommand>{{RoomAction::angles, {-20000, -10000, 0}},
                                                                    {RoomAction::table, {0, 250000, 0}},
                                                                    {RoomAction::field, {200000, 0, 0}}}));
}

// Each line of the script must give exactly the commands to the X-ray room that the test lists.
void the_room_is_asked_in_words(void **)
{
    using crn::RoomAction, crn::RoomCommand;
    const struct {
        const char *text;
        std::vector<RoomCommand> commands;
    } cases[] = {
        {"fluoro on rate 7.5 p/s",
         {{RoomAction::fluoro_rate, {750, 0, 0}}, {RoomAction::fluoro_pedal, {1, 0, 0}}}},
        {"dsa on rate 3/s",
         {{RoomAction::program, {1, 0, 0}},
          {RoomAction::dsa_rate, {300, 0, 0}},
          {RoomAction::acquire_pedal, {1, 0, 0}}}},
        {"cine off", {{RoomAction::acquire_pedal, {0, 0, 0}}}},
        {"view spider",
         {{RoomAction::distance, {1100000, 750000, 0}},
          {RoomAction::angles, {45000, -30000, 0}},
          {RoomAction::field, {200000, 0, 0}}}},
        {"c-arm SID 120 cm RAO 20",
         {{RoomAction::distance, {1200000, 750000, 0}}, {RoomAction::angles, {-20000, 0, 0}}}},
        // The values in this test are the smallest and largest that docs/session.md allows.
        {"field 45 cm", {{RoomAction::field, {450000, 0, 0}}}},
        {"field 100 mm", {{RoomAction::field, {100000, 0, 0}}}},
        {"c-arm SID 130 cm SOD 60 cm", {{RoomAction::distance, {1300000, 600000, 0}}}},
        {"collimate width 60% height 80 % round",
         {{RoomAction::iris, {1, 0, 0}}, {RoomAction::blades, {600, 800, 0}}}},
        {"mask frames 2 to 4", {{RoomAction::mask, {1, 3, 0}}}},
        {"shift mask left 0.5 px up 2 px", {{RoomAction::shift, {-50, 200, 0}}}},
        {"roadmap from run", {{RoomAction::roadmap, {1, 0, 0}}}},
        {"review", {{RoomAction::review, {1, 0, 0}}}},
        {"review run 2 frame 12", {{RoomAction::review, {2, 2, 11}}}},
        {"review off", {{RoomAction::review, {0, 0, 0}}}},
        {"store fluoro 5 s", {{RoomAction::store, {5000, 0, 0}}}},
        {"acknowledge dose", {{RoomAction::acknowledge, {0, 0, 0}}}},
        {"stop", {{RoomAction::halt, {0, 0, 0}}}},
    };
    for (const auto &c : cases) {
        const crn::Session session = crn::parse_session(c.text, "test");
        crn::SessionPlayer player(session, 1);
        if (player.take_commands() != c.commands) fail_msg("'%s' was understood otherwise", c.text);
    }
    expect_error("dsa rate 4 f/s", "a.session:1:10: no such rate; there are 0.5, 1, 2, 3, 6, 7.5 per second");
    expect_error("view spidr", "did you mean 'spider'?");
    expect_error("mask frame 0", "a frame is 1, 2, 3 ...");
    expect_error("review frames", "unknown review 'frames', did you mean 'frame'?");
    expect_error("collimate width 3 %", "opening is out of range");
    expect_error("store fluoro 1 min", "time is out of range");
}

// Each command to heart or breath must be in the input of exactly one tick. If a script gives two commands to
// heart or breath at the same time, the second command must come a tick later than the first.
void heart_and_breath_are_asked_at_their_ticks(void **)
{
    const auto inputs =
        play("heart rate 90 /min\nheart variability 2.5 %\nwait 0.1 s\npremature beat at 45 %\nwait 10 ms\n"
             "premature beat\nwait 10 ms\nasystole on\nwait 10 ms\nbreath rate 12/min\nbreath hold on\nwait "
             "10 ms\n");
    const std::vector<std::array<int, 3>> wanted = {
        {0, CRN_WIRE_RHYTHM_HEART_RATE, 90},   {1, CRN_WIRE_RHYTHM_VARIABILITY, 25},
        {100, CRN_WIRE_RHYTHM_PREMATURE, 450}, {110, CRN_WIRE_RHYTHM_PREMATURE, 600},
        {120, CRN_WIRE_RHYTHM_ASYSTOLE, 1},    {130, CRN_WIRE_RHYTHM_BREATH_RATE, 12},
        {131, CRN_WIRE_RHYTHM_BREATH_HOLD, 1}};
    std::vector<std::array<int, 3>> found;
    for (std::size_t i = 0; i < inputs.size(); i++) {
        for (const crn_wire_order &order : crn::orders_of(inputs[i]))
            found.push_back({static_cast<int>(i), order.rhythm.action, order.rhythm.value});
    }
    assert_true(found == wanted);
    expect_error("heart rate 170 /min\n", "a.session:1:12: heart rate must be 40 to 160 /min");
    expect_error("premature beat at 95 %\n", "coupling must be 40 to 90 % of the interval");
    expect_error("breath hold maybe\n", "unknown switch 'maybe'");
    expect_error("hart rate 90 /min\n", "did you mean 'heart'");
}

// At 2 bar/s, the pressure reaches 8 bar in four seconds; the statement `deflate` without a rate releases 4
// bar per second. While the pressure changes, the hands must be at rest.
void the_inflator_goes_to_its_pressure_at_its_rate(void **)
{
    const auto inputs = play("inflate to 8 bar at 2 bar/s\nwait 0.5 s\ndeflate\nadvance 10 mm\n");
    assert_int_equal(inputs[999].inflator_raw, 200);
    assert_int_equal(inputs[3999].inflator_raw, 800);
    assert_int_equal(inputs[4499].inflator_raw, 800);
    assert_int_equal(inputs[5499].inflator_raw, 400);
    assert_int_equal(inputs[6499].inflator_raw, 0);
    assert_int_equal(inputs[6499].hands[0].translation_counts, 0);
    assert_int_equal(inputs.back().inflator_raw, 0);
    assert_int_equal(inputs.back().hands[0].translation_counts, 10000);
    for (std::size_t i = 1; i < inputs.size(); i++)
        assert_true(std::abs(inputs[i].inflator_raw - inputs[i - 1].inflator_raw) <= 1);
    expect_error("inflate 8 bar\n", "expected 'to'");
    expect_error("inflate to 50 bar\n", "pressure is out of range");
    expect_error("inflate to 8 bear\n", "did you mean 'bar'");
    expect_error("deflate at 2 bar\n", "unknown unit of rate 'bar'");
}

void mistakes_are_reported_with_place_and_suggestion(void **)
{
    expect_error("wait 1 s\nadvanse 10 mm",
                 "a.session:2:1: unknown statement 'advanse', did you mean 'advance'?");
    expect_error("advance 10 mn", "a.session:1:12: unknown unit of distance 'mn', did you mean 'mm'?");
    expect_error("advance ten mm", "a.session:1:9: expected distance (a number), found 'ten'");
    expect_error("advance 10", "expected unit of distance, the line ends");
    expect_error("advance 10 mm 5", "'5' does not belong here");
    expect_error("advance 9 m", "distance is out of range");
    expect_error("advance nan mm", "expected distance");
    expect_error("rotate 1e999 deg", "unknown unit of angle 'e999'");
    expect_error("wait -1 s", "time is out of range");
    expect_error("fluoro maybe", "unknown switch 'maybe'; known: on, off");
    expect_error("c-arm LOA 30", "did you mean 'LAO'?");
    expect_error("c-arm LAO 200", "outside +-120 deg");
    expect_error("advance 1 mm while withdraw 1 mm", "one hand cannot");
    expect_error("wait 1 s\nbegin inserted 5 mm", "must be the first statement");
    expect_error("advance catheter 1 mm while withdraw catheter 1 mm", "one hand cannot");
    expect_error("advance together 1 mm while advance wire 1 mm", "one hand cannot");
    expect_error("advance cateter 1 mm", "1:9: unknown tool 'cateter', did you mean 'catheter'?");
    expect_error("select cateter", "unknown tool 'cateter', did you mean 'catheter'?");
    expect_error("select 4", "unknown tool '4'");
    expect_error("advance tool 4 1 mm", "a tool is 1 to 3, from the innermost");
    expect_error("advance tool 1.5 1 mm", "a tool is 1 to 3");
    expect_error("begin balloon inserted 1 mm", "expected 'inserted', found 'balloon'");
    expect_error("select", "expected tool, the line ends");
    expect_error("# nothing\n\n", "holds no statement");
}

void comments_commas_and_joined_units_are_understood(void **)
{
    const auto inputs = play("advance 10mm at 10mm/s, while rotate 90° # push and turn\r\n");
    assert_int_equal(inputs.back().hands[0].translation_counts, 10000);
    assert_int_equal(inputs.back().hands[0].rotation_counts, 16384);
}

// Every hand must have encoder counts of its own, and a hand that no statement names must be at rest.
std::vector<crn_wire_tick_input> play(const std::string &text, std::size_t tool_count)
{
    const crn::Session session = crn::parse_session(text, "test");
    crn::SessionPlayer player(session, tool_count);
    std::vector<crn_wire_tick_input> inputs;
    while (!player.is_done() && inputs.size() < 1000000) inputs.push_back(player.next());
    return inputs;
}

void a_move_names_its_tool_or_moves_the_selected_one(void **)
{
    const auto inputs =
        play("advance catheter 10 mm\nadvance tool 3 5 mm\nrotate guide 90 deg\nadvance 1 mm\n"
             "select 2\nadvance 2 mm\ntool guide\nwithdraw 1 mm\nselect wire\nrotate -90 deg",
             3);
    const crn_wire_tick_input &end = inputs.back();
    assert_int_equal(end.hands_count, 3);
    assert_int_equal(end.hands[0].translation_counts, 1000);
    assert_int_equal(end.hands[0].rotation_counts, -16384);
    assert_int_equal(end.hands[1].translation_counts, 12000);
    assert_int_equal(end.hands[1].rotation_counts, 0);
    assert_int_equal(end.hands[2].translation_counts, 4000);
    assert_int_equal(end.hands[2].rotation_counts, 16384);
}

// The guidewire moves for 3 s plus the time of one ramp (the smooth start and stop), and the catheter moves
// for 1 s plus the time of one ramp. After 1.2 s the catheter is therefore at rest, while the guidewire still
// moves.
void two_tools_move_at_once(void **)
{
    const auto inputs = play("advance wire 60 mm at 20 mm/s while withdraw catheter 10 mm at 10 mm/s", 2);
    assert_int_equal(inputs.size(), 3200);
    assert_in_range(inputs[1250].hands[0].translation_counts, 20000, 25000);
    assert_int_equal(inputs[1250].hands[1].translation_counts, -10000);
    assert_int_equal(inputs.back().hands[0].translation_counts, 60000);
}

void together_moves_every_tool_of_the_line(void **)
{
    for (std::size_t count = 1; count <= 3; count++) {
        const auto inputs = play("advance together 20 mm while rotate together 1 turn", count);
        assert_int_equal(inputs.back().hands_count, count);
        for (std::size_t k = 0; k < count; k++) {
            assert_int_equal(inputs.back().hands[k].translation_counts, 20000);
            assert_int_equal(inputs.back().hands[k].rotation_counts, 65536);
        }
    }
}

// If an `until` condition names a tool, the inserted length of that tool decides whether the condition is
// met.
void until_looks_at_its_own_tool(void **)
{
    const crn::Session session = crn::parse_session("withdraw wire until inserted 100 mm at 30 mm/s", "test");
    crn::SessionPlayer player(session, 2);
    double inserted_m[2] = {0.2, 0.02};
    for (std::uint32_t tick = 1; !player.is_done() && tick < 100000; tick++) {
        const crn_wire_tick_input input = player.next();
        inserted_m[0] = 0.2 + input.hands[0].translation_counts * 1e-6;
        assert_int_equal(input.hands[1].translation_counts, 0);
        if (tick % crn::SessionPlayer::observe_every_ticks == 0) player.observe(inserted_m);
    }
    assert_true(inserted_m[0] <= 0.1 && inserted_m[0] > 0.1 - 0.003 - 16 * 30e-6);
}

void every_tool_may_begin_at_its_own_length(void **)
{
    const crn::Session all = crn::parse_session("begin inserted 40 mm\nwait 1 s", "test");
    const crn::Session each = crn::parse_session(
        "begin inserted 40 mm\nbegin wire inserted 120 mm\nbegin tool 3 inserted 0 mm\nwait 1 s", "test");
    for (std::uint32_t um : all.inserted_um) assert_int_equal(um, 40000);
    assert_int_equal(all.tools_named, 1);
    assert_int_equal(each.inserted_um[0], 120000);
    assert_int_equal(each.inserted_um[1], 40000);
    assert_int_equal(each.inserted_um[2], 0);
    assert_int_equal(each.tools_named, 3);
}

// A tool without a `begin` statement begins at the length that the scene states.
void a_length_that_no_statement_sets_is_left_to_the_scene(void **)
{
    const crn::Session session = crn::parse_session("begin wire inserted 120 mm\nwait 1 s", "test");
    assert_int_equal(session.inserted_um[0], 120000);
    assert_int_equal(session.inserted_um[1], crn::inserted_unstated);
}

void a_script_may_name_its_scene_tools_and_stents(void **)
{
    const crn::Session session = crn::parse_session(
        "# a comment\nneeds scene aorta\nneeds tools 014_wire, my/b_3x20.toml:soft\nneeds stent s\nwait 1 s",
        "test");
    assert_string_equal(session.needs.scene.c_str(), "aorta");
    assert_int_equal(session.needs.tools.size(), 2);
    assert_string_equal(session.needs.tools[0].c_str(), "014_wire");
    assert_string_equal(session.needs.tools[1].c_str(), "my/b_3x20.toml:soft");
    assert_string_equal(session.needs.stents.at(0).c_str(), "s");
    assert_int_equal(session.statements.size(), 1);
    expect_error("wait 1 s\nneeds scene aorta",
                 "a.session:2:1: 'needs' must come before all other statements");
    expect_error("begin inserted 5 mm\nneeds scene aorta", "a.session:2:1: 'needs' must come before");
    expect_error("needs scene a\nneeds scene b\nwait 1 s",
                 "a.session:2:13: these files are stated in a line above");
    expect_error("needs scene a b\nwait 1 s", "a session has one scene");
    expect_error("needs tool\nwait 1 s", "a.session:1:11: expected a name of a file, the line ends");
    expect_error("needs tols a\nwait 1 s", "unknown kind of file 'tols', did you mean 'tools'?");
    expect_error("needs tools a b c d e f g h i\nwait 1 s", "a session has at most 8 tools");
}

// If a script needs more tools than the session has, the message must give the line and the remedy.
void a_tool_that_is_not_there_is_named_with_its_line(void **)
{
    const crn::Session session =
        crn::parse_session("advance 1 mm\nadvance catheter 1 mm\nadvance wire 1 mm", "a.session");
    crn::SessionPlayer with_two(session, 2);
    try {
        crn::SessionPlayer with_one(session, 1);
        fail_msg("a missing tool was accepted");
    } catch (const crn::FileError &error) {
        assert_non_null(
            std::strstr(error.what(), "a.session:2:1: moves tool 2, but there is only one; name the tools"));
    }
}

// When the user moves a hand by keyboard, the hand's speed changes in steps, and the encoder counters must
// follow the speed.
void a_live_hand_comes_to_rest(void **)
{
    crn::LiveHand hand;
    hand.set_speed(60000, 0);
    for (int i = 0; i < 1000; i++) hand.advance_tick();
    assert_in_range(hand.translation_counts(), 55000, 60000);
    hand.set_speed(0, 0);
    for (int i = 0; i < 200; i++) hand.advance_tick();
    const std::int32_t rest = hand.translation_counts();
    for (int i = 0; i < 100; i++) hand.advance_tick();
    assert_int_equal(hand.translation_counts(), rest);
}

crn::LineNumbers resolved(crn::Session &session)
{
    static const std::vector<std::string> names = {"j_wire", "balloon", "guide", "floppy", "floppy"};
    return crn::resolve_tools(session, names);
}

crn_wire_exchange exchange_in(const crn::Session &session, std::size_t statement)
{
    const auto &order = session.statements[statement].order;
    assert_true(order.has_value() && order->kind == CRN_WIRE_KIND_exchange);
    return order->exchange;
}

void a_script_states_its_line_and_exchanges_tools(void **)
{
    crn::Session session =
        crn::parse_session("begin with j_wire nothing guide\nbegin inserted 20 mm\nload balloon as catheter\n"
                           "exchange wire for 4\nremove tool 2\nload 5 as tool 2",
                           "a.session");
    assert_true(resolved(session) == (crn::LineNumbers{1, 0, 3}));
    assert_int_equal(session.tools_named, 2);
    const crn_wire_exchange load = exchange_in(session, 0), swap = exchange_in(session, 1),
                            removal = exchange_in(session, 2), last = exchange_in(session, 3);
    assert_true(load.position == 1 && load.tool == 2);
    assert_true(swap.position == 0 && swap.tool == 4);
    assert_true(removal.position == 1 && removal.tool == 0);
    assert_true(last.position == 1 && last.tool == 5);
}

void an_exchange_is_given_in_one_tick_and_waits_for_its_answer(void **)
{
    crn::Session session = crn::parse_session("remove wire\nwait 10 ms", "a.session");
    crn::resolve_tools(session, std::vector<std::string>{"a"});
    crn::SessionPlayer player(session, 1);
    for (int tick = 0; tick < 40; tick++)
        assert_int_equal(player.next().orders.items_count, tick == 0 ? 1 : 0);
    player.answer_exchange(CRN_WIRE_EXCHANGE_DONE);
    assert_true(player.failures().empty() && !player.is_done());
    player.answer_exchange(CRN_WIRE_EXCHANGE_INSIDE);
    assert_true(player.is_done());
    assert_string_equal(
        player.failures()[0].c_str(),
        "a.session:1: exchange: the device at this position is still in the patient; withdraw it into "
        "the introducer sheath first");
}

void expect_unresolved(const std::string &text, const std::string &expected)
{
    crn::Session session = crn::parse_session(text, "a.session");
    try {
        resolved(session);
    } catch (const crn::FileError &error) {
        if (std::string(error.what()).find(expected) == std::string::npos)
            fail_msg("message '%s' does not hold '%s'", error.what(), expected.c_str());
        return;
    }
    fail_msg("'%s' was resolved", text.c_str());
}

void mistakes_in_exchanges_are_named(void **)
{
    expect_error("load balloon\n", "1:13: expected 'as', the line ends");
    expect_error("load stint\n", "1:6: unknown word 'stint', did you mean 'stent'?");
    expect_error("load balloon as together\n", "this is for one position");
    expect_error("exchange wire balloon\n", "expected 'for', found 'balloon'");
    expect_error("exchange wire for\n", "expected a tool of the session");
    expect_error("remove\n", "expected tool, the line ends");
    expect_error("begin with\nwait 1 s", "expected the tools on the line");
    expect_error("begin with a b c d\nwait 1 s", "a line has at most 3 positions");
    expect_error("begin with a\nbegin with b\nwait 1 s", "are stated in a line above");
    expect_error("wait 1 s\nbegin with a", "'begin' must be the first statement");
    expect_unresolved("begin with j_wire\nload baloon as catheter", "2:1: the session has no tool 'baloon'");
    expect_unresolved("begin with j_wier\nwait 1 s", "1:1: the session has no tool 'j_wier'");
    expect_unresolved("begin with j_wire\nload floppy as wire", "two tools 'floppy': write 4 or 5");
    expect_unresolved("wait 1 s", "has 5 tools and does not say which are on the line");
}

} // namespace

int main()
{
    const CMUnitTest tests[] = {
        cmocka_unit_test(advance_goes_exactly_the_distance_in_the_stated_time),
        cmocka_unit_test(motion_is_smooth_and_never_faster_than_stated),
        cmocka_unit_test(withdraw_and_negative_turns_go_the_other_way),
        cmocka_unit_test(strokes_add_up_to_the_whole),
        cmocka_unit_test(moves_joined_by_while_run_together),
        cmocka_unit_test(until_stops_within_one_ramp),
        cmocka_unit_test(until_that_is_never_reached_is_given_up_and_reported),
        cmocka_unit_test(views_change_between_moves),
        cmocka_unit_test(the_room_is_asked_in_words),
        cmocka_unit_test(heart_and_breath_are_asked_at_their_ticks),
        cmocka_unit_test(the_inflator_goes_to_its_pressure_at_its_rate),
        cmocka_unit_test(mistakes_are_reported_with_place_and_suggestion),
        cmocka_unit_test(comments_commas_and_joined_units_are_understood),
        cmocka_unit_test(a_move_names_its_tool_or_moves_the_selected_one),
        cmocka_unit_test(two_tools_move_at_once),
        cmocka_unit_test(together_moves_every_tool_of_the_line),
        cmocka_unit_test(until_looks_at_its_own_tool),
        cmocka_unit_test(every_tool_may_begin_at_its_own_length),
        cmocka_unit_test(a_length_that_no_statement_sets_is_left_to_the_scene),
        cmocka_unit_test(a_script_may_name_its_scene_tools_and_stents),
        cmocka_unit_test(a_tool_that_is_not_there_is_named_with_its_line),
        cmocka_unit_test(a_live_hand_comes_to_rest),
        cmocka_unit_test(a_script_states_its_line_and_exchanges_tools),
        cmocka_unit_test(an_exchange_is_given_in_one_tick_and_waits_for_its_answer),
        cmocka_unit_test(mistakes_in_exchanges_are_named),
    };
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
