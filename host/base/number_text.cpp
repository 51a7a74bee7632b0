#include "host/base/number_text.hpp"
#include <charconv>

namespace crn
{

namespace
{

std::string converted(double value, std::chars_format format, int precision)
{
    char text[400]; // the largest double has 309 digits before its point
    const std::to_chars_result end = std::to_chars(text, text + sizeof text, value, format, precision);
    return {text, end.ptr};
}

} // namespace

std::string number_text(double value, int digits)
{
    return converted(value, std::chars_format::general, digits);
}

std::string decimals_text(double value, int decimals)
{
    return converted(value, std::chars_format::fixed, decimals);
}

std::string trimmed_text(double value, int decimals)
{
    std::string text = decimals_text(value, decimals);
    if (text.find('.') != std::string::npos) {
        text.erase(text.find_last_not_of('0') + 1);
        if (text.back() == '.') text.pop_back();
    }
    return text == "-0" ? "0" : text;
}

std::string hex_text(std::uint64_t value, int digits)
{
    char text[17];
    const std::to_chars_result end = std::to_chars(text, text + sizeof text, value, 16);
    const std::string plain(text, end.ptr);
    const auto wanted = static_cast<std::size_t>(digits);
    return plain.size() < wanted ? std::string(wanted - plain.size(), '0') + plain : plain;
}

} // namespace crn
