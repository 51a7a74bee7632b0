// Contact of mass points with a rigid wall: found once per step, answered on velocities after every distance
// iteration.
#pragma once
#include "tools/lab/vcsim3/lumen.hpp"
#include "tools/lab/vcsim3/rod.hpp"
#include <functional>

namespace vcsim3
{

using Wall = std::function<LumenSample(const Vector &)>;

struct Contact {
    int node;
    Vector inward;
    double depth_m; // > 0
};

// Free nodes deeper than the wall by the rod's radius. Order: by node.
void find_contacts(const Rod &rod, const Wall &wall, std::vector<Contact> &contacts);

// Each touching node gets the inward velocity it lacks, baumgarte depth / h, and loses at most `friction`
// times that of its tangential velocity.
void answer_contacts(Rod &rod, const std::vector<Contact> &contacts, double baumgarte, double step_s);

} // namespace vcsim3
