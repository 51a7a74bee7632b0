// Computes the signal at the detector from path lengths: attenuation, blur, scatter, and the measurement for
// automatic exposure.
#include "host/xray/chain.hpp"
#include "host/xray/float_math.hpp"
#include "host/xray/paths/lanes.hpp"
#include "host/xray/paths/parallel.hpp"
#include "host/xray/scatter.hpp"
#include <algorithm>
#include <cmath>

namespace crn
{
namespace
{

// Each thread receives whole cells of the coarse grid, so that a single thread adds all rows of a cell, in
// order.
constexpr int rows_at_once = 4 * coarse_cell;

double pixel_mm(const XrayChain &chain)
{
    return chain.paths.view().pixel_m * 1e3;
}

// Computes the transmission of each pixel, which is the fraction of the open beam's signal that the bodies
// let through. While a row of transmissions is in the processor's cache, its values are also added to the
// cells of the coarse grid.
CoarseSums attenuate(XrayChain &chain)
{
    CoarseSums sums(chain.size / coarse_cell);
    chain.transmission.resize(static_cast<std::size_t>(chain.size) * chain.size);
    run_on_rows(chain.threads, chain.size, rows_at_once, [&](const RowRange &rows) {
        for (int row = rows.begin; row < rows.end; ++row) {
            std::array<const std::int32_t *, material_count> paths{};
            const std::size_t begin = static_cast<std::size_t>(row) * chain.size;
            for (int m = 0; m < material_count; ++m)
                if (!chain.paths.bodies()[m].empty()) paths[m] = chain.paths.bodies()[m].data() + begin;
            transmission_row(chain.beam, paths, chain.size, chain.transmission.data() + begin);
            sums.add_row(chain.transmission.data() + begin, chain.size, row, chain.open[row]);
        }
    });
    return sums;
}

// Computes scatter from the sums over the coarse grid's cells before the blur, because the blur of focal spot
// and pixel does not change these sums.
void scatter(XrayChain &chain, const CoarseSums &transmitted, bool is_on)
{
    const int cells = chain.size / coarse_cell;
    if (!is_on) {
        chain.scatter_cells.assign(static_cast<std::size_t>(cells) * cells, 0.0f);
        return;
    }
    chain.scatter_cells = scatter_part(transmitted, cells, pixel_mm(chain) * coarse_cell);
    for (float &value : chain.scatter_cells) value *= grid_scatter_to_primary;
}

CRN_WIDE void add_row(int size, float *primary, float *signal, float *logarithm)
{
    for (int x = 0; x < size; ++x) {
        primary[x] = primary[x] > 0.0f ? primary[x] : 0.0f; // the kernels have negative taps
        signal[x] = signal[x] + primary[x];
        logarithm[x] = log2_positive(signal[x] + 1e-9f);
    }
}

// Returns the columns of a row that automatic exposure measures: those that the collimator leaves open inside
// the round measuring field.
OpenColumns measured_columns(const XrayChain &chain, int row)
{
    const double half = 0.5 * chain.size, reach = half * measuring_field_share, y = row + 0.5 - half;
    const double square = reach * reach - y * y;
    if (square < 0.0) return {};
    const double width = std::sqrt(square);
    return {std::max(static_cast<int>(std::ceil(half - width - 0.5)), chain.open[row].begin),
            std::min(static_cast<int>(std::floor(half + width - 0.5)) + 1, chain.open[row].end)};
}

// Adds logarithms as whole multiples of 1/65536, so that their sum is exact in any order.
CRN_WIDE std::int64_t sum_of_logarithms(const float *logarithm, int count)
{
    std::int64_t sum = 0;
    for (int x = 0; x < count; ++x) sum += static_cast<std::int32_t>(logarithm[x] * 65536.0f);
    return sum;
}

void blur_add_and_measure(XrayChain &chain)
{
    const View &view = chain.paths.view();
    const BlurGeometry geometry{pixel_mm(chain), chain.key.technique.focal_spot_mm,
                                view.source_detector_m / view.source_isocentre_m};
    if (!chain.kernels || !(chain.kernels->geometry == geometry)) chain.kernels = kernels_of(geometry);
    const BlurKernel &kernel = chain.kernels->before_photons;
    const std::size_t pixels = static_cast<std::size_t>(chain.size) * chain.size;
    chain.primary.resize(pixels);
    chain.signal.resize(pixels);
    CoarseSums logarithms(chain.size / coarse_cell);
    std::vector<std::int64_t> sums(chain.size, 0);
    std::vector<std::int64_t> counts(chain.size, 0);
    run_on_rows(chain.threads, chain.size, rows_at_once, [&](const RowRange &rows) {
        std::vector<float> scratch(chain.size + 2 * blur_radius_max), logarithm(chain.size);
        for (int row = rows.begin; row < rows.end; ++row) {
            const std::size_t begin = static_cast<std::size_t>(row) * chain.size;
            float *primary = chain.primary.data() + begin;
            float *signal = chain.signal.data() + begin;
            blur_row(chain.transmission.data(), chain.size, row, kernel, scratch.data(), primary);
            slow_row(chain.scatter_cells, chain.size, row, signal);
            add_row(chain.size, primary, signal, logarithm.data());
            logarithms.add_row(logarithm.data(), chain.size, row, chain.open[row]);
            const OpenColumns measured = measured_columns(chain, row);
            if (measured.begin >= measured.end) continue;
            counts[row] = measured.end - measured.begin;
            sums[row] = sum_of_logarithms(logarithm.data() + measured.begin, measured.end - measured.begin);
        }
    });
    std::int64_t sum = 0, count = 0;
    for (int row = 0; row < chain.size; ++row) {
        sum += sums[row];
        count += counts[row];
    }
    chain.log_mean = count > 0 ? static_cast<double>(sum) / static_cast<double>(count) / 65536.0 : 0.0;
    chain.log_slow = slow_part(std::move(logarithms), chain.size / coarse_cell);
}

// Divides the picture into a grid of `cells` by `cells` squares. Returns the transmission of the middle pixel
// of each square, and leaves out squares whose middle the collimator covers.
CoarseSums sample_cells(const XrayChain &chain, const BeamTable &beam, int cells)
{
    const int cell = chain.size / cells, padded = (cells + 15) / 16 * 16;
    CoarseSums samples(cells);
    std::vector<std::int32_t> gathered(static_cast<std::size_t>(padded) * material_count);
    std::vector<float> share(padded);
    for (int cy = 0; cy < cells; ++cy) {
        const int row = cy * cell + cell / 2;
        std::array<const std::int32_t *, material_count> paths{};
        for (int m = 0; m < material_count; ++m) {
            if (chain.paths.bodies()[m].empty()) continue;
            const std::int32_t *from =
                chain.paths.bodies()[m].data() + static_cast<std::size_t>(row) * chain.size + cell / 2;
            std::int32_t *line = gathered.data() + static_cast<std::size_t>(m) * padded;
            for (int cx = 0; cx < cells; ++cx) line[cx] = from[cx * cell];
            paths[m] = line;
        }
        transmission_row(beam, paths, padded, share.data());
        for (int cx = 0; cx < cells; ++cx) {
            const int x = cx * cell + cell / 2;
            if (x < chain.open[row].begin || x >= chain.open[row].end) continue;
            samples.sum[cy * cells + cx] = share[cx] * (coarse_cell * coarse_cell);
            samples.count[cy * cells + cx] = coarse_cell * coarse_cell;
        }
    }
    return samples;
}

// Estimates, from about 32 x 32 pixels, the mean of log2(signal) over the measuring field (the open beam's
// signal is 1). blur_add_and_measure computes this mean from all pixels.
double sampled_log_mean(const XrayChain &chain, const BeamTable &beam, bool with_scatter)
{
    int cell = coarse_cell;
    while (chain.size % (2 * cell) == 0 && chain.size / (2 * cell) >= 32) cell *= 2;
    const int cells = chain.size / cell;
    const CoarseSums samples = sample_cells(chain, beam, cells);
    std::vector<float> scattered(samples.sum.size(), 0.0f);
    if (with_scatter) scattered = scatter_part(samples, cells, pixel_mm(chain) * cell);
    double sum = 0.0, count = 0.0;
    for (int cy = 0; cy < cells; ++cy) {
        const OpenColumns measured = measured_columns(chain, cy * cell + cell / 2);
        for (int cx = 0; cx < cells; ++cx) {
            const int x = cx * cell + cell / 2, i = cy * cells + cx;
            if (x < measured.begin || x >= measured.end) continue;
            sum += static_cast<double>(log2_positive(samples.sum[i] * (1.0f / (coarse_cell * coarse_cell)) +
                                                     grid_scatter_to_primary * scattered[i] + 1e-9f));
            count += 1.0;
        }
    }
    return count > 0.0 ? sum / count : 0.0;
}

SignalKey key_of(const XraySettings &settings, const XrayTechnique &technique)
{
    SignalKey key;
    key.technique.tube_voltage_kV = technique.tube_voltage_kV;
    key.technique.copper_mm = technique.copper_mm;
    key.technique.focal_spot_mm = technique.focal_spot_mm;
    key.scatter = settings.beam.scatter;
    key.circular_field = settings.beam.circular_field;
    key.open_width_share = settings.beam.open_width_share;
    key.open_height_share = settings.beam.open_height_share;
    return key;
}

} // namespace

XraySettings held_settings(const XraySettings &settings)
{
    XraySettings held = settings;
    held.carm = clamp_carm(settings.carm);
    held.size = held_size(settings.size);
    held.beam.open_width_share = std::clamp(settings.beam.open_width_share, 0.05, 1.0);
    held.beam.open_height_share = std::clamp(settings.beam.open_height_share, 0.05, 1.0);
    held.beam.dose_per_frame_nGy = std::clamp(settings.beam.dose_per_frame_nGy, 0.1, 1e5);
    held.beam.frame_period_ms = std::clamp(settings.beam.frame_period_ms, 1.0, 1e4);
    if (held.beam.fixed_technique) held.beam.fixed_technique = held_technique(*held.beam.fixed_technique);
    return held;
}

ExposureDemand demand_of(const XraySettings &settings)
{
    return {settings.beam.mode, settings.beam.dose_per_frame_nGy, settings.beam.frame_period_ms,
            settings.carm.source_detector_m, settings.carm.source_isocentre_m};
}

void see_paths(XrayChain &chain, const XraySettings &settings, const XrayFrame &frame)
{
    const bool are_new = chain.paths.see(settings.carm, settings.size, frame);
    const SignalKey field = key_of(settings, {});
    const bool is_field_new = chain.size != settings.size ||
                              chain.key.circular_field != field.circular_field ||
                              chain.key.open_width_share != field.open_width_share ||
                              chain.key.open_height_share != field.open_height_share;
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
    const CoarseSums transmitted = attenuate(chain);
    scatter(chain, transmitted, settings.beam.scatter);
    blur_add_and_measure(chain);
    chain.is_filled = true;
}

ExposureChoice expose_bodies(XrayChain &chain, const XraySettings &settings, ExposureState *state)
{
    const ExposureDemand demand = demand_of(settings);
    ExposureChoice choice;
    if (settings.beam.fixed_technique)
        choice.technique = *settings.beam.fixed_technique;
    else if (state)
        choice = chain.exposure.choose(demand, *state);
    else
        choice = settle_exposure(chain, settings, demand);
    see_signal(chain, settings, choice.technique);
    if (!settings.beam.fixed_technique && state)
        chain.exposure.follow(choice.technique, exp2_double(chain.log_mean), *state);
    return choice;
}

} // namespace crn
