// Draws the haemodynamics strip: the electrocardiogram in green, the arterial pressure in red, the heart
// rate, systolic/diastolic (mean) pressure, the oxygen saturation in cyan, and alarms.
#include "host/base/format.hpp"
#include "host/suite/suite_screen.hpp"
#include <algorithm>
#include <cmath>
#include <vector>

namespace crn
{
namespace
{

// The alarm limits are assumed values, usual for adults at rest.
constexpr double rate_low = 40.0, rate_high = 130.0, systolic_low = 80.0, systolic_high = 180.0;
constexpr float numbers_width = 300.0f, saturation_width = 84.0f;
constexpr std::size_t gap_samples = 24; // between the newest and the oldest sample
constexpr double pressure_low_mmHg = 0.0, pressure_high_mmHg = 200.0;

struct PulseLane {
    UiRect place;
    double low, high; // values at its lower and upper edge
    ImU32 colour;
    float thick;
};

// Draws one trace from left to right, as a monitor does: new samples replace the old ones. Every column of
// the trace shows the range of its samples, so that no peak is lost.
template <class Value>
void draw_trace(ImDrawList *draw, const PulseMonitor &pulse, const PulseLane &lane, Value value)
{
    const auto &samples = pulse.samples();
    const std::size_t newest = pulse.newest();
    const auto y_of = [&](double v) {
        const double share = std::clamp((v - lane.low) / (lane.high - lane.low), 0.0, 1.0);
        return lane.place.y + lane.place.height * static_cast<float>(1.0 - share);
    };
    const float step = lane.place.width / static_cast<float>(samples.size());
    std::vector<ImVec2> points;
    const auto flush = [&] {
        if (points.size() > 1)
            draw->AddPolyline(points.data(), static_cast<int>(points.size()), lane.colour, 0, lane.thick);
        points.clear();
    };
    for (std::size_t i = 0; i < samples.size(); ++i) {
        const bool is_new = i <= newest, is_old = pulse.is_full() && i > newest + gap_samples;
        if (!is_new && !is_old) {
            flush();
            continue;
        }
        points.push_back({lane.place.x + step * static_cast<float>(i), y_of(value(samples[i]))});
    }
    flush();
}

} // namespace

void SuiteScreen::draw_strip(const UiRect &place)
{
    ui_.begin_panel("strip", place, "");
    ImDrawList *draw = ImGui::GetWindowDrawList();
    if (!view_->has_patient) {
        const char *text = "Free space: no patient, so there is no ECG, pressure or saturation.";
        const ImVec2 size = ImGui::CalcTextSize(text);
        draw->AddText({place.x + 0.5f * (place.width - size.x), place.y + 0.5f * (place.height - size.y)},
                      tint::dim, text);
        ui_.note("no patient", place, text);
        return ui_.end_panel();
    }
    const PulseMonitor &pulse = view_->state->pulse;
    const float pad = ui_.px(8.0f), width = place.width - ui_.px(numbers_width) - 2.0f * pad;
    const float scale_width = ui_.px(30.0f);
    const float lane_h = 0.5f * (place.height - 3.0f * pad);
    const UiRect ecg{place.x + pad + scale_width, place.y + pad, width - scale_width, lane_h};
    const UiRect art{ecg.x, ecg.y + lane_h + pad, ecg.width, lane_h};
    draw->AddRectFilled({place.x + pad, ecg.y}, {ecg.x + ecg.width, art.y + art.height},
                        IM_COL32(8, 10, 12, 255));
    ImGui::PushFont(ui_.fonts().small_text);
    draw->AddText({place.x + pad + ui_.px(3.0f), ecg.y + ui_.px(1.0f)}, tint::green, "II");
    for (int mmHg : {0, 100, 200}) {
        const float y = art.y + art.height * (1.0f - static_cast<float>(mmHg) / 200.0f);
        draw->AddLine({art.x, y}, {art.x + art.width, y}, IM_COL32(50, 40, 44, 255));
        const std::string text = std::to_string(mmHg);
        const ImVec2 size = ImGui::CalcTextSize(text.c_str());
        const float text_y = std::clamp(y - 0.5f * size.y, art.y, art.y + art.height - size.y);
        draw->AddText({art.x - size.x - ui_.px(3.0f), text_y}, tint::dim, text.c_str());
    }
    ImGui::PopFont();
    if (pulse.has_samples()) {
        draw_trace(draw, pulse, {ecg, -0.6, 1.6, tint::green, ui_.px(1.6f)},
                   [](const PulseMonitor::Sample &s) { return s.ecg_mV; });
        draw_trace(draw, pulse, {art, pressure_low_mmHg, pressure_high_mmHg, tint::red, ui_.px(1.6f)},
                   [](const PulseMonitor::Sample &s) { return s.pressure_mmHg; });
    }
    draw_pressure_numbers(
        {place.x + place.width - ui_.px(numbers_width), place.y, ui_.px(numbers_width), place.height});
    draw_saturation(
        {place.x + place.width - ui_.px(saturation_width), place.y, ui_.px(saturation_width), place.height});
    ui_.end_panel();
}

// Without a pulse the finger sensor cannot measure an oxygen saturation.
void SuiteScreen::draw_saturation(const UiRect &place)
{
    const PulseMonitor &pulse = view_->state->pulse;
    oximeter_.look(view_->state->tick, pulse.holds_breath());
    const double saturation = oximeter_.saturation_pct();
    ImGui::SetCursorScreenPos({place.x, place.y + ui_.px(7.0f)});
    ImGui::BeginGroup();
    ImGui::PushFont(ui_.fonts().large);
    if (pulse.rate_per_min() > 0.0)
        ui_.text(tint::cyan, "%.0f %%", saturation);
    else
        ui_.text(tint::cyan, "-- %%");
    ImGui::PopFont();
    ui_.small_text(tint::cyan, "SpO\u2082");
    if (saturation < Oximeter::low_pct) ui_.text(tint::yellow, "** LOW");
    ImGui::EndGroup();
}

// An alarm has a sign besides its colour: *** means that help is needed at once, and ** that attention is
// needed.
void SuiteScreen::draw_pressure_numbers(const UiRect &place)
{
    const PulseMonitor &pulse = view_->state->pulse;
    const double rate = pulse.rate_per_min(), high = pulse.systolic_mmHg(), low = pulse.diastolic_mmHg();
    const bool has_pulse = pulse.has_samples();
    ImGui::SetCursorScreenPos({place.x + ui_.px(6.0f), place.y + ui_.px(7.0f)});
    ImGui::BeginChild("numbers", {place.width - ui_.px(10.0f), place.height - ui_.px(10.0f)}, false,
                      ImGuiWindowFlags_NoInputs | ImGuiWindowFlags_NoScrollbar);
    ImGui::PushFont(ui_.fonts().large);
    ui_.text(tint::green, rate > 0.0 ? "%.0f" : "--", rate);
    ImGui::PopFont();
    ImGui::SameLine();
    ui_.small_text(tint::green, "beats/min");
    if (has_pulse && rate <= 0.0) {
        ImGui::SameLine();
        ui_.text(tint::red, "*** NO BEAT");
    } else if (has_pulse && (rate < rate_low || rate > rate_high)) {
        ImGui::SameLine();
        ui_.text(tint::yellow, rate < rate_low ? "** SLOW" : "** FAST");
    }
    ImGui::PushFont(ui_.fonts().large);
    if (high > 0.0)
        ui_.text(tint::red, "%.0f/%.0f (%.0f)", high, low, (high + 2.0 * low) / 3.0);
    else
        ui_.text(tint::red, "--/-- (--)");
    ImGui::PopFont();
    const bool is_damped = view_->state->is_pressure_damped;
    const bool is_low = high > 0.0 && high < systolic_low;
    if (is_damped)
        ui_.text(tint::yellow, "** DAMPED: withdraw");
    else if (is_low || high > systolic_high)
        ui_.text(tint::yellow, is_low ? "** PRESSURE LOW" : "** PRESSURE HIGH");
    else
        ui_.small_text(tint::red, "arterial pressure, mmHg");
    if (pulse.holds_breath()) {
        ImGui::SameLine();
        ui_.small_text(tint::cyan, "* BREATH HELD");
    }
    ImGui::EndChild();
}

} // namespace crn
