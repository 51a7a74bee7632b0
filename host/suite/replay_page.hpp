// Draws the replay: the picture of any moment from any angle, a time bar with the pedals and injections of
// the session, and the readings of the devices.
#pragma once
#include "host/cases/case.hpp"
#include "host/live/background_task.hpp"
#include "host/live/replay_thread.hpp"
#include "host/suite/ui.hpp"
#include <memory>
#include <string>

namespace crn
{

// Describes a handling error that the assessment found, and its tick on the time bar.
struct ReplayError {
    std::uint32_t tick = 0;
    int weight = 3; // 3 moderate, 4 serious, 5 life-threatening
    std::string title;
};

class ReplayPage
{
  public:
    // `lesson` is the case whose expert can be shown beside the session, or null if there is no case. Throws
    // what ReplayRoom throws.
    ReplayPage(Ui &ui, const std::string &recording, const PictureSettings &settings,
               std::shared_ptr<const Case> lesson = {}, std::vector<ReplayError> errors = {});

    void draw();
    // Carries out a control of the C-arm, table or field, which changes only this view of the replay. Returns
    // false for other controls.
    bool act(ControlId id);
    void jump(double seconds); // relative
    void go_to(std::uint32_t tick);
    // Goes to one second before the next error, or before the previous error.
    void go_to_error(bool is_next);
    void toggle_expert();
    void toggle_play() { is_playing_ = !is_playing_; }
    const ReplayThread &replay() const { return thread_; }
    std::uint32_t tick() const { return static_cast<std::uint32_t>(tick_); }

  private:
    using ExpertTask = BackgroundTask<std::shared_ptr<ReplayThread>>;

    void draw_pictures(const UiRect &place);
    void draw_picture(const char *name, std::size_t slot, const ReplayShown *shown, const UiRect &place);
    void draw_expert_text();
    void draw_sides(const CArm &carm, const UiRect &picture);
    void draw_side(const UiRect &place);
    void draw_scrub(const UiRect &place);
    void draw_scrub_buttons(double ticks);
    void draw_errors(const UiRect &place, double ticks);
    void ask();
    void ask_expert();
    ReplayThread *expert() const;

    Ui &ui_;
    std::string name_;
    ReplayThread thread_;
    std::vector<ReplayMark> marks_;
    PictureSettings settings_;
    std::shared_ptr<const Case> lesson_;
    std::vector<ReplayError> errors_;    // by time
    std::unique_ptr<ExpertTask> expert_; // null: not asked for
    bool shows_expert_ = false, has_asked_expert_ = false;
    ReplayAsk asked_expert_;
    std::uint32_t asked_expert_prepared_ = 0;
    double tick_ = 0.0;
    bool is_playing_ = false;
    std::optional<CArm> carm_; // empty: as in the session
    ReplayAsk asked_;
    bool has_asked_ = false;
    std::uint32_t asked_prepared_ = 0;
};

} // namespace crn
