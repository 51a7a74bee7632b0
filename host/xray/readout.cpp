// The read-out works row by row on all threads, because each row depends only on the photons of neighbouring
// rows.
#include "host/xray/readout.hpp"
#include "host/xray/lag.hpp"
#include "host/xray/paths/lanes.hpp"
#include "host/xray/paths/parallel.hpp"
#include <algorithm>
#include <cmath>

namespace crn
{
namespace
{

struct Curve {
    float slope, level, keep_slow, log_mean, log_open; // logarithms to base 2
    float grey_scale, grey_offset;
};

Curve make_curve(const XrayChain &chain, const XrayDisplay &display, const XrayPicture &picture)
{
    Curve curve;
    curve.slope = static_cast<float>(1.05 * std::clamp(display.contrast, 0.1, 10.0));
    curve.level = static_cast<float>(0.12 + std::clamp(display.brightness, -1.0, 1.0));
    curve.keep_slow = static_cast<float>(1.0 - std::clamp(display.harmonise, 0.0, 1.0));
    curve.log_mean = static_cast<float>(chain.log_mean);
    curve.log_open = log2_positive(static_cast<float>(picture.photons_open * picture.raw_per_photon));
    const double window = std::clamp(display.window, 2.0, 1e5), level = std::clamp(display.level, -1e5, 1e5);
    const double scale = 255.0 / (window - 1.0); // PS3.3 C.11.2.1.2.1
    curve.grey_scale = static_cast<float>(scale);
    curve.grey_offset = static_cast<float>(0.5 * 255.0 - (level - 0.5) * scale + 0.5);
    return curve;
}

CRN_WIDE void quantise_row(const float *signal, int size, float gain, std::uint16_t *raw)
{
    for (int x = 0; x < size; ++x) {
        const float value = signal[x] * gain + 0.5f;
        const float low = value > 0.0f ? value : 0.0f;
        const float held = low < static_cast<float>(raw_max) ? low : static_cast<float>(raw_max);
        raw[x] = static_cast<std::uint16_t>(static_cast<std::int32_t>(held));
    }
}

// Computes the displayed value: takes the logarithm of the signal, reduces its slow changes over the picture,
// and applies an S-curve. Pixels with few photons (bone, metal) are dark. Window and level follow.
CRN_WIDE void display_row(const Curve &curve, const std::uint16_t *raw, const float *slow, int size,
                          std::uint16_t *shown, std::uint8_t *grey)
{
    for (int x = 0; x < size; ++x) {
        const float signal = static_cast<float>(static_cast<std::int32_t>(raw[x])) + 0.5f;
        const float share_log2 = log2_positive(signal) - curve.log_open;
        const float value = (share_log2 - slow[x]) + curve.keep_slow * (slow[x] - curve.log_mean);
        const float t = value * curve.slope + curve.level;
        const float s = t / std::sqrt(1.0f + t * t); // -1 .. 1
        const auto place = static_cast<std::int32_t>(2048.0f + 2047.0f * s);
        shown[x] = static_cast<std::uint16_t>(place);
        const float on_screen = static_cast<float>(place) * curve.grey_scale + curve.grey_offset;
        const float low = on_screen > 0.0f ? on_screen : 0.0f;
        grey[x] = static_cast<std::uint8_t>(static_cast<std::int32_t>(low < 255.0f ? low : 255.0f));
    }
}

} // namespace

void read_out(const XrayChain &chain, const XrayDisplay &display, XrayMemory *memory, XrayPicture &picture)
{
    const int size = chain.size;
    const std::size_t pixels = static_cast<std::size_t>(size) * size;
    picture.raw.resize(pixels);
    picture.shown.resize(pixels);
    picture.grey.resize(pixels);
    const Curve curve = make_curve(chain, display, picture);
    const BlurKernel &kernel = chain.kernels->scintillator;
    const float released = memory ? lag_released_share(picture.tick - memory->tick) : 0.0f;
    const auto gain = static_cast<float>(picture.raw_per_photon);
    run_on_rows(chain.threads, size, 32, [&](const RowRange &rows) {
        std::vector<float> scratch(size + 2 * blur_radius_max), signal(size), slow(size);
        for (int row = rows.begin; row < rows.end; ++row) {
            const std::size_t begin = static_cast<std::size_t>(row) * size;
            blur_row(picture.photons.data(), size, row, kernel, scratch.data(), signal.data());
            if (memory) lag_row(released, size, memory->trapped.data() + begin, signal.data());
            std::uint16_t *raw = picture.raw.data() + begin, *shown = picture.shown.data() + begin;
            std::uint8_t *grey = picture.grey.data() + begin;
            quantise_row(signal.data(), size, gain, raw);
            slow_row(chain.log_slow, size, row, slow.data());
            display_row(curve, raw, slow.data(), size, shown, grey);
            const OpenColumns open = chain.open[row];
            std::fill(shown, shown + open.begin, std::uint16_t{0});
            std::fill(shown + open.end, shown + size, std::uint16_t{0});
            std::fill(grey, grey + open.begin, std::uint8_t{0});
            std::fill(grey + open.end, grey + size, std::uint8_t{0});
        }
    });
}

} // namespace crn
