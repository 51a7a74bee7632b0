// cournand run
#include "host/base/examples.hpp"
#include "host/base/interrupt.hpp"
#include "host/base/pending_file.hpp"
#include "host/base/progress_line.hpp"
#include "host/base/terminal.hpp"
#include "host/base/text.hpp"
#include "host/command/cli.hpp"
#include "host/command/names.hpp"
#include "host/igtl/feed.hpp"
#include "host/patient/balloon.hpp"
#include "host/patient/patient.hpp"
#include "host/picture/session_pictures.hpp"
#include "host/report/figures/reported_tools.hpp"
#include "host/report/session_summary.hpp"
#include "host/rig/rig.hpp"
#include "host/script/hand_model.hpp"
#include "host/script/session_checks.hpp"
#include "host/session/run.hpp"
#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <nlohmann/json.hpp>

namespace crn
{

namespace
{

void check_files(const RunOptions &options, const PictureSettings &pictures)
{
    std::vector<NamedPath> inputs = tool_inputs(options.instrument, options.tools);
    for (const std::string &stent : options.stents) inputs.push_back({"--stent", stent});
    inputs.insert(
        inputs.end(),
        {{"--scene", options.scene}, {"--session", options.session}, {"--bodies", pictures.bodies_path}});
    if (options.complications != "off") inputs.push_back({"--complications", options.complications});
    complication_commands(options.complications); // a mistake in the file is reported before the session
    if (options.free_run_s && !options.hands.empty())
        throw UsageError("--hands changes a script: name a session");
    if (options.free_run_s && !options.plan.plan.empty())
        throw UsageError("--plan: a session on a rig is assessed from its recording: give --record FILE, and "
                         "then run `cournand score FILE`");
    check_outputs(inputs, {{"--record", options.record},
                           {"--json", options.json},
                           {"--score", options.score},
                           {"--timing", options.timing},
                           {"--png", pictures.png_path},
                           {"--card", options.card},
                           {"--png16", pictures.png16_path},
                           {"--mp4", pictures.mp4_path}});
    check_dicom_settings(pictures.dicom);
}

RunResult carry_out(Device &device, Patient &patient, const SceneFile &scene, const RunOptions &options,
                    const Session &session, Recorder *recorder, FrameSink *sink, const TipPlaces &tips,
                    const SessionWitness &witness)
{
    RunSettings settings{!options.quiet && shows_progress()};
    settings.tips = &tips;
    settings.witness = &witness;
    const std::vector<RoomCommand> limits = complication_commands(options.complications);
    if (!options.free_run_s) {
        settings.begin = begin_commands(session, patient);
        settings.begin.insert(settings.begin.end(), limits.begin(), limits.end());
        return run_session(device, patient, session, recorder, sink, settings);
    }
    settings.begin = entry_commands(scene);
    settings.begin.insert(settings.begin.end(), limits.begin(), limits.end());
    if (patient.stents() && balloon_tool(patient.tools())) settings.begin.push_back(first_stent);
    return run_free_session(device, patient, settings.begin, *options.free_run_s, recorder, sink, settings);
}

void write_card(const std::string &path, const SessionPictures &pictures)
{
    const std::vector<std::uint8_t> bytes =
        encode_png(card_picture(pictures.screen(), pictures.plain_image()));
    write_whole_file(path, {reinterpret_cast<const char *>(bytes.data()), bytes.size()});
    print_files({path});
}

// Writes the files of a session that was observed for its assessment; one of them is the debrief page.
void write_assessed(const RunOptions &options, const RunResult &result, const std::string &scene,
                    const std::string &session, const std::vector<Instrument> &tools, Patient &patient,
                    const SessionAssessor &assessor)
{
    nlohmann::ordered_json report = report_of(result, scene, tools, session, patient);
    assessor.assess(report);
    print_assessment(report["assessment"]);
    if (!options.timing.empty()) write_report(options.timing, timing_of(result, patient));
    if (!options.json.empty()) write_report(options.json, report);
    if (options.score.empty()) return;
    write_debrief(options.score, report["assessment"]);
    print_files({options.score});
}

} // namespace

DeviceChoice free_run_device(const std::string &device, bool motors, bool yes)
{
    DeviceChoice choice = parse_device(device);
    choice.free_run = choice.has_rig = true;
    choice.powers_motors = motors;
    if (!motors) return choice;
    const RigTalk talk = console_talk();
    std::fprintf(
        talk.out,
        "The motors of every track that has a coupling will be powered and push back at the hand, within "
        "the rig's\nown limits (cournand rig info). Ctrl-C or the emergency stop ends it.\n");
    if (!yes && talk.ask("Type yes to power the motors:") != "yes")
        throw RigStopped("not confirmed; no motor was powered");
    return choice;
}

// If the session did not end as it should, prints the reason. Returns the exit code.
static int tell_end(const RunResult &result, const Patient &patient, bool was_stopped)
{
    for (const std::string &failure : result.failures) say(stderr, "cournand: %s\n", failure.c_str());
    if (!result.stopped_by.empty()) {
        say(stderr, "cournand: %s\n", result.stopped_by.c_str());
        return 1;
    }
    if (const int code = exit_of_range(result.figures.range)) return code;
    if (!patient.refusals().empty()) {
        std::fprintf(stderr, "cournand: a request of the session was refused, see 'refused' above\n");
        return 1;
    }
    if (result.was_interrupted || was_stopped) {
        std::fprintf(stderr, "cournand: interrupted; what was written up to here is complete\n");
        return 1;
    }
    return result.failures.empty() ? 0 : 1;
}

// Adds to the options the files for which the session was written, unless the user has named others.
static RunOptions with_needs(const RunOptions &given, const SessionNeeds &needs)
{
    RunOptions options = given;
    if (options.scene.empty()) options.scene = scene_path(needs.scene);
    if (options.tools.empty() && options.instrument.empty())
        for (const std::string &name : needs.tools)
            options.tools.push_back(named_path(instrument_files, name));
    if (options.stents.empty())
        for (const std::string &name : needs.stents) options.stents.push_back(named_path(stent_files, name));
    return options;
}

// Returns the script of the session; for a session on a rig the script is empty.
static Session session_of(const RunOptions &given)
{
    if (given.free_run_s) return {"rig", {}, {}, {}};
    const Session session =
        given.lesson ? case_session(*given.lesson, given.session) : read_session(given.session);
    return given.hands.empty() ? session : with_hands(session, read_hands(given.hands));
}

// The option --line replaces the script's statement `begin with`.
static LineNumbers line_of_run(const RunOptions &options, Session &session)
{
    if (options.free_run_s || !options.line.empty()) {
        const LineNumbers line = line_numbers(options.line, options.instrument, options.tools);
        if (options.free_run_s) return line;
        session.line_names = options.line;
    }
    return resolve_tools(session, tool_words(options.instrument, options.tools));
}

int command_run(const RunOptions &given)
{
    if (given.free_run_s.has_value() != given.session.empty())
        throw UsageError("name a session, or give --free-run (docs/session.md)");
    const bool is_led = given.free_run_s.has_value(); // in FREE_RUN
    check_files(given, given.pictures);
    Session session = session_of(given);
    const RunOptions options = with_needs(given, session.needs);
    PictureSettings picture_settings = options.pictures;
    if (picture_settings.bodies_path.empty()) picture_settings.bodies_path = bodies_beside(options.scene);
    picture_settings.scene_path = options.scene;
    check_files(options, picture_settings);
    const SceneFile scene = read_scene(options.scene);
    const std::vector<Instrument> tools = read_tools(options.instrument, options.tools, CRN_WIRE_TABLE_MAX);
    const LineNumbers line = line_of_run(options, session);
    picture_settings.line = line;
    const std::size_t positions = line.empty() ? tools.size() : line.size();
    const crn_wire_entry entry = is_led ? entry_with(scene, positions, options.inserted_mm)
                                        : entry_of(scene, positions, session.inserted_um);
    take_stents(picture_settings, options.stents, tools);
    check_loads(session, options.stents.size());
    check_inflations(session, tools);
    watch_for_interrupt();
    IgtlOutput watched(options.igtl);
    DeviceChoice choice =
        is_led ? free_run_device(options.device, options.motors, options.yes) : parse_device(options.device);
    Device device(scene, tools, entry, host_rig(), choice, line);

    picture_settings.shows_progress = !options.quiet;
    const SceneAnatomy anatomy = read_anatomy(picture_settings);
    const std::unique_ptr<Patient> patient = make_patient(picture_settings, anatomy, tools);
    std::unique_ptr<SessionPictures> pictures;
    if (writes_pictures(picture_settings) || !options.score.empty() || !options.card.empty() ||
        watched.server()) // a score's page shows the runs
        pictures = std::make_unique<SessionPictures>(picture_settings, tools, *patient, anatomy);
    const TipPlaces tips(anatomy.bodies.vessels, anatomy.motion);
    check_injections(session, patient->contrast());
    std::optional<SessionAssessor> assessor;
    FrameSink *shown = watched.with(pictures.get(), patient.get());
    if (!options.plan.plan.empty()) assessor.emplace(options.plan, *patient, tools, tips, shown);
    std::unique_ptr<Recorder> recorder;
    if (!options.record.empty())
        recorder = std::make_unique<Recorder>(options.record,
                                              device.recording_header(session.file, picture_settings.stents));
    const EffectsWitness witness(tips.map(), *patient);
    CasePlay play(options.lesson, tips, &witness, assessor ? assessor->sink() : shown);
    RunResult result =
        carry_out(device, *patient, scene, options, session, recorder.get(), play.sink(), tips, witness);
    name_range_branch(result.figures.range, picture_settings.bodies_path);
    const std::vector<Instrument> reported = reported_tools(*patient);
    print_session(result, reported, *patient);
    SessionFiles files{options.json, options.score, options.timing, nullptr};
    if (options.lesson)
        files.case_entry = play.end(result, report_of(result, scene.path, reported, session.file, *patient));
    if (assessor)
        write_assessed(options, result, scene.path, session.file, reported, *patient, *assessor);
    else
        write_session_files(files, result, scene.path, reported, session.file, *patient,
                            pictures ? &pictures->screen() : nullptr);
    if (pictures) print_files(pictures->files());
    if (!options.card.empty()) write_card(options.card, *pictures);
    const int code = tell_end(result, *patient, pictures && pictures->was_stopped());
    return code == 0 && options.lesson && !files.case_entry.at("is_reached").get<bool>() ? 1 : code;
}

} // namespace crn
