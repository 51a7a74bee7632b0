#include "tools/lab/ct/arteries/trace.hpp"
#include "host/base/format.hpp"
#include "tools/lab/ct/arteries/repair.hpp"
#include <algorithm>
#include <cmath>
#include <optional>
#include <queue>
#include <unordered_map>
#include <unordered_set>

namespace crn::ct
{

namespace
{

using Eigen::Vector3d;

// The price of a millimetre. Inside a tube it is 1.
constexpr double beside_tube = 3.0, in_bone = 8.0, in_dark = 8.0;
constexpr double bone_share = 1.25; // of the blood's brightness; brighter is bone or plaque
constexpr double thin_mm = 0.9, wide_mm = 2.5;

struct Reached {
    double price = INFINITY, mm = 0, off_mm = 0; // of the way from the click; off_mm: of it, outside tubes
    std::size_t from = 0;
    bool is_final = false;
};
using Ways = std::unordered_map<std::size_t, Reached>;

class Tracer
{
  public:
    Tracer(const Volume &scan, const Bright &bright, const Contrast &contrast)
        : scan_(scan), bright_(bright), neighbours_(scan), bone_HU_(bone_share * contrast.mean_HU),
          dark_HU_(0.5 * (surroundings_HU + bright_range(contrast).low_HU))
    {
    }

    // The cheapest ways from a voxel, by Dijkstra. A way ends where it meets a voxel of `goal`.
    std::optional<std::size_t> find(std::size_t from, const Mask &goal)
    {
        using Entry = std::pair<double, std::size_t>;
        std::priority_queue<Entry, std::vector<Entry>, std::greater<>> queue;
        std::optional<std::size_t> met;
        ways_.clear();
        order_.clear();
        ways_[from] = {0, 0, 0, from, false};
        queue.emplace(0.0, from);
        while (!queue.empty()) {
            const auto [price, at] = queue.top();
            queue.pop();
            Reached &here = ways_[at];
            if (here.is_final) continue;
            here.is_final = true;
            order_.push_back(at);
            if (goal[at]) {
                if (!met) met = at;
                continue;
            }
            go_on(at, here, queue);
        }
        return met;
    }

    std::vector<std::size_t> way_to(std::size_t at) const
    {
        std::vector<std::size_t> way{at};
        for (std::size_t next = ways_.at(at).from; next != way.back(); next = ways_.at(next).from)
            way.push_back(next);
        return way;
    }

    // The end of the longest way through tubes that leaves the given way near the click.
    std::optional<std::size_t> far_end(const std::vector<std::size_t> &way) const
    {
        constexpr double shared_most_mm = 6.0, off_share = 0.15, least_mm = 5.0;
        std::unordered_set<std::size_t> beside; // the given way with what lies beside it
        for (const std::size_t middle : way)
            for_ball(scan_, {place_at(scan_, middle), wide_mm}, [&](std::size_t at) { beside.insert(at); });
        std::unordered_map<std::size_t, double> left_mm; // where the way to a voxel leaves the given one
        std::optional<std::size_t> best;
        double best_mm = least_mm;
        for (const std::size_t at : order_) { // each comes after the one that its way comes from
            const Reached &reached = ways_.at(at);
            const double left = left_mm[at] = beside.count(at) > 0 ? reached.mm : left_mm.at(reached.from);
            if (!bright_.tubes[at] || left > shared_most_mm || reached.mm <= best_mm ||
                reached.off_mm > off_share * reached.mm)
                continue;
            best = at, best_mm = reached.mm;
        }
        return best;
    }

    // The radius of the artery along a way: a low quartile of the widths, because a bone beside it adds to
    // some.
    double radius_mm(const std::vector<std::size_t> &way) const
    {
        std::vector<std::uint16_t> widths;
        for (const std::size_t at : way)
            if (bright_.tubes[at]) widths.push_back(bright_.widths[at]);
        if (widths.empty()) return thin_mm;
        const auto quartile = widths.begin() + static_cast<std::ptrdiff_t>(widths.size() / 4);
        std::nth_element(widths.begin(), quartile, widths.end());
        return std::clamp(*quartile * width_unit_mm, thin_mm, wide_mm);
    }

    double length_mm(std::size_t at) const { return ways_.at(at).mm; }

  private:
    template <class Queue> void go_on(std::size_t at, const Reached &here, Queue &queue)
    {
        neighbours_.each(at, [&](std::size_t next, std::size_t n) {
            const double mm = neighbours_.all[n].mm, each = price_of(next);
            if (!std::isfinite(each) || here.mm + mm > trace_most_mm) return;
            const double price = here.price + mm * each;
            Reached &there = ways_[next];
            if (there.is_final || price >= there.price) return;
            there = {price, here.mm + mm, here.off_mm + (bright_.tubes[next] ? 0.0 : mm), at, false};
            queue.emplace(price, next);
        });
    }

    // Infinite where no artery can be.
    double price_of(std::size_t at) const
    {
        const double HU = static_cast<double>(scan_.hu[at]);
        if (HU > bone_HU_) return in_bone;
        if (bright_.tubes[at]) return 1;
        if (bright_.inside[at]) return bright_.widths[at] * width_unit_mm > wide_mm ? in_bone : beside_tube;
        return HU > dark_HU_ ? in_dark : INFINITY;
    }

    const Volume &scan_;
    const Bright &bright_;
    Neighbours neighbours_;
    double bone_HU_, dark_HU_;
    Ways ways_;
    std::vector<std::size_t> order_; // as they became final
};

// Marks the bright voxels around a way. The thread in its middle keeps it open, because the wall would close
// a thin artery where noise darkens it. The wall itself is found in the scan.
void mark_way(const Volume &scan, const Bright &bright, const std::vector<std::size_t> &way, double radius_mm,
              Mask &artery, Mask &tubes)
{
    for (const std::size_t middle : way) {
        const auto mark = [&](std::size_t at) { artery[at] = 1, tubes[at] = thread_mark; };
        for_ball(scan, {place_at(scan, middle), radius_mm},
                 [&](std::size_t at) { artery[at] = artery[at] || bright.inside[at]; });
        // With the neighbours, the thread is connected over faces where the way goes diagonally, too.
        mark(middle);
        for_neighbours(scan, middle, mark);
    }
}

// The arteries connected with the start that are wide enough to stay open.
Mask trunk_of(const Volume &scan, const Bright &bright, const Mask &start, const Mask &artery)
{
    constexpr double open_mm = 1.4;
    Mask trunk = artery;
    keep_connected(scan, start, trunk);
    for (std::size_t at = 0; at < trunk.size(); ++at)
        trunk[at] = trunk[at] && bright.widths[at] * width_unit_mm >= open_mm;
    return trunk;
}

} // namespace

void trace_clicked(const Volume &scan, const Bright &bright, const Contrast &contrast,
                   const std::vector<Click> &clicks, const Mask &unaided, const Mask &start, Mask &artery,
                   Mask &tubes, Findings &findings)
{
    if (!has_artery_click(clicks)) return;
    Tracer tracer(scan, bright, contrast);
    const Mask trunk = trunk_of(scan, bright, start, unaided);
    for (const Click &click : clicks) {
        if (click.kind != ClickKind::artery) continue;
        const std::size_t source = sources_of(scan, bright, {click}).front().at;
        const std::optional<std::size_t> met = tracer.find(source, trunk);
        if (!met || *met == source) continue;
        const std::vector<std::size_t> way = tracer.way_to(*met);
        const double radius_mm = tracer.radius_mm(way);
        double length_mm = tracer.length_mm(*met);
        mark_way(scan, bright, way, radius_mm, artery, tubes);
        if (const auto end = tracer.far_end(way)) {
            mark_way(scan, bright, tracer.way_to(*end), radius_mm, artery, tubes);
            length_mm += tracer.length_mm(*end);
        }
        findings.facts.push_back(click.label +
                                 formatted(": traced over %.0f mm, radius %.1f mm", length_mm, radius_mm));
    }
}

} // namespace crn::ct
