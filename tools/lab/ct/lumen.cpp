#include "tools/lab/ct/lumen.hpp"
#include "host/base/format.hpp"
#include "tools/lab/ct/measures.hpp"
#include "tools/mesh/fault.hpp"
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace crn::ct
{

using Eigen::Vector3d;

namespace
{

constexpr double wall_contrast_least_HU = 40;
constexpr double opening_mm = 1.1; // radius of the ball: streaks may thin the wall, but not over such a width
constexpr double closing_mm = 2.2; // closes gaps that streaks and the hidden wall leave near the instrument
constexpr double seed_mm = 2.6; // around the line: this close there is fluid, not what lies behind the wall
constexpr double rim_mm = 1.0;  // around the masked region, where the fluid's value is measured

// Returns the most frequent value of voxels in a ring around the line, from a histogram smoothed over 20 HU.
double commonest(const Volume &volume, const Volume &distance, double from_mm, double to_mm)
{
    constexpr int low = -1000, high = 2000;
    std::vector<double> histogram(high - low, 0.0);
    for (std::size_t i = 0; i < volume.hu.size(); ++i) {
        const double away = static_cast<double>(distance.hu[i]), value = static_cast<double>(volume.hu[i]);
        if (away < from_mm || away > to_mm || value < low || value >= high) continue;
        histogram[static_cast<std::size_t>(value - low)] += 1;
    }
    double best = -1, sum = 0;
    int at = low;
    constexpr int half = 10;
    for (int i = 0; i < high - low; ++i) {
        sum += histogram[static_cast<std::size_t>(i)];
        if (i >= 2 * half) sum -= histogram[static_cast<std::size_t>(i - 2 * half)];
        if (sum > best) {
            best = sum;
            at = low + i - half;
        }
    }
    return at;
}

struct Wall {
    double crest_HU,
        edge_HU; // the wall's highest value, and the value where its slope is steepest, which is its surface
};

struct Crests {
    std::vector<double> crests, edges;
};

// Searches outwards from the centreline of the instrument in 16 directions. In each direction, the wall is
// taken to be the first peak well above the value of the fluid.
void look_outwards(const Volume &volume, const std::vector<Vector3d> &line, double fluid, double from_mm,
                   Crests &found)
{
    constexpr double step = 0.2;
    for (std::size_t i = 4; i + 4 < line.size(); i += 4) {
        const Vector3d tangent = (line[i + 4] - line[i - 4]).normalized(), side = tangent.unitOrthogonal(),
                       other = tangent.cross(side);
        for (int turn = 0; turn < 16; ++turn) {
            const double angle = turn * M_PI / 8;
            const Vector3d outwards = std::cos(angle) * side + std::sin(angle) * other;
            double crest = -1e9, steepest = 0, edge = 0,
                   before = volume.value(volume.voxel(line[i] + from_mm * outwards));
            for (double away = from_mm + step; away < 25; away += step) {
                const double value = volume.value(volume.voxel(line[i] + away * outwards));
                if (value - before > steepest) {
                    steepest = value - before;
                    edge = 0.5 * (value + before);
                }
                before = value;
                crest = std::max(crest, value);
                if (crest > fluid + wall_contrast_least_HU && value < crest - 0.4 * (crest - fluid)) {
                    found.crests.push_back(crest);
                    found.edges.push_back(edge);
                    break;
                }
            }
        }
    }
}

Wall wall_along(const Volume &smoothed, const std::vector<LumenScan> &scans, double fluid, double from_mm)
{
    Crests found;
    for (const LumenScan &scan : scans) look_outwards(smoothed, scan.line, fluid, from_mm, found);
    if (found.crests.size() < 20) return {fluid, fluid};
    return {median(found.crests), median(found.edges)};
}

struct Grower {
    const Volume &volume;
    std::vector<std::uint8_t> inside;
    std::vector<std::size_t> open;

    void add(std::size_t at)
    {
        if (inside[at]) return;
        inside[at] = 1;
        open.push_back(at);
    }
    template <class Allowed> void grow(const Allowed &allowed)
    {
        const auto row = static_cast<std::size_t>(volume.size[0]),
                   slice = row * static_cast<std::size_t>(volume.size[1]);
        while (!open.empty()) {
            const std::size_t at = open.back();
            open.pop_back();
            const int i = static_cast<int>(at % row), j = static_cast<int>(at % slice / row),
                      k = static_cast<int>(at / slice);
            const auto look = [&](int a, int b, int c) {
                if (!volume.holds(a, b, c)) return;
                const std::size_t next = volume.at(a, b, c);
                if (!inside[next] && allowed(next)) add(next);
            };
            look(i - 1, j, k), look(i + 1, j, k), look(i, j - 1, k), look(i, j + 1, k), look(i, j, k - 1),
                look(i, j, k + 1);
        }
    }
};

// Applies a morphological opening with a ball to the voxels that may be fluid. After the morphological
// opening, gaps that streaks leave in the wall no longer connect the inside of the lumen with the outside.
// The function then keeps the voxels that are connected to the centreline, and adds all voxels that these
// enclose.
Volume grown(const Volume &restored, const Volume &distance, double fluid, double limit)
{
    Volume dim = restored.like(0);
    const double lowest = fluid - 1.5 * (limit - fluid);
    for (std::size_t i = 0; i < dim.hu.size(); ++i) {
        const double value = static_cast<double>(restored.hu[i]);
        dim.hu[i] = value < limit && value > lowest ? 1.0f : 0.0f;
    }
    const Volume depth = signed_distance(dim);
    Grower core{restored, std::vector<std::uint8_t>(restored.count(), 0), {}};
    const auto is_core = [&](std::size_t at) { return static_cast<double>(depth.hu[at]) < -opening_mm; };
    for (std::size_t i = 0; i < depth.hu.size(); ++i)
        if (static_cast<double>(distance.hu[i]) < seed_mm && is_core(i)) core.add(i);
    core.grow(is_core);
    Volume mask = restored.like(0);
    for (std::size_t i = 0; i < mask.hu.size(); ++i) mask.hu[i] = core.inside[i];
    const Volume from_core = signed_distance(mask);
    Grower outside{restored, std::vector<std::uint8_t>(restored.count(), 0), {}};
    for (std::size_t i = 0; i < mask.hu.size(); ++i)
        outside.inside[i] =
            (static_cast<double>(from_core.hu[i]) < opening_mm + restored.spacing_mm.maxCoeff() + 0.05 &&
             dim.hu[i] > 0) ||
            distance.hu[i] < 0.6f;
    const std::vector<std::uint8_t> inside = outside.inside;
    const auto [ni, nj, nk] = restored.size;
    std::size_t at_border = 0, border = 0;
    for (int k = 0; k < nk; ++k)
        for (int j = 0; j < nj; ++j)
            for (int i = 0; i < ni; ++i) {
                if (i > 0 && j > 0 && k > 0 && i + 1 < ni && j + 1 < nj && k + 1 < nk) continue;
                ++border;
                at_border += inside[restored.at(i, j, k)];
                outside.add(restored.at(i, j, k));
            }
    if (static_cast<double>(at_border) > 0.3 * static_cast<double>(border))
        throw Fault(restored.name + ": the lumen has no wall in this scan: fluid and what is outside hang "
                                    "together; scan with less noise, "
                                    "or give --no-lumen for the line alone");
    outside.grow([](std::size_t) { return true; });
    for (std::size_t i = 0; i < mask.hu.size(); ++i)
        mask.hu[i] = inside[i] || !outside.inside[i] ? 1.0f : 0.0f;
    return mask;
}

// Streaks near the instrument leave cracks in the mask, which the function closes by expanding and shrinking
// the mask.
void close_cracks(Volume &mask, const Volume &distance)
{
    Volume wide = signed_distance(mask);
    for (float &value : wide.hu) value = static_cast<double>(value) < closing_mm ? 1.0f : 0.0f;
    const Volume back = signed_distance(wide);
    for (std::size_t i = 0; i < mask.hu.size(); ++i)
        if (static_cast<double>(distance.hu[i]) < streak_mm && static_cast<double>(back.hu[i]) < -closing_mm)
            mask.hu[i] = 1;
}

// Places the surface of the lumen at those points between voxels where the interpolated value equals `limit`.
// Enclosed bright voxels stay inside.
Volume level_of(const Volume &mask, const Volume &restored, double limit, double slope_HU_per_mm)
{
    Volume level = signed_distance(mask);
    for (std::size_t i = 0; i < level.hu.size(); ++i) {
        const double away = static_cast<double>(level.hu[i]),
                     by_value = (static_cast<double>(restored.hu[i]) - limit) / slope_HU_per_mm;
        // `away` is the distance from voxel i to the nearest voxel on the other side of the surface; the
        // surface lies between these two voxels.
        if (std::abs(away) < 1.1 && (by_value < 0) == (mask.hu[i] > 0))
            level.hu[i] = static_cast<float>(std::clamp(by_value, -1.2, 1.2));
    }
    return level;
}

// Returns the box around the mask, enlarged by `around` voxels on each side.
void box_of(const Volume &mask, int around, std::array<int, 3> &low, std::array<int, 3> &high)
{
    low = mask.size;
    high = {0, 0, 0};
    for (int k = 0; k < mask.size[2]; ++k)
        for (int j = 0; j < mask.size[1]; ++j)
            for (int i = 0; i < mask.size[0]; ++i) {
                if (mask.hu[mask.at(i, j, k)] <= 0) continue;
                const std::array<int, 3> at = {i, j, k};
                for (std::size_t axis = 0; axis < 3; ++axis) {
                    low[axis] = std::min(low[axis], at[axis] - around);
                    high[axis] = std::max(high[axis], at[axis] + around + 1);
                }
            }
    for (std::size_t axis = 0; axis < 3; ++axis) {
        low[axis] = std::max(low[axis], 0);
        high[axis] = std::min(high[axis], mask.size[axis]);
    }
}

} // namespace

Lumen find_lumen(const std::vector<LumenScan> &scans, const LumenOptions &options, const Report &report)
{
    Lumen lumen;
    report("lumen", 0);
    const std::string &name = scans.front().volume->name;
    lumen.fluid_HU = options.fluid_HU;
    if (lumen.fluid_HU <= -1500) {
        const Volume &first = *scans.front().volume;
        lumen.fluid_HU = commonest(first, distance_volume(first, scans.front().line, streak_mm),
                                   options.masked_mm, options.masked_mm + rim_mm);
    }
    Merged merged = merge_scans(scans, options.masked_mm, lumen.fluid_HU);
    report("lumen", 0.1);
    lumen.restored = smoothed(merged.filled, options.smooth_mm);
    const Wall wall = wall_along(lumen.restored, scans, lumen.fluid_HU, options.masked_mm);
    lumen.wall_HU = wall.crest_HU;
    lumen.edge_HU = wall.edge_HU;
    const double contrast = lumen.wall_HU - lumen.fluid_HU;
    if (contrast < wall_contrast_least_HU) {
        const std::string text = formatted(
            ": no wall around the instrument: the fluid has %.0f HU, nothing around it is brighter by %.0f",
            lumen.fluid_HU, wall_contrast_least_HU);
        throw Fault(name + text + "; give --fluid-HU, or --no-lumen for the line alone");
    }
    Volume mask = grown(lumen.restored, merged.distance, lumen.fluid_HU, lumen.edge_HU);
    close_cracks(mask, merged.distance);
    report("lumen", 0.3);
    std::array<int, 3> low, high;
    box_of(mask, 6, low, high);
    for (Volume *part : {&mask, &merged.distance, &merged.filled, &merged.hidden, &lumen.restored})
        *part = cut_out(*part, low, high);
    lumen.hidden = std::move(merged.hidden);
    // The steepest slope of an edge that is smoothed by sigma is contrast / (sigma sqrt(2 pi)), with the
    // measured contrast; a slope of at least half this size counts as an edge.
    const double steepest = contrast / (2.5066 * std::hypot(options.smooth_mm, 0.45));
    lumen.edge_HU_per_mm = 0.5 * steepest;
    lumen.first = level_of(mask, lumen.restored, lumen.edge_HU, steepest);
    lumen.speed = speed_of(gradient_magnitude(merged.filled, options.smooth_mm), lumen.edge_HU_per_mm,
                           0.3 * lumen.edge_HU_per_mm);
    report("lumen", 0.4);
    lumen.level = evolve_snake(lumen.first, lumen.speed, options.snake);
    report("lumen", 0.95);
    // The space that the instrument fills always belongs to the lumen.
    for (std::size_t i = 0; i < lumen.level.hu.size(); ++i)
        lumen.level.hu[i] =
            std::min(lumen.level.hu[i], merged.distance.hu[i] - static_cast<float>(options.instrument_mm));
    report("lumen", 1);
    return lumen;
}

} // namespace crn::ct
