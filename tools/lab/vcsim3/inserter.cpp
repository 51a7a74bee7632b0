#include "tools/lab/vcsim3/inserter.hpp"
#include <algorithm>
#include <cmath>

namespace vcsim3
{

Inserter::Inserter(const Vector &mouth_m, const Vector &direction, const Vector &axis)
    : mouth_m_(mouth_m), direction_(direction)
{
    Eigen::Matrix3d axes;
    axes << axis, axis.cross(direction), -direction;
    unturned_ = Quaternion(axes);
}

Rod Inserter::make_rod(const RodProperties &properties, double inserted_m) const
{
    Rod rod(properties, mouth_m_ + inserted_m * direction_, -direction_);
    std::fill(rod.orientation.begin(), rod.orientation.end(), unturned_);
    rod.free_count = 0;
    feed(rod, inserted_m, 0.0);
    return rod;
}

void Inserter::feed(Rod &rod, double inserted_m, double speed_m_s, double turn_rad) const
{
    const double element_m = rod.properties.element_m;
    while (rod.free_count < rod.node_count() && rod.free_count * element_m < inserted_m) rod.free_count++;
    for (int i = rod.free_count; i < rod.node_count(); i++) {
        rod.position[i] = mouth_m_ + (inserted_m - i * element_m) * direction_;
        rod.velocity[i] = speed_m_s * direction_;
    }
    // The third axis of each segment points out of the vessel.
    const Quaternion turned =
        unturned_ * Quaternion(std::cos(0.5 * turn_rad), 0.0, 0.0, -std::sin(0.5 * turn_rad));
    for (int j = rod.free_count; j < rod.properties.element_count; j++) rod.orientation[j] = turned;
}

} // namespace vcsim3
