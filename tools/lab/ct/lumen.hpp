// Finds the lumen of a phantom in a scan; the lumen is the space around the instrument up to the wall
// (docs/ct.md, "The lumen").
#pragma once
#include "tools/lab/ct/centreline.hpp"
#include "tools/lab/ct/snake.hpp"

namespace crn::ct
{

// Within `streak_mm` of the instrument's centreline, values that are impossible for fluid and silicone are
// treated as streaks.
inline constexpr double streak_mm = 9.0;

struct LumenOptions {
    double smooth_mm = 0.5;      // smoothing of the picture before edges are searched
    double masked_mm = 2.2;      // around the line: the region that metal hides
    double instrument_mm = 0.65; // radius around the line that always belongs to the lumen: a wire of 0.9 mm
                                 // and a third of a voxel
    double fluid_HU = -2000;     // below -1500: use the most frequent value around the instrument
    double contrast_HU = 0;      // of the wall against the fluid; 0: as found
    SnakeWeights snake{0.0, 0.15, 0.5, 15};
};

// Holds one scan of the phantom, and the centrelines of the parts of the instrument that hide the phantom in
// this scan.
struct LumenScan {
    const Volume *volume;
    std::vector<Eigen::Vector3d> line;   // the part of the instrument that lies in the lumen
    std::vector<Eigen::Vector3d> behind; // the rest of the instrument, which hides the wall too; may be empty
};

struct Lumen {
    // All volumes of the struct cover only the part of the scan that surrounds the lumen.
    Volume level;    // mm from the wall, negative inside
    Volume restored; // the merged scans without the instrument, smoothed
    Volume hidden;   // 1 where metal hid the voxel in all scans, else 0
    Volume speed;    // of the snake
    Volume first;    // the level before the snake
    double fluid_HU = 0, wall_HU = 0, edge_HU = 0,
           edge_HU_per_mm = 0; // edge: the value and slope at the wall's surface
    std::vector<std::string> notes;
};

// The scans show one phantom at one position, each with the instrument at another depth. Where metal or
// streaks hide the phantom in one scan, the function uses the other scans. Throws Fault if the centreline is
// not surrounded by a space with a wall.
Lumen find_lumen(const std::vector<LumenScan> &scans, const LumenOptions &options, const Report &report);

// --- parts, for tests ---

// Holds one picture that is merged from all scans and does not show the instrument, on the grid of the first
// scan.
struct Merged {
    Volume filled;   // hidden voxels are filled from their surroundings
    Volume distance; // distance from the nearest line in the lumen, cut off
    Volume hidden;   // 1 where no scan shows the voxel
};
Merged merge_scans(const std::vector<LumenScan> &scans, double masked_mm, double fluid_HU);
// Fills hidden voxels from the voxels around them by Laplace's equation; the iteration starts from the value
// `start`.
void fill_in(Volume &volume, const std::vector<std::size_t> &hidden, double start);
// Returns the distance of every voxel from a polyline; distances above `reach_mm` are set to `reach_mm`.
Volume distance_volume(const Volume &grid, const std::vector<Eigen::Vector3d> &line, double reach_mm);

} // namespace crn::ct
