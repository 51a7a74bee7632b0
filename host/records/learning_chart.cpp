#include "host/records/learning_chart.hpp"
#include "host/base/format.hpp"
#include "host/base/html_page.hpp"
#include "host/base/number_text.hpp"
#include <algorithm>
#include <cmath>

namespace crn
{

namespace
{

constexpr double width = 760.0, height = 240.0, left = 58.0, right = 14.0, top = 22.0, bottom = 38.0;

// Converts session number and value to pixels of the chart.
struct Axes {
    double low, high;
    std::size_t sessions;
    double x(double session) const
    {
        const double span = std::max<double>(1.0, static_cast<double>(sessions) - 1.0);
        return left + 10.0 + (session - 1.0) / span * (width - left - right - 20.0);
    }
    double y(double value) const { return top + (high - value) / (high - low) * (height - top - bottom); }
};

std::string points(const Axes &axes, const std::vector<double> &values)
{
    std::string text;
    for (std::size_t i = 0; i < values.size(); i++)
        text +=
            formatted("%s%.1f %.1f", i ? " " : "", axes.x(static_cast<double>(i) + 1.0), axes.y(values[i]));
    return text;
}

std::string grid(const Axes &axes, const std::string &unit)
{
    std::string svg;
    const double step = axis_step(axes.high - axes.low);
    for (double value = std::ceil(axes.low / step) * step; value <= axes.high + 1e-9 * step; value += step)
        svg += formatted("<line x1=\"%.0f\" x2=\"%.0f\" y1=\"%.1f\" y2=\"%.1f\" stroke=\"#dde3ea\"/>", left,
                         width - right, axes.y(value), axes.y(value)) +
               formatted("<text x=\"%.0f\" y=\"%.1f\" text-anchor=\"end\">%s</text>", left - 6,
                         axes.y(value) + 4,
                         number_text(std::fabs(value) < 1e-9 * step ? 0.0 : value, 6).c_str());
    const std::size_t every = std::max<std::size_t>(
        1, static_cast<std::size_t>(axis_step(static_cast<double>(axes.sessions) * 0.5)));
    for (std::size_t session = 1; session <= axes.sessions;
         session += session == 1 && every > 1 ? every - 1 : every)
        svg += formatted("<text x=\"%.1f\" y=\"%.0f\" text-anchor=\"middle\">%zu</text>",
                         axes.x(static_cast<double>(session)), height - bottom + 16, session);
    return svg +
           formatted("<text x=\"%.0f\" y=\"%.0f\" text-anchor=\"end\">session</text>", width - right,
                     height - 6) +
           formatted("<text x=\"4\" y=\"12\">%s</text>", html_text(unit).c_str());
}

} // namespace

LearningChart::LearningChart(std::string title, std::string unit, std::size_t sessions)
    : title_(std::move(title)), unit_(std::move(unit)), sessions_(std::max<std::size_t>(1, sessions))
{
}

void LearningChart::band(const std::vector<double> &low, const std::vector<double> &high, const char *colour,
                         double opacity)
{
    marks_.push_back({Mark::Kind::band, low, high, {}, colour, "", opacity});
}

void LearningChart::line(const std::vector<double> &values, const char *colour, const char *dashes)
{
    marks_.push_back({Mark::Kind::line, values, {}, {}, colour, dashes});
}

void LearningChart::level(double value, const char *colour, const char *dashes, const std::string &label)
{
    marks_.push_back({Mark::Kind::level, {value}, {}, {label}, colour, dashes});
}

void LearningChart::area(double low, double high, const char *colour)
{
    marks_.push_back({Mark::Kind::area, {low}, {high}, {}, colour, ""});
}

void LearningChart::dots(const std::vector<double> &values, const std::vector<std::string> &labels,
                         const char *colour)
{
    marks_.push_back({Mark::Kind::dots, values, {}, labels, colour, ""});
}

std::string LearningChart::svg() const
{
    double low = 0.0, high = 0.0; // 0 is always on the axis, so that no difference looks larger than it is
    for (const Mark &mark : marks_)
        for (const auto *values : {&mark.values, &mark.more})
            for (double value : *values) low = std::min(low, value), high = std::max(high, value);
    if (high <= low) high = low + 1.0;
    const Axes axes{low, low + (high - low) * 1.05, sessions_};
    std::string svg =
        formatted("<svg viewBox=\"0 0 %.0f %.0f\" width=\"%.0f\" role=\"img\" aria-label=\"%s\">", width,
                  height, width, html_text(title_).c_str()) +
        grid(axes, unit_);
    for (const Mark &mark : marks_) {
        const char *colour = mark.colour.c_str();
        if (mark.kind == Mark::Kind::band) {
            std::vector<double> back(mark.more.rbegin(), mark.more.rend());
            std::string edge = points(axes, mark.values);
            for (std::size_t i = 0; i < back.size(); i++)
                edge +=
                    formatted(" %.1f %.1f", axes.x(static_cast<double>(back.size() - i)), axes.y(back[i]));
            svg += formatted("<polygon fill=\"%s\" opacity=\"%.2f\" points=\"", colour, mark.opacity) + edge +
                   "\"/>";
        }
        if (mark.kind == Mark::Kind::line)
            svg += formatted("<polyline fill=\"none\" stroke=\"%s\" stroke-width=\"2\" "
                             "stroke-dasharray=\"%s\" points=\"",
                             colour, mark.dashes.c_str()) +
                   points(axes, mark.values) + "\"/>";
        if (mark.kind == Mark::Kind::area)
            svg += formatted(
                "<rect x=\"%.0f\" width=\"%.0f\" y=\"%.1f\" height=\"%.1f\" fill=\"%s\" opacity=\"0.15\"/>",
                left, width - left - right, axes.y(mark.more[0]),
                std::max(1.0, axes.y(mark.values[0]) - axes.y(mark.more[0])), colour);
        if (mark.kind == Mark::Kind::level)
            svg += formatted("<line x1=\"%.0f\" x2=\"%.0f\" y1=\"%.1f\" y2=\"%.1f\" stroke=\"%s\" "
                             "stroke-width=\"1.5\" "
                             "stroke-dasharray=\"%s\"/>",
                             left, width - right, axes.y(mark.values[0]), axes.y(mark.values[0]), colour,
                             mark.dashes.c_str()) +
                   formatted("<text x=\"%.0f\" y=\"%.1f\" text-anchor=\"end\">%s</text>", width - right,
                             axes.y(mark.values[0]) - 4, html_text(mark.labels[0]).c_str());
        if (mark.kind == Mark::Kind::dots)
            for (std::size_t i = 0; i < mark.values.size(); i++)
                svg += formatted(
                    "<circle cx=\"%.1f\" cy=\"%.1f\" r=\"4\" fill=\"%s\"><title>%s</title></circle>",
                    axes.x(static_cast<double>(i) + 1.0), axes.y(mark.values[i]), colour,
                    html_text(mark.labels[i]).c_str());
    }
    return svg + "</svg>\n";
}

} // namespace crn
