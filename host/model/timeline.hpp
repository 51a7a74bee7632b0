// Converts messages of the byte protocol to a WireFrame in SI units, which describes the tools at one tick
// for pictures and effects.
#pragma once
#include "host/model/instrument.hpp"
#include "host/model/wire_frame.hpp"
#include "shared/wire/wire.h"
#include <span>

namespace crn
{

// `tools` lists the nested tools from the innermost outwards. The conversion drops nodes that are missing
// from the node table; only a faulty device sends such nodes.
WireFrame wire_frame(const crn_wire_nodes &nodes, const crn_wire_node_table &table,
                     std::span<const Instrument> tools);

// Returns the outer radius of a tool at `arc_m` from its own tip: linear between knots, constant beyond the
// ends.
double outer_radius_m(const crn_wire_instrument &tool, double arc_m);

} // namespace crn
