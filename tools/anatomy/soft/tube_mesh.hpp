/* Adds thin tubes to a mesh as polygonal prisms. */
#pragma once
#include "tools/anatomy/mesh.hpp"

namespace anatomy
{

/* Adds a closed tube with `sides` sides along the points of a course, of which there must be two or more. Its
 * sections have the area of circles with the course's radii; flat caps close its ends. */
void add_tube(Mesh &mesh, const Curve &course, int sides);

/* Returns a course with fewer points, which departs from the given one by at most error_mm. */
Curve simplified_course(const Curve &course, double error_mm);

} // namespace anatomy
