// Text from numbers, and text for pages.
#pragma once
#include <cstdarg>
#include <string>

namespace crn
{

// As printf, of any length. A format that is no good for its values does not compile.
[[gnu::format(printf, 1, 2)]] std::string formatted(const char *format, ...);

[[gnu::format(printf, 1, 0)]] std::string formatted_with(const char *format, va_list values);

// The same with an end of line.
[[gnu::format(printf, 1, 2)]] std::string formatted_line(const char *format, ...);

// Text as HTML and SVG show it, in an element or in an attribute between double quotes: &, <, > and "
// replaced.
std::string html_text(const std::string &text);

} // namespace crn
