// Making the field (see field.hpp). Bricks (blocks of 8^3 voxels) are made level by level from coarse to
// fine, so a finer grid exists only where it is needed.
#include "tools/bake/field.hpp"
#include "shared/scene/scene.h"
#include "tools/bake/fault.hpp"
#include "tools/bake/solid.hpp"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <numeric>
#include <set>

namespace crn::bake
{
namespace
{

constexpr int filter_reach = 6; // taps of the prefilter on each side; the next tap would weigh 4e-6
constexpr int block = 10 + 2 * filter_reach;
constexpr float field_band_voxels = 9;         // int8 holds 4 of them; the rest is the reach of the prefilter
constexpr float exact_voxels = 7;              // samples farther away weigh less than 0.005 in the prefilter
constexpr double coefficient_max = 127.0 / 32; // voxels
constexpr std::uint32_t bricks_max = static_cast<std::uint32_t>(CRN_SCENE_BYTES_MAX) / 1000;
constexpr int test_points = 6; // along each edge of a brick

double voxel_mm(int level)
{
    return voxel0_mm / (1 << level);
}

using mesh::Cell; // here the index of a brick in its level, counted from the patient's origin

struct Brick {
    Cell cell{};
    std::uint16_t entry =
        CRN_LUMEN_ENTRY_OUTSIDE; // OUTSIDE, INSIDE, or FIRST_BRICK, for which `coefficients` is filled
    bool refine = false;
    std::vector<std::int8_t> coefficients;
};

// --- distances on a grid: sample (i,j,k) at voxel centre (i + 1/2) h ---
mesh::LevelSet distances(const Mesh &mesh, int level, Progress &progress)
{
    progress.stage("distances at " + std::to_string(voxel_mm(level)) + " mm", 0);
    mesh::LevelSet grid = level_set(mesh, voxel_mm(level), 0.5, field_band_voxels, field_band_voxels);
    progress.step(0);
    progress.finish();
    return grid;
}

// When the library OpenVDB computes distances from a mesh, it keeps only one triangle per voxel. Where
// triangles are smaller than voxels, OpenVDB's distances are up to 0.03 mm too large. We therefore recompute
// the distances exactly near the wall, and also in all voxels of the bricks that will be stored. Each brick
// covers the same 8^3 voxels as one block of the grid, so we recompute this block and the blocks around it.
// Returns whether the grid had every recomputed voxel on its right side of the wall, but for those that the
// wall crosses.
bool make_exact(mesh::LevelSet &grid, const std::vector<Brick> &bricks, int level, const TriangleTree &tree,
                Progress &progress)
{
    constexpr std::size_t chunk = 128;
    const float reach_mm = static_cast<float>(exact_voxels * voxel_mm(level));
    std::set<Cell> wanted;
    for (const Brick &brick : bricks)
        for (int n = 0; n < 27; ++n)
            wanted.insert(
                {brick.cell[0] + n % 3 - 1, brick.cell[1] + n / 3 % 3 - 1, brick.cell[2] + n / 9 - 1});
    std::vector<Cell> blocks = grid.blocks();
    std::erase_if(blocks, [&](const Cell &cell) { return !wanted.count(cell); });
    std::atomic<bool> are_sides_right = true;
    const auto exact = [&](const Cell &at, float old_mm) {
        const float far_mm = std::abs(old_mm);
        if (far_mm > reach_mm) return old_mm;
        const Eigen::Vector3d p = (Eigen::Vector3d(at[0], at[1], at[2]).array() + 0.5) * voxel_mm(level);
        const auto now_mm = static_cast<float>(tree.nearest(p, 1.001 * far_mm + 1e-3).distance_mm);
        if (std::signbit(old_mm) != std::signbit(now_mm) && std::abs(now_mm) > voxel_mm(level))
            are_sides_right = false;
        return now_mm;
    };
    progress.stage("exact distances at " + std::to_string(voxel_mm(level)) + " mm", blocks.size());
    for (std::size_t first = 0; first < blocks.size(); first += chunk) {
        progress.step(first);
        tbb::parallel_for(first, std::min(first + chunk, blocks.size()),
                          [&](std::size_t i) { grid.change(blocks[i], exact); });
    }
    progress.finish();
    return are_sides_right;
}

// Makes the grid of a level. The finer levels have few bricks, so the part of the mesh around these suffices.
// If a mesh with folds should defeat the cut, the whole mesh gives the grid.
mesh::LevelSet exact_distances(const std::vector<Brick> &bricks, int level, const TriangleTree &tree,
                               Progress &progress)
{
    if (level > 0) {
        std::vector<Cell> cells;
        for (const Brick &brick : bricks) cells.push_back(brick.cell);
        const Mesh part = near_part(tree, std::move(cells), 8 * voxel_mm(level));
        if (part.triangles.size() < tree.mesh().triangles.size()) {
            mesh::LevelSet grid = distances(part, level, progress);
            if (make_exact(grid, bricks, level, tree, progress)) return grid;
        }
    }
    mesh::LevelSet grid = distances(tree.mesh(), level, progress);
    make_exact(grid, bricks, level, tree, progress);
    return grid;
}

// --- prefilter: the inverse of (1/8, 3/4, 1/8) is c z^|n|, z = 2 sqrt 2 - 3; truncated, scaled to sum 1 ---
std::array<double, 2 * filter_reach + 1> prefilter()
{
    const double z = 2 * std::sqrt(2.0) - 3;
    std::array<double, 2 * filter_reach + 1> taps{};
    double sum = 0;
    for (int n = -filter_reach; n <= filter_reach; ++n)
        sum += taps[n + filter_reach] = std::pow(z, std::abs(n));
    for (double &tap : taps) tap /= sum;
    return taps;
}

// Filters along one axis. `size` holds the number of values along each of the three axes. The filter needs
// neighbours on both sides, so its result has fewer values along `axis`.
void filter_axis(std::vector<double> &values, std::array<int, 3> &size, int axis)
{
    static const auto taps = prefilter();
    std::array<int, 3> after = size;
    after[axis] = 10;
    const int stride = axis == 0 ? 1 : axis == 1 ? size[0] : size[0] * size[1];
    std::vector<double> out;
    out.reserve(static_cast<std::size_t>(after[0] * after[1] * after[2]));
    for (int z = 0; z < after[2]; ++z)
        for (int y = 0; y < after[1]; ++y)
            for (int x = 0; x < after[0]; ++x) {
                const double *from = &values[static_cast<std::size_t>((z * size[1] + y) * size[0] + x)];
                double sum = 0;
                for (int n = 0; n < static_cast<int>(taps.size()); ++n) sum += taps[n] * from[n * stride];
                out.push_back(sum);
            }
    values = std::move(out);
    size = after;
}

// --- one brick ---

// Returns the distances in a brick (block of voxels) and up to `reach` voxels around it, in units of the
// voxel size.
std::vector<double> gather(const mesh::LevelSet &grid, const Cell &cell, int reach, double voxel)
{
    return grid.read({8 * cell[0] - reach, 8 * cell[1] - reach, 8 * cell[2] - reach}, 8 + 2 * reach, voxel);
}

// Returns whether some of the brick's distances lie in the range that the file stores. The test of a brick
// uses its 10^3 samples, and widens the stored range by half a voxel on either side.
std::uint16_t classify(const std::vector<double> &values, const FieldText &text, double voxel)
{
    const double inside = std::min(text.inside_mm / voxel, coefficient_max) + 0.5;
    const double outside = std::min(text.outside_mm / voxel, coefficient_max) + 0.5;
    double low = INFINITY, high = -INFINITY;
    for (double value : values) {
        low = std::min(low, value);
        high = std::max(high, value);
    }
    if (low > outside) return CRN_LUMEN_ENTRY_OUTSIDE;
    return high < -inside ? CRN_LUMEN_ENTRY_INSIDE : CRN_LUMEN_ENTRY_FIRST_BRICK;
}

std::vector<std::int8_t> quantise(std::vector<double> values)
{
    std::array<int, 3> size{block, block, block};
    for (int axis = 0; axis < 3; ++axis) filter_axis(values, size, axis);
    std::vector<std::int8_t> coefficients;
    coefficients.reserve(values.size());
    for (double value : values)
        coefficients.push_back(static_cast<std::int8_t>(std::clamp(std::lround(value * 32), -127l, 127l)));
    return coefficients;
}

// Returns the value of a brick's spline, in voxels, at the point x (in voxels from the brick's corner).
double spline(const std::vector<std::int8_t> &c, const Eigen::Vector3d &x)
{
    double w[3][3];
    int first[3];
    for (int k = 0; k < 3; ++k) {
        first[k] = std::min(7, static_cast<int>(x[k]));
        const double u = x[k] - first[k];
        w[k][0] = (1 - u) * (1 - u) / 2;
        w[k][2] = u * u / 2;
        w[k][1] = 1 - w[k][0] - w[k][2];
    }
    double sum = 0;
    for (int n = 0; n < 27; ++n) {
        const int i = n % 3, j = n / 3 % 3, k = n / 9;
        sum += w[0][i] * w[1][j] * w[2][k] *
               c[static_cast<std::size_t>(((first[2] + k) * 10 + first[1] + j) * 10 + first[0] + i)];
    }
    return sum / 32;
}

// Returns whether the brick's spline is wrong by more than the tolerance at some point of a test grid near
// the wall. Returns false for a brick (block of voxels) that may not be divided into smaller bricks.
bool is_wrong(const Brick &brick, int level, const TriangleTree &tree, const FieldText &text)
{
    const double voxel = voxel_mm(level);
    const Eigen::Vector3d corner = Eigen::Vector3d(brick.cell[0], brick.cell[1], brick.cell[2]) * 8 * voxel;
    const Eigen::AlignedBox3d box(corner, corner + Eigen::Vector3d::Constant(8 * voxel));
    double tolerance_mm = level < text.level_max ? text.tolerance_mm : INFINITY;
    for (const FineRegion &region : text.fine)
        if (level < region.level_max && region.box_mm.intersects(box))
            tolerance_mm = std::min(tolerance_mm, region.tolerance_mm);
    if (std::isinf(tolerance_mm)) return false;
    const double band = std::min(error_band_mm, (coefficient_max - 0.2) * voxel);
    for (int n = 0; n < test_points * test_points * test_points; ++n) {
        const Eigen::Vector3d x =
            (Eigen::Vector3d(n % test_points, n / test_points % test_points, n / test_points / test_points)
                 .array() +
             0.5) *
            (8.0 / test_points);
        const double guess = spline(brick.coefficients, x) * voxel;
        if (std::abs(guess) > band + voxel) continue;
        const double exact = tree.nearest(corner + x * voxel, std::abs(guess) + voxel / 4).distance_mm;
        if (std::abs(exact) <= band && std::abs(guess - exact) > tolerance_mm) return true;
    }
    return false;
}

void make_bricks(std::vector<Brick> &bricks, int level, const mesh::LevelSet &grid, const TriangleTree &tree,
                 const FieldText &text, Progress &progress)
{
    constexpr std::size_t chunk = 256; // bricks between two checks of the clock and of Ctrl-C
    progress.stage("bricks of " + std::to_string(voxel_mm(level)) + " mm", bricks.size());
    for (std::size_t first = 0; first < bricks.size(); first += chunk) {
        progress.step(first);
        tbb::parallel_for(first, std::min(first + chunk, bricks.size()), [&](std::size_t i) {
            Brick &brick = bricks[i];
            const double voxel = voxel_mm(level);
            brick.entry = classify(gather(grid, brick.cell, 1, voxel), text, voxel);
            if (brick.entry != CRN_LUMEN_ENTRY_FIRST_BRICK) return;
            brick.coefficients = quantise(gather(grid, brick.cell, 1 + filter_reach, voxel));
            brick.refine = is_wrong(brick, level, tree, text);
        });
    }
    progress.finish();
}

std::vector<Brick> octants(const std::vector<Brick> &bricks)
{
    std::vector<Brick> finer;
    for (const Brick &brick : bricks) {
        for (int octant = 0; brick.refine && octant < 8; ++octant) {
            Brick child;
            for (int k = 0; k < 3; ++k) child.cell[k] = 2 * brick.cell[k] + (octant >> k & 1);
            finer.push_back(std::move(child));
        }
    }
    return finer;
}

// --- the lattice ---

// Returns one index entry per brick. An entry is either the mark for "far from the wall", the table row of
// the finer bricks (counted from `row`), or the next free position in `samples`.
std::vector<std::uint16_t> number(const std::vector<Brick> &bricks, int level, std::uint32_t row,
                                  Field &field)
{
    std::vector<std::uint16_t> entries;
    for (const Brick &brick : bricks) {
        if (brick.refine) {
            entries.push_back(static_cast<std::uint16_t>(CRN_LUMEN_ENTRY_REFINED | row++));
        } else if (brick.entry == CRN_LUMEN_ENTRY_FIRST_BRICK) {
            entries.push_back(static_cast<std::uint16_t>(CRN_LUMEN_ENTRY_FIRST_BRICK +
                                                         field.samples.size() / CRN_LUMEN_BRICK_SAMPLES));
            field.samples.insert(field.samples.end(), brick.coefficients.begin(), brick.coefficients.end());
            ++field.bricks_of_level[level];
        } else {
            entries.push_back(brick.entry);
        }
    }
    return entries;
}

void check_budget(const std::vector<std::vector<Brick>> &levels)
{
    std::size_t count = 0, rows = 0;
    for (const std::vector<Brick> &bricks : levels)
        for (const Brick &brick : bricks) {
            count += !brick.refine && brick.entry == CRN_LUMEN_ENTRY_FIRST_BRICK;
            rows += brick.refine;
        }
    if (count > bricks_max || rows >= 0x7fff)
        throw Fault("the lumen needs over " + std::to_string(bricks_max) + " bricks, more than a scene of " +
                    std::to_string(CRN_SCENE_BYTES_MAX >> 20) +
                    " MiB holds: raise tolerance_mm, lower level_max, or leave out branches");
}

std::vector<Brick> coarse_bricks(const Mesh &mesh, const FieldText &text, Field &field)
{
    Eigen::AlignedBox3d box;
    for (const Eigen::Vector3d &v : mesh.vertices_mm) box.extend(v);
    Cell low, count;
    for (int k = 0; k < 3; ++k) {
        low[k] = static_cast<int>(std::floor((box.min()[k] - text.outside_mm) / brick0_mm));
        count[k] = static_cast<int>(std::floor((box.max()[k] + text.outside_mm) / brick0_mm)) + 1 - low[k];
        field.lumen.origin_m_q30[k] = low[k] * (1 << CRN_SCENE_BRICK_LOG2_Q30);
        field.lumen.brick_count_xyz[k] = static_cast<std::uint16_t>(count[k]);
    }
    const std::size_t total = static_cast<std::size_t>(count[0]) * count[1] * count[2];
    if (2 * total > CRN_SCENE_BYTES_MAX || area_mm2(mesh) / (brick0_mm * brick0_mm) > bricks_max)
        throw Fault(mesh.name + ": too large for a scene of " + std::to_string(CRN_SCENE_BYTES_MAX >> 20) +
                    " MiB (" + std::to_string(total) + " coarse bricks, wall of " +
                    std::to_string(area_mm2(mesh) / 100) +
                    " cm2): check its unit, or cut off what the wire does not reach");
    std::vector<Brick> bricks(total);
    for (std::size_t i = 0; i < total; ++i) {
        const auto at = static_cast<int>(i);
        bricks[i].cell = {low[0] + at % count[0], low[1] + at / count[0] % count[1],
                          low[2] + at / count[0] / count[1]};
    }
    return bricks;
}

} // namespace

const crn_lumen *Field::view()
{
    lumen.index = index.data();
    lumen.children = children.data();
    lumen.samples = samples.data();
    return &lumen;
}

crn_vec3 to_q30(const Eigen::Vector3d &p_mm)
{
    return crn_vec3_make(static_cast<std::int32_t>(std::lround(p_mm.x() / mm_per_q30)),
                         static_cast<std::int32_t>(std::lround(p_mm.y() / mm_per_q30)),
                         static_cast<std::int32_t>(std::lround(p_mm.z() / mm_per_q30)));
}

Field make_field(const TriangleTree &tree, const FieldText &text, Progress &progress)
{
    Field field;
    std::vector<std::vector<Brick>> levels;
    levels.push_back(coarse_bricks(tree.mesh(), text, field));
    for (int level = 0; level < CRN_LUMEN_LEVELS && !levels.back().empty(); ++level) {
        const mesh::LevelSet grid = exact_distances(levels.back(), level, tree, progress);
        make_bricks(levels.back(), level, grid, tree, text, progress);
        check_budget(levels);
        levels.push_back(octants(levels.back()));
    }
    levels.resize(CRN_LUMEN_LEVELS);
    const auto rows = [&](int level) {
        return static_cast<std::uint32_t>(std::count_if(levels[level].begin(), levels[level].end(),
                                                        [](const Brick &b) { return b.refine; }));
    };
    field.row_first_rank = rows(0);
    field.index = number(levels[0], 0, 0, field);
    field.children = number(levels[1], 1, field.row_first_rank, field);
    const std::vector<std::uint16_t> last = number(levels[2], 2, 0, field);
    field.children.insert(field.children.end(), last.begin(), last.end());
    field.lumen.child_row_count = static_cast<std::uint16_t>(field.children.size() / 8);
    field.lumen.brick_count = static_cast<std::uint32_t>(field.samples.size() / CRN_LUMEN_BRICK_SAMPLES);
    field.view();
    return field;
}

} // namespace crn::bake
