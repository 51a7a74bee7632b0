// Contains the options and the work that `cournand run --plan` and `cournand score` share: to read a plan, to
// observe the session, and to write the assessment.
#pragma once
#include "host/assess/assessment.hpp"
#include "host/assess/observer.hpp"
#include "host/cases/case.hpp"
#include <CLI/CLI.hpp>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

namespace crn
{

struct PlanOptions {
    std::string plan;                 // name or path; empty: none, or the standard one
    std::vector<std::string> vessels; // NAME=VESSEL
};
void add_plan(CLI::App &command, PlanOptions &options, const std::string &help);

// Reads the named plan; if none is named, reads the standard plan for these tools. Throws FileError and
// std::runtime_error.
AssessPlan plan_of(const PlanOptions &options, const SessionLog &log);

// Returns the plan of a case: its table [assessment], or the standard plan. Where the table does not say
// otherwise, `target` is the vessel of the last goal about the tip of the innermost tool, and `ostium` that
// of the last goal about the tip of the guiding catheter. Throws FileError.
AssessPlan read_case_plan(const Case &lesson, bool has_balloon);
// Returns the plan of a case as read_case_plan() does, after checking that the session has the plan's
// vessels.
AssessPlan case_plan(const Case &lesson, const SessionLog &log);

// Observes a session and assesses it.
class SessionAssessor
{
  public:
    // Reads the plan and checks its vessels; throws FileError if they are wrong. `pictures` may be nullptr.
    // If no plan is named, and there is a case, the plan of this case (`lesson`) is used.
    SessionAssessor(const PlanOptions &options, Patient &patient, const std::vector<Instrument> &tools,
                    const TipPlaces &tips, FrameSink *pictures, const Case *lesson = nullptr);
    FrameSink *sink() { return &sinks_; } // of the observer and the pictures
    // Adds the entry "assessment" to the report; the report's score then uses the limits of the plan.
    void assess(nlohmann::ordered_json &report) const;

  private:
    AssessObserver observer_;
    const AssessPlan plan_;
    FrameSinks sinks_;
};

struct ScoreOptions {
    std::string recording, scene, bodies_path, json, html;
    PlanOptions plan;
};
void add_score(CLI::App &app, ScoreOptions &options);
int command_score(const ScoreOptions &options);

} // namespace crn
