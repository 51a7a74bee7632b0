// Formats messages that contain numbers.
#pragma once
#include <cstdio>
#include <string>

namespace crn
{

inline std::string format(const char *pattern, auto... values)
{
    char text[512];
    std::snprintf(text, sizeof text, pattern, values...);
    return text;
}

} // namespace crn
