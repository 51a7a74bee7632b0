// Draws charts into a picture, as rectangles, lines, discs and letters. Every shape is drawn at twice its
// final size and then reduced, so that its edges look smooth.
#pragma once
#include <Eigen/Core>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace vcsim3
{

struct Colour {
    std::uint8_t red, green, blue;
};

enum class Align { left, centre, right };

// Coordinates are pixels of the finished picture, with the origin at the top left. If a shape extends beyond
// the picture, the outer part is cut off.
class Canvas
{
  public:
    Canvas(int width, int height, Colour background);

    int width() const { return width_; }
    int height() const { return height_; }

    void rectangle(double x0, double y0, double x1, double y1, Colour colour);
    void line(double x0, double y0, double x1, double y1, double thickness, Colour colour);
    void dashed(double x0, double y0, double x1, double y1, double thickness, Colour colour);
    void disc(double x, double y, double radius, Colour colour);
    void blend(int x, int y, Colour colour, double share); // one pixel

    // A letter is a grid of 6 x 8 dots, each dot measures `size` pixels, and y is the top of the letter. The
    // function text_upwards() rotates the text by a quarter turn, and y is the middle of this text.
    void text(double x, double y, std::string_view letters, double size, Colour colour,
              Align align = Align::left);
    void text_upwards(double x, double y, std::string_view letters, double size, Colour colour);
    static double text_width(std::string_view letters, double size);

    // Throws std::runtime_error, whose message names the file and the cause.
    void write_png(const std::string &path) const;

  private:
    void put(int column, int row, Colour colour);

    int width_, height_;
    std::vector<std::uint8_t> fine_; // RGB at twice the width and height
};

} // namespace vcsim3
