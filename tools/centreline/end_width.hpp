// The width of a vessel at an end that is closed. In front of a cap, inscribed spheres become as small as
// their distance from it, so the last sphere says nothing about the vessel.
#pragma once
#include "tools/centreline/tree.hpp"

namespace crn::centreline
{

struct EndWidth {
    double radius_mm = 0;  // median over two radii of the vessel behind the taper of its cap
    std::size_t index = 0; // the spheres before this one are those of the taper
};

// `inwards` begins at the end. Spheres belong to the taper as long as a sphere within the next radius (and
// 0.5 mm) is larger by more than a tenth. Vessels themselves become narrower more slowly than that.
EndWidth width_inside(const std::vector<Sphere> &inwards);

// Gives the spheres of a cap's taper the largest radius that lies within one radius of the vessel behind
// them: a flat cap at the end of a tube then leaves the tube's radius, and a cone becomes shorter by one
// radius. Returns the vessel's width.
EndWidth open_end(std::vector<Sphere> &inwards);

} // namespace crn::centreline
