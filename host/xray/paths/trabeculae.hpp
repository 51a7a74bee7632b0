// The trabecular texture of spongy bone. Each face of a textured body shifts its depth by a short length h
// (docs/xray.md, "Trabeculae"). h depends only on the place of the face in its body, so the pattern moves
// with the bone when the C-arm, the table or the body moves, and every back end draws the same pattern.
//
// h comes from a periodic block of 64^3 cells, which holds smooth noise with the mean 0. The cells are longer
// along the patient than across, like the trabeculae that carry load. There is one block for each range of
// pixel sizes, so that no picture has detail finer than its pixels.
//
// The place of a vertex in the block is computed once. Within a triangle, the place is a linear function of
// the position in the picture, which is continuous from triangle to triangle. In a triangle of 10 mm whose
// corners differ by 5 mm in depth, the place is wrong by at most 0.02 mm.
#pragma once
#include "host/xray/paths/carm.hpp"
#include <cstdint>

namespace crn
{

inline constexpr int grain_bits = 6, grain_cells = 1 << grain_bits; // along each edge of the block

// Returns the place (u, v, w) of a point of the patient, in cells. The cell at this place is
// floor(place) modulo grain_cells.
Eigen::Vector3f grain_place(const Eigen::Vector3i &point_um);

// Describes the texture in one view.
struct Grain {
    const std::int8_t *block = nullptr; // cells in the order [w][v][u]; the three bytes before may be read
    float unit_q10mm = 0.0f;            // h of a cell that holds 1
    // A face that the rays graze would show as noise, because much of the texture lies between two pixels.
    // Its h is multiplied by 1 - steep slope^2 depth^4, where slope is the change of 1/depth (in 1/um) per
    // pixel, and by 0 where this is negative.
    float steep = 0.0f;
};
Grain grain_in(const View &view);

// The root mean square of h in a picture with fine pixels, of faces that the rays meet at a right angle.
inline constexpr double grain_rms_mm = 0.65;

} // namespace crn
