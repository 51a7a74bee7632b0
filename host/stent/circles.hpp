// A stent that was deployed as the core meets it: circles of its struts' inside, from its tip's end to its
// hub's. Between two of them a tool cannot go through (docs/lesions.md). Circles lie in the middle of rings,
// the first and the last one at the stent's ends.
#pragma once
#include "host/stent/stent.hpp"
#include <functional>
#include <vector>

namespace crn
{

struct StentCircle {
    Eigen::Vector3d centre_mm;
    double inside_mm = 0.0; // radius, inside of the struts: the mean over the ring's crowns
};

// At most `most` (two at least), evenly chosen where the stent has more rings; none unless it is deployed.
// `to_reference`: where a place of now is in the pose that the vessels are described in.
std::vector<StentCircle>
stent_circles(const Stent &stent, std::size_t most,
              const std::function<Eigen::Vector3d(const Eigen::Vector3d &)> &to_reference);

} // namespace crn
