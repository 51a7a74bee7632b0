#include "host/cases/goals.hpp"
#include "host/base/number_text.hpp"
#include "host/base/terminal.hpp"
#include "host/cases/measures.hpp"
#include <algorithm>
#include <nlohmann/json.hpp>

namespace crn
{

namespace
{

using Json = nlohmann::ordered_json;

std::string tools_text(std::size_t count)
{
    return std::to_string(count) + (count == 1 ? " tool" : " tools");
}

} // namespace

GoalWatch::GoalWatch(const Case &lesson, const VesselMap &map)
    : lesson_(lesson), map_(map), results_(lesson.goals.size())
{
    for (const CaseGoal &goal : lesson.goals) {
        const Expectation &expected = goal.expectation;
        if (expected.tool >= lesson.start.tools.size())
            throw FileError(lesson.file, goal.line, 0,
                            "names the " + tool_name(expected.tool) + ", but the line has " +
                                tools_text(lesson.start.tools.size()));
        const std::optional<std::size_t> vessel =
            expected.names_vessel() ? map.find(expected.vessel.text) : std::optional<std::size_t>(0);
        if (!vessel)
            throw FileError(lesson.file, goal.line, 0,
                            "unknown vessel '" + expected.vessel.text + "'" +
                                map.suggestion(expected.vessel.text));
        vessels_.push_back(*vessel);
    }
}

void GoalWatch::look(const SessionView &view, std::span<const double> turned_deg)
{
    bool is_next = true; // all earlier goals that are to be reached once have been reached
    for (std::size_t i = 0; i < results_.size(); ++i) {
        const CaseGoal &goal = lesson_.goals[i];
        GoalResult &result = results_[i];
        if (goal.is_once && result.is_reached) continue;
        const std::size_t tool = goal.expectation.tool;
        const double turned = tool < turned_deg.size() ? turned_deg[tool] : 0.0;
        const ExpectationResult now = judge(goal.expectation, goal.line, vessels_[i], map_, view, turned);
        result.found = now.found;
        if (!goal.is_once) {
            result.is_reached = now.is_held;
            continue;
        }
        result.is_reached = now.is_held && is_next;
        if (result.is_reached) result.tick = view.tick;
        is_next = is_next && result.is_reached;
    }
}

void GoalSink::tick(const crn_wire_tick_input &input, const crn_wire_tick_state &state)
{
    last_ = input;
    tick_ = state.tick;
    if (inner_) inner_->tick(input, state);
}

std::uint32_t GoalSink::next_tick() const
{
    return inner_ ? std::min(next_, inner_->next_tick()) : next_;
}

void GoalSink::frame(const SessionFrame &frame)
{
    if (tick_ >= next_) {
        std::vector<double> inserted_m, turned_deg;
        for (const ToolReading &tool : frame.tools) {
            inserted_m.push_back(tool.inserted_m);
            turned_deg.push_back(tool.turned_deg);
        }
        const std::vector<TipPlace> places = tips_.at(frame.wire);
        goals_.look({inserted_m, places, witness_, tick_}, turned_deg);
        next_ = tick_ + GoalWatch::look_every_ticks - tick_ % GoalWatch::look_every_ticks;
    }
    // The patient has already advanced to the tick of this frame, so next_tick() of the inner observer no
    // longer returns this tick. The inner observer therefore gets every frame, and ignores the frames that it
    // does not need.
    if (inner_) inner_->frame(frame);
}

void GoalSink::finish()
{
    if (inner_) inner_->finish();
}

void GoalSink::end(std::span<const double> inserted_m, std::span<const TipPlace> tips)
{
    std::vector<double> turned_deg;
    for (std::size_t k = 0; k < inserted_m.size(); ++k)
        turned_deg.push_back(last_.hands[k].rotation_counts * 360.0 / counts_per_turn);
    goals_.look({inserted_m, tips, witness_, tick_}, turned_deg);
}

bool GoalWatch::are_all_reached() const
{
    return std::all_of(results_.begin(), results_.end(),
                       [](const GoalResult &one) { return one.is_reached; });
}

Json case_result(const Case &lesson, const std::vector<GoalResult> &goals, const Json &report)
{
    double points = 0.0, marks = 0.0;
    bool is_reached = true;
    Json goal_list = Json::array(), limit_list = Json::array();
    for (std::size_t i = 0; i < lesson.goals.size(); ++i) {
        const CaseGoal &goal = lesson.goals[i];
        const GoalResult &result = goals[i];
        const double won = result.is_reached ? goal.marks : 0.0;
        points += won;
        marks += goal.marks;
        is_reached = is_reached && result.is_reached;
        goal_list.push_back({{"text", goal.text},
                             {"expected", goal.expectation.text()},
                             {"wanted", goal.expectation.plain_text()},
                             {"when", goal.is_once ? "once" : "end"},
                             {"is_reached", result.is_reached},
                             {"at_s", result.tick ? Json(*result.tick * 1e-3) : Json()},
                             {"found", result.found},
                             {"marks", goal.marks},
                             {"points", won}});
    }
    for (const CaseLimit &limit : lesson.limits) {
        const std::optional<double> value = measured(limit.measure, report);
        // If the session has no value for a limit, such as an angioplasty without a treated lesion, the limit
        // earns no marks.
        const double share =
            value ? std::clamp((*value - limit.none_at) / (limit.full_at - limit.none_at), 0.0, 1.0) + 0.0
                  : 0.0; // + 0.0: no marks are 0, not -0
        points += share * limit.marks;
        marks += limit.marks;
        limit_list.push_back({{"measure", limit.measure},
                              {"title", measure_named(limit.measure).title},
                              {"value", value ? Json(*value) : Json()},
                              {"unit", measure_named(limit.measure).unit},
                              {"full_marks_at", limit.full_at},
                              {"no_marks_at", limit.none_at},
                              {"marks", limit.marks},
                              {"points", share * limit.marks}});
    }
    return {{"name", lesson.name},
            {"title", lesson.title},
            {"score", marks > 0.0 ? 100.0 * points / marks : 0.0},
            {"is_reached", is_reached},
            {"goals", goal_list},
            {"limits", limit_list}};
}

void print_case_result(const Json &entry)
{
    for (const Json &goal : entry.at("goals"))
        std::printf("%-21s %s (%s; %s)\n",
                    goal.at("is_reached").get<bool>() ? "goal reached" : "goal NOT REACHED",
                    printable(goal.at("text").get<std::string>()).c_str(),
                    printable(goal.at("expected").get<std::string>()).c_str(),
                    printable(goal.at("found").get<std::string>()).c_str());
    for (const Json &limit : entry.at("limits")) {
        const std::string unit = limit.at("unit").get<std::string>();
        std::printf("limit                 %s: %s%s%s, %s of %s marks\n",
                    limit.at("title").get<std::string>().c_str(),
                    limit.at("value").is_number() ? number_text(limit.at("value").get<double>(), 3).c_str()
                                                  : "not known",
                    unit.empty() ? "" : " ", unit.c_str(),
                    number_text(limit.at("points").get<double>(), 3).c_str(),
                    number_text(limit.at("marks").get<double>(), 3).c_str());
    }
    std::printf("score of the case     %.0f of 100\n", entry.at("score").get<double>());
}

CasePlay::CasePlay(const Case *lesson, const TipPlaces &tips, const SessionWitness *witness,
                   FrameSink *pictures)
    : lesson_(lesson), sink_(pictures)
{
    if (!lesson) return;
    goals_.emplace(*lesson, tips.map());
    goal_sink_.emplace(*goals_, tips, witness, pictures);
    sink_ = &*goal_sink_;
}

Json CasePlay::judge_end(const RunResult &result, const Json &report)
{
    std::vector<double> inserted_m;
    for (const ToolFigures &tool : result.figures.tools) inserted_m.push_back(tool.inserted_m);
    goal_sink_->end(inserted_m, result.tips);
    return case_result(*lesson_, goals_->results(), report);
}

Json CasePlay::end(const RunResult &result, const Json &report)
{
    const Json entry = judge_end(result, report);
    print_case_result(entry);
    return entry;
}

} // namespace crn
