// Describes the tools at one tick, for one picture; the code for effects and X-ray receives no other data
// from the core. Lengths in the WireFrame are Eigen doubles in SI units. host/model fills the WireFrame from
// received bytes, never from the core's memory.
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
    double contrast_mg_per_ml = 0.0; // iodine in the surrounding blood
};

// How far the tools have pushed a vessel's wall aside at one station, and how much its radius has grown.
struct WallWay {
    Eigen::Vector3d way_m = Eigen::Vector3d::Zero();
    double widened_m = 0.0;
};

inline constexpr double wall_spacing_m = 0.0078125; // of the stations, along the tools

struct WireFrame {
    std::uint32_t tick = 0;
    std::uint32_t heart_phase32 = 0, breath_phase32 = 0; // 2^-32 cycle: docs/heart.md
    std::vector<WireNode>
        nodes{}; // node 0 is the leading tip; only nodes beyond the introducer and the first one inside it
    // Holds, for each tool from the innermost outwards, the arc length of its own tip, measured from the
    // leading tip. A tool covers the common centreline from the tool's tip to the last node. If the list
    // tip_arc_m is empty, there is one tool, which begins at node 0.
    std::vector<double> tip_arc_m{};
    // The next members describe the balloon of one of the tools as a row of balls (spheres), beginning with
    // the balls' radii. The first ball of the balloon is at `balloon_arc_m` from the leading tip, and
    // neighbouring balls are `balloon_spacing_m` apart. The list of radii is empty if no tool has a balloon.
    std::vector<double> balloon_radii_m{};
    double balloon_arc_m = 0.0, balloon_spacing_m = 0.0;
    // Holds the opening, 0 to 1, of each station (point) of each lesion that a balloon can open, lesion after
    // lesion (docs/lesions.md).
    std::vector<double> lesions_open{};
    // The displacement of the vessel by the tools at stations `wall_spacing_m` apart, from the leading tip
    // (docs/walls.md). The list is empty while the vessel is at rest.
    std::vector<WallWay> walls{};
};

} // namespace crn
