// Wire messages -> WireFrame in SI units: what picture and effects see of the tools at a tick.
#pragma once
#include "host/model/instrument.hpp"
#include "host/model/wire_frame.hpp"
#include "shared/wire/wire.h"
#include <span>

namespace crn
{

// `tools` from the innermost. Nodes that the table does not know (a device that lies) are dropped.
WireFrame wire_frame(const crn_wire_nodes &nodes, const crn_wire_node_table &table,
                     std::span<const Instrument> tools);

// Outer radius of a tool, `arc_m` from its own tip: linear between knots, constant beyond the ends.
double outer_radius_m(const crn_wire_instrument &tool, double arc_m);

} // namespace crn
