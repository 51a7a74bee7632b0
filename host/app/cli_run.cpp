// seldinger run
#include "host/app/cli.hpp"
#include "host/app/cli_rig.hpp"
#include "host/app/interrupt.hpp"
#include "host/app/run.hpp"
#include "host/app/score.hpp"
#include "host/model/text.hpp"
#include <algorithm>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <numeric>
#include <unistd.h>

namespace seld
{

void print_tools(const std::vector<Instrument> &tools, const SessionFigures &figures)
{
    for (std::size_t k = 0; k < figures.tools.size() && k < tools.size(); k++) {
        const ToolFigures &tool = figures.tools[k];
        std::printf("tool %zu                %s\n", k + 1, tools[k].name.c_str());
        std::printf("  inserted            %.1f mm at the end, %.1f mm at most\n", tool.inserted_m * 1e3,
                    tool.inserted_max_m * 1e3);
        std::printf("  largest hand force  %.2f N, torque %.2f mN m\n", tool.axial_max_N,
                    tool.torque_max_N_m * 1e3);
    }
}

void print_files(const std::vector<std::string> &files)
{
    for (const std::string &file : files) std::printf("written               %s\n", file.c_str());
}

namespace
{

constexpr std::size_t score_pictures_max = 8; // of a page

void print_result(const RunResult &result, const std::vector<Instrument> &tools)
{
    const SessionFigures &figures = result.figures;
    std::printf("ticks                 %u (%.3f s)\n", unsigned{figures.ticks}, figures.ticks * 1e-3);
    std::printf("final hash            %016llx\n", static_cast<unsigned long long>(result.hash));
    std::printf("wall clock            %.2f s, %.1f times real time\n", result.seconds,
                result.seconds > 0.0 ? figures.ticks * 1e-3 / result.seconds : 0.0);
    std::printf("worst penetration     %.3f mm at tick %u\n", figures.penetration_max_m * 1e3,
                unsigned{figures.penetration_max_tick});
    std::printf("worst length error    %.4f %% at tick %u\n", figures.strain_max * 1e2,
                unsigned{figures.strain_max_tick});
    print_tools(tools, figures);
    for (std::uint16_t i = 0; i < result.faults.entries_count; i++) {
        const seld_wire_fault_entry &fault = result.faults.entries[i];
        std::printf("fault                 %s at tick %u, %u in all: %s; remedy: %s\n",
                    seld_wire_fault_name(fault.code), unsigned{fault.tick_first}, unsigned{fault.count},
                    seld_wire_fault_text(fault.code), seld_wire_fault_remedy(fault.code));
    }
    if (result.resumes > 0) {
        std::printf("device                went and came back %u times; the session went on bit for bit\n",
                    unsigned{result.resumes});
    }
    if (result.pictures > 0) {
        std::printf("led by the rig        %u shapes of the line, %u ticks with power, %u late\n",
                    unsigned{result.pictures}, unsigned{result.powered_ticks}, unsigned{result.late_ticks});
    }
    for (int line : result.given_up_lines) {
        std::printf("given up              line %d: the length was not reached within %u s\n", line,
                    unsigned{SessionPlayer::until_limit_ticks / 1000});
    }
}

void print_dose(const DoseMeter &dose)
{
    const Dose &total = dose.total();
    std::printf(
        "dose                  %.2f mGy reference air kerma, %.3f Gy cm2, %u pulses, fluoroscopy %.2f min\n",
        total.air_kerma_uGy * 1e-3, total.kap_Gy_cm2, unsigned{total.pulses}, dose.fluoro_ticks() / 60e3);
    int number = 0;
    for (const Irradiation &one : dose.irradiations()) {
        const char *kind = one.kind == RunKind::fluoro ? "fluoroscopy"
                           : one.kind == RunKind::cine ? "cine"
                                                       : "DSA";
        std::printf("  %2d %-12s %7.1f s  %4u pulses  %8.3f mGy  %8.4f Gy cm2\n", ++number, kind,
                    one.dose.beam_ticks * 1e-3, unsigned{one.dose.pulses}, one.dose.air_kerma_uGy * 1e-3,
                    one.dose.kap_Gy_cm2);
    }
}

void print_medium(const SessionContrast &contrast)
{
    const IodineBudget &budget = contrast.flow().budget();
    std::printf("contrast medium       %.1f ml, %.0f mg iodine: %.0f in the vessels, %.0f out, %.0f back "
                "through the inlet\n",
                contrast.injected_ml(), budget.injected_mg, contrast.flow().held_mg(), budget.out_mg,
                budget.reflux_mg);
}

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
    for (const Statement &statement : session.statements)
        for (const RoomCommand &command : statement.room) {
            const std::string why =
                pictures ? pictures->contrast().refusal(command) : injection_refusal(tools, command);
            if (!why.empty()) throw FileError(session.file, statement.line, 0, why);
        }
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

// The frame of a run in which the medium is best seen: the darkest.
Image darkest_frame(const StoredRun &stored)
{
    const auto sum = [](const std::vector<std::uint8_t> &grey) {
        return std::accumulate(grey.begin(), grey.end(), std::uint64_t{0});
    };
    const auto darkest = std::min_element(stored.grey.begin(), stored.grey.end(),
                                          [&](const auto &a, const auto &b) { return sum(a) < sum(b); });
    return {stored.run.size, stored.run.size, 1, *darkest};
}

// Into the report, onto the page and onto the screen.
void give_score(const std::string &path, nlohmann::ordered_json &report, const Room &room)
{
    std::vector<ScorePicture> pictures;
    for (const auto &stored : room.store().runs())
        if (stored->run.kind == RunKind::cine && !stored->grey.empty() &&
            pictures.size() < score_pictures_max) {
            char caption[64];
            std::snprintf(caption, sizeof caption, "Run %d, at %.0f s", stored->run.number,
                          stored->run.frames.front().tick * 1e-3);
            pictures.push_back({caption, darkest_frame(*stored)});
        }
    report["score"] = score_of(report);
    write_score_page(path, report, report["score"], pictures);
    if (report["score"]["percent"].is_number())
        std::printf("score                 %.0f of 100\n", report["score"]["percent"].get<double>());
    std::printf("written               %s\n", path.c_str());
}

RunResult carry_out(Device &device, const SceneFile &scene, const RunOptions &options, const Session &session,
                    Recorder *recorder, FrameSink *sink, bool is_mounted)
{
    RunSettings settings{!options.quiet && isatty(STDERR_FILENO) != 0};
    std::vector<RoomCommand> begin = options.free_run_s ? entry_commands(scene) : std::vector<RoomCommand>();
    if (is_mounted) begin.push_back(first_stent);
    settings.begin = begin;
    settings.measures_contacts = !options.score.empty();
    return options.free_run_s ? run_free_session(device, begin, *options.free_run_s, recorder, sink, settings)
                              : run_session(device, session, recorder, sink, settings);
}

void print_stents(SessionStents &stents)
{
    for (const StentResult &stent : stents.results()) {
        std::printf("stent                 %s, %s", stent.name.c_str(),
                    stent.was_taken_out ? "taken out of the patient unopened"
                                        : std::string(stent_stage_text(stent.stage)).c_str());
        if (stent.stage == StentStage::deployed)
            std::printf(": apposed %.0f %%, inside %.2f mm at least", stent.figures.apposed_share * 100.0,
                        stent.figures.diameter_min_mm);
        std::printf("\n");
    }
    for (const std::string &refusal : stents.refusals())
        std::printf("refused               %s\n", refusal.c_str());
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
        "the rig's\nown limits (seldinger rig info). Ctrl-C or the emergency stop ends it.\n");
    if (!yes && talk.ask("Type yes to power the motors:") != "yes")
        throw RigStopped("not confirmed; no motor was powered");
    return choice;
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
    const seld_wire_entry entry = is_led ? entry_with(scene, tools.size(), options.inserted_mm)
                                         : entry_of(scene, tools.size(), session.inserted_um);
    take_stents(picture_settings, options.stents, tools);
    check_loads(session, options.stents.size());
    watch_for_interrupt();
    DeviceChoice choice =
        is_led ? free_run_device(options.device, options.motors, options.yes) : parse_device(options.device);
    choice.picture_every_ticks = static_cast<std::uint16_t>(
        (1000 + picture_settings.pictures_per_second - 1) / picture_settings.pictures_per_second);
    Device device(scene, tools, entry, host_rig(), choice);

    std::unique_ptr<SessionPictures> pictures;
    picture_settings.shows_progress = !options.quiet;
    if (writes_pictures(picture_settings) || !options.score.empty())
        pictures = std::make_unique<SessionPictures>(picture_settings, tools);
    const std::unique_ptr<SessionStents> unseen =
        pictures ? nullptr : make_stents(picture_settings, tools); // drawn by nobody
    SessionStents *stents = pictures ? pictures->stents() : unseen.get();
    FrameSink *sink = pictures ? static_cast<FrameSink *>(pictures.get()) : unseen.get();
    check_injections(session, tools, pictures.get());
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
    const RunResult result =
        carry_out(device, scene, options, session, recorder.get(), sink, stents && count_loads(session) == 0);
    print_result(result, tools);
    if (pictures) print_dose(pictures->room().dose());
    if (pictures && pictures->contrast().was_used()) print_medium(pictures->contrast());
    if (stents) print_stents(*stents);
    if (!options.json.empty() || !options.score.empty()) {
        nlohmann::ordered_json report = report_of(
            result, scene.path, tools, session.file,
            {pictures ? &pictures->room() : nullptr, pictures ? &pictures->contrast() : nullptr, stents});
        if (!options.score.empty()) give_score(options.score, report, pictures->room());
        if (!options.json.empty()) write_report(options.json, report);
    }
    if (pictures) print_files(pictures->files());
    if (!result.stopped_by.empty()) {
        std::fprintf(stderr, "seldinger: %s\n", result.stopped_by.c_str());
        return 1;
    }
    if (result.was_interrupted || (pictures && pictures->was_stopped())) {
        std::fprintf(stderr, "seldinger: interrupted; what was written up to here is complete\n");
        return 1;
    }
    return 0;
}

} // namespace seld
