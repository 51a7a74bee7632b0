#include "host/base/format.hpp"
#include "host/base/number_text.hpp"
#include "tools/lab/literature/pages.hpp"

#include <algorithm>
#include <cmath>

namespace crn::literature
{

namespace
{

constexpr double width = 900, text_end = 390, plot_end = 690, top = 64, line_height = 30;
constexpr double shown = 2.5; // a line shows so many half widths of the accepted range on either side
// The colours of the validation's plots, which colour-blind readers can distinguish (Okabe and Ito).
constexpr const char *passed_colour = "#0072b2", *failed_colour = "#d55e00", *plain_colour = "#555";

// Places figures on a line: -1 and 1 are the ends of the accepted range. Where one end is open, 0 lies
// between a figure of 0 and the other end.
struct Scale {
    double middle = 0, half = 1;
    explicit Scale(const Row &row)
    {
        double low = row.lowest(), high = row.highest();
        if (!std::isfinite(low) && !std::isfinite(high)) {
            low = *row.mean - std::fabs(*row.mean) / 10;
            high = *row.mean + std::fabs(*row.mean) / 10;
        }
        if (!std::isfinite(low)) low = std::min(0.0, high - std::fabs(high));
        if (!std::isfinite(high)) high = low + std::max(std::fabs(low), 1e-9);
        middle = (low + high) / 2;
        half = std::max((high - low) / 2, 1e-12);
    }
    double at(double value) const
    {
        const double place = std::clamp((value - middle) / half, -shown, shown);
        return (text_end + plot_end) / 2 + place / shown * (plot_end - text_end) / 2;
    }
};

std::string text(double x, double y, const char *anchor, const std::string &words, const char *more = "")
{
    return formatted("<text x='%.1f' y='%.1f' text-anchor='%s' %s>", x, y, anchor, more) + html_text(words) +
           "</text>\n";
}

std::string line_of(const Measured &one, const Row &row, double y)
{
    const Scale scale(row);
    const double ours = one.value(row);
    std::string out = text(text_end - 12, y + 4, "end", row.what);
    if (row.has_spread()) {
        const double left = scale.at(row.lowest()), right = scale.at(row.highest());
        out += formatted("<rect x='%.1f' y='%.1f' width='%.1f' height='14' fill='#d9d9d9'/>\n", left, y - 7,
                         right - left);
    }
    if (row.mean)
        out += formatted("<line x1='%.1f' y1='%.1f' x2='%.1f' y2='%.1f' stroke='#444' stroke-width='2'/>\n",
                         scale.at(*row.mean), y - 9, scale.at(*row.mean), y + 9);
    const char *colour = !one.is_judged(row) ? plain_colour : one.passed(row) ? passed_colour : failed_colour;
    if (std::isfinite(ours)) {
        const bool is_beyond = std::fabs((ours - scale.middle) / scale.half) > shown;
        out += is_beyond
                   ? text(scale.at(ours), y + 5, "middle", ours < scale.middle ? "◀" : "▶",
                          formatted("fill='%s'", colour).c_str())
                   : formatted("<circle cx='%.1f' cy='%.1f' r='5' fill='%s'/>\n", scale.at(ours), y, colour);
    }
    const std::string figures =
        number_text(ours, 3) + " (" + row.published() + ") " + (row.unit == "1" ? "" : row.unit);
    return out + text(plot_end + 12, y + 4, "start", figures, formatted("fill='%s'", colour).c_str());
}

} // namespace

std::string picture(const Measured &one)
{
    const double height = top + line_height * double(one.table->rows.size()) + 14;
    std::string out = formatted("<svg xmlns='http://www.w3.org/2000/svg' width='%.0f' height='%.0f' "
                                "viewBox='0 0 %.0f %.0f' font-family='sans-serif' font-size='13'>"
                                "<rect width='100%%' height='100%%' fill='white'/>\n",
                                width, height, width, height);
    out += text(width / 2, 24, "middle", one.table->title + ": " + one.verdict(),
                "font-weight='bold' font-size='15'");
    out += text(plot_end, 46, "end", "dot: ours; bar: accepted by the published spread; line: published mean",
                "fill='#555'");
    out += text(plot_end + 12, 46, "start", "ours (published)", "fill='#555'");
    double y = top + line_height / 2;
    for (const Row &row : one.table->rows) {
        out += line_of(one, row, y);
        y += line_height;
    }
    return out + "</svg>\n";
}

} // namespace crn::literature
