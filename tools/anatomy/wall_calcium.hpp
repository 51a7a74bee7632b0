/* Calcium in the wall of the aorta and of the iliac arteries, which shows as bright flecks beside the lumen.
 */
#pragma once
#include "tools/anatomy/person.hpp"
#include "tools/anatomy/vessels.hpp"

namespace anatomy
{

/* One plaque: a flat lens in the wall, just outside the lumen. */
struct Plaque {
    Vec3 centre_mm, half_axes_mm; // across the wall, around the vessel, along it
    Eigen::Matrix3d rotation;     // columns: these directions
};

/* Returns the plaques of a person's tree. Their number grows with `wall_calcium`. Most lie below the renal
 * arteries and in the arch. */
std::vector<Plaque> wall_plaques(const VesselTree &tree, const SoftShape &shape);

Solid plaque_solid(const std::vector<Plaque> &plaques);

} // namespace anatomy
