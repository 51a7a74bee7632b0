// cournand score, and the assessment of cournand run
#include "host/command/cli_assess.hpp"
#include "host/base/interrupt.hpp"
#include "host/base/terminal.hpp"
#include "host/command/cli.hpp"
#include "host/report/session_summary.hpp"
#include "host/session/replay.hpp"
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

SessionAssessor::SessionAssessor(const PlanOptions &options, Patient &patient,
                                 const std::vector<Instrument> &tools, const TipPlaces &tips,
                                 FrameSink *pictures)
    : observer_(patient, tools, tips), plan_(plan_of(options, observer_.log()))
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
    const Recording recording = read_recording(options.recording);
    const RecordingHeader &header = recording.header;
    const SceneFile scene = recorded_scene(header, options.scene);
    Device device(scene, header.tools, header.entry, header.rig);
    check_core(header, device.identity());
    PictureSettings settings;
    settings.bodies_path = options.bodies_path.empty() ? bodies_beside(scene.path) : options.bodies_path;
    settings.scene_path = scene.path;
    settings.stents = header.stents;
    const SceneAnatomy anatomy = read_anatomy(settings);
    const std::unique_ptr<Patient> patient = make_patient(settings, anatomy, header.tools);
    const TipPlaces tips(anatomy.bodies.vessels, anatomy.motion);
    SessionAssessor assessor(options.plan, *patient, header.tools, tips, nullptr);
    watch_for_interrupt();
    ReplaySettings replay;
    replay.verifies = true; // a score of another course than the recorded one would be wrong
    replay.measures_contacts = true;
    const ReplayResult replayed = replay_recording(device, recording, patient.get(), assessor.sink(), replay);
    if (replayed.first_difference_tick)
        throw std::runtime_error(options.recording + ": cannot be scored: at tick " +
                                 std::to_string(*replayed.first_difference_tick) +
                                 " the replay differs from the recording: " + replayed.difference);
    if (replayed.was_interrupted) {
        std::fprintf(stderr, "cournand: interrupted; nothing was written\n");
        return 1;
    }
    nlohmann::ordered_json report =
        report_of(run_result(replayed), scene.path, header.tools, header.session_path, *patient);
    assessor.assess(report);
    const nlohmann::ordered_json &assessment = report["assessment"];
    print_assessment(assessment);
    if (!options.json.empty()) write_report(options.json, assessment);
    if (!options.html.empty()) write_debrief(options.html, assessment);
    std::vector<std::string> files;
    for (const std::string &file : {options.json, options.html})
        if (!file.empty()) files.push_back(file);
    print_files(files);
    if (!recording.is_complete)
        std::printf("the recording was cut off; the score is of its first %zu ticks\n",
                    recording.ticks.size());
    return 0;
}

} // namespace crn
