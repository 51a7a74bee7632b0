// Grows arteries through the bright voxels of a CT, in competition with bones (docs/own_ct.md, "Arteries
// without a label map").
//
//     aorta ====\            A voxel's width is its distance from the dark voxels. A path is as wide as its
//     ======\    \==== wide  narrowest voxel, its neck. Each voxel belongs to the source from which the widest
//     neck   \===            path comes. Where it is much wider behind a neck, the path has left the artery.
#pragma once
#include "tools/lab/ct/arteries/mask.hpp"
#include <cstdint>

namespace crn::ct
{

// Widths in units of 0.05 mm.
using Widths = std::vector<std::uint16_t>;
constexpr double width_unit_mm = 0.05;
constexpr std::uint16_t width_most = 1600; // 80 mm: wider than any vessel

// The distance of each voxel of the mask from the middle of the nearest voxel outside it, by a chamfer
// transform over 26 neighbours. What lies beyond the grid counts as inside.
Widths widths_in(const Volume &grid, const Mask &inside);

enum class Side : unsigned char { none, artery, other };

struct Growth {
    Mask side;                        // of the enum Side
    Widths neck;                      // of the path to the voxel
    std::vector<signed char> from;    // the neighbour from which the path comes, 0 to 25; -1: a source
    std::vector<std::uint32_t> order; // voxels of arteries, as the paths reached them

    bool is_artery(std::size_t at) const { return side[at] == static_cast<unsigned char>(Side::artery); }
};

struct Source {
    std::size_t at;
    std::uint16_t width; // of the paths that begin here
};

// Grows from both sides through the mask. For the other side, a voxel that is shaped like a thin artery is
// half as wide: a bone that touches an artery does not claim it.
Growth grow_apart(const Volume &grid, const Mask &inside, const Widths &widths, const Mask &tubes,
                  const std::vector<Source> &artery, const std::vector<Source> &other);

// A region is wide if its width is more than `factor` times the neck and `more_mm`.
struct Leak {
    double factor = 1.5, more_mm = 1.0;
};

// Takes from the arteries what lies behind a neck that leads to a wide region, and what lies behind a gate.
// Returns the mask of what was taken.
Mask cut_leaks(const Volume &grid, const Widths &widths, const std::vector<std::size_t> &gates,
               const Leak &leak, Growth &growth);

// The voxels of the path from a source to the voxel, backwards.
std::vector<std::size_t> path_to(const Volume &grid, const Growth &growth, std::size_t at);

} // namespace crn::ct
