// The part of a picture that only the patient and the C-arm decide.
#include "host/xray/cache.hpp"
#include "host/xray/parallel.hpp"
#include <atomic>
#include <cmath>

namespace seld
{
namespace
{

// Scattered photons behind an anti-scatter grid, relative to the local mean of the primary ones. Assumption; published
// figures for the trunk lie between .2 and .6.
constexpr float scatter_to_primary = 0.35f;
// Diameter of the field that the automatic exposure measures, share of the picture.
constexpr double measuring_field = 0.65;

void sum_triangles(XrayCache &cache)
{
    const std::size_t pixels = static_cast<std::size_t>(cache.size) * cache.size;
    const std::size_t channels = cache.meshes.channels.size();
    cache.sums.resize(cache.threads);
    std::atomic<std::size_t> next = 0;
    run_on_threads(cache.threads, [&](int thread) {
        std::vector<std::int32_t> &sums = cache.sums[thread];
        sums.assign(pixels * channels, 0);
        for (std::size_t i = next++; i < cache.meshes.chunks.size(); i = next++) {
            const RasterChunk &chunk = cache.meshes.chunks[i];
            raster_chunk(cache.meshes, chunk, cache.view, sums.data() + pixels * chunk.channel);
        }
    });
}

// Adds the sums of all threads into each channel's materials, and turns depth into distance along the ray.
void resolve_row(XrayCache &cache, int row)
{
    const int size = cache.size;
    const std::size_t pixels = static_cast<std::size_t>(size) * size,
                      begin = static_cast<std::size_t>(row) * size;
    for (std::size_t channel = 0; channel < cache.meshes.channels.size(); ++channel) {
        const RasterChannel &of = cache.meshes.channels[channel];
        std::int32_t *own = cache.paths[of.own].data() + begin;
        std::int32_t *parent = of.parent >= 0 ? cache.paths[of.parent].data() + begin : nullptr;
        for (const std::vector<std::int32_t> &sums : cache.sums) {
            const std::int32_t *sum = sums.data() + pixels * channel + begin;
            for (int x = 0; x < size; ++x) own[x] += sum[x];
            if (!parent) continue;
            for (int x = 0; x < size; ++x) parent[x] -= sum[x];
        }
    }
    const float focal = static_cast<float>(cache.view.source_detector_m / cache.view.pixel_m);
    const float y = static_cast<float>(row) + 0.5f - 0.5f * static_cast<float>(size);
    const float scale = 1.0f / focal, square = y * y + focal * focal;
    std::array<float, 2048> oblique;
    for (int x = 0; x < size; ++x) {
        const float dx = static_cast<float>(x) + 0.5f - 0.5f * static_cast<float>(size);
        oblique[x] = std::sqrt(dx * dx + square) * scale;
    }
    for (std::vector<std::int32_t> &path : cache.paths) {
        if (path.empty()) continue;
        std::int32_t *line = path.data() + begin;
        for (int x = 0; x < size; ++x) {
            const float length = static_cast<float>(line[x]) * oblique[x] + 0.5f;
            line[x] = static_cast<std::int32_t>(length > 0.0f ? length : 0.0f);
        }
    }
}

void clear_paths(XrayCache &cache)
{
    const std::size_t pixels = static_cast<std::size_t>(cache.size) * cache.size;
    for (auto &path : cache.paths) path.clear();
    for (const RasterChannel &channel : cache.meshes.channels) {
        cache.paths[channel.own].assign(pixels, 0);
        if (channel.parent >= 0) cache.paths[channel.parent].assign(pixels, 0);
    }
}

void attenuate(XrayCache &cache)
{
    const std::size_t pixels = static_cast<std::size_t>(cache.size) * cache.size;
    cache.primary.resize(pixels);
    run_on_threads(cache.threads, [&](int thread) {
        const RowRange rows = rows_of_thread(thread, cache.threads, cache.size);
        for (int row = rows.begin; row < rows.end; ++row) {
            resolve_row(cache, row);
            std::array<const std::int32_t *, material_count> paths{};
            const std::size_t begin = static_cast<std::size_t>(row) * cache.size;
            for (int m = 0; m < material_count; ++m)
                if (!cache.paths[m].empty()) paths[m] = cache.paths[m].data() + begin;
            transmission_row(paths, cache.size, cache.primary.data() + begin);
        }
    });
}

void add_scatter(XrayCache &cache)
{
    const std::size_t pixels = static_cast<std::size_t>(cache.size) * cache.size;
    cache.scatter_slow = slow_part(cache.primary, cache.size, cache.open);
    for (float &value : cache.scatter_slow) value *= scatter_to_primary;
    cache.signal.resize(pixels);
    cache.log_signal.resize(pixels);
    run_on_threads(cache.threads, [&](int thread) {
        const RowRange rows = rows_of_thread(thread, cache.threads, cache.size);
        for (int row = rows.begin; row < rows.end; ++row) {
            const std::size_t begin = static_cast<std::size_t>(row) * cache.size;
            float *signal = cache.signal.data() + begin, *logarithm = cache.log_signal.data() + begin;
            slow_row(cache.scatter_slow, cache.size, row, signal);
            for (int x = 0; x < cache.size; ++x) {
                signal[x] = signal[x] + cache.primary[begin + x];
                logarithm[x] = log2_positive(signal[x] + 1e-9f);
            }
        }
    });
    cache.log_slow = slow_part(cache.log_signal, cache.size, cache.open);
}

// Mean of log2(signal) in 1/65536, so that its sum is exact.
void measure_exposure(XrayCache &cache)
{
    const double half = 0.5 * cache.size, reach = half * measuring_field;
    std::int64_t sum = 0, count = 0;
    for (int row = 0; row < cache.size; ++row) {
        const double y = row + 0.5 - half;
        for (int x = cache.open[row].begin; x < cache.open[row].end; ++x) {
            const double dx = x + 0.5 - half;
            if (dx * dx + y * y > reach * reach) continue;
            sum += static_cast<std::int64_t>(
                cache.log_signal[static_cast<std::size_t>(row) * cache.size + x] * 65536.0f);
            ++count;
        }
    }
    cache.log_mean = count > 0 ? static_cast<double>(sum) / static_cast<double>(count) / 65536.0 : 0.0;
}

} // namespace

void fill_cache(XrayCache &cache, const XraySettings &settings)
{
    const XrayBeam &beam = settings.beam;
    cache.was_used = cache.is_filled && cache.carm == settings.carm && cache.size == settings.size &&
                     cache.circular_field == beam.circular_field &&
                     cache.collimator_share == beam.collimator_share;
    if (cache.was_used) return;
    cache.carm = settings.carm;
    cache.size = settings.size;
    cache.circular_field = beam.circular_field;
    cache.collimator_share = beam.collimator_share;
    cache.view = make_view(settings.carm, settings.size);
    cache.open.resize(settings.size);
    for (int row = 0; row < settings.size; ++row) cache.open[row] = open_columns(beam, settings.size, row);
    sum_triangles(cache);
    clear_paths(cache);
    attenuate(cache);
    add_scatter(cache);
    measure_exposure(cache);
    cache.is_filled = true;
}

} // namespace seld
