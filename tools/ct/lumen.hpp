// The phantom's lumen in a scan: the space around the instrument up to the wall (docs/ct.md, "The lumen").
// May include: volume, snake, centreline. Called by: segment, tests.
#pragma once
#include "tools/ct/centreline.hpp"
#include "tools/ct/snake.hpp"

namespace seld::ct
{

struct LumenOptions {
    double smooth_mm = 0.5;      // of the picture before edges are looked for
    double masked_mm = 2.2;      // around the line: what metal hides
    double instrument_mm = 0.35; // radius that is inside the lumen wherever the line is
    double fluid_HU = -2000;     // below -1500: the commonest value around the instrument
    double contrast_HU = 0;      // of the wall against the fluid; 0: as found
    SnakeWeights snake{0.0, 0.15, 0.5, 15};
};

struct Lumen {
    // All of the part of the volume around the lumen.
    Volume level;    // mm from the wall, negative inside
    Volume restored; // the scan with the instrument taken out, smoothed
    Volume speed;    // the snake's
    Volume first;    // the level before the snake
    double fluid_HU = 0, wall_HU = 0, edge_HU = 0, edge_HU_per_mm = 0; // edge: where the wall's surface is
    std::vector<std::string> notes;
};

// `line`: the instrument's part that lies in the lumen; `behind`: what else of it there is, which hides the wall too (or nothing).
// Throws Fault where no space with a wall is around the line.
Lumen find_lumen(const Volume &volume, const std::vector<Eigen::Vector3d> &line,
                 const std::vector<Eigen::Vector3d> &behind, const LumenOptions &options,
                 const Report &report);

// Hidden voxels get the values of what is around them (Laplace's equation, from `start`).
void fill_in(Volume &volume, const std::vector<std::size_t> &hidden, double start);
// Distance of every voxel from a line, cut off at `reach_mm`.
Volume distance_volume(const Volume &grid, const std::vector<Eigen::Vector3d> &line, double reach_mm);

} // namespace seld::ct
