// Returns the largest number of brackets in a JSON text that are open at the same time. A function that walks
// through the parsed JSON calls itself once per level of nesting, so the depth of nesting must be limited.
#pragma once
#include <algorithm>
#include <cstddef>
#include <string_view>

namespace crn
{

inline constexpr int json_depth_max = 64;

inline int json_depth(std::string_view text)
{
    int depth = 0, deepest = 0;
    bool is_text = false;
    for (std::size_t i = 0; i < text.size(); ++i) {
        const char c = text[i];
        if (is_text && c == '\\')
            ++i;
        else if (c == '"')
            is_text = !is_text;
        else if (!is_text && (c == '[' || c == '{'))
            deepest = std::max(deepest, ++depth);
        else if (!is_text && (c == ']' || c == '}'))
            --depth;
    }
    return deepest;
}

} // namespace crn
