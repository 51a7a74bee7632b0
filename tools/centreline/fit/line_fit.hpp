// Fits inscribed spheres in the middle of a vessel, along a rough path through the vessel
// (docs/centreline.md).
#pragma once
#include "tools/centreline/fit/lumen.hpp"
#include "tools/centreline/tree.hpp"

namespace crn::centreline
{

struct LineWish {
    double spacing = 0.5; // of neighbouring spheres, in radii
    const Branch *parent =
        nullptr; // points inside this branch's tube stay on the path from its middle to the wall
    bool holds_first = true, holds_last = true; // the ends stay where they are
};

// Returns the centre of the largest inscribed sphere near p. The centre lies at most limit_mm away from p, in
// the plane through p perpendicular to `direction`.
Eigen::Vector3d centred(const Lumen &lumen, const Eigen::Vector3d &p_mm, const Eigen::Vector3d &direction,
                        double limit_mm);

// Fits inscribed spheres along the rough path and returns at least two spheres.
std::vector<Sphere> fit_line(const Lumen &lumen, const std::vector<Eigen::Vector3d> &way_mm,
                             const LineWish &wish);

// Places spheres along the centreline. The distance to the next sphere is `spacing` times the vessel's
// radius, and the first and last sphere lie at the ends.
std::vector<Sphere> spaced(const Lumen &lumen, const std::vector<Eigen::Vector3d> &line_mm, double spacing);

} // namespace crn::centreline
