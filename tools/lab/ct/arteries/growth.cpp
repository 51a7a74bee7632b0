#include "tools/lab/ct/arteries/growth.hpp"
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace crn::ct
{

namespace
{

// The voxel from which the path to this one comes.
std::size_t before(const Neighbours &neighbours, const Growth &growth, std::size_t at)
{
    return static_cast<std::size_t>(static_cast<std::ptrdiff_t>(at) +
                                    neighbours.all[static_cast<std::size_t>(growth.from[at])].step);
}

// A queue by widths: the widest first, and among equals the first that came.
class WidestFirst
{
  public:
    WidestFirst() : rows_(std::size_t{width_most} + 1) {}
    void push(std::uint16_t width, std::uint32_t at)
    {
        rows_[width].push_back(at);
        highest_ = std::max<int>(highest_, width);
    }
    // Returns false when the queue is empty.
    bool pop(std::uint16_t &width, std::uint32_t &at)
    {
        while (highest_ >= 0 && heads_[static_cast<std::size_t>(highest_)] ==
                                    rows_[static_cast<std::size_t>(highest_)].size()) {
            std::vector<std::uint32_t>().swap(rows_[static_cast<std::size_t>(highest_)]);
            heads_[static_cast<std::size_t>(highest_)] = 0;
            --highest_;
        }
        if (highest_ < 0) return false;
        width = static_cast<std::uint16_t>(highest_);
        at = rows_[width][heads_[width]++];
        return true;
    }

  private:
    std::vector<std::vector<std::uint32_t>> rows_;
    std::array<std::size_t, std::size_t{width_most} + 1> heads_{};
    int highest_ = -1;
};

} // namespace

Widths widths_in(const Volume &grid, const Mask &inside)
{
    const Neighbours neighbours(grid);
    std::array<int, 26> steps{};
    for (std::size_t n = 0; n < steps.size(); ++n)
        steps[n] = static_cast<int>(std::lround(neighbours.all[n].mm / width_unit_mm));
    Widths widths(grid.count());
    for (std::size_t at = 0; at < widths.size(); ++at) widths[at] = inside[at] ? width_most : 0;
    const auto lower = [&](std::size_t at, std::size_t first, std::size_t last) {
        if (widths[at] == 0) return;
        int least = widths[at];
        neighbours.each(at, [&](std::size_t other, std::size_t n) {
            if (n >= first && n < last) least = std::min(least, widths[other] + steps[n]);
        });
        widths[at] = static_cast<std::uint16_t>(least);
    };
    for (std::size_t at = 0; at < widths.size(); ++at) lower(at, 0, 13);
    for (std::size_t at = widths.size(); at-- > 0;) lower(at, 13, 26);
    return widths;
}

Growth grow_apart(const Volume &grid, const Mask &inside, const Widths &widths, const Mask &tubes,
                  const std::vector<Source> &artery, const std::vector<Source> &other)
{
    const Neighbours neighbours(grid);
    Growth growth{
        Mask(grid.count(), 0), Widths(grid.count(), 0), std::vector<signed char>(grid.count(), -1), {}};
    Mask done(grid.count(), 0);
    WidestFirst queue;
    const auto begin = [&](const Source &source, Side side) {
        if (!inside[source.at] || source.width <= growth.neck[source.at]) return;
        growth.side[source.at] = static_cast<unsigned char>(side);
        growth.neck[source.at] = source.width;
        queue.push(source.width, static_cast<std::uint32_t>(source.at));
    };
    for (const Source &source : other) begin(source, Side::other);
    for (const Source &source : artery) begin(source, Side::artery);
    std::uint16_t width = 0;
    std::uint32_t at = 0;
    while (queue.pop(width, at)) {
        if (done[at] || growth.neck[at] != width) continue;
        done[at] = 1;
        if (growth.is_artery(at)) growth.order.push_back(at);
        neighbours.each(at, [&](std::size_t next, std::size_t n) {
            if (!inside[next] || done[next]) return;
            const bool is_foreign = tubes[next] && !growth.is_artery(at);
            const std::uint16_t neck = std::min<std::uint16_t>(
                width, static_cast<std::uint16_t>(widths[next] / (is_foreign ? 2 : 1)));
            if (neck <= growth.neck[next]) return;
            growth.neck[next] = neck;
            growth.side[next] = growth.side[at];
            growth.from[next] = static_cast<signed char>(25 - n);
            queue.push(neck, static_cast<std::uint32_t>(next));
        });
    }
    return growth;
}

Mask cut_leaks(const Volume &grid, const Widths &widths, const std::vector<std::size_t> &gates,
               const Leak &leak, Growth &growth)
{
    enum : unsigned char { kept, seen, taken };
    const Neighbours neighbours(grid);
    const double more = leak.more_mm / width_unit_mm;
    Mask mark(grid.count(), kept);
    for (const std::size_t gate : gates) mark[gate] = taken;
    for (const std::uint32_t wide : growth.order) {
        if (mark[wide] != kept || widths[wide] <= leak.factor * growth.neck[wide] + more) continue;
        // The neck is the last narrow place on the path to the wide region.
        const double narrow = 1.2 * growth.neck[wide] + 1;
        std::size_t at = wide;
        while (growth.from[at] >= 0 && mark[at] == kept && widths[at] > narrow) {
            mark[at] = seen;
            at = before(neighbours, growth, at);
        }
        if (mark[at] == kept) mark[at] = taken;
    }
    Mask leaks(grid.count(), 0);
    for (const std::uint32_t at : growth.order) { // every path comes before what it leads to
        if (mark[at] != taken && (growth.from[at] < 0 || !leaks[before(neighbours, growth, at)])) continue;
        leaks[at] = 1;
        growth.side[at] = static_cast<unsigned char>(Side::none);
    }
    growth.order.erase(std::remove_if(growth.order.begin(), growth.order.end(),
                                      [&](std::uint32_t at) { return leaks[at] != 0; }),
                       growth.order.end());
    return leaks;
}

std::vector<std::size_t> path_to(const Volume &grid, const Growth &growth, std::size_t at)
{
    const Neighbours neighbours(grid);
    std::vector<std::size_t> path{at};
    while (growth.from[at] >= 0) path.push_back(at = before(neighbours, growth, at));
    return path;
}

} // namespace crn::ct
