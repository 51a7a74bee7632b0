// Tests that a case file is read with all its parts, and that each mistake is refused with file and line. A
// goal of the kind "reached once" stays reached, and counts only after the earlier goals of this kind. A goal
// that must hold at the end is judged by the last check. Between the two values of a limit, the marks fall in
// proportion to the measured value.
#include "host/cases/check.hpp"
#include "host/cases/goals.hpp"
#include "host/cases/measures.hpp"
#include <algorithm>
#include <array>
#include <cmath>
#include <csetjmp>
#include <cstdarg>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>
#include <unistd.h>
#include <vector>

extern "C" {
#include <cmocka.h>
}

namespace
{

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

fs::path folder;

int make_folder(void **)
{
    folder = fs::temp_directory_path() / ("cournand_cases_" + std::to_string(::getpid()));
    fs::create_directories(folder);
    return 0;
}

int remove_folder(void **)
{
    fs::remove_all(folder);
    return 0;
}

void write(const fs::path &path, const std::string &text)
{
    std::ofstream(path) << text;
}

// Writes the template as a case with one changed piece of text, and returns the path of the case.
std::string template_case(const std::string &old = "", const std::string &changed = "")
{
    std::string text = crn::case_template("a");
    if (!old.empty()) {
        const std::size_t at = text.find(old);
        assert_true(at != std::string::npos);
        text.replace(at, old.size(), changed);
    }
    write(folder / "a.toml", text);
    for (const crn::NamedText &script : crn::template_scripts("a")) write(folder / script.name, script.text);
    return (folder / "a.toml").string();
}

int line_of(const std::string &text, const std::string &piece)
{
    const std::string before = text.substr(0, text.find(piece));
    return 1 + static_cast<int>(std::count(before.begin(), before.end(), '\n'));
}

void the_template_is_a_good_case(void **)
{
    const crn::Case lesson = crn::read_case(template_case());
    assert_string_equal(lesson.name.c_str(), "a");
    assert_int_equal(lesson.goals.size(), 2);
    assert_true(lesson.goals[0].is_once && !lesson.goals[1].is_once);
    assert_int_equal(lesson.limits.size(), 2);
    assert_int_equal(lesson.start.inserted_um.at(0), 20000);
    assert_int_equal(lesson.start.room.size(), 3);
    for (const std::string &fault : crn::case_faults(lesson.file)) fail_msg("%s", fault.c_str());
}

void a_goal_is_told_in_plain_words(void **)
{
    const crn::Case lesson = crn::read_case(template_case());
    assert_string_equal(lesson.goals[0].expectation.plain_text().c_str(),
                        "the tip of the wire is inside the descending aorta");
    assert_string_equal(lesson.goals[1].expectation.plain_text().c_str(),
                        "the tip of the wire is at least 20 mm inside the ascending aorta");
    crn::Expectation goal;
    goal.kind = crn::Expectation::Kind::stenosis;
    goal.most = 20.0;
    goal.is_below = true;
    assert_string_equal(goal.plain_text().c_str(), "the remaining stenosis is less than 20 %");
    goal.kind = crn::Expectation::Kind::turned;
    goal.least = 10.0;
    goal.is_below = false;
    assert_string_equal(goal.plain_text().c_str(),
                        "the wire has been turned by at least 10 degrees and at most 20 degrees");
}

struct Mistake {
    const char *old, *changed, *said; // `said` is part of the message
};

// For each mistake in a case file, the check must name the file and the line of the mistake.
void each_mistake_is_refused_with_its_line(void **)
{
    const std::vector<Mistake> mistakes = {
        {"aim =", "aims =", "did you mean 'aim'?"},
        {"invented = true", "invented = false", "must be true"},
        {"tools = [\"j_wire\"]", "tools = [\"j_wir\"]", "did you mean 'j_wire'?"},
        {"tools = [\"j_wire\"]", "tools = [\"rosen\"]", "not among the offered devices"},
        {"tools = [\"j_wire\"]", "tools = []", "names no tool"},
        {"tools = [\"j_wire\"]", "tools = [\"nothing\"]", "names no tool"},
        {"tools = [\"j_wire\"]", "tools = [\"j_wire\", \"j_wire\"]", "is there only once"},
        {"inserted_mm = [20]", "inserted_mm = [20, 5]", "2 lengths for 1 tools"},
        {"inserted_mm = [20]", "inserted_mm = [1550]", "is only"},
        {"kind = \"aorta\"", "kind = \"aorte\"", "did you mean 'aorta'?"},
        {"\"view ap\"", "\"advance 3 mm\"", "no statement for the X-ray room"},
        {"\"view ap\"", "\"view app\"", "'app'"},
        {"tip wire in descending aorta\"", "tip wire in descending aorte\"",
         "did you mean 'descending aorta'?"},
        {"tip wire in descending aorta\"", "tip guide in descending aorta\"", "the start has only 1"},
        {"tip wire in descending aorta\"", "tipp wire in descending aorta\"", "did you mean 'tip'?"},
        {"at least 20 mm\"", "at least 900 mm\"", "no tip can be"},
        {"at least 20 mm\"", "at least 20\"", "unit of length"},
        {"when = \"once\"", "when = \"ever\"", "'when' is 'ever'"},
        {"measure = \"time_min\"", "measure = \"time_mn\"", "did you mean 'time_min'?"},
        {"no_marks_at = 4", "no_marks_at = 2", "equals 'full_marks_at'"},
        {"expert = \"a_expert.session\"", "expert = \"b_expert.session\"", "there is no file"},
        {"# stents = [\"renal_6_0x18\"]", "stents = [\"renal_6_0x18\"]",
         "none of the offered devices has a balloon"},
        {"# lesions = [\"renal_ostium\"]", "lesions = [\"renal_ostum\"]", "did you mean 'renal_ostium'?"},
        {"sex = \"male\"", "sex = \"man\"", "'sex' is 'man'"},
    };
    for (const Mistake &mistake : mistakes) {
        const std::string path = template_case(mistake.old, mistake.changed);
        const std::vector<std::string> faults = crn::case_faults(path);
        if (faults.size() != 1) fail_msg("'%s': %zu faults", mistake.changed, faults.size());
        if (faults[0].find(mistake.said) == std::string::npos)
            fail_msg("'%s' was told as: %s", mistake.changed, faults[0].c_str());
        std::ifstream file(path);
        const std::string text((std::istreambuf_iterator<char>(file)), std::istreambuf_iterator<char>());
        const int line = line_of(text, mistake.changed);
        const bool has_line = faults[0].find(path + ":" + std::to_string(line) + ":") != std::string::npos;
        // A fault of a stent is reported at the line of the tools at the start, and a missing key at the line
        // of its table.
        const bool is_elsewhere = faults[0].find("balloon") != std::string::npos ||
                                  faults[0].find("is only") != std::string::npos ||
                                  faults[0].find("lengths for") != std::string::npos;
        if (!has_line && !is_elsewhere) fail_msg("line %d is not in: %s", line, faults[0].c_str());
    }
}

void a_mistake_in_a_script_is_told_at_the_script(void **)
{
    const std::string path = template_case();
    write(folder / "a_expert.session", "steer into ascending aorte\n");
    std::vector<std::string> faults = crn::case_faults(path);
    assert_int_equal(faults.size(), 1);
    assert_non_null(std::strstr(faults[0].c_str(), "a_expert.session:1: unknown vessel 'ascending aorte'"));
    write(folder / "a_expert.session", "inflate to 3 bar\nload stent\nadvance guide 3 mm\n");
    faults = crn::case_faults(path);
    assert_int_equal(faults.size(), 3);
}

// Writes a case with five offered tools, of which two are in the vessels at the start; one position on the
// line holds no tool.
std::string exchange_case(const std::string &expert)
{
    std::string text = crn::case_template("a");
    const std::vector<std::array<std::string, 2>> changes = {
        {"offered = [\"j_wire\", \"bentson\"]",
         "offered = [\"balloon_3x20\", \"j_wire\", \"coronary_014\", \"guide_jl4_6f\", \"pigtail_5f\"]"},
        {"# stents = [\"renal_6_0x18\"]", "stents = [\"coronary_3_0x18\"]"},
        {"tools = [\"j_wire\"]", "tools = [\"j_wire\", \"nothing\", \"guide_jl4_6f\"]"},
        {"inserted_mm = [20]", "inserted_mm = [20, 0, 5]"}};
    for (const auto &[old, changed] : changes) {
        const std::size_t at = text.find(old);
        assert_true(at != std::string::npos);
        text.replace(at, old.size(), changed);
    }
    write(folder / "a.toml", text);
    for (const crn::NamedText &script : crn::template_scripts("a")) write(folder / script.name, script.text);
    write(folder / "a_expert.session", expert);
    return (folder / "a.toml").string();
}

const std::string exchanges = "withdraw wire until inserted 0 mm\nexchange wire for coronary_014\n"
                              "load balloon_3x20 as catheter\nload stent\ninflate to 8 bar\n";

void a_case_may_have_more_tools_than_the_line(void **)
{
    const crn::Case lesson = crn::read_case(exchange_case(exchanges));
    for (const std::string &fault : crn::case_faults(lesson.file)) fail_msg("%s", fault.c_str());
    assert_int_equal(lesson.offered.size(), 5);
    assert_true(lesson.start.numbers == (crn::LineNumbers{2, 0, 4}));
    assert_true(lesson.start.tools[1].empty());
    crn::Session session = crn::case_session(lesson, lesson.expert);
    const std::vector<std::string> names = {"balloon_3x20", "j_wire", "coronary_014", "guide_jl4_6f",
                                            "pigtail_5f"};
    assert_true(crn::resolve_tools(session, names) == lesson.start.numbers);
    assert_int_equal(session.inserted_um[2], 5000);
}

// The check judges each statement of a script with the tools that are nested in the vessels at that
// statement.
void a_mistake_about_the_line_is_told_at_its_statement(void **)
{
    const std::vector<Mistake> mistakes = {
        {"exchange wire for coronary_014", "exchange wire for coronary_01", "did you mean 'coronary_014'?"},
        {"load balloon_3x20 as catheter", "load guide_jl4_6f as catheter", "is on the line already"},
        {"coronary_014\nload balloon_3x20 as catheter", "pigtail_5f\nload balloon_3x20 as catheter",
         "does not pass the lumen"},
        {"load balloon_3x20 as catheter", "wait 1 s", "loads a stent, but no tool on the line has a balloon"},
        {"load stent", "begin with j_wire guide_jl4_6f", "'begin' must be the first statement"},
        {"withdraw wire until inserted 0 mm", "begin with j_wire guide_jl4_6f", "begins with other tools"},
        {"inflate to 8 bar", "inflate to 8 bar\nremove catheter\ninflate to 2 bar", "inflates a balloon"},
    };
    for (const Mistake &mistake : mistakes) {
        std::string text = exchanges;
        text.replace(text.find(mistake.old), std::strlen(mistake.old), mistake.changed);
        const std::vector<std::string> faults = crn::case_faults(exchange_case(text));
        if (faults.empty()) fail_msg("'%s' was accepted", mistake.changed);
        if (faults[0].find(mistake.said) == std::string::npos ||
            faults[0].find("a_expert.session:") == std::string::npos)
            fail_msg("'%s' was told as: %s", mistake.changed, faults[0].c_str());
    }
}

// A position without a tool has no inserted length.
void a_length_at_a_free_position_is_refused(void **)
{
    const std::string path = exchange_case(exchanges);
    std::ifstream file(path);
    std::string text((std::istreambuf_iterator<char>(file)), std::istreambuf_iterator<char>());
    text.replace(text.find("[20, 0, 5]"), 10, "[20, 3, 5]");
    write(path, text);
    const std::vector<std::string> faults = crn::case_faults(path);
    assert_int_equal(faults.size(), 1);
    assert_non_null(std::strstr(faults[0].c_str(), "has a length for position 2, which is free"));
}

crn::VesselTree tube()
{
    crn::VesselTree tree;
    tree.branches.push_back({"a", -1, 0, {{0, 0, 0}, {0, 0.1, 0}, {0, 0.2, 0}}, {0.01, 0.01, 0.01}});
    tree.branches.push_back({"b", 0, 1, {{0, 0.1, 0}, {0.1, 0.1, 0}}, {0.005, 0.005}});
    return tree;
}

crn::Case two_steps(bool is_once)
{
    crn::Case lesson;
    lesson.file = "two.toml";
    lesson.start.tools = {"wire"};
    for (const char *vessel : {"b", "a"}) {
        crn::CaseGoal goal;
        goal.text = vessel;
        goal.expectation.vessel.text = vessel;
        goal.is_once = is_once;
        lesson.goals.push_back(goal);
    }
    return lesson;
}

void look_at(crn::GoalWatch &goals, std::size_t vessel, std::uint32_t tick)
{
    crn::TipPlace tip;
    tip.is_known = true;
    tip.place.vessel = vessel;
    tip.inside_m = 0.01;
    const double inserted_m = 0.1;
    goals.look({{&inserted_m, 1}, {&tip, 1}, nullptr, tick}, {});
}

void goals_that_are_reached_once_count_in_their_order(void **)
{
    const crn::VesselMap map(tube());
    const crn::Case lesson = two_steps(true);
    crn::GoalWatch goals(lesson, map);
    look_at(goals, 0, 64); // the second goal's vessel is too early
    assert_false(goals.results()[0].is_reached || goals.results()[1].is_reached);
    look_at(goals, 1, 128);
    look_at(goals, 0, 192);
    assert_int_equal(goals.results()[0].tick.value(), 128);
    assert_int_equal(goals.results()[1].tick.value(), 192);
    look_at(goals, 1, 256);
    assert_true(goals.are_all_reached());
}

void goals_of_the_end_are_judged_by_the_last_look(void **)
{
    const crn::VesselMap map(tube());
    const crn::Case lesson = two_steps(false);
    crn::GoalWatch goals(lesson, map);
    look_at(goals, 1, 64);
    assert_true(goals.results()[0].is_reached);
    look_at(goals, 0, 128);
    assert_true(!goals.results()[0].is_reached && goals.results()[1].is_reached);
}

void a_goal_without_its_vessel_is_refused(void **)
{
    const crn::VesselMap map(tube());
    crn::Case lesson = two_steps(false);
    lesson.goals[1].expectation.vessel.text = "c";
    lesson.goals[1].line = 7;
    try {
        crn::GoalWatch goals(lesson, map);
        fail_msg("it was accepted");
    } catch (const crn::FileError &error) {
        assert_non_null(std::strstr(error.what(), "two.toml:7: unknown vessel 'c'"));
    }
}

// Simulates an observer that expects no frame for a long time.
struct Counter final : crn::FrameSink {
    int frames = 0;
    std::uint32_t next_tick() const override { return 100000; }
    void frame(const crn::SessionFrame &) override { ++frames; }
};

// The observer that makes pictures reads the X-ray events of the patient's last update. If the observer that
// makes pictures does not get a frame, an X-ray pulse has no picture. An earlier version lost such frames, so
// its cine runs had no pictures.
void pictures_get_every_frame_that_the_goals_ask_for(void **)
{
    const crn::TipPlaces tips(tube(), {});
    const crn::Case lesson = two_steps(false);
    crn::GoalWatch goals(lesson, tips.map());
    Counter pictures;
    crn::GoalSink sink(goals, tips, nullptr, &pictures);
    crn_wire_tick_state state{};
    for (state.tick = 0; state.tick < 1000; state.tick += 50) {
        sink.tick({}, state);
        sink.frame({});
    }
    assert_int_equal(pictures.frames, 20);
}

// A value halfway between `full_at` and `none_at` must earn half of the marks, whichever of the two limits is
// larger.
void marks_fall_in_proportion_between_the_values_of_a_limit(void **)
{
    const Json report = Json::parse(R"({"ticks": 180000, "tools": [{"handle_force_max_N": 2.0}],
        "contrast": null, "balloon": {"pressure_max_bar": 10.0, "rated_burst_bar": 9.0, "burst_s": null},
        "stents": [{"is_lost": true, "stage": "x"}], "score": {"percent": null}})");
    crn::Case lesson = two_steps(true);
    lesson.limits = {{0, "time_min", 2.0, 4.0, 10.0},          {0, "hand_force_N", 3.0, 6.0, 10.0},
                     {0, "contrast_ml", 20.0, 60.0, 10.0},     {0, "balloon_pressure_bar", 14.0, 6.0, 10.0},
                     {0, "bursts_and_losses", 0.0, 1.0, 10.0}, {0, "angioplasty_percent", 90.0, 50.0, 10.0}};
    std::vector<crn::GoalResult> goals(2);
    goals[1].is_reached = true;
    const Json entry = crn::case_result(lesson, goals, report);
    const double points[] = {5.0, 10.0, 10.0, 5.0, 0.0, 0.0};
    for (std::size_t i = 0; i < 6; ++i)
        assert_true(std::abs(entry["limits"][i]["points"].get<double>() - points[i]) < 1e-9);
    assert_false(std::signbit(entry["limits"][4]["points"].get<double>())); // 0, not -0
    assert_true(entry["limits"][5]["value"].is_null());
    assert_true(std::abs(entry["score"].get<double>() - 100.0 * 40.0 / 80.0) < 1e-9);
    assert_false(entry["is_reached"].get<bool>());
}

// The key of a scene must change if the lesion's text changes, but not if any other part of the case changes.
void a_changed_lesion_is_another_scene(void **)
{
    const std::string lesion = (folder / "l.toml").string();
    write(lesion, "[[lesion]]\nbranch = \"LAD\"\n");
    crn::Recipe recipe;
    recipe.kind = "heart";
    recipe.lesions = {lesion};
    const std::string first = crn::recipe_key(recipe);
    recipe.line = 3;
    assert_string_equal(crn::recipe_key(recipe).c_str(), first.c_str());
    write(lesion, "[[lesion]]\nbranch = \"RCA\"\n");
    assert_string_not_equal(crn::recipe_key(recipe).c_str(), first.c_str());
}

// The key must change if a mesh that the scene's text names has changed, even if the text has not.
void a_changed_mesh_is_another_scene(void **)
{
    crn::Recipe recipe;
    recipe.scene = (folder / "s.toml").string();
    const std::string mesh = (folder / "aorta.ply").string();
    write(recipe.scene, "[[body]]\nname = \"aorta\"\nmesh = \"aorta.ply\"\n");
    write(mesh, "ply");
    const std::string first = crn::recipe_key(recipe);
    assert_string_equal(crn::recipe_key(recipe).c_str(), first.c_str());
    write(mesh, "ply, another one");
    assert_string_not_equal(crn::recipe_key(recipe).c_str(), first.c_str());
}

void every_shipped_case_can_be_read(void **)
{
    std::vector<std::string> paths = crn::case_paths();
    assert_true(paths.size() >= 10);
    for (const std::string &path : paths) {
        const crn::Case lesson = crn::read_case(path);
        assert_true(!lesson.teaching.empty() && !lesson.hints.empty() && !lesson.limits.empty());
        assert_string_not_equal(lesson.expert.c_str(), lesson.clumsy.c_str());
    }
}

} // namespace

int main()
{
    const CMUnitTest tests[] = {
        cmocka_unit_test(the_template_is_a_good_case),
        cmocka_unit_test(a_goal_is_told_in_plain_words),
        cmocka_unit_test(each_mistake_is_refused_with_its_line),
        cmocka_unit_test(a_mistake_in_a_script_is_told_at_the_script),
        cmocka_unit_test(a_case_may_have_more_tools_than_the_line),
        cmocka_unit_test(a_mistake_about_the_line_is_told_at_its_statement),
        cmocka_unit_test(a_length_at_a_free_position_is_refused),
        cmocka_unit_test(goals_that_are_reached_once_count_in_their_order),
        cmocka_unit_test(goals_of_the_end_are_judged_by_the_last_look),
        cmocka_unit_test(a_goal_without_its_vessel_is_refused),
        cmocka_unit_test(pictures_get_every_frame_that_the_goals_ask_for),
        cmocka_unit_test(marks_fall_in_proportion_between_the_values_of_a_limit),
        cmocka_unit_test(a_changed_lesion_is_another_scene),
        cmocka_unit_test(a_changed_mesh_is_another_scene),
        cmocka_unit_test(every_shipped_case_can_be_read),
    };
    return cmocka_run_group_tests(tests, make_folder, remove_folder);
}
