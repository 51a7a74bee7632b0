// The threads first share the chunks of triangles and then the tiles of the picture, so that only one thread
// writes each pixel.
#include "host/xray/paths/raster_paths.hpp"
#include "host/xray/paths/lanes.hpp"
#include "host/xray/paths/raster_tile.hpp"
#include <algorithm>
#include <atomic>
#include <cmath>

namespace crn
{
// Lists the depth sums of several channels of a tile: those that are added to a material's path lengths, and
// those that are subtracted.
struct DepthSums {
    std::vector<const std::int32_t *> added, subtracted;
    int offset = 0; // of the row

    bool is_empty() const { return added.empty() && subtracted.empty(); }
};

namespace
{

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

// A reference to such lanes must not be returned: clang would forget that they are not aligned.
inline __attribute__((always_inline)) void read_lanes(const std::int32_t *from, Lanes_i &to)
{
    to = *reinterpret_cast<const Lanes_i_anywhere *>(from);
}

// Adds depth sums from column x on, for `vectors` times eight columns, and converts the result to lengths
// along the rays. The sums stay in registers.
template <int vectors, bool has_still, bool is_long>
inline __attribute__((always_inline)) void resolve_columns(const DepthSums &sums, const std::int32_t *still,
                                                           const float *oblique, int x, std::int32_t *to)
{
    Lanes_i sum[vectors] = {}, more;
    if constexpr (has_still)
        for (int k = 0; k < vectors; ++k) read_lanes(still + x + k * lane_count, sum[k]);
    for (const std::int32_t *from : sums.added)
        for (int k = 0; k < vectors; ++k) {
            read_lanes(from + sums.offset + x + k * lane_count, more);
            sum[k] += more;
        }
    for (const std::int32_t *from : sums.subtracted)
        for (int k = 0; k < vectors; ++k) {
            read_lanes(from + sums.offset + x + k * lane_count, more);
            sum[k] -= more;
        }
    for (int k = 0; k < vectors; ++k) {
        if constexpr (is_long) {
            const Lanes_f factor = *reinterpret_cast<const Lanes_f_anywhere *>(oblique + x + k * lane_count);
            Lanes_f length = __builtin_convertvector(sum[k], Lanes_f) * factor + 0.5f;
            length = length > 0.0f ? length : Lanes_f{};
            sum[k] = __builtin_convertvector(length, Lanes_i);
        }
        *reinterpret_cast<Lanes_i_anywhere *>(to + x + k * lane_count) = sum[k];
    }
}

template <bool has_still, bool is_long>
inline __attribute__((always_inline)) void resolve_row(const DepthSums &sums, const std::int32_t *still,
                                                       const float *oblique, int count, std::int32_t *to)
{
    constexpr int vectors = 4, at_once = vectors * lane_count;
    int x = 0;
    for (; x + at_once <= count; x += at_once)
        resolve_columns<vectors, has_still, is_long>(sums, still, oblique, x, to);
    for (; x + lane_count <= count; x += lane_count)
        resolve_columns<1, has_still, is_long>(sums, still, oblique, x, to);
    for (; x < count; ++x) {
        std::int32_t sum = has_still ? still[x] : 0;
        for (const std::int32_t *from : sums.added) sum += from[sums.offset + x];
        for (const std::int32_t *from : sums.subtracted) sum -= from[sums.offset + x];
        to[x] = is_long ? lengthened(sum, oblique[x]) : sum;
    }
}

CRN_WIDE void add_rows(const DepthSums &sums, int count, std::int32_t *to)
{
    resolve_row<false, false>(sums, nullptr, nullptr, count, to);
}

CRN_WIDE void lengthen_rows(const DepthSums &sums, const float *oblique, int count, std::int32_t *to)
{
    resolve_row<false, true>(sums, nullptr, oblique, count, to);
}

CRN_WIDE void lengthen_rows_on(const DepthSums &sums, const std::int32_t *still, const float *oblique,
                               int count, std::int32_t *to)
{
    resolve_row<true, true>(sums, still, oblique, count, to);
}

CRN_WIDE void lengthen_row(const std::int32_t *from, const float *oblique, int count, std::int32_t *to)
{
    for (int x = 0; x < count; ++x) to[x] = lengthened(from[x], oblique[x]);
}

// Returns whether a picture has a number that is not 0 in a rectangle.
bool is_any_in(const PixelRect &rect, int size, const std::vector<std::int32_t> &picture)
{
    for (int row = rect.y0; row < rect.y1; ++row) {
        const std::int32_t *line = picture.data() + static_cast<std::size_t>(row) * size;
        if (std::any_of(line + rect.x0, line + rect.x1, [](std::int32_t sum) { return sum != 0; }))
            return true;
    }
    return false;
}

RowRange around_both(const RowRange &a, const RowRange &b)
{
    if (a.begin >= a.end) return b;
    if (b.begin >= b.end) return a;
    return {std::min(a.begin, b.begin), std::max(a.end, b.end)};
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

void finish_row(const View &view, int row, int begin, int end, std::int32_t *line)
{
    float oblique[tile_columns];
    for (int x = begin; x < end; x += tile_columns) {
        const int count = std::min(tile_columns, end - x);
        oblique_of_row(view, row, x, x + count, oblique);
        lengthen_row(line + x, oblique, count, line + x);
    }
}

CRN_WIDE void scale_sums(int scale_q10, int count, std::int32_t *sums)
{
    for (int i = 0; i < count; ++i) sums[i] = scaled_sum(sums[i], scale_q10);
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

// Adds the depths of the faces in a tile to the sums of their channels. Only the rows that a channel's chunks
// cover are cleared before.
void RasterPaths::sum_tile(const Camera &camera, Tile &tile) const
{
    const PixelRect &rect = tile.rect;
    tile.sums.resize(meshes_->channels.size() * tile_ints);
    tile.rows.assign(meshes_->channels.size(), {0, 0});
    tile.chunks.clear();
    for (const std::uint32_t i : projection_.seen) {
        const Projection::OfChunk &chunk = projection_.chunks[i];
        if (chunk.x0 >= rect.x1 || chunk.x1 < rect.x0 || chunk.y0 >= rect.y1 || chunk.y1 < rect.y0) continue;
        tile.chunks.push_back(i);
        RowRange &rows = tile.rows[static_cast<std::size_t>(meshes_->chunks[i].channel)];
        rows = around_both(rows, {std::max<int>(chunk.y0, rect.y0) - rect.y0,
                                  std::min<int>(chunk.y1 + 1, rect.y1) - rect.y0});
    }
    for (std::size_t channel = 0; channel < tile.rows.size(); ++channel) {
        const RowRange &rows = tile.rows[channel];
        std::fill_n(tile.sums.data() + channel * tile_ints + rows.begin * tile_stride,
                    (rows.end - rows.begin) * tile_stride, 0);
    }
    TileRaster raster(*meshes_, vertices_, camera, projection_, rect);
    for (const std::uint32_t i : tile.chunks)
        raster.add(i, tile.sums.data() + meshes_->chunks[i].channel * tile_ints);
    raster.finish();
    for (std::size_t channel = 0; channel < tile.rows.size(); ++channel) {
        const int scale_q10 = meshes_->channels[channel].scale_q10;
        const RowRange &rows = tile.rows[channel];
        if (scale_q10 != 1024)
            scale_sums(scale_q10, (rows.end - rows.begin) * tile_stride,
                       tile.sums.data() + channel * tile_ints + rows.begin * tile_stride);
    }
}

// Lists the sums that make up a material's path lengths in a row, and reduces `end` to the first row for
// which the list is another one.
void RasterPaths::list_sums(const Tile &tile, int material, int row, int &end, DepthSums &sums) const
{
    sums.added.clear();
    sums.subtracted.clear();
    for (std::size_t i = 0; i < meshes_->channels.size(); ++i) {
        const MeshChannel &channel = meshes_->channels[i];
        const RowRange &rows = tile.rows[i];
        if (channel.own == channel.parent || (channel.own != material && channel.parent != material))
            continue;
        if (row < rows.begin) end = std::min(end, rows.begin);
        if (row < rows.begin || row >= rows.end) continue;
        end = std::min(end, rows.end);
        (channel.own == material ? sums.added : sums.subtracted).push_back(tile.sums.data() + i * tile_ints);
    }
}

// Computes the path lengths of one material in some rows of a tile: adds the channels of this material, and
// subtracts the channels whose bodies lie in it.
void RasterPaths::resolve_rows(const Task &task, const Tile &tile, int material, const RowRange &rows) const
{
    const auto size = static_cast<std::size_t>(task.view.size);
    const int columns = tile.rect.x1 - tile.rect.x0;
    DepthSums sums;
    int end = rows.begin;
    for (int row = rows.begin; row < rows.end; ++row) {
        if (row == end) list_sums(tile, material, row, end = rows.end, sums);
        sums.offset = row * tile_stride;
        const std::size_t begin = static_cast<std::size_t>(tile.rect.y0 + row) * size + tile.rect.x0;
        const float *oblique = tile.oblique.empty() ? nullptr : tile.oblique.data() + row * tile_columns;
        std::int32_t *to = task.pictures[material].data() + begin;
        if (task.still)
            lengthen_rows_on(sums, (*task.still)[material].data() + begin, oblique, columns, to);
        else if (sums.is_empty())
            clear_row(columns, to);
        else if (task.form == PathForm::axis_sums)
            add_rows(sums, columns, to);
        else
            lengthen_rows(sums, oblique, columns, to);
    }
}

// Returns the rows of a tile in which bodies of this material, or bodies in it, lie.
RowRange RasterPaths::rows_of_material(const Tile &tile, int material) const
{
    RowRange rows{0, 0};
    for (std::size_t i = 0; i < meshes_->channels.size(); ++i) {
        const MeshChannel &channel = meshes_->channels[i];
        if (channel.own != channel.parent && (channel.own == material || channel.parent == material))
            rows = around_both(rows, tile.rows[i]);
    }
    return rows;
}

void RasterPaths::measure_rays(const View &view, Tile &tile) const
{
    const PixelRect &rect = tile.rect;
    tile.oblique.resize(tile_rows * tile_columns);
    for (int row = rect.y0; row < rect.y1; ++row)
        oblique_of_row(view, row, rect.x0, rect.x1, tile.oblique.data() + (row - rect.y0) * tile_columns);
}

// Divides the rectangle into tiles, sums each, and passes its number and its sums to `resolve`.
template <class Resolve>
void RasterPaths::draw_tiles(const Camera &camera, const PixelRect &rect, const Resolve &resolve)
{
    const int across = (rect.x1 - rect.x0 + tile_columns - 1) / tile_columns;
    const int down = (rect.y1 - rect.y0 + tile_rows - 1) / tile_rows;
    std::atomic<int> next = 0;
    run_on_threads(threads_, [&](int thread) {
        Tile &tile = tiles_[thread];
        for (int i = next++; i < across * down; i = next++) {
            const int x = rect.x0 + i % across * tile_columns, y = rect.y0 + i / across * tile_rows;
            tile.rect = {x, y, std::min(x + tile_columns, rect.x1), std::min(y + tile_rows, rect.y1)};
            sum_tile(camera, tile);
            resolve(i, tile);
        }
    });
}

bool RasterPaths::draw(const View &view, std::span<const std::uint8_t> is_drawn, const PixelRect &rect,
                       PathForm form, PathPictures &pictures, std::string &)
{
    if (rect.is_empty()) return true;
    const Camera camera = make_camera(view);
    if (!vertices_.grain_places.empty()) projection_.grain = grain_in(view);
    project(camera, is_drawn, rect);
    const Task task{view, form, nullptr, pictures};
    draw_tiles(camera, rect, [&](int, Tile &tile) {
        if (form == PathForm::ray_lengths) measure_rays(view, tile);
        for (int material : materials_) resolve_rows(task, tile, material, {0, tile.rect.y1 - tile.rect.y0});
    });
    return true;
}

// The tiles are those of the whole picture. In each, only the rows that a material covers now or covered at
// the last call are computed anew. Sums at rest that are all 0 are not read.
bool RasterPaths::draw_on(const PathPictures &still, bool is_new, const View &view,
                          std::span<const std::uint8_t> is_drawn, const PixelRect &, PathPictures &pictures,
                          std::string &)
{
    const PixelRect rect{0, 0, view.size, view.size};
    const Camera camera = make_camera(view);
    if (!vertices_.grain_places.empty()) projection_.grain = grain_in(view);
    project(camera, is_drawn, rect);
    const int tiles =
        ((view.size + tile_columns - 1) / tile_columns) * ((view.size + tile_rows - 1) / tile_rows);
    if (is_new) {
        covered_.assign(static_cast<std::size_t>(tiles) * materials_.size(), {0, tile_rows});
        has_still_.assign(covered_.size(), 1);
    }
    const Task task{view, PathForm::ray_lengths, &still, pictures},
        alone{view, PathForm::ray_lengths, nullptr, pictures};
    draw_tiles(camera, rect, [&](int i, Tile &tile) {
        measure_rays(view, tile);
        const std::size_t first = static_cast<std::size_t>(i) * materials_.size();
        for (std::size_t k = 0; k < materials_.size(); ++k) {
            const int material = materials_[k];
            if (is_new) has_still_[first + k] = is_any_in(tile.rect, view.size, still[material]) ? 1 : 0;
            const RowRange rows = rows_of_material(tile, material);
            const RowRange changed = around_both(rows, covered_[first + k]);
            resolve_rows(has_still_[first + k] ? task : alone, tile, material,
                         {changed.begin, std::min(changed.end, tile.rect.y1 - tile.rect.y0)});
            covered_[first + k] = rows;
        }
    });
    return true;
}

} // namespace crn
