// Converts texts of the X-ray display to the characters of the window's font.
#pragma once
#include <algorithm>
#include <string>
#include <string_view>
#include <vector>

namespace crn
{

// Replaces the character 0x7f, which is the degree sign in the display's own font.
inline std::string with_degrees(std::string_view text)
{
    std::string result;
    for (char letter : text) {
        if (letter == '\x7f')
            result += "\u00b0";
        else
            result += letter;
    }
    return result;
}

// Breaks a text into lines of at most this width, only at blanks, because ImGui also breaks after the point
// in "3.0 mm". The function `measure` returns the width of a text. A word that is wider than the line is not
// broken.
template <class Measure>
std::vector<std::string> lines_of(std::string_view text, float width, Measure measure)
{
    std::vector<std::string> lines(1);
    bool has_word = false; // on the present line, besides its indentation
    for (std::size_t at = 0; at <= text.size();) {
        const std::size_t end = std::min(text.find_first_of(" \n", at), text.size());
        const std::string word(text.substr(at, end - at));
        const bool is_first = at == 0 || text[at - 1] == '\n';
        const std::string longer = is_first ? word : lines.back() + " " + word;
        if (has_word && !word.empty() && measure(longer) > width)
            lines.push_back(word);
        else
            lines.back() = longer;
        has_word = has_word || !word.empty();
        if (end < text.size() && text[end] == '\n') {
            lines.emplace_back();
            has_word = false;
        }
        at = end + 1;
    }
    return lines;
}

inline std::string joined_lines(const std::vector<std::string> &lines)
{
    std::string text;
    for (const std::string &line : lines) text += (&line == lines.data() ? "" : "\n") + line;
    return text;
}

// Removes the time at the end of a notice, such as " (at 4569 ms)", which is meant for the report.
inline std::string without_moment(const std::string &notice)
{
    const std::size_t at = notice.rfind(" (at ");
    const bool is_moment = at != std::string::npos && notice.size() >= 4 && notice.ends_with(" ms)");
    return is_moment ? notice.substr(0, at) : notice;
}

// Removes the remedy from the text about a condition that is not met, because the remedy is meant for the
// author of a script.
inline std::string without_remedy(const std::string &found)
{
    return found.substr(0, found.find("; remedy:"));
}

} // namespace crn
