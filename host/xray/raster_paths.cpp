// Shares first the chunks, then the tiles out among threads; each pixel is written by one of them.
#include "host/xray/raster_paths.hpp"
#include "host/xray/lanes.hpp"
#include "host/xray/parallel.hpp"
#include <algorithm>
#include <atomic>
#include <cmath>

namespace seld
{
namespace
{

// How much longer the way along each ray is than that along the axis.
SELD_WIDE void oblique_row(const View &view, int row, int begin, int end, float *oblique)
{
    const float half = 0.5f * static_cast<float>(view.size);
    const float focal = static_cast<float>(view.source_detector_m / view.pixel_m);
    const float y = static_cast<float>(row) + 0.5f - half;
    const float scale = 1.0f / focal, square = y * y + focal * focal;
    for (int x = begin; x < end; ++x) {
        const float dx = static_cast<float>(x) + 0.5f - half;
        oblique[x - begin] = std::sqrt(dx * dx + square) * scale;
    }
}

SELD_WIDE void lengthen_row(const std::int32_t *from, const float *oblique, int count, std::int32_t *to)
{
    for (int x = 0; x < count; ++x) {
        const float length = static_cast<float>(from[x]) * oblique[x] + 0.5f;
        to[x] = static_cast<std::int32_t>(length > 0.0f ? length : 0.0f);
    }
}

SELD_WIDE void add_row(const std::int32_t *from, int count, std::int32_t sign, std::int32_t *to)
{
    for (int x = 0; x < count; ++x) to[x] += (from[x] ^ sign) - sign;
}

} // namespace

void finish_row(const View &view, int row, int begin, int end, std::int32_t *line)
{
    float oblique[tile_size];
    for (int x = begin; x < end; x += tile_size) {
        const int count = std::min(tile_size, end - x);
        oblique_row(view, row, x, x + count, oblique);
        lengthen_row(line + x, oblique, count, line + x);
    }
}

RasterPaths::RasterPaths(const BodyMeshes &meshes, int threads)
    : meshes_(&meshes), vertices_(meshes), threads_(threads), tiles_(threads)
{
    for (const MeshChannel &channel : meshes.channels)
        for (int material : {channel.own, channel.parent})
            if (material >= 0 &&
                std::find(materials_.begin(), materials_.end(), material) == materials_.end())
                materials_.push_back(material);
    projection_.chunks.resize(meshes.chunks.size());
    projection_.corners.resize(vertices_.x_um.size());
    projection_.kept.resize(meshes.triangles.size());
}

void RasterPaths::move(int body, std::span<const Eigen::Vector3i> vertices_um)
{
    if (!moved_) moved_ = std::make_unique<BodyMeshes>(*meshes_);
    meshes_ = moved_.get();
    move_body(*moved_, body, vertices_um);
    for (std::size_t i = 0; i < moved_->chunks.size(); ++i)
        if (moved_->chunks[i].body == body) vertices_.set(*moved_, i);
}

void RasterPaths::project(const Camera &camera, std::span<const std::uint8_t> is_drawn, const PixelRect &rect)
{
    std::atomic<std::size_t> next = 0;
    run_on_threads(threads_, [&](int) {
        for (std::size_t i = next++; i < meshes_->chunks.size(); i = next++) {
            if (is_drawn[meshes_->chunks[i].body])
                project_chunk(*meshes_, vertices_, i, camera, rect, projection_);
            else
                projection_.chunks[i] = {};
        }
    });
}

void RasterPaths::sum_tile(const Camera &camera, const PixelRect &rect, Tile &tile) const
{
    tile.sums.resize(meshes_->channels.size() * tile_ints);
    tile.has_channel.assign(meshes_->channels.size(), 0);
    for (std::size_t i = 0; i < meshes_->chunks.size(); ++i) {
        const Projection::OfChunk &chunk = projection_.chunks[i];
        if (chunk.kind == Projection::Kind::nowhere || chunk.x0 >= rect.x1 || chunk.x1 < rect.x0 ||
            chunk.y0 >= rect.y1 || chunk.y1 < rect.y0)
            continue;
        const int channel = meshes_->chunks[i].channel;
        std::int32_t *sums = tile.sums.data() + channel * tile_ints;
        if (!tile.has_channel[channel]) std::fill_n(sums, tile_ints, 0);
        tile.has_channel[channel] = 1;
        raster_tile(*meshes_, vertices_, i, camera, projection_, rect, sums);
    }
}

// Adds each channel to its material and takes it from its parent's.
void RasterPaths::resolve_tile(const View &view, const PixelRect &rect, const Tile &tile, PathForm form,
                               PathPictures &pictures) const
{
    const int columns = rect.x1 - rect.x0;
    float oblique[tile_size];
    for (int row = rect.y0; row < rect.y1; ++row) {
        const std::size_t begin = static_cast<std::size_t>(row) * view.size + rect.x0;
        if (form == PathForm::ray_lengths) oblique_row(view, row, rect.x0, rect.x1, oblique);
        for (int material : materials_) {
            std::int32_t sum[tile_size] = {};
            bool has_any = false;
            for (std::size_t i = 0; i < meshes_->channels.size(); ++i) {
                const MeshChannel &channel = meshes_->channels[i];
                if (!tile.has_channel[i] || channel.own == channel.parent) continue;
                if (channel.own != material && channel.parent != material) continue;
                const std::int32_t *line = tile.sums.data() + i * tile_ints + (row - rect.y0) * tile_stride;
                add_row(line, columns, channel.own == material ? 0 : -1, sum);
                has_any = true;
            }
            std::int32_t *to = pictures[material].data() + begin;
            if (form == PathForm::ray_lengths && has_any)
                lengthen_row(sum, oblique, columns, to);
            else
                std::copy_n(sum, columns, to);
        }
    }
}

bool RasterPaths::draw(const View &view, std::span<const std::uint8_t> is_drawn, const PixelRect &rect,
                       PathForm form, PathPictures &pictures, std::string &)
{
    if (rect.is_empty()) return true;
    const Camera camera = make_camera(view);
    project(camera, is_drawn, rect);
    const int across = (rect.x1 - rect.x0 + tile_size - 1) / tile_size;
    const int down = (rect.y1 - rect.y0 + tile_size - 1) / tile_size;
    std::atomic<int> next = 0;
    run_on_threads(threads_, [&](int thread) {
        for (int i = next++; i < across * down; i = next++) {
            const int x = rect.x0 + i % across * tile_size, y = rect.y0 + i / across * tile_size;
            const PixelRect tile = {x, y, std::min(x + tile_size, rect.x1), std::min(y + tile_size, rect.y1)};
            sum_tile(camera, tile, tiles_[thread]);
            resolve_tile(view, tile, tiles_[thread], form, pictures);
        }
    });
    return true;
}

} // namespace seld
