#include "hil_tests/soak/trial.hpp"
#include "hil_tests/soak/watch.hpp"
#include "host/base/interrupt.hpp"
#include "host/session/replay.hpp"
#include "host/session/run.hpp"
#include <algorithm>
#include <filesystem>
#include <memory>
#include <unistd.h>

namespace soak
{

namespace
{

namespace fs = std::filesystem;

constexpr crn::RoomCommand first_stent{crn::RoomAction::load_stent, {}};

// When this object is destroyed after the session has been judged, the recording file is deleted, even if an
// error ended the judgement.
struct RecordingFile {
    explicit RecordingFile(const std::string &folder)
        : path((folder.empty() ? fs::temp_directory_path() : fs::path(folder)) /
               ("soak_" + std::to_string(getpid()) + ".rec"))
    {
    }
    ~RecordingFile()
    {
        std::error_code ignored;
        fs::remove(path, ignored);
    }
    const fs::path path;
};

bool has_action(const crn::Session &script, crn::RoomAction action)
{
    for (const crn::Statement &statement : script.statements)
        for (const crn::RoomCommand &command : statement.room)
            if (command.action == action) return true;
    return false;
}

// Holds all objects that one session needs; the constructor makes them in the same way as `cournand run`.
struct Stage {
    Stage(const Catalogue &catalogue, const DrawnSession &drawn)
        : scene(catalogue.scene(drawn.scene)), script(crn::parse_session(script_of(drawn), name_of(drawn)))
    {
        for (const std::string &path : drawn.tools) tools.push_back(catalogue.tool(path).instrument);
        for (const std::string &path : drawn.stents) designs.push_back(catalogue.stent(path).design);
        crn::SceneAnatomy anatomy; // no bodies: no one is X-rayed
        anatomy.bodies.vessels = scene.vessels;
        anatomy.motion = scene.motion;
        anatomy.stations = scene.stations;
        patient = std::make_unique<crn::Patient>(anatomy, tools, crn::PatientSettings{"", designs, 1});
        entry = crn::entry_of(scene.file, tools.size(), script.inserted_um);
    }

    std::unique_ptr<crn::Device> device() const
    {
        return std::make_unique<crn::Device>(scene.file, tools, entry, crn::host_rig());
    }

    crn::RecordingHeader header(const crn::Device &device) const
    {
        crn::RecordingHeader header;
        header.core_version = device.identity().core_version;
        header.schema_hash = device.identity().schema_hash;
        header.scene_bytes = static_cast<std::uint32_t>(scene.file.bytes.size());
        header.scene_crc32 = scene.file.crc32;
        header.scene_path = scene.path;
        header.session_path = script.file;
        header.tools = tools;
        header.entry = entry;
        header.rig = device.rig();
        header.stents = designs;
        return header;
    }

    const SoakScene &scene;
    const crn::Session script;
    std::vector<crn::Instrument> tools;
    std::vector<crn::StentDesign> designs;
    std::unique_ptr<crn::Patient> patient;
    crn_wire_entry entry{};
};

// Runs the session with a recorder, and closes the recording even if an error ends the session.
Verdict run_once(Stage &stage, const TrialSettings &settings, const std::string &recording)
{
    const std::unique_ptr<crn::Device> device = stage.device();
    Watch watch(settings, stage.patient->contrast(), [&] {
        crn_wire_fault_log log{};
        device->ask([&](crn::Link &link) { log = link.read_fault_log(); });
        return log;
    });
    std::unique_ptr<crn::Recorder> recorder;
    if (settings.replays) recorder = std::make_unique<crn::Recorder>(recording, stage.header(*device));
    crn::RunSettings run_settings;
    if (stage.patient->stents() && !has_action(stage.script, crn::RoomAction::load_stent))
        run_settings.begin = {first_stent};
    Enough end;
    bool was_interrupted = false;
    try {
        const crn::RunResult result =
            crn::run_session(*device, *stage.patient, stage.script, recorder.get(), &watch, run_settings);
        was_interrupted = result.was_interrupted;
        watch.look_at_faults(device->link().tick());
        watch.balance_iodine(device->link().tick());
    } catch (const Enough &enough) {
        end = enough;
        if (end.broken.empty() && recorder) {
            const std::uint64_t hash = device->link().read_hash64().hash;
            recorder->finish(device->link().tick(), hash);
        }
    }
    Verdict verdict = watch.worst();
    verdict.hash = device->link().read_hash64().hash;
    verdict.broken = end.broken;
    verdict.text = end.text;
    verdict.tick = end.tick;
    verdict.was_interrupted = was_interrupted;
    verdict.injected_mg = stage.patient->contrast().flow().budget().injected_mg;
    return verdict;
}

// Replays the recording on a new device, which knows nothing of the recorded session.
void replay_once(const Stage &stage, const TrialSettings &settings, const std::string &path, Verdict &verdict)
{
    crn::Recording recording = crn::read_recording(path);
    if (settings.disturb) settings.disturb(recording);
    const std::unique_ptr<crn::Device> device = stage.device();
    crn::ReplaySettings replay_settings;
    replay_settings.verifies = true;
    const crn::ReplayResult replay =
        crn::replay_recording(*device, recording, nullptr, nullptr, replay_settings);
    verdict.was_interrupted = replay.was_interrupted;
    if (replay.was_interrupted) return;
    if (!replay.first_difference_tick && replay.ticks_compared == recording.ticks.size() &&
        replay.ticks_compared == verdict.ticks && replay.hash == verdict.hash)
        return;
    verdict.broken = "replay";
    verdict.tick = replay.first_difference_tick.value_or(replay.tick);
    verdict.text = replay.first_difference_tick
                       ? "replay: " + replay.difference
                       : "replay: " + std::to_string(replay.ticks_compared) + " ticks of " +
                             std::to_string(verdict.ticks) + " were compared, or the last hash differs";
}

} // namespace

Verdict run_trial(const Catalogue &catalogue, const DrawnSession &session, const TrialSettings &settings)
{
    Verdict verdict;
    try {
        Stage stage(catalogue, session);
        const RecordingFile file(settings.folder);
        verdict = run_once(stage, settings, file.path.string());
        if (settings.replays && verdict.broken.empty() && !verdict.was_interrupted)
            replay_once(stage, settings, file.path.string(), verdict);
    } catch (const std::exception &error) {
        if (crn::is_interrupted()) { // a session that Ctrl-C interrupted has no verdict
            verdict.was_interrupted = true;
            return verdict;
        }
        verdict.broken = "error";
        verdict.text = error.what();
        verdict.tick = verdict.ticks;
    }
    return verdict;
}

} // namespace soak
