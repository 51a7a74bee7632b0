// From path lengths to the signal at the detector: attenuation, blur, scatter, what automatic exposure measures.
#include "host/xray/chain.hpp"
#include "host/xray/lanes.hpp"
#include "host/xray/parallel.hpp"
#include "host/xray/scatter.hpp"
#include <algorithm>
#include <cmath>

namespace seld
{
namespace
{

double pixel_mm(const XrayChain &chain)
{
    return chain.paths.view().pixel_m * 1e3;
}

void attenuate(XrayChain &chain)
{
    chain.transmission.resize(static_cast<std::size_t>(chain.size) * chain.size);
    run_on_threads(chain.threads, [&](int thread) {
        const RowRange rows = rows_of_thread(thread, chain.threads, chain.size);
        for (int row = rows.begin; row < rows.end; ++row) {
            std::array<const std::int32_t *, material_count> paths{};
            const std::size_t begin = static_cast<std::size_t>(row) * chain.size;
            for (int m = 0; m < material_count; ++m)
                if (!chain.paths.bodies()[m].empty()) paths[m] = chain.paths.bodies()[m].data() + begin;
            transmission_row(chain.beam, paths, chain.size, chain.transmission.data() + begin);
        }
    });
}

// Scatter comes from sums over cells, which focal spot and pixel do not change.
void scatter(XrayChain &chain, bool is_on)
{
    if (!is_on) {
        const std::size_t cells = chain.size / coarse_cell;
        chain.scatter_cells.assign(cells * cells, 0.0f);
        return;
    }
    chain.scatter_cells = scatter_part(coarse_sums(chain.transmission, chain.size, chain.open),
                                       chain.size / coarse_cell, pixel_mm(chain) * coarse_cell);
    for (float &value : chain.scatter_cells) value *= grid_scatter_to_primary;
}

SELD_WIDE void add_row(int size, float *primary, float *signal, float *logarithm)
{
    for (int x = 0; x < size; ++x) {
        primary[x] = primary[x] > 0.0f ? primary[x] : 0.0f; // the kernels have negative taps
        signal[x] = signal[x] + primary[x];
        logarithm[x] = log2_positive(signal[x] + 1e-9f);
    }
}

void blur_and_add(XrayChain &chain)
{
    const View &view = chain.paths.view();
    const BlurKernel kernel = kernel_before_photons({pixel_mm(chain), chain.key.technique.focal_spot_mm,
                                                     view.source_detector_m / view.source_isocentre_m});
    const std::size_t pixels = static_cast<std::size_t>(chain.size) * chain.size;
    chain.primary.resize(pixels);
    chain.signal.resize(pixels);
    chain.log_signal.resize(pixels);
    run_on_threads(chain.threads, [&](int thread) {
        std::vector<float> scratch(chain.size + 2 * blur_radius_max);
        const RowRange rows = rows_of_thread(thread, chain.threads, chain.size);
        for (int row = rows.begin; row < rows.end; ++row) {
            const std::size_t begin = static_cast<std::size_t>(row) * chain.size;
            float *primary = chain.primary.data() + begin;
            float *signal = chain.signal.data() + begin, *logarithm = chain.log_signal.data() + begin;
            blur_row(chain.transmission.data(), chain.size, row, kernel, scratch.data(), primary);
            slow_row(chain.scatter_cells, chain.size, row, signal);
            add_row(chain.size, primary, signal, logarithm);
        }
    });
    chain.log_slow = slow_part(chain.log_signal, chain.size, chain.open);
}

bool is_measured(double x, double y, double half)
{
    const double reach = half * measuring_field_share;
    return (x - half) * (x - half) + (y - half) * (y - half) <= reach * reach;
}

// Mean of logarithms in 1/65536, so that the sum is exact in any order.
class LogMean
{
  public:
    void add(float log2_signal)
    {
        sum_ += static_cast<std::int64_t>(log2_signal * 65536.0f);
        ++count_;
    }
    double value() const
    {
        return count_ > 0 ? static_cast<double>(sum_) / static_cast<double>(count_) / 65536.0 : 0.0;
    }

  private:
    std::int64_t sum_ = 0, count_ = 0;
};

void measure_exposure(XrayChain &chain)
{
    const double half = 0.5 * chain.size;
    LogMean mean;
    for (int row = 0; row < chain.size; ++row)
        for (int x = chain.open[row].begin; x < chain.open[row].end; ++x)
            if (is_measured(x + 0.5, row + 0.5, half))
                mean.add(chain.log_signal[static_cast<std::size_t>(row) * chain.size + x]);
    chain.log_mean = mean.value();
}

// Transmission of one pixel of each cell of the coarse grid, where it is open.
CoarseSums sample_cells(const XrayChain &chain, const BeamTable &beam)
{
    const int cells = chain.size / coarse_cell, padded = (cells + 15) / 16 * 16;
    CoarseSums samples;
    samples.sum.assign(static_cast<std::size_t>(cells) * cells, 0.0f);
    samples.count.assign(samples.sum.size(), 0.0f);
    std::vector<std::int32_t> gathered(static_cast<std::size_t>(padded) * material_count);
    std::vector<float> share(padded);
    for (int cy = 0; cy < cells; ++cy) {
        const int row = cy * coarse_cell + coarse_cell / 2;
        std::array<const std::int32_t *, material_count> paths{};
        for (int m = 0; m < material_count; ++m) {
            if (chain.paths.bodies()[m].empty()) continue;
            std::int32_t *line = gathered.data() + static_cast<std::size_t>(m) * padded;
            for (int cx = 0; cx < cells; ++cx)
                line[cx] = chain.paths.bodies()[m][static_cast<std::size_t>(row) * chain.size +
                                                   cx * coarse_cell + coarse_cell / 2];
            paths[m] = line;
        }
        transmission_row(beam, paths, padded, share.data());
        for (int cx = 0; cx < cells; ++cx) {
            const int x = cx * coarse_cell + coarse_cell / 2;
            if (x < chain.open[row].begin || x >= chain.open[row].end) continue;
            samples.sum[cy * cells + cx] = share[cx] * (coarse_cell * coarse_cell);
            samples.count[cy * cells + cx] = coarse_cell * coarse_cell;
        }
    }
    return samples;
}

// What measure_exposure would find, from one pixel per cell: log2 of the share.
double sampled_log_mean(const XrayChain &chain, const BeamTable &beam, bool with_scatter)
{
    const int cells = chain.size / coarse_cell;
    const CoarseSums samples = sample_cells(chain, beam);
    std::vector<float> scattered(samples.sum.size(), 0.0f);
    if (with_scatter) scattered = scatter_part(samples, cells, pixel_mm(chain) * coarse_cell);
    LogMean mean;
    for (int cy = 0; cy < cells; ++cy)
        for (int cx = 0; cx < cells; ++cx) {
            const int i = cy * cells + cx;
            if (!(samples.count[i] > 0.0f) || !is_measured(cx + 0.5, cy + 0.5, 0.5 * cells)) continue;
            mean.add(log2_positive(samples.sum[i] * (1.0f / (coarse_cell * coarse_cell)) +
                                   grid_scatter_to_primary * scattered[i] + 1e-9f));
        }
    return mean.value();
}

SignalKey key_of(const XraySettings &settings, const XrayTechnique &technique)
{
    SignalKey key;
    key.technique.tube_voltage_kV = technique.tube_voltage_kV;
    key.technique.copper_mm = technique.copper_mm;
    key.technique.focal_spot_mm = technique.focal_spot_mm;
    key.scatter = settings.beam.scatter;
    key.circular_field = settings.beam.circular_field;
    key.collimator_share = settings.beam.collimator_share;
    return key;
}

// Several rays through each pixel: what they let through is averaged, since a mean of lengths would let thin metal through
// too little.
float behind_tools(const XrayChain &chain, std::size_t touched)
{
    const ToolPaths &tools = chain.paths.tools();
    const PathPictures &bodies = chain.paths.bodies();
    const std::int32_t pixel = tools.pixels[touched];
    float exponent[beam_energy_count][tool_rays];
    for (int k = 0; k < beam_energy_count; ++k) {
        float body = 0.0f;
        for (int m = 0; m < material_count; ++m)
            if (!bodies[m].empty())
                body += chain.beam.log2_per_q10mm[m][k] * static_cast<float>(bodies[m][pixel]);
        for (int ray = 0; ray < tool_rays; ++ray) exponent[k][ray] = body;
    }
    for (std::size_t slot = 0; slot < tools.materials.size(); ++slot) {
        const int m = static_cast<int>(tools.materials[slot]);
        const std::int32_t there = bodies[m].empty() ? 0 : bodies[m][pixel];
        const std::int32_t *length = tools.q10mm.data() + touched * tools.ints_per_pixel() + slot * tool_rays;
        float added[tool_rays];
        for (int ray = 0; ray < tool_rays; ++ray) // no more can be displaced than there is
            added[ray] = static_cast<float>(std::max(length[ray], -there));
        for (int k = 0; k < beam_energy_count; ++k)
            for (int ray = 0; ray < tool_rays; ++ray)
                exponent[k][ray] += chain.beam.log2_per_q10mm[m][k] * added[ray];
    }
    float sum = 0.0f;
    for (int k = 0; k < beam_energy_count; ++k) {
        float part = 0.0f;
        for (int ray = 0; ray < tool_rays; ++ray)
            part += exp2_negative(exponent[k][ray] > 0.0f ? exponent[k][ray] : 0.0f);
        sum += chain.beam.share[k] * part;
    }
    return sum * (1.0f / tool_rays);
}

} // namespace

void see_paths(XrayChain &chain, const XraySettings &settings, const XrayFrame &frame)
{
    const bool are_new = chain.paths.see(settings.carm, settings.size, frame);
    const SignalKey field = key_of(settings, {});
    const bool is_field_new = chain.size != settings.size ||
                              chain.key.circular_field != field.circular_field ||
                              chain.key.collimator_share != field.collimator_share;
    if (!are_new && !is_field_new) return;
    chain.is_filled = chain.is_settled = false;
    chain.size = settings.size;
    chain.open.resize(settings.size);
    for (int row = 0; row < settings.size; ++row)
        chain.open[row] = open_columns(settings.beam, settings.size, row);
}

ExposureChoice settle_exposure(XrayChain &chain, const XraySettings &settings, const ExposureDemand &demand)
{
    const SignalKey key = key_of(settings, {});
    if (chain.is_settled && chain.settled_demand == demand && chain.settled_key == key) return chain.settled;
    ExposureState state;
    ExposureChoice choice = chain.exposure.choose(demand, state);
    for (int round = 0; round < 8; ++round) {
        const XrayTechnique before = choice.technique;
        const BeamTable &beam = chain.exposure.table(before.tube_voltage_kV, before.copper_mm);
        const double log_mean = sampled_log_mean(chain, beam, settings.beam.scatter);
        chain.exposure.jump(before, exp2_double(log_mean), state);
        choice = chain.exposure.choose(demand, state);
        if (choice.technique == before) break;
    }
    chain.is_settled = true;
    chain.settled_demand = demand;
    chain.settled_key = key;
    chain.settled = choice;
    return choice;
}

void see_signal(XrayChain &chain, const XraySettings &settings, const XrayTechnique &technique)
{
    const SignalKey key = key_of(settings, technique);
    chain.was_kept = chain.is_filled && chain.key == key;
    if (chain.was_kept) return;
    chain.key = key;
    chain.beam = chain.exposure.table(technique.tube_voltage_kV, technique.copper_mm);
    attenuate(chain);
    scatter(chain, settings.beam.scatter);
    blur_and_add(chain);
    measure_exposure(chain);
    chain.is_filled = true;
}

void attenuate_tools(XrayChain &chain)
{
    const ToolPaths &tools = chain.paths.tools();
    const int count = static_cast<int>(tools.pixels.size());
    chain.tool_signal.resize(count);
    run_on_threads(count > 500 ? chain.threads : 1, [&](int thread) {
        const RowRange range =
            count > 500 ? rows_of_thread(thread, chain.threads, count) : RowRange{0, count};
        for (int i = range.begin; i < range.end; ++i) {
            const std::int32_t pixel = tools.pixels[i];
            // The bodies' own softness stays; a pixel that bodies make quite black stays so.
            const float body = std::max(chain.transmission[pixel], 1e-12f);
            const float left = std::min(behind_tools(chain, i) / body, 1e3f);
            const float scattered = chain.signal[pixel] - chain.primary[pixel];
            chain.tool_signal[i] = chain.primary[pixel] * left + scattered;
        }
    });
}

} // namespace seld
