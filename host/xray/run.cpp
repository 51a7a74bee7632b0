#include "host/xray/run.hpp"
#include "host/xray/float_math.hpp"
#include <algorithm>
#include <cmath>

namespace crn
{

namespace
{

constexpr float steps_per_octave = 65535.0f / 16.0f; // log2(65536) = 16 fills the range

std::uint16_t logarithm(float value)
{
    return static_cast<std::uint16_t>(
        std::clamp(steps_per_octave * log2_positive(1.0f + value) + 0.5f, 0.0f, 65535.0f));
}

// The logarithm changes the edges of the display window in the same way as the pixel values. A display window
// that reaches beyond the range of pixel values is limited to that range.
void move_window(XrayRun &run)
{
    const auto moved = [](double value) {
        return static_cast<double>(logarithm(static_cast<float>(std::clamp(value, 0.0, 65535.0))));
    };
    const double low = moved(run.window_centre - run.window_width / 2);
    const double high = moved(run.window_centre + run.window_width / 2);
    run.window_centre = (low + high) / 2;
    run.window_width = std::max(high - low, 1.0);
}

} // namespace

const std::vector<std::uint16_t> &logarithm_table()
{
    static const std::vector<std::uint16_t> table = [] {
        std::vector<std::uint16_t> values(65536);
        for (std::size_t i = 0; i < values.size(); i++) values[i] = logarithm(static_cast<float>(i));
        return values;
    }();
    return table;
}

void make_logarithmic(XrayRun &run)
{
    if (run.relation != PixelRelation::linear || run.bits != 16) return;
    const std::vector<std::uint16_t> &table = logarithm_table();
    for (RunFrame &frame : run.frames)
        for (std::uint16_t &value : frame.raw) value = table[value];
    run.to_linear.resize(65536);
    for (std::size_t i = 0; i < run.to_linear.size(); i++) {
        const float octaves = static_cast<float>(i) / steps_per_octave;
        run.to_linear[i] = static_cast<std::uint16_t>(
            std::clamp(65536.0f * exp2_negative(16.0f - octaves) - 1.0f + 0.5f, 0.0f, 65535.0f));
    }
    run.relation = PixelRelation::logarithmic;
    if (run.window_width > 0.0) move_window(run);
}

} // namespace crn
