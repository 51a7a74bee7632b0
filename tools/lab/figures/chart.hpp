// Draws the frame of a chart, which consists of title, axes, grid and legend, and converts values to pixels.
#pragma once
#include "tools/lab/figures/canvas.hpp"
#include <utility>

namespace vcsim3
{

inline constexpr Colour paper{255, 255, 255}, ink{30, 30, 40}, faint{222, 224, 230}, quiet{110, 115, 125};
inline constexpr Colour baseline_colour{52, 101, 164}, thesis_colour{170, 174, 182},
    direct_colour{204, 85, 0};

// One axis: linear from 0, or logarithmic, over [low, high].
struct Axis {
    double low = 0.0, high = 1.0;
    bool is_log = false;
    std::string label;

    double share(double value) const;  // 0 at low, 1 at high; clamped
    std::vector<double> ticks() const; // decades, or about six round steps
};

// Represents the plot area of a chart in a canvas, with an axis for the values on the left.
class Chart
{
  public:
    // The rectangle of the chart's plot area is given in pixels.
    Chart(Canvas &canvas, double left, double top, double right, double bottom, Axis vertical);

    void draw_frame(); // grid lines, numbers and label of the vertical axis
    double y_of(double value) const;
    double left() const { return left_; }
    double right() const { return right_; }
    double top() const { return top_; }
    double bottom() const { return bottom_; }
    Canvas &canvas() { return canvas_; }

  private:
    Canvas &canvas_;
    double left_, top_, right_, bottom_;
    Axis vertical_;
};

void draw_title(Canvas &canvas, const std::string &title, const std::vector<std::string> &lines);
void draw_legend(Canvas &canvas, double x, double y, const std::vector<std::pair<Colour, std::string>> &rows);

// Formats the significant digits of a number without an exponent, for example "0.00842", "7.07" or "384".
std::string short_number(double value, int digits = 3);

} // namespace vcsim3
