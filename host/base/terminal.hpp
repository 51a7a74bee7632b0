// What a person reads in a terminal: text from files, devices and other people's libraries reaches it without
// control characters, so that no name moves the cursor, changes a title or forges a line.
#pragma once
#include <cstdio>
#include <string>
#include <string_view>

namespace crn
{

// A name or path in one line: control characters (C0, DEL, C1), those that turn the direction of writing, the
// separators of lines and bytes that are no UTF-8 become \xNN, byte by byte; all else stays. A backslash
// stays too: this is for reading.
std::string printable(std::string_view text);
// The same for whole messages: ends of lines stay.
std::string printable_lines(std::string_view text);

// As fprintf, through printable_lines().
[[gnu::format(printf, 2, 3)]] void say(std::FILE *out, const char *format, ...);

} // namespace crn
