// Computes the contact of mass points with a rigid wall. Contact is detected once per step, and it changes
// the velocities after every iteration of the distance constraints.
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

// Lists, in the order of nodes, the free nodes at which the rod's surface reaches into the wall.
void find_contacts(const Rod &rod, const Wall &wall, std::vector<Contact> &contacts);

// Raises the inward velocity of each touching node to baumgarte depth / h, if it is lower. Friction then
// reduces the node's tangential velocity by at most `friction` times this change.
void answer_contacts(Rod &rod, const std::vector<Contact> &contacts, double baumgarte, double step_s);

} // namespace vcsim3
