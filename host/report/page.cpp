#include "host/report/page.hpp"
#include "host/base/format.hpp"
#include "host/base/html_page.hpp"
#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

namespace crn
{

namespace
{

using Json = nlohmann::ordered_json;

constexpr double plot_width = 640.0, plot_height = 150.0, margin_left = 52.0, margin_bottom = 22.0,
                 margin_top = 8.0;

// The line of a curve is interrupted between two samples that are more than a second apart and farther apart
// than three times the average distance.
std::string line_of(const std::vector<double> &time_s, const PageCurve &curve, double begin_s, double end_s,
                    double top)
{
    std::string path;
    const std::size_t count = std::min(time_s.size(), curve.values.size());
    const double gap_s = std::max(1.0, 3.0 * (end_s - begin_s) / static_cast<double>(count + 1));
    for (std::size_t i = 0; i < count; i++) {
        const bool is_new = i == 0 || time_s[i] - time_s[i - 1] > gap_s;
        path += formatted(
            "%s%.1f %.1f", is_new ? "M" : "L",
            margin_left + (time_s[i] - begin_s) / (end_s - begin_s) * (plot_width - margin_left),
            margin_top + (1.0 - curve.values[i] / top) * (plot_height - margin_top - margin_bottom));
    }
    return formatted("<path fill=\"none\" stroke=\"%s\" stroke-width=\"1.4\" d=\"", curve.colour) + path +
           "\"/>";
}

} // namespace

std::string page_text(const Json &from, const char *key)
{
    return from.is_object() && from.contains(key) && from[key].is_string()
               ? html_text(from[key].get<std::string>())
               : std::string();
}

std::string page_figure(const Json &value)
{
    if (!value.is_number()) return "–";
    const double v = value.get<double>(), size = std::fabs(v);
    return formatted(size >= 100.0 ? "%.0f" : size >= 10.0 ? "%.1f" : "%.2f", v);
}

std::vector<double> page_numbers(const Json &from, const char *key)
{
    std::vector<double> values;
    if (!from.is_object() || !from.contains(key) || !from[key].is_array()) return values;
    for (const Json &value : from[key]) values.push_back(value.is_number() ? value.get<double>() : 0.0);
    return values;
}

std::string page_plot(const std::string &title, const std::vector<double> &time_s,
                      const std::vector<PageCurve> &curves)
{
    double top = 0.0;
    for (const PageCurve &curve : curves)
        for (double value : curve.values) top = std::max(top, value);
    if (time_s.size() < 2 || top <= 0.0) return "";
    const double begin_s = time_s.front(), end_s = std::max(time_s.back(), begin_s + 1e-3);
    const double step = axis_step(top), step_s = axis_step(end_s - begin_s);
    top = std::ceil(top / step) * step;
    std::string svg = formatted("<svg viewBox=\"0 0 %.0f %.0f\" width=\"%.0f\" role=\"img\">", plot_width,
                                plot_height, plot_width);
    for (double value = 0.0; value <= top * 1.0001; value += step) {
        const double y = margin_top + (1.0 - value / top) * (plot_height - margin_top - margin_bottom);
        svg += formatted(
            "<line x1=\"%.0f\" x2=\"%.0f\" y1=\"%.1f\" y2=\"%.1f\" stroke=\"#dde3ea\"/><text x=\"%.0f\" "
            "y=\"%.1f\" text-anchor=\"end\">%g</text>",
            margin_left, plot_width, y, y, margin_left - 6, y + 4, value);
    }
    for (double s = std::ceil(begin_s / step_s) * step_s; s <= end_s; s += step_s)
        svg += formatted("<text x=\"%.1f\" y=\"%.0f\" text-anchor=\"middle\">%g s</text>",
                         margin_left + (s - begin_s) / (end_s - begin_s) * (plot_width - margin_left - 20),
                         plot_height - 6, s);
    std::string legend;
    for (const PageCurve &curve : curves) {
        svg += line_of(time_s, curve, begin_s, end_s, top);
        legend += formatted(" <span style=\"color:%s\">%s</span>", curve.colour, curve.title);
    }
    return "<p class=\"soft\">" + title + ":" + legend + "</p>\n" + svg + "</svg>\n";
}

} // namespace crn
