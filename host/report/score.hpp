// Scores an angioplasty from the report of its session (docs/score.md): each metric gives marks in proportion
// between two stated limits. A metric whose value is missing in the report is shown without marks and does
// not change the sum.
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

// Writes the score as one page without scripts or links, with the score, the tools, pictures, and curves over
// time. Throws OutputError.
void write_score_page(const std::string &path, const nlohmann::ordered_json &report,
                      const nlohmann::ordered_json &score, const std::vector<ScorePicture> &pictures);
// Returns the text of the same page, for tests. Throws std::runtime_error when a picture cannot be encoded.
std::string score_page(const nlohmann::ordered_json &report, const nlohmann::ordered_json &score,
                       const std::vector<ScorePicture> &pictures);

} // namespace crn
