// Wire messages -> WireFrame in SI units: what picture and effects see of the tools at a tick.
// May include: shared/wire, units, instrument. Called by: host/app, host/xray's callers.
#pragma once
#include "host/model/instrument.hpp"
#include "host/model/wire_frame.hpp"
#include "shared/wire/wire.h"
#include <span>

namespace seld
{

// `tools` from the innermost. Nodes that the table does not know (a device that lies) are dropped.
WireFrame wire_frame(const seld_wire_nodes &nodes, const seld_wire_node_table &table,
                     std::span<const Instrument> tools);

// Outer radius of a tool, `arc_m` from its own tip: linear between knots, constant beyond the ends.
double outer_radius_m(const seld_wire_instrument &tool, double arc_m);

} // namespace seld
