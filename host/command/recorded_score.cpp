#include "host/command/recorded_score.hpp"
#include "host/base/format.hpp"
#include "host/base/number_text.hpp"
#include "host/cases/goals.hpp"
#include "host/command/cli.hpp"
#include "host/report/figures/reported_tools.hpp"
#include "host/report/session_summary.hpp"
#include "host/session/replay.hpp"

namespace crn
{
namespace
{

struct ScoreStopped {
};

// Reports how far a replay has advanced, and ends the replay by an exception if the caller's function returns
// false.
class ReplayWatch final : public FrameSink
{
  public:
    static constexpr std::uint32_t every_ticks = 128;

    ReplayWatch(const std::function<bool(double)> &goes_on, std::size_t ticks)
        : goes_on_(goes_on), ticks_(ticks)
    {
    }
    void tick(const crn_wire_tick_input &, const crn_wire_tick_state &state) override
    {
        if (!goes_on_ || state.tick % every_ticks != 0) return;
        if (!goes_on_(static_cast<double>(state.tick) / static_cast<double>(ticks_))) throw ScoreStopped();
    }
    std::uint32_t next_tick() const override { return UINT32_MAX; }
    void frame(const SessionFrame &) override {}

  private:
    const std::function<bool(double)> &goes_on_;
    std::size_t ticks_;
};

} // namespace

RecordedScore score_recording(const ScoreRequest &request)
{
    const Recording recording = read_recording(request.recording);
    const RecordingHeader &header = recording.header;
    const SceneFile scene = recorded_scene(header, request.scene);
    Device device(scene, header.tools, header.entry, header.rig, {}, header.line);
    check_core(header, device.identity());
    PictureSettings settings;
    settings.bodies_path = request.bodies_path.empty() ? bodies_beside(scene.path) : request.bodies_path;
    settings.scene_path = scene.path;
    settings.stents = header.stents;
    settings.line = header.line;
    const SceneAnatomy anatomy = read_anatomy(settings);
    const std::unique_ptr<Patient> patient = make_patient(settings, anatomy, header.tools);
    const TipPlaces tips(anatomy.bodies.vessels, anatomy.motion);
    const EffectsWitness witness(tips.map(), *patient);
    SessionAssessor assessor(request.plan, *patient, header.tools, tips, nullptr, request.lesson);
    CasePlay play(request.lesson, tips, &witness, nullptr);
    ReplayWatch watch(request.goes_on, recording.ticks.size());
    FrameSinks sinks;
    sinks.add(&watch);
    sinks.add(play.sink());
    sinks.add(assessor.sink());
    ReplaySettings replay;
    replay.verifies = true; // a score of another course than the recorded one would be wrong
    replay.measures_contacts = true;
    RecordedScore score;
    score.is_complete = recording.is_complete;
    score.ticks = static_cast<std::uint32_t>(recording.ticks.size());
    score.core_version = std::to_string(header.core_version);
    ReplayResult replayed;
    try {
        replayed = replay_recording(device, recording, patient.get(), &sinks, replay);
    } catch (const ScoreStopped &) {
        replayed.was_interrupted = true;
    }
    if (replayed.first_difference_tick)
        throw std::runtime_error(request.recording + ": cannot be scored: at tick " +
                                 std::to_string(*replayed.first_difference_tick) +
                                 " the replay differs from the recording: " + replayed.difference);
    score.was_stopped = replayed.was_interrupted;
    if (score.was_stopped) return score;
    device.link().read_nodes();
    replayed.tips = tips.at(session_frame(device, {}, {}).wire);
    const RunResult result = run_result(replayed);
    score.report = report_of(result, scene.path, reported_tools(*patient), header.session_path, *patient);
    assessor.assess(score.report);
    if (request.lesson) score.report["case"] = play.judge_end(result, score.report);
    score.state_hash = hex_text(replayed.hash);
    return score;
}

} // namespace crn
