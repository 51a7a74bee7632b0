// Draws charts on a white sheet: boxes, smooth lines of any width, and text in the font of the display.
#pragma once
#include "host/picture/picture.hpp"
#include <string_view>
#include <vector>

namespace crn
{

struct Ink {
    std::uint8_t red = 0, green = 0, blue = 0;
};

struct SheetPoint {
    double x = 0.0, y = 0.0; // pixels; y grows downwards, whole numbers are the corners of pixels
};

// Drawing outside the sheet or the clip box has no effect.
class Sheet
{
  public:
    Sheet(int width, int height);
    const Image &image() const { return image_; }
    void clip(int x0, int y0, int x1, int y1); // until the next call; [x0, x1) x [y0, y1)
    void unclip();
    void box(int x0, int y0, int x1, int y1, Ink ink);
    // Draws one line of any width with round ends and joints. Where the line crosses itself, its colour does
    // not get darker. If `dash` is 0, the line has no gaps.
    void stroke(const std::vector<SheetPoint> &points, double width, Ink ink, double dash = 0.0);
    // Draws text with letters of 5 x 7 pixels times `scale`; (x, y) is the top left corner of the text.
    void text(int x, int y, std::string_view text, int scale, Ink ink);
    static int text_width(std::string_view text, int scale);
    void blend(int x, int y, Ink ink,
               double share); // one pixel; with share 1 the ink replaces the old colour

  private:
    void cover(const std::vector<SheetPoint> &points, double width, Ink ink);

    Image image_;
    int x0_ = 0, y0_ = 0, x1_ = 0, y1_ = 0;
};

} // namespace crn
