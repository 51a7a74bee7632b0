// These tests check the following. The reader of TOML files returns values within their bounds, and refuses
// all other values. If the reader refuses a value, the message names file, line, place, key and remedy. For a
// mistyped key, word or source the error message suggests the right one.
#include "host/base/tests/folder.hpp"
#include "host/base/toml_reader.hpp"

#include <csetjmp>
#include <cstdarg>
#include <cstddef>
#include <cstdint>
#include <fstream>
#include <functional>
extern "C" {
#include <cmocka.h>
}

namespace
{

using crn::TomlTable;

crn::tests::Folder *folder = nullptr;

TomlTable read(const std::string &text)
{
    const std::string file = folder->file("a.toml");
    std::ofstream(file, std::ios::binary) << text;
    return crn::read_toml(file, {"a test", "a file of this test", ": give less"});
}

std::string refusal(const std::function<void()> &call)
{
    try {
        call();
    } catch (const crn::FileError &error) {
        return error.what();
    }
    return "";
}

void refuses(const std::string &text, const std::function<void(const TomlTable &)> &use,
             const std::string &wanted)
{
    const std::string said = refusal([&] { use(read(text)); });
    if (said != folder->file("a.toml") + ":" + wanted)
        fail_msg("\"%s\" is not the file and \":%s\"", said.c_str(), wanted.c_str());
}

void values_within_their_bounds_are_read(void **)
{
    const TomlTable root =
        read("format = 3\ncount = 4.0\nshare = 0.25\nname = \"a\"\nplace = [1, 2.5, -3]\n"
             "moves = true\nparts = [\"x\", \"y\"]\npart = \"z\"\n[[row]]\nat = 1\n[[row]]\nat = 2\n");
    root.check_format(3);
    assert_int_equal(root.whole("count", {1, 4}), 4);
    assert_true(root.number("share", {0, 1}) == 0.25 && root.number("absent", {0, 1}, 0.5) == 0.5);
    assert_string_equal(root.words("name").c_str(), "a");
    assert_string_equal(root.text("absent", 3, "b").c_str(), "b");
    assert_true((root["place"].three(10) == std::array{1.0, 2.5, -3.0}));
    assert_true(root["moves"].truth());
    assert_true((root["parts"].texts() == std::vector<std::string>{"x", "y"}));
    assert_true((root["part"].texts() == std::vector<std::string>{"z"}));
    assert_int_equal(root.tables("row").size(), 2);
    assert_true(root.tables("row")[1].number("at", {0, 5}) == 2);
    assert_true(root.tables("absent").empty());
    assert_int_equal(root["share"].line(), 3);
}

void a_mistyped_key_or_word_gets_a_suggestion(void **)
{
    const auto known = [](const TomlTable &t) { t.check_keys({"length_mm", "radius_mm"}); };
    refuses("lenght_mm = 1\n", known, "1:13: unknown key 'lenght_mm', did you mean 'length_mm'?");
    refuses("colour = 1\n", known, "1:10: unknown key 'colour'; known: length_mm, radius_mm");
    const auto inner = [](const TomlTable &t) { t.table("rod").inside("rod").check_keys({"length_mm"}); };
    refuses("[rod]\nlengths_mm = 1\n", inner,
            "2:14: rod: unknown key 'lengths_mm', did you mean 'length_mm'?");
    const auto kind = [](const TomlTable &t) { t["kind"].one_of({"wire", "catheter"}); };
    refuses("kind = \"wires\"\n", kind, "1:8: 'kind' is 'wires', did you mean 'wire'?");
}

void numbers_outside_their_bounds_are_refused(void **)
{
    const auto number = [](const TomlTable &t) { t.number("x", {0.5, 2}); };
    refuses("x = 3\n", number, "1:5: 'x' = 3 is outside 0.5 .. 2");
    refuses("x = 0.4999\n", number, "1:5: 'x' = 0.4999 is outside 0.5 .. 2");
    refuses("x = nan\n", number, "1:5: 'x' is not a finite number: give one from 0.5 to 2");
    refuses("x = inf\n", number, "1:5: 'x' is not a finite number: give one from 0.5 to 2");
    refuses("x = \"1\"\n", number, "1:5: 'x' is not a finite number: give one from 0.5 to 2");
    refuses("y = 1\n", number, "1:1: 'x' is missing: give a number from 0.5 to 2");
    refuses(
        "x = 1.5\n",
        [](const TomlTable &t) {
            t.whole("x", {1, 2});
        },
        "1:5: 'x' is not a whole number");
    const auto three = [](const TomlTable &t) { t["x"].three(100); };
    const std::string wanted = "1:5: 'x' must be three numbers from -100 to 100, like [1.0, 0.0, 0.0]";
    for (const char *text :
         {"x = [1, 2]\n", "x = [1, 2, 101]\n", "x = [1, 2, nan]\n", "x = [1, 2, true]\n", "x = 1\n"})
        refuses(text, three, wanted);
}

void texts_lists_and_tables_of_another_form_are_refused(void **)
{
    const auto words = [](const TomlTable &t) { t.words("x"); };
    refuses("x = 7\n", words, "1:5: 'x' is not a text: put it in quotes");
    refuses("x = \"\"\n", words, "1:5: 'x' is empty: give a text");
    const auto text = [](const TomlTable &t) { t.text("x", 3, ""); };
    refuses("x = \"four\"\n", text, "1:5: 'x' is longer than 3 bytes: shorten it");
    refuses("x = \"a\\u001b\"\n", text, "1:5: 'x' holds a control character: remove it");
    const auto texts = [](const TomlTable &t) { t["x"].texts(); };
    for (const char *bad : {"x = []\n", "x = [1]\n", "x = [\"a\", \"\"]\n", "x = 1\n"})
        refuses(bad, texts, "1:5: 'x' must be a list of names in quotes");
    refuses(
        "x = 1\n", [](const TomlTable &t) { t["x"].truth(); }, "1:5: 'x' must be true or false");
    refuses(
        "x = 1\n", [](const TomlTable &t) { t["x"].list(); }, "1:5: 'x' must be a list");
    refuses(
        "x = 1\n", [](const TomlTable &t) { t.table("x"); }, "1:5: 'x' must be a table: [x]");
    refuses(
        "y = 1\n", [](const TomlTable &t) { t.table("x"); }, "1:1: 'x' is missing: add the table [x]");
    refuses(
        "[x]\n", [](const TomlTable &t) { t.tables("x"); }, "1:1: 'x' must be written as [[x]]");
    const auto format = [](const TomlTable &t) { t.check_format(2); };
    refuses("format = 1\n", format, "1:10: 'format' must be 2; this file is of another version");
    refuses("", format, "1:1: 'format' is missing: this program reads format = 2");
}

void a_value_without_its_source_is_refused(void **)
{
    const auto value = [](const TomlTable &t) {
        t.read_sources();
        t.sourced("x", {0, 1});
        t.check_sources_used();
    };
    const std::string sources = "[sources]\ntips = \"a measurement\"\n";
    assert_string_equal(
        refusal([&] { value(read("x = { value = 1, source = \"@tips: 3\" }\n" + sources)); }).c_str(), "");
    const TomlTable ramp = read("x = { from = 0.25, to = 1, source = \"a scale\" }\n");
    assert_true(ramp.sourced_range("x", {0, 1}).from == 0.25 && ramp.sourced_range("x", {0, 1}).to == 1);
    refuses(
        "x = 1\n", value,
        "1:5: 'x' must be { value = ..., source = \"...\" } or { from = ..., to = ..., source = \"...\" }");
    refuses("x = { value = 1 }\n", value, "1:5: 'x': 'source' is missing");
    refuses("x = { valu = 1, source = \"a\" }\n", value,
            "1:14: 'x': unknown key 'valu', did you mean 'value'?");
    refuses("x = { value = 2, source = \"a\" }\n", value, "1:5: 'x' = 2 is outside 0 .. 1");
    refuses("x = { value = 1, to = 1, source = \"a\" }\n", value,
            "1:5: 'x' has both 'value' and 'from'/'to'");
    refuses("x = { from = 0, to = 1, source = \"a\" }\n", value, "1:5: 'x' must be one value");
    refuses("x = { value = 1, source = \"@tip\" }\n" + sources, value,
            "1:27: 'x': there is no 'tip' in [sources], did you mean 'tips'?");
    refuses("x = { value = 1, source = \"a\" }\n" + sources, value, "3:8: no value names the source 'tips'");
}

void absent_huge_and_broken_files_are_refused(void **)
{
    const auto of = [](const std::string &file) {
        return refusal([&] { crn::read_toml(file, {"a test", "a file of this test", ": give less"}); });
    };
    assert_string_equal(of("/nowhere/a.toml").c_str(),
                        "/nowhere/a.toml: no such file: give a file of this test");
    assert_string_equal(of("/tmp").c_str(), "/tmp: no such file: give a file of this test");
    const std::string file = folder->file("a.toml");
    std::ofstream(file) << std::string((std::size_t{4} << 20) + 1, '\n');
    assert_string_equal(of(file).c_str(), (file + ": over 4 MiB, so hardly a test: give less").c_str());
    std::ofstream(file) << "a = 1\n[b\n";
    assert_true(of(file).rfind(file + ":2:", 0) == 0);
}

} // namespace

int main()
{
    const CMUnitTest tests[] = {
        cmocka_unit_test(values_within_their_bounds_are_read),
        cmocka_unit_test(a_mistyped_key_or_word_gets_a_suggestion),
        cmocka_unit_test(numbers_outside_their_bounds_are_refused),
        cmocka_unit_test(texts_lists_and_tables_of_another_form_are_refused),
        cmocka_unit_test(a_value_without_its_source_is_refused),
        cmocka_unit_test(absent_huge_and_broken_files_are_refused),
    };
    crn::tests::Folder own("toml_reader");
    folder = &own;
    cmocka_set_message_output(CM_OUTPUT_TAP);
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
