// Writes the score as one HTML page that needs no other file.
#include "host/report/score_page.hpp"
#include "host/base/format.hpp"
#include "host/base/html_page.hpp"
#include "host/base/pending_file.hpp"
#include "host/report/page.hpp"
#include <nlohmann/json.hpp>

namespace crn
{

namespace
{

using Json = nlohmann::ordered_json;

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

std::string curves_of(const Json &report)
{
    std::string html;
    if (report.contains("balloon") && report["balloon"].is_object() && report["balloon"].contains("curves")) {
        const Json &curves = report["balloon"]["curves"];
        const std::vector<double> time_s = page_numbers(curves, "time_s");
        html += page_plot("Pressure, bar", time_s,
                          {{"inflator", "#1f5fa8", page_numbers(curves, "pressure_bar")}});
        html += page_plot("Balloon's diameter, mm", time_s,
                          {{"widest", "#1b6e3c", page_numbers(curves, "diameter_max_mm")},
                           {"narrowest", "#c2691c", page_numbers(curves, "diameter_min_mm")}});
        html += page_plot("Balloon's force on the wall, N", time_s,
                          {{"all round", "#7a3b9a", page_numbers(curves, "wall_force_N")}});
    }
    if (report.contains("contact") && report["contact"].is_object()) {
        const Json &contact = report["contact"];
        html += page_plot("Force of the wall on the line, N", page_numbers(contact, "time_s"),
                          {{"all contacts", "#b3261e", page_numbers(contact, "force_N")}});
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
        html += "<tr><td>" + page_text(metric, "title") + "</td><td class=n>" + page_figure(metric["value"]) +
                " " + page_text(metric, "unit") + "</td>";
        html += "<td class=n>" + (has_weight ? formatted("%g", metric["full_marks_at"].get<double>()) : "") +
                "</td><td class=n>" +
                (has_weight ? formatted("%g", metric["no_marks_at"].get<double>()) : "") +
                "</td><td class=\"n" + mark + "\">" +
                (has_points
                     ? formatted("%.1f of %g", metric["points"].get<double>(), metric["weight"].get<double>())
                 : has_weight ? "not known"
                              : "") +
                "</td><td class=soft>" + page_text(metric, "remark") + "</td></tr>\n";
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
    bool has_resting = false;
    for (const Json &lesion : report["lesions"]) {
        const Json after = lesion.contains("after") ? lesion["after"] : Json::object();
        const auto of = [](const Json &from, const char *key) {
            return page_figure(from.contains(key) ? from[key] : Json());
        };
        if (page_text(lesion, "ffr_flow") == "resting") has_resting = true;
        html += "<tr><td>" + page_text(lesion, "name") + "</td><td>" + page_text(lesion, "branch") +
                "</td><td class=n>" + of(lesion, "stenosis_diameter_pct") + " %</td><td class=n>" +
                of(after, "stenosis_diameter_pct") + " %</td><td class=n>" +
                of(lesion, "minimum_diameter_mm") + " mm</td><td class=n>" +
                of(after, "minimum_diameter_mm") + " mm</td><td class=n>" + of(lesion, "ffr") +
                "</td><td class=n>" + of(after, "ffr") + "</td></tr>\n";
    }
    html += "</table>\n";
    if (has_resting)
        html += "<p class=soft>A pressure ratio of a vessel that is not marked as a coronary artery is with "
                "resting flow, so it is no FFR.</p>\n";
    return html;
}

std::string stents_table(const Json &report)
{
    if (!report.contains("stents") || report["stents"].empty()) return "";
    std::string html =
        "<h2>Stents</h2>\n<table><tr><th>Stent</th><th>Branch</th><th>Stage</th><th class=n>On the wall</th>"
        "<th class=n>Inside, least</th><th class=n>Length</th></tr>\n";
    for (const Json &stent : report["stents"]) {
        const auto of = [&](const char *key) {
            return page_figure(stent.contains(key) ? stent[key] : Json());
        };
        html += "<tr><td>" + page_text(stent, "name") + "</td><td>" + page_text(stent, "branch") +
                "</td><td>" + page_text(stent, "stage") + "</td><td class=n>" + of("apposed_pct") +
                " %</td><td class=n>" + of("inside_diameter_min_mm") + " mm</td><td class=n>" +
                of("length_now_mm") + " mm</td></tr>\n";
    }
    return html + "</table>\n";
}

std::string tools_table(const Json &report)
{
    std::string html = "<h2>Tools</h2>\n<table><tr><th>Tool</th><th class=n>Inserted at most</th><th "
                       "class=n>Hand's force at most</th>"
                       "<th class=n>torque</th></tr>\n";
    for (const Json &tool : report["tools"])
        html += "<tr><td>" + page_text(tool, "name") + "</td><td class=n>" +
                page_figure(tool["inserted_max_mm"]) + " mm</td><td class=n>" +
                page_figure(tool["handle_force_max_N"]) + " N</td><td class=n>" +
                page_figure(tool["handle_torque_max_mN_m"]) + " mN m</td></tr>\n";
    return html + "</table>\n";
}

} // namespace

std::string score_page(const Json &report, const Json &score, const std::vector<ScorePicture> &pictures)
{
    std::string html = page_begin("Cournand: score");
    html += "<h1>Angioplasty: treatment score</h1>\n<p class=soft>Scene " + page_text(report, "scene") +
            ", session " + page_text(report, "session") + ", state " + page_text(report, "hash") + "</p>\n";
    html += "<p><span class=sum>" +
            (score["percent"].is_number() ? formatted("%.0f", score["percent"].get<double>()) : "–") +
            "</span> of 100 <span class=soft>(" + page_figure(score["points"]) + " points of " +
            page_figure(score["of"]) + " that could be judged)</span></p>\n";
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
