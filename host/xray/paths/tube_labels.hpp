// A label image, which is drawn in the same pass as the path lengths of tools and curves (tube.hpp): drawing
// them a second time for the labels would take a third of the time of a picture.
#pragma once
#include <cstddef>
#include <cstdint>
#include <vector>

namespace crn
{

// Describes a run of consecutive curves of a frame, which have one bit of the label image.
struct LabelledCurves {
    std::size_t count = 0;
    std::uint8_t bit = 0; // 0: no label
    // The sum of the path lengths of a pixel's rays in these curves, in 1/1024 mm, from which on the pixel
    // has the bit. With 0, the pixel has the bit if at least one ray meets a curve.
    std::int64_t sum_min_q10mm = 0;
};

struct TubeLabels {
    std::vector<std::uint8_t> tool_bits; // of each tool of the frame; 0: no label
    std::vector<LabelledCurves> curves;  // in the order of the frame's curves; the others have no label
    std::vector<std::uint8_t> pixels;    // size * size, row 0 on top; drawing replaces them

    // The rest belongs to the drawing. Between two drawings all sums are 0.
    std::vector<std::int32_t> sums_q10mm; // of each pixel
    std::vector<std::int32_t> summed;     // pixels whose sum is not 0
};

} // namespace crn
