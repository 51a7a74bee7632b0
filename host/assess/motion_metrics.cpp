#include "host/assess/motion_metrics.hpp"
#include "host/assess/session_log.hpp"
#include <algorithm>
#include <cmath>
#include <unsupported/Eigen/FFT>

namespace crn
{

namespace
{

// Returns the amplitude spectrum of a profile from zero to `cut_Hz`, divided by the largest amplitude.
std::vector<double> amplitudes(std::span<const double> profile, std::size_t bins, std::size_t kept)
{
    std::vector<double> padded(profile.begin(), profile.end());
    padded.resize(bins, 0.0);
    std::vector<std::complex<double>> spectrum;
    Eigen::FFT<double> transform;
    transform.fwd(spectrum, padded);
    std::vector<double> found;
    double most = 0.0;
    for (std::size_t i = 0; i < spectrum.size(); ++i) {
        most = std::max(most, std::abs(spectrum[i]));
        if (i < kept) found.push_back(std::abs(spectrum[i]));
    }
    for (double &amplitude : found) amplitude = most > 0.0 ? amplitude / most : 0.0;
    return found;
}

} // namespace

double sparc(std::span<const double> speed, double rate_Hz, const SparcSettings &settings)
{
    if (speed.size() < 2 || std::all_of(speed.begin(), speed.end(), [](double v) { return v == 0.0; }))
        return 0.0;
    std::size_t bins = 1;
    while (bins < speed.size()) bins *= 2;
    bins <<= settings.pad_level;
    const double step_Hz = rate_Hz / static_cast<double>(bins);
    const auto kept = static_cast<std::size_t>(std::floor(settings.cut_Hz / step_Hz)) + 1;
    const std::vector<double> amplitude = amplitudes(speed, bins, std::min(kept, bins));
    std::size_t first = amplitude.size(), last = 0;
    for (std::size_t i = 0; i < amplitude.size(); ++i) {
        if (amplitude[i] < settings.amplitude_threshold) continue;
        first = std::min(first, i);
        last = i;
    }
    if (first >= last) return 0.0;
    double length = 0.0;
    for (std::size_t i = first; i < last; ++i)
        length += std::hypot(1.0 / static_cast<double>(last - first), amplitude[i + 1] - amplitude[i]);
    return -length;
}

double ldlj(std::span<const double> speed, double rate_Hz)
{
    if (speed.size() < 3) return 0.0;
    double peak = 0.0, sum = 0.0;
    for (double v : speed) peak = std::max(peak, std::fabs(v));
    for (std::size_t i = 1; i + 1 < speed.size(); ++i)
        sum += std::pow((speed[i + 1] - 2.0 * speed[i] + speed[i - 1]) * rate_Hz * rate_Hz, 2);
    const double duration_s = static_cast<double>(speed.size()) / rate_Hz;
    if (peak == 0.0 || sum == 0.0) return 0.0;
    return -std::log(std::pow(duration_s, 3) / (peak * peak) * sum / rate_Hz);
}

int submovements(std::span<const double> speed, double prominence)
{
    double peak = 0.0;
    for (double v : speed) peak = std::max(peak, v);
    if (peak == 0.0) return 0;
    const double rise = prominence * peak;
    // A peak is counted if the speed has risen by `rise` from the last minimum and then falls by `rise`.
    int count = 0;
    bool rises = true;
    double low = 0.0, high = 0.0;
    for (double v : speed) {
        if (rises) {
            high = std::max(high, v);
            low = std::min(low, v);
            if (high - low >= rise && v <= high - rise) {
                ++count;
                rises = false;
                low = v;
            }
        } else {
            low = std::min(low, v);
            if (v >= low + rise) {
                rises = true;
                high = v;
            }
        }
    }
    return count + (rises && high - low >= rise);
}

std::vector<Movement> split_movements(std::span<const double> speed_mm_s, double rate_Hz,
                                      const MovementSettings &settings)
{
    std::vector<Movement> movements;
    const auto gap = static_cast<std::size_t>(std::lround(settings.pause_s * rate_Hz));
    for (std::size_t i = 0; i < speed_mm_s.size(); ++i) {
        if (speed_mm_s[i] < settings.pause_mm_s) continue;
        if (!movements.empty() && i - movements.back().end < gap)
            movements.back().end = i + 1;
        else
            movements.push_back({i, i + 1});
    }
    const auto least = static_cast<std::size_t>(std::lround(settings.least_s * rate_Hz));
    std::erase_if(movements, [&](const Movement &one) { return one.end - one.begin < least; });
    return movements;
}

std::vector<double> speed_of(std::span<const double> position, double rate_Hz, double sigma_s)
{
    std::vector<double> raw(position.size(), 0.0), smooth(position.size(), 0.0);
    for (std::size_t i = 1; i < position.size(); ++i)
        raw[i] = std::fabs(position[i] - position[i - 1]) * rate_Hz;
    const auto reach = static_cast<std::ptrdiff_t>(std::ceil(3.0 * sigma_s * rate_Hz));
    const auto size = static_cast<std::ptrdiff_t>(raw.size());
    std::vector<double> weights;
    for (std::ptrdiff_t k = -reach; k <= reach; ++k)
        weights.push_back(std::exp(-0.5 * std::pow(static_cast<double>(k) / (sigma_s * rate_Hz), 2)));
    for (std::ptrdiff_t i = 0; i < size; ++i) {
        double sum = 0.0, weight = 0.0;
        for (std::ptrdiff_t k = std::max(-reach, -i); k <= std::min(reach, size - 1 - i); ++k) {
            sum += weights[static_cast<std::size_t>(k + reach)] * raw[static_cast<std::size_t>(i + k)];
            weight += weights[static_cast<std::size_t>(k + reach)];
        }
        smooth[static_cast<std::size_t>(i)] = sum / weight;
    }
    return smooth;
}

namespace
{

void measure_paths(const SessionLog &log, std::size_t tool, MotionFigures &figures)
{
    PathLength<3> in_space(tip_step_mm);
    PathLength<2> in_picture(tip_step_px);
    PathLength<1> by_hand(0.0), turned(0.0);
    for (const SessionMoment &moment : log.moments) {
        const ToolMoment &one = moment.tools[tool];
        by_hand.add(PathLength<1>::Point(one.inserted_mm));
        turned.add(PathLength<1>::Point(one.turned_deg));
        if (one.has_tip) in_space.add(one.tip_mm);
        if (one.has_tip && moment.is_xray_on && one.is_in_picture && !moment.is_gantry_moving)
            in_picture.add({one.right_px, one.down_px});
        else
            in_picture.interrupt();
    }
    figures.hand_path_mm = by_hand.length();
    figures.hand_turn_deg = turned.length();
    figures.tip_path_mm = in_space.length();
    figures.tip_path_px = in_picture.length();
}

} // namespace

MotionFigures motion_of(const SessionLog &log, std::size_t tool)
{
    constexpr double rate_Hz = 1.0 / SessionLog::seconds_per_moment;
    MotionFigures figures;
    measure_paths(log, tool, figures);
    std::vector<double> inserted_mm;
    for (const SessionMoment &moment : log.moments) inserted_mm.push_back(moment.tools[tool].inserted_mm);
    const std::vector<double> speed = speed_of(inserted_mm, rate_Hz);
    double sum_sparc = 0.0, sum_ldlj = 0.0, sum_mm = 0.0;
    for (const Movement &movement : split_movements(speed, rate_Hz)) {
        const std::span<const double> part(speed.data() + movement.begin, movement.end - movement.begin);
        figures.movements++;
        figures.submovements += submovements(part);
        figures.moving_s += static_cast<double>(part.size()) / rate_Hz;
        sum_sparc += sparc(part, rate_Hz);
        sum_ldlj += ldlj(part, rate_Hz);
        for (double v : part) sum_mm += v / rate_Hz;
    }
    if (figures.movements == 0) return figures;
    figures.sparc = sum_sparc / figures.movements;
    figures.ldlj = sum_ldlj / figures.movements;
    figures.speed_mean_mm_s = sum_mm / figures.moving_s;
    return figures;
}

} // namespace crn
