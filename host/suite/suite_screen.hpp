// Draws the suite (the window of a live session): the monitors, the panels around them, and temporary parts
// such as notices and help. Each part of the suite reads a copy of the session's state, and passes the user's
// actions to UserInput.
#pragma once
#include "host/cases/goals.hpp"
#include "host/live/oximeter.hpp"
#include "host/live/physics_thread.hpp"
#include "host/model/instrument.hpp"
#include "host/suite/ui.hpp"
#include <deque>
#include <memory>
#include <string>
#include <vector>

namespace crn
{

// Holds everything that one drawing of the suite shows.
struct SuiteView {
    std::shared_ptr<const SuiteState> state;
    std::shared_ptr<const MonitorPicture> live, reference;
    const std::vector<Instrument> *tools = nullptr;       // on the line, from the innermost
    const std::vector<Instrument> *table = nullptr;       // all tools of the session
    std::string title;                                    // of the scene or the case
    const Case *lesson = nullptr;                         // null: no case
    std::shared_ptr<const std::vector<GoalResult>> goals; // of the case; null: not known yet
    std::shared_ptr<const std::vector<std::string>> tips; // of the case: where they are; null: not known
    std::size_t hints_shown = 0;                          // of the case
    bool shows_help = false, is_pixel_by_pixel = false;
    bool has_patient = true; // false: free space
    bool is_measured = true; // false: figures that depend on the clock are left out, for tests
};

// Describes a drag, or a turn of the mouse wheel, on a device: how far the session must push and turn the
// tool.
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
    double shown_s = -1.0; // when it appeared; negative: it waits for its place
};

// Describes the range of greys that a monitor stretches from black to white, in shares of all greys: `window`
// is the width of the range, and `level` its middle.
struct GreyRange {
    double window = 1.0, level = 0.5;
    bool is_whole() const { return window == 1.0 && level == 0.5; }
    // Returns the picture with this range of greys stretched from black to white.
    std::vector<std::uint8_t> shown(const std::vector<std::uint8_t> &grey) const;
    // Dragging to the right widens the range of greys, and dragging upwards raises its middle, which makes
    // the picture darker. `right` and `up` are shares of the length of the picture's edge.
    void drag(double right, double up);
};

struct NoticeLine;

class SuiteScreen
{
  public:
    explicit SuiteScreen(Ui &ui) : ui_(ui) {}

    // Draws one frame. Returns the user's actions with the mouse, except for presses of controls.
    SuiteActions draw(const SuiteView &view);
    void forget_toasts(); // of the last session

  private:
    // monitor_panel.cpp
    void draw_live(const UiRect &place);
    void draw_reference(const UiRect &place);
    void draw_picture(std::size_t slot, const MonitorPicture &picture, const UiRect &place, bool is_sharp,
                      UiRect &shown);
    void draw_live_texts(const UiRect &left, const UiRect &right);
    void draw_grey_range(const UiRect &place);
    void draw_orientation(const UiRect &place, const UiRect &picture);
    void draw_case(const UiRect &place);
    // strip_panel.cpp
    void draw_strip(const UiRect &place);
    void draw_pressure_numbers(const UiRect &place);
    void draw_saturation(const UiRect &place);
    // carm_panel.cpp
    void draw_carm(const UiRect &place);
    void draw_dial(const UiRect &place);
    void draw_space(const UiRect &place);
    void draw_table(const UiRect &place);
    // device_panel.cpp
    void draw_devices(const UiRect &place);
    void draw_device(std::size_t tool, float width);
    void take_drag(std::size_t tool);
    float rack_height() const; // in units of the layout
    void draw_rack(const UiRect &place);
    void draw_rack_device(std::uint8_t number, float width, float height);
    // syringe_panel.cpp
    void draw_dose(const UiRect &place);
    void draw_syringe(const UiRect &place);
    void draw_inflator(const UiRect &place);
    void draw_chart(const UiRect &place, const Instrument &tool);
    // overlay_panels.cpp
    void draw_bar(const UiRect &place);
    void draw_toasts(const UiRect &live);
    void draw_alerts(NoticeLine &line);
    void draw_help();
    void collect_toasts();
    void toast(const RoomNotice &notice);

    Ui &ui_;
    const SuiteView *view_ = nullptr;
    SuiteActions actions_;
    std::deque<Toast> toasts_;
    std::vector<RoomNotice> told_;
    GreyRange range_; // of the live monitor
    std::uint64_t range_changes_ = 0;
    std::vector<std::uint8_t> stretched_; // the live picture `stretched_version_` in that range
    std::uint64_t stretched_version_ = 0;
    Oximeter oximeter_;
};

} // namespace crn
