#include "tools/lab/vcsim3/collision.hpp"
#include <algorithm>

namespace vcsim3
{

void find_contacts(const Rod &rod, const Wall &wall, std::vector<Contact> &contacts)
{
    contacts.clear();
    for (int i = 0; i < std::min(rod.free_count, rod.node_count()); i++) {
        const LumenSample sample = wall(rod.position[i]);
        const double depth_m = sample.distance_m + rod.properties.radius_m;
        if (depth_m > 0.0) contacts.push_back({i, sample.inward, depth_m});
    }
}

void answer_contacts(Rod &rod, const std::vector<Contact> &contacts, double baumgarte, double step_s)
{
    for (const Contact &contact : contacts) {
        Vector &velocity = rod.velocity[contact.node];
        const double inward = contact.inward.dot(velocity);
        const double lacking = baumgarte * contact.depth_m / step_s - inward;
        if (lacking <= 0.0) continue;
        const Vector tangential = velocity - inward * contact.inward;
        const double slip = tangential.norm();
        const double brake = slip > 0.0 ? std::min(1.0, rod.properties.friction * lacking / slip) : 0.0;
        velocity += lacking * contact.inward - brake * tangential;
    }
}

} // namespace vcsim3
