// Computes the contact of the rod's mass points with a rigid wall. The program detects contact once per step.
// The contacts change the velocities after every iteration of the distance constraints.
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

// Lists, in the order of the nodes, those free nodes at which the rod's surface reaches into the wall.
void find_contacts(const Rod &rod, const Wall &wall, std::vector<Contact> &contacts);

// Raises the inward velocity of each node in contact to at least baumgarte * depth / h, where h is the time
// step. After the normal impulse, friction reduces the node's tangential velocity by at most `friction` times
// the change of its inward velocity.
void answer_contacts(Rod &rod, const std::vector<Contact> &contacts, double baumgarte, double step_s);

} // namespace vcsim3
