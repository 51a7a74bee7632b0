// Makes text safe for a terminal. Text from files, devices and third-party libraries is printed without
// control characters. Without control characters, no name can move the cursor, change a title or imitate a
// line of the program.
#pragma once
#include <cstdio>
#include <string>
#include <string_view>

namespace crn
{

// Returns a name or a path as text that can be printed in one line. These bytes become \xNN, byte by byte:
// control characters (C0, DEL, C1), characters that change the writing direction, line separators, and bytes
// that are not UTF-8. All other characters do not change. A backslash in the text is not doubled, because the
// result is only for reading.
std::string printable(std::string_view text);
// Makes a whole message printable and keeps its line ends.
std::string printable_lines(std::string_view text);

// Prints like fprintf, through printable_lines().
[[gnu::format(printf, 2, 3)]] void say(std::FILE *out, const char *format, ...);

} // namespace crn
