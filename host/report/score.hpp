// Scores an angioplasty from the report of its session (docs/score.md): between two limits, the points of
// each metric change in proportion to its value. If the report does not contain the value of a metric, the
// metric is shown without points and does not change the sum.
//   Json score = score_of(report);    write_score_page("score.html", report, score, pictures);
#pragma once
#include "host/picture/picture.hpp"
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

namespace crn
{

// Returns {"points", "of", "percent", "metrics": [{"name", "title", "value", "unit", "full_marks_at",
// "no_marks_at", "weight", "points", "remark"}]}. `value` is null if it is not known; `points` is null in
// this case, and if the metric has no weight. `report` is the output of write_report().
nlohmann::ordered_json score_of(const nlohmann::ordered_json &report);

struct ScorePicture {
    std::string caption;
    Image image;
};

// Writes the score as one page without scripts or links, with the score, the tools, pictures, and curves over
// time. Throws OutputError.
void write_score_page(const std::string &path, const nlohmann::ordered_json &report,
                      const nlohmann::ordered_json &score, const std::vector<ScorePicture> &pictures);
// Returns the text of the page that write_score_page() writes, for tests. Throws std::runtime_error when a
// picture cannot be encoded.
std::string score_page(const nlohmann::ordered_json &report, const nlohmann::ordered_json &score,
                       const std::vector<ScorePicture> &pictures);

} // namespace crn
