// The threads first share the chunks of triangles and then the tiles of the picture, so that only one thread
// writes each pixel.
#include "host/xray/paths/raster_paths.hpp"
#include "host/xray/paths/parallel.hpp"
#include "host/xray/paths/raster_tile.hpp"
#include <algorithm>
#include <atomic>
#include <cmath>

namespace crn
{
namespace
{

// Holds one row of a channel's depth sums, and the sign with which the row is added to a material's path
// lengths.
struct SignedRow {
    const std::int32_t *line;
    std::int32_t sign; // 0: added, -1: subtracted
};

CRN_WIDE void add_rows(std::span<const SignedRow> rows, int count, std::int32_t *to)
{
    for (int x = 0; x < count; ++x) to[x] = (rows[0].line[x] ^ rows[0].sign) - rows[0].sign;
    for (const SignedRow &row : rows.subspan(1)) {
        const std::int32_t *line = row.line, sign = row.sign;
        for (int x = 0; x < count; ++x) to[x] += (line[x] ^ sign) - sign;
    }
}

// In most tiles of the picture, most materials do not occur. For a row of path lengths, testing for zeros is
// cheaper than writing zeros again, because a write uses memory bandwidth twice.
CRN_WIDE void clear_row(int count, std::int32_t *to)
{
    std::int32_t any = 0;
    for (int x = 0; x < count; ++x) any |= to[x];
    if (any != 0) std::fill_n(to, count, 0);
}

// Converts a sum of depths along the central axis to a length along the ray, which is not negative.
inline std::int32_t lengthened(std::int32_t sum, float oblique)
{
    const float length = static_cast<float>(sum) * oblique + 0.5f;
    return static_cast<std::int32_t>(length > 0.0f ? length : 0.0f);
}

CRN_WIDE void lengthen_row(const std::int32_t *from, const float *oblique, int count, std::int32_t *to)
{
    for (int x = 0; x < count; ++x) to[x] = lengthened(from[x], oblique[x]);
}

} // namespace

CRN_WIDE void oblique_of_row(const View &view, int row, int begin, int end, float *oblique)
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

CRN_WIDE void finish_sum(const std::int32_t *one, const std::int32_t *other, const float *oblique, int count,
                         std::int32_t *to)
{
    for (int x = 0; x < count; ++x) to[x] = lengthened(one[x] + other[x], oblique[x]);
}

void finish_row(const View &view, int row, int begin, int end, std::int32_t *line)
{
    float oblique[tile_columns];
    for (int x = begin; x < end; x += tile_columns) {
        const int count = std::min(tile_columns, end - x);
        oblique_of_row(view, row, x, x + count, oblique);
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
    if (!moved_) {
        moved_ = std::make_unique<BodyMeshes>(*meshes_);
        moved_->vertices_um = {}; // vertices_ holds them
        meshes_ = moved_.get();
    }
    for (std::size_t i = 0; i < moved_->chunks.size(); ++i)
        if (moved_->chunks[i].body == body) vertices_.move(*moved_, i, vertices_um);
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
    projection_.seen.clear();
    for (std::size_t i = 0; i < projection_.chunks.size(); ++i)
        if (projection_.chunks[i].kind != Projection::Kind::nowhere)
            projection_.seen.push_back(static_cast<std::uint32_t>(i));
}

void RasterPaths::sum_tile(const Camera &camera, const PixelRect &rect, Tile &tile) const
{
    tile.sums.resize(meshes_->channels.size() * tile_ints);
    tile.has_channel.assign(meshes_->channels.size(), 0);
    TileRaster raster(*meshes_, vertices_, camera, projection_, rect);
    for (const std::uint32_t i : projection_.seen) {
        const Projection::OfChunk &chunk = projection_.chunks[i];
        if (chunk.x0 >= rect.x1 || chunk.x1 < rect.x0 || chunk.y0 >= rect.y1 || chunk.y1 < rect.y0) continue;
        const int channel = meshes_->chunks[i].channel;
        std::int32_t *sums = tile.sums.data() + channel * tile_ints;
        if (!tile.has_channel[channel]) std::fill_n(sums, tile_ints, 0);
        tile.has_channel[channel] = 1;
        raster.add(i, sums);
    }
    raster.finish();
}

// Computes the path lengths of one material in a tile: adds the channels of this material, and subtracts the
// channels whose bodies lie in it.
void RasterPaths::resolve_material(const View &view, const PixelRect &rect, const Tile &tile, int material,
                                   PathForm form, PathPictures &pictures) const
{
    const int columns = rect.x1 - rect.x0;
    std::vector<SignedRow> rows;
    for (std::size_t i = 0; i < meshes_->channels.size(); ++i) {
        const MeshChannel &channel = meshes_->channels[i];
        if (!tile.has_channel[i] || channel.own == channel.parent) continue;
        const std::int32_t *sums = tile.sums.data() + i * tile_ints;
        if (channel.own == material) rows.push_back({sums, 0});
        if (channel.parent == material) rows.push_back({sums, -1});
    }
    const bool is_one = rows.size() == 1 && rows[0].sign == 0;
    std::int32_t sum[tile_columns];
    for (int row = rect.y0; row < rect.y1; ++row) {
        std::int32_t *to = pictures[material].data() + static_cast<std::size_t>(row) * view.size + rect.x0;
        if (rows.empty()) {
            clear_row(columns, to);
            continue;
        }
        const bool is_done = form == PathForm::axis_sums;
        if (!is_one || is_done) add_rows(rows, columns, is_done ? to : sum);
        if (!is_done)
            lengthen_row(is_one ? rows[0].line : sum, tile.oblique.data() + (row - rect.y0) * tile_columns,
                         columns, to);
        for (SignedRow &of : rows) of.line += tile_stride;
    }
}

void RasterPaths::resolve_tile(const View &view, const PixelRect &rect, Tile &tile, PathForm form,
                               PathPictures &pictures) const
{
    tile.oblique.resize(tile_rows * tile_columns);
    if (form == PathForm::ray_lengths)
        for (int row = rect.y0; row < rect.y1; ++row)
            oblique_of_row(view, row, rect.x0, rect.x1, tile.oblique.data() + (row - rect.y0) * tile_columns);
    for (int material : materials_) resolve_material(view, rect, tile, material, form, pictures);
}

bool RasterPaths::draw(const View &view, std::span<const std::uint8_t> is_drawn, const PixelRect &rect,
                       PathForm form, PathPictures &pictures, std::string &)
{
    if (rect.is_empty()) return true;
    const Camera camera = make_camera(view);
    if (!vertices_.grain_places.empty()) projection_.grain = grain_in(view);
    project(camera, is_drawn, rect);
    const int across = (rect.x1 - rect.x0 + tile_columns - 1) / tile_columns;
    const int down = (rect.y1 - rect.y0 + tile_rows - 1) / tile_rows;
    std::atomic<int> next = 0;
    run_on_threads(threads_, [&](int thread) {
        for (int i = next++; i < across * down; i = next++) {
            const int x = rect.x0 + i % across * tile_columns, y = rect.y0 + i / across * tile_rows;
            const PixelRect tile = {x, y, std::min(x + tile_columns, rect.x1),
                                    std::min(y + tile_rows, rect.y1)};
            sum_tile(camera, tile, tiles_[thread]);
            resolve_tile(view, tile, tiles_[thread], form, pictures);
        }
    });
    return true;
}

} // namespace crn
