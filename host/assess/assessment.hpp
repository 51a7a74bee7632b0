// Returns the assessment of a session as JSON (docs/assessment.md): errors with their ticks, phases, metrics,
// and the score with its parts. The assessments of a session and of a replay of its recording are equal, byte
// for byte.
//
//   const Json assessment = assessment_of(plan, observer.log(), report);
//   write_debrief("debrief.html", assessment);
#pragma once
#include "host/assess/evaluation.hpp"
#include <nlohmann/json_fwd.hpp>

namespace crn
{

// `report` is the report of the session (report_of). The returned JSON object has the following entries.
//   "format", "plan", "title", "scene", "session", "ticks", "hash",
//   "score": {"percent", "capped_by", "parts": [{"name", "title", "weight", "share"}]},
//   "errors": [{"kind", "title", "severity", "weight", "tick", "end_tick", "at_s", "seconds", "counts",
//               "advice"}], the heaviest first,
//   "error_kinds": [{"kind", "title", "severity", "weight", "when", "for_s", "again_s", "at_most", "count",
//                    "why_not", "source"}],
//   "phases": [{"name", "title", "weight", "begin_tick", "end_tick", "why_not", "steps": [...]}],
//   "metrics": as score_of() returns them, and the motion of every tool,
//   "tools": [{"name", "hand_path_mm", "tip_path_mm", "tip_path_px", ...}], "curves".
// A share is a number from 0 to 1, or null for a part of the score that does not apply. Throws FileError as
// evaluate() does.
nlohmann::ordered_json assessment_of(const AssessPlan &plan, const SessionLog &log,
                                     const nlohmann::ordered_json &report);

// Prints the errors and the score on the terminal.
void print_assessment(const nlohmann::ordered_json &assessment);

// Writes the debrief as one HTML page without scripts or links to other files. Throws OutputError.
void write_debrief(const std::string &path, const nlohmann::ordered_json &assessment);
// Returns the text of the debrief page, for tests.
std::string debrief_page(const nlohmann::ordered_json &assessment);

} // namespace crn
