// Draws the debrief: errors first, then phases, marks, motion, and the learning curve. A click on an error, a
// phase or the timeline shows the corresponding moment in the replay.
#include "host/base/format.hpp"
#include "host/base/number_text.hpp"
#include "host/picture/room_text.hpp"
#include "host/suite/pages.hpp"
#include "host/suite/ui_text.hpp"
#include <algorithm>
#include <cfloat>
#include <cmath>

namespace crn
{
namespace
{

using Json = nlohmann::ordered_json;

constexpr float timeline_units = 64.0f;
constexpr float curves_share = 0.22f; // of the window's height

std::string clock_of(const Json &tick)
{
    return session_clock(tick.get<double>() * 1e-3);
}

std::string value_text(const Json &value, const std::string &unit)
{
    if (!value.is_number()) return "not known";
    if (unit == "min") return decimals_text(value.get<double>(), 1) + " min";
    return number_text(value.get<double>(), 3) + (unit.empty() ? "" : " " + unit);
}

class DebriefView
{
  public:
    DebriefView(Ui &ui, const Debrief &debrief, const std::string &said)
        : ui_(ui), debrief_(debrief), said_(said)
    {
        if (const ScoredSession *scored = debrief.scored()) {
            report_ = &scored->score.report;
            stored_ = scored->stored ? &*scored->stored : nullptr;
        }
    }

    PageChoice draw()
    {
        begin_page(ui_, "debrief", "Debrief", debrief_.title.c_str());
        const float w = ui_.window().width(), h = ui_.window().height();
        const float margin = ui_.px(page_margin), top = ui_.px(108.0f), gap = ui_.px(26.0f);
        const float timeline_y = h - ui_.px(timeline_units + 20.0f), curves = curves_share * h;
        const float bottom = report_ ? timeline_y - curves - ui_.px(16.0f) : timeline_y;
        const float side = std::min(ui_.px(360.0f), 0.27f * w);
        const float rest = w - 2.0f * margin - side - 2.0f * gap;
        const float left = 0.54f * rest, middle = rest - left;
        child("errors", {margin, top, left, bottom - top}, [&] { draw_errors(); });
        child("marks", {margin + left + gap, top, middle, bottom - top}, [&] { draw_marks(); });
        child("debrief side", {w - margin - side, ui_.px(34.0f), side, bottom - ui_.px(34.0f)},
              [&] { draw_side(side); });
        if (report_) {
            const float width = w - 2.0f * margin;
            draw_session_curves(ui_, (*report_)["assessment"],
                                {margin, bottom + ui_.px(8.0f), width, curves});
            draw_timeline({margin, timeline_y, width, ui_.px(timeline_units)});
        }
        ui_.end_panel();
        return choice_;
    }

  private:
    template <class Draw> void child(const char *name, const UiRect &place, Draw draw)
    {
        ImGui::SetCursorScreenPos({place.x, place.y});
        ImGui::BeginChild(name, {place.width, place.height});
        ImGui::PushTextWrapPos(0.0f);
        draw();
        ImGui::PopTextWrapPos();
        ImGui::EndChild();
    }

    void heading(const char *text)
    {
        ImGui::Dummy({1.0f, ui_.px(4.0f)});
        ui_.small_text(tint::dim, "%s", text);
    }

    void show(const Json &tick)
    {
        choice_ = {PageChoice::Kind::replay, 0, debrief_.recording, tick.get<std::uint32_t>()};
    }

    // Draws the time of a moment as a button, which shows this moment in the replay.
    void moment(const std::string &name, const Json &tick)
    {
        if (ui_.plain_button(name.c_str(), clock_of(tick).c_str(), 84.0f, "Shows this moment in the replay."))
            show(tick);
        ImGui::SameLine();
        ImGui::AlignTextToFramePadding();
    }

    void draw_waiting()
    {
        const BackgroundTask<ScoredSession> *task = debrief_.task.get();
        if (!task) {
            ui_.text(tint::dim, "This session was not recorded, so it cannot be assessed.");
        } else if (!task->trouble().empty()) {
            ui_.text(tint::red, "The assessment failed: %s", task->trouble().c_str());
        } else {
            const double share = std::max(task->progress().share(), 0.0);
            ui_.text(tint::yellow, "The recording is replayed for the assessment: %.0f %%", 100.0 * share);
            ImGui::ProgressBar(static_cast<float>(share), {-1.0f, ui_.px(8.0f)}, "");
        }
    }

    void draw_errors()
    {
        if (!debrief_.fault.empty()) ui_.text(tint::red, "%s", debrief_.fault.c_str());
        if (!report_) return draw_waiting();
        ui_.note("assessed", {0.0f, 0.0f, 1.0f, 1.0f});
        const Json &assessment = (*report_)["assessment"];
        heading("ERRORS, the gravest first");
        if (assessment["errors"].empty()) ui_.text(tint::green, "\u25cf No handling error was found.");
        std::size_t number = 0;
        std::string advised;
        for (const Json &error : assessment["errors"]) {
            const std::string name = "error " + std::to_string(++number);
            moment(name, error["tick"]);
            const bool counts = error.value("counts", true);
            ui_.text(severity_colour(error.value("weight", 3)), "\u25b2 %s%s",
                     error.value("title", "").c_str(), counts ? "" : " (costs no more marks)");
            ui_.tooltip(error.value("severity", "") + ": " + error.value("advice", ""));
            const std::string advice = error.value("advice", "");
            if (advice == advised) continue;
            advised = advice;
            ui_.small_text(tint::dim, "%s: %s", error.value("severity", "").c_str(), advice.c_str());
        }
        heading("PHASES");
        number = 0;
        for (const Json &phase : assessment["phases"]) draw_phase(phase, ++number);
    }

    void draw_phase(const Json &phase, std::size_t number)
    {
        if (phase["why_not"].is_string()) {
            ui_.small_text(tint::dim, "%s: does not apply, because %s", phase.value("title", "").c_str(),
                           phase["why_not"].get<std::string>().c_str());
            return;
        }
        const bool has_begun = phase["begin_tick"].is_number(), has_ended = phase["end_tick"].is_number();
        if (has_begun) moment("phase " + std::to_string(number), phase["begin_tick"]);
        const std::string took =
            has_ended
                ? formatted("%.0f s",
                            (phase["end_tick"].get<double>() - phase["begin_tick"].get<double>()) * 1e-3)
                : std::string(has_begun ? "not finished" : "not reached");
        ui_.text(has_ended ? tint::text : tint::orange, "%s  (%s)", phase.value("title", "").c_str(),
                 took.c_str());
        for (const Json &step : phase["steps"])
            if (!step["why_not"].is_string())
                ui_.small_text(step["done_tick"].is_number() ? tint::green : tint::orange, "      %s %s",
                               step["done_tick"].is_number() ? "\u25cf" : "\u25cb",
                               step.value("title", "").c_str());
    }

    void draw_marks()
    {
        const Json &report = report_ ? *report_ : debrief_.report;
        heading("TIME AND DOSE");
        using Pointer = Json::json_pointer;
        ui_.text(tint::text, "%s,  fluoroscopy %.1f min",
                 session_clock(report.value("ticks", 0.0) * 1e-3).c_str(),
                 report.value(Pointer("/room/fluoroscopy_min"), 0.0));
        ui_.text(tint::text, "%.2f mGy,  %.3f Gy cm\u00b2",
                 report.value(Pointer("/room/total/reference_air_kerma_mGy"), 0.0),
                 report.value(Pointer("/room/total/kap_Gy_cm2"), 0.0));
        if (!report_) return;
        if (report.contains("case")) draw_case_marks(report["case"]);
        heading("ASSESSMENT");
        for (const Json &part : report["assessment"]["score"]["parts"])
            if (part["share"].is_number())
                ui_.text(tint::text, "%5.1f of %.0f   %s",
                         part["share"].get<double>() * part["weight"].get<double>(),
                         part["weight"].get<double>(), part.value("title", "").c_str());
        heading("RESULT");
        for (const Json &metric : report["assessment"]["metrics"])
            if (metric["value"].is_number())
                ui_.small_text(tint::text, "%s: %s", metric.value("title", "").c_str(),
                               value_text(metric["value"], metric.value("unit", "")).c_str());
        heading("MOTION");
        for (const Json &tool : report["assessment"]["tools"])
            ui_.small_text(
                tint::text,
                "%s: path of the hand %.0f mm, of the tip %.0f mm\n  submovements %d, smoothness (SPARC) %s",
                tool.value("name", "").c_str(), tool.value("hand_path_mm", 0.0),
                tool.value("tip_path_mm", 0.0), tool.value("submovements", 0),
                value_text(tool["sparc"], "").c_str());
    }

    void draw_case_marks(const Json &marks)
    {
        heading("MARKS OF THE CASE");
        for (const Json &goal : marks["goals"]) {
            const bool is_reached = goal["is_reached"].get<bool>();
            ui_.text(is_reached ? tint::green : tint::orange, "%s %.0f of %.0f  %s",
                     is_reached ? "\u25cf" : "\u25cb", goal["points"].get<double>(),
                     goal["marks"].get<double>(), goal.value("text", "").c_str());
            if (!is_reached)
                ui_.small_text(tint::dim, "wanted: %s\nfound: %s", goal.value("wanted", "").c_str(),
                               without_remedy(goal.value("found", "")).c_str());
        }
        for (const Json &limit : marks["limits"])
            ui_.text(tint::text, "%.1f of %.0f  %s: %s", limit["points"].get<double>(),
                     limit["marks"].get<double>(), limit.value("title", "").c_str(),
                     value_text(limit["value"], limit.value("unit", "")).c_str());
    }

    void draw_side(float width)
    {
        if (report_) {
            const Json &report = *report_;
            const Json &percent =
                report.contains("case") ? report["case"]["score"] : report["assessment"]["score"]["percent"];
            ImGui::PushFont(ui_.fonts().large);
            if (percent.is_number()) {
                ui_.text(tint::orange, "%.0f of 100", percent.get<double>());
                ui_.note_last_item("score", formatted("%.1f of 100", percent.get<double>()));
            }
            ImGui::PopFont();
            ui_.small_text(tint::dim, report.contains("case") ? "marks of the case" : "assessment");
        }
        if (stored_) draw_stored(width);
        if (debrief_.lesson && report_) {
            heading("WHAT THE CASE TEACHES");
            std::string teaching = debrief_.lesson->teaching;
            std::replace(teaching.begin(), teaching.end(), '\n', ' ');
            ui_.small_text(tint::text, "%s", teaching.c_str());
        }
        ImGui::Dummy({1.0f, ui_.px(8.0f)});
        if (!debrief_.recording.empty() && ui_.screen_button(ScreenControlId::to_replay, "Replay", -1.0f))
            choice_ = {PageChoice::Kind::replay, 0, debrief_.recording, 0};
        if (ui_.screen_button(ScreenControlId::again, "Again", -1.0f)) choice_.kind = PageChoice::Kind::again;
        if (report_ && ui_.screen_button(ScreenControlId::save, "Save page and figures", -1.0f))
            choice_.kind = PageChoice::Kind::save;
        if (ui_.screen_button(ScreenControlId::leave_debrief, "Start screen", -1.0f))
            choice_.kind = PageChoice::Kind::start;
        if (!said_.empty()) ui_.small_text(tint::sky, "%s", said_.c_str());
        for (const std::string &file : debrief_.files) ui_.small_text(tint::dim, "written %s", file.c_str());
    }

    void draw_stored(float width)
    {
        if (!stored_->trouble.empty()) {
            ui_.small_text(tint::red, "The session is not stored: %s", stored_->trouble.c_str());
            return;
        }
        ui_.small_text(tint::green, "stored for the trainee '%s'", stored_->trainee.c_str());
        if (!stored_->note.empty()) ui_.small_text(tint::dim, "%s", stored_->note.c_str());
        heading("CURVE OF LEARNING: marks by session");
        const ImVec2 at = ImGui::GetCursorScreenPos();
        const UiRect place{at.x, at.y, width - ui_.px(20.0f), ui_.px(120.0f)};
        draw_curve(place);
        ImGui::Dummy({place.width, place.height});
    }

    // Draws scores from 0 to 100: the middle half of the cohort, the range of the experts, the fitted curve
    // with its band, and the trainee's sessions.
    void draw_curve(const UiRect &place)
    {
        ImDrawList *draw = ImGui::GetWindowDrawList();
        draw->AddRectFilled({place.x, place.y}, {place.x + place.width, place.y + place.height},
                            tint::background, ui_.px(4.0f));
        const LearningCurve &curve = stored_->curve;
        const float pad = ui_.px(8.0f), scale = ui_.px(34.0f),
                    count = static_cast<float>(std::max<std::size_t>(curve.points.size(), 2));
        const auto x_of = [&](std::size_t i) {
            const float left = place.x + scale + pad, right = place.x + place.width - 2.0f * pad;
            return left + (right - left) * static_cast<float>(i) / (count - 1.0f);
        };
        const auto y_of = [&](double value) {
            const float share = static_cast<float>(std::clamp(value / 100.0, 0.0, 1.0));
            return place.y + pad + (place.height - 2.0f * pad) * (1.0f - share);
        };
        ImFont *font = ui_.fonts().small_text;
        for (const double level : {0.0, 50.0, 100.0}) {
            draw->AddLine({place.x + scale, y_of(level)}, {place.x + place.width - pad, y_of(level)},
                          tint::line);
            const std::string text = formatted("%.0f", level);
            const float text_w = font->CalcTextSizeA(font->FontSize, FLT_MAX, 0.0f, text.c_str()).x;
            draw->AddText(font, font->FontSize,
                          {place.x + scale - text_w - ui_.px(4.0f), y_of(level) - 0.5f * font->FontSize},
                          tint::dim, text.c_str());
        }
        if (curve.expert)
            draw->AddRectFilled({place.x + scale, y_of(curve.expert->high) - 1.0f},
                                {place.x + place.width - pad, y_of(curve.expert->low) + 1.0f},
                                IM_COL32(0, 200, 130, 60));
        for (std::size_t i = 0; i + 1 < curve.points.size(); ++i) {
            if (curve.fit) {
                draw->AddQuadFilled({x_of(i), y_of(curve.fit->low[i])}, {x_of(i), y_of(curve.fit->high[i])},
                                    {x_of(i + 1), y_of(curve.fit->high[i + 1])},
                                    {x_of(i + 1), y_of(curve.fit->low[i + 1])}, IM_COL32(86, 180, 233, 50));
                draw->AddLine({x_of(i), y_of(curve.fit->value[i])},
                              {x_of(i + 1), y_of(curve.fit->value[i + 1])}, tint::sky, ui_.px(2.0f));
            }
            if (i + 1 < curve.cohort.size())
                draw->AddLine({x_of(i), y_of(curve.cohort[i].median)},
                              {x_of(i + 1), y_of(curve.cohort[i + 1].median)}, tint::dim, ui_.px(1.0f));
        }
        for (std::size_t i = 0; i < curve.points.size(); ++i)
            draw->AddCircleFilled({x_of(i), y_of(curve.points[i].value)}, ui_.px(4.0f), tint::orange);
    }

    void draw_timeline(const UiRect &place)
    {
        const Json &assessment = (*report_)["assessment"];
        const double ticks = std::max(assessment["ticks"].get<double>(), 1.0);
        ImDrawList *draw = ImGui::GetWindowDrawList();
        const float y = place.y + ui_.px(20.0f), height = place.height - ui_.px(24.0f);
        const auto x_of = [&](double tick) {
            return place.x + place.width * static_cast<float>(tick / ticks);
        };
        ImGui::SetCursorScreenPos({place.x, place.y});
        ui_.small_text(tint::dim,
                       "TIMELINE: X-ray yellow, phases blue, errors as triangles. A click shows the moment.");
        const std::string length = session_clock(ticks * 1e-3);
        ImFont *font = ui_.fonts().small_text;
        const float length_w = font->CalcTextSizeA(font->FontSize, FLT_MAX, 0.0f, length.c_str()).x;
        draw->AddText(font, font->FontSize, {place.x + place.width - length_w, place.y}, tint::dim,
                      length.c_str());
        draw->AddRectFilled({place.x, y}, {place.x + place.width, y + height}, tint::background,
                            ui_.px(4.0f));
        draw_xray(assessment["curves"], x_of, y, height);
        for (const Json &phase : assessment["phases"])
            if (phase["begin_tick"].is_number() && phase["end_tick"].is_number())
                draw->AddRectFilled(
                    {x_of(phase["begin_tick"]) + 1.0f, y + 0.7f * height},
                    {std::max(x_of(phase["end_tick"]), x_of(phase["begin_tick"]) + 3.0f), y + 0.95f * height},
                    tint::sky);
        for (const Json &error : assessment["errors"]) {
            const float x = x_of(error["tick"]), half = ui_.px(6.0f);
            draw->AddTriangleFilled({x - half, y + ui_.px(2.0f)}, {x + half, y + ui_.px(2.0f)},
                                    {x, y + ui_.px(13.0f)}, severity_colour(error.value("weight", 3)));
        }
        ImGui::SetCursorScreenPos({place.x, y});
        if (ImGui::InvisibleButton("timeline", {place.width, height})) {
            const double share =
                std::clamp<double>((ImGui::GetIO().MousePos.x - place.x) / place.width, 0.0, 1.0);
            show(Json(static_cast<std::uint32_t>(share * ticks)));
        }
        ui_.note_last_item("timeline");
    }

    template <class XOf> void draw_xray(const Json &curves, XOf x_of, float y, float height)
    {
        const Json &times = curves["time_s"], &xray = curves["xray"];
        ImDrawList *draw = ImGui::GetWindowDrawList();
        for (std::size_t i = 0; i + 1 < times.size() && i < xray.size(); ++i) {
            const bool is_on = xray[i].is_boolean() ? xray[i].get<bool>() : xray[i].get<double>() > 0.0;
            if (is_on)
                draw->AddRectFilled({x_of(times[i].get<double>() * 1e3), y + 0.4f * height},
                                    {x_of(times[i + 1].get<double>() * 1e3) + 1.0f, y + 0.62f * height},
                                    tint::yellow);
        }
    }

    Ui &ui_;
    const Debrief &debrief_;
    const std::string &said_;
    const Json *report_ = nullptr;
    const StoredSession *stored_ = nullptr;
    PageChoice choice_;
};

} // namespace

PageChoice draw_debrief(Ui &ui, const Debrief &debrief, const std::string &said)
{
    return DebriefView(ui, debrief, said).draw();
}

} // namespace crn
