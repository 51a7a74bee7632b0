// Divides a picture into tiles of rays, finds the slabs of the volume in which a tile meets tissue, and adds
// the attenuation along the rays.
#include "host/xray/volume/ray_caster.hpp"
#include "host/xray/paths/parallel.hpp"
#include <algorithm>
#include <cmath>

namespace crn
{
namespace
{

constexpr int bundles_across = ray_tile_columns / lane_count;
constexpr int tile_bundles = bundles_across * ray_tile_rows;
constexpr double fixed_one = 65536.0;

std::int32_t to_fixed(double value)
{
    return static_cast<std::int32_t>(std::floor(std::clamp(value, -32000.0, 32000.0) * fixed_one + 0.5));
}

} // namespace

// Holds the geometry of one picture: vectors in voxels along p, q and r.
struct RayCaster::Rays {
    const Slices &slices;
    RayGrid grid;
    Eigen::Vector3d source, right, up,
        forward; // the last three give a ray's direction per pixel, and to the detector
    Eigen::Vector3d right_mm, up_mm, forward_mm;
    double middle_px;

    Rays(const CtVolume &volume, const View &view, const RayGrid &of, const Slices &along)
        : slices(along), grid(of), middle_px(0.5 * view.size)
    {
        right_mm = view.right * view.pixel_m * 1e3;
        up_mm = view.up * view.pixel_m * 1e3;
        forward_mm = view.forward * view.source_detector_m * 1e3;
        const auto in_voxels = [&](const Eigen::Vector3d &mm) {
            return Eigen::Vector3d(mm[along.p] / volume.spacing_mm[along.p],
                                   mm[along.q] / volume.spacing_mm[along.q],
                                   mm[along.r] / volume.spacing_mm[along.r]);
        };
        source = in_voxels(view.source_m * 1e3 - volume.first_mm);
        right = in_voxels(right_mm);
        up = in_voxels(up_mm);
        forward = in_voxels(forward_mm);
        const double from = std::clamp(source.x(), -1.0, 2.0 * ct_size_max);
        const int size = volume.size[along.p];
        begin = forward.x() > 0.0 ? std::max(static_cast<int>(std::floor(from)) + 1, 0) : 0;
        end = forward.x() > 0.0 ? size : std::min(static_cast<int>(std::ceil(from)), size);
    }
    // The slices in front of the source.
    int begin = 0, end = 0;

    double across_px(int column) const { return grid.first_px + grid.step_px * column - middle_px; }
    double above_px(int row) const { return middle_px - grid.first_px - grid.step_px * row; }
    Eigen::Vector3d direction(int column, int row) const
    {
        return right * across_px(column) + up * above_px(row) + forward;
    }
    double length_mm(int column, int row) const
    {
        return (right_mm * across_px(column) + up_mm * above_px(row) + forward_mm).norm();
    }
};

RayCaster::RayCaster(std::shared_ptr<const CtVolume> volume,
                     const std::array<double, knot_count> &knots_permille)
    : volume_(std::move(volume)), along_x_(*volume_, false), along_z_(*volume_, true),
      cast_slab_(choose_cast_slab())
{
    const CtVolume &own = *volume_;
    for (int knot = 0; knot < knot_count; ++knot)
        knots_[knot] = static_cast<std::int32_t>(std::floor(knots_permille[knot] * (1 << sum_bits) + 0.5));
    std::array<int, 3> bricks;
    const std::vector<std::uint8_t> is_full = full_bricks(own, bricks);
    for (int axis = 0; axis < 3; ++axis) slices_[axis] = slices_of(axis, is_full, bricks);
}

RayCaster::Slices RayCaster::slices_of(int p, const std::vector<std::uint8_t> &is_full,
                                       const std::array<int, 3> &bricks) const
{
    Slices slices;
    slices.p = p;
    slices.q = p == 0 ? 2 : 0;
    slices.r = p == 1 ? 2 : 1;
    const VoxelRows &rows = p == 0 ? along_z_ : along_x_;
    slices.voxels = rows.voxels();
    slices.slice_stride = p == 1 ? rows.plane_stride() : rows.row_stride();
    slices.row_stride = p == 1 ? rows.row_stride() : rows.plane_stride();
    slices.table = std::make_unique<SlabTable>(is_full, bricks, p, slices.q, slices.r);
    return slices;
}

// Holds the rays of one tile, and the slabs of the volume in which they may meet tissue. One thread works on
// it.
struct RayCaster::Tile {
    struct Slab {
        int first, end;     // slices
        int q0, q1, r0, r1; // the voxels that the rays read lie in this rectangle
    };
    int column = 0, row = 0; // of the first ray
    std::array<RayBundle, tile_bundles> bundles;
    float per_step_mm[tile_bundles]
                     [lane_count]; // length of the ray from slice to slice, per unit of the sums
    std::vector<Slab> slabs;
    std::uint32_t steps = 0; // slices passed
};

void RayCaster::aim(const Rays &rays, Tile &tile) const
{
    tile.bundles = {};
    for (int i = 0; i < tile_bundles * lane_count; ++i) {
        const int x = tile.column + i % ray_tile_columns, y = tile.row + i / ray_tile_columns,
                  lane = i % lane_count;
        RayBundle &bundle = tile.bundles[i / lane_count];
        const Eigen::Vector3d direction = rays.direction(x, y);
        const double step_q = direction.y() / direction.x(), step_r = direction.z() / direction.x();
        bundle.q[lane] = to_fixed(rays.source.y() - rays.source.x() * step_q);
        bundle.r[lane] = to_fixed(rays.source.z() - rays.source.x() * step_r);
        bundle.step_q[lane] = to_fixed(step_q);
        bundle.step_r[lane] = to_fixed(step_r);
        tile.per_step_mm[i / lane_count][lane] =
            static_cast<float>(rays.length_mm(x, y) / std::fabs(direction.x()) * 1e-3 / (1 << sum_bits));
    }
}

// All rays of a tile lie between its four corner rays.
void RayCaster::find_slabs(const Rays &rays, Tile &tile) const
{
    const std::pair<int, int> corners[] = {{0, 0},
                                           {bundles_across - 1, lane_count - 1},
                                           {tile_bundles - bundles_across, 0},
                                           {tile_bundles - 1, lane_count - 1}};
    tile.slabs.clear();
    for (int index = rays.begin / brick_edge; index < rays.slices.table->slabs(); ++index) {
        const int first = std::max(index * brick_edge, rays.begin),
                  end = std::min((index + 1) * brick_edge, rays.end);
        if (first >= end) continue;
        std::int64_t q0 = INT64_MAX, q1 = INT64_MIN, r0 = INT64_MAX, r1 = INT64_MIN;
        for (const auto &[bundle, lane] : corners)
            for (int k : {first, end - 1}) {
                const RayBundle &of = tile.bundles[bundle];
                const std::int64_t q = of.q[lane] + std::int64_t{of.step_q[lane]} * k;
                const std::int64_t r = of.r[lane] + std::int64_t{of.step_r[lane]} * k;
                q0 = std::min(q0, q), q1 = std::max(q1, q), r0 = std::min(r0, r), r1 = std::max(r1, r);
            }
        // One voxel more on each side: the neighbours that interpolation reads, and rounding.
        const Tile::Slab slab{first,
                              end,
                              static_cast<int>(q0 >> 16) - 1,
                              static_cast<int>(q1 >> 16) + 2,
                              static_cast<int>(r0 >> 16) - 1,
                              static_cast<int>(r1 >> 16) + 2};
        if (rays.slices.table->has_tissue(index, slab.q0, slab.q1, slab.r0, slab.r1))
            tile.slabs.push_back(slab);
    }
}

void RayCaster::walk(const Rays &rays, Tile &tile) const
{
    const Slices &slices = rays.slices;
    const int last_q = volume_->size[slices.q] - 1, last_r = volume_->size[slices.r] - 1;
    SlabOfSlices slab;
    slab.voxels = slices.voxels;
    slab.slice_stride = slices.slice_stride;
    slab.row_stride = slices.row_stride;
    slab.q_limit = last_q << 16;
    slab.r_limit = last_r << 16;
    std::copy(knots_.begin(), knots_.end(), slab.knots);
    // Oblique rays meet other cache lines in every slice, which the processor cannot foresee by itself.
    const auto fetch = [&](const Tile::Slab &next) {
        const int q0 = std::max(next.q0, 0) & ~31, q1 = std::min(next.q1, last_q);
        for (int k = next.first; k < next.end; ++k)
            for (int r = std::max(next.r0, 0); r <= std::min(next.r1, last_r); ++r)
                for (int q = q0; q <= q1; q += 32)
                    __builtin_prefetch(slab.voxels + std::int64_t{k} * slab.slice_stride +
                                       std::int64_t{r} * slab.row_stride + q);
    };
    tile.steps = 0;
    for (std::size_t i = 0; i < tile.slabs.size(); ++i) {
        const Tile::Slab &now = tile.slabs[i];
        if (i + 1 < tile.slabs.size()) fetch(tile.slabs[i + 1]);
        slab.first = now.first;
        slab.end = now.end;
        slab.is_inside = now.q0 >= 0 && now.r0 >= 0 && now.q1 <= last_q && now.r1 <= last_r;
        cast_slab_(slab, tile.bundles.data(), tile_bundles);
        tile.steps += static_cast<std::uint32_t>(now.end - now.first);
    }
}

void RayCaster::write(const Rays &rays, const Tile &tile, RaySums &sums) const
{
    for (int i = 0; i < tile_bundles * lane_count; ++i) {
        const RayBundle &bundle = tile.bundles[i / lane_count];
        const int lane = i % lane_count;
        const std::size_t at = std::size_t{1} * (tile.row + i / ray_tile_columns) * rays.grid.columns +
                               tile.column + i % ray_tile_columns;
        const float mm = tile.per_step_mm[i / lane_count][lane];
        sums.all_mm[at] = static_cast<float>(bundle.all[lane]) * mm;
        for (int knot = 0; knot < knot_count; ++knot) {
            const std::uint32_t below = tile.steps * static_cast<std::uint32_t>(knots_[knot]);
            sums.over_mm[knot][at] = static_cast<float>(bundle.over[knot][lane] - below) * mm;
        }
    }
}

// Chooses the axis along which the picture's central ray makes the most steps. Where voxels are long, this
// could be an axis to which the central ray is nearly perpendicular. Rays at the edge of the picture would
// then run along the slices instead of through them. So the angle between axis and central ray is at most 66
// degrees; the outermost rays of a C-arm deviate from the central ray by up to 21 degrees.
int RayCaster::axis_across(const View &view) const
{
    constexpr double component_min = 0.4; // cos 66 degrees
    int best = -1;
    double most = 0.0;
    for (int axis = 0; axis < 3; ++axis) {
        const double along = std::fabs(view.forward[axis]), steps = along / volume_->spacing_mm[axis];
        if (along < component_min || steps <= most) continue;
        best = axis;
        most = steps;
    }
    return best;
}

void RayCaster::cast(const View &view, const RayGrid &grid, int threads, RaySums &sums) const
{
    sums.all_mm.resize(grid.count());
    for (std::vector<float> &over : sums.over_mm) over.resize(grid.count());
    const Rays rays(*volume_, view, grid, slices_[axis_across(view)]);
    run_on_rows(threads, grid.rows, ray_tile_rows, [&](const RowRange &rows) {
        Tile tile;
        tile.row = rows.begin;
        for (tile.column = 0; tile.column < grid.columns; tile.column += ray_tile_columns) {
            aim(rays, tile);
            find_slabs(rays, tile);
            walk(rays, tile);
            write(rays, tile, sums);
        }
    });
}

} // namespace crn
