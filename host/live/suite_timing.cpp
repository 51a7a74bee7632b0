#include "host/live/suite_timing.hpp"
#include "host/base/pending_file.hpp"
#include <algorithm>
#include <nlohmann/json.hpp>

namespace crn
{
namespace
{

// Returns the value below which this share of the values lies, or null if `values` is empty.
nlohmann::ordered_json delay_quantile(std::vector<double> values, double share)
{
    if (values.empty()) return nullptr;
    std::sort(values.begin(), values.end());
    return values[std::min(values.size() - 1,
                           static_cast<std::size_t>(share * static_cast<double>(values.size())))];
}

} // namespace

// The delay of an input ends when the window first shows an X-ray pulse that came after the input.
void SuiteTiming::take(const SuiteState &state, const MonitorPicture *live, SuiteClock::time_point now)
{
    ++screens_;
    last_ = now;
    pace_ = state.pace;
    if (!live || live->pulses == pulses_) return;
    if (!has_pulses_) {
        has_pulses_ = true;
        first_pulse_ = now;
        first_pulses_ = live->pulses;
    }
    pulses_ = live->pulses;
    left_out_ = live->pulses_left_out;
    last_pulse_ = now;
    if (live->asked == SuiteClock::time_point{} || live->asked == asked_) return;
    asked_ = live->asked;
    inputs_.push_back({asked_, now});
}

void SuiteTiming::write(const std::string &path) const
{
    using Seconds = std::chrono::duration<double>;
    const double pulse_s = Seconds(last_pulse_ - first_pulse_).count();
    nlohmann::ordered_json json;
    json["seconds"] = Seconds(last_ - begin_).count();
    json["ticks"] = pace_.ticks;
    json["late_ticks"] = pace_.late_ticks;
    json["tick_late_pct"] =
        pace_.ticks > 0 ? 100.0 * static_cast<double>(pace_.late_ticks) / static_cast<double>(pace_.ticks)
                        : 0.0;
    json["lost_s"] = pace_.lost_s;
    json["scheduling"] = text_of(pace_.urgency);
    json["pictures"] = pulses_;
    json["pictures_left_out"] = left_out_;
    json["pictures_per_s"] = pulse_s > 0.0 ? static_cast<double>(pulses_ - first_pulses_) / pulse_s : 0.0;
    json["screens_per_s"] = static_cast<double>(screens_) / std::max(Seconds(last_ - begin_).count(), 1e-3);
    std::vector<double> delays_ms;
    nlohmann::ordered_json times = nlohmann::ordered_json::array();
    for (const Shown &input : inputs_) {
        delays_ms.push_back(Seconds(input.shown - input.read).count() * 1e3);
        times.push_back({Seconds(input.read.time_since_epoch()).count(),
                         Seconds(input.shown.time_since_epoch()).count()});
    }
    json["hand_to_picture"] = {{"inputs", delays_ms.size()},
                               {"p50_ms", delay_quantile(delays_ms, 0.5)},
                               {"p95_ms", delay_quantile(delays_ms, 0.95)},
                               {"read_and_shown_s", times}}; // by the machine's monotonic clock
    write_whole_file(path, json.dump(2) + "\n");
}

} // namespace crn
