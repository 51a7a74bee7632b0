#include "host/assess/assessment.hpp"
#include "host/assess/motion_metrics.hpp"
#include "host/base/terminal.hpp"
#include "host/base/text.hpp"
#include <algorithm>
#include <cstdio>
#include <nlohmann/json.hpp>

namespace crn
{

namespace
{

using Json = nlohmann::ordered_json;

constexpr int format = 1;
constexpr std::size_t curve_points_max = 600;

Json tick_or_null(const std::optional<std::uint32_t> &tick)
{
    return tick ? Json(*tick) : Json();
}

template <typename Value> Json value_or_null(const std::optional<Value> &value)
{
    return value ? Json(*value) : Json();
}

Json text_or_null(const std::string &text)
{
    return text.empty() ? Json() : Json(text);
}

Json errors_of(const AssessPlan &plan, const Evaluation &found)
{
    Json errors = Json::array();
    for (const FoundError &one : found.errors) {
        const PlanError &error = plan.errors[one.kind];
        errors.push_back({{"kind", error.name},
                          {"title", error.title},
                          {"severity", severity_text(error.severity)},
                          {"weight", static_cast<int>(error.severity)},
                          {"tick", one.begin_tick},
                          {"end_tick", one.end_tick},
                          {"at_s", one.begin_tick * 1e-3},
                          {"seconds", (one.end_tick - one.begin_tick) * 1e-3},
                          {"counts", one.counts},
                          {"advice", error.advice}});
    }
    return errors;
}

Json error_kinds_of(const AssessPlan &plan, const Evaluation &found)
{
    Json kinds = Json::array();
    for (std::size_t k = 0; k < plan.errors.size(); ++k) {
        const PlanError &error = plan.errors[k];
        const auto count = std::count_if(found.errors.begin(), found.errors.end(),
                                         [&](const FoundError &one) { return one.kind == k; });
        kinds.push_back({{"kind", error.name},
                         {"title", error.title},
                         {"severity", severity_text(error.severity)},
                         {"weight", static_cast<int>(error.severity)},
                         {"when", error.when.text()},
                         {"for_s", error.for_s},
                         {"again_s", error.again_s},
                         {"at_most", error.at_most},
                         {"count", count},
                         {"why_not", text_or_null(found.why_not[k])},
                         {"source", error.source}});
    }
    return kinds;
}

Json phases_of(const AssessPlan &plan, const Evaluation &found)
{
    Json phases = Json::array();
    for (std::size_t p = 0; p < plan.phases.size(); ++p) {
        const PlanPhase &phase = plan.phases[p];
        const FoundPhase &was = found.phases[p];
        Json steps = Json::array();
        for (std::size_t s = 0; s < phase.steps.size(); ++s)
            steps.push_back({{"title", phase.steps[s].title},
                             {"weight", phase.steps[s].weight},
                             {"done_tick", tick_or_null(was.steps[s].done_tick)},
                             {"why_not", text_or_null(was.steps[s].why_not)}});
        phases.push_back({{"name", phase.name},
                          {"title", phase.title},
                          {"weight", phase.weight},
                          {"begin_tick", tick_or_null(was.begin_tick)},
                          {"end_tick", tick_or_null(was.end_tick)},
                          {"why_not", text_or_null(was.why_not)},
                          {"steps", steps}});
    }
    return phases;
}

// --- the score ---

// Returns the weighted share of the phases that ended and of the steps that were done. Phases and steps that
// do not apply are not counted.
std::optional<double> share_of_phases(const AssessPlan &plan, const Evaluation &found)
{
    double done = 0.0, of = 0.0;
    for (std::size_t p = 0; p < plan.phases.size(); ++p) {
        const FoundPhase &phase = found.phases[p];
        if (!phase.why_not.empty()) continue;
        of += plan.phases[p].weight;
        if (phase.end_tick) done += plan.phases[p].weight;
        for (std::size_t s = 0; s < phase.steps.size(); ++s) {
            if (!phase.steps[s].why_not.empty()) continue;
            of += plan.phases[p].steps[s].weight;
            if (phase.steps[s].done_tick) done += plan.phases[p].steps[s].weight;
        }
    }
    return of > 0.0 ? std::optional(done / of) : std::nullopt;
}

// Returns the marks of one group of metrics as a share of the possible marks; metrics that do not apply to
// the session are not counted.
std::optional<double> share_of_metrics(const Json &score, const std::string &group)
{
    double points = 0.0, of = 0.0;
    for (const Json &metric : score["metrics"]) {
        if (metric["group"] != group || !metric["points"].is_number()) continue;
        points += metric["points"].get<double>();
        of += metric["weight"].get<double>();
    }
    return of > 0.0 ? std::optional(points / of) : std::nullopt;
}

std::optional<double> share_of_errors(const AssessPlan &plan, const Evaluation &found)
{
    const bool applies = std::any_of(found.why_not.begin(), found.why_not.end(),
                                     [](const std::string &why) { return why.empty(); });
    if (!applies) return {};
    return std::max(0.0, 1.0 - found.lost_marks / plan.score.error_marks);
}

Json total_of(const AssessPlan &plan, const Evaluation &found, const Json &metrics)
{
    struct Part {
        const char *name, *title;
        double weight;
        std::optional<double> share;
    };
    const bool has_lesions = metrics["of"].get<double>() > 0.0; // without one, no result can be judged
    const Part parts[] = {
        {"errors", "Handling errors", plan.score.errors, share_of_errors(plan, found)},
        {"phases", "Phases and steps", plan.score.phases, share_of_phases(plan, found)},
        {"result", "Result of the treatment", plan.score.result,
         has_lesions ? share_of_metrics(metrics, "result") : std::nullopt},
        {"burden", "Burden on the patient", plan.score.burden, share_of_metrics(metrics, "burden")},
    };
    Json list = Json::array();
    double points = 0.0, of = 0.0;
    for (const Part &part : parts) {
        list.push_back({{"name", part.name},
                        {"title", part.title},
                        {"weight", part.weight},
                        {"share", value_or_null(part.share)}});
        if (!part.share) continue;
        points += part.weight * *part.share;
        of += part.weight;
    }
    Json total = {{"percent", of > 0.0 ? Json(100.0 * points / of) : Json()}, {"capped_by", Json()}};
    const std::optional<double> cap = plan.score.life_threatening_cap_pct;
    if (cap && found.has_life_threatening && of > 0.0 && 100.0 * points / of > *cap)
        total = {{"percent", *cap}, {"capped_by", "a life-threatening error"}};
    total["lost_marks"] = found.lost_marks;
    total["error_marks"] = plan.score.error_marks;
    total["parts"] = list;
    return total;
}

// --- motion and curves ---

Json tools_of(const SessionLog &log)
{
    Json tools = Json::array();
    for (std::size_t k = 0; k < log.tools.size(); ++k) {
        const MotionFigures motion = motion_of(log, k);
        double push_max_N = 0.0;
        for (const SessionMoment &moment : log.moments)
            push_max_N = std::max(push_max_N, std::fabs(moment.tools[k].hand_force_N));
        tools.push_back({{"name", log.tools[k]},
                         {"hand_path_mm", motion.hand_path_mm},
                         {"hand_turn_deg", motion.hand_turn_deg},
                         {"tip_path_mm", motion.tip_path_mm},
                         {"tip_path_px", motion.tip_path_px},
                         {"movements", motion.movements},
                         {"submovements", motion.submovements},
                         {"moving_s", motion.moving_s},
                         {"speed_mean_mm_s", value_or_null(motion.speed_mean_mm_s)},
                         {"sparc", value_or_null(motion.sparc)},
                         {"ldlj", value_or_null(motion.ldlj)},
                         {"hand_force_max_N", push_max_N}});
    }
    return tools;
}

Json curves_of(const SessionLog &log)
{
    const std::size_t step =
        std::max<std::size_t>(1, (log.moments.size() + curve_points_max - 1) / curve_points_max);
    Json time = Json::array(), xray = time, injected = time, bar = time, wall = time, kap = time,
         inserted = time;
    for (std::size_t k = 0; k < log.tools.size(); ++k) inserted.push_back(Json::array());
    for (std::size_t i = 0; i < log.moments.size(); i += step) {
        // Each point of the curve holds the largest value since the previous point, so that a short flash of
        // X-ray or a short peak stays visible.
        double wall_N = 0.0, balloon_bar = 0.0;
        int mode = 0;
        for (std::size_t j = i; j < std::min(i + step, log.moments.size()); ++j) {
            const SessionMoment &moment = log.moments[j];
            wall_N = std::max(wall_N, moment.wall_N);
            balloon_bar = std::max(balloon_bar, moment.balloon_bar);
            mode = std::max(mode, moment.is_acquiring ? 2 : moment.is_xray_on ? 1 : 0);
        }
        const SessionMoment &moment = log.moments[i];
        time.push_back(moment.tick * 1e-3);
        xray.push_back(mode);
        injected.push_back(moment.injected_ml);
        kap.push_back(moment.kap_Gy_cm2);
        bar.push_back(balloon_bar);
        wall.push_back(wall_N);
        for (std::size_t k = 0; k < log.tools.size(); ++k) inserted[k].push_back(moment.tools[k].inserted_mm);
    }
    return {{"time_s", time},
            {"xray", xray},
            {"inserted_mm", inserted},
            {"injected_ml", injected},
            {"kap_Gy_cm2", kap},
            {"balloon_bar", bar},
            {"wall_N", log.has_contacts ? wall : Json()}};
}

} // namespace

Json assessment_of(const AssessPlan &plan, const SessionLog &log, const Json &report)
{
    const Evaluation found = evaluate(plan, log);
    const Json metrics = score_of(report, plan.limits);
    Json assessment = {{"format", format},
                       {"plan", plan.name},
                       {"title", plan.title},
                       {"scene", report["scene"]},
                       {"session", report["session"]},
                       {"ticks", report["ticks"]},
                       {"hash", report["hash"]}};
    assessment["score"] = total_of(plan, found, metrics);
    assessment["errors"] = errors_of(plan, found);
    assessment["error_kinds"] = error_kinds_of(plan, found);
    assessment["phases"] = phases_of(plan, found);
    assessment["metrics"] = metrics["metrics"];
    assessment["tools"] = tools_of(log);
    assessment["curves"] = curves_of(log);
    return assessment;
}

void print_assessment(const Json &assessment)
{
    for (const Json &error : assessment["errors"])
        say(stdout, "error                 %-16s at %6.1f s  %s\n",
            error["severity"].get<std::string>().c_str(), error["at_s"].get<double>(),
            error["title"].get<std::string>().c_str());
    if (assessment["errors"].empty()) std::printf("error                 none\n");
    for (const Json &part : assessment["score"]["parts"])
        if (part["share"].is_number())
            std::printf("score                 %5.1f of %g  %s\n",
                        part["share"].get<double>() * part["weight"].get<double>(),
                        part["weight"].get<double>(), part["title"].get<std::string>().c_str());
    const Json &percent = assessment["score"]["percent"];
    if (percent.is_number()) std::printf("score                 %.0f of 100\n", percent.get<double>());
}

} // namespace crn
