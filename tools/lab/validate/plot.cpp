#include "tools/lab/validate/plot.hpp"
#include "host/base/format.hpp"
#include "host/base/number_text.hpp"

#include <algorithm>
#include <cmath>

namespace crn::validate
{

namespace
{

constexpr double width = 620, height = 390, left = 76, right = 20, top = 40, bottom = 72;
// The colours have enough contrast on a white background, and colour-blind readers can distinguish them
// (Okabe and Ito).
const char *const colours[] = {"#0072b2", "#d55e00", "#009e73", "#cc79a7", "#8a6d00", "#56b4e9", "#000000"};

const char *colour_of(const Plot &plot, std::size_t i)
{
    int chosen = plot.series[i].colour;
    return colours[(chosen < 0 ? i : std::size_t(chosen)) % std::size(colours)];
}

struct Axis {
    double low = 0, high = 1, from = 0, to = 1; // values, pixels
    bool logarithmic = false;
    double at(double v) const
    {
        double a = logarithmic ? std::log10(v) : v;
        return from + (a - low) / (high - low) * (to - from);
    }
};

double round_step(double span)
{
    double unit = std::pow(10, std::floor(std::log10(span / 5)));
    for (double factor : {1.0, 2.0, 5.0, 10.0}) {
        if (span / (unit * factor) <= 6) return unit * factor;
    }
    return unit * 10;
}

bool shown(const Plot &plot, double x, double y)
{
    return std::isfinite(x) && std::isfinite(y) && (!plot.x_is_logarithmic || x > 0);
}

void spread(Axis &axis, double low, double high)
{
    if (!(high > low)) {
        double margin = low == 0 ? 1 : std::fabs(low) * 0.1;
        low -= margin;
        high += margin;
    }
    double margin = (high - low) * 0.05;
    axis.low = low - margin;
    axis.high = high + margin;
}

void find_ranges(const Plot &plot, Axis &x, Axis &y)
{
    double low[2] = {INFINITY, INFINITY}, high[2] = {-INFINITY, -INFINITY};
    for (const Series &s : plot.series) {
        for (std::size_t i = 0; i < s.x.size() && i < s.y.size(); i++) {
            if (!shown(plot, s.x[i], s.y[i])) continue;
            double v[2] = {plot.x_is_logarithmic ? std::log10(s.x[i]) : s.x[i], s.y[i]};
            for (int k = 0; k < 2; k++) {
                low[k] = std::min(low[k], v[k]);
                high[k] = std::max(high[k], v[k]);
            }
        }
    }
    spread(x, low[0], high[0]);
    spread(y, low[1], high[1]);
    if (plot.equal_scale) {
        double per_x = (x.high - x.low) / (width - left - right),
               per_y = (y.high - y.low) / (height - top - bottom);
        double scale = std::max(per_x, per_y);
        double x_middle = (x.low + x.high) / 2, y_middle = (y.low + y.high) / 2;
        x.low = x_middle - scale * (width - left - right) / 2;
        x.high = x_middle + scale * (width - left - right) / 2;
        y.low = y_middle - scale * (height - top - bottom) / 2;
        y.high = y_middle + scale * (height - top - bottom) / 2;
    }
}

std::vector<double> ticks(const Axis &axis)
{
    std::vector<double> values;
    if (axis.logarithmic) {
        for (double power = std::ceil(axis.low); power <= axis.high; power++)
            values.push_back(std::pow(10, power));
        if (values.size() >= 2) return values;
        values.clear();
        for (double power = std::floor(axis.low); power <= axis.high; power++) {
            for (double factor : {1.0, 2.0, 5.0}) {
                double a = std::log10(factor) + power;
                if (a >= axis.low && a <= axis.high) values.push_back(factor * std::pow(10, power));
            }
        }
        return values;
    }
    double step = round_step(axis.high - axis.low);
    for (double v = std::ceil(axis.low / step) * step; v <= axis.high; v += step) {
        values.push_back(std::fabs(v) < step * 1e-9 ? 0 : v);
    }
    return values;
}

std::string axes(const Plot &plot, const Axis &x, const Axis &y)
{
    std::string out;
    for (double v : ticks(x)) {
        out += formatted("<line x1='%.1f' y1='%.1f' x2='%.1f' y2='%.1f' stroke='#ddd'/>", x.at(v), y.from,
                         x.at(v), y.to);
        out += formatted("<text x='%.1f' y='%.1f' text-anchor='middle'>", x.at(v), y.from + 17) +
               number_text(v, 4) + "</text>\n";
    }
    for (double v : ticks(y)) {
        out += formatted("<line x1='%.1f' y1='%.1f' x2='%.1f' y2='%.1f' stroke='#ddd'/>", x.from, y.at(v),
                         x.to, y.at(v));
        out += formatted("<text x='%.1f' y='%.1f' text-anchor='end'>", x.from - 6, y.at(v) + 4) +
               number_text(v, 4) + "</text>\n";
    }
    out += formatted("<rect x='%.1f' y='%.1f' width='%.1f' height='%.1f' fill='none' stroke='#444'/>\n",
                     x.from, y.to, x.to - x.from, y.from - y.to);
    out += formatted("<text x='%.1f' y='%.1f' text-anchor='middle'>", (x.from + x.to) / 2, y.from + 38) +
           html_text(plot.x_label) + "</text>\n";
    double middle = (y.from + y.to) / 2;
    out += formatted("<text x='16' y='%.1f' text-anchor='middle' transform='rotate(-90 16 %.1f)'>", middle,
                     middle) +
           html_text(plot.y_label) + "</text>\n";
    out += formatted("<text x='%.1f' y='20' text-anchor='middle' font-weight='bold'>", (x.from + x.to) / 2) +
           html_text(plot.title) + "</text>\n";
    return out;
}

std::string curve(const Plot &plot, const Series &s, const char *colour, const Axis &x, const Axis &y)
{
    std::string out, points;
    for (std::size_t i = 0; i < s.x.size() && i < s.y.size(); i++) {
        if (!shown(plot, s.x[i], s.y[i])) continue;
        if (s.dots) {
            out += formatted("<circle cx='%.1f' cy='%.1f' r='3' fill='", x.at(s.x[i]), y.at(s.y[i])) +
                   colour + "'/>";
        } else {
            points += formatted("%.1f,%.1f ", x.at(s.x[i]), y.at(s.y[i]));
        }
    }
    if (!points.empty()) {
        out += "<polyline fill='none' stroke-width='1.6' stroke='" + std::string(colour) + "' points='" +
               points + "'/>";
    }
    return out + "\n";
}

// The legend is below the plot and lists its entries one after the other.
std::string legend(const Plot &plot, double line_y)
{
    std::string out;
    double at = left;
    for (std::size_t i = 0; i < plot.series.size(); i++) {
        const Series &s = plot.series[i];
        const char *colour = colour_of(plot, i);
        if (s.label.empty()) continue;
        if (s.dots) {
            out +=
                formatted("<circle cx='%.1f' cy='%.1f' r='3' fill='", at + 10, line_y - 4) + colour + "'/>";
        } else {
            out += formatted("<line x1='%.1f' y1='%.1f' x2='%.1f' y2='%.1f' stroke-width='1.6' stroke='", at,
                             line_y - 4, at + 20, line_y - 4) +
                   colour + "'/>";
        }
        out += formatted("<text x='%.1f' y='%.1f'>", at + 25, line_y) + html_text(s.label) + "</text>\n";
        at += 38 + 6.0 * double(s.label.size());
    }
    return out;
}

} // namespace

std::string svg(const Plot &plot)
{
    Axis x{0, 1, left, width - right, plot.x_is_logarithmic};
    Axis y{0, 1, height - bottom, top, false};
    find_ranges(plot, x, y);
    std::string out =
        formatted(
            "<svg xmlns='http://www.w3.org/2000/svg' width='%.0f' height='%.0f' viewBox='0 0 %.0f %.0f' ",
            width, height, width, height) +
        "font-family='sans-serif' font-size='12'><rect width='100%' height='100%' fill='white'/>\n";
    out += axes(plot, x, y);
    for (std::size_t i = 0; i < plot.series.size(); i++) {
        out += curve(plot, plot.series[i], colour_of(plot, i), x, y);
    }
    return out + legend(plot, height - 8) + "</svg>\n";
}

} // namespace crn::validate
