// Writes the score of a session (figures/score.hpp) as a page with pictures.
//   write_score_page("score.html", report, score_of(report), pictures);
#pragma once
#include "host/picture/picture.hpp"
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

namespace crn
{

struct ScorePicture {
    std::string caption;
    Image image;
};

// Writes the score as one page without scripts or links, with the score, the tools, pictures, and curves over
// time. Throws OutputError.
void write_score_page(const std::string &path, const nlohmann::ordered_json &report,
                      const nlohmann::ordered_json &score, const std::vector<ScorePicture> &pictures);
// Returns the text of the page that write_score_page() writes, for tests. Throws std::runtime_error if a
// picture cannot be encoded.
std::string score_page(const nlohmann::ordered_json &report, const nlohmann::ordered_json &score,
                       const std::vector<ScorePicture> &pictures);

} // namespace crn
