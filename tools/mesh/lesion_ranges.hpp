// Defines the permitted ranges of a lesion's numbers (docs/lesions.md) in one place, which both writers and
// readers of scene texts use.
#pragma once
#include "host/base/number_range.hpp"

namespace crn
{

constexpr NumberRange lesion_at_mm = {0, 1000}, lesion_length_mm = {2, 100},
                      lesion_stenosis_percent = {1, 95}, // of the diameter
    lesion_eccentricity = {0, 1}, lesion_plaque_deg = {-360, 360}, lesion_calcified_deg = {0, 300};

} // namespace crn
