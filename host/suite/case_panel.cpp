// Draws the panel of a case beside the live monitor: its goals and whether they are reached, its limits, and
// hints on demand. No marks are shown during a session, because trainees remember feedback better if they get
// it at the end (docs/assessment.md).
#include "host/base/format.hpp"
#include "host/suite/pages.hpp"
#include "host/suite/prep_page.hpp"
#include "host/suite/suite_screen.hpp"
#include "host/suite/ui_text.hpp"

namespace crn
{

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
            ui_.tooltip(goal.expectation.text() + "\nnow: " + without_remedy(result->found));
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

} // namespace crn
