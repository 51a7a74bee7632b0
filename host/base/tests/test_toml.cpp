// These tests check the following. Before parsing, the reader refuses a text on which the parser would
// recurse too deeply; the message names line and column. A text within the limits must be parsed, traversed
// and destroyed without a deep stack.
#include "host/base/toml.hpp"

#include <csetjmp>
#include <cstdarg>
#include <cstddef>
#include <cstdint>
extern "C" {
#include <cmocka.h>
}

namespace
{

std::string repeated(const std::string &text, int count)
{
    std::string all;
    for (int i = 0; i < count; ++i) all += text;
    return all;
}

// Returns "line:column what", or "".
std::string refusal(const std::string &text)
{
    try {
        crn::parse_toml(text, "a.toml");
    } catch (const crn::TomlError &error) {
        return std::to_string(error.line) + ":" + std::to_string(error.column) + " " + error.what();
    }
    return "";
}

void begins_with(const std::string &text, const std::string &wanted)
{
    if (text.rfind(wanted, 0) != 0)
        fail_msg("\"%s\" does not begin with \"%s\"", text.c_str(), wanted.c_str());
}

void a_header_of_400000_names_is_refused(void **)
{
    begins_with(refusal("x = 1\n[" + repeated("a.", 400000) + "a]\n"), "2:65 a key of over 32 names");
    begins_with(refusal(repeated("'a' . ", 400000) + "a = 1\n"), "1:");
    begins_with(refusal("x = {" + repeated("a.", 40) + "a = 1}\n"), "1:");
}

void brackets_without_end_are_refused(void **)
{
    begins_with(refusal("a = " + std::string(1000000, '[')), "1:37 over 32 brackets");
    begins_with(refusal("a = " + repeated("{b = ", 100000)), "1:");
    // If five quotation marks end a string, the last three of them close it, so the text that follows is
    // outside the string.
    begins_with(refusal("a = [\"\"\"x\"\"\"\"\", " + std::string(1000, '[')), "1:");
}

void a_text_of_data_is_refused(void **)
{
    begins_with(refusal(std::string(crn::toml_bytes_max + 1, '\n')), "0:0 has 4 MiB");
}

void what_looks_deep_in_strings_and_comments_is_read(void **)
{
    assert_string_equal(refusal("a = '" + std::string(100, '[') + "' # " + std::string(100, '[') +
                                "\nb = \"\\\"" + std::string(100, '{') + repeated("a.", 100) +
                                "\"\nc = '''\n" + std::string(100, '[') + "\n'''\nd = [" +
                                repeated("1.5, ", 100) + "]\n")
                            .c_str(),
                        "");
}

// The deepest text within the limits has a header of 32 names, and below it 31 nested tables, each after a
// key of 32 names.
void the_deepest_text_that_is_allowed_is_read(void **)
{
    const std::string key = repeated("a.", 31) + "a";
    std::string text = "[" + key + "]\n" + key + " = ";
    for (int i = 0; i < 31; ++i) text += "{" + key + " = ";
    text += "1" + std::string(31, '}') + "\n";
    const toml::table table = crn::parse_toml(text, "a.toml");
    int depth = 0;
    for (const toml::table *at = &table; at; at = (*at)["a"].as_table()) ++depth;
    assert_int_equal(depth, 32 + 32 * 32);
}

// To find out whether a letter outside ASCII is white space, the library toml++ looks it up in a table. In an
// earlier version, this look-up was undefined behaviour for most letters outside ASCII, and a sanitizer ended
// the program (host/base/toml.hpp).
void a_letter_outside_ascii_is_no_blank(void **)
{
    begins_with(refusal("\xEF\xBB\x9F\x07"), "1:1 ");
    begins_with(refusal("a = 1\nb = 2 \u00e4\n"), "2:7 ");
    begins_with(refusal("a = [1\"\"\"\uFD7F\"\"\"]\n"), "1:");
    const toml::table table = crn::parse_toml(
        "\uFEFF\"\u00e4\" = '\u00f6' # \u00fc\nb = \"\"\"\\\n \u00e4 \uFD7F\"\"\"\n", "a.toml");
    assert_string_equal(table["\u00e4"].value_or(std::string()).c_str(), "\u00f6");
    assert_string_equal(table["b"].value_or(std::string()).c_str(), "\u00e4 \uFD7F");
}

} // namespace

int main()
{
    const CMUnitTest tests[] = {
        cmocka_unit_test(a_header_of_400000_names_is_refused),
        cmocka_unit_test(brackets_without_end_are_refused),
        cmocka_unit_test(a_text_of_data_is_refused),
        cmocka_unit_test(what_looks_deep_in_strings_and_comments_is_read),
        cmocka_unit_test(the_deepest_text_that_is_allowed_is_read),
        cmocka_unit_test(a_letter_outside_ascii_is_no_blank),
    };
    cmocka_set_message_output(CM_OUTPUT_TAP);
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
