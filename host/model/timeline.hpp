// Converts messages of the byte protocol to a WireFrame in SI units, which describes the tools at a tick for
// pictures and effects.
#pragma once
#include "host/model/instrument.hpp"
#include "host/model/wire_frame.hpp"
#include "shared/wire/wire.h"
#include <span>

namespace crn
{

// `tools` are given from the innermost out. Nodes that are missing from the table, which a faulty device may
// send, are dropped.
WireFrame wire_frame(const crn_wire_nodes &nodes, const crn_wire_node_table &table,
                     std::span<const Instrument> tools);

// Returns the outer radius of a tool at `arc_m` from its own tip: linear between knots, constant beyond the
// ends.
double outer_radius_m(const crn_wire_instrument &tool, double arc_m);

} // namespace crn
