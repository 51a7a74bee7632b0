// Reads the plan of an assessment (TOML, docs/assessment.md): phases with steps, handling errors, limits of
// metrics, and weights of the score's parts. A plan is a file in shared/examples/assessments, a user's own
// file, or the table [assessment] of another file.
//
//   const AssessPlan plan = read_plan(named_path(plan_files, "angioplasty"));
#pragma once
#include "host/assess/condition.hpp"
#include "host/base/examples.hpp"
#include "host/base/toml_reader.hpp"
#include "host/report/figures/score.hpp"
#include <optional>
#include <string>
#include <vector>

namespace crn
{

inline constexpr ExampleKind plan_files{"assessments", "assessment plan", ".toml"};

struct PlanStep {
    std::string title;
    Condition done;
    double weight = 1.0;
};

struct PlanPhase {
    std::string name, title;
    std::optional<Condition> begin; // absent: when the phase before it ends, or at the start of the session
    Condition end;
    double weight = 1.0;
    std::vector<PlanStep> steps;
};

// How bad an error is. The weights are those that 28 experts gave to errors in carotid stenting (Van
// Herzeele, Aggarwal, Malik et al., Eur J Vasc Endovasc Surg 2009;38:1).
enum class Severity { moderate = 3, serious = 4, life_threatening = 5 };
std::string severity_text(Severity severity);

struct PlanError {
    std::string name, title, advice, source;
    Condition when;
    Severity severity = Severity::moderate;
    double for_s = 0.0;   // the condition must hold for so long
    double again_s = 2.0; // and must not hold for so long before the error can count again
    int at_most = 5;      // counted in the score; more are listed
};

struct PlanScore {
    double errors = 50.0, phases = 20.0, result = 20.0, burden = 10.0; // weights of the parts
    double error_marks = 40.0; // sum of the weights of all errors at which nothing is left of that part
    std::optional<double> life_threatening_cap_pct; // of the whole score, after such an error
};

struct AssessPlan {
    std::string file, name, title;
    PlanVessels vessels;
    PlanScore score;
    std::vector<PlanPhase> phases;
    std::vector<PlanError> errors;
    ScoreLimits limits; // of the metrics
};

// Reads a plan file. If the file has the key `plan`, the function first reads the plan with that name, and
// then changes it as the file states. In this file, [vessels] names vessels, and [score] and the metrics
// replace weights and limits. Errors of the file are added to the plan, or replace errors of the same name.
// If the file has phases, they replace all phases of the plan. Throws a FileError whose message names file,
// line and column and suggests a known word.
AssessPlan read_plan(const std::string &path);

// Reads a plan in the same way from a table of another file, such as [assessment] in the file of a case. The
// caller must have read the list of sources in that file before (TomlTable::read_sources). Throws FileError.
AssessPlan read_plan(const TomlTable &table);

// Reads a word of the command line, such as "target=LAD", and sets the named vessel in the plan. Throws
// std::runtime_error.
void set_vessel(AssessPlan &plan, const std::string &word);

// Returns the name of the plan that is used if the user names none: `angioplasty` if the session has a
// balloon, else `navigation`.
AssessPlan standard_plan(bool has_balloon);

} // namespace crn
