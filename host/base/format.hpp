// Makes text from numbers, and escapes text for HTML and SVG pages.
#pragma once
#include <cstdarg>
#include <string>

namespace crn
{

// Formats text as printf does; the formatted text may have any length. If a format string does not fit the
// values that are to be printed, the code does not compile.
[[gnu::format(printf, 1, 2)]] std::string formatted(const char *format, ...);

[[gnu::format(printf, 1, 0)]] std::string formatted_with(const char *format, va_list values);

// Formats text as printf does and adds the end of the line.
[[gnu::format(printf, 1, 2)]] std::string formatted_line(const char *format, ...);

// Escapes text for HTML and SVG, in an element or in an attribute between double quotes: &, <, > and " are
// replaced.
std::string html_text(const std::string &text);

} // namespace crn
