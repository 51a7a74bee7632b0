// Tells a vessel that is drawn with its wall, as two sheets, from one that is drawn as its lumen alone.
#pragma once
#include "tools/bake/mesh.hpp"

#include <optional>

namespace crn::patient
{

// The inside of a wall: its inner sheet, which is open where the sheet ends.
struct WallFound {
    bake::Mesh lumen;
    double inner_share = 0;  // of the part's area
    double thickness_mm = 0; // median distance of the sheets
};

// Looks from the triangles of a part in both directions. From the inner sheet of a wall, both directions meet
// the part: the outer sheet at the wall's thickness, and the opposite wall at the width of the lumen. From an
// outer sheet, or a lumen alone, one direction leads out of the vessel. Returns the inner sheet if a quarter
// of the area is such a sheet, and nothing for a lumen alone.
std::optional<WallFound> lumen_of_wall(const bake::Mesh &part);

} // namespace crn::patient
