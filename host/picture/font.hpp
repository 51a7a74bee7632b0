// The bitmap font of the display has 5 columns, 7 rows and one row below the baseline.
#pragma once
#include <array>
#include <cstdint>

namespace crn
{

inline constexpr int glyph_columns = 5;
inline constexpr int glyph_rows = 8;

// Returns rows from the top; bit 4 is the left column. For an unknown letter it returns a caret; '\x7f' is
// the degree sign.
std::array<std::uint8_t, glyph_rows> glyph(char letter);

} // namespace crn
