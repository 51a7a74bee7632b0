// Draws the review window: steps and buttons at the left, three sections through the patient at the right,
// and below them what was found and the clicks.
#pragma once
#include "host/suite/ui.hpp"
#include "tools/lab/ct/review/review_state.hpp"

namespace crn::ct
{

// What the user wants to happen after a frame, by a button or a key.
struct ReviewWish {
    bool plays = false, ends = false;
};

class ReviewScreen
{
  public:
    ReviewScreen(Ui &ui, ReviewState &state) : ui_(ui), state_(state) {}

    ReviewWish draw();
    // Acts on a key of the keyboard (GLFW_KEY_*), as the buttons do.
    ReviewWish press(int key);

  private:
    void draw_steps(ReviewWish &wish);
    void draw_progress();
    void draw_tools();
    void draw_section(Section section, const char *name, const char *title, const UiRect &place);
    void draw_marks(const SectionPicture &picture, const UiRect &place);
    void draw_findings(const UiRect &place);
    void draw_clicks(const UiRect &place);

    Ui &ui_;
    ReviewState &state_;
    char branch_[64] = {}; // the name that the next click of this kind gives
};

} // namespace crn::ct
