// Scores an angioplasty: metrics with marks between two stated limits, from a session's report
// (docs/score.md). A metric without a value in the report is shown without marks and does not affect the sum.
//   Json score = score_of(report);    write_score_page("score.html", report, score, pictures);
#pragma once
#include "host/picture/picture.hpp"
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

namespace crn
{

// Returns {"points", "of", "percent", "metrics": [{"name", "title", "value", "unit", "full_marks_at",
// "no_marks_at", "weight", "points", "remark"}]}. `value` is null where it is not known; `points` is null
// there and where there is no weight. `report` is the output of write_report().
nlohmann::ordered_json score_of(const nlohmann::ordered_json &report);

struct ScorePicture {
    std::string caption;
    Image image;
};

// Writes one page without scripts or links: score, tools, pictures, curves over time. Throws OutputError.
void write_score_page(const std::string &path, const nlohmann::ordered_json &report,
                      const nlohmann::ordered_json &score, const std::vector<ScorePicture> &pictures);
// Returns the page's text, for tests. Throws std::runtime_error when a picture cannot be encoded.
std::string score_page(const nlohmann::ordered_json &report, const nlohmann::ordered_json &score,
                       const std::vector<ScorePicture> &pictures);

} // namespace crn
