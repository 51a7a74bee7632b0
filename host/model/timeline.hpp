// Converts wire messages to a WireFrame in SI units: the tools at a tick for pictures and effects.
#pragma once
#include "host/model/instrument.hpp"
#include "host/model/wire_frame.hpp"
#include "shared/wire/wire.h"
#include <span>

namespace crn
{

// `tools` are given from the innermost out. Nodes that the table does not have (from a faulty device) are
// dropped.
WireFrame wire_frame(const crn_wire_nodes &nodes, const crn_wire_node_table &table,
                     std::span<const Instrument> tools);

// Returns the outer radius of a tool, `arc_m` from its own tip: linear between knots, constant beyond the
// ends.
double outer_radius_m(const crn_wire_instrument &tool, double arc_m);

} // namespace crn
