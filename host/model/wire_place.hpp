// Computes positions between the nodes of the tools' common centreline.
#pragma once
#include "host/model/wire_frame.hpp"
#include <algorithm>
#include <cstddef>

namespace crn
{

// Returns the position at an arc length from the leading tip; beyond both ends the centreline continues
// straight. The line needs two nodes.
inline Eigen::Vector3d line_place_m(const WireFrame &wire, double arc_m)
{
    const std::vector<WireNode> &nodes = wire.nodes;
    const auto after = std::upper_bound(nodes.begin(), nodes.end(), arc_m,
                                        [](double arc, const WireNode &node) { return arc < node.arc_m; });
    const auto i = static_cast<std::size_t>(
        std::clamp<std::ptrdiff_t>(after - nodes.begin(), 1, static_cast<std::ptrdiff_t>(nodes.size()) - 1));
    const WireNode &a = nodes[i - 1], &b = nodes[i];
    const double share = b.arc_m > a.arc_m ? (arc_m - a.arc_m) / (b.arc_m - a.arc_m) : 0.0;
    return a.position_m + share * (b.position_m - a.position_m);
}

} // namespace crn
