// Draws the parts of which the window's panels are made: panels at fixed places, buttons of controls, texts
// and bars. The class also stores the position of every control, so that a test can press it.
#pragma once
#include "host/suite/suite_window.hpp"
#include "host/suite/user_input.hpp"
#include <cstdarg>
#include <imgui.h>
#include <string>
#include <vector>

namespace crn
{

// Defines greys and the colours of Okabe and Ito, which people with colour blindness can distinguish.
namespace tint
{
inline constexpr ImU32 background = IM_COL32(16, 20, 24, 255), panel = IM_COL32(30, 36, 43, 255),
                       raised = IM_COL32(45, 53, 63, 255), text = IM_COL32(232, 237, 240, 255),
                       dim = IM_COL32(154, 164, 174, 255), orange = IM_COL32(230, 159, 0, 255),
                       sky = IM_COL32(86, 180, 233, 255), green = IM_COL32(0, 200, 130, 255),
                       yellow = IM_COL32(240, 228, 66, 255), red = IM_COL32(255, 90, 90, 255),
                       cyan = IM_COL32(90, 220, 230, 255), line = IM_COL32(60, 73, 88, 255);
}

struct UiRect {
    float x = 0.0f, y = 0.0f, width = 0.0f, height = 0.0f; // pixels
};

struct PlacedControl {
    std::string name;
    UiRect place;
    std::string text; // that the control shows and that changes; empty: none
};

class Ui
{
  public:
    explicit Ui(SuiteWindow &window) : window_(&window) {}
    void serve(UserInput &input) { input_ = &input; } // to which the buttons of controls belong

    SuiteWindow &window() { return *window_; }
    UserInput &input() { return *input_; }
    const UiFonts &fonts() const { return window_->fonts(); }
    float px(float units) const { return units * window_->scale(); }

    void begin_screen() { placed_.clear(); }
    // Begins a panel at a fixed place; `title` may be empty. Call end_panel() afterwards.
    void begin_panel(const char *name, const UiRect &place, const char *title);
    void end_panel();
    // Draws the button of a control. `label` replaces the control's name, and is shown with a capital letter
    // at its beginning. If `is_lit` is true, the button shows that its control is switched on. `width` is in
    // layout units; 0 means as wide as the label, and a negative value means the whole remaining width. If
    // the label of a button does not fit into its fixed width, the layout file (for tests) says so.
    void button(ControlId id, const char *label = nullptr, float width = 0.0f, bool is_lit = false);
    // Draws the button of a screen's control; a wide button also shows its key. Returns true if the user
    // pressed the button.
    bool screen_button(ScreenControlId id, const std::string &label, float width);
    // Draws a button that belongs to no control of the session, such as a card. Returns true if the user
    // pressed this button.
    bool plain_button(const char *name, const char *label, float width, const char *tooltip = nullptr);
    // Shows a tooltip for the last drawn item, if the pointer rests on the item.
    void tooltip(const std::string &text);
    static std::string tooltip_of(const Control &control);
    void text(ImU32 colour, const char *format, ...) IM_FMTARGS(3);
    void small_text(ImU32 colour, const char *format, ...) IM_FMTARGS(3);
    // Draws a horizontal bar from the middle to the left or right, for values from -1 to 1.
    void bar(float share, ImU32 colour, const char *label, float width);
    void note(const std::string &name, const UiRect &place, const std::string &text = "")
    {
        placed_.push_back({name, place, text});
    }
    void note_last_item(const std::string &name, const std::string &text = "");

    // Returns the controls that the present screen shows, with their positions in pixels.
    const std::vector<PlacedControl> &placed() const { return placed_; }
    // Returns them as lines "name TAB x TAB y TAB width TAB height", with TAB and the text where there is
    // one.
    std::string layout_text() const;

  private:
    void draw_text(ImFont *font, ImU32 colour, const char *format, va_list arguments);

    SuiteWindow *window_;
    UserInput *input_ = nullptr;
    std::vector<PlacedControl> placed_;
};

} // namespace crn
