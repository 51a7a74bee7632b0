#include "host/command/cli.hpp"
#include "firmware/core/core.h"
#include "host/base/command_values.hpp"
#include "host/base/terminal.hpp"
#include "host/base/version.hpp"
#include "host/cli/parse.hpp"
#include "host/command/cli_case.hpp"
#include "host/command/cli_dicom.hpp"
#include "host/command/cli_patient.hpp"
#include "host/command/cli_records.hpp"
#include "host/command/cli_rig.hpp"
#include "host/command/names.hpp"
#include "host/command/start.hpp"
#include "host/complications/limits.hpp"
#include "host/igtl/feed.hpp"
#include "host/model/units.hpp"
#include "host/report/instrument_list.hpp"
#include "host/session/replay.hpp"
#include "shared/wire/wire.h"
#include <CLI/CLI.hpp>
#include <cmath>
#include <cstdio>
#include <filesystem>

namespace crn
{

namespace
{

// While an object of this class exists, new options of the command are listed in this group of the command's
// help text.
class Group
{
  public:
    Group(CLI::App &command, const char *name) : command_(command) { command.option_defaults()->group(name); }
    ~Group() { command_.option_defaults()->group("Options"); }
    Group(const Group &) = delete;
    Group &operator=(const Group &) = delete;

  private:
    CLI::App &command_;
};

// Adds an option for a file that the command writes.
CLI::Option *add_output(CLI::App &command, const std::string &names, std::string &path,
                        const std::string &text)
{
    return command.add_option(names, path, text)->type_name("FILE")->group("Outputs");
}

void add_igtl(CLI::App &command, std::string &address)
{
    command
        .add_option("--igtl", address,
                    "Let 3D Slicer and other OpenIGTLink clients watch the session (docs/slicer.md): a port, "
                    "such as 18944, for clients on this machine, or HOST:PORT; 0: any free port")
        ->type_name("ADDRESS")
        ->check([](const std::string &text) {
            try {
                parse_igtl_address(text);
                return std::string();
            } catch (const std::runtime_error &error) {
                return std::string(error.what());
            }
        });
}

void add_xray(CLI::App &command, PictureSettings &pictures)
{
    command
        .add_option("--style", pictures.style,
                    "Look of the X-ray: physical, or vcsim3 as in the thesis (docs/xray-style.md)")
        ->capture_default_str()
        ->check(one_of({"physical", "vcsim3"}));
    command
        .add_option(
            "--xray", pictures.xray,
            "Who draws the path lengths: raster (no graphics driver, the same bytes everywhere), opengl "
            "(OSMesa, where that is missing EGL), opengl-osmesa, opengl-egl")
        ->capture_default_str()
        ->check(one_of(path_choices));
}

void add_xray_window(CLI::App &command, PictureSettings &pictures)
{
    command
        .add_option(
            "--xray", pictures.xray,
            "Who draws the path lengths: raster (the same bytes everywhere), opengl (the window's own)")
        ->capture_default_str()
        ->check(one_of(path_choices_window));
}

void add_pictures(CLI::App &command, PictureSettings &pictures)
{
    add_output(command, "--png", pictures.png_path, "Write the last picture with its display, 8 bits");
    add_output(command, "--png16", pictures.png16_path,
               "Write the last X-ray's values, 16 bits, grey, proportional to the X-ray intensity");
    add_output(command, "--mp4", pictures.mp4_path, "Write all pictures as a film, H.264");
    add_dicom_options(command, pictures.dicom);
    const Group group(command, "Pictures");
    command
        .add_option("--bodies", pictures.bodies_path,
                    "Body file for the picture; default: the scene's .bodies file, if there is one")
        ->type_name("FILE");
    command.add_option("--size", pictures.size, "Pixels along each edge")
        ->capture_default_str()
        ->check(CLI::Range(64, 2048));
    command.add_option("--fps", pictures.pictures_per_second, "Pictures per second")
        ->capture_default_str()
        ->check(CLI::Range(1, 60));
    command.add_option("--seed", pictures.seed, "Seed of the quantum noise")->capture_default_str();
    command
        .add_option("--threads", pictures.threads, "Threads of the X-ray, 0: one per processor, at most 4")
        ->capture_default_str()
        ->check(CLI::Range(0, 64));
    add_xray(command, pictures);
}

void add_scene(CLI::App &command, std::string &scene, const std::string &without)
{
    const Group group(command, "Patient and tools");
    command.add_option("--scene", scene, "Name or file of a baked scene; without: " + without)
        ->type_name("SCENE")
        ->check(scene_name());
}

void add_tools(CLI::App &command, std::string &instrument, std::vector<std::string> &tools,
               std::vector<std::string> &line)
{
    const Group group(command, "Patient and tools");
    command
        .add_option("--tool", tools,
                    "Name or file of an instrument, maybe with :preset (docs/instruments.md); once per tool, "
                    "from the "
                    "innermost to the outermost, at most three; up to eight, in any order, with --line or if "
                    "a script says 'begin with'")
        ->allow_extra_args(false)
        ->type_name("INSTRUMENT")
        ->transform(name_or_path(instrument_files));
    command
        .add_option(
            "--line", line,
            "The tools on the line at the start, from the innermost, such as bentson,nothing,guide_jl4_6f: "
            "names or numbers of the tools, 'nothing' for a free position; the other tools can be "
            "loaded during the session; without: all tools")
        ->delimiter(',')
        ->allow_extra_args(false)
        ->type_name("TOOL,...");
    command.add_option("--instrument", instrument, "The innermost tool, as --tool before all others")
        ->type_name("INSTRUMENT")
        ->transform(name_or_path(instrument_files));
}

void add_stents(CLI::App &command, std::vector<std::string> &stents, PictureSettings &pictures)
{
    const Group group(command, "Patient and tools");
    command
        .add_option("--stent", stents,
                    "Name or file of a stent (docs/stent.md) for the tool with a balloon; once per stent, in "
                    "the order of "
                    "loading: the first "
                    "is on the balloon from the start, unless a script says 'load stent'")
        ->allow_extra_args(false)
        ->type_name("STENT")
        ->transform(name_or_path(stent_files));
    command
        .add_option("--balloon-iodine", pictures.balloon_iodine_mg_per_ml,
                    "What fills a balloon, mg iodine per ml: half of it contrast medium, half saline")
        ->capture_default_str()
        ->check(CLI::Range(0.0, 350.0));
}

void add_complications(CLI::App &command, std::string &complications)
{
    const Group group(command, "Patient and tools");
    command
        .add_option("--complications", complications,
                    "File of the limits at which vessels are dissected or perforated "
                    "(docs/complications.md), or off: vessels bear everything")
        ->type_name("FILE|off");
}

void add_device(CLI::App &command, std::string &device)
{
    const Group group(command, "Rig");
    command
        .add_option(
            "--device", device,
            "Where the device is: sim (in this program), emulator (the firmware's image on an emulated "
            "Cortex-M7, docs/hil.md), usb, or usb:SERIAL (docs/rig.md)")
        ->capture_default_str();
}

void add_inserted(CLI::App &command, std::vector<double> &inserted_mm)
{
    const Group group(command, "Patient and tools");
    command
        .add_option("--inserted", inserted_mm,
                    "Inserted length at the start, mm; once for all tools, or once per tool; without: the "
                    "scene's start length (20 in free space)")
        ->allow_extra_args(false)
        ->check(CLI::Range(0.0, 2000.0));
}

void add_motors(CLI::App &command, bool &motors, bool &yes)
{
    const Group group(command, "Rig");
    command.add_flag(
        "--motors", motors,
        "With --free-run: power the tracks whose damping the rig reports (docs/rig.md), after a typed yes");
    command.add_flag("--yes", yes, "Power the motors without asking");
}

void add_run(CLI::App &app, RunOptions &options)
{
    CLI::App *command = app.add_subcommand("run", "Carry out a session script, or what hands do at a rig");
    command
        ->add_option("session,--session", options.session,
                     "Name or file of a session script (docs/session.md), carried out as fast as the machine "
                     "allows; it may name its own scene, tools and stents")
        ->type_name("SESSION")
        ->transform(name_or_path(session_files));
    add_scene(*command, options.scene, "that of the session, else free space");
    add_tools(*command, options.instrument, options.tools, options.line);
    add_stents(*command, options.stents, options.pictures);
    add_complications(*command, options.complications);
    command
        ->add_option("--free-run", options.free_run_s,
                     "Instead of a script: FREE_RUN for so many seconds, 0: until Ctrl-C (docs/rig.md)")
        ->check(CLI::Range(0.0, 36000.0));
    add_motors(*command, options.motors, options.yes);
    add_inserted(*command, options.inserted_mm);
    add_device(*command, options.device);
    command->add_option("--hands", options.hands,
                        "Play the script with the hands of an expert, a novice or a clumsy person, such as "
                        "novice:7; the number is the seed (docs/assessment.md)");
    add_output(*command, "--record", options.record, "Write a recording");
    add_output(*command, "--json", options.json, "Write the figures of the session");
    add_output(*command, "--score", options.score,
               "Write what the angioplasty is worth, as one HTML page (docs/score.md)");
    add_output(*command, "--timing", options.timing, "Write what the session took of the machine");
    add_plan(*command, options.plan,
             "Assess the session by this plan (name or file): --json has the assessment, and --score is the "
             "debrief (docs/assessment.md)");
    add_igtl(*command, options.igtl);
    command->add_flag("--quiet", options.quiet, "No progress line");
    add_pictures(*command, options.pictures);
    command->footer(
        "Examples:\n"
        "  cournand run demo\n"
        "  cournand run demo --mp4 demo.mp4 --record demo.rec --json demo.json\n"
        "  cournand run iliac_to_arch --tool bentson\n"
        "  cournand run my.session --scene aorta --tool j_wire --tool beacon_5f --dicom my_dicom\n"
        "  cournand run --device usb --scene aorta --tool j_wire --free-run 60 --record my.rec");
}

void add_replay(CLI::App &app, ReplayOptions &options)
{
    CLI::App *command = app.add_subcommand("replay", "Play a recording again, bit for bit");
    command
        ->add_option("recording", options.recording,
                     "File of the recording, or name of a kept one; last: the newest one that is kept")
        ->type_name("RECORDING")
        ->required()
        ->transform(recording_name());
    command->add_flag("--verify", options.verify,
                      "Compare the hash of every tick; stop at the first difference");
    command
        ->add_option("--speed", options.speed,
                     "fast, slow (half real time), paused, or a factor of real time")
        ->capture_default_str()
        ->check([](const std::string &text) {
            return replay_speed(text) ? std::string()
                                      : "'" + text + "' is not fast, slow, paused or a factor 0.001 .. 1000";
        });
    command->add_option("--from", options.from_s, "Start at this second, from the snapshot before it")
        ->capture_default_str()
        ->check(CLI::Range(0.0, 1e6));
    add_scene(*command, options.scene, "the one that the recording names");
    add_output(*command, "--json", options.json, "Write the figures of the session, as run does");
    add_output(*command, "--score", options.score,
               "Write what the angioplasty is worth, as one HTML page (docs/score.md)");
    add_igtl(*command, options.igtl);
    add_pictures(*command, options.pictures);
    CLI::Option *upgrade =
        command->add_flag("--upgrade", options.upgrades,
                          "Play nothing: convert a recording of an older version, and write it with -o");
    CLI::Option *output = add_output(*command, "-o,--output", options.upgraded, "The converted recording");
    upgrade->needs(output);
    output->needs(upgrade);
    for (const char *other :
         {"--verify", "--json", "--score", "--png", "--png16", "--mp4", "--dicom", "--igtl"})
        upgrade->excludes(command->get_option(other));
    command->footer("Examples:\n"
                    "  cournand replay last --verify\n"
                    "  cournand replay demo.rec --speed slow --from 12.5\n"
                    "  cournand replay demo.rec --dicom demo_dicom --size 1024\n"
                    "  cournand replay --upgrade old.rec -o new.rec");
}

void add_surface(CLI::App &app, SurfaceOptions &options)
{
    CLI::App *command = app.add_subcommand(
        "surface", "The walls round a lesion at moments of a recording, as polygons (docs/lesions.md)");
    command
        ->add_option("recording", options.recording,
                     "Recording of a session in a scene with lesions, as for replay")
        ->type_name("RECORDING")
        ->required()
        ->transform(recording_name());
    command->add_option("--at", options.at_s, "Moment, s from the begin; once per moment")
        ->allow_extra_args(false);
    command->add_flag(
        "--stages", options.stages,
        "The three moments about the first inflation: balloon positioned, inflated, and down again; "
        "their seconds are printed");
    command->add_option("--lesion", options.surface.lesion, "Its name; without: the scene's first");
    command
        ->add_option("--around", options.surface.around_mm,
                     "Millimetres of vessel to either side of the lesion")
        ->capture_default_str()
        ->check(CLI::Range(0.0, 200.0));
    add_scene(*command, options.scene, "the one that the recording names");
    command
        ->add_option("--bodies", options.surface.bodies_path, "Body file; default: the scene's .bodies file")
        ->type_name("FILE");
    add_output(*command, "-o,--output", options.surface.output,
               "OBJ file, mm: objects TIME_BODY, and TIME_balloon for a balloon")
        ->required();
    add_output(*command, "--png", options.surface.png,
               "And a picture: the moments side by side, the lesion from the side");
    command->footer("Examples:\n"
                    "  cournand surface out/pci_lad.rec --stages -o lesion.obj\n"
                    "  cournand surface last --at 5 --at 12.5 --at 30 -o lesion.obj");
}

void add_view(CLI::App &app, WindowOptions &options)
{
    CLI::App *command = app.add_subcommand("view", "A window: push, turn and look by keyboard");
    add_scene(*command, options.scene, "free space, or aorta if no tool is named either");
    add_tools(*command, options.instrument, options.tools, options.line);
    add_stents(*command, options.stents, options.pictures);
    add_complications(*command, options.complications);
    add_device(*command, options.device);
    add_output(*command, "--record", options.record,
               "Write the recording of what the hands do here; without: by date and time in "
               "~/.local/state/cournand");
    command->add_flag("!--no-record", options.keeps_recording, "Without --record: keep no recording");
    add_output(*command, "--json", options.json, "Write the figures of the session at its end, as run does");
    add_output(*command, "--score", options.score,
               "Write what the angioplasty is worth, as one HTML page (docs/score.md)");
    add_igtl(*command, options.igtl);
    add_dicom_options(*command, options.pictures.dicom);
    command
        ->add_option("--bodies", options.pictures.bodies_path,
                     "Body file; default: the scene's .bodies file, if there is one")
        ->type_name("FILE");
    command->add_option("--size", options.pictures.size, "Pixels along each edge of the X-ray")
        ->capture_default_str()
        ->check(CLI::Range(64, 2048));
    command->add_option("--seed", options.pictures.seed, "Seed of the quantum noise")->capture_default_str();
    command->add_option("--threads", options.pictures.threads, "Threads of the X-ray, 0: one per processor")
        ->capture_default_str()
        ->check(CLI::Range(0, 64));
    add_xray_window(*command, options.pictures);
    add_inserted(*command, options.inserted_mm);
    command
        ->add_flag("--free-run", options.free_run,
                   "The rig's own encoders are the hands, and its first button the X-ray pedal (docs/rig.md)")
        ->group("Rig");
    add_motors(*command, options.motors, options.yes);
    command->add_flag("--fluoro", options.starts_with_fluoro, "X-ray on from the start");
    command->add_flag("!--no-help-panel", options.shows_help, "Start without the list of keys");
    command->add_option("--frames", options.frames, "End after so many screens of 1/60 s; 0: until Esc")
        ->capture_default_str()
        ->check(CLI::Range(0, 1000000));
    add_output(*command, "--screenshot", options.screenshot, "Write the last screen as PNG");
    command->add_option("--width", options.window_width, "Width of the window at the start, pixels")
        ->capture_default_str()
        ->check(CLI::Range(800, 7680));
    command->add_option("--height", options.window_height, "Height of the window at the start, pixels")
        ->capture_default_str()
        ->check(CLI::Range(450, 4320));
    command->add_option("--font", options.font,
                        "TrueType file of the window's letters; default: DejaVu Sans");
    command->add_flag("--start", options.opens_start,
                      "Begin with the cards of cases, practice and recordings");
    command->add_option("--replay", options.replays, "Show any moment of this recording from any angle");
    add_output(*command, "--timing", options.timing,
               "Write what the window took of the machine: late ticks, pictures, delays");
    add_output(*command, "--layout", options.layout,
               "Write the names and places of the controls on the screen, for tests that press them");
    command->footer("Examples:\n"
                    "  cournand view\n"
                    "  cournand view --scene aorta --tool bentson\n"
                    "  cournand view --tool bentson --tool beacon_5f --inserted 60 --inserted 40\n"
                    "  cournand view --record view.rec --dicom view_dicom");
}

void add_instruments(CLI::App &app, InstrumentsOptions &options)
{
    CLI::App *command =
        app.add_subcommand("instruments", "List instruments with size, stiffness, shape and presets");
    command
        ->add_option(
            "file", options.files,
            "Names or files of instruments, each maybe with :preset, or folders; without: those that come "
            "with the program")
        ->transform(name_or_path(instrument_files));
    command->add_option("--preset", options.preset,
                        "This preset of every file that has it; default: physical");
    add_output(*command, "--png", options.png, "Draw stiffness and unloaded shape");
    add_output(*command, "--json", options.json, "Write every figure, knots and shapes included");
    add_output(*command, "--table", options.table, "Renew the table in a document (docs/instruments.md)");
    command->footer("Examples:\n"
                    "  cournand instruments\n"
                    "  cournand instruments --png instruments.png\n"
                    "  cournand instruments bentson:vcsim3-fit --json bentson.json");
}

} // namespace

void take_stents(PictureSettings &settings, const std::vector<std::string> &paths,
                 const std::vector<Instrument> &tools)
{
    settings.stents = read_stents(paths, tools);
}

crn_wire_entry entry_with(const SceneFile &scene, std::size_t tool_count,
                          const std::vector<double> &inserted_mm)
{
    std::vector<std::uint32_t> inserted_um;
    for (double mm : inserted_mm) inserted_um.push_back(static_cast<std::uint32_t>(std::lround(mm * 1e3)));
    if (inserted_um.size() == 1) inserted_um.assign(tool_count, inserted_um.front());
    if (inserted_um.size() > tool_count)
        throw UsageError("--inserted is given " + std::to_string(inserted_um.size()) +
                         " times, but there are only " + std::to_string(tool_count) + " tools");
    return entry_of(scene, tool_count, inserted_um);
}

std::vector<RoomCommand> complication_commands(const std::string &complications)
{
    if (complications.empty()) return {};
    ComplicationLimits limits;
    limits.is_on = complications != "off";
    return commands_of(limits.is_on ? read_complications(complications) : limits);
}

std::vector<RoomCommand> entry_commands(const SceneFile &scene)
{
    RoomCommand table{RoomAction::table, {}};
    const std::int32_t place_m_q30[3] = {scene.entry.position_x_m_q30, scene.entry.position_y_m_q30,
                                         scene.entry.position_z_m_q30};
    for (int axis = 0; axis < 3; ++axis)
        table.values[axis] = static_cast<std::int32_t>(std::lround(units::metres(place_m_q30[axis]) * 1e6));
    return {table, {RoomAction::follow, {1, 0, 0}}};
}

void choose_defaults(WindowOptions &options)
{
    if (!options.tools.empty() || !options.instrument.empty()) return;
    options.tools = {example_path(instrument_files, "j_wire")};
    if (options.scene.empty()) options.scene = scene_path("aorta");
}

struct InfoOptions {
    std::string file;
    bool shows_opengl = false;
};

static void add_info(CLI::App &app, InfoOptions &info)
{
    CLI::App *info_command =
        app.add_subcommand("info", "What a recording, scene, instrument or session file holds");
    CLI::Option *info_file =
        info_command->add_option("file", info.file, "Name or file")->type_name("NAME")->transform(any_name());
    info_command->add_flag("--opengl", info.shows_opengl, "Instead: the OpenGL that --xray opengl finds here")
        ->excludes(info_file);
    info_command->footer("Examples:\n  cournand info demo\n  cournand info j_wire\n  cournand info last\n  "
                         "cournand info --opengl");
}

// `cournand` alone.
static int start(const std::string &program, const OpenStart &open_start)
{
    if (open_start && has_display()) return open_start();
    say(stdout, "%s", start_text(program).c_str());
    return 0;
}

int command_line(int argc, char **argv, const RunWindow &run_window, const OpenStart &open_start)
{
    CLI::App app("Cournand: endovascular instruments in fixed point, seen under X-ray", "cournand");
    app.require_subcommand(argc > 1 ? 1 : 0);
    app.set_help_all_flag("--help-all", "Help of every command");
    RunOptions run;
    ReplayOptions replay;
    SurfaceOptions surface;
    WindowOptions window;
    ScoreOptions score;
    add_run(app, run);
    add_replay(app, replay);
    add_score(app, score);
    add_surface(app, surface);
    add_view(app, window);
    InstrumentsOptions instruments;
    add_instruments(app, instruments);
    RigOptions rig;
    add_rig(app, rig);
    RecordsOptions records;
    add_records(app, records);
    DicomCheckOptions dicom_check;
    add_dicom_check(app, dicom_check);
    CaseOptions lesson;
    add_case(app, lesson);
    PatientCommandOptions patient;
    add_patient(app, patient);
    InfoOptions info;
    add_info(app, info);
    app.footer(
        "Examples:\n  cournand\n  cournand run demo\n  cournand run --help\n  cournand replay last --verify");
    app.set_version_flag("--version", version_of("cournand") + ", core " +
                                          std::to_string(int{CRN_CORE_VERSION}) + ", protocol " +
                                          std::to_string(int{CRN_WIRE_PROTOCOL_MAJOR}) + "." +
                                          std::to_string(int{CRN_WIRE_PROTOCOL_MINOR}));
    if (const std::optional<int> code = parse_command_line(app, argc, argv, names_of_type)) return *code;
    try {
        if (argc < 2) return start(argc > 0 ? argv[0] : "cournand", open_start);
        for (std::string *scene : {&run.scene, &replay.scene, &surface.scene, &window.scene})
            *scene = scene_path(*scene);
        if (app.got_subcommand("run")) return command_run(run);
        if (app.got_subcommand("replay")) return command_replay(replay);
        if (app.got_subcommand("score")) return command_score(score);
        if (app.got_subcommand("surface")) return command_surface(surface);
        if (app.got_subcommand("view")) {
            if (!run_window)
                throw UsageError("view: this program was built without its window, since the machine had no "
                                 "display: `make window` builds it");
            choose_defaults(window);
            window.watched = open_told_igtl(window.igtl);
            return run_window(window);
        }
        if (app.got_subcommand("instruments")) return command_instruments(instruments);
        if (app.got_subcommand("rig")) return command_rig(rig);
        if (app.got_subcommand("records")) return command_records(records);
        if (app.got_subcommand("case")) return command_case(app, lesson, run_window);
        if (app.got_subcommand("patient")) return command_patient(app, patient);
        if (app.got_subcommand("dicom-check")) return command_dicom_check(dicom_check);
        if (info.shows_opengl) return command_info_opengl();
        if (info.file.empty()) throw UsageError("info: name a file, or --opengl");
        return command_info(info.file);
    } catch (const UsageError &error) {
        say(stderr, "cournand: %s\n", error.what());
        return 2;
    } catch (const std::exception &error) {
        say(stderr, "cournand: %s\n", error.what());
        return 1;
    }
}

} // namespace crn
