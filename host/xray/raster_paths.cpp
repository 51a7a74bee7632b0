// Shares the chunks out among threads, each with sums of its own, and adds these up row by row.
#include "host/xray/raster_paths.hpp"
#include "host/xray/parallel.hpp"
#include "host/xray/raster.hpp"
#include <atomic>
#include <cmath>

namespace seld
{

void finish_row(const View &view, int row, int begin, int end, std::int32_t *line)
{
    const float half = 0.5f * static_cast<float>(view.size);
    const float focal = static_cast<float>(view.source_detector_m / view.pixel_m);
    const float y = static_cast<float>(row) + 0.5f - half;
    const float scale = 1.0f / focal, square = y * y + focal * focal;
    for (int x = begin; x < end; ++x) {
        const float dx = static_cast<float>(x) + 0.5f - half;
        const float oblique = std::sqrt(dx * dx + square) * scale;
        const float length = static_cast<float>(line[x]) * oblique + 0.5f;
        line[x] = static_cast<std::int32_t>(length > 0.0f ? length : 0.0f);
    }
}

void RasterPaths::move(int body, std::span<const Eigen::Vector3i> vertices_um)
{
    if (!moved_) moved_ = std::make_unique<BodyMeshes>(*meshes_);
    meshes_ = moved_.get();
    move_body(*moved_, body, vertices_um);
}

void RasterPaths::sum_chunks(const View &view, std::span<const std::uint8_t> is_drawn)
{
    const std::size_t pixels = static_cast<std::size_t>(view.size) * view.size;
    sums_.resize(threads_);
    std::atomic<std::size_t> next = 0;
    run_on_threads(threads_, [&](int thread) {
        std::vector<std::int32_t> &sums = sums_[thread];
        sums.assign(pixels * meshes_->channels.size(), 0);
        for (std::size_t i = next++; i < meshes_->chunks.size(); i = next++) {
            const MeshChunk &chunk = meshes_->chunks[i];
            if (is_drawn[chunk.body])
                raster_chunk(*meshes_, chunk, view, sums.data() + pixels * chunk.channel);
        }
    });
}

void RasterPaths::resolve_row(const View &view, const PixelRect &rect, int row, PathForm form,
                              PathPictures &pictures)
{
    const std::size_t pixels = static_cast<std::size_t>(view.size) * view.size,
                      begin = static_cast<std::size_t>(row) * view.size;
    for (const MeshChannel &channel : meshes_->channels)
        for (int material : {channel.own, channel.parent})
            if (material >= 0) std::fill_n(pictures[material].data() + begin + rect.x0, rect.x1 - rect.x0, 0);
    for (std::size_t channel = 0; channel < meshes_->channels.size(); ++channel) {
        const MeshChannel &of = meshes_->channels[channel];
        std::int32_t *own = pictures[of.own].data() + begin;
        std::int32_t *parent = of.parent >= 0 ? pictures[of.parent].data() + begin : nullptr;
        for (const std::vector<std::int32_t> &sums : sums_) {
            const std::int32_t *sum = sums.data() + pixels * channel + begin;
            for (int x = rect.x0; x < rect.x1; ++x) own[x] += sum[x];
            if (!parent) continue;
            for (int x = rect.x0; x < rect.x1; ++x) parent[x] -= sum[x];
        }
    }
    if (form == PathForm::axis_sums) return;
    for (std::vector<std::int32_t> &picture : pictures)
        if (!picture.empty()) finish_row(view, row, rect.x0, rect.x1, picture.data() + begin);
}

bool RasterPaths::draw(const View &view, std::span<const std::uint8_t> is_drawn, const PixelRect &rect,
                       PathForm form, PathPictures &pictures, std::string &)
{
    if (rect.is_empty()) return true;
    sum_chunks(view, is_drawn);
    run_on_threads(threads_, [&](int thread) {
        const RowRange rows = rows_of_thread(thread, threads_, rect.y1 - rect.y0);
        for (int row = rows.begin; row < rows.end; ++row)
            resolve_row(view, rect, rect.y0 + row, form, pictures);
    });
    return true;
}

} // namespace seld
