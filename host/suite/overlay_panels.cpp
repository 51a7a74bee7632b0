// Draws the bar at the top, the toasts (notices that appear for some seconds), and the help.
#include "host/base/format.hpp"
#include "host/picture/room_text.hpp"
#include "host/suite/suite_screen.hpp"
#include "host/suite/ui_text.hpp"
#include <algorithm>
#include <imgui_internal.h>

namespace crn
{
namespace
{

constexpr double toast_s = 6.0, toast_short_s = 2.5; // the latter if others wait
constexpr std::size_t toasts_max = 4;
constexpr double slow_factor = 0.97; // below this, the session is announced as slow

} // namespace

// Places notices side by side in a line below the live picture, so that they do not cover the picture.
struct NoticeLine {
    Ui &ui;
    float right = 0.0f; // pixels
    float x = 0.0f;     // of the next notice
    bool is_empty = true;

    // Draws a notice to the right of the previous one. If the line has no room for a notice that can wait,
    // draws nothing and returns false; a notice that cannot wait gets a line of its own.
    bool add(ImU32 colour, const std::string &text, bool needs_answer, bool can_wait)
    {
        const float gap = is_empty ? 0.0f : ui.px(24.0f), button = needs_answer ? ui.px(70.0f) : 0.0f;
        const float wide = ImGui::CalcTextSize(text.c_str()).x + button;
        const bool has_room = x + gap + wide <= right;
        if (!is_empty && !has_room && can_wait) return false;
        if (!is_empty && has_room)
            ImGui::SameLine(0.0f, gap);
        else
            x = 0.0f;
        if (x == 0.0f) ImGui::AlignTextToFramePadding();
        ui.text(colour, "%s", text.c_str());
        ui.note_last_item("notice", text);
        if (needs_answer) {
            ImGui::SameLine();
            ui.button(ControlId::acknowledge, "Seen");
        }
        x += gap + wide;
        is_empty = false;
        return true;
    }
};

void SuiteScreen::draw_bar(const UiRect &place)
{
    ui_.begin_panel("bar", place, "");
    const SuiteState &state = *view_->state;
    ImGui::SetCursorScreenPos({ui_.px(10.0f), ui_.px(8.0f)});
    ui_.text(tint::dim, "Cournand");
    ImGui::SameLine();
    ui_.text(tint::text, "%s", view_->title.c_str());
    ImGui::SameLine(place.width * 0.34f);
    ui_.text(tint::text, "%s", session_clock(state.tick * 1e-3).c_str());
    ui_.note_last_item("clock", session_clock(state.tick * 1e-3));
    ImGui::SameLine();
    const double factor = view_->is_measured ? state.pace.real_time_factor : 1.0;
    if (factor < slow_factor)
        ui_.text(tint::orange, "   SLOW MOTION: %.2f x real time", factor);
    else
        ui_.text(tint::dim, "   %.2f x real time", factor);
    const float buttons = ui_.px(330.0f);
    ImGui::SetCursorScreenPos({place.width - buttons, ui_.px(5.0f)});
    ui_.button(ControlId::pixels, view_->is_pixel_by_pixel ? "Fit" : "1:1", 52.0f, view_->is_pixel_by_pixel);
    ImGui::SameLine();
    ui_.button(ControlId::help, "Help (H)", 78.0f, view_->shows_help);
    ImGui::SameLine();
    ui_.button(ControlId::restart, "Start again", 94.0f);
    ImGui::SameLine();
    ui_.button(ControlId::end, "End (Esc)", 80.0f);
    ui_.end_panel();
}

// Shows each new notice of the X-ray room, the syringe or the inflator once, as a toast (a notice that
// disappears after some seconds).
void SuiteScreen::toast(const RoomNotice &notice)
{
    if (notice.from < 0 || notice.text.empty()) return;
    const bool is_told = std::any_of(told_.begin(), told_.end(), [&](const RoomNotice &old) {
        return old.text == notice.text && old.from == notice.from;
    });
    if (is_told) return;
    told_.push_back(notice);
    if (told_.size() > 32) told_.erase(told_.begin());
    toasts_.push_back({without_moment(notice.text)});
    if (toasts_.size() > toasts_max) toasts_.pop_front();
}

void SuiteScreen::collect_toasts()
{
    const SuiteState &state = *view_->state;
    toast(state.room.notice());
    toast(state.notice);
    toast(state.refused);
    if (view_->live && !view_->live->status.notice.empty()) {
        const std::string &text = view_->live->status.notice;
        const bool is_room = text == state.room.notice().text;
        if (!is_room && (told_.empty() || told_.back().text != text || state.tick > told_.back().from + 4000))
            toast({text, state.tick});
    }
    const bool others_wait =
        std::any_of(toasts_.begin(), toasts_.end(), [](const Toast &one) { return one.shown_s < 0.0; });
    const double end_s = ImGui::GetTime() - (others_wait ? toast_short_s : toast_s);
    while (!toasts_.empty() && toasts_.front().shown_s >= 0.0 && toasts_.front().shown_s < end_s)
        toasts_.pop_front();
}

void SuiteScreen::forget_toasts()
{
    toasts_.clear();
    told_.clear();
}

// Draws the alerts; an alert that the user must acknowledge stays until it is acknowledged.
void SuiteScreen::draw_alerts(NoticeLine &line)
{
    const SuiteState &state = *view_->state;
    const DoseMeter &dose = state.room.dose();
    if (!state.fault.empty()) line.add(tint::red, state.fault + " - R starts again", false, false);
    if (dose.unseen_alert())
        line.add(tint::red, formatted("DOSE ABOVE %g Gy", dose_alert_levels_Gy[*dose.unseen_alert()]), true,
                 false);
    if (dose.has_unseen_reminder())
        line.add(tint::orange,
                 formatted("FLUOROSCOPY %u MIN",
                           static_cast<unsigned>(dose.fluoro_reminders() * fluoro_reminder_ticks / 60'000)),
                 true, false);
}

// Draws the alerts and toasts side by side in the line below the picture. A toast for which the line has no
// room waits until an older toast has disappeared; the oldest toast is always shown.
void SuiteScreen::draw_toasts(const UiRect &live)
{
    const SuiteState &state = *view_->state;
    const DoseMeter &dose = state.room.dose();
    const bool has_alert = !state.fault.empty() || dose.unseen_alert() || dose.has_unseen_reminder();
    if (!has_alert && toasts_.empty()) return;
    ImGui::SetNextWindowPos({live.x + 0.5f * live.width, live.y + live.height}, ImGuiCond_Always,
                            {0.5f, 1.0f});
    ImGui::PushStyleVar(ImGuiStyleVar_WindowPadding, {ui_.px(9.0f), ui_.px(2.0f)});
    ImGui::Begin("notices", nullptr,
                 ImGuiWindowFlags_NoDecoration | ImGuiWindowFlags_AlwaysAutoResize | ImGuiWindowFlags_NoMove |
                     ImGuiWindowFlags_NoSavedSettings | ImGuiWindowFlags_NoFocusOnAppearing);
    ImGui::BringWindowToDisplayFront(ImGui::GetCurrentWindow());
    const float width = 0.96f * live.width;
    ImGui::PushTextWrapPos(width);
    NoticeLine line{ui_, width, 0.0f, true};
    draw_alerts(line);
    for (std::size_t i = 0; i < toasts_.size(); ++i) {
        Toast &toast = toasts_[i];
        if (!line.add(tint::orange, toast.text, false, i > 0)) break;
        if (toast.shown_s < 0.0) toast.shown_s = ImGui::GetTime();
    }
    ImGui::PopTextWrapPos();
    ImGui::End();
    ImGui::PopStyleVar();
}

void SuiteScreen::draw_help()
{
    const float w = std::min(ui_.window().width() - ui_.px(40.0f), ui_.px(1360.0f));
    const float h = std::min(ui_.window().height() - ui_.px(60.0f), ui_.px(840.0f));
    ImGui::SetNextWindowPos({0.5f * ui_.window().width(), 0.5f * ui_.window().height() + ui_.px(14.0f)},
                            ImGuiCond_Always, {0.5f, 0.5f});
    ImGui::SetNextWindowSize({w, h});
    ImGui::PushStyleColor(ImGuiCol_WindowBg, IM_COL32(16, 20, 24, 255));
    ImGui::PushStyleVar(ImGuiStyleVar_ItemSpacing, {ui_.px(6.0f), ui_.px(4.0f)}); // so that all rows fit
    ImGui::PushStyleVar(ImGuiStyleVar_CellPadding, {ui_.px(4.0f), 0.0f});
    ImGui::PushStyleVar(ImGuiStyleVar_WindowPadding, {ui_.px(16.0f), ui_.px(12.0f)});
    ImGui::Begin("help", nullptr,
                 ImGuiWindowFlags_NoMove | ImGuiWindowFlags_NoTitleBar | ImGuiWindowFlags_NoResize |
                     ImGuiWindowFlags_NoCollapse | ImGuiWindowFlags_NoSavedSettings | ImGuiWindowFlags_NoNav);
    ImGui::BringWindowToDisplayFront(ImGui::GetCurrentWindow());
    ui_.text(tint::orange, "Controls: H or F1 hides this list");
    if (ImGui::BeginTable("controls", 2, ImGuiTableFlags_SizingStretchSame)) {
        const auto rows = controls();
        constexpr std::size_t groups = 9;
        const std::size_t half = (rows.size() + groups + 1) / 2;
        std::size_t lines = 0;
        bool is_second = false;
        ImGui::TableNextColumn();
        std::string_view group;
        ImGui::PushFont(ui_.fonts().small_text);
        for (const Control &row : rows) {
            if (lines >= half && !is_second) {
                ImGui::TableNextColumn();
                is_second = true;
            }
            ++lines;
            if (row.group != group) {
                group = row.group;
                ui_.text(tint::sky, "%s", std::string(group).c_str());
                ++lines;
            }
            ui_.text(tint::text, "%-11s", std::string(row.key_text).c_str());
            ImGui::SameLine(ui_.px(92.0f));
            ImGui::PushTextWrapPos(0.0f);
            ui_.text(tint::dim, "%s", std::string(row.what).c_str());
            ImGui::PopTextWrapPos();
        }
        ImGui::PopFont();
        ImGui::EndTable();
    }
    ui_.note("help", {0.0f, 0.0f, w, h}, ImGui::GetScrollMaxY() > 0.0f ? "it does not fit" : "");
    ImGui::End();
    ImGui::PopStyleVar(3);
    ImGui::PopStyleColor();
}

} // namespace crn
