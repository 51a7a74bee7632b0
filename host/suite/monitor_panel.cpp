// Draws the live and the reference monitor, and the goals of a case beside the live one. The texts stand
// beside the pictures, never over the anatomy.
#include "host/base/format.hpp"
#include "host/picture/room_text.hpp"
#include "host/suite/pages.hpp"
#include "host/suite/prep_page.hpp"
#include "host/suite/suite_screen.hpp"
#include "host/suite/ui_text.hpp"
#include <algorithm>
#include <array>
#include <cmath>

namespace crn
{
namespace
{

constexpr std::size_t live_slot = 0, reference_slot = 1;
constexpr float gutter = 148.0f, case_gutter = 240.0f; // beside the live picture; with a case
constexpr float letter_band = 18.0f;                   // for the letters of the patient's sides
constexpr double window_min = 0.05, window_max = 4.0;
constexpr double notch_um = 2000.0;

ImVec2 centred(const UiRect &place, const ImVec2 &size)
{
    return {place.x + 0.5f * (place.width - size.x), place.y + 0.5f * (place.height - size.y)};
}

} // namespace

std::vector<std::uint8_t> GreyRange::shown(const std::vector<std::uint8_t> &grey) const
{
    std::array<std::uint8_t, 256> table{};
    for (std::size_t i = 0; i < table.size(); ++i) {
        const double share = (static_cast<double>(i) / 255.0 - level) / window + 0.5;
        table[i] = static_cast<std::uint8_t>(std::lround(255.0 * std::clamp(share, 0.0, 1.0)));
    }
    std::vector<std::uint8_t> result(grey.size());
    std::transform(grey.begin(), grey.end(), result.begin(),
                   [&](std::uint8_t value) { return table[value]; });
    return result;
}

void GreyRange::drag(double right, double up)
{
    window = std::clamp(window * std::exp(2.0 * right), window_min, window_max);
    level = std::clamp(level + up, 0.0, 1.0);
}

// Draws a picture in the middle of a rectangle, either as large as fits, or with one pixel of the picture on
// one pixel of the screen. `shown` receives the rectangle that the picture occupies on the screen.
void SuiteScreen::draw_picture(std::size_t slot, const MonitorPicture &picture, const UiRect &place,
                               bool is_sharp, UiRect &shown)
{
    ImDrawList *draw = ImGui::GetWindowDrawList();
    const float edge = std::min(place.width, place.height);
    const float size = is_sharp ? static_cast<float>(picture.size) : edge;
    const ImVec2 at = centred(place, {size, size});
    shown = {std::floor(at.x), std::floor(at.y), size, size};
    draw->AddRectFilled({place.x, place.y}, {place.x + place.width, place.y + place.height},
                        IM_COL32(8, 10, 12, 255));
    if (picture.grey.empty()) {
        const char *none = slot == live_slot ? "No picture yet. Hold Space: fluoroscopy."
                                             : "Enter copies the live picture here.";
        const ImVec2 text = ImGui::CalcTextSize(none);
        draw->AddText(centred(place, text), tint::dim, none);
        return;
    }
    const bool is_changed = slot == live_slot && !range_.is_whole();
    // A new version number makes the texture load the picture again after the picture or its grey range has
    // changed. The version consists of the picture's number and the number of changes of the grey range; both
    // only grow, and the range changes at most once per drawing of the window.
    const std::uint64_t version = picture.number + (slot == live_slot ? range_changes_ << 32 : 0);
    if (is_changed && stretched_version_ != version) {
        stretched_ = range_.shown(picture.grey);
        stretched_version_ = version;
    }
    void *texture =
        ui_.window().texture(slot, picture.size, is_changed ? stretched_ : picture.grey, version, is_sharp);
    draw->PushClipRect({place.x, place.y}, {place.x + place.width, place.y + place.height}, true);
    draw->AddImage(texture, {shown.x, shown.y}, {shown.x + shown.width, shown.y + shown.height});
    draw->PopClipRect();
}

void SuiteScreen::draw_live(const UiRect &place)
{
    ui_.begin_panel("live", place, "");
    UiRect shown{};
    const float side = std::min(ui_.px(gutter), 0.2f * place.width);
    const float right = view_->lesson ? std::min(ui_.px(case_gutter), 0.3f * place.width) : side;
    const UiRect middle{place.x + side, place.y + ui_.px(18.0f), place.width - side - right,
                        place.height - ui_.px(36.0f)};
    const MonitorPicture none;
    const MonitorPicture &picture = view_->live ? *view_->live : none;
    ImGui::GetWindowDrawList()->AddRectFilled(
        {middle.x, middle.y}, {middle.x + middle.width, middle.y + middle.height}, IM_COL32(8, 10, 12, 255));
    const float band = ui_.px(letter_band);
    draw_picture(live_slot, picture, {middle.x + band, middle.y, middle.width - 2.0f * band, middle.height},
                 view_->is_pixel_by_pixel, shown);
    if (!picture.grey.empty()) draw_orientation(middle, shown);
    if (picture.status.is_beam_on) {
        ImDrawList *draw = ImGui::GetWindowDrawList();
        draw->AddRect({middle.x - 2.0f, middle.y - 2.0f},
                      {middle.x + middle.width + 2.0f, middle.y + middle.height + 2.0f}, tint::yellow, 0.0f,
                      0, ui_.px(2.0f));
    }
    draw_live_texts({place.x, place.y, side, place.height}, {place.x + place.width - right, place.y, right,
                                                             view_->lesson ? ui_.px(96.0f) : place.height});
    if (view_->lesson)
        draw_case(
            {place.x + place.width - right, place.y + ui_.px(100.0f), right, place.height - ui_.px(104.0f)});
    ImGui::SetCursorScreenPos({middle.x, middle.y});
    ImGui::InvisibleButton("live picture", {middle.width, middle.height});
    ui_.note_last_item("live picture");
    draw_grey_range(middle);
    if (ImGui::IsItemHovered() && ImGui::GetIO().MouseWheel != 0.0f) {
        const bool turns = ImGui::GetIO().KeyShift;
        const double notches = ImGui::GetIO().MouseWheel;
        actions_.drags.push_back({ui_.input().chosen_tool(),
                                  turns ? 0 : static_cast<std::int32_t>(notches * notch_um),
                                  turns ? static_cast<std::int32_t>(notches * counts_per_turn / 24) : 0});
    }
    ui_.end_panel();
}

// Dragging over the live picture changes its range of greys, and a double click resets the range.
void SuiteScreen::draw_grey_range(const UiRect &place)
{
    const ImVec2 way = ImGui::GetMouseDragDelta(ImGuiMouseButton_Left, 0.0f);
    if (ImGui::IsItemActive() && (way.x != 0.0f || way.y != 0.0f)) {
        const double edge = static_cast<double>(std::min(place.width, place.height));
        range_.drag(static_cast<double>(way.x) / edge, -static_cast<double>(way.y) / edge);
        ImGui::ResetMouseDragDelta(ImGuiMouseButton_Left);
        ++range_changes_;
    }
    if (ImGui::IsItemHovered() && ImGui::IsMouseDoubleClicked(ImGuiMouseButton_Left)) {
        range_ = {};
        ++range_changes_;
    }
    if (range_.is_whole()) return;
    const std::string text =
        formatted("W %.0f  L %.0f  (double click: reset)", rounded_to(range_.window * 100.0, 1.0),
                  rounded_to(range_.level * 100.0, 1.0));
    ImFont *font = ui_.fonts().small_text;
    ImGui::GetWindowDrawList()->AddText(font, font->FontSize,
                                        {place.x + ui_.px(4.0f), place.y + place.height + ui_.px(2.0f)},
                                        tint::sky, text.c_str());
}

// Writes the patient's sides around the picture: left and right in bands that the picture leaves free, above
// and below in the margin of the panel.
void SuiteScreen::draw_orientation(const UiRect &place, const UiRect &picture)
{
    const View view = make_view(clamp_carm(view_->live->status.carm), 16);
    const float band = ui_.px(letter_band), half_line = 0.5f * ImGui::GetFontSize();
    const auto letter = [&](const char *name, float x, float y, const std::string &text) {
        const ImVec2 size = ImGui::CalcTextSize(text.c_str());
        const UiRect at{x - 0.5f * size.x, y - half_line, size.x, 2.0f * half_line};
        ImGui::GetWindowDrawList()->AddText({at.x, at.y}, tint::text, text.c_str());
        ui_.note(name, at, text);
    };
    const float left = std::max(picture.x, place.x + band) - 0.5f * band;
    const float right = std::min(picture.x + picture.width, place.x + place.width - band) + 0.5f * band;
    const float x = place.x + 0.5f * place.width, y = place.y + 0.5f * place.height;
    letter("side above", x, place.y - ui_.px(9.0f), patient_side(view.up));
    letter("side below", x, place.y + place.height + ui_.px(9.0f), patient_side(-view.up));
    letter("side left", left, y, patient_side(-view.right));
    letter("side right", right, y, patient_side(view.right));
}

void SuiteScreen::draw_live_texts(const UiRect &left, const UiRect &right)
{
    const MonitorPicture none;
    const RoomStatus &status = view_->live ? view_->live->status : none.status;
    const RoomState room = view_->state->room.state();
    const auto begin = [&](const char *name, const UiRect &place) {
        ImGui::SetCursorScreenPos({place.x + ui_.px(8.0f), place.y + ui_.px(8.0f)});
        ImGui::BeginChild(name, {place.width - ui_.px(10.0f), place.height - ui_.px(16.0f)}, false,
                          ImGuiWindowFlags_NoInputs | ImGuiWindowFlags_NoScrollbar);
        ImGui::PushTextWrapPos(0.0f);
    };
    const auto finish = [] {
        ImGui::PopTextWrapPos();
        ImGui::EndChild();
    };
    begin("live left", left);
    // The kind and the rate of live pictures are written in the next line.
    const bool is_live = status.source == ScreenSource::live;
    ui_.text(room.is_beam_on ? tint::yellow : tint::dim, "%s",
             is_live ? "X-RAY ON" : state_text(status).c_str());
    for (const std::string &line : processing_texts(status)) ui_.text(tint::sky, "%s", line.c_str());
    if (status.source != ScreenSource::nothing) {
        ui_.small_text(tint::text, "%s  %g/s", name_of(status.kind), status.pulses_per_s);
        const XrayTechnique &with = room.technique;
        if (with.tube_voltage_kV > 0.0)
            ui_.small_text(room.is_underexposed ? tint::orange : tint::text, "%.0f kV\n%.0f mA\n%.1f ms",
                           with.tube_voltage_kV, with.tube_current_mA, with.pulse_ms);
    }
    if (view_->is_measured && view_->live && view_->live->pulses_left_out > 0)
        ui_.small_text(tint::orange, "%llu pulses not drawn",
                       static_cast<unsigned long long>(view_->live->pulses_left_out));
    finish();
    begin("live right", right);
    ui_.text(room.is_blocked  ? tint::red
             : room.is_moving ? tint::orange
                              : tint::text,
             "%s", with_degrees(angles_text(room.carm)).c_str());
    ui_.small_text(tint::text, "SID %.0f cm\nfield %.0f cm", room.carm.source_detector_m * 100.0,
                   room.carm.field_m * 100.0);
    if (room.is_blocked) ui_.text(tint::red, "TABLE IN THE WAY");
    if (room.follows_tip) ui_.small_text(tint::dim, "table follows the tip");
    finish();
}

// Draws the goals of a case and their state, its limits, and hints on demand. No marks are shown during a
// session, because trainees remember feedback better if they get it at the end (docs/assessment.md).
void SuiteScreen::draw_case(const UiRect &place)
{
    const Case &lesson = *view_->lesson;
    ImGui::SetCursorScreenPos({place.x + ui_.px(8.0f), place.y});
    ImGui::BeginChild("case", {place.width - ui_.px(12.0f), place.height});
    ImGui::PushTextWrapPos(0.0f);
    ui_.small_text(tint::dim, "GOALS");
    for (std::size_t i = 0; i < lesson.goals.size(); ++i) {
        const CaseGoal &goal = lesson.goals[i];
        const GoalResult *result = view_->goals && i < view_->goals->size() ? &(*view_->goals)[i] : nullptr;
        const bool is_reached = result && result->is_reached;
        ui_.small_text(is_reached ? tint::green : tint::text, "%s %s", is_reached ? "\u25cf" : "\u25cb",
                       goal.text.c_str());
        if (result && !result->found.empty())
            ui_.tooltip("wanted: " + goal.expectation.plain_text() +
                        "\nnow: " + without_remedy(result->found));
        const std::string name = "goal " + std::to_string(i + 1);
        if (is_reached) ui_.note_last_item(name + " reached");
        ui_.note_last_item(name, result ? without_remedy(result->found) : "");
    }
    if (!lesson.limits.empty()) {
        ui_.small_text(tint::dim, "LIMITS");
        for (const CaseLimit &limit : lesson.limits)
            ui_.small_text(tint::dim, "%s", limit_text(limit).c_str());
    }
    const std::size_t hints = lesson.hints.size();
    if (hints > 0) {
        const std::size_t shown = std::min(view_->hints_shown, hints);
        if (shown < hints) {
            const std::string label = formatted("Hint %zu of %zu", shown + 1, hints);
            ui_.button(ControlId::hint, label.c_str());
        }
        for (std::size_t i = 0; i < shown; ++i) ui_.small_text(tint::yellow, "%s", lesson.hints[i].c_str());
    }
    ImGui::PopTextWrapPos();
    ImGui::EndChild();
}

void SuiteScreen::draw_reference(const UiRect &place)
{
    ui_.begin_panel("reference", place, "REFERENCE");
    const MonitorPicture none;
    const MonitorPicture &picture = view_->reference ? *view_->reference : none;
    if (!picture.grey.empty()) {
        ImGui::SameLine();
        ui_.small_text(tint::text, "  %s",
                       picture.status.run > 0 ? state_text(picture.status).c_str()
                                              : "copy of the live picture");
    }
    UiRect shown{};
    const float head = ui_.px(26.0f), foot = ui_.px(36.0f);
    draw_picture(reference_slot, picture, {place.x, place.y + head, place.width, place.height - head - foot},
                 false, shown);
    ImGui::SetCursorScreenPos({place.x + ui_.px(8.0f), place.y + place.height - ui_.px(31.0f)});
    ui_.button(ControlId::to_reference, "Copy live");
    ImGui::SameLine();
    ui_.button(ControlId::reference_run, "Next run");
    ImGui::SameLine();
    ui_.button(ControlId::reference_off, "Clear");
    ui_.end_panel();
}

} // namespace crn
