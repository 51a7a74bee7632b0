// Draws the panels of dose, injector and inflator; the injector shows the flow limit of the lumen, and the
// inflator the balloon's compliance chart.
#include "host/base/format.hpp"
#include "host/effects/lumen_pressure.hpp"
#include "host/patient/balloon.hpp"
#include "host/picture/room_text.hpp"
#include "host/suite/suite_screen.hpp"
#include <algorithm>
#include <cmath>
#include <vector>

namespace crn
{
namespace
{

constexpr double kPa_per_psi = 6.894757, kPa_per_bar = 100.0;

} // namespace

void SuiteScreen::draw_dose(const UiRect &place)
{
    ui_.begin_panel("dose", place, "X-RAY AND DOSE");
    const Room &room = view_->state->room;
    const DoseMeter &dose = room.dose();
    const RoomState state = room.state();
    using enum ControlId;
    if (dose.kerma_rate_mGy_min() > 0.0) {
        ImGui::SameLine();
        ui_.small_text(tint::yellow, "   %.1f mGy/min", dose.kerma_rate_mGy_min());
    }
    const double kerma_mGy = dose.total().air_kerma_uGy * 1e-3;
    ui_.text(tint::text, "%.*f mGy   %.2f Gy cm\u00b2   %.1f min", kerma_mGy < 100.0 ? 1 : 0, kerma_mGy,
             dose.total().kap_Gy_cm2, dose.fluoro_ticks() / 60e3);
    ui_.tooltip("Reference air kerma, kerma-area product, and time of fluoroscopy, since the session began.");
    const float third = (place.width / ui_.px(1.0f) - 30.0f) / 3.0f;
    ui_.button(fluoro, "Fluoro", third, state.is_beam_on);
    ImGui::SameLine();
    ui_.button(acquire, state.program == RunKind::dsa ? "DSA" : "Cine", third);
    ImGui::SameLine();
    ui_.button(fluoro_latch, "stays on", third, ui_.input().is_latched());
    const bool is_dsa = state.program == RunKind::dsa;
    const bool is_roadmap = view_->live && view_->live->status.roadmap != RoadmapState::off;
    ImGui::PushFont(ui_.fonts().small_text);
    ui_.button(fluoro_rate, formatted("Fluoro %g/s", state.fluoro_pulses_per_s).c_str(), 88.0f);
    ImGui::SameLine();
    ui_.button(acquire_rate,
               formatted("%s %g/s", is_dsa ? "DSA" : "Cine", state.program_pulses_per_s).c_str(), 72.0f);
    ImGui::SameLine();
    ui_.button(program, is_dsa ? "To cine" : "To DSA", 54.0f);
    ImGui::SameLine();
    ui_.button(roadmap, nullptr, -1.0f, is_roadmap);
    ImGui::PopFont();
    ui_.end_panel();
}

void SuiteScreen::draw_syringe(const UiRect &place)
{
    ui_.begin_panel("syringe", place, "SYRINGE AND PICTURES");
    const SuiteState &state = *view_->state;
    using enum ControlId;
    const double flow_ml_s = ui_.input().injection_ml_s();
    const float half = (place.width / ui_.px(1.0f) - 30.0f) / 3.0f;
    ui_.button(inject, "Inject", half, state.contrast_ml_s > 0.0);
    ImGui::SameLine();
    ui_.button(aspirate, nullptr, half);
    ImGui::SameLine();
    ui_.button(inject_rate, formatted("%g ml/s", flow_ml_s).c_str(), half);
    if (!state.injection_kPa_per_ml_s) {
        ui_.small_text(tint::dim, "no device on the line has a lumen");
    } else {
        const double needed_kPa = *state.injection_kPa_per_ml_s * flow_ml_s;
        const double most_ml_s = injection_pressure_max_kPa / *state.injection_kPa_per_ml_s;
        const bool is_too_much = needed_kPa > injection_pressure_max_kPa;
        if (!std::isfinite(needed_kPa))
            ui_.small_text(tint::red, "the lumen is closed: nothing passes");
        else
            ui_.small_text(
                is_too_much ? tint::red : tint::text,
                "given %.3g ml;  %g ml/s needs %.0f of %.0f psi\nthis lumen passes at most %.2g ml/s",
                state.contrast_ml, flow_ml_s, needed_kPa / kPa_per_psi,
                injection_pressure_max_kPa / kPa_per_psi, most_ml_s);
    }
    const float quarter = (place.width / ui_.px(1.0f) - 36.0f) / 4.0f;
    ImGui::SetCursorScreenPos({place.x + ui_.px(9.0f), place.y + place.height - ui_.px(33.0f)});
    ui_.button(frame_back, "<", quarter);
    ImGui::SameLine();
    ui_.button(loop, nullptr, quarter);
    ImGui::SameLine();
    ui_.button(frame_on, ">", quarter);
    ImGui::SameLine();
    ui_.button(mask, nullptr, quarter);
    ui_.end_panel();
}

void SuiteScreen::draw_inflator(const UiRect &place)
{
    ui_.begin_panel("inflator", place, "INFLATOR");
    const std::optional<std::size_t> tool = balloon_tool(*view_->tools);
    if (!tool) {
        ui_.small_text(tint::dim, "no device on the line has a balloon");
        ui_.end_panel();
        return;
    }
    const SuiteState &state = *view_->state;
    const double bar = state.core.balloon_kPa / kPa_per_bar,
                 widest_mm = state.core.balloon_diameter_max_um * 1e-3,
                 waist_mm = state.core.balloon_diameter_min_um * 1e-3;
    const bool is_burst = state.core.balloon_bits != 0;
    ImGui::SameLine();
    ui_.text(is_burst     ? tint::red
             : bar > 0.05 ? tint::orange
                          : tint::text,
             is_burst ? "  BURST" : "  %.1f bar   %.2f mm", bar, widest_mm);
    ui_.note_last_item("pressure", is_burst ? "BURST" : formatted("%.1f bar   %.2f mm", bar, widest_mm));
    if (!is_burst && widest_mm - waist_mm > 0.05) {
        ImGui::SameLine();
        ui_.small_text(tint::text, "waist %.2f mm", waist_mm);
    }
    if (!state.stent.empty()) {
        ui_.small_text(tint::text, "stent %s", state.stent.c_str());
        ui_.note_last_item("stent", state.stent);
    }
    using enum ControlId;
    const float third = (place.width / ui_.px(1.0f) - 30.0f) / 3.0f;
    const float top = ImGui::GetCursorScreenPos().y;
    const float buttons = ui_.px(36.0f);
    draw_chart(
        {place.x + ui_.px(9.0f), top, place.width - ui_.px(18.0f), place.y + place.height - buttons - top},
        (*view_->tools)[*tool]);
    ImGui::SetCursorScreenPos({place.x + ui_.px(9.0f), place.y + place.height - ui_.px(31.0f)});
    ui_.button(inflate, nullptr, third);
    ImGui::SameLine();
    ui_.button(deflate, nullptr, third);
    ImGui::SameLine();
    ui_.button(load_stent, nullptr, third);
    ui_.end_panel();
}

// Draws the balloon's compliance chart: diameter over pressure, with nominal and rated burst pressure, and
// the present state.
void SuiteScreen::draw_chart(const UiRect &place, const Instrument &tool)
{
    if (place.height < ui_.px(30.0f)) return;
    ImDrawList *draw = ImGui::GetWindowDrawList();
    draw->AddRectFilled({place.x, place.y}, {place.x + place.width, place.y + place.height},
                        tint::background);
    const crn_wire_instrument &table = tool.table;
    if (table.balloon_count < 2) return;
    const crn_wire_balloon_point &first = table.balloon[0], &last = table.balloon[table.balloon_count - 1];
    const double high_kPa = std::max<double>(table.balloon_burst_kPa, last.pressure_kPa) * 1.05;
    const double low_mm = first.diameter_um * 1e-3 * 0.93, high_mm = last.diameter_um * 1e-3 * 1.05;
    const auto at = [&](double kPa, double mm) {
        return ImVec2{
            place.x + place.width * static_cast<float>(kPa / high_kPa),
            place.y + place.height *
                          static_cast<float>(1.0 - std::clamp((mm - low_mm) / (high_mm - low_mm), 0.0, 1.0))};
    };
    std::vector<ImVec2> points;
    for (std::uint16_t i = 0; i < table.balloon_count; ++i)
        points.push_back(at(table.balloon[i].pressure_kPa, table.balloon[i].diameter_um * 1e-3));
    draw->AddPolyline(points.data(), static_cast<int>(points.size()), tint::sky, 0, ui_.px(2.0f));
    ImGui::PushFont(ui_.fonts().small_text);
    const auto mark = [&](double kPa, ImU32 colour, const char *name) {
        const float x = at(kPa, low_mm).x;
        draw->AddLine({x, place.y}, {x, place.y + place.height}, colour);
        draw->AddText({x + ui_.px(3.0f), place.y + place.height - ui_.px(30.0f)}, colour,
                      formatted("%s\n%.0f bar", name, kPa / kPa_per_bar).c_str());
    };
    // Marks the largest and the smallest diameter of the balloon's table at their heights in the chart.
    const float line = ImGui::GetFontSize();
    for (const crn_wire_balloon_point *point : {&first, &last}) {
        const double mm = point->diameter_um * 1e-3;
        const float y = at(0.0, mm).y;
        draw->AddLine({place.x, y}, {place.x + ui_.px(6.0f), y}, tint::dim);
        draw->AddText({place.x + ui_.px(9.0f), point == &last ? std::max(y - 0.5f * line, place.y) : y},
                      tint::dim, formatted("%.2f mm", mm).c_str());
    }
    if (tool.balloon) {
        mark(tool.balloon->nominal_kPa, tint::green, "nominal");
        mark(tool.balloon->rated_burst_kPa, tint::red, "rated burst");
    }
    ImGui::PopFont();
    const crn_wire_tick_state &core = view_->state->core;
    draw->AddCircleFilled(at(core.balloon_kPa, core.balloon_diameter_max_um * 1e-3), ui_.px(5.0f),
                          tint::orange);
}

} // namespace crn
