#include "host/base/format.hpp"
#include <cstdio>

namespace crn
{

std::string formatted_with(const char *format, va_list values)
{
    va_list again;
    va_copy(again, values);
    const int length = std::vsnprintf(nullptr, 0, format, values);
    std::string text(length > 0 ? static_cast<std::size_t>(length) : 0, '\0');
    std::vsnprintf(text.data(), text.size() + 1, format, again);
    va_end(again);
    return text;
}

std::string formatted(const char *format, ...)
{
    va_list values;
    va_start(values, format);
    std::string text = formatted_with(format, values);
    va_end(values);
    return text;
}

std::string formatted_line(const char *format, ...)
{
    va_list values;
    va_start(values, format);
    std::string text = formatted_with(format, values);
    va_end(values);
    return text + "\n";
}

std::string html_text(const std::string &text)
{
    std::string safe;
    for (const char c : text) {
        switch (c) {
        case '&':
            safe += "&amp;";
            break;
        case '<':
            safe += "&lt;";
            break;
        case '>':
            safe += "&gt;";
            break;
        case '"':
            safe += "&quot;";
            break;
        default:
            safe += c;
        }
    }
    return safe;
}

} // namespace crn
