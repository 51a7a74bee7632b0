// Turns the sums along the rays into path lengths of materials, and interpolates them between the rays.
#include "host/xray/volume/volume_paths.hpp"
#include "host/xray/paths/parallel.hpp"
#include <algorithm>
#include <cmath>

namespace crn
{
namespace
{

constexpr int ct_materials[] = {static_cast<int>(Material::soft_tissue), static_cast<int>(Material::adipose),
                                static_cast<int>(Material::bone_cortical)};
constexpr double step_max_px = 4.0;
constexpr float q10_per_mm = 1024.0f;
constexpr int rows_at_once = 16;

// Holds the four rays around each pixel along one axis, with the weights of Catmull-Rom's cubic (Keys, IEEE
// Trans. Acoust. 29 (1981) 1153, a = -0.5).
struct Taps {
    std::vector<int> first;
    std::vector<float> weight; // four per pixel

    Taps(const RayGrid &grid, int size) : first(size), weight(4 * static_cast<std::size_t>(size))
    {
        for (int x = 0; x < size; ++x) {
            const double at = (x + 0.5 - grid.first_px) / grid.step_px, floor = std::floor(at),
                         t = at - floor;
            first[x] = static_cast<int>(floor) - 1;
            const double w[] = {t * (-0.5 + t * (1.0 - 0.5 * t)), 1.0 + t * t * (-2.5 + 1.5 * t),
                                t * (0.5 + t * (2.0 - 1.5 * t)), t * t * (-0.5 + 0.5 * t)};
            for (int k = 0; k < 4; ++k) weight[4 * x + k] = static_cast<float>(w[k]);
        }
    }
};

int whole_tiles(int count, int tile)
{
    return (count + tile - 1) / tile * tile;
}

// Adds four rows of rays, weighted, for all columns of the grid.
CRN_WIDE void blend_rows(const float *const rows[4], const float *weight, int count, float *to)
{
    for (int i = 0; i < count; ++i)
        to[i] =
            rows[0][i] * weight[0] + rows[1][i] * weight[1] + rows[2][i] * weight[2] + rows[3][i] * weight[3];
}

// Interpolates along a row, and adds the length to the path of each pixel.
CRN_WIDE void add_columns(const float *rays, const Taps &taps, const float *shorten, int begin, int end,
                          std::int32_t *to)
{
    for (int x = begin; x < end; ++x) {
        const float *near = rays + taps.first[x], *w = taps.weight.data() + 4 * static_cast<std::size_t>(x);
        float mm = near[0] * w[0] + near[1] * w[1] + near[2] * w[2] + near[3] * w[3];
        mm = mm > 0.0f ? mm : 0.0f; // the cubic overshoots at edges
        to[x] += static_cast<std::int32_t>(mm * shorten[x] * q10_per_mm + 0.5f);
    }
}

// Returns, for each pixel of a row, the depth along the central axis over the length along the ray.
void shorten_row(const View &view, int row, PathForm form, std::vector<float> &shorten)
{
    if (form == PathForm::ray_lengths) {
        std::fill(shorten.begin(), shorten.end(), 1.0f);
        return;
    }
    const double half = 0.5 * view.size, distance = view.source_detector_m / view.pixel_m;
    for (int x = 0; x < view.size; ++x) {
        const double across = x + 0.5 - half, above = half - row - 0.5;
        shorten[x] =
            static_cast<float>(distance / std::sqrt(distance * distance + across * across + above * above));
    }
}

} // namespace

RayGrid grid_for(const View &view, const CtVolume &volume)
{
    const double voxel_mm = volume.spacing_mm.minCoeff();
    const double pixel_mm = view.pixel_m * 1e3 * view.source_isocentre_m / view.source_detector_m;
    RayGrid grid;
    grid.step_px = std::clamp(voxel_mm / pixel_mm, 1.0, step_max_px);
    grid.first_px = 0.5 - grid.step_px; // one ray more on each side, and two at the end, for the cubic
    const int needed = static_cast<int>(std::ceil((view.size - 1) / grid.step_px)) + 4;
    grid.columns = whole_tiles(needed, ray_tile_columns);
    grid.rows = whole_tiles(needed, ray_tile_rows);
    return grid;
}

void append_ct(BodyMeshes &meshes)
{
    meshes.channel_of_body.push_back(static_cast<int>(meshes.channels.size()));
    meshes.vertex_counts.push_back(0);
    for (int material : ct_materials) meshes.channels.push_back({material, -1});
}

VolumePaths::VolumePaths(std::shared_ptr<const RayCaster> caster, const CtMixture &mixture,
                         const BodyMeshes &meshes, int threads)
    : caster_(std::move(caster)), mixture_(mixture), meshes_(meshes, threads), threads_(threads)
{
}

// Everything is linear in the sums, so the mixture is computed once per ray and not once per voxel.
void VolumePaths::mix()
{
    for (std::vector<float> &of : lengths_mm_) of.resize(grid_.count());
    const auto per_fat = static_cast<float>(1.0 / mixture_.fat_width);
    const auto per_bone = static_cast<float>(1.0 / (mixture_.bone - mixture_.bone_begins));
    const auto soft = static_cast<float>(1.0 / mixture_.soft_tissue),
               fat_share = static_cast<float>(mixture_.fat), bone_share = static_cast<float>(mixture_.bone);
    run_on_rows(threads_, grid_.rows, rows_at_once, [&](const RowRange &rows) {
        const std::size_t begin = std::size_t{1} * rows.begin * grid_.columns,
                          end = std::size_t{1} * rows.end * grid_.columns;
        for (std::size_t i = begin; i < end; ++i) {
            const float fat =
                (sums_.over_mm[0][i] - 2.0f * sums_.over_mm[1][i] + sums_.over_mm[2][i]) * per_fat;
            const float bone = sums_.over_mm[3][i] * per_bone;
            lengths_mm_[0][i] = (sums_.all_mm[i] - fat * fat_share - bone * bone_share) * soft;
            lengths_mm_[1][i] = fat;
            lengths_mm_[2][i] = bone;
        }
    });
}

void VolumePaths::add(const View &view, const PixelRect &rect, PathForm form, PathPictures &pictures)
{
    const Taps taps(grid_, view.size);
    run_on_rows(threads_, rect.y1 - rect.y0, rows_at_once, [&](const RowRange &rows) {
        std::vector<float> line(grid_.columns), shorten(view.size);
        for (int row = rect.y0 + rows.begin; row < rect.y0 + rows.end; ++row) {
            shorten_row(view, row, form, shorten);
            for (int m = 0; m < 3; ++m) {
                const float *near[4];
                for (int k = 0; k < 4; ++k)
                    near[k] = lengths_mm_[m].data() + std::size_t{1} * (taps.first[row] + k) * grid_.columns;
                blend_rows(near, taps.weight.data() + 4 * static_cast<std::size_t>(row), grid_.columns,
                           line.data());
                add_columns(line.data(), taps, shorten.data(), rect.x0, rect.x1,
                            pictures[ct_materials[m]].data() + std::size_t{1} * row * view.size);
            }
        }
    });
}

bool VolumePaths::draw(const View &view, std::span<const std::uint8_t> is_drawn, const PixelRect &rect,
                       PathForm form, PathPictures &pictures, std::string &error)
{
    if (!meshes_.draw(view, is_drawn, rect, form, pictures, error)) return false;
    if (rect.is_empty() || is_drawn.empty() || !is_drawn.back()) return true;
    grid_ = grid_for(view, caster_->volume());
    caster_->cast(view, grid_, threads_, sums_);
    mix();
    add(view, rect, form, pictures);
    return true;
}

} // namespace crn
