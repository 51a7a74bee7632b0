// Traces an artery from a click: along its ridge to the arteries that were found, and away from them as far
// as the tube goes. So one click takes back a whole artery that a bone has claimed.
#pragma once
#include "tools/lab/ct/arteries/bright.hpp"
#include "tools/lab/ct/arteries/clicks.hpp"

namespace crn::ct
{

constexpr double trace_most_mm = 120;    // of the way in each direction
constexpr unsigned char thread_mark = 2; // in `tubes`, where 1 is a bridge

// Adds the voxels of the traced arteries to `artery`, and those of them that the wall must not close to
// `tubes`. The ways lead to arteries that were found without a click (`unaided`), are connected with `start`
// and are wider than 2.8 mm: what has grown from a click may be bone. A click that lies in one of them, or
// from which no way leads there, adds nothing.
void trace_clicked(const Volume &scan, const Bright &bright, const Contrast &contrast,
                   const std::vector<Click> &clicks, const Mask &unaided, const Mask &start, Mask &artery,
                   Mask &tubes, Findings &findings);

} // namespace crn::ct
