// A picture's worth of the tools: what effects and X-ray see of the core at one tick.
// SI units in Eigen doubles; filled by host/model from bytes, never from the core directly.
#pragma once
#include <Eigen/Core>
#include <cstdint>
#include <vector>

namespace crn
{

struct WireNode {
    Eigen::Vector3d position_m;      // patient frame: +x left, +y head, +z anterior
    double arc_m = 0.0;              // rest arc length from the leading tip
    double radius_m = 0.0;           // outer radius of the outermost tool there
    double depth_m = 0.0;            // contact depth, > 0 in contact (0 when unknown)
    double contrast_mg_per_ml = 0.0; // iodine in the blood around
};

struct WireFrame {
    std::uint32_t tick = 0;
    std::uint32_t heart_phase32 = 0, breath_phase32 = 0; // 2^-32 cycle: docs/heart.md
    std::vector<WireNode>
        nodes{}; // node 0 is the leading tip; only those beyond the inserter and the first inside it
    // Where on the line each tool's own tip lies, from the innermost tool; the leading one's is 0. A tool
    // covers the line from there to the last node. Empty: one tool from node 0.
    std::vector<double> tip_arc_m{};
    // The balloon of one of the tools: radii of its balls, `balloon_arc_m` from the leading tip on,
    // `balloon_spacing_m` apart. Empty: none.
    std::vector<double> balloon_radii_m{};
    double balloon_arc_m = 0.0, balloon_spacing_m = 0.0;
    // How far lesions that give way are open, 0 .. 1, station by station, lesion by lesion (docs/lesions.md).
    std::vector<double> lesions_open{};
};

} // namespace crn
