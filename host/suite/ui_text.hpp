// Converts the display's texts to the letters of the window's font.
#pragma once
#include <algorithm>
#include <string>
#include <string_view>
#include <vector>

namespace crn
{

// The display's own letters have the degree sign at 0x7f.
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

// Breaks a text into lines of at most this width, at its blanks only: ImGui also breaks behind the point of
// "3.0 mm". `measure` returns the width of a text. A word that is too wide stays whole.
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

// Leaves out the moment behind a notice, " (at 4569 ms)": it is written for the report.
inline std::string without_moment(const std::string &notice)
{
    const std::size_t at = notice.rfind(" (at ");
    const bool is_moment = at != std::string::npos && notice.size() >= 4 && notice.ends_with(" ms)");
    return is_moment ? notice.substr(0, at) : notice;
}

// Leaves out the remedy of a condition that does not hold: it is written for the author of a script.
inline std::string without_remedy(const std::string &found)
{
    return found.substr(0, found.find("; remedy:"));
}

} // namespace crn
