// Describes a label image that is drawn in the same pass as the path lengths of tools and curves (tube.hpp);
// a second pass for the labels would take a third of the time of a picture.
#pragma once
#include <cstddef>
#include <cstdint>
#include <vector>

namespace crn
{

// Describes consecutive curves of a frame that set the same bit of the label image.
struct LabelledCurves {
    std::size_t count = 0;
    std::uint8_t bit = 0; // 0: no label
    // A pixel gets the bit if the sum of its rays' path lengths in these curves, in 1/1024 mm, is at least
    // this number. If the threshold for a label is 0, a pixel gets the label's bit if at least one ray meets
    // a curve.
    std::int64_t sum_min_q10mm = 0;
};

struct TubeLabels {
    std::vector<std::uint8_t> tool_bits; // of each tool of the frame; 0: no label
    std::vector<LabelledCurves> curves;  // in the order of the frame's curves; the others have no label
    std::vector<std::uint8_t> pixels;    // size * size, row 0 on top; drawing replaces them

    // The remaining members are working data of the drawing code. Between two drawings, all sums of path
    // lengths are 0.
    std::vector<std::int32_t> sums_q10mm; // of each pixel
    std::vector<std::int32_t> summed;     // pixels whose sum is not 0
};

} // namespace crn
