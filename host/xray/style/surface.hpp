// Sums over surfaces: every triangle adds a value at each pixel centre that it covers; the value is linear
// between the corners. All arithmetic is in integers, so that the sum depends on neither order nor threads.
#pragma once
#include "host/xray/paths/carm.hpp"
#include <array>
#include <cstdint>
#include <vector>

namespace crn
{

struct SurfaceCorner {
    std::int32_t x = 0, y = 0;  // 1/16 pixel
    std::int32_t value_q16 = 0; // 0 .. 2^18
    bool is_seen = false;       // in front of the source and not far off the picture
};

// Projects a patient point, and attaches a value.
SurfaceCorner surface_corner(const View &view, const Eigen::Vector3d &point_m, std::int32_t value_q16);

// Adds one triangle to rows [row_begin, row_end) of sums (size*size). Neighbours cover each pixel exactly
// once (top-left rule).
void add_surface(const std::array<SurfaceCorner, 3> &corners, int size, int row_begin, int row_end,
                 std::int32_t *sums);

} // namespace crn
