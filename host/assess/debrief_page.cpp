// Writes the debrief of a session as one HTML page that needs no other file and no network.
#include "host/assess/assessment.hpp"
#include "host/base/format.hpp"
#include "host/base/html_page.hpp"
#include "host/base/pending_file.hpp"
#include "host/report/page.hpp"
#include <algorithm>
#include <nlohmann/json.hpp>

namespace crn
{

namespace
{

using Json = nlohmann::ordered_json;

const char *const debrief_style =
    ".part{display:grid;grid-template-columns:14em 1fr 8em;gap:.6em;align-items:center;margin:.2em 0}"
    ".bar{background:#e6ebf1;height:.8em}.bar div{background:#1f5fa8;height:100%}"
    ".w5{color:#b3261e;font-weight:600}.w4{color:#9a4a00;font-weight:600}.w3{color:#5a5200}"
    "tr:target td{background:#fff3c4}svg{max-width:100%;height:auto}details{margin:1em 0}"
    "td.t{white-space:nowrap}";

// Severities have a colour and a letter, so that they also differ in black-and-white print.
const char *colour_of(int weight)
{
    return weight >= 5 ? "#b3261e" : weight == 4 ? "#c2691c" : "#8a7d00";
}
const char *letter_of(int weight)
{
    return weight >= 5 ? "L" : weight == 4 ? "S" : "M";
}

std::string clock_text(double seconds)
{
    const int tenths = static_cast<int>(seconds * 10.0 + 0.5);
    return formatted("%d:%02d.%d", tenths / 600, tenths / 10 % 60, tenths % 10);
}

std::string clock_of(const Json &tick)
{
    return tick.is_number() ? clock_text(tick.get<double>() * 1e-3) : "–";
}

std::string score_part(const Json &score)
{
    std::string html =
        "<p><span class=sum>" +
        (score["percent"].is_number() ? formatted("%.0f", score["percent"].get<double>()) : "–") +
        "</span> of 100";
    if (score["capped_by"].is_string())
        html += " <span class=bad>limited by " + page_text(score, "capped_by") + "</span>";
    html += "</p>\n";
    for (const Json &part : score["parts"]) {
        const bool applies = part["share"].is_number();
        const double share = applies ? part["share"].get<double>() : 0.0,
                     weight = part["weight"].get<double>();
        html += "<div class=part><span>" + page_text(part, "title") + "</span><div class=bar>" +
                formatted("<div style=\"width:%.1f%%\"></div></div><span class=soft>", share * 100.0) +
                (applies ? formatted("%.1f of %g", share * weight, weight) : "does not apply") +
                "</span></div>\n";
    }
    return html;
}

std::string errors_part(const Json &assessment)
{
    if (assessment["errors"].empty())
        return "<h2>Errors</h2>\n<p class=good>No handling error was found.</p>\n";
    std::string html = "<h2>Errors</h2>\n<table><tr><th>Severity</th><th>At</th><th class=n>Lasted</th>"
                       "<th>What happened</th><th>What helps</th></tr>\n";
    int number = 0;
    for (const Json &error : assessment["errors"]) {
        const int weight = error["weight"].get<int>();
        html += formatted("<tr id=\"e%d\"><td class=\"t w%d\">%s %s</td><td class=t>", ++number, weight,
                          letter_of(weight), page_text(error, "severity").c_str()) +
                clock_text(error["at_s"].get<double>()) +
                formatted("</td><td class=n>%.1f s</td><td>", error["seconds"].get<double>()) +
                page_text(error, "title") +
                (error["counts"] == true ? "" : " <span class=soft>(no longer counted)</span>") +
                "</td><td class=soft>" + page_text(error, "advice") + "</td></tr>\n";
    }
    return html + "</table>\n";
}

// --- the timeline ---

constexpr double chart_left_px = 96.0, chart_width_px = 960.0, chart_row_px = 26.0;

double place_of(double seconds, double end_s)
{
    return chart_left_px + (chart_width_px - chart_left_px - 8.0) * (end_s > 0.0 ? seconds / end_s : 0.0);
}

std::string band(double from_s, double to_s, double end_s, double top, const char *colour,
                 const std::string &title)
{
    const double x = place_of(from_s, end_s);
    return formatted("<rect x=\"%.1f\" y=\"%.1f\" width=\"%.1f\" height=\"16\" fill=\"%s\"><title>", x, top,
                     std::max(1.0, place_of(to_s, end_s) - x), colour) +
           title + "</title></rect>";
}

// Draws one band for every part of the curve in which the value is at least `least`.
std::string bands_of(const std::vector<double> &time_s, const std::vector<double> &values, double least,
                     double end_s, double top, const char *colour, const std::string &title)
{
    std::string svg;
    for (std::size_t i = 0; i < values.size(); ++i) {
        if (values[i] < least) continue;
        std::size_t end = i;
        while (end < values.size() && values[end] >= least) ++end;
        svg += band(time_s[i], end < time_s.size() ? time_s[end] : end_s, end_s, top, colour, title);
        i = end;
    }
    return svg;
}

std::string label(double top, const char *text)
{
    return formatted("<text x=\"%.0f\" y=\"%.0f\" text-anchor=\"end\">%s</text>", chart_left_px - 8.0,
                     top + 12.0, text);
}

std::string error_marks(const Json &errors, double end_s, double top)
{
    std::string svg;
    int number = 0;
    for (const Json &error : errors) {
        const int weight = error["weight"].get<int>();
        const double x = place_of(error["at_s"].get<double>(), end_s);
        svg += formatted("<a href=\"#e%d\"><rect x=\"%.1f\" y=\"%.1f\" width=\"14\" height=\"16\" rx=\"3\" "
                         "fill=\"%s\"/><text x=\"%.1f\" y=\"%.1f\" style=\"fill:#fff;font-weight:600\" "
                         "text-anchor=\"middle\">%s</text><title>",
                         ++number, x - 7.0, top, colour_of(weight), x, top + 12.0, letter_of(weight)) +
               clock_text(error["at_s"].get<double>()) + " " + page_text(error, "title") + "</title></a>";
    }
    return svg;
}

std::string phase_bands(const Json &phases, double end_s, double top)
{
    std::string svg;
    int number = 0;
    for (const Json &phase : phases) {
        ++number;
        if (!phase["begin_tick"].is_number()) continue;
        const double from_s = phase["begin_tick"].get<double>() * 1e-3;
        const bool has_end = phase["end_tick"].is_number();
        const double to_s = has_end ? phase["end_tick"].get<double>() * 1e-3 : end_s;
        svg += band(from_s, to_s, end_s, top,
                    !has_end     ? "#c9ced6"
                    : number % 2 ? "#8fb3dd"
                                 : "#b9d0ea",
                    page_text(phase, "title"));
        svg += formatted("<text x=\"%.1f\" y=\"%.1f\" style=\"fill:#1c2530\">%d</text>",
                         place_of(from_s, end_s) + 3.0, top + 12.0, number);
    }
    return svg;
}

std::string timeline_part(const Json &assessment)
{
    const Json &curves = assessment["curves"];
    const double end_s = assessment["ticks"].get<double>() * 1e-3;
    const std::vector<double> time_s = page_numbers(curves, "time_s"), xray = page_numbers(curves, "xray");
    std::vector<double> injecting = page_numbers(curves, "injected_ml");
    for (std::size_t i = injecting.size(); i-- > 0;)
        injecting[i] = i > 0 && injecting[i] > injecting[i - 1] ? 1.0 : 0.0;
    std::string svg = formatted("<svg viewBox=\"0 0 %.0f %.0f\" width=\"%.0f\" role=\"img\" "
                                "aria-label=\"Timeline\">",
                                chart_width_px, 6.5 * chart_row_px, chart_width_px);
    svg += label(0, "errors") + error_marks(assessment["errors"], end_s, 0);
    svg += label(chart_row_px, "phases") + phase_bands(assessment["phases"], end_s, chart_row_px);
    svg += label(2 * chart_row_px, "fluoroscopy") +
           bands_of(time_s, xray, 1, end_s, 2 * chart_row_px, "#e0c341", "fluoroscopy");
    svg += bands_of(time_s, xray, 2, end_s, 2 * chart_row_px, "#8a5a00", "cine or DSA run");
    svg += label(3 * chart_row_px, "contrast") +
           bands_of(time_s, injecting, 1, end_s, 3 * chart_row_px, "#4a4a4a", "contrast");
    svg += label(4 * chart_row_px, "balloon") + bands_of(time_s, page_numbers(curves, "balloon_bar"), 0.5,
                                                         end_s, 4 * chart_row_px, "#1b6e3c", "balloon");
    const double step_s = std::max(1.0, axis_step(end_s));
    for (double s = 0.0; s <= end_s; s += step_s)
        svg += formatted("<text x=\"%.1f\" y=\"%.1f\" text-anchor=\"middle\">%.0f s</text>",
                         place_of(s, end_s), 5.6 * chart_row_px, s);
    return "<h2>Timeline</h2>\n" + svg +
           "</svg>\n<p class=soft>Errors: M moderate, S serious, L life-threatening. A mark leads to its "
           "line in the "
           "table. Dark bands of the X-ray are cine or DSA runs.</p>\n";
}

// --- tables ---

std::string phases_part(const Json &phases)
{
    if (phases.empty()) return "";
    std::string html = "<h2>Phases and steps</h2>\n<table><tr><th></th><th>Phase, step</th><th>Began</th>"
                       "<th>Done</th></tr>\n";
    int number = 0;
    for (const Json &phase : phases) {
        const bool applies = !phase["why_not"].is_string();
        const char *mark = !applies ? "soft" : phase["end_tick"].is_number() ? "good" : "bad";
        html += formatted("<tr><td>%d</td><td><b>", ++number) + page_text(phase, "title") + "</b></td><td>" +
                clock_of(phase["begin_tick"]) + formatted("</td><td class=\"%s\">", mark) +
                (applies ? phase["end_tick"].is_number() ? clock_of(phase["end_tick"]) : "not reached"
                         : "does not apply: " + page_text(phase, "why_not")) +
                "</td></tr>\n";
        for (const Json &step : phase["steps"]) {
            const bool is_done = step["done_tick"].is_number();
            html += "<tr><td></td><td>" + page_text(step, "title") + "</td><td></td><td class=\"" +
                    (is_done                       ? "good\">" + clock_of(step["done_tick"])
                     : step["why_not"].is_string() ? "soft\">does not apply: " + page_text(step, "why_not")
                                                   : "bad\">not done") +
                    "</td></tr>\n";
        }
    }
    return html + "</table>\n";
}

std::string metrics_part(const Json &metrics)
{
    std::string html = "<h2>Result and burden</h2>\n<table><tr><th>Metric</th><th class=n>Value</th>"
                       "<th class=n>Full marks at</th><th class=n>None at</th><th class=n>Marks</th></tr>\n";
    for (const Json &metric : metrics) {
        if (!metric["value"].is_number()) continue;
        const bool has_points = metric["points"].is_number();
        html += "<tr><td>" + page_text(metric, "title") + "</td><td class=n>" + page_figure(metric["value"]) +
                " " + page_text(metric, "unit") + "</td>";
        html += has_points
                    ? formatted("<td class=n>%g</td><td class=n>%g</td><td class=n>%.1f of %g</td></tr>\n",
                                metric["full_marks_at"].get<double>(), metric["no_marks_at"].get<double>(),
                                metric["points"].get<double>(), metric["weight"].get<double>())
                    : "<td></td><td></td><td class=\"n soft\">shown only</td></tr>\n";
    }
    return html + "</table>\n";
}

std::string motion_part(const Json &tools)
{
    std::string html =
        "<h2>Motion</h2>\n<table><tr><th>Tool</th><th class=n>Hand's path</th><th class=n>Tip's path</th>"
        "<th class=n>in the picture</th><th class=n>Movements</th><th class=n>Submovements</th>"
        "<th class=n>SPARC</th><th class=n>LDLJ</th><th class=n>Hand force, most</th></tr>\n";
    for (const Json &tool : tools)
        html += "<tr><td>" + page_text(tool, "name") + "</td><td class=n>" +
                page_figure(tool["hand_path_mm"]) + " mm</td><td class=n>" +
                page_figure(tool["tip_path_mm"]) + " mm</td><td class=n>" + page_figure(tool["tip_path_px"]) +
                " px</td><td class=n>" +
                formatted("%d</td><td class=n>%d</td><td class=n>", tool["movements"].get<int>(),
                          tool["submovements"].get<int>()) +
                page_figure(tool["sparc"]) + "</td><td class=n>" + page_figure(tool["ldlj"]) +
                "</td><td class=n>" + page_figure(tool["hand_force_max_N"]) + " N</td></tr>\n";
    return html +
           "</table>\n<p class=soft>SPARC and LDLJ are nearer to zero when the hand moves more smoothly. "
           "Motion is shown and costs no marks.</p>\n";
}

std::string curves_part(const Json &assessment)
{
    static const char *const colours[] = {"#1f5fa8", "#c2691c", "#1b6e3c"};
    const Json &curves = assessment["curves"];
    const std::vector<double> time_s = page_numbers(curves, "time_s");
    std::vector<PageCurve> inserted;
    std::vector<std::string> names; // the curves keep pointers to them
    for (const Json &tool : assessment["tools"]) names.push_back(page_text(tool, "name"));
    for (std::size_t k = 0; k < names.size() && k < std::size(colours); ++k) {
        std::vector<double> values = curves["inserted_mm"][k].get<std::vector<double>>();
        inserted.push_back({names[k].c_str(), colours[k], std::move(values)});
    }
    return "<h2>Curves</h2>\n" + page_plot("Inserted length, mm", time_s, inserted) +
           page_plot("Kerma-area product, Gy cm²", time_s,
                     {{"since the start", "#8a5a00", page_numbers(curves, "kap_Gy_cm2")}}) +
           page_plot("Contrast medium, ml", time_s,
                     {{"since the start", "#4a4a4a", page_numbers(curves, "injected_ml")}}) +
           page_plot("Pressure of the balloon, bar", time_s,
                     {{"inflator", "#1b6e3c", page_numbers(curves, "balloon_bar")}}) +
           page_plot("Force of the walls, N", time_s,
                     {{"all contacts", "#b3261e", page_numbers(curves, "wall_N")}});
}

std::string rules_part(const Json &kinds)
{
    std::string html =
        "<details><summary>Rules of the plan and their sources</summary>\n<table><tr><th>Rule</th>"
        "<th>Counted when</th><th class=n>Found</th><th>Source</th></tr>\n";
    for (const Json &kind : kinds)
        html += "<tr><td>" + page_text(kind, "title") + "</td><td>" + page_text(kind, "when") +
                formatted(", for %g s</td><td class=n>", kind["for_s"].get<double>()) +
                (kind["why_not"].is_string() ? "does not apply: " + page_text(kind, "why_not")
                                             : formatted("%d", kind["count"].get<int>())) +
                "</td><td class=soft>" + page_text(kind, "source") + "</td></tr>\n";
    return html + "</table></details>\n";
}

} // namespace

std::string debrief_page(const Json &assessment)
{
    std::string html = page_begin("Cournand: debrief", debrief_style);
    html += "<h1>" + page_text(assessment, "title") + "</h1>\n<p class=soft>Scene " +
            page_text(assessment, "scene") + ", session " + page_text(assessment, "session") + ", length " +
            clock_text(assessment["ticks"].get<double>() * 1e-3) + ", state " +
            page_text(assessment, "hash") + "</p>\n";
    html += errors_part(assessment) + timeline_part(assessment) + "<h2>Score</h2>\n" +
            score_part(assessment["score"]) + phases_part(assessment["phases"]) +
            metrics_part(assessment["metrics"]) + motion_part(assessment["tools"]) + curves_part(assessment) +
            rules_part(assessment["error_kinds"]);
    return html +
           "<p class=soft>Formulas, limits and sources: docs/assessment.md. Not a medical device.</p>\n"
           "</body></html>\n";
}

void write_debrief(const std::string &path, const Json &assessment)
{
    write_whole_file(path, debrief_page(assessment));
}

} // namespace crn
