// A deployed stent in the form that the core uses: circles of its struts' inside, from its tip end to its hub
// end. A tool cannot pass between two of them (docs/lesions.md). Circles lie in the middle of rings; the
// first and the last one lie at the stent's ends.
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

// Returns at most `most` circles (at least two), evenly chosen where the stent has more rings; none unless it
// is deployed. `to_reference` converts a present place to the pose in which the vessels are described.
std::vector<StentCircle>
stent_circles(const Stent &stent, std::size_t most,
              const std::function<Eigen::Vector3d(const Eigen::Vector3d &)> &to_reference);

} // namespace crn
