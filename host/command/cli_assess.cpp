// cournand score, and the assessment of cournand run
#include "host/command/cli_assess.hpp"
#include "host/base/interrupt.hpp"
#include "host/base/terminal.hpp"
#include "host/command/cli.hpp"
#include "host/command/recorded_score.hpp"
#include "host/report/session_summary.hpp"
#include <map>
#include <nlohmann/json.hpp>

namespace crn
{

void add_plan(CLI::App &command, PlanOptions &options, const std::string &help)
{
    command.add_option("--plan", options.plan, help);
    command
        .add_option("--vessel", options.vessels,
                    "NAME=VESSEL, such as target=LAD: which vessel a name in the plan means; once per name")
        ->allow_extra_args(false);
}

AssessPlan plan_of(const PlanOptions &options, const SessionLog &log)
{
    AssessPlan plan = options.plan.empty() ? standard_plan(log.has_balloon)
                                           : read_plan(named_path(plan_files, options.plan));
    for (const std::string &word : options.vessels) set_vessel(plan, word);
    check_plan(plan, log);
    return plan;
}

// A vessel of the plan that the case does not name is the vessel of one of the case's goals.
AssessPlan read_case_plan(const Case &lesson, bool has_balloon)
{
    AssessPlan plan;
    if (lesson.has_assessment) {
        const TomlTable root = read_toml(lesson.file, {"a case file", "a case file (docs/cases.md)"});
        plan = read_plan(root.table("assessment"));
    } else {
        plan = standard_plan(has_balloon);
    }
    const std::map<std::string, std::string> named = plan.vessels.names;
    const std::size_t last = lesson.start.tools.size() - 1;
    for (const CaseGoal &goal : lesson.goals) {
        const Expectation &expected = goal.expectation;
        if (expected.kind != Expectation::Kind::tip) continue;
        if (expected.tool == 0) plan.vessels.names["target"] = expected.vessel.text;
        if (expected.tool == last && last > 0 && has_balloon)
            plan.vessels.names["ostium"] = expected.vessel.text;
    }
    for (const auto &[name, vessel] : named) plan.vessels.names[name] = vessel;
    return plan;
}

AssessPlan case_plan(const Case &lesson, const SessionLog &log)
{
    AssessPlan plan = read_case_plan(lesson, log.has_balloon);
    check_plan(plan, log);
    return plan;
}

SessionAssessor::SessionAssessor(const PlanOptions &options, Patient &patient,
                                 const std::vector<Instrument> &tools, const TipPlaces &tips,
                                 FrameSink *pictures, const Case *lesson)
    : observer_(patient, tools, tips),
      plan_(lesson && options.plan.empty() ? case_plan(*lesson, observer_.log())
                                           : plan_of(options, observer_.log()))
{
    sinks_.add(&observer_);
    sinks_.add(pictures);
}

void SessionAssessor::assess(nlohmann::ordered_json &report) const
{
    report["score"] = score_of(report, plan_.limits);
    report["assessment"] = assessment_of(plan_, observer_.log(), report);
}

void add_score(CLI::App &app, ScoreOptions &options)
{
    CLI::App *command = app.add_subcommand(
        "score", "Assess a recorded session: errors, phases, result, burden (docs/assessment.md)");
    command->add_option("recording", options.recording, "The recording")->required();
    add_plan(*command, options.plan,
             "Name or file of the assessment plan; default: angioplasty with a balloon, else navigation");
    command->add_option("--json", options.json, "Write the assessment");
    command->add_option("--html", options.html, "Write the debrief as one page");
    command->add_option("--scene", options.scene, "The scene, when it is no longer where the recording says");
    command->add_option("--bodies", options.bodies_path,
                        "Body file; default: the scene's .bodies file, if there is one");
    command->footer(
        "Examples:\n  cournand score out/demo.rec\n  cournand score out/pci.rec --plan angioplasty "
        "--vessel target=LAD \\\n      --vessel ostium=LM --json out/pci_score.json --html "
        "out/pci_debrief.html");
}

int command_score(const ScoreOptions &options)
{
    check_outputs({{"the recording", options.recording},
                   {"--scene", options.scene},
                   {"--bodies", options.bodies_path},
                   {"--plan", options.plan.plan}},
                  {{"--json", options.json}, {"--html", options.html}});
    watch_for_interrupt();
    const RecordedScore score =
        score_recording({options.recording, options.scene, options.bodies_path, options.plan, nullptr, {}});
    if (score.was_stopped) {
        std::fprintf(stderr, "cournand: interrupted; nothing was written\n");
        return 1;
    }
    const nlohmann::ordered_json &report = score.report;
    const nlohmann::ordered_json &assessment = report["assessment"];
    print_assessment(assessment);
    if (!options.json.empty()) write_report(options.json, assessment);
    if (!options.html.empty()) write_debrief(options.html, assessment);
    std::vector<std::string> files;
    for (const std::string &file : {options.json, options.html})
        if (!file.empty()) files.push_back(file);
    print_files(files);
    if (!score.is_complete)
        std::printf("the recording was cut off; the score is of its first %u ticks\n", unsigned{score.ticks});
    return 0;
}

} // namespace crn
