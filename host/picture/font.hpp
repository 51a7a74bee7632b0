// Bitmap font of the display: 5 columns, 7 rows and one row below the line.
#pragma once
#include <array>
#include <cstdint>

namespace crn
{

inline constexpr int glyph_columns = 5;
inline constexpr int glyph_rows = 8;

// Rows from the top, bit 4 is the left column. An unknown letter is a caret; '\x7f' is the degree sign.
std::array<std::uint8_t, glyph_rows> glyph(char letter);

} // namespace crn
