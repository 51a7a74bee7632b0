#include "host/suite/replay_page.hpp"
#include "host/base/format.hpp"
#include "host/command/expert_run.hpp"
#include "host/picture/room_text.hpp"
#include "host/suite/pages.hpp"
#include "host/suite/ui_text.hpp"
#include <algorithm>
#include <cmath>
#include <filesystem>

namespace crn
{
namespace
{

constexpr std::size_t replay_slot = 2, expert_slot = 3;
constexpr std::uint32_t before_error_ticks = 1000; // that an error is shown with
constexpr float side_width = 330.0f, scrub_height = 92.0f;
constexpr float side_band = 20.0f; // round a picture, for the letters of the patient's sides

bool is_same(const CArm &a, const CArm &b)
{
    return a.primary_deg == b.primary_deg && a.secondary_deg == b.secondary_deg &&
           a.isocentre_m == b.isocentre_m && a.source_detector_m == b.source_detector_m &&
           a.field_m == b.field_m;
}

// Returns a room whose C-arm and table are in the positions of this view: commands before the room's first
// tick take effect at once.
Room room_at(const CArm &carm)
{
    const auto milli = [](double value) { return static_cast<std::int32_t>(std::lround(value * 1e3)); };
    const auto micro = [](double value) { return static_cast<std::int32_t>(std::lround(value * 1e6)); };
    Room room;
    room.give(0, {RoomAction::distance, {micro(carm.source_detector_m), micro(carm.source_isocentre_m), 0}});
    room.give(0, {RoomAction::angles, {milli(carm.primary_deg), milli(carm.secondary_deg), 0}});
    room.give(0, {RoomAction::table,
                  {micro(carm.isocentre_m.x()), micro(carm.isocentre_m.y()), micro(carm.isocentre_m.z())}});
    room.give(0, {RoomAction::field, {micro(carm.field_m), 0, 0}});
    room.advance(0, nullptr);
    return room;
}

ImU32 colour_of(ReplayMark::Kind kind)
{
    return kind == ReplayMark::Kind::fluoro    ? tint::yellow
           : kind == ReplayMark::Kind::acquire ? tint::orange
                                               : tint::sky;
}

} // namespace

ReplayPage::ReplayPage(Ui &ui, const std::string &recording, const PictureSettings &settings,
                       std::shared_ptr<const Case> lesson, std::vector<ReplayError> errors)
    : ui_(ui), name_(std::filesystem::path(recording).filename().string()),
      thread_(std::make_unique<ReplayRoom>(recording, "", settings)), marks_(thread_.room().marks()),
      settings_(settings), lesson_(std::move(lesson)), errors_(std::move(errors))
{
    std::sort(errors_.begin(), errors_.end(),
              [](const ReplayError &a, const ReplayError &b) { return a.tick < b.tick; });
}

void ReplayPage::go_to_error(bool is_next)
{
    const auto shown_at = [](const ReplayError &error) {
        return error.tick > before_error_ticks ? error.tick - before_error_ticks : 0;
    };
    const ReplayError *found = nullptr;
    for (const ReplayError &error : errors_) {
        if (is_next && !found && shown_at(error) > tick()) found = &error;
        if (!is_next && shown_at(error) < tick()) found = &error;
    }
    if (found) go_to(shown_at(*found));
}

// At the first call, a background task looks for the expert's run or makes it.
void ReplayPage::toggle_expert()
{
    shows_expert_ = lesson_ && !shows_expert_;
    if (!shows_expert_ || expert_) return;
    expert_ = std::make_unique<ExpertTask>([lesson = lesson_, settings = settings_](TaskProgress &progress) {
        const std::string recording = expert_recording(
            *lesson, [&] { return progress.tell("the expert's run is recorded, once for each case", -1.0); });
        return std::make_shared<ReplayThread>(std::make_unique<ReplayRoom>(recording, "", settings));
    });
}

ReplayThread *ReplayPage::expert() const
{
    const std::shared_ptr<ReplayThread> *made = expert_ ? expert_->result() : nullptr;
    return made ? made->get() : nullptr;
}

// The expert's picture shows the same time of the session, and the same angle if the user has chosen one.
void ReplayPage::ask_expert()
{
    ReplayThread *thread = expert();
    if (!shows_expert_ || !thread) return;
    const ReplayAsk now{std::min(tick(), thread->room().ticks()), carm_};
    const std::uint32_t prepared = thread->room().prepared();
    const bool is_same_view = has_asked_expert_ && now.tick == asked_expert_.tick &&
                              now.carm.has_value() == asked_expert_.carm.has_value() &&
                              (!now.carm || is_same(*now.carm, *asked_expert_.carm));
    if (is_same_view && (prepared == asked_expert_prepared_ || asked_expert_prepared_ >= now.tick)) return;
    has_asked_expert_ = true;
    asked_expert_ = now;
    asked_expert_prepared_ = prepared;
    thread->ask(now);
}

bool ReplayPage::act(ControlId id)
{
    if (id < ControlId::lao || id > ControlId::field_larger || id == ControlId::follow) return false;
    const std::shared_ptr<const ReplayShown> shown = thread_.latest();
    CArm carm = carm_ ? *carm_ : shown ? shown->picture.carm : CArm{};
    for (const RoomCommand &command : commands_of(id, room_at(carm), {})) {
        const std::int32_t *values = command.values;
        if (command.action == RoomAction::angles) {
            carm.primary_deg = values[0] * 1e-3;
            carm.secondary_deg = values[1] * 1e-3;
        } else if (command.action == RoomAction::distance) {
            carm.source_detector_m = values[0] * 1e-6;
            carm.source_isocentre_m = values[1] * 1e-6;
        } else if (command.action == RoomAction::field) {
            carm.field_m = values[0] * 1e-6;
        } else if (command.action == RoomAction::table) {
            carm.isocentre_m = Eigen::Vector3d(values[0], values[1], values[2]) * 1e-6;
        }
    }
    carm_ = carm;
    return true;
}

void ReplayPage::jump(double seconds)
{
    tick_ = std::clamp(tick_ + seconds * 1e3, 0.0, static_cast<double>(thread_.room().ticks()));
}

void ReplayPage::go_to(std::uint32_t tick)
{
    tick_ = std::min(tick, thread_.room().ticks());
}

// Requests the picture of the present view, if the view has changed.
void ReplayPage::ask()
{
    const ReplayAsk now{tick(), carm_};
    const bool is_new_track = thread_.room().prepared() != asked_prepared_ &&
                              asked_prepared_ < now.tick; // medium and stents may come now
    const bool is_same_view = has_asked_ && now.tick == asked_.tick &&
                              now.carm.has_value() == asked_.carm.has_value() &&
                              (!now.carm || is_same(*now.carm, *asked_.carm));
    if (is_same_view && !is_new_track) return;
    has_asked_ = true;
    asked_ = now;
    asked_prepared_ = thread_.room().prepared();
    thread_.ask(now);
}

void ReplayPage::draw()
{
    if (is_playing_) {
        jump(static_cast<double>(ImGui::GetIO().DeltaTime));
        if (tick() >= thread_.room().ticks()) is_playing_ = false;
    }
    ask();
    ask_expert();
    const float w = ui_.window().width(), h = ui_.window().height();
    const float side = ui_.px(side_width), scrub = ui_.px(scrub_height), gap = ui_.px(4.0f);
    draw_pictures({0.0f, 0.0f, w - side - gap, h - scrub - gap});
    draw_side({w - side, 0.0f, side, h - scrub - gap});
    draw_scrub({0.0f, h - scrub, w, scrub});
}

void ReplayPage::draw_pictures(const UiRect &place)
{
    const std::shared_ptr<const ReplayShown> shown = thread_.latest();
    if (!shows_expert_) return draw_picture("replay picture", replay_slot, shown.get(), place);
    const float gap = ui_.px(4.0f), half = 0.5f * (place.width - gap);
    draw_picture("replay picture", replay_slot, shown.get(), {place.x, place.y, half, place.height});
    const ReplayThread *thread = expert();
    const std::shared_ptr<const ReplayShown> of_expert = thread ? thread->latest() : nullptr;
    draw_picture("expert picture", expert_slot, of_expert.get(),
                 {place.x + half + gap, place.y, half, place.height});
}

void ReplayPage::draw_picture(const char *name, std::size_t slot, const ReplayShown *shown,
                              const UiRect &place)
{
    ui_.begin_panel(name, place, "");
    const float edge = std::min(place.width, place.height) - 2.0f * ui_.px(side_band);
    const ImVec2 at{place.x + 0.5f * (place.width - edge), place.y + 0.5f * (place.height - edge)};
    ImGui::GetWindowDrawList()->AddRectFilled(at, {at.x + edge, at.y + edge}, IM_COL32(8, 10, 12, 255));
    if (shown && !shown->picture.grey.empty()) {
        void *texture =
            ui_.window().texture(slot, shown->picture.size, shown->picture.grey, shown->number, false);
        ImGui::GetWindowDrawList()->AddImage(texture, at, {at.x + edge, at.y + edge});
        ui_.note(name, {at.x, at.y, edge, edge});
        draw_sides(shown->picture.carm, {at.x, at.y, edge, edge});
    }
    ImGui::SetCursorScreenPos({place.x + ui_.px(12.0f), place.y + ui_.px(8.0f)});
    if (slot == expert_slot)
        draw_expert_text();
    else if (shows_expert_)
        ui_.text(tint::text, "TRAINEE");
    if (shown && !shown->trouble.empty()) {
        ImGui::SetCursorScreenPos({place.x + ui_.px(20.0f), place.y + ui_.px(40.0f)});
        ui_.text(tint::red, "%s", shown->trouble.c_str());
    }
    ui_.end_panel();
}

// Writes the letters of the patient's sides beside the picture.
void ReplayPage::draw_sides(const CArm &carm, const UiRect &picture)
{
    const View view = make_view(clamp_carm(carm), 16);
    const auto letter = [&](float x, float y, const Eigen::Vector3d &direction) {
        const std::string text = patient_side(direction);
        const ImVec2 size = ImGui::CalcTextSize(text.c_str());
        ImGui::GetWindowDrawList()->AddText({x - 0.5f * size.x, y - 0.5f * size.y}, tint::text, text.c_str());
    };
    const float x = picture.x + 0.5f * picture.width, y = picture.y + 0.5f * picture.height;
    const float out = 0.5f * picture.width + 0.5f * ui_.px(side_band);
    letter(x, y - out, view.up);
    letter(x, y + out, -view.up);
    letter(x - out, y, -view.right);
    letter(x + out, y, view.right);
}

// Writes a text beside the expert's picture: how much of the expert's run has been computed, or the time at
// which the run ended.
void ReplayPage::draw_expert_text()
{
    const ReplayThread *thread = expert();
    ui_.text(tint::text, "EXPERT");
    if (thread && tick() > thread->room().ticks())
        ui_.text(tint::green, "finished after %s", session_clock(thread->room().ticks() * 1e-3).c_str());
    else if (!thread && expert_->trouble().empty())
        ui_.text(tint::yellow, "Please wait: %s.", expert_->progress().stage().c_str());
    else if (!thread)
        ui_.text(tint::red, "%s", expert_->trouble().c_str());
}

void ReplayPage::draw_side(const UiRect &place)
{
    ui_.begin_panel("replay side", place, "REPLAY");
    const std::shared_ptr<const ReplayShown> shown = thread_.latest();
    ui_.text(tint::text, "%s", name_.c_str());
    const CArm carm = carm_ ? *carm_ : shown ? shown->picture.carm : CArm{};
    ui_.text(carm_ ? tint::orange : tint::text, "%s", with_degrees(angles_text(carm)).c_str());
    ui_.small_text(tint::dim, carm_ ? "an angle of your own" : "as in the session");
    const float width = place.width / ui_.px(1.0f) - 18.0f, quarter = (width - 18.0f) / 4.0f,
                third = (width - 12.0f) / 3.0f;
    const auto row = [&](std::initializer_list<ControlId> ids, float each) {
        bool is_first = true;
        for (ControlId id : ids) {
            if (!is_first) ImGui::SameLine();
            is_first = false;
            ui_.button(id, nullptr, each);
        }
    };
    using enum ControlId;
    row({rao, lao, cranial, caudal}, quarter);
    row({view_ap, view_lateral, view_spider}, third);
    row({view_arch, view_rca_lao, view_lao_cranial}, third);
    row({table_head, table_feet}, (width - 6.0f) / 2.0f);
    row({table_right, table_left}, (width - 6.0f) / 2.0f);
    row({field_smaller, field_larger}, (width - 6.0f) / 2.0f);
    if (ui_.plain_button("as recorded", "Angle of the session", -1.0f)) carm_.reset();
    if (lesson_ && ui_.screen_button(ScreenControlId::expert,
                                     shows_expert_ ? "Hide the expert" : "Expert beside it", -1.0f))
        toggle_expert();
    ImGui::Dummy({1.0f, ui_.px(8.0f)});
    if (shown) {
        const std::vector<Instrument> tools = tools_on(thread_.room().tools(), shown->picture.line);
        for (std::size_t k = 0; k < tools.size() && k < shown->picture.frame.tools.size(); ++k) {
            if (tools[k].name.empty()) continue; // a free position
            const ToolReading &reading = shown->picture.frame.tools[k];
            ui_.text(tint::text, "%zu  %s", k + 1, tools[k].name.c_str());
            ui_.small_text(tint::dim, "%.0f mm  %+.0f\u00b0  %.2f N  %.1f mN\u00b7m",
                           rounded_to(reading.inserted_m * 1e3, 1.0), rounded_to(reading.turned_deg, 1.0),
                           rounded_to(reading.axial_N, 100.0), rounded_to(reading.torque_N_m * 1e3, 10.0));
        }
        if (!shown->picture.is_prepared)
            ui_.small_text(tint::orange, "Medium and stents are being prepared: %.0f %%",
                           100.0 * thread_.room().prepared() / std::max(thread_.room().ticks(), 1u));
    }
    ImGui::SetCursorScreenPos({place.x + ui_.px(9.0f), place.y + place.height - ui_.px(36.0f)});
    ui_.button(end, "Back (Esc)", -1.0f);
    ui_.end_panel();
}

void ReplayPage::draw_scrub_buttons(double ticks)
{
    if (ui_.screen_button(ScreenControlId::play, is_playing_ ? "Pause" : "Play", 130.0f)) toggle_play();
    ImGui::SameLine();
    if (ui_.screen_button(ScreenControlId::second_back, "- 1 s", 64.0f)) jump(-1.0);
    ImGui::SameLine();
    if (ui_.screen_button(ScreenControlId::second_on, "+ 1 s", 64.0f)) jump(1.0);
    ImGui::SameLine();
    if (!errors_.empty()) {
        if (ui_.screen_button(ScreenControlId::error_before, "< Error", 76.0f)) go_to_error(false);
        ImGui::SameLine();
        if (ui_.screen_button(ScreenControlId::next_error, "Error >", 76.0f)) go_to_error(true);
        ImGui::SameLine();
    }
    ui_.text(tint::text, "   %s of %s", session_clock(tick_ * 1e-3).c_str(),
             session_clock(ticks * 1e-3).c_str());
    ImGui::SameLine();
    ui_.small_text(tint::yellow, "     fluoroscopy");
    ImGui::SameLine();
    ui_.small_text(tint::orange, "runs");
    ImGui::SameLine();
    ui_.small_text(tint::sky, "injections");
    const auto near = std::find_if(errors_.begin(), errors_.end(), [&](const ReplayError &error) {
        return tick() + before_error_ticks >= error.tick && tick() <= error.tick + before_error_ticks;
    });
    if (near == errors_.end()) return;
    ImGui::SameLine();
    ui_.text(tint::red, "    \u25b2 %s", near->title.c_str());
}

// Draws a triangle above the time bar for each handling error.
void ReplayPage::draw_errors(const UiRect &place, double ticks)
{
    ImDrawList *draw = ImGui::GetWindowDrawList();
    for (const ReplayError &error : errors_) {
        const float x = place.x + place.width * static_cast<float>(error.tick / ticks), half = ui_.px(6.0f);
        draw->AddTriangleFilled({x - half, place.y - ui_.px(12.0f)}, {x + half, place.y - ui_.px(12.0f)},
                                {x, place.y - ui_.px(1.0f)}, severity_colour(error.weight));
    }
}

void ReplayPage::draw_scrub(const UiRect &place)
{
    ui_.begin_panel("scrub panel", place, "");
    const double ticks = std::max(thread_.room().ticks(), 1u);
    ImGui::SetCursorScreenPos({place.x + ui_.px(12.0f), place.y + ui_.px(8.0f)});
    draw_scrub_buttons(ticks);
    const float x = place.x + ui_.px(14.0f), y = place.y + ui_.px(52.0f), width = place.width - ui_.px(28.0f),
                height = ui_.px(28.0f);
    ImDrawList *draw = ImGui::GetWindowDrawList();
    const auto x_of = [&](double tick) { return x + width * static_cast<float>(tick / ticks); };
    draw->AddRectFilled({x, y}, {x + width, y + height}, tint::background, ui_.px(4.0f));
    for (const ReplayMark &mark : marks_) {
        const float lane = static_cast<float>(mark.kind) * height / 3.0f;
        draw->AddRectFilled(
            {x_of(mark.begin), y + lane + 1.0f},
            {std::max(x_of(mark.end), x_of(mark.begin) + 2.0f), y + lane + height / 3.0f - 1.0f},
            colour_of(mark.kind));
    }
    draw_errors({x, y, width, height}, ticks);
    draw->AddLine({x_of(tick_), y - ui_.px(5.0f)}, {x_of(tick_), y + height + ui_.px(5.0f)}, tint::text,
                  ui_.px(3.0f));
    ImGui::SetCursorScreenPos({x, y});
    ImGui::InvisibleButton("scrub", {width, height});
    ui_.note_last_item("scrub");
    if (ImGui::IsItemActive())
        tick_ = std::clamp<double>((ImGui::GetIO().MousePos.x - x) / width, 0.0, 1.0) * ticks;
    ui_.tooltip("Click or drag: shows this moment.");
    ui_.end_panel();
}

} // namespace crn
