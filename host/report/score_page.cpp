// Writes the score as one HTML page that needs no other file.
#include "host/base/format.hpp"
#include "host/base/html_page.hpp"
#include "host/base/pending_file.hpp"
#include "host/report/score.hpp"
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

std::string text_at(const Json &from, const char *key)
{
    return from.is_object() && from.contains(key) && from[key].is_string()
               ? html_text(from[key].get<std::string>())
               : std::string();
}

// Rounds to three significant digits, without an exponent.
std::string figure(const Json &value)
{
    if (!value.is_number()) return "–";
    const double v = value.get<double>(), size = std::fabs(v);
    return formatted(size >= 100.0 ? "%.0f" : size >= 10.0 ? "%.1f" : "%.2f", v);
}

std::string base64(const std::vector<std::uint8_t> &bytes)
{
    static const char letters[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    std::string text;
    for (std::size_t i = 0; i < bytes.size(); i += 3) {
        const std::size_t left = bytes.size() - i;
        const std::uint32_t three = static_cast<std::uint32_t>(bytes[i]) << 16 |
                                    (left > 1 ? static_cast<std::uint32_t>(bytes[i + 1]) << 8 : 0u) |
                                    (left > 2 ? static_cast<std::uint32_t>(bytes[i + 2]) : 0u);
        text += letters[three >> 18 & 63];
        text += letters[three >> 12 & 63];
        text += left > 1 ? letters[three >> 6 & 63] : '=';
        text += left > 2 ? letters[three & 63] : '=';
    }
    return text;
}

std::string pictures_of(const std::vector<ScorePicture> &pictures)
{
    std::string html;
    for (const ScorePicture &picture : pictures)
        html += "<figure><img alt=\"" + html_text(picture.caption) + "\" src=\"data:image/png;base64," +
                base64(encode_png(picture.image)) + "\"><figcaption>" + html_text(picture.caption) +
                "</figcaption></figure>\n";
    return html.empty() ? "" : "<h2>Pictures</h2>\n" + html;
}

struct Curve {
    const char *title, *colour;
    std::vector<double> values;
};

std::vector<double> numbers(const Json &from, const char *key)
{
    std::vector<double> values;
    if (!from.is_object() || !from.contains(key) || !from[key].is_array()) return values;
    for (const Json &value : from[key]) values.push_back(value.is_number() ? value.get<double>() : 0.0);
    return values;
}

// The line of a curve is interrupted where two samples are more than a second apart.
std::string line_of(const std::vector<double> &time_s, const Curve &curve, double begin_s, double end_s,
                    double top)
{
    std::string path;
    const std::size_t count = std::min(time_s.size(), curve.values.size());
    for (std::size_t i = 0; i < count; i++) {
        const bool is_new = i == 0 || time_s[i] - time_s[i - 1] > 1.0;
        path += formatted(
            "%s%.1f %.1f", is_new ? "M" : "L",
            margin_left + (time_s[i] - begin_s) / (end_s - begin_s) * (plot_width - margin_left),
            margin_top + (1.0 - curve.values[i] / top) * (plot_height - margin_top - margin_bottom));
    }
    return formatted("<path fill=\"none\" stroke=\"%s\" stroke-width=\"1.4\" d=\"", curve.colour) + path +
           "\"/>";
}

std::string plot(const std::string &title, const std::vector<double> &time_s,
                 const std::vector<Curve> &curves)
{
    double top = 0.0;
    for (const Curve &curve : curves)
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
    for (const Curve &curve : curves) {
        svg += line_of(time_s, curve, begin_s, end_s, top);
        legend += formatted(" <span style=\"color:%s\">%s</span>", curve.colour, curve.title);
    }
    return "<p class=\"soft\">" + title + ":" + legend + "</p>\n" + svg + "</svg>\n";
}

std::string curves_of(const Json &report)
{
    std::string html;
    if (report.contains("balloon") && report["balloon"].is_object() && report["balloon"].contains("curves")) {
        const Json &curves = report["balloon"]["curves"];
        const std::vector<double> time_s = numbers(curves, "time_s");
        html += plot("Pressure, bar", time_s, {{"inflator", "#1f5fa8", numbers(curves, "pressure_bar")}});
        html += plot("Balloon's diameter, mm", time_s,
                     {{"widest", "#1b6e3c", numbers(curves, "diameter_max_mm")},
                      {"narrowest", "#c2691c", numbers(curves, "diameter_min_mm")}});
        html += plot("Balloon's force on the wall, N", time_s,
                     {{"all round", "#7a3b9a", numbers(curves, "wall_force_N")}});
    }
    if (report.contains("contact") && report["contact"].is_object()) {
        const Json &contact = report["contact"];
        html += plot("Force of the wall on the line, N", numbers(contact, "time_s"),
                     {{"all contacts", "#b3261e", numbers(contact, "force_N")}});
    }
    return html.empty() ? "" : "<h2>Over time</h2>\n" + html;
}

std::string metrics_table(const Json &score)
{
    std::string html =
        "<table><tr><th>Metric</th><th class=n>Value</th><th class=n>Full marks</th><th class=n>None</th>"
        "<th class=n>Points</th><th></th></tr>\n";
    for (const Json &metric : score["metrics"]) {
        const bool has_weight = metric.contains("weight"), has_points = metric["points"].is_number();
        const double share =
            has_points ? metric["points"].get<double>() / metric["weight"].get<double>() : 1.0;
        const char *mark = !has_points ? "" : share > 0.999 ? " good" : share < 0.5 ? " bad" : "";
        html += "<tr><td>" + text_at(metric, "title") + "</td><td class=n>" + figure(metric["value"]) + " " +
                text_at(metric, "unit") + "</td>";
        html += "<td class=n>" + (has_weight ? formatted("%g", metric["full_marks_at"].get<double>()) : "") +
                "</td><td class=n>" +
                (has_weight ? formatted("%g", metric["no_marks_at"].get<double>()) : "") +
                "</td><td class=\"n" + mark + "\">" +
                (has_points
                     ? formatted("%.1f of %g", metric["points"].get<double>(), metric["weight"].get<double>())
                 : has_weight ? "not known"
                              : "") +
                "</td><td class=soft>" + text_at(metric, "remark") + "</td></tr>\n";
    }
    return html + "</table>\n";
}

std::string lesions_table(const Json &report)
{
    if (!report.contains("lesions") || report["lesions"].empty()) return "";
    std::string html = "<h2>Lesions</h2>\n<table><tr><th>Lesion</th><th>Branch</th><th "
                       "class=n>Before</th><th class=n>After</th>"
                       "<th class=n>Narrowest before</th><th class=n>after</th><th class=n>FFR "
                       "before</th><th class=n>after</th></tr>\n";
    for (const Json &lesion : report["lesions"]) {
        const Json after = lesion.contains("after") ? lesion["after"] : Json::object();
        const auto of = [](const Json &from, const char *key) {
            return figure(from.contains(key) ? from[key] : Json());
        };
        html += "<tr><td>" + text_at(lesion, "name") + "</td><td>" + text_at(lesion, "branch") +
                "</td><td class=n>" + of(lesion, "stenosis_diameter_pct") + " %</td><td class=n>" +
                of(after, "stenosis_diameter_pct") + " %</td><td class=n>" +
                of(lesion, "minimum_diameter_mm") + " mm</td><td class=n>" +
                of(after, "minimum_diameter_mm") + " mm</td><td class=n>" + of(lesion, "ffr") +
                "</td><td class=n>" + of(after, "ffr") + "</td></tr>\n";
    }
    return html + "</table>\n";
}

std::string stents_table(const Json &report)
{
    if (!report.contains("stents") || report["stents"].empty()) return "";
    std::string html =
        "<h2>Stents</h2>\n<table><tr><th>Stent</th><th>Branch</th><th>Stage</th><th class=n>On the wall</th>"
        "<th class=n>Inside, least</th><th class=n>Length</th></tr>\n";
    for (const Json &stent : report["stents"]) {
        const auto of = [&](const char *key) { return figure(stent.contains(key) ? stent[key] : Json()); };
        html += "<tr><td>" + text_at(stent, "name") + "</td><td>" + text_at(stent, "branch") + "</td><td>" +
                text_at(stent, "stage") + "</td><td class=n>" + of("apposed_pct") + " %</td><td class=n>" +
                of("inside_diameter_min_mm") + " mm</td><td class=n>" + of("length_now_mm") +
                " mm</td></tr>\n";
    }
    return html + "</table>\n";
}

std::string tools_table(const Json &report)
{
    std::string html = "<h2>Tools</h2>\n<table><tr><th>Tool</th><th class=n>Inserted at most</th><th "
                       "class=n>Hand's force at most</th>"
                       "<th class=n>torque</th></tr>\n";
    for (const Json &tool : report["tools"])
        html += "<tr><td>" + text_at(tool, "name") + "</td><td class=n>" + figure(tool["inserted_max_mm"]) +
                " mm</td><td class=n>" + figure(tool["handle_force_max_N"]) + " N</td><td class=n>" +
                figure(tool["handle_torque_max_mN_m"]) + " mN m</td></tr>\n";
    return html + "</table>\n";
}

} // namespace

std::string score_page(const Json &report, const Json &score, const std::vector<ScorePicture> &pictures)
{
    std::string html = page_begin("Cournand: score");
    html += "<h1>Angioplasty</h1>\n<p class=soft>Scene " + text_at(report, "scene") + ", session " +
            text_at(report, "session") + ", state " + text_at(report, "hash") + "</p>\n";
    html += "<p><span class=sum>" +
            (score["percent"].is_number() ? formatted("%.0f", score["percent"].get<double>()) : "–") +
            "</span> of 100 <span class=soft>(" + figure(score["points"]) + " points of " +
            figure(score["of"]) + " that could be judged)</span></p>\n";
    html += metrics_table(score) + lesions_table(report) + stents_table(report) + pictures_of(pictures) +
            curves_of(report) + tools_table(report);
    return html + page_end("Limits and weights are assumptions (docs/score.md). Not a medical device.");
}

void write_score_page(const std::string &path, const Json &report, const Json &score,
                      const std::vector<ScorePicture> &pictures)
{
    write_whole_file(path, score_page(report, score, pictures));
}

} // namespace crn
