// Draws line plots as SVG text, with plain axes and round numbers at the ticks. In the plots, lines show
// references, and dots show our values.
#pragma once
#include <string>
#include <vector>

namespace crn::validate
{

struct Series {
    std::string label; // empty: not in the legend
    std::vector<double> x, y;
    bool dots = false; // else a line
    int colour = -1;   // series with the same number share a colour; -1: its position in the plot, 6: black
};

struct Plot {
    std::string title, x_label, y_label;
    std::vector<Series> series;
    bool equal_scale = false; // the same millimetres along both axes, for shapes
    bool x_is_logarithmic = false;
};

// Returns a complete <svg> element. Values that are not finite are not drawn.
std::string svg(const Plot &plot);

} // namespace crn::validate
