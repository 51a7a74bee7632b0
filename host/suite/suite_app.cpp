#include "host/suite/suite_app.hpp"
#include "host/base/format.hpp"
#include "host/base/interrupt.hpp"
#include "host/base/pending_file.hpp"
#include "host/command/names.hpp"
#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <stdexcept>
#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>

namespace crn
{
namespace
{

constexpr double screens_per_s = 60.0;
// The window is drawn at most 60 times a second, and leaves processor time to physics and X-ray: after a
// drawing that takes the time d, the window pauses for at least 1.5 d.
constexpr double pause_share = 1.5, pause_max_s = 0.12;
constexpr double look_s = 2e-3; // between looks for a new picture during that pause
constexpr auto step_memory = std::chrono::milliseconds(400);
constexpr auto layout_pause = std::chrono::milliseconds(40); // a file reaches the disk each time

std::string title_of(const WindowOptions &options)
{
    if (options.lesson) return options.lesson->title;
    if (options.scene.empty()) return "free space, no patient";
    return std::filesystem::path(options.scene).stem().string() + ", an invented patient";
}

} // namespace

SuiteApp::SuiteApp(const WindowOptions &options)
    : options_(options), window_("Cournand", {options.window_width, options.window_height}, options.font),
      ui_(window_), begins_at_start_(options.opens_start || options.lesson), trainee_(remembered_trainee()),
      shows_help_(options.shows_help)
{
    window_.on_key([this](int key, int action, int modifiers) {
        last_input_ = SuiteClock::now();
        if (is_in_session() || page_ == Page::replay) input_->key(key, action, modifiers);
        // A key that is held down must not lead through several screens.
        if (!is_in_session() && action == GLFW_PRESS) take_page_key(key);
    });
    window_.on_focus_lost([this] {
        if (input_) input_->release_all();
    });
    // The OpenGL context for the X-ray is made here, because only this thread may make windows.
    if (options.pictures.xray == "opengl") window_.context();
    if (!options.replays.empty())
        open_replay(options.replays);
    else if (options.lesson)
        open_prep(case_card(options_, *options_.lesson));
    else if (options.opens_start)
        go_on(Page::start);
    else
        open_session(options_);
}

// A session that begins from a screen of the window has a recording of its own; only the first session uses
// the file that the command line named.
WindowOptions SuiteApp::session_options(const WindowOptions &options) const
{
    WindowOptions chosen = options;
    chosen.pictures.scene_path = chosen.scene;
    if (chosen.pictures.bodies_path.empty()) chosen.pictures.bodies_path = bodies_beside(chosen.scene);
    const bool is_named = !host_ && !chosen.record.empty();
    if (begins_at_start_ && chosen.keeps_recording && !is_named) chosen.record = kept_recording();
    return chosen;
}

void SuiteApp::open_session(const WindowOptions &options)
{
    host_ = std::make_unique<SessionHost>(session_options(options), [this] { return window_.context(); });
    host_->begin(++sessions_);
    enter_session();
}

// Shows the session that the member host_ has begun.
void SuiteApp::enter_session()
{
    input_.emplace(host_->line().size());
    if (host_->options().starts_with_fluoro) input_->latch_pedal();
    ui_.serve(*input_);
    screen_.emplace(ui_);
    begin_session();
    prep_.reset();
    page_ = Page::suite;
}

void SuiteApp::begin_session()
{
    input_->begin_session();
    screen_->forget_toasts();
    reference_run_ = 0;
    hints_shown_ = 0;
    wants_end_ = wants_restart_ = false;
    host_->physics().on_picture([] { glfwPostEmptyEvent(); }); // ends the wait in keep_rate() at once
}

void SuiteApp::end_session()
{
    code_ = std::max(code_, host_->end());
}

int SuiteApp::run()
{
    for (int frame = 0; options_.frames == 0 || frame < options_.frames; ++frame) {
        const auto begin = SuiteClock::now();
        window_.poll(0.0);
        GamepadState pad;
        if (is_in_session()) gamepad_.take(read_gamepad(pad) ? &pad : nullptr, *input_);
        pass_input();
        if (!show_screen(frame)) break;
        if (options_.frames == 0) keep_rate(begin);
    }
    return finish();
}

// Shows one screen. The function returns false if the program must end.
bool SuiteApp::show_screen(int frame)
{
    if (window_.wants_close() || is_interrupted() || wants_quit_) return false;
    if (is_in_session() && wants_end_) {
        if (!begins_at_start_) return false;
        end_session();
        window_.poll(0.0); // what was pressed meanwhile was meant for the session
        host_->assess(trainee_);
        go_on(Page::debrief);
    }
    if (is_in_session() && wants_restart_) {
        end_session();
        host_->begin(++sessions_);
        begin_session();
    }
    if (!is_in_session()) {
        show_page();
        return true;
    }
    if (options_.frames > 0) {
        const auto due = static_cast<std::uint32_t>((frame + 1) / screens_per_s * 1e3);
        host_->physics().run_ticks(due - counted_ticks_);
        counted_ticks_ = due;
    }
    host_->physics().check();
    host_->tell_fault();
    show_suite();
    return true;
}

int SuiteApp::finish()
{
    std::string error;
    if (!options_.screenshot.empty() && !write_png(options_.screenshot, window_.read_back(), error))
        throw std::runtime_error(error);
    if (!options_.timing.empty()) timing_.write(options_.timing);
    if (host_ && host_->is_running()) end_session();
    if (!is_interrupted() && !(host_ && host_->was_interrupted())) return code_;
    std::fprintf(stderr, "cournand: interrupted; what was written up to here is complete\n");
    return std::max(code_, 1);
}

void SuiteApp::show_suite()
{
    PhysicsThread &physics = host_->physics();
    SuiteView view;
    view.state = physics.state();
    view.live = physics.live();
    view.reference = physics.reference();
    view.tools = &host_->tools_on(view.state->line);
    view.table = &host_->table();
    input_->see_line(view.state->line, host_->table().size());
    view.title = title_of(host_->options());
    view.lesson = host_->options().lesson.get();
    view.has_patient = !host_->options().scene.empty();
    view.goals = host_->goals();
    view.tips = host_->tips();
    view.hints_shown = hints_shown_;
    view.shows_help = shows_help_;
    view.is_pixel_by_pixel = is_pixel_by_pixel_;
    view.is_measured = options_.frames == 0;
    if (view.live && view.live->number != shown_number_) rhythm_.picture_came(SuiteClock::now());
    window_.begin_frame();
    ui_.begin_screen();
    const SuiteActions actions = screen_->draw(view);
    window_.end_frame();
    shown_number_ = view.live ? view.live->number : 0;
    drawn_ = {view.state, view.live};
    for (const DeviceDrag &drag : actions.drags)
        physics.ask([drag, when = SuiteClock::now()](LiveSession &live) {
            live.drag(drag.tool, drag.push_um, drag.turn_counts);
            live.note_input(when);
        });
    for (const RoomCommand &command : actions.commands)
        physics.ask([command](LiveSession &live) { live.command(command); });
    write_layout();
}

// Returns true if the live monitor has a picture that the window has not shown yet.
bool SuiteApp::is_picture_new() const
{
    if (!is_in_session()) return false;
    const std::shared_ptr<const MonitorPicture> live = host_->physics().live();
    return live && live->number != shown_number_;
}

// Waits until the window is drawn, and passes on input meanwhile.
void SuiteApp::finish_screen()
{
    while (window_.is_drawing()) {
        window_.poll(look_s);
        pass_input();
    }
    if (drawn_) timing_.take(*drawn_->state, drawn_->live.get(), window_.shown_at());
    drawn_.reset();
}

// Waits until the window must be drawn again: a new picture is shown at once, and a drawing shortly before a
// picture is left out. Input is passed on at once, so its delay does not depend on how often the window is
// drawn.
void SuiteApp::keep_rate(SuiteClock::time_point begin)
{
    using Seconds = std::chrono::duration<double>;
    finish_screen();
    const auto drawn = SuiteClock::now() - begin;
    const double drawn_s = Seconds(drawn).count();
    const double pause_s =
        std::min(std::max(1.0 / screens_per_s - drawn_s, pause_share * drawn_s), pause_max_s);
    const auto due = SuiteClock::now() + std::chrono::duration_cast<SuiteClock::duration>(Seconds(pause_s));
    for (;;) {
        const auto now = SuiteClock::now();
        const double left_s = Seconds(due - now).count();
        if (is_picture_new() || (left_s <= 0.0 && !waits_for_picture(now, drawn))) return;
        window_.poll(std::clamp(left_s, 1e-3, look_s));
        pass_input();
    }
}

bool SuiteApp::waits_for_picture(SuiteClock::time_point now, SuiteClock::duration screen) const
{
    return is_in_session() && rhythm_.is_picture_near(now, screen);
}

void SuiteApp::pass_input()
{
    if (!input_) return;
    const UserWishes wishes = input_->take();
    if (page_ == Page::replay)
        for (ControlId id : wishes.actions) replay_->act(id);
    else if (is_in_session() && wishes.is_any())
        pass(wishes);
    act_own();
}

void SuiteApp::pass(const UserWishes &wishes)
{
    PhysicsThread &physics = host_->physics();
    for (ControlId id : wishes.actions) act(id);
    physics.ask([wishes, when = last_input_](LiveSession &live) {
        for (const RoomCommand &command : wishes.commands) live.command(command);
        for (const crn_wire_order &order : wishes.orders) live.order(order);
        if (wishes.inflation_kPa_per_s) live.inflate(*wishes.inflation_kPa_per_s);
        if (wishes.hands.empty()) return;
        live.lead(wishes.hands);
        live.note_input(when);
    });
}

// A step to another frame, or a shift of the mask, starts from the state that the screen shows. The screen
// may not yet show the previous step, so the steps of the last 400 ms are remembered here.
RoomStatus SuiteApp::predicted(ControlId id)
{
    const std::shared_ptr<const MonitorPicture> live = host_->physics().live();
    RoomStatus status = live ? live->status : RoomStatus{};
    const bool is_frame = id == ControlId::frame_back || id == ControlId::frame_on;
    const bool is_shift = id >= ControlId::mask_right && id <= ControlId::mask_down;
    if (!is_frame && !is_shift) return status;
    if (SuiteClock::now() - stepped_at_ < step_memory && stepped_.run == status.run) {
        status.frame = stepped_.frame;
        status.shift_right_px = stepped_.shift_right_px;
        status.shift_up_px = stepped_.shift_up_px;
    }
    stepped_ = status;
    stepped_at_ = SuiteClock::now();
    for (const RoomCommand &command : commands_of(id, host_->physics().state()->room, status)) {
        if (command.action == RoomAction::review) stepped_.frame = command.values[2];
        if (command.action != RoomAction::shift) continue;
        stepped_.shift_right_px = command.values[0] * 0.01;
        stepped_.shift_up_px = command.values[1] * 0.01;
    }
    return status;
}

void SuiteApp::act(ControlId id)
{
    host_->physics().ask([id, status = predicted(id)](LiveSession &live) {
        for (const RoomCommand &command : commands_of(id, live.patient().room(), status))
            live.command(command);
    });
}

void SuiteApp::act_own()
{
    for (ControlId id : input_->take_own()) {
        if (page_ == Page::replay && id == ControlId::end) {
            if (!options_.replays.empty())
                wants_quit_ = true;
            else
                go_on(before_replay_);
            return;
        }
        if (!is_in_session()) continue;
        switch (id) {
        case ControlId::help:
            shows_help_ = !shows_help_;
            break;
        case ControlId::pixels:
            is_pixel_by_pixel_ = !is_pixel_by_pixel_;
            break;
        case ControlId::to_reference:
            host_->physics().show_reference({ReferenceChoice::Kind::copy});
            break;
        case ControlId::reference_run:
            next_reference();
            break;
        case ControlId::reference_off:
            host_->physics().show_reference({});
            break;
        case ControlId::hint:
            ++hints_shown_;
            break;
        case ControlId::restart:
            wants_restart_ = true;
            break;
        case ControlId::end:
            wants_end_ = true;
            break;
        default:
            break;
        }
    }
}

// Shows the stored run that follows the shown run; the last run is followed by the first.
void SuiteApp::next_reference()
{
    const std::vector<RoomRun> &runs = host_->physics().state()->room.runs();
    if (runs.empty()) return;
    const auto next = std::find_if(runs.begin(), runs.end(),
                                   [&](const RoomRun &run) { return run.number > reference_run_; });
    reference_run_ = (next == runs.end() ? runs.front() : *next).number;
    host_->physics().show_reference({ReferenceChoice::Kind::loop, reference_run_});
}

// Writes the positions of the controls, and the texts that change, to a file, for tests that react to what
// the window shows.
void SuiteApp::write_layout()
{
    if (options_.layout.empty()) return;
    const std::string text = ui_.layout_text();
    const SuiteClock::time_point now = SuiteClock::now();
    if (text == layout_ || now - layout_written_ < layout_pause) return;
    layout_ = text;
    layout_written_ = now;
    write_whole_file(options_.layout, text);
}

} // namespace crn
