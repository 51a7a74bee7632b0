// The angiography display around a picture: angles, dose, instrument and orientation, in an own bitmap font.
#pragma once
#include "host/app/picture.hpp"
#include "host/xray/xray.hpp"
#include <string>
#include <string_view>
#include <vector>

namespace seld
{

// One tool's lines in the display.
struct OverlayTool {
    std::string name;
    double inserted_mm = 0.0;
    double turned_deg = 0.0;
    double axial_N = 0.0; // on the hand, + pushes it out
    double torque_mN_m = 0.0;
    bool is_chosen = false; // the one that the keys move
};

struct OverlayInfo {
    double primary_deg = 0.0;   // + LAO
    double secondary_deg = 0.0; // + CRA
    double field_m = 0.32;
    double time_s = 0.0;            // of the session
    std::vector<OverlayTool> tools; // from the innermost
    double axial_full_scale_N = 2.0;
    double fluoro_s = 0.0;          // beam-on time
    double kerma_mGy = 0.0;         // sum at the reference point
    bool is_beam_on = true;         // false: last image hold
    std::string notice;             // one line in the middle, e.g. a warning; empty for none
    std::vector<std::string> panel; // help panel, one line each; empty for none
};

// The grey picture as RGB with the display drawn over it. Letters grow with
// the picture.
Image compose_display(const XrayPicture &picture, const OverlayInfo &info);

// Text in white with a dark rim; scale 1 is 5x7 points, 6 per letter. What does not fit is cut off at the picture's edge.
struct Colour {
    std::uint8_t red, green, blue;
};
void draw_text(Image &rgb, int x, int y, std::string_view text, int scale, Colour colour);
int text_width(std::string_view text, int scale);

} // namespace seld
