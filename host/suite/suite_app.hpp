// Runs the window: shows its screens, passes the user's actions to the session, and limits the rate of
// drawing.
#pragma once
#include "host/live/picture_rhythm.hpp"
#include "host/live/suite_timing.hpp"
#include "host/suite/gamepad.hpp"
#include "host/suite/pages.hpp"
#include "host/suite/prep_page.hpp"
#include "host/suite/replay_page.hpp"
#include "host/suite/session_host.hpp"
#include "host/suite/suite_screen.hpp"
#include "host/suite/suite_window.hpp"
#include "host/suite/ui.hpp"
#include <memory>
#include <optional>

namespace crn
{

class SuiteApp
{
  public:
    explicit SuiteApp(const WindowOptions &options);
    // Shows the window until the user closes it. Returns the program's exit code.
    int run();

  private:
    enum class Page { start, prep, suite, debrief, replay, rig };

    void go_on(Page page);
    void open_prep(const CaseCard &card);
    WindowOptions session_options(const WindowOptions &options) const;
    void open_session(const WindowOptions &options);
    void begin_opening(const WindowOptions &options);
    void look_at_opening();
    void show_opening();
    void enter_session();
    void begin_session();
    void end_session();
    void open_replay(const std::string &recording, std::uint32_t tick = 0);
    bool show_screen(int frame);
    void show_suite();
    void show_page();
    void follow(const PageChoice &choice);
    void carry_out(const PageChoice &choice);
    void save_debrief();
    PageChoice choice_of_key(int key) const;
    void take_page_key(int key);
    void pass_input();
    void pass(const UserWishes &wishes);
    void act(ControlId id);
    void act_own();
    void next_reference();
    RoomStatus predicted(ControlId id);
    bool is_picture_new() const;
    bool waits_for_picture(SuiteClock::time_point now, SuiteClock::duration screen) const;
    void finish_screen();
    void keep_rate(SuiteClock::time_point begin);
    void write_layout();
    int finish();
    bool is_in_session() const { return page_ == Page::suite; }

    const WindowOptions options_;
    SuiteWindow window_;
    Ui ui_;
    Page page_ = Page::start;
    bool begins_at_start_;
    std::vector<CaseCard> cards_, practice_;
    std::string trainee_, said_;
    std::unique_ptr<PrepPage> prep_;
    std::size_t hints_shown_ = 0, card_page_ = 0;
    std::vector<KeptRecording> kept_;
    std::vector<RigRow> rigs_;
    std::string trouble_;
    std::unique_ptr<SessionHost> host_;
    std::unique_ptr<BackgroundTask<std::unique_ptr<SessionHost>>> opening_; // a session that is being opened
    std::optional<UserInput> input_;
    std::optional<SuiteScreen> screen_;
    std::unique_ptr<ReplayPage> replay_;
    Page before_replay_ = Page::start;
    Gamepad gamepad_;
    SuiteTiming timing_;
    struct Drawn { // on the screen that is being drawn
        std::shared_ptr<const SuiteState> state;
        std::shared_ptr<const MonitorPicture> live;
    };
    std::optional<Drawn> drawn_;
    bool shows_help_, is_pixel_by_pixel_ = false, wants_end_ = false, wants_restart_ = false,
                      wants_quit_ = false;
    int reference_run_ = 0, code_ = 0, sessions_ = 0;
    std::uint32_t counted_ticks_ = 0;
    std::uint64_t shown_number_ = 0; // of the live picture on the screen
    PictureRhythm rhythm_;           // of the live pictures
    SuiteClock::time_point last_input_{}, stepped_at_{}, layout_written_{};
    RoomStatus stepped_; // expected on the screen after the last step of a frame or of the mask
    std::string layout_;
};

} // namespace crn
