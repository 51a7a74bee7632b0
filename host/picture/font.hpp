// Provides the bitmap font in which the display draws its texts. A letter has 5 columns, 7 rows, and one more
// row below the baseline.
#pragma once
#include <array>
#include <cstdint>

namespace crn
{

inline constexpr int glyph_columns = 5;
inline constexpr int glyph_rows = 8;

// Returns a letter's rows from the top; bit 4 of a row is the left column. An unknown letter is drawn as a
// caret; '\x7f' is the degree sign.
std::array<std::uint8_t, glyph_rows> glyph(char letter);

} // namespace crn
