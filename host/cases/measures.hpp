// Lists the quantities of a session's report (docs/session.md) that a case may limit.
#pragma once
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

namespace crn
{

struct Measure {
    const char *name;  // in case files, with its unit
    const char *title; // for people
    const char *unit;
};

const std::vector<Measure> &case_measures();
std::vector<std::string> measure_names();
const Measure &measure_named(const std::string &name); // throws std::out_of_range

// Returns the value of a measure in a report. Returns no value if the report has none, such as the score of
// an angioplasty without a lesion.
std::optional<double> measured(const std::string &name, const nlohmann::ordered_json &report);

} // namespace crn
