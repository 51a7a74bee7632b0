// Computes sums over surfaces. Every triangle adds a value at each pixel whose centre the triangle covers;
// this value changes linearly between the corners. All arithmetic uses integers, so that the sum depends
// neither on the order of triangles nor on the number of threads.
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

// Projects a point of the patient to the picture, and returns the projected point together with the value
// `value_q16`.
SurfaceCorner surface_corner(const View &view, const Eigen::Vector3d &point_m, std::int32_t value_q16);

// Adds one triangle to the rows [row_begin, row_end) of the picture `sums` (size*size pixels). Neighbouring
// triangles cover each pixel exactly once (top-left rule).
void add_surface(const std::array<SurfaceCorner, 3> &corners, int size, int row_begin, int row_end,
                 std::int32_t *sums);

} // namespace crn
