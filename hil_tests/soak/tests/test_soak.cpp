// These tests check the program soak itself with sessions in free space (without vessels), so that every
// session ends quickly. A random session depends only on its seed and number, and a device accepts every
// random session. If a session exceeds a limit, soak finds the tick at which this happens, and shortens the
// session to the part that causes it. Soak reports a differing replay, a crash and an endless session as
// verdicts. The rows of the result file are kept if soak is interrupted, if the last line is incomplete, and
// if the program has changed. The script hil_tests/soak/test_soak.sh tests the program on vessels.
#include "hil_tests/soak/campaign.hpp"
#include <algorithm>
#include <csetjmp>
#include <cstdarg>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <set>
#include <unistd.h>

extern "C" {
#include <cmocka.h>
}

namespace
{

namespace fs = std::filesystem;

fs::path folder;
soak::Catalogue catalogue; // free space and everything that ships

int make_catalogue(void **)
{
    folder = fs::temp_directory_path() / ("cournand_soak_" + std::to_string(getpid()));
    catalogue = soak::read_catalogue({""}, "shared/examples/instruments", "shared/examples/stents");
    return fs::create_directories(folder) ? 0 : 1;
}

int remove_folder(void **)
{
    fs::remove_all(folder);
    return 0;
}

soak::TrialSettings settings_with(const soak::Bars &bars = {})
{
    soak::TrialSettings settings;
    settings.bars = bars;
    settings.folder = folder.string();
    return settings;
}

std::string instrument(const char *name)
{
    return std::string("shared/examples/instruments/") + name + ".toml";
}

soak::DrawnSession written(const std::vector<std::string> &lines,
                           const std::vector<std::string> &tools = {instrument("j_wire")})
{
    return {1, 0, "", tools, {}, lines};
}

// --- drawing ---

void the_same_seed_and_number_give_the_same_session(void **)
{
    for (std::uint32_t index = 0; index < 50; index++) {
        const soak::DrawnSession a = soak::draw_session(catalogue, 7, index),
                                 b = soak::draw_session(catalogue, 7, index);
        assert_string_equal(soak::script_of(a).c_str(), soak::script_of(b).c_str());
        assert_string_equal(soak::command_of(a, "x").c_str(), soak::command_of(b, "x").c_str());
    }
}

void another_seed_or_number_gives_another_session(void **)
{
    std::set<std::string> scripts;
    for (std::uint64_t seed : {1, 2, 3})
        for (std::uint32_t index = 0; index < 100; index++)
            assert_true(scripts.insert(soak::script_of(soak::draw_session(catalogue, seed, index))).second);
}

// The random sessions of this test contain every instrument, one to three tools, balloons, stents, and hands
// up to 250 mm/s and 12 rad/s.
void three_hundred_sessions_have_every_instrument_and_every_kind_of_statement(void **)
{
    std::set<std::string> tools, verbs;
    std::size_t count[4] = {};
    bool is_fastest = false;
    for (std::uint32_t index = 0; index < 300; index++) {
        const soak::DrawnSession session = soak::draw_session(catalogue, 11, index);
        assert_in_range(session.tools.size(), 1, 3);
        count[session.tools.size()]++;
        tools.insert(session.tools.begin(), session.tools.end());
        for (const std::string &line : session.lines) {
            verbs.insert(line.substr(0, line.find(' ')));
            is_fastest = is_fastest || line.find(" 250 mm/s") != std::string::npos;
            if (line == "load stent") assert_false(session.stents.empty());
        }
    }
    assert_int_equal(tools.size(), catalogue.tools.size());
    for (std::size_t k = 1; k <= 3; k++) assert_true(count[k] >= 50);
    for (const char *verb : {"advance", "withdraw", "rotate", "inflate", "deflate", "load", "heart", "breath",
                             "premature", "asystole", "wait", "c-arm", "fluoro"})
        assert_true(verbs.count(verb) == 1);
    assert_true(is_fastest);
}

// The parser of session scripts checks every script, and the core checks whether the tools fit into each
// other.
void drawn_sessions_are_ones_that_a_device_takes(void **)
{
    soak::TrialSettings settings = settings_with({1e9, 1e9, 1e9, 1.0});
    settings.ticks_max = 20;
    settings.replays = false;
    for (std::uint32_t index = 0; index < 60; index++) {
        const soak::Verdict verdict =
            soak::run_trial(catalogue, soak::draw_session(catalogue, 3, index), settings);
        if (verdict.broken == "error") fail_msg("session %u: %s", unsigned{index}, verdict.text.c_str());
    }
}

// --- judging ---

void a_session_that_holds_every_bar_is_replayed_to_its_hash(void **)
{
    const soak::DrawnSession session =
        written({"begin inserted 40 mm", "advance 20 mm at 50 mm/s", "rotate 90 deg at 300 deg/s"});
    const soak::Verdict a = soak::run_trial(catalogue, session, settings_with({1, 1, 30, 1e-6}));
    assert_string_equal(a.broken.c_str(), "");
    assert_true(a.ticks > 500);
    assert_true(a.hash != 0);
    assert_true(fs::is_empty(folder)); // its recording has been removed
}

// Its recording is replayed nevertheless.
void a_session_that_is_long_enough_ends_at_that_tick(void **)
{
    soak::TrialSettings settings = settings_with();
    settings.ticks_max = 150;
    const soak::Verdict verdict =
        soak::run_trial(catalogue, written({"begin inserted 40 mm", "wait 10 s"}), settings);
    assert_string_equal(verdict.broken.c_str(), "");
    assert_int_equal(verdict.ticks, 150);
}

void a_recording_that_differs_in_one_input_is_told_at_its_tick(void **)
{
    soak::TrialSettings settings = settings_with();
    settings.disturb = [](crn::Recording &recording) {
        recording.ticks.at(300).input.hands[0].translation_counts += 100;
    };
    const soak::Verdict verdict =
        soak::run_trial(catalogue, written({"begin inserted 40 mm", "advance 20 mm at 50 mm/s"}), settings);
    assert_string_equal(verdict.broken.c_str(), "replay");
    assert_int_equal(verdict.tick, 301);
}

void a_recording_that_lost_its_end_is_told(void **)
{
    soak::TrialSettings settings = settings_with();
    settings.disturb = [](crn::Recording &recording) { recording.ticks.resize(recording.ticks.size() - 1); };
    const soak::Verdict verdict =
        soak::run_trial(catalogue, written({"begin inserted 40 mm", "wait 200 ms"}), settings);
    assert_string_equal(verdict.broken.c_str(), "replay");
}

// In free space only the wire's stiffness resists the hand, with a force of some millinewtons. The first push
// therefore exceeds a force limit of 1 uN, and the session must end there.
void a_bar_that_is_much_too_low_ends_the_session_at_the_first_push(void **)
{
    const soak::Bars bars{1.0, 1.0, 1e-6, 1e-6};
    const soak::Verdict verdict =
        soak::run_trial(catalogue, written({"begin inserted 40 mm", "advance 20 mm at 50 mm/s", "wait 1 s"}),
                        settings_with(bars));
    assert_string_equal(verdict.broken.c_str(), "force");
    assert_true(verdict.ticks == verdict.tick);
    assert_true(verdict.tick < 700);
    assert_true(verdict.text.find("at most") != std::string::npos);
}

void a_statement_that_no_device_takes_is_an_error_with_its_line(void **)
{
    const soak::Verdict verdict =
        soak::run_trial(catalogue, written({"advance 20 furlongs"}), settings_with());
    assert_string_equal(verdict.broken.c_str(), "error");
    assert_true(verdict.text.find("furlongs") != std::string::npos);
}

void a_crash_and_an_endless_trial_are_verdicts(void **)
{
    const soak::Verdict crash = soak::run_isolated([]() -> soak::Verdict { _exit(7); }, 30);
    assert_string_equal(crash.broken.c_str(), "crash");
    const soak::Verdict endless = soak::run_isolated(
        []() -> soak::Verdict {
            for (;;) pause();
        },
        0.3);
    assert_string_equal(endless.broken.c_str(), "time");
}

void a_verdict_keeps_its_numbers_as_a_line(void **)
{
    soak::Verdict verdict{"force", "of 31 N,\tat most 30 N", 17,   40, 0.5, 0.25, 31.5, 3,
                          350.0,   0x123456789abcdef0u,      false};
    const soak::Verdict again = soak::verdict_of(soak::line_of(verdict));
    assert_string_equal(again.broken.c_str(), "force");
    assert_string_equal(again.text.c_str(), "of 31 N, at most 30 N");
    assert_int_equal(again.tick, 17);
    assert_int_equal(again.ticks, 40);
    assert_int_equal(again.capped, 3);
    assert_true(again.force_N == 31.5 && again.penetration_mm == 0.5 && again.injected_mg == 350.0);
    assert_true(again.hash == verdict.hash);
}

// --- shrinking ---

// The judge of this test reads only the script: a session counts as failed if, after an inflation, the script
// pushes the catheter by at least 20 mm.
soak::Verdict judge_of_words(const soak::DrawnSession &session)
{
    soak::Verdict verdict;
    bool is_up = false;
    for (const std::string &line : session.lines) {
        is_up = is_up || line.starts_with("inflate");
        const std::size_t push = line.find(session.tools.size() == 2 ? "advance wire" : "advance catheter");
        if (!is_up || push == std::string::npos) continue;
        const std::size_t number = line.find_first_of("0123456789", push);
        if (std::atoi(line.c_str() + number) >= 20) verdict.broken = "force";
    }
    return verdict;
}

void a_broken_session_shrinks_to_the_statements_that_break_it(void **)
{
    soak::DrawnSession session = written(
        {"begin wire inserted 5 mm", "advance wire 300 mm at 50 mm/s", "rotate guide 90 deg at 20 deg/s",
         "heart rate 80 /min", "inflate to 8 bar at 10 bar/s", "wait 100 ms",
         "advance wire 10 mm at 5 mm/s while advance catheter 100 mm at 50 mm/s in strokes of 20 mm",
         "wait 1000 ms", "deflate at 4 bar/s"},
        {instrument("coronary_014"), instrument("balloon_3x20"), instrument("guide_jl4_6f")});
    const soak::Shrunk shrunk = soak::shrink(session, judge_of_words(session), judge_of_words);
    // The judge's condition does not depend on the wire, so shortening removes the wire, makes the balloon
    // the innermost tool, and halves the push of 100 mm to 25 mm.
    assert_string_equal(soak::script_of(shrunk.session).c_str(),
                        "inflate to 1 bar at 10 bar/s\nadvance wire 25 mm at 50 mm/s\n");
    assert_string_equal(soak::tools_of(shrunk.session).c_str(), "balloon_3x20 + guide_jl4_6f");
    assert_true(shrunk.trials <= soak::ShrinkLimits{}.trials);
}

void shrinking_stays_within_its_trials(void **)
{
    std::vector<std::string> lines(60, "wait 100 ms");
    const soak::DrawnSession session = written(lines);
    std::uint32_t calls = 0;
    soak::Verdict found;
    found.broken = "force";
    const soak::Shrunk shrunk = soak::shrink(session, found,
                                             [&](const soak::DrawnSession &) {
                                                 calls++;
                                                 return soak::Verdict{};
                                             },
                                             {10, 60});
    assert_int_equal(calls, 10);
    assert_int_equal(shrunk.session.lines.size(), 60);
}

void a_tool_that_is_left_out_takes_its_statements_along_and_the_others_move_up(void **)
{
    const soak::DrawnSession session = written(
        {"begin wire inserted 5 mm", "begin guide inserted 3 mm", "inject 5 ml at 2 ml/s through tool 3",
         "advance wire 3 mm at 5 mm/s while rotate catheter 90 deg at 20 deg/s", "advance together 4 mm"},
        {"a", "b", "c"});
    const soak::DrawnSession shorter = soak::without_tool(session, 0);
    assert_string_equal(soak::script_of(shorter).c_str(),
                        "begin catheter inserted 3 mm\ninject 5 ml at 2 ml/s through tool 2\n"
                        "rotate wire 90 deg at 20 deg/s\nadvance together 4 mm\n");
}

// --- a campaign ---

soak::CampaignSettings short_campaign(const char *name)
{
    soak::CampaignSettings settings;
    settings.seed = 5;
    settings.ticks = 0;
    settings.folder = (folder / name).string();
    settings.draw = {1, 1};
    settings.trial = settings_with({1e9, 1e9, 1e9, 1.0});
    settings.trial.ticks_max = 150;
    settings.shows_progress = false;
    fs::create_directories(settings.folder);
    return settings;
}

std::string text_of(const fs::path &path)
{
    std::ifstream in(path);
    return {std::istreambuf_iterator<char>(in), {}};
}

std::set<std::string> rows_in(const fs::path &path)
{
    std::istringstream in(text_of(path));
    std::set<std::string> rows;
    for (std::string line; std::getline(in, line);) rows.insert(line);
    return rows;
}

void a_campaign_that_was_stopped_goes_on_to_the_same_rows(void **)
{
    soak::CampaignSettings settings = short_campaign("resumed");
    const fs::path whole = fs::path(settings.folder) / "whole.tsv",
                   parts = fs::path(settings.folder) / "parts.tsv";
    settings.sessions = 6;
    settings.jobs = 2;
    {
        soak::RowsFile rows(whole.string(), "key");
        soak::run_campaign(catalogue, settings, rows);
        assert_int_equal(rows.rows().size(), 6);
    }
    settings.sessions = 2;
    {
        soak::RowsFile rows(parts.string(), "key");
        soak::run_campaign(catalogue, settings, rows);
    }
    std::ofstream(parts, std::ios::app) << "17\t-\tj_wi"; // killed while it wrote
    settings.sessions = 6;
    settings.jobs = 1;
    {
        soak::RowsFile rows(parts.string(), "key");
        assert_int_equal(rows.rows().size(), 2);
        soak::run_campaign(catalogue, settings, rows);
    }
    assert_true(rows_in(whole) == rows_in(parts));
}

void rows_of_another_program_or_scene_are_put_aside(void **)
{
    const fs::path path = folder / "aside.tsv";
    soak::Row row;
    row.tools = "j_wire";
    soak::RowsFile(path.string(), "one").add(row);
    soak::RowsFile again(path.string(), "two");
    assert_true(again.was_put_aside());
    assert_int_equal(again.rows().size(), 0);
    assert_true(text_of(path.string() + ".old").find("j_wire") != std::string::npos);
}

void the_summary_has_the_sums_and_the_worst_with_the_session_that_it_is_of(void **)
{
    soak::RowsFile rows((folder / "sum.tsv").string(), "key");
    soak::Row row;
    row.verdict.ticks = 40000;
    row.verdict.force_N = 3;
    rows.add(row);
    row.index = 4;
    row.verdict.force_N = 31;
    row.verdict.broken = "force";
    row.script = "x.session";
    rows.add(row);
    const std::string table = soak::bench_rows(soak::sum_of(rows), 9);
    for (const char *line : {"soak.sessions\t2\t1\tseed=9\n", "soak.ticks\t80000\tticks\tseed=9\n",
                             "soak.broken\t1\t1\tseed=9\n", "soak.force_N\t31\tN\tseed=9 session=4\n"})
        if (table.find(line) == std::string::npos) fail_msg("no %s in %s", line, table.c_str());
}

} // namespace

int main()
{
    const CMUnitTest tests[] = {
        cmocka_unit_test(the_same_seed_and_number_give_the_same_session),
        cmocka_unit_test(another_seed_or_number_gives_another_session),
        cmocka_unit_test(three_hundred_sessions_have_every_instrument_and_every_kind_of_statement),
        cmocka_unit_test(drawn_sessions_are_ones_that_a_device_takes),
        cmocka_unit_test(a_session_that_holds_every_bar_is_replayed_to_its_hash),
        cmocka_unit_test(a_session_that_is_long_enough_ends_at_that_tick),
        cmocka_unit_test(a_recording_that_differs_in_one_input_is_told_at_its_tick),
        cmocka_unit_test(a_recording_that_lost_its_end_is_told),
        cmocka_unit_test(a_bar_that_is_much_too_low_ends_the_session_at_the_first_push),
        cmocka_unit_test(a_statement_that_no_device_takes_is_an_error_with_its_line),
        cmocka_unit_test(a_crash_and_an_endless_trial_are_verdicts),
        cmocka_unit_test(a_verdict_keeps_its_numbers_as_a_line),
        cmocka_unit_test(a_broken_session_shrinks_to_the_statements_that_break_it),
        cmocka_unit_test(shrinking_stays_within_its_trials),
        cmocka_unit_test(a_tool_that_is_left_out_takes_its_statements_along_and_the_others_move_up),
        cmocka_unit_test(a_campaign_that_was_stopped_goes_on_to_the_same_rows),
        cmocka_unit_test(rows_of_another_program_or_scene_are_put_aside),
        cmocka_unit_test(the_summary_has_the_sums_and_the_worst_with_the_session_that_it_is_of),
    };
    return cmocka_run_group_tests(tests, make_catalogue, remove_folder);
}
