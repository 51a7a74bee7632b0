// These tests check the following. When the program prints text from files on a terminal, it prints only
// visible letters. Characters that would move the cursor, change the writing direction or end a line are
// shown as \xNN; all other letters of any language are not changed.
#include "host/base/terminal.hpp"
#include <csetjmp>
#include <cstdarg>
#include <cstddef>
#include <cstdint>
extern "C" {
#include <cmocka.h>
}

using namespace crn;

static void letters_of_any_language_stay(void **)
{
    for (const char *text : {"", "J wire 0.035\" x 180 cm", "Führungsdraht \u00d8 0,89 mm",
                             "\u8840\u7ba1 \u043a\u0430\u0442\u0435\u0442\u0435\u0440", "\U0001f9ea",
                             "C:\\x41\\wire.toml", "~ \u00a0"})
        assert_string_equal(printable(text).c_str(), text);
}

static void every_control_character_is_shown_as_its_number(void **)
{
    for (int code = 0; code < 256; code++) {
        const bool is_control = code < 0x20 || (code >= 0x7f && code < 0xa0);
        const std::string text = code < 0x80 ? std::string(1, static_cast<char>(code))
                                             : std::string{static_cast<char>(0xc0 | code >> 6),
                                                           static_cast<char>(0x80 | (code & 0x3f))};
        const std::string shown = printable(text);
        assert_int_equal(shown != text, is_control);
        for (char letter : shown) assert_true(static_cast<std::uint8_t>(letter) >= 0x20 && letter != 0x7f);
    }
    assert_string_equal(printable("\x1b]0;title\x07").c_str(), "\\x1b]0;title\\x07");
    assert_string_equal(printable("a\nb\tc\r").c_str(), "a\\x0ab\\x09c\\x0d");
    assert_string_equal(printable("\u009b31m").c_str(), "\\xc2\\x9b31m"); // CSI in one letter
}

static void nothing_turns_the_direction_of_writing(void **)
{
    assert_string_equal(printable("a\u202eb\u2066c\u200fd\u2028e\ufeff").c_str(),
                        "a\\xe2\\x80\\xaeb\\xe2\\x81\\xa6c\\xe2\\x80\\x8fd\\xe2\\x80\\xa8e\\xef\\xbb\\xbf");
    assert_string_equal(printable("\u2027\u202f\u2065\u206a").c_str(),
                        "\u2027\u202f\u2065\u206a"); // their neighbours
}

// The cases of RFC 3629: cut letters, lone bytes, longer forms than needed, surrogates, beyond U+10FFFF.
static void bytes_that_are_no_utf8_are_shown_as_numbers(void **)
{
    for (const char *text : {"\xc3", "\xe2\x80", "\xf0\x9f\xa7", "\x80", "\xff", "\xc0\xaf", "\xe0\x80\xaf",
                             "\xc1\x9b", "\xed\xa0\x80", "\xf4\x90\x80\x80", "\xf5\x80\x80\x80"})
        for (char letter : printable(text)) assert_true(letter >= 0x20 && letter < 0x7f);
    assert_string_equal(printable("\xc3(").c_str(), "\\xc3(");
}

static void messages_keep_their_lines_and_nothing_else(void **)
{
    assert_string_equal(printable_lines("a\n\x1b[2J\rb\n").c_str(), "a\n\\x1b[2J\\x0db\n");
}

int main()
{
    cmocka_set_message_output(CM_OUTPUT_TAP);
    const CMUnitTest tests[] = {
        cmocka_unit_test(letters_of_any_language_stay),
        cmocka_unit_test(every_control_character_is_shown_as_its_number),
        cmocka_unit_test(nothing_turns_the_direction_of_writing),
        cmocka_unit_test(bytes_that_are_no_utf8_are_shown_as_numbers),
        cmocka_unit_test(messages_keep_their_lines_and_nothing_else),
    };
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
