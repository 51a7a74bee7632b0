// Contact of mass points with a rigid wall. It is detected once per step and resolved on velocities after
// every distance iteration.
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

// Lists the free nodes that are deeper than the wall by the rod's radius, in the order of nodes.
void find_contacts(const Rod &rod, const Wall &wall, std::vector<Contact> &contacts);

// Gives each touching node the inward velocity that it lacks, baumgarte depth / h. The node loses at most
// `friction` times that of its tangential velocity.
void answer_contacts(Rod &rod, const std::vector<Contact> &contacts, double baumgarte, double step_s);

} // namespace vcsim3
