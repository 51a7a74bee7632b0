// Draws the suite: the monitors, the panels around them, and what lies over them for a while. Each part reads
// a copy of the session's state, and gives the user's actions to UserInput.
#pragma once
#include "host/live/physics_thread.hpp"
#include "host/model/instrument.hpp"
#include "host/suite/ui.hpp"
#include <deque>
#include <memory>
#include <string>
#include <vector>

namespace crn
{

// Everything that one frame of the suite shows.
struct SuiteView {
    std::shared_ptr<const SuiteState> state;
    std::shared_ptr<const MonitorPicture> live, reference;
    const std::vector<Instrument> *tools = nullptr; // from the innermost
    std::string title;                              // of the scene
    bool shows_help = false, is_pixel_by_pixel = false;
    bool is_measured = true; // false: figures that depend on the clock are left out, for tests
};

// A drag or turn of the wheel on a device: what the session must do with it.
struct DeviceDrag {
    std::size_t tool = 0;
    std::int32_t push_um = 0, turn_counts = 0;
};

struct SuiteActions {
    std::vector<DeviceDrag> drags;
    std::vector<RoomCommand> commands;
};

struct Toast {
    std::string text;
    double until_s = 0.0;
    std::int64_t from_tick = -1;
};

class SuiteScreen
{
  public:
    explicit SuiteScreen(Ui &ui) : ui_(ui) {}

    // Draws one frame. Returns what the mouse did in it, besides pressing controls.
    SuiteActions draw(const SuiteView &view);
    void forget_toasts(); // of the last session

  private:
    // monitor_panel.cpp
    void draw_live(const UiRect &place);
    void draw_reference(const UiRect &place);
    void draw_picture(std::size_t slot, const MonitorPicture &picture, const UiRect &place, bool is_sharp,
                      UiRect &shown);
    void draw_live_texts(const UiRect &left, const UiRect &right);
    void draw_orientation(const UiRect &shown);
    // strip_panel.cpp
    void draw_strip(const UiRect &place);
    void draw_pressure_numbers(const UiRect &place);
    // carm_panel.cpp
    void draw_carm(const UiRect &place);
    void draw_dial(const UiRect &place);
    void draw_space(const UiRect &place);
    void draw_table(const UiRect &place);
    // device_panel.cpp
    void draw_devices(const UiRect &place);
    void draw_device(std::size_t tool, float width);
    // syringe_panel.cpp
    void draw_dose(const UiRect &place);
    void draw_syringe(const UiRect &place);
    void draw_inflator(const UiRect &place);
    void draw_chart(const UiRect &place, const Instrument &tool);
    // overlay_panels.cpp
    void draw_bar(const UiRect &place);
    void draw_toasts(const UiRect &live);
    void draw_help();
    void collect_toasts();
    void toast(const RoomNotice &notice);

    Ui &ui_;
    const SuiteView *view_ = nullptr;
    SuiteActions actions_;
    std::deque<Toast> toasts_;
    std::vector<RoomNotice> told_;
};

} // namespace crn
