#include "tools/ct/lumen.hpp"
#include "tools/mesh/fault.hpp"
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdio>

namespace seld::ct
{

using Eigen::Vector3d;

namespace
{

constexpr double wall_contrast_least_HU = 40;
constexpr double opening_mm = 1.1; // of the ball: streaks may thin the wall, not over such a width
constexpr double closing_mm = 1.3; // of cracks near the instrument
constexpr double seed_mm = 2.6;    // around the line: fluid is so near, what lies behind the wall is not
constexpr double streak_mm =
    9.0;                       // so far from the line values beyond fluid and silicone are taken for streaks
constexpr double rim_mm = 1.0; // around what is masked, where the fluid's value is looked for

// The commonest value of voxels in a ring around the line, from a histogram smoothed over 20 HU.
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
    double crest_HU, edge_HU; // the wall's highest, and where the way up to it is steepest: its surface
};

// Outwards across the line in 16 directions: the first crest well above the fluid is the wall.
Wall wall_along(const Volume &volume, const std::vector<Vector3d> &line, double fluid, double from_mm)
{
    constexpr double step = 0.2;
    std::vector<double> crests, edges;
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
                    crests.push_back(crest);
                    edges.push_back(edge);
                    break;
                }
            }
        }
    }
    if (crests.size() < 20) return {fluid, fluid};
    const auto middle = static_cast<std::ptrdiff_t>(crests.size() / 2);
    std::nth_element(crests.begin(), crests.begin() + middle, crests.end());
    std::nth_element(edges.begin(), edges.begin() + middle, edges.end());
    return {crests[static_cast<std::size_t>(middle)], edges[static_cast<std::size_t>(middle)]};
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

// Voxels that may be fluid, opened by a ball so that no hole of a streak in the wall leads out; what hangs together with the
// line; then what that encloses.
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

// Cracks that streaks leave near the instrument are closed: out by some, and back.
void close_cracks(Volume &mask, const Volume &distance)
{
    Volume wide = signed_distance(mask);
    for (float &value : wide.hu) value = static_cast<double>(value) < closing_mm ? 1.0f : 0.0f;
    const Volume back = signed_distance(wide);
    for (std::size_t i = 0; i < mask.hu.size(); ++i)
        if (static_cast<double>(distance.hu[i]) < streak_mm && static_cast<double>(back.hu[i]) < -closing_mm)
            mask.hu[i] = 1;
}

// The level between voxels, from their values: where they pass the limit. What is enclosed and bright stays inside.
Volume level_of(const Volume &mask, const Volume &restored, double limit, double slope_HU_per_mm)
{
    Volume level = signed_distance(mask);
    for (std::size_t i = 0; i < level.hu.size(); ++i) {
        const double away = static_cast<double>(level.hu[i]),
                     by_value = (static_cast<double>(restored.hu[i]) - limit) / slope_HU_per_mm;
        // Distance from the nearest voxel of the other kind; the surface is somewhere between.
        if (std::abs(away) < 1.1 && (by_value < 0) == (mask.hu[i] > 0))
            level.hu[i] = static_cast<float>(std::clamp(by_value, -1.2, 1.2));
    }
    return level;
}

// The box of what is inside, with `around` voxels more.
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

Volume distance_volume(const Volume &grid, const std::vector<Vector3d> &line, double reach_mm)
{
    Volume result = grid.like(static_cast<float>(reach_mm));
    for (std::size_t p = 1; p < line.size(); ++p) {
        const std::vector<Vector3d> piece = {line[p - 1], line[p]};
        const Vector3d a = grid.voxel(line[p - 1]), b = grid.voxel(line[p]),
                       sides = Vector3d::Constant(reach_mm).cwiseQuotient(grid.spacing_mm);
        int low[3], high[3];
        for (int axis = 0; axis < 3; ++axis) {
            low[axis] = std::max(0, static_cast<int>(std::floor(std::min(a[axis], b[axis]) - sides[axis])));
            high[axis] = std::min(grid.size[static_cast<std::size_t>(axis)] - 1,
                                  static_cast<int>(std::ceil(std::max(a[axis], b[axis]) + sides[axis])));
        }
        for (int k = low[2]; k <= high[2]; ++k)
            for (int j = low[1]; j <= high[1]; ++j)
                for (int i = low[0]; i <= high[0]; ++i) {
                    const double away =
                        distance_from(piece, grid.scene({double(i), double(j), double(k)})).distance_mm;
                    float &here = result.hu[grid.at(i, j, k)];
                    here = std::min(here, static_cast<float>(away));
                }
    }
    return result;
}

void fill_in(Volume &volume, const std::vector<std::size_t> &hidden, double start)
{
    for (const std::size_t at : hidden) volume.hu[at] = static_cast<float>(start);
    const Vector3d weight = volume.spacing_mm.cwiseProduct(volume.spacing_mm).cwiseInverse();
    const auto row = static_cast<std::size_t>(volume.size[0]),
               slice = row * static_cast<std::size_t>(volume.size[1]);
    for (int round = 0; round < 60; ++round)
        for (const std::size_t at : hidden) {
            const int i = static_cast<int>(at % row), j = static_cast<int>(at % slice / row),
                      k = static_cast<int>(at / slice);
            double values = 0, weights = 0;
            const auto look = [&](int a, int b, int c, double w) {
                if (!volume.holds(a, b, c)) return;
                values += w * static_cast<double>(volume.hu[volume.at(a, b, c)]);
                weights += w;
            };
            look(i - 1, j, k, weight[0]), look(i + 1, j, k, weight[0]), look(i, j - 1, k, weight[1]),
                look(i, j + 1, k, weight[1]), look(i, j, k - 1, weight[2]), look(i, j, k + 1, weight[2]);
            volume.hu[at] +=
                static_cast<float>(1.6 * (values / weights - static_cast<double>(volume.hu[at])));
        }
}

// The scan without the instrument: what it hides, and streaks that no fluid and no silicone have, are filled from around.
Volume without_instrument(const Volume &volume, const Volume &distance, double masked_mm, double fluid)
{
    Volume filled = volume;
    std::vector<std::size_t> hidden;
    for (std::size_t i = 0; i < filled.hu.size(); ++i) {
        const double away = static_cast<double>(distance.hu[i]), value = static_cast<double>(filled.hu[i]);
        if (away < masked_mm || (away < streak_mm && (value > fluid + 280 || value < fluid - 180)))
            hidden.push_back(i);
        else
            filled.hu[i] =
                std::clamp(filled.hu[i], static_cast<float>(fluid - 300), static_cast<float>(fluid + 400));
    }
    fill_in(filled, hidden, fluid);
    return filled;
}

Lumen find_lumen(const Volume &volume, const std::vector<Vector3d> &line, const std::vector<Vector3d> &behind,
                 const LumenOptions &options, const Report &report)
{
    Lumen lumen;
    report("lumen", 0);
    Volume distance = distance_volume(volume, line, streak_mm);
    Volume hidden = behind.empty() ? distance : distance_volume(volume, behind, streak_mm);
    for (std::size_t i = 0; i < hidden.hu.size(); ++i) hidden.hu[i] = std::min(hidden.hu[i], distance.hu[i]);
    lumen.fluid_HU = options.fluid_HU > -1500
                         ? options.fluid_HU
                         : commonest(volume, distance, options.masked_mm, options.masked_mm + rim_mm);
    Volume filled = without_instrument(volume, hidden, options.masked_mm, lumen.fluid_HU);
    report("lumen", 0.1);
    lumen.restored = smoothed(filled, options.smooth_mm);
    const Wall wall = wall_along(lumen.restored, line, lumen.fluid_HU, options.masked_mm);
    lumen.wall_HU = wall.crest_HU;
    lumen.edge_HU = wall.edge_HU;
    const double contrast = lumen.wall_HU - lumen.fluid_HU;
    if (contrast < wall_contrast_least_HU) {
        char text[200];
        std::snprintf(
            text, sizeof text,
            ": no wall around the instrument: the fluid has %.0f HU, nothing around it is brighter by %.0f",
            lumen.fluid_HU, wall_contrast_least_HU);
        throw Fault(volume.name + text + "; give --fluid-HU, or --no-lumen for the line alone");
    }
    Volume mask = grown(lumen.restored, distance, lumen.fluid_HU, lumen.edge_HU);
    close_cracks(mask, distance);
    report("lumen", 0.3);
    std::array<int, 3> low, high;
    box_of(mask, 6, low, high);
    for (Volume *part : {&mask, &distance, &filled, &lumen.restored}) *part = cut_out(*part, low, high);
    // The steepest of a smooth edge of this height: height / (sigma sqrt(2 pi)); half of it is an edge.
    const double steepest = contrast / (2.5066 * std::hypot(options.smooth_mm, 0.45));
    lumen.edge_HU_per_mm = 0.5 * steepest;
    lumen.first = level_of(mask, lumen.restored, lumen.edge_HU, steepest);
    lumen.speed = speed_of(gradient_magnitude(filled, options.smooth_mm), lumen.edge_HU_per_mm,
                           0.3 * lumen.edge_HU_per_mm);
    report("lumen", 0.4);
    lumen.level = evolve_snake(lumen.first, lumen.speed, options.snake);
    report("lumen", 0.95);
    // Where the instrument is, there is lumen.
    for (std::size_t i = 0; i < lumen.level.hu.size(); ++i)
        lumen.level.hu[i] =
            std::min(lumen.level.hu[i], distance.hu[i] - static_cast<float>(options.instrument_mm));
    report("lumen", 1);
    return lumen;
}

} // namespace seld::ct
