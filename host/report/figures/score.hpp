// Scores an angioplasty from the report of its session (docs/score.md): between two limits, the points of
// each metric change in proportion to its value. If the report does not contain the value of a metric, the
// metric is shown without points and does not change the sum.
//   Json score = score_of(report);
#pragma once
#include <map>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

namespace crn
{

// Holds, by the metric's name, limits that differ from those of docs/score.md; a plan of an assessment states
// them.
struct ScoreLimit {
    double full_at = 0.0, none_at = 0.0;
    std::optional<double> weight; // absent: as without this limit
};
using ScoreLimits = std::map<std::string, ScoreLimit>;
// Returns the names of all metrics, in the order of the score.
std::vector<std::string> score_metric_names();

// Returns {"points", "of", "percent", "metrics": [{"name", "group", "title", "value", "unit",
// "full_marks_at", "no_marks_at", "weight", "points", "remark"}]}. The group is "result" for what the
// treatment achieved and "burden" for what it cost the patient. `value` is null if it is not known; `points`
// is null if `value` is null or the metric has no weight. `report` is what write_report() returned.
nlohmann::ordered_json score_of(const nlohmann::ordered_json &report, const ScoreLimits &limits = {});

} // namespace crn
