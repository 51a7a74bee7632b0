// Draws the texts and traces of the angiography display over a picture: geometry, mode, dose, instrument,
// orientation, electrocardiogram and pressure.
#pragma once
#include "host/effects/pulse.hpp"
#include "host/picture/picture.hpp"
#include "host/room/room_screen.hpp"
#include <string>
#include <string_view>
#include <vector>

namespace crn
{

// Holds the values that the display shows for one tool.
struct OverlayTool {
    std::string name;
    double inserted_mm = 0.0;
    double turned_deg = 0.0;
    double axial_N = 0.0; // on the hand, + pushes it out
    double torque_mN_m = 0.0;
    bool is_chosen = false; // the one that the keys move
};

// Holds the values that the display shows for the balloon and its stent, if a tool has a balloon.
struct OverlayBalloon {
    bool is_shown = false, is_burst = false;
    double pressure_bar = 0.0, diameter_max_mm = 0.0, diameter_min_mm = 0.0;
    std::string stent; // its stage; empty: there is no stent
};

struct OverlayInfo {
    RoomStatus room;
    double time_s = 0.0;            // of the session
    std::vector<OverlayTool> tools; // from the innermost
    double axial_full_scale_N = 2.0;
    double fluoro_min = 0.0; // pedal time of fluoroscopy
    double kerma_mGy = 0.0;  // total at the reference point
    double kerma_rate_mGy_min = 0.0;
    double kap_Gy_cm2 = 0.0;
    double contrast_ml = 0.0;         // injected volume; at 0 and without flow nothing is shown
    double contrast_ml_s = 0.0;       // at the moment
    double dose_alert_Gy = 0.0;       // exceeded and not acknowledged; 0: none
    unsigned fluoro_reminder_min = 0; // minutes of fluoroscopy, likewise
    OverlayBalloon balloon;
    const PulseMonitor *pulse = nullptr; // traces of the heart; nullptr: none
    bool is_pressure_damped = false;     // the tip of the catheter blocks its vessel
    std::string notice;                  // one line in the middle, e.g. a warning; empty for none
    std::vector<std::string> panel;      // help panel, one line each; empty for none
};

// Converts the grey picture to RGB and returns it with the display drawn over it. Letters grow with the
// picture.
Image compose_display(const XrayPicture &picture, const OverlayInfo &info);

// Draws text in the given colour with a dark rim; at scale 1 a letter has 5 x 7 pixels, and letters are 6
// pixels apart. Text that does not fit is cut off at the picture's edge.
struct Colour {
    std::uint8_t red, green, blue;
};
void draw_text(Image &rgb, int x, int y, std::string_view text, int scale, Colour colour);
int text_width(std::string_view text, int scale);

} // namespace crn
