#include "host/suite/session_host.hpp"
#include "host/base/interrupt.hpp"
#include "host/base/terminal.hpp"
#include "host/igtl/geometry.hpp"
#include "host/patient/balloon.hpp"
#include "host/records/identity.hpp"
#include "host/report/figures/reported_tools.hpp"
#include "host/report/session_summary.hpp"
#include "host/script/session_checks.hpp"
#include <cstdio>
#include <filesystem>

namespace crn
{
namespace
{

// "live.rec", "live.2.rec", ...
std::string numbered(const std::string &wanted, int number)
{
    if (wanted.empty() || number == 1) return wanted;
    std::filesystem::path path(wanted);
    const std::string extension = path.extension().string();
    path.replace_extension(std::to_string(number) + extension);
    return path.string();
}

// Returns the folder for the DICOM files of a session. The first session uses "runs"; a later session uses
// the first folder of "runs.2", "runs.3", ... that holds no files yet.
std::string export_folder(DicomSettings settings, int number)
{
    const std::string wanted = settings.folder;
    if (wanted.empty() || number == 1) return wanted;
    for (;; ++number) {
        settings.folder = wanted.substr(0, wanted.find_last_not_of('/') + 1) + "." + std::to_string(number);
        try {
            check_dicom_settings(settings);
            return settings.folder;
        } catch (const UsageError &) { // in use: try the next
        }
    }
}

} // namespace

// Publishes the tips and the live monitor of a session by OpenIGTLink.
class WindowFeed
{
  public:
    WindowFeed(IgtlServer &server, const PictureThread &pictures) : feed_(server), pictures_(pictures) {}
    void look(const SessionFrame &frame, const Patient &patient)
    {
        const std::shared_ptr<const MonitorPicture> live = pictures_.live();
        if (!live || live->grey.empty() || live->number == number_)
            return feed_.send(frame, patient, nullptr);
        number_ = live->number;
        IgtlPicture picture = picture_place(live->status.picture_carm, live->size);
        picture.grey = {live, &live->grey};
        feed_.send(frame, patient, &picture);
    }
    void end() { feed_.end(); }

  private:
    IgtlFeed feed_;
    const PictureThread &pictures_;
    std::uint64_t number_ = 0;
};

SessionHost::SessionHost(WindowOptions options, GlOpener window_context)
    : options_(std::move(options)), window_context_(std::move(window_context)),
      scene_(read_scene(options_.scene)),
      table_(read_tools(options_.instrument, options_.tools, CRN_WIRE_TABLE_MAX)),
      line_(line_or_table(line_numbers(options_.line, options_.instrument, options_.tools), table_.size())),
      entry_(entry_with(scene_, line_.size(), options_.inserted_mm))
{
    choice_ = options_.free_run ? free_run_device(options_.device, options_.motors, options_.yes)
                                : parse_device(options_.device);
}

void SessionHost::begin(int number)
{
    PictureSettings pictures = options_.pictures;
    pictures.window_context = window_context_;
    number_ = number;
    ++begun_;
    pictures.line = line_;
    take_stents(pictures, options_.stents, table_);
    std::vector<RoomCommand> commands = entry_commands(scene_);
    for (const RoomCommand &limit : complication_commands(options_.complications)) commands.push_back(limit);
    // In a case the trainee orders the stent to be loaded, as the expert does, because a balloon without a
    // stent may be needed first.
    const bool has_balloon = balloon_tool(crn::tools_on(table_, line_)).has_value();
    if (!pictures.stents.empty() && !options_.lesson && has_balloon) commands.push_back(first_stent);
    if (options_.lesson)
        for (const Statement &statement : options_.lesson->start.room)
            commands.insert(commands.end(), statement.room.begin(), statement.room.end());
    pictures.dicom.folder = export_folder(pictures.dicom, number_);
    recording_ = numbered(options_.record, begun_);
    // The stored files and the tests must contain the picture of every X-ray pulse.
    const bool is_counted = options_.frames > 0;
    const bool keeps_all = is_counted || !pictures.dicom.folder.empty();
    auto session = std::make_unique<LiveSession>(scene_, table_, entry_, recording_, pictures, commands,
                                                 choice_, keeps_all);
    goals_.reset();
    feed_.reset();
    if (options_.lesson) goals_ = std::make_shared<LiveGoals>(options_.lesson, *session);
    if (options_.watched) feed_ = std::make_shared<WindowFeed>(*options_.watched, session->pictures());
    session->observe([goals = goals_, feed = feed_](const SessionFrame &frame, Patient &patient) {
        if (goals) goals->look(frame);
        if (feed) feed->look(frame, patient);
    });
    started_at_ = utc_now();
    physics_ = std::make_unique<PhysicsThread>(std::move(session),
                                               is_counted ? PhysicsPace::counted : PhysicsPace::real_time);
    is_fault_told_ = false;
}

const std::vector<Instrument> &SessionHost::tools_on(const LineNumbers &line)
{
    if (shown_tools_.empty() || line != shown_line_) {
        shown_tools_ = crn::tools_on(table_, line);
        shown_line_ = line;
    }
    return shown_tools_;
}

void SessionHost::tell_fault()
{
    const std::shared_ptr<const SuiteState> state = physics_->state();
    if (is_fault_told_ || state->fault.empty()) return;
    is_fault_told_ = true;
    if (state->has_left_range) return; // end() tells it with its place
    say(stderr, "cournand: the session ended by a fault: %s\n", state->fault.c_str());
}

void SessionHost::assess(const std::string &trainee)
{
    if (recording_.empty()) return;
    debrief_.task = std::make_unique<BackgroundTask<ScoredSession>>(
        [lesson = options_.lesson, recording = recording_, bodies = options_.pictures.bodies_path, trainee,
         began = started_at_](TaskProgress &progress) {
            ScoreRequest request{recording, "", bodies, {}, lesson.get(), {}};
            request.goes_on = [&](double share) { return progress.tell("", share); };
            ScoredSession scored{score_recording(request), {}};
            if (lesson && !scored.score.was_stopped)
                scored.stored = store_session({lesson.get(), trainee, began, recording}, scored.score);
            return scored;
        });
}

int SessionHost::end()
{
    const std::unique_ptr<PhysicsThread> physics = std::move(physics_);
    const std::unique_ptr<LiveSession> session = physics->stop();
    session->finish();
    if (feed_) feed_->end();
    const SceneAnatomy &anatomy = session->anatomy();
    RunResult result = session->result(TipPlaces(anatomy.bodies.vessels, anatomy.motion));
    name_range_branch(result.figures.range, options_.pictures.bodies_path);
    const std::vector<Instrument> tools = reported_tools(session->patient());
    print_session(result, tools, session->patient());
    write_session_files({numbered(options_.json, number_), numbered(options_.score, number_), ""}, result,
                        options_.scene, tools, "live", session->patient(),
                        &session->pictures().pictures().screen());
    print_files(session->files());
    if (!recording_.empty()) print_files({recording_});
    debrief_ = {};
    debrief_.report = report_of(result, options_.scene, tools, "live", session->patient());
    debrief_.recording = recording_;
    debrief_.fault = session->fault();
    debrief_.files = session->files();
    debrief_.lesson = options_.lesson;
    if (options_.lesson) debrief_.title = options_.lesson->title;
    if (!recording_.empty()) debrief_.files.push_back(recording_);
    was_interrupted_ = is_interrupted() || session->was_stopped();
    if (session->range().is_left()) return exit_of_range(session->range());
    if (!is_fault_told_ && !session->fault().empty())
        say(stderr, "cournand: the session ended by a fault: %s\n", session->fault().c_str());
    return session->fault().empty() ? 0 : 1;
}

} // namespace crn
