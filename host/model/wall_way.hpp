// Tells where the tools have pushed a vessel aside, and where they would lie in the vessel at rest
// (docs/walls.md).
#pragma once
#include "host/model/wire_frame.hpp"
#include <algorithm>

namespace crn
{

// Returns the displacement of the vessel at an arc length from the leading tip, linear between stations.
inline WallWay wall_way(const WireFrame &wire, double arc_m)
{
    const double at = std::max(arc_m, 0.0) / wall_spacing_m;
    const auto station = static_cast<std::size_t>(at);
    if (station >= wire.walls.size()) return {};
    const WallWay &here = wire.walls[station];
    const WallWay next = station + 1 < wire.walls.size() ? wire.walls[station + 1] : WallWay{};
    const double share = at - static_cast<double>(station);
    return {here.way_m + share * (next.way_m - here.way_m),
            here.widened_m + share * (next.widened_m - here.widened_m)};
}

// Returns the frame with each node where it would be if the vessel had not given way.
inline WireFrame at_rest(const WireFrame &wire)
{
    WireFrame rest = wire;
    if (wire.walls.empty()) return rest;
    for (WireNode &node : rest.nodes) node.position_m -= wall_way(wire, node.arc_m).way_m;
    rest.walls.clear();
    return rest;
}

} // namespace crn
