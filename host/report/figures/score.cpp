#include "host/report/figures/score.hpp"
#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>
#include <optional>

namespace crn
{

namespace
{

using Json = nlohmann::ordered_json;
using Value = std::optional<double>;

constexpr double narrow_pct = 50.0; // by diameter: a lesion that needs treatment

// Returns a number of the report, which is found by its path of keys, or no value if the path does not exist.
Value number(const Json &from, const std::vector<std::string> &way)
{
    const Json *at = &from;
    for (const std::string &key : way) {
        if (!at->is_object() || !at->contains(key)) return {};
        at = &(*at)[key];
    }
    return at->is_number() ? Value(at->get<double>()) : Value();
}

const Json &list(const Json &from, const char *key)
{
    static const Json none = Json::array();
    return from.is_object() && from.contains(key) && from[key].is_array() ? from[key] : none;
}

// Returns an extreme value of a quantity over all lesions that were narrow before the treatment; `pick`
// returns the larger or the smaller of two values.
template <typename Pick> Value over_lesions(const Json &report, const char *figure, Pick pick)
{
    Value found;
    for (const Json &lesion : list(report, "lesions")) {
        const Value before = number(lesion, {"stenosis_diameter_pct"}),
                    after = number(lesion, {"after", figure});
        if (!before || *before < narrow_pct || !after) continue;
        found = found ? pick(*found, *after) : *after;
    }
    return found;
}

// Returns an extreme value of a quantity over all stents that were opened in the patient.
template <typename Pick> Value over_stents(const Json &report, const char *figure, Pick pick)
{
    Value found;
    for (const Json &stent : list(report, "stents")) {
        const Value value = number(stent, {figure});
        if (!value || !stent.contains("opened_s") || stent["opened_s"].is_null()) continue;
        found = found ? pick(*found, *value) : *value;
    }
    return found;
}

double larger(double a, double b)
{
    return std::max(a, b);
}
double smaller(double a, double b)
{
    return std::min(a, b);
}

// Returns the total length of the parts of narrow lesions that no stent covers. If several stents lie in one
// lesion, the uncovered length at each end of the lesion is the one that the nearest stent leaves.
Value geographic_miss_mm(const Json &report)
{
    Value sum;
    for (const Json &lesion : list(report, "lesions")) {
        const Value before = number(lesion, {"stenosis_diameter_pct"});
        if (!before || *before < narrow_pct) continue;
        Value ahead, behind;
        for (const Json &stent : list(report, "stents")) {
            if (!stent.contains("released_s") || stent["released_s"].is_null()) continue;
            for (const Json &covered : list(stent, "lesions")) {
                if (!covered.contains("name") || !lesion.contains("name") ||
                    covered["name"] != lesion["name"])
                    continue;
                const Value first = number(covered, {"missed_before_mm"}),
                            last = number(covered, {"missed_behind_mm"});
                if (first) ahead = std::min(ahead.value_or(*first), *first);
                if (last) behind = std::min(behind.value_or(*last), *last);
            }
        }
        if (ahead && behind) sum = sum.value_or(0.0) + *ahead + *behind;
    }
    return sum;
}

// Returns, in percent, the smallest ratio of a stent's least inside area to the healthy vessel's area there,
// over all stents opened in a lesion.
Value stent_expansion_pct(const Json &report)
{
    Value least;
    for (const Json &stent : list(report, "stents")) {
        const Value area_mm2 = number(stent, {"area_min_mm2"});
        if (!area_mm2 || !stent.contains("opened_s") || stent["opened_s"].is_null()) continue;
        for (const Json &covered : list(stent, "lesions"))
            for (const Json &lesion : list(report, "lesions")) {
                const Value healthy_mm = number(lesion, {"after", "reference_diameter_mm"});
                if (!healthy_mm || !covered.contains("name") || covered["name"] != lesion["name"]) continue;
                const double pct = 100.0 * *area_mm2 / (std::numbers::pi / 4.0 * *healthy_mm * *healthy_mm);
                least = std::min(least.value_or(pct), pct);
            }
    }
    return least;
}

// Counts mishaps: burst balloons, lost stents, and deployed stents that hold no lesion open.
Value mishaps(const Json &report)
{
    if (!report.contains("balloon") || report["balloon"].is_null()) return {};
    double count = number(report, {"balloon", "burst_s"}) ? 1.0 : 0.0;
    for (const Json &stent : list(report, "stents"))
        count += stent.contains("is_lost") && stent["is_lost"] == true ? 1.0 : 0.0;
    return count;
}

// Counts perforations and dissections of vessels; a session without any has no value, and keeps its score.
Value injuries(const Json &report)
{
    const Value count = number(report, {"complications", "count"});
    return count && *count > 0.0 ? count : Value();
}

Value times(const Value &value, double factor)
{
    return value ? Value(*value * factor) : Value();
}

constexpr const char *group_result = "result", *group_burden = "burden";

struct Metric {
    const char *name, *group, *title, *unit;
    Value value;
    double full_at, none_at, weight; // no weight: only shown
    const char *remark;
};

std::vector<Metric> results_of(const Json &report)
{
    return {
        {"residual_stenosis_pct", group_result, "Residual stenosis, by diameter", "%",
         over_lesions(report, "stenosis_diameter_pct", larger), 10, 30, 20,
         "the narrowest lesion that is left"},
        {"minimum_lumen_diameter_mm", group_result, "Minimum lumen diameter", "mm",
         over_lesions(report, "minimum_diameter_mm", smaller), 0, 0, 0, ""},
        {"flow_reserve", group_result, "Fractional flow reserve", "", over_lesions(report, "ffr", smaller), 0,
         0, 0, "0.80 and less: the flow is short"},
        {"stent_expansion_pct", group_result, "Stent expansion", "%", stent_expansion_pct(report), 90, 50, 15,
         "the stent's least inside area, of the healthy vessel's area"},
        {"apposition_pct", group_result, "Struts on the wall", "%",
         over_stents(report, "apposed_pct", smaller), 95, 80, 15,
         "within 0.1 mm; a stent that is too small or not fully opened has malapposed struts"},
        {"geographic_miss_mm", group_result, "Lesion left without stent", "mm", geographic_miss_mm(report), 0,
         5, 15, "at both ends together"},
        {"overstretch_pct", group_result, "Wall over-stretch", "%",
         over_stents(report, "overstretch_pct", larger), 10, 30, 10,
         "of the healthy diameter; too large a balloon tears the wall"},
        {"mishaps", group_result, "Burst balloons and lost stents", "", mishaps(report), 0, 1, 10, ""},
        {"injuries", group_result, "Perforated and dissected vessels", "", injuries(report), 0, 1, 20,
         "a metric that can only cost: without injuries it does not count"},
    };
}

std::vector<Metric> burdens_of(const Json &report)
{
    const Value session_min = times(number(report, {"ticks"}), 1e-3 / 60.0);
    return {
        {"contrast_ml", group_burden, "Contrast medium", "ml", number(report, {"contrast", "injected_ml"}),
         50, 200, 3, ""},
        {"fluoroscopy_min", group_burden, "Fluoroscopy", "min", number(report, {"room", "fluoroscopy_min"}),
         5, 20, 4, ""},
        {"kap_Gy_cm2", group_burden, "Kerma-area product", "Gy cm²",
         number(report, {"room", "total", "kap_Gy_cm2"}), 20, 100, 3, ""},
        {"contact_impulse_N_s", group_burden, "Contact impulse", "N s",
         number(report, {"contact", "impulse_N_s"}), 600, 3000, 5,
         "force of the wall on the line, over the time"},
        {"time_min", group_burden, "Time", "min", session_min, 0, 0, 0,
         "a quick session has no advantage by itself"},
    };
}

std::vector<Metric> metrics_of(const Json &report, const ScoreLimits &limits)
{
    std::vector<Metric> metrics = results_of(report);
    for (const Metric &metric : burdens_of(report)) metrics.push_back(metric);
    for (Metric &metric : metrics) {
        const auto limit = limits.find(metric.name);
        if (limit == limits.end()) continue;
        metric.full_at = limit->second.full_at;
        metric.none_at = limit->second.none_at;
        metric.weight = limit->second.weight.value_or(metric.weight);
    }
    return metrics;
}

// Returns all points for values up to `full_at`, no points from `none_at` on, and a proportional number of
// points between these two limits.
double points_of(const Metric &metric)
{
    const double way = (*metric.value - metric.full_at) / (metric.none_at - metric.full_at);
    return metric.weight * (1.0 - std::clamp(way, 0.0, 1.0));
}

} // namespace

std::vector<std::string> score_metric_names()
{
    std::vector<std::string> names;
    for (const Metric &metric : metrics_of(Json::object(), {})) names.push_back(metric.name);
    return names;
}

Json score_of(const Json &report, const ScoreLimits &limits)
{
    double points = 0.0, of = 0.0;
    Json metrics = Json::array();
    for (const Metric &metric : metrics_of(report, limits)) {
        Json entry = {{"name", metric.name},
                      {"group", metric.group},
                      {"title", metric.title},
                      {"value", Json()},
                      {"unit", metric.unit}};
        if (metric.value) entry["value"] = *metric.value;
        if (metric.weight > 0.0) {
            entry["full_marks_at"] = metric.full_at;
            entry["no_marks_at"] = metric.none_at;
            entry["weight"] = metric.weight;
        }
        entry["points"] = Json();
        if (metric.weight > 0.0 && metric.value) {
            entry["points"] = points_of(metric);
            points += points_of(metric);
            of += metric.weight;
        }
        entry["remark"] = metric.remark;
        metrics.push_back(entry);
    }
    // If the report has no lesion, nothing was treated, and a score of 100 % for a low X-ray dose alone would
    // be misleading.
    if (!report.contains("lesions") || report["lesions"].empty()) points = of = 0.0;
    return {{"points", points},
            {"of", of},
            {"percent", of > 0.0 ? Json(100.0 * points / of) : Json()},
            {"metrics", metrics}};
}

} // namespace crn
