#include "tools/lab/ct/arteries/repair.hpp"
#include "host/base/format.hpp"
#include "tools/centreline/tree.hpp"
#include "tools/mesh/fault.hpp"
#include <algorithm>
#include <cmath>

namespace crn::ct
{

namespace
{

using Eigen::Vector3d;

constexpr double join_most_mm = 30, click_mm = 2.5;

// The widest bright voxel near a place. If the nearest one is in a tube, it is that one: the widest may be in
// a bone beside the tube.
std::optional<Source> source_near(const Volume &scan, const Bright &bright, const Vector3d &place_mm)
{
    std::optional<Source> widest, nearest;
    double least_mm = click_mm;
    for_ball(scan, {place_mm, click_mm}, [&](std::size_t at) {
        if (!bright.inside[at]) return;
        const Source here{at, bright.widths[at]};
        if (!widest || here.width > widest->width) widest = here;
        const double mm = (place_at(scan, at) - place_mm).norm();
        if (mm <= least_mm) nearest = here, least_mm = mm;
    });
    return nearest && bright.tubes[nearest->at] ? nearest : widest;
}

double radius_at(const Bright &bright, std::size_t at)
{
    return std::clamp(bright.widths[at] * width_unit_mm, 0.8, 6.0);
}

// The middle of the vessel at a voxel: the widest place within twice its width.
std::size_t middle_of(const Volume &scan, const Bright &bright, const Mask &vessel, std::size_t at)
{
    std::size_t best = at;
    const double reach_mm = 2.0 * bright.widths[at] * width_unit_mm + 1.5;
    for_ball(scan, {place_at(scan, at), reach_mm}, [&](std::size_t other) {
        if (vessel[other] && bright.widths[other] > bright.widths[best]) best = other;
    });
    return best;
}

Tube tube_between(const Volume &scan, const Bright &bright, std::size_t from, std::size_t to)
{
    return {place_at(scan, from), place_at(scan, to), radius_at(bright, from), radius_at(bright, to), to};
}

// The nearest voxel to a place that satisfies the rule.
template <class Rule>
std::optional<std::size_t> nearest_voxel(const Volume &scan, const Vector3d &place_mm, const Rule &rule)
{
    std::optional<std::size_t> nearest;
    double least_mm = join_most_mm;
    for_ball(scan, {place_mm, join_most_mm}, [&](std::size_t at) {
        const double mm = (place_at(scan, at) - place_mm).norm();
        if (mm < least_mm && rule(at)) nearest = at, least_mm = mm;
    });
    return nearest;
}

// The shortest way from the voxels of mark 2 to those of mark 1.
struct Gap {
    std::size_t from = 0, to = 0;
    double mm = join_most_mm;
};

Gap shortest_gap(const Volume &scan, const Mask &piece)
{
    Gap gap;
    for (std::size_t at = 0; at < piece.size(); ++at) {
        if (piece[at] != 2) continue;
        bool is_border = false;
        for_neighbours(scan, at, [&](std::size_t next) { is_border = is_border || piece[next] != 2; });
        if (!is_border) continue;
        const Vector3d here = place_at(scan, at);
        for_ball(scan, {here, gap.mm}, [&](std::size_t other) {
            if (piece[other] != 1) return;
            const double mm = (place_at(scan, other) - here).norm();
            if (mm < gap.mm) gap = {at, other, mm};
        });
    }
    return gap;
}

} // namespace

std::vector<Ball> cuts_of(const std::vector<Click> &clicks)
{
    std::vector<Ball> cuts;
    for (const Click &click : clicks)
        if (click.kind == ClickKind::cut)
            cuts.push_back({click.at_mm, click.radius_mm > 0 ? click.radius_mm : cut_radius_mm});
    return cuts;
}

Stack clicked_start(const Volume &scan, const std::vector<Click> &clicks)
{
    constexpr double radius_mm = 1.5, least_HU = 130.0, most_HU = 900.0; // as of the aorta's discs
    const auto click = std::find_if(clicks.begin(), clicks.end(),
                                    [](const Click &one) { return one.kind == ClickKind::artery; });
    if (click == clicks.end()) return {};
    const auto is_blood = [&](std::size_t at) { return scan.hu[at] >= least_HU && scan.hu[at] <= most_HU; };
    std::size_t nearest = scan.count();
    double least_mm = INFINITY;
    for_ball(scan, {click->at_mm, click_mm}, [&](std::size_t at) {
        const double mm = (place_at(scan, at) - click->at_mm).norm();
        if (is_blood(at) && mm < least_mm) nearest = at, least_mm = mm;
    });
    if (nearest == scan.count()) return {};
    std::vector<double> values;
    for_ball(scan, {place_at(scan, nearest), radius_mm},
             [&](std::size_t at) { values.push_back(static_cast<double>(scan.hu[at])); });
    const double mean_HU = median(values);
    if (mean_HU < least_HU) return {};
    for (double &value : values) value = std::fabs(value - mean_HU);
    const Vector3d voxel = scan.voxel(place_at(scan, nearest));
    Disc disc;
    disc.slice = static_cast<int>(std::lround(voxel.z()));
    disc.middle = voxel.head<2>();
    disc.radius_mm = radius_mm;
    disc.mean_HU = mean_HU;
    disc.noise_HU = 1.48 * median(values); // of a normal distribution
    disc.share = 1.0;
    return {disc};
}

std::vector<Source> sources_of(const Volume &scan, const Bright &bright, const std::vector<Click> &clicks)
{
    std::vector<Source> sources;
    for (const Click &click : clicks) {
        if (click.kind != ClickKind::artery) continue;
        const std::optional<Source> source = source_near(scan, bright, click.at_mm);
        if (!source)
            throw Fault(
                click.where +
                formatted(
                    ": 'at_mm': nothing within %.1f mm is as bright as an artery (%.0f HU there): click "
                    "into the middle of an artery, or use a bridge where its lumen is too thin to see",
                    click_mm, scan.value(scan.voxel(click.at_mm))));
        sources.push_back(*source);
    }
    return sources;
}

Tube bridge_of(const Volume &scan, const Bright &bright, const Mask &artery, const Click &click)
{
    const auto near = nearest_voxel(scan, click.at_mm, [&](std::size_t at) { return artery[at] != 0; });
    if (!near)
        throw Fault(click.where +
                    formatted(": 'at_mm': no artery that was found is within %.0f mm: click into "
                              "the gap between two ends",
                              join_most_mm));
    const Vector3d there = place_at(scan, *near) - click.at_mm;
    const auto other = nearest_voxel(scan, click.at_mm, [&](std::size_t at) {
        constexpr double widest_mm = 15.0; // a chamber
        const Vector3d here = place_at(scan, at) - click.at_mm;
        return (bright.inside[at] || artery[at]) && bright.widths[at] * width_unit_mm < widest_mm &&
               here.dot(there) < 0.3 * here.norm() * there.norm();
    });
    if (!other)
        throw Fault(click.where + formatted(": 'at_mm': there is nothing bright within %.0f mm on the other "
                                            "side of the gap",
                                            join_most_mm));
    return tube_between(scan, bright, middle_of(scan, bright, artery, *near),
                        middle_of(scan, bright, bright.inside, *other));
}

void mark_tube(const Volume &scan, const Tube &tube, Mask &mask)
{
    const double reach_mm =
        0.5 * (tube.to_mm - tube.from_mm).norm() + std::max(tube.from_radius_mm, tube.to_radius_mm);
    for_ball(scan, {0.5 * (tube.from_mm + tube.to_mm), reach_mm}, [&](std::size_t at) {
        if (centreline::tapered_capsule_distance(place_at(scan, at), tube.from_mm, tube.from_radius_mm,
                                                 tube.to_mm, tube.to_radius_mm) <= 0)
            mask[at] = 1;
    });
}

void join_clicked(const Volume &scan, const Bright &bright, const std::vector<Click> &clicks,
                  const Mask &start, Mask &artery, Mask &tubes, Findings &findings)
{
    for (const Click &click : clicks) {
        if (click.kind != ClickKind::artery) continue;
        const std::optional<Source> source = source_near(scan, bright, click.at_mm);
        if (!source || !artery[source->at]) continue;
        Mask piece = artery;
        flood_diagonally(scan, piece, {source->at}, 1, 2);
        bool is_joined = false;
        for (std::size_t at = 0; at < piece.size() && !is_joined; ++at)
            is_joined = piece[at] == 2 && start[at];
        if (is_joined) continue;
        const Gap gap = shortest_gap(scan, piece);
        if (gap.mm >= join_most_mm) {
            findings.check.push_back(
                click.label +
                formatted(": its artery ends more than %.0f mm from the others and is left out: "
                          "add a bridge",
                          join_most_mm));
            continue;
        }
        Mask tube(scan.count(), 0);
        mark_tube(scan,
                  tube_between(scan, bright, middle_of(scan, bright, artery, gap.from),
                               middle_of(scan, bright, artery, gap.to)),
                  tube);
        for (std::size_t at = 0; at < tube.size(); ++at)
            if (tube[at] && !artery[at]) artery[at] = tubes[at] = 1;
        findings.facts.push_back(click.label + formatted(": joined over a gap of %.1f mm", gap.mm));
    }
}

void keep_connected(const Volume &scan, const Mask &start, Mask &artery)
{
    std::vector<std::size_t> queue;
    for (std::size_t at = 0; at < artery.size(); ++at)
        if (artery[at] && start[at]) queue.push_back(at);
    flood_diagonally(scan, artery, std::move(queue), 1, 2);
    for (unsigned char &value : artery) value = value == 2;
}

} // namespace crn::ct
