// The phantom's lumen in a scan: the space around the instrument up to the wall (docs/ct.md, "The lumen").
#pragma once
#include "tools/lab/ct/centreline.hpp"
#include "tools/lab/ct/snake.hpp"

namespace crn::ct
{

// So far from the line, values that neither fluid nor silicone has are taken for streaks.
inline constexpr double streak_mm = 9.0;

struct LumenOptions {
    double smooth_mm = 0.5; // of the picture before edges are looked for
    double masked_mm = 2.2; // around the line: what metal hides
    double instrument_mm =
        0.65; // radius that is inside the lumen wherever the line is: a wire of 0.9 mm and a third of a voxel
    double fluid_HU = -2000; // below -1500: the commonest value around the instrument
    double contrast_HU = 0;  // of the wall against the fluid; 0: as found
    SnakeWeights snake{0.0, 0.15, 0.5, 15};
};

// One of the scans in which the phantom lies, with what the instrument hides there.
struct LumenScan {
    const Volume *volume;
    std::vector<Eigen::Vector3d> line;   // the instrument's part that lies in the lumen
    std::vector<Eigen::Vector3d> behind; // what else of it there is, which hides the wall too; or nothing
};

struct Lumen {
    // All of the part of the volume around the lumen.
    Volume level;    // mm from the wall, negative inside
    Volume restored; // the scans with the instrument taken out, smoothed
    Volume hidden;   // 1 where metal hid it in all scans, else 0
    Volume speed;    // the snake's
    Volume first;    // the level before the snake
    double fluid_HU = 0, wall_HU = 0, edge_HU = 0, edge_HU_per_mm = 0; // edge: where the wall's surface is
    std::vector<std::string> notes;
};

// The scans show the same phantom at the same place, each with the instrument elsewhere: what metal or
// streaks hide in one is taken from the others. Throws Fault where no space with a wall is around the line.
Lumen find_lumen(const std::vector<LumenScan> &scans, const LumenOptions &options, const Report &report);

// --- parts, for tests
// --------------------------------------------------------------------------------------------------- One
// picture of all scans, without the instrument, on the first one's grid.
struct Merged {
    Volume filled;   // where nothing was seen, what is around it
    Volume distance; // of the nearest line in the lumen, cut off
    Volume hidden;   // 1 where nothing was seen
};
Merged merge_scans(const std::vector<LumenScan> &scans, double masked_mm, double fluid_HU);
// Hidden voxels get the values of what is around them (Laplace's equation, from `start`).
void fill_in(Volume &volume, const std::vector<std::size_t> &hidden, double start);
// Distance of every voxel from a line, cut off at `reach_mm`.
Volume distance_volume(const Volume &grid, const std::vector<Eigen::Vector3d> &line, double reach_mm);

} // namespace crn::ct
