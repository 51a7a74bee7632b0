#include "host/base/terminal.hpp"
#include "host/base/format.hpp"
#include <cstdarg>
#include <cstdint>

namespace crn
{

namespace
{

struct Letter {
    std::uint32_t code = 0;
    std::size_t bytes = 1;
    bool is_whole = false; // well-formed UTF-8 (RFC 3629): shortest form, no surrogate, at most U+10FFFF
};

Letter letter_at(std::string_view text, std::size_t at)
{
    const auto byte = [&](std::size_t i) { return static_cast<std::uint8_t>(text[at + i]); };
    const std::uint8_t first = byte(0);
    if (first < 0x80) return {first, 1, true};
    const std::size_t bytes = first >= 0xf0 ? 4 : first >= 0xe0 ? 3 : 2;
    if (first < 0xc2 || first > 0xf4 || text.size() - at < bytes) return {};
    std::uint32_t code = first & (0xffu >> (bytes + 1));
    for (std::size_t i = 1; i < bytes; ++i) {
        if ((byte(i) & 0xc0) != 0x80) return {};
        code = code << 6 | (byte(i) & 0x3fu);
    }
    const std::uint32_t least[] = {0, 0, 0x80, 0x800, 0x10000};
    if (code < least[bytes] || code > 0x10ffff || (code >= 0xd800 && code <= 0xdfff)) return {};
    return {code, bytes, true};
}

bool is_shown(std::uint32_t code)
{
    if (code < 0x20 || (code >= 0x7f && code < 0xa0)) return false;
    // The following characters are the control characters of writing direction (Unicode Bidi_Control), the
    // separators of lines and paragraphs, and the byte order mark.
    if (code == 0x61c || code == 0x200e || code == 0x200f || code == 0xfeff) return false;
    return !(code >= 0x2028 && code <= 0x202e) && !(code >= 0x2066 && code <= 0x2069);
}

std::string cleaned(std::string_view text, bool keeps_lines)
{
    std::string clean;
    clean.reserve(text.size());
    for (std::size_t at = 0; at < text.size();) {
        const Letter letter = letter_at(text, at);
        const bool stays = letter.is_whole && (is_shown(letter.code) || (keeps_lines && text[at] == '\n'));
        for (std::size_t i = 0; i < letter.bytes; ++i, ++at) {
            if (stays)
                clean += text[at];
            else
                clean += formatted("\\x%02x", unsigned{static_cast<std::uint8_t>(text[at])});
        }
    }
    return clean;
}

} // namespace

std::string printable(std::string_view text)
{
    return cleaned(text, false);
}

std::string printable_lines(std::string_view text)
{
    return cleaned(text, true);
}

void say(std::FILE *out, const char *format, ...)
{
    va_list values;
    va_start(values, format);
    const std::string text = printable_lines(formatted_with(format, values));
    va_end(values);
    std::fwrite(text.data(), 1, text.size(), out);
}

} // namespace crn
