// Draws the replay: the picture of any moment from any angle, a scrub bar with the pedals and injections of
// the session, and the devices' readings.
#pragma once
#include "host/live/replay_thread.hpp"
#include "host/suite/ui.hpp"
#include <memory>
#include <string>

namespace crn
{

class ReplayPage
{
  public:
    // Throws what ReplayRoom throws.
    ReplayPage(Ui &ui, const std::string &recording, const PictureSettings &settings);

    void draw();
    // Carries out a control of the C-arm, table or field for this view only. Returns false for other
    // controls.
    bool act(ControlId id);
    void jump(double seconds); // relative
    void toggle_play() { is_playing_ = !is_playing_; }
    const ReplayThread &replay() const { return thread_; }
    std::uint32_t tick() const { return static_cast<std::uint32_t>(tick_); }

  private:
    void draw_picture(const UiRect &place);
    void draw_side(const UiRect &place);
    void draw_scrub(const UiRect &place);
    void ask();

    Ui &ui_;
    std::string name_;
    ReplayThread thread_;
    std::vector<ReplayMark> marks_;
    double tick_ = 0.0;
    bool is_playing_ = false;
    std::optional<CArm> carm_; // empty: as in the session
    ReplayAsk asked_;
    bool has_asked_ = false;
    std::uint32_t asked_prepared_ = 0;
};

} // namespace crn
