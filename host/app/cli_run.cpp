// cournand run
#include "host/app/cli.hpp"
#include "host/app/cli_rig.hpp"
#include "host/app/run.hpp"
#include "host/app/session_balloon.hpp"
#include "host/app/session_effects.hpp"
#include "host/app/session_summary.hpp"
#include "host/model/interrupt.hpp"
#include "host/model/terminal.hpp"
#include "host/model/text.hpp"
#include <algorithm>
#include <cstdio>
#include <unistd.h>

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
    if (options.free_run_s.has_value() != options.session.empty())
        throw UsageError("either --session or --free-run says who leads");
    check_outputs(inputs, {{"--record", options.record},
                           {"--json", options.json},
                           {"--score", options.score},
                           {"--png", pictures.png_path},
                           {"--png16", pictures.png16_path},
                           {"--mp4", pictures.mp4_path}});
    check_dicom_settings(pictures.dicom);
}

// An injection that these tools or this scene do not allow is found before the session begins.
void check_injections(const Session &session, const std::vector<Instrument> &tools,
                      const SessionPictures *pictures)
{
    double iodine_mg_per_ml = iodine_default_mg_per_ml;
    for (const Statement &statement : session.statements)
        for (const RoomCommand &command : statement.room) {
            if (command.action == RoomAction::contrast_strength) iodine_mg_per_ml = command.values[0];
            const std::string why = pictures ? pictures->contrast().refusal(command, iodine_mg_per_ml)
                                             : injection_refusal(tools, command, iodine_mg_per_ml);
            if (!why.empty()) throw FileError(session.file, statement.line, 0, why);
        }
}

void check_inflations(const Session &session, const std::vector<Instrument> &tools)
{
    if (balloon_tool(tools)) return;
    for (const Statement &statement : session.statements)
        if (statement.inflation)
            throw FileError(session.file, statement.line, 0,
                            std::string(no_balloon_text) + ": name a balloon catheter with --tool");
}

std::size_t count_loads(const Session &session)
{
    std::size_t count = 0;
    for (const Statement &statement : session.statements)
        for (const RoomCommand &command : statement.room) count += command.action == RoomAction::load_stent;
    return count;
}

void check_loads(const Session &session, std::size_t stents)
{
    std::size_t count = 0;
    for (const Statement &statement : session.statements)
        for (const RoomCommand &command : statement.room) {
            count += command.action == RoomAction::load_stent;
            if (count > stents)
                throw FileError(session.file, statement.line, 0,
                                "loads stent " + std::to_string(count) + ", but " + std::to_string(stents) +
                                    " are given: name each with --stent");
        }
}

RunResult carry_out(Device &device, const SceneFile &scene, const RunOptions &options, const Session &session,
                    Recorder *recorder, FrameSink *sink, bool is_mounted, const TipPlaces &tips,
                    const SessionWitness &witness)
{
    RunSettings settings{!options.quiet && isatty(STDERR_FILENO) != 0};
    settings.tips = &tips;
    settings.witness = &witness;
    std::vector<RoomCommand> begin = options.free_run_s ? entry_commands(scene) : std::vector<RoomCommand>();
    if (is_mounted) begin.push_back(first_stent);
    settings.begin = begin;
    settings.measures_contacts = !options.score.empty();
    return options.free_run_s ? run_free_session(device, begin, *options.free_run_s, recorder, sink, settings)
                              : run_session(device, session, recorder, sink, settings);
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

// Why it did not end as it should, if so; the exit code.
static int tell_end(const RunResult &result, const ReportSources &sources, bool was_stopped)
{
    for (const std::string &failure : result.failures) say(stderr, "cournand: %s\n", failure.c_str());
    if (!result.stopped_by.empty()) {
        say(stderr, "cournand: %s\n", result.stopped_by.c_str());
        return 1;
    }
    if (const int code = exit_of_range(result.figures.range)) return code;
    if (!sources.refusals.empty()) {
        std::fprintf(stderr,
                     "cournand: something that the session asked for was refused, see 'refused' above\n");
        return 1;
    }
    if (result.was_interrupted || was_stopped) {
        std::fprintf(stderr, "cournand: interrupted; what was written up to here is complete\n");
        return 1;
    }
    return result.failures.empty() ? 0 : 1;
}

int command_run(const RunOptions &options)
{
    PictureSettings picture_settings = options.pictures;
    if (picture_settings.bodies_path.empty()) picture_settings.bodies_path = bodies_beside(options.scene);
    picture_settings.scene_path = options.scene;
    check_files(options, picture_settings);
    const bool is_led = options.free_run_s.has_value(); // by the rig
    const SceneFile scene = read_scene(options.scene);
    const std::vector<Instrument> tools = read_tools(options.instrument, options.tools);
    const Session session = is_led ? Session{"rig", {}, {}} : read_session(options.session);
    const crn_wire_entry entry = is_led ? entry_with(scene, tools.size(), options.inserted_mm)
                                        : entry_of(scene, tools.size(), session.inserted_um);
    take_stents(picture_settings, options.stents, tools);
    check_loads(session, options.stents.size());
    check_inflations(session, tools);
    watch_for_interrupt();
    DeviceChoice choice =
        is_led ? free_run_device(options.device, options.motors, options.yes) : parse_device(options.device);
    choice.picture_every_ticks = static_cast<std::uint16_t>(
        (1000 + picture_settings.pictures_per_second - 1) / picture_settings.pictures_per_second);
    Device device(scene, tools, entry, host_rig(), choice);

    picture_settings.shows_progress = !options.quiet;
    const SessionSinks sinks = make_sinks(picture_settings, tools, !options.score.empty(),
                                          !picture_settings.stents.empty() || needs_effects(session));
    SessionStents *stents = sinks.stents();
    const std::unique_ptr<TipPlaces> tips =
        read_tip_places(picture_settings.bodies_path, picture_settings.scene_path);
    const EffectsWitness witness(tips->map(), sinks.contrast(), stents);
    check_injections(session, tools, sinks.pictures.get());
    std::unique_ptr<Recorder> recorder;
    if (!options.record.empty()) {
        const RecordingHeader header = {device.identity().core_version,
                                        device.identity().schema_hash,
                                        static_cast<std::uint32_t>(scene.bytes.size()),
                                        scene.crc32,
                                        scene.path,
                                        session.file,
                                        tools,
                                        entry,
                                        device.rig(),
                                        picture_settings.stents};
        recorder = std::make_unique<Recorder>(options.record, header);
    }
    RunResult result = carry_out(device, scene, options, session, recorder.get(), sinks.sink(),
                                 stents && count_loads(session) == 0, *tips, witness);
    name_range_branch(result.figures.range, picture_settings.bodies_path);
    const ReportSources sources = sinks.sources();
    print_session(result, tools, sources);
    write_session_files({options.json, options.score}, result, scene.path, tools, session.file, sources);
    if (sinks.pictures) print_files(sinks.pictures->files());
    return tell_end(result, sources, sinks.pictures && sinks.pictures->was_stopped());
}

} // namespace crn
