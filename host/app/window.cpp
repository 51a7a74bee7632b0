// In its loop, the window turns keys into motion of the hand and the C-arm, advances the session by the ticks
// that are due, and draws the picture on the screen.
#include "host/app/window.hpp"
#include "host/app/window_keys.hpp"
#include "host/app/window_live.hpp"
#include "host/base/interrupt.hpp"
#include "host/base/terminal.hpp"
#include "host/command/cli.hpp"
#include "host/command/names.hpp"
#include "host/report/session_summary.hpp"
#include "host/screen/screen.hpp"
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <stdexcept>
#include <string>
#include <thread>

namespace crn
{
namespace
{

using Clock = std::chrono::steady_clock;
constexpr double screens_per_s = 60.0;
constexpr std::uint32_t ticks_behind_max = 100; // farther behind real time than this, the session slows down
constexpr int window_edge = 768;

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

// Counts the ticks (milliseconds) by which the session must advance, according to the wall clock or, in
// tests, to the number of screens shown.
class Pace
{
  public:
    explicit Pace(bool is_counted) : is_counted_(is_counted) {}

    std::uint32_t ticks_due()
    {
        ++screens_;
        const double time_s = is_counted_
                                  ? static_cast<double>(screens_) / screens_per_s
                                  : std::chrono::duration<double>(Clock::now() - begin_).count() - lost_s_;
        const auto due = static_cast<std::int64_t>(time_s * 1e3) - ticks_;
        const std::int64_t given = std::clamp<std::int64_t>(due, 0, ticks_behind_max);
        lost_s_ += static_cast<double>(std::max<std::int64_t>(due - given, 0)) * 1e-3;
        ticks_ += given;
        return static_cast<std::uint32_t>(given);
    }
    // Waits 2 ms per screen. Some displays do not make the program wait for their refresh, and without this
    // pause the loop would then occupy a whole processor.
    void wait() const
    {
        if (is_counted_) return;
        const double next_s = std::chrono::duration<double>(Clock::now() - begin_).count() + 2e-3;
        std::this_thread::sleep_until(
            begin_ + std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(next_s)));
    }

  private:
    bool is_counted_;
    Clock::time_point begin_ = Clock::now();
    std::int64_t screens_ = 0, ticks_ = 0;
    double lost_s_ = 0.0;
};

class Window
{
  public:
    explicit Window(const WindowOptions &options)
        : options_(options), scene_(read_scene(options.scene)),
          tools_(read_tools(options.instrument, options.tools)),
          entry_(entry_with(scene_, tools_.size(), options.inserted_mm)),
          keys_(tools_.size(), options.shows_help), screen_("Cournand", window_edge)
    {
        choice_ = options.free_run ? free_run_device(options.device, options.motors, options.yes)
                                   : parse_device(options.device);
        if (options.starts_with_fluoro) keys_.latch_pedal();
        screen_.on_key([this](const Screen::KeyEvent &event) {
            if (session_) keys_.take(event, session_->pictures().screen());
        });
        start();
    }

    // Returns the program's exit code, which is not 0 when a signal ended the window or the session has
    // stopped with a fault. In every case, all files that the program wrote are complete.
    int run()
    {
        Pace pace(options_.frames > 0);
        for (int frame = 0; options_.frames == 0 || frame < options_.frames; ++frame) {
            screen_.poll();
            if (screen_.wants_close() || keys_.wants_end() || is_interrupted()) break;
            if (keys_.take_reset()) restart();
            keys_.hold(screen_);
            keys_.lead(session_->hands());
            session_->inflate(keys_.inflation_kPa_per_s());
            for (const RoomCommand &command : keys_.take_commands()) session_->command(command);
            for (const crn_wire_order &order : keys_.take_orders()) session_->order(order);
            session_->advance(pace.ticks_due());
            tell_fault();
            annotate();
            screen_.show(session_->image());
            pace.wait();
        }
        std::string error;
        if (!options_.screenshot.empty() && !write_png(options_.screenshot, screen_.read_back(), error))
            throw std::runtime_error(error);
        end_session();
        if (is_interrupted() || session_->was_stopped())
            std::fprintf(stderr, "cournand: interrupted; what was written up to here is complete\n");
        else
            return !tell_fault() ? 0 : session_->range().is_left() ? exit_out_of_range : 1;
        return 1;
    }

  private:
    // Returns true when the session has stopped with a fault, and prints the fault once, when it occurs.
    bool tell_fault()
    {
        if (session_->fault().empty()) return false;
        const auto &left = session_->range().left();
        if (!is_fault_told_ && left)
            say(stderr, "cournand: %s\n", range_text(*left).c_str());
        else if (!is_fault_told_)
            say(stderr, "cournand: the session ended by a fault: %s\n", session_->fault().c_str());
        return is_fault_told_ = true;
    }

    void start()
    {
        PictureSettings pictures = options_.pictures;
        pictures.window_context = [this] { return screen_.context(); };
        ++session_number_;
        take_stents(pictures, options_.stents, tools_);
        std::vector<RoomCommand> begin = entry_commands(scene_);
        if (!pictures.stents.empty()) begin.push_back(first_stent);
        pictures.dicom.folder = export_folder(pictures.dicom, session_number_);
        session_.reset(); // a rig has one host at a time
        recording_ = numbered(options_.record, session_number_);
        session_ =
            std::make_unique<LiveSession>(scene_, tools_, entry_, recording_, pictures, begin, choice_);
        is_annotated_ = is_fault_told_ = false;
    }

    void end_session()
    {
        session_->finish();
        const SceneAnatomy &anatomy = session_->anatomy();
        RunResult result = session_->result(TipPlaces(anatomy.bodies.vessels, anatomy.motion));
        name_range_branch(result.figures.range, options_.pictures.bodies_path);
        print_session(result, tools_, session_->patient());
        write_session_files(
            {numbered(options_.json, session_number_), numbered(options_.score, session_number_), ""}, result,
            options_.scene, tools_, "live", session_->patient(), &session_->pictures().screen());
        print_files(session_->files());
        if (!recording_.empty()) print_files({recording_});
    }

    void restart()
    {
        end_session();
        start();
    }

    void annotate()
    {
        const std::string notice = session_->fault().empty() ? "" : session_->fault() + " - R starts again";
        if (is_annotated_ && notice == notice_ && keys_.shows_help() == shows_help_ &&
            keys_.chosen_tool() == chosen_tool_ && keys_.moves_all() == moves_all_)
            return;
        notice_ = notice;
        chosen_tool_ = keys_.chosen_tool();
        moves_all_ = keys_.moves_all();
        session_->choose_tool(chosen_tool_, moves_all_);
        shows_help_ = keys_.shows_help();
        is_annotated_ = true;
        session_->annotate(notice_, shows_help_ ? help_panel(tools_.size()) : std::vector<std::string>{});
    }

    const WindowOptions &options_;
    SceneFile scene_;
    std::vector<Instrument> tools_;
    crn_wire_entry entry_;
    DeviceChoice choice_;
    WindowKeys keys_;
    Screen screen_;
    std::unique_ptr<LiveSession> session_;
    int session_number_ = 0;
    bool is_annotated_ = false, is_fault_told_ = false, shows_help_ = false, moves_all_ = false;
    std::size_t chosen_tool_ = 0;
    std::string notice_, recording_;
};

} // namespace

int run_window(WindowOptions options)
{
    if (options.pictures.bodies_path.empty()) options.pictures.bodies_path = bodies_beside(options.scene);
    options.pictures.scene_path = options.scene;
    std::vector<NamedPath> inputs = tool_inputs(options.instrument, options.tools);
    for (const std::string &stent : options.stents) inputs.push_back({"--stent", stent});
    inputs.insert(inputs.end(), {{"--scene", options.scene}, {"--bodies", options.pictures.bodies_path}});
    if (options.record.empty() && options.keeps_recording) options.record = kept_recording();
    check_outputs(inputs, {{"--record", options.record},
                           {"--screenshot", options.screenshot},
                           {"--json", options.json},
                           {"--score", options.score}});
    check_dicom_settings(options.pictures.dicom);
    watch_for_interrupt();
    return Window(options).run();
}

} // namespace crn
