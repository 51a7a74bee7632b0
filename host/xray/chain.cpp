// From path lengths to the signal at the detector: attenuation, scatter, what automatic exposure measures.
#include "host/xray/chain.hpp"
#include "host/xray/parallel.hpp"
#include <algorithm>
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

void attenuate(XrayChain &chain)
{
    const std::size_t pixels = static_cast<std::size_t>(chain.size) * chain.size;
    chain.primary.resize(pixels);
    run_on_threads(chain.threads, [&](int thread) {
        const RowRange rows = rows_of_thread(thread, chain.threads, chain.size);
        for (int row = rows.begin; row < rows.end; ++row) {
            std::array<const std::int32_t *, material_count> paths{};
            const std::size_t begin = static_cast<std::size_t>(row) * chain.size;
            for (int m = 0; m < material_count; ++m)
                if (!chain.paths.bodies()[m].empty()) paths[m] = chain.paths.bodies()[m].data() + begin;
            transmission_row(paths, chain.size, chain.primary.data() + begin);
        }
    });
}

void add_scatter(XrayChain &chain)
{
    const std::size_t pixels = static_cast<std::size_t>(chain.size) * chain.size;
    chain.scatter_slow = slow_part(chain.primary, chain.size, chain.open);
    for (float &value : chain.scatter_slow) value *= scatter_to_primary;
    chain.signal.resize(pixels);
    chain.log_signal.resize(pixels);
    run_on_threads(chain.threads, [&](int thread) {
        const RowRange rows = rows_of_thread(thread, chain.threads, chain.size);
        for (int row = rows.begin; row < rows.end; ++row) {
            const std::size_t begin = static_cast<std::size_t>(row) * chain.size;
            float *signal = chain.signal.data() + begin, *logarithm = chain.log_signal.data() + begin;
            slow_row(chain.scatter_slow, chain.size, row, signal);
            for (int x = 0; x < chain.size; ++x) {
                signal[x] = signal[x] + chain.primary[begin + x];
                logarithm[x] = log2_positive(signal[x] + 1e-9f);
            }
        }
    });
    chain.log_slow = slow_part(chain.log_signal, chain.size, chain.open);
}

// Mean of log2(signal) in 1/65536, so that its sum is exact.
void measure_exposure(XrayChain &chain)
{
    const double half = 0.5 * chain.size, reach = half * measuring_field;
    std::int64_t sum = 0, count = 0;
    for (int row = 0; row < chain.size; ++row) {
        const double y = row + 0.5 - half;
        for (int x = chain.open[row].begin; x < chain.open[row].end; ++x) {
            const double dx = x + 0.5 - half;
            if (dx * dx + y * y > reach * reach) continue;
            sum += static_cast<std::int64_t>(
                chain.log_signal[static_cast<std::size_t>(row) * chain.size + x] * 65536.0f);
            ++count;
        }
    }
    chain.log_mean = count > 0 ? static_cast<double>(sum) / static_cast<double>(count) / 65536.0 : 0.0;
}

} // namespace

void attenuate_tools(XrayChain &chain)
{
    const ToolPaths &tools = chain.paths.tools();
    const PathPictures &bodies = chain.paths.bodies();
    chain.tool_signal.resize(tools.pixels.size());
    std::vector<float> scatter(chain.size);
    int scatter_row = -1;
    for (std::size_t i = 0; i < tools.pixels.size(); ++i) {
        const std::int32_t pixel = tools.pixels[i];
        std::array<float, material_count> path{};
        for (int m = 0; m < material_count; ++m)
            if (!bodies[m].empty()) path[m] = static_cast<float>(bodies[m][pixel]);
        for (std::size_t k = 0; k < tools.materials.size(); ++k) {
            float &of_material = path[static_cast<int>(tools.materials[k])];
            of_material += static_cast<float>(tools.sum(i, k)) * (1.0f / tool_rays);
            of_material = std::max(of_material, 0.0f); // no more can be displaced than there is
        }
        const int row = pixel / chain.size;
        if (row != scatter_row) slow_row(chain.scatter_slow, chain.size, row, scatter.data());
        scatter_row = row;
        chain.tool_signal[i] = transmission(path) + scatter[pixel % chain.size];
    }
}

void see(XrayChain &chain, const XraySettings &settings, std::span<const RadiopaqueInstrument> tools,
         const WireFrame &wire)
{
    const XrayBeam &beam = settings.beam;
    const bool are_paths_new = chain.paths.see(settings.carm, settings.size, tools, wire);
    chain.was_kept = !are_paths_new && chain.circular_field == beam.circular_field &&
                     chain.collimator_share == beam.collimator_share;
    if (chain.was_kept) return;
    chain.size = settings.size;
    chain.circular_field = beam.circular_field;
    chain.collimator_share = beam.collimator_share;
    chain.open.resize(settings.size);
    for (int row = 0; row < settings.size; ++row) chain.open[row] = open_columns(beam, settings.size, row);
    attenuate(chain);
    add_scatter(chain);
    measure_exposure(chain);
}

} // namespace seld
