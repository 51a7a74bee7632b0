// Makes the pages with the curves of a trainee and of a cohort: each page is one HTML file that needs no
// network and no script.
#pragma once
#include "host/records/learning.hpp"
#include <string>
#include <vector>

namespace crn
{

struct TraineePage {
    std::string trainee, case_id;
    std::vector<LearningCurve> curves;
    Cusum cusum;                         // of the sessions that were passed or failed
    std::vector<SessionRecord> sessions; // of the trainee in this case
    double pass_score_pct = 80.0;
};
std::string trainee_page(const TraineePage &page);

struct CohortPage {
    std::string case_id, group; // an empty group means all trainees
    std::size_t people = 0, sessions = 0;
    std::vector<LearningCurve> curves;
};
std::string cohort_page(const CohortPage &page);

} // namespace crn
