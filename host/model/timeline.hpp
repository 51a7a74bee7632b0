// Wire messages -> WireFrame in SI units: what picture and effects see of the instrument at a tick.
// May include: shared/wire, units. Called by: host/app, host/xray's callers.
#pragma once
#include "host/model/wire_frame.hpp"
#include "shared/wire/wire.h"

namespace seld
{

// Nodes that the table does not know (a device that lies) are dropped.
WireFrame wire_frame(const seld_wire_nodes &nodes, const seld_wire_node_table &table);

} // namespace seld
