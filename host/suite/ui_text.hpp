// Converts the display's texts to the letters of the window's font.
#pragma once
#include <string>
#include <string_view>

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

// Leaves out the remedy of a condition that does not hold: it is written for the author of a script.
inline std::string without_remedy(const std::string &found)
{
    return found.substr(0, found.find("; remedy:"));
}

} // namespace crn
