// May include: inserter.hpp. Called by: simulation, tests.
#include "tools/vcsim3/inserter.hpp"

namespace vcsim3
{

Rod Inserter::make_rod(const RodProperties &properties, double inserted_m) const
{
    Rod rod(properties, mouth_m_ + inserted_m * direction_, -direction_);
    rod.free_count = 0;
    feed(rod, inserted_m, 0.0);
    return rod;
}

void Inserter::feed(Rod &rod, double inserted_m, double speed_m_s) const
{
    const double element_m = rod.properties.element_m;
    while (rod.free_count < rod.node_count() && rod.free_count * element_m < inserted_m) rod.free_count++;
    for (int i = rod.free_count; i < rod.node_count(); i++) {
        rod.position[i] = mouth_m_ + (inserted_m - i * element_m) * direction_;
        rod.velocity[i] = speed_m_s * direction_;
    }
}

} // namespace vcsim3
