#include "tools/lab/figures/chart.hpp"
#include "host/base/number_text.hpp"
#include <algorithm>
#include <cmath>

namespace vcsim3
{
namespace
{

constexpr double small_text = 1.5, large_text = 2.5;

} // namespace

std::string short_number(double value, int digits)
{
    if (value == 0.0) return "0";
    const int decade = static_cast<int>(std::floor(std::log10(std::abs(value))));
    return crn::trimmed_text(value, std::clamp(digits - 1 - decade, 0, 6));
}

double Axis::share(double value) const
{
    const double share =
        is_log ? std::log(std::max(value, 1e-12) / low) / std::log(high / low) : (value - low) / (high - low);
    return std::clamp(share, 0.0, 1.0);
}

std::vector<double> Axis::ticks() const
{
    std::vector<double> ticks;
    if (is_log) {
        for (double tick = low; tick <= high * 1.001; tick *= 10.0) ticks.push_back(tick);
        return ticks;
    }
    const double rough = (high - low) / 6.0, decade = std::pow(10.0, std::floor(std::log10(rough)));
    const double step = decade * (rough < 1.5 * decade ? 1.0 : rough < 3.5 * decade ? 2.0 : 5.0);
    for (int i = 0; low + i * step <= high * 1.001; i++) ticks.push_back(low + i * step);
    return ticks;
}

Chart::Chart(Canvas &canvas, double left, double top, double right, double bottom, Axis vertical)
    : canvas_(canvas), left_(left), top_(top), right_(right), bottom_(bottom), vertical_(std::move(vertical))
{
}

double Chart::y_of(double value) const
{
    return bottom_ - vertical_.share(value) * (bottom_ - top_);
}

void Chart::draw_frame()
{
    for (double tick : vertical_.ticks()) {
        canvas_.line(left_, y_of(tick), right_, y_of(tick), 1.0, faint);
        canvas_.text(left_ - 8, y_of(tick) - 6, short_number(tick), small_text, quiet, Align::right);
    }
    canvas_.line(left_, bottom_, right_, bottom_, 1.5, ink);
    canvas_.text_upwards(left_ - 78, (top_ + bottom_) / 2, vertical_.label, small_text, ink);
}

void draw_title(Canvas &canvas, const std::string &title, const std::vector<std::string> &lines)
{
    canvas.text(24, 18, title, large_text, ink);
    for (std::size_t i = 0; i < lines.size(); i++)
        canvas.text(24, 46 + 18.0 * static_cast<double>(i), lines[i], small_text, quiet);
}

void draw_legend(Canvas &canvas, double x, double y, const std::vector<std::pair<Colour, std::string>> &rows)
{
    for (std::size_t i = 0; i < rows.size(); i++) {
        const double top = y + 20.0 * static_cast<double>(i);
        canvas.rectangle(x, top, x + 14, top + 12, rows[i].first);
        canvas.text(x + 22, top, rows[i].second, small_text, ink);
    }
}

} // namespace vcsim3
