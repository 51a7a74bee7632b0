// cournand replay
#include "host/base/format.hpp"
#include "host/base/interrupt.hpp"
#include "host/base/terminal.hpp"
#include "host/base/text.hpp"
#include "host/command/cli.hpp"
#include "host/igtl/feed.hpp"
#include "host/patient/patient.hpp"
#include "host/picture/session_pictures.hpp"
#include "host/report/figures/reported_tools.hpp"
#include "host/report/session_summary.hpp"
#include "host/session/recording_upgrade.hpp"
#include "host/session/replay.hpp"
#include <algorithm>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <unistd.h>

namespace crn
{

SceneFile recorded_scene(const RecordingHeader &header, const std::string &given_path)
{
    if (header.scene_bytes == 0) return read_scene("");
    const std::string path = given_path.empty() ? header.scene_path : given_path;
    SceneFile scene;
    try {
        scene = read_scene(path);
    } catch (const FileError &error) {
        throw std::runtime_error(std::string(error.what()) +
                                 "; name the scene of this recording with --scene");
    }
    if (scene.bytes.size() == header.scene_bytes && scene.crc32 == header.scene_crc32) return scene;
    const std::string text =
        formatted(" is not the scene of this recording: it has %zu bytes, CRC-32 %08x; recorded was one of "
                  "%u bytes, CRC-32 %08x; name that one with --scene",
                  scene.bytes.size(), unsigned{scene.crc32}, unsigned{header.scene_bytes},
                  unsigned{header.scene_crc32});
    throw std::runtime_error(path + text);
}

void check_core(const RecordingHeader &header, const crn_wire_hello_reply &identity)
{
    if (header.core_version == identity.core_version) return;
    throw std::runtime_error("the recording was made by core version " + std::to_string(header.core_version) +
                             ", this device has version " + std::to_string(identity.core_version) +
                             ": it cannot be replayed bit for bit; use the release that recorded it");
}

RunResult run_result(const ReplayResult &replayed)
{
    RunResult result;
    result.figures = replayed.figures;
    result.contacts = replayed.contacts;
    result.hash = replayed.hash;
    result.seconds = replayed.seconds;
    result.was_interrupted = replayed.was_interrupted;
    result.tips = replayed.tips;
    result.faults = replayed.faults;
    return result;
}

namespace
{

// Returns the tools that are in the vessels at the end of the replay, as `run` reports them.
std::vector<Instrument> named_tools(const RecordingHeader &header, const LineNumbers &line)
{
    const LineNumbers &at_end = line.empty() ? header.line : line;
    return with_free_positions(tools_on(header.tools, line_or_table(at_end, header.tools.size())));
}

int print_result(const Recording &recording, const ReplayOptions &options, const ReplayResult &result)
{
    std::printf("final hash %016llx at tick %u\n", static_cast<unsigned long long>(result.hash),
                unsigned{result.tick});
    print_tools(named_tools(recording.header, result.line), result.figures);
    if (!recording.is_complete && !options.verify)
        std::printf("the recording was cut off; it is whole up to tick %zu\n", recording.ticks.size());
    if (result.first_difference_tick) {
        say(stderr, "cournand: %s: first difference at tick %u: %s\n", options.recording.c_str(),
            unsigned{*result.first_difference_tick}, result.difference.c_str());
        return 1;
    }
    if (result.was_interrupted) {
        std::fprintf(stderr, "cournand: interrupted\n");
        return 1;
    }
    if (options.verify && result.ticks_compared == 0) {
        say(stderr, "cournand: %s: nothing to verify: no tick of it is whole\n", options.recording.c_str());
        return 1;
    }
    if (options.verify) {
        std::printf("verified: %u ticks and %u full hashes agree\n", unsigned{result.ticks_compared},
                    unsigned{result.hashes_compared});
    }
    // If the end of the recording is missing, the missing part cannot be verified. If a part of the recording
    // was not verified, the exit code must not indicate success.
    if (options.verify && !recording.is_complete) {
        say(stderr,
            "cournand: %s: verified up to tick %zu, but the recording was cut off there: how the session "
            "ended is "
            "not known\n",
            options.recording.c_str(), recording.ticks.size());
        return 1;
    }
    return exit_of_range(result.figures.range);
}

int upgrade(const ReplayOptions &options)
{
    check_outputs({{"the recording", options.recording}}, {{"--output", options.upgraded}});
    const Recording recording = upgrade_recording(options.recording, options.upgraded);
    say(stdout, "Written: %s, %zu ticks; cournand replay %s --verify shows that it ends with the same hash\n",
        options.upgraded.c_str(), recording.ticks.size(), options.upgraded.c_str());
    if (!recording.is_complete)
        std::printf("the recording was cut off; it is whole up to tick %zu\n", recording.ticks.size());
    return 0;
}

ReplaySettings replay_settings(const ReplayOptions &options, bool is_reported)
{
    ReplaySettings settings;
    settings.speed = *replay_speed(options.speed);
    settings.verifies = options.verify;
    settings.from_s = options.from_s;
    settings.waits_for_enter = isatty(STDIN_FILENO) != 0;
    settings.measures_contacts = is_reported;
    return settings;
}

} // namespace

int command_replay(const ReplayOptions &options)
{
    if (options.upgrades) return upgrade(options);
    check_outputs({{"the recording", options.recording},
                   {"--scene", options.scene},
                   {"--bodies", options.pictures.bodies_path}},
                  {{"--png", options.pictures.png_path},
                   {"--png16", options.pictures.png16_path},
                   {"--mp4", options.pictures.mp4_path},
                   {"--json", options.json},
                   {"--score", options.score}});
    check_dicom_settings(options.pictures.dicom);
    const bool is_reported = !options.json.empty() || !options.score.empty() || options.lesson;
    if (is_reported && options.from_s > 0.0)
        throw UsageError("--json and --score describe the whole session: leave out --from");
    const Recording recording = read_recording(options.recording);
    const RecordingHeader &header = recording.header;
    const double length_s = recording.ticks.size() * 1e-3;
    if (!(options.from_s <= length_s)) { // rejects NaN too
        throw std::runtime_error(options.recording + ": --from " + std::to_string(options.from_s) +
                                 " is beyond its end at " + std::to_string(length_s) + " s");
    }
    const SceneFile scene = recorded_scene(header, options.scene);
    IgtlOutput watched(options.igtl);
    Device device(scene, header.tools, header.entry, header.rig, {}, header.line);
    check_core(header, device.identity());

    PictureSettings picture_settings = options.pictures;
    if (picture_settings.bodies_path.empty()) picture_settings.bodies_path = bodies_beside(scene.path);
    picture_settings.scene_path = scene.path;
    picture_settings.stents = header.stents;
    picture_settings.line = header.line;
    const bool has_pictures = writes_pictures(picture_settings) || !options.score.empty() || watched.server();
    SceneAnatomy anatomy;
    std::unique_ptr<Patient> patient;
    std::unique_ptr<SessionPictures> pictures;
    if (has_pictures || is_reported) {
        anatomy = read_anatomy(picture_settings);
        patient = make_patient(picture_settings, anatomy, header.tools);
        if (has_pictures)
            pictures = std::make_unique<SessionPictures>(picture_settings, header.tools, *patient, anatomy);
    }
    watch_for_interrupt();
    const ReplaySettings settings = replay_settings(options, is_reported);
    const TipPlaces tips(anatomy.bodies.vessels, anatomy.motion);
    std::optional<EffectsWitness> witness;
    if (patient) witness.emplace(tips.map(), *patient);
    CasePlay play(options.lesson, tips, witness ? &*witness : nullptr,
                  watched.with(pictures.get(), patient.get()));
    ReplayResult result = replay_recording(device, recording, patient.get(), play.sink(), settings);
    name_range_branch(result.figures.range, picture_settings.bodies_path);
    if (is_reported) {
        device.link().read_nodes();
        result.tips = tips.at(session_frame(device, {}, {}).wire);
        const std::vector<Instrument> reported = reported_tools(*patient);
        SessionFiles files{options.json, options.score, "", nullptr};
        if (options.lesson)
            files.case_entry =
                play.end(run_result(result),
                         report_of(run_result(result), scene.path, reported, header.session_path, *patient));
        write_session_files(files, run_result(result), scene.path, reported, header.session_path, *patient,
                            pictures ? &pictures->screen() : nullptr);
    }
    if (pictures) print_files(pictures->files());
    const int code = print_result(recording, options, result);
    return pictures && pictures->was_stopped() ? 1 : code;
}

} // namespace crn
