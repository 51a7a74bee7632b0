// Describes a deployed stent as the core uses it: by circles along the inner side of the struts, from the end
// towards the tip to the end towards the hub. No tool can pass between two neighbouring circles of the stent
// (docs/lesions.md). Each circle lies in the middle of a ring of struts, except that the first and the last
// circle lie at the ends of the stent.
#pragma once
#include "host/stent/stent.hpp"
#include <functional>
#include <vector>

namespace crn
{

struct StentCircle {
    Eigen::Vector3d centre_mm;
    double inside_mm = 0.0; // inside radius of the struts: the mean over the ring's crowns
};

// Returns at least two and at most `most` circles. If the stent has more rings than `most`, the function
// chooses rings at even distances. Returns an empty list if the stent is not deployed. `to_reference`
// converts a present position to the reference pose of the vessels.
std::vector<StentCircle>
stent_circles(const Stent &stent, std::size_t most,
              const std::function<Eigen::Vector3d(const Eigen::Vector3d &)> &to_reference);

} // namespace crn
