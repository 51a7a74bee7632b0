// Works on masks: one byte for each voxel of a grid.
#pragma once
#include "tools/lab/ct/volume/volume.hpp"
#include <array>

namespace crn::ct
{

using Mask = std::vector<unsigned char>;

// The number of the slice in which a voxel lies.
inline int slice_of(const Volume &grid, std::size_t at)
{
    return static_cast<int>(
        at / (static_cast<std::size_t>(grid.size[0]) * static_cast<std::size_t>(grid.size[1])));
}

// The middle of a voxel in the scene's axes.
inline Eigen::Vector3d place_at(const Volume &grid, std::size_t at)
{
    const auto nx = static_cast<std::size_t>(grid.size[0]), ny = static_cast<std::size_t>(grid.size[1]);
    return grid.scene({static_cast<double>(at % nx), static_cast<double>(at / nx % ny),
                       static_cast<double>(at / (nx * ny))});
}

// Calls work(neighbour) for the six neighbours of a voxel.
template <class Work> void for_neighbours(const Volume &grid, std::size_t at, const Work &work)
{
    const auto nx = static_cast<std::size_t>(grid.size[0]),
               plane = nx * static_cast<std::size_t>(grid.size[1]);
    const std::size_t i = at % nx, j = at / nx % static_cast<std::size_t>(grid.size[1]), k = at / plane;
    if (i > 0) work(at - 1);
    if (i + 1 < nx) work(at + 1);
    if (j > 0) work(at - nx);
    if (j + 1 < static_cast<std::size_t>(grid.size[1])) work(at + nx);
    if (k > 0) work(at - plane);
    if (k + 1 < static_cast<std::size_t>(grid.size[2])) work(at + plane);
}

// The 26 neighbours of a voxel; number 25 - n is opposite to number n.
struct Neighbours {
    struct One {
        int i, j, k;
        std::ptrdiff_t step;
        double mm;
    };
    std::array<One, 26> all;
    std::array<int, 3> size;

    explicit Neighbours(const Volume &grid);
    // Calls use(neighbour, number) for those of the grid.
    template <class Use> void each(std::size_t at, const Use &use) const
    {
        const auto nx = static_cast<std::size_t>(size[0]), ny = static_cast<std::size_t>(size[1]);
        const int i = static_cast<int>(at % nx), j = static_cast<int>(at / nx % ny),
                  k = static_cast<int>(at / (nx * ny));
        for (std::size_t n = 0; n < all.size(); ++n) {
            const One &one = all[n];
            const int x = i + one.i, y = j + one.j, z = k + one.k;
            if (x < 0 || y < 0 || z < 0 || x >= size[0] || y >= size[1] || z >= size[2]) continue;
            use(static_cast<std::size_t>(static_cast<std::ptrdiff_t>(at) + one.step), n);
        }
    }
};

// Marks with `mark` all voxels of value `from` that are connected to the start. Returns their number.
std::size_t flood(const Volume &grid, Mask &mask, std::vector<std::size_t> queue, unsigned char from,
                  unsigned char mark);
// The same over all 26 neighbours: thin vessels go diagonally.
std::size_t flood_diagonally(const Volume &grid, Mask &mask, std::vector<std::size_t> queue,
                             unsigned char from, unsigned char mark);
// Keeps only the largest piece of the voxels that are 1.
void keep_largest(const Volume &grid, Mask &mask);

// Marks each voxel of `wanted` and, `rounds` times, the neighbours of those marked.
Mask grown(const Volume &grid, Mask wanted, int rounds);

// Keeps only the connected pieces of a mask that are larger than a volume, or only the others.
enum class Pieces { large, small };
void keep_pieces(const Volume &grid, Pieces wanted, double limit_mm3, Mask &mask);

} // namespace crn::ct
