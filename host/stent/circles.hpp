// Describes a deployed stent as the core uses it: circles along the inner side of its struts, from its end at
// the tip to its end at the hub. No tool can pass between two neighbouring circles (docs/lesions.md). Each
// circle lies in the middle of a ring, but the first and the last one lie at the ends of the stent.
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

// Returns at most `most` circles, and at least two. If the stent has more rings, they are chosen at even
// distances. Returns none unless the stent is deployed. `to_reference` converts a present place to the
// reference pose of the vessels.
std::vector<StentCircle>
stent_circles(const Stent &stent, std::size_t most,
              const std::function<Eigen::Vector3d(const Eigen::Vector3d &)> &to_reference);

} // namespace crn
