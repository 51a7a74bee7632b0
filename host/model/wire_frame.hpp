// A picture's worth of instrument state: what effects and X-ray see of the core at one tick.
// SI units in Eigen doubles; filled by host/model from bytes, never from the core directly.
#pragma once
#include <Eigen/Core>
#include <cstdint>
#include <vector>

namespace seld
{

struct WireNode {
    Eigen::Vector3d position_m; // patient frame: +x left, +y head, +z anterior
    double arc_m = 0.0;         // rest arc length from the distal tip
    double radius_m = 0.0;      // outer radius
    double depth_m = 0.0;       // contact depth, > 0 in contact (0 when unknown)
};

struct WireFrame {
    std::uint32_t tick = 0;
    std::vector<WireNode>
        nodes; // node 0 is the tip; only nodes beyond the inserter and the first one inside it
};

} // namespace seld
