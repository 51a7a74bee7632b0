#include "tools/lab/ct/arteries/mask.hpp"
#include <Eigen/Core>
#include <utility>

namespace crn::ct
{

Neighbours::Neighbours(const Volume &grid) : all{}, size(grid.size)
{
    const std::ptrdiff_t nx = size[0], plane = nx * size[1];
    std::size_t n = 0;
    for (int k = -1; k <= 1; ++k)
        for (int j = -1; j <= 1; ++j)
            for (int i = -1; i <= 1; ++i)
                if (i != 0 || j != 0 || k != 0)
                    all[n++] = {i, j, k, i + nx * j + plane * k,
                                Eigen::Vector3d(i, j, k).cwiseProduct(grid.spacing_mm).norm()};
}

namespace
{

// Marks what is connected with the start over the neighbours that `each(voxel, use)` gives.
template <class Each>
std::size_t flood_over(const Each &each, Mask &mask, std::vector<std::size_t> queue, unsigned char from,
                       unsigned char mark)
{
    std::size_t count = 0;
    for (std::size_t start : queue) mask[start] = mark;
    while (!queue.empty()) {
        const std::size_t at = queue.back();
        queue.pop_back();
        ++count;
        each(at, [&](std::size_t next) {
            if (mask[next] != from) return;
            mask[next] = mark;
            queue.push_back(next);
        });
    }
    return count;
}

} // namespace

std::size_t flood(const Volume &grid, Mask &mask, std::vector<std::size_t> queue, unsigned char from,
                  unsigned char mark)
{
    return flood_over([&](std::size_t at, const auto &use) { for_neighbours(grid, at, use); }, mask,
                      std::move(queue), from, mark);
}

std::size_t flood_diagonally(const Volume &grid, Mask &mask, std::vector<std::size_t> queue,
                             unsigned char from, unsigned char mark)
{
    const Neighbours neighbours(grid);
    const auto each = [&](std::size_t at, const auto &use) {
        neighbours.each(at, [&](std::size_t next, std::size_t) { use(next); });
    };
    return flood_over(each, mask, std::move(queue), from, mark);
}

void keep_largest(const Volume &grid, Mask &mask)
{
    enum : unsigned char { none, wanted, tried, kept };
    std::size_t largest = 0, start = 0;
    for (std::size_t at = 0; at < mask.size(); ++at) {
        if (mask[at] != wanted) continue;
        const std::size_t count = flood_diagonally(grid, mask, {at}, wanted, tried);
        if (count > largest) largest = count, start = at;
    }
    if (largest > 0) flood_diagonally(grid, mask, {start}, tried, kept);
    for (unsigned char &value : mask) value = value == kept;
}

Mask grown(const Volume &grid, Mask wanted, int rounds)
{
    for (int round = 0; round < rounds; ++round) {
        Mask next = wanted;
        for (std::size_t at = 0; at < wanted.size(); ++at)
            if (wanted[at]) for_neighbours(grid, at, [&](std::size_t neighbour) { next[neighbour] = 1; });
        wanted = std::move(next);
    }
    return wanted;
}

void keep_pieces(const Volume &grid, Pieces wanted, double limit_mm3, Mask &mask)
{
    enum : unsigned char { out, unknown, small, large };
    for (std::size_t at = 0; at < mask.size(); ++at) {
        if (mask[at] != unknown) continue;
        const std::size_t count = flood(grid, mask, {at}, unknown, small);
        if (static_cast<double>(count) * grid.spacing_mm.prod() > limit_mm3)
            flood(grid, mask, {at}, small, large);
    }
    const unsigned char kept = wanted == Pieces::large ? large : small;
    for (unsigned char &value : mask) value = value == kept;
}

} // namespace crn::ct
