// Tests the reader of assessment plans: conditions in words, the shipped plans, and a plan inside a case
// file. For a mistake, the reader must report the place and a suggestion.
#include "host/assess/plan.hpp"
#include <csetjmp>
#include <cstdarg>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <string>
#include <unistd.h>
extern "C" {
#include <cmocka.h>
}

namespace
{

namespace fs = std::filesystem;

std::string message_of(const std::string &condition)
{
    try {
        crn::Condition::parse(condition, "p.toml", 7, 1);
    } catch (const crn::FileError &error) {
        return error.what();
    }
    return "";
}

void every_condition_of_the_documentation_is_read(void **)
{
    for (const char *text : {
             "x-ray on",
             "acquiring",
             "c-arm moves",
             "injecting",
             "injected at least 5 ml",
             "time at least 90 s",
             "runs at least 2",
             "filled runs at least 1",
             "empty runs at most 0",
             "empty run ends",
             "wire advances",
             "wire withdraws faster than 20 mm/s",
             "guide turns faster than 90 deg/s",
             "catheter moves",
             "wire inserted at least 60 mm",
             "wire force at least 2 N",
             "tip wire moves",
             "tip wire in \"left main\" at least 4 mm",
             "tip guide in LM below 8 mm",
             "tip wire in picture",
             "tip wire off the way",
             "tip catheter ahead of wire at least 5 mm",
             "tip wire fixed at least 15 mm",
             "damped guide",
             "pressure damped",
             "unaspirated injection begins",
             "balloon above 2 bar",
             "balloon at least 200 kPa",
             "balloon above rated burst",
             "balloon burst",
             "balloon beyond stent at least 3 mm",
             "stent loaded",
             "stent deployed",
             "stent lost",
             "lesion open at least 50 %",
             "wall force at least 1 N",
             "line without wire",
             "not x-ray on",
             "( injecting or acquiring ) and not ( x-ray on )",
             "tool 2 moves",
             "(injecting or acquiring) and x-ray on",
         })
        assert_string_equal((std::string(text) + ": " + message_of(text)).c_str(),
                            (std::string(text) + ": ").c_str());
}

void a_mistake_is_reported_with_its_place_and_a_suggestion(void **)
{
    const struct {
        const char *text, *message;
    } mistakes[] = {
        {"x-ry on", "p.toml:7:1: unknown condition 'x-ry', did you mean 'x-ray'?"},
        {"tip wire inn LAD", "p.toml:7:10: unknown what a tip does 'inn', did you mean 'in'?"},
        {"wire advances faster than 20", "p.toml:7:29: expected unit of speed, the line ends"},
        {"injecting an x-ray on", "p.toml:7:11: expected 'and', 'or' or the end, found 'an'"},
        {"", "p.toml:7:1: the condition is empty: give one, like 'x-ray on'"},
        {"( injecting", "p.toml:7:12: expected ')', the line ends"},
        {"tip wire in", "p.toml:7:12: expected 'picture' or the name of a vessel, the line ends"},
        {"balloon above 99 bar", "p.toml:7:15: pressure is out of range"},
    };
    for (const auto &mistake : mistakes)
        assert_string_equal(message_of(mistake.text).c_str(), mistake.message);
}

void brackets_without_end_do_not_overflow_the_stack(void **)
{
    std::string text;
    for (int i = 0; i < 100000; ++i) text += "( ";
    assert_non_null(std::strstr(message_of(text).c_str(), "more than 32 nested brackets"));
}

fs::path folder;

int make_folder(void **)
{
    folder = fs::temp_directory_path() / ("cournand_plan_" + std::to_string(getpid()));
    return fs::create_directories(folder) ? 0 : 1;
}

int remove_folder(void **)
{
    fs::remove_all(folder);
    return 0;
}

std::string write(const std::string &text)
{
    std::ofstream(folder / "p.toml") << text;
    return (folder / "p.toml").string();
}

const char *const small =
    "format = 1\nname = \"small\"\n"
    "[[error]]\nname = \"a\"\nwhen = \"injecting\"\nseverity = \"serious\"\nsource = \"own\"\n";

std::string plan_message(const std::string &text)
{
    try {
        crn::read_plan(write(text));
    } catch (const crn::FileError &error) {
        const std::string what = error.what();
        return what.substr(what.find("p.toml"));
    }
    return "";
}

void a_plan_with_a_mistake_is_refused_with_its_line(void **)
{
    const std::string plan = small;
    assert_string_equal(plan_message(plan).c_str(), "");
    assert_string_equal(plan_message(plan + "whn = \"x\"\n").c_str(),
                        "p.toml:8:7: error 'a': unknown key 'whn', did you mean 'when'?");
    assert_string_equal(plan_message(plan + "[[error]]\nname = \"b\"\nwhen = \"injectin\"\n").c_str(),
                        "p.toml:10:9: unknown condition 'injectin', did you mean 'injecting'?");
    assert_non_null(std::strstr(plan_message(plan + plan.substr(plan.find("[[error"))).c_str(),
                                "two entries are named 'a': rename one"));
    assert_non_null(std::strstr(
        plan_message(plan + "[[metric]]\nname = \"kap_Gy_cm\"\nall = 1\nnone = 2\nsource = \"own\"\n")
            .c_str(),
        "did you mean 'kap_Gy_cm2'"));
    assert_non_null(
        std::strstr(plan_message("format = 1\nname = \"none\"\n").c_str(), "neither phases nor errors"));
    // A handling error without a source is refused, because every limit in a plan must name its source.
    assert_non_null(
        std::strstr(plan_message("format = 1\nname = \"n\"\n[[error]]\nname = \"a\"\nwhen = \"injecting\"\n"
                                 "severity = \"serious\"\n")
                        .c_str(),
                    "'source' is missing"));
}

void every_shipped_plan_is_read_and_every_limit_has_a_source(void **)
{
    int count = 0;
    for (const fs::directory_entry &file : fs::directory_iterator("shared/examples/assessments")) {
        const crn::AssessPlan plan = crn::read_plan(file.path().string());
        assert_string_equal(plan.name.c_str(), file.path().stem().c_str());
        assert_true(plan.errors.size() >= 8);
        for (const crn::PlanError &error : plan.errors) {
            assert_true(error.source.size() >= 14 && error.source[0] != '@');
            assert_true(!error.advice.empty());
        }
        ++count;
    }
    assert_true(count >= 2);
}

// The file of a case names a shipped plan and extends it.
void a_case_names_a_plan_its_vessels_and_what_differs(void **)
{
    const std::string path =
        write("title = \"A case\"\n[assessment]\nplan = \"navigation\"\n"
              "[assessment.vessels]\ntarget = \"LAD\"\nway = [\"LM\", \"LAD\"]\n"
              "[[assessment.error]]\nname = \"side_branch\"\nwhen = \"tip wire off the way at least 3 mm\"\n"
              "severity = \"serious\"\nsource = \"the case's own\"\n"
              "[[assessment.metric]]\nname = \"fluoroscopy_min\"\nall = 2\nnone = 8\nsource = \"the case's "
              "own\"\n");
    const crn::TomlTable root = crn::read_toml(path, {"a case", "a case"});
    root.read_sources();
    const crn::AssessPlan plan = crn::read_plan(root.table("assessment"));
    assert_string_equal(plan.name.c_str(), "navigation");
    assert_string_equal(plan.vessels.names.at("target").c_str(), "LAD");
    assert_int_equal(plan.vessels.way.size(), 2);
    assert_float_equal(plan.limits.at("fluoroscopy_min").none_at, 8.0, 0.0);
    int sides = 0;
    for (const crn::PlanError &error : plan.errors)
        if (error.name == "side_branch") {
            ++sides;
            assert_true(error.severity == crn::Severity::serious);
        }
    assert_int_equal(sides, 1);
    assert_true(plan.errors.size() >= 8); // the others are those of the shipped plan
}

void a_vessel_of_the_command_line_has_a_name_and_a_vessel(void **)
{
    crn::AssessPlan plan;
    crn::set_vessel(plan, "target=left main");
    assert_string_equal(plan.vessels.names.at("target").c_str(), "left main");
    for (const char *word : {"target", "=LAD", "target="}) try {
            crn::set_vessel(plan, word);
            fail_msg("%s was accepted", word);
        } catch (const std::runtime_error &error) {
            assert_non_null(std::strstr(error.what(), "write NAME=VESSEL"));
        }
}

} // namespace

int main()
{
    const CMUnitTest tests[] = {
        cmocka_unit_test(every_condition_of_the_documentation_is_read),
        cmocka_unit_test(a_mistake_is_reported_with_its_place_and_a_suggestion),
        cmocka_unit_test(brackets_without_end_do_not_overflow_the_stack),
        cmocka_unit_test(a_plan_with_a_mistake_is_refused_with_its_line),
        cmocka_unit_test(every_shipped_plan_is_read_and_every_limit_has_a_source),
        cmocka_unit_test(a_case_names_a_plan_its_vessels_and_what_differs),
        cmocka_unit_test(a_vessel_of_the_command_line_has_a_name_and_a_vessel),
    };
    return cmocka_run_group_tests(tests, make_folder, remove_folder);
}
