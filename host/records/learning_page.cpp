#include "host/records/learning_page.hpp"
#include "host/base/format.hpp"
#include "host/base/html_page.hpp"
#include "host/base/number_text.hpp"
#include "host/records/learning_chart.hpp"
#include <algorithm>
#include <cmath>
#include <map>

namespace crn
{

namespace
{

// The colours of the curves have a contrast ratio of at least 4.5 to white; each kind of line also has its
// own dash pattern.
constexpr const char *own = "#1f5fa8", *expert = "#1b6e3c", *cohort = "#a8560f", *alarm = "#b3261e";
constexpr const char *expert_dash = "8 4", *cohort_dash = "2 4";

std::string figure(double value, const std::string &unit)
{
    const double size = std::fabs(value);
    return trimmed_text(value, size >= 100.0  ? 0
                               : size >= 10.0 ? 1
                                              : 2) +
           (unit.empty() ? "" : " " + html_text(unit));
}

std::string key(const char *colour, const char *dash, const std::string &what)
{
    return formatted("<span style=\"white-space:nowrap;margin-right:1em\"><svg width=\"30\" height=\"8\" "
                     "aria-hidden=\"true\"><line x1=\"0\" x2=\"30\" y1=\"4\" y2=\"4\" stroke=\"%s\" "
                     "stroke-width=\"2\" "
                     "stroke-dasharray=\"%s\"/></svg> ",
                     colour, dash) +
           what + "</span>";
}

void add_others(LearningChart &chart, const LearningCurve &curve)
{
    if (curve.expert) {
        chart.area(curve.expert->low, curve.expert->high, expert);
        chart.level(curve.expert->median, expert, expert_dash, "");
    }
    std::vector<double> low, median, high;
    for (const CohortStep &step : curve.cohort)
        low.push_back(step.low), median.push_back(step.median), high.push_back(step.high);
    if (low.empty()) return;
    chart.band(low, high, cohort, 0.15);
    chart.line(median, cohort, cohort_dash);
}

std::string keys_of(const LearningCurve &curve, bool has_own)
{
    std::string html = "<p class=soft>";
    if (has_own)
        html += key(own, "",
                    curve.fit ? "sessions (dots), fitted curve and its 95 % band"
                              : formatted("sessions; a curve needs %zu", fit_sessions_min));
    if (curve.expert)
        html += key(expert, expert_dash,
                    formatted("experts: median and range of %zu session%s", curve.expert->sessions,
                              curve.expert->sessions == 1 ? "" : "s"));
    html += curve.cohort.empty() ? formatted("No cohort: it needs at least %zu people.", cohort_people_min)
                                 : key(cohort, cohort_dash, "cohort: median and middle half");
    return html + "</p>\n";
}

std::string title_of(const LearningCurve &curve)
{
    static const std::map<std::string, std::string> titles{
        {"score", "Score"}, {"errors", "Errors"}, {"duration_s", "Time"}};
    const auto title = titles.find(curve.metric);
    return title == titles.end() ? curve.metric : title->second;
}

// Returns a sentence that says what the curve shows, for readers who do not read charts.
std::string sentence_of(const LearningCurve &curve)
{
    if (curve.points.empty()) return "No session has this figure.";
    const std::size_t count = curve.points.size();
    std::string text = "First session " + figure(curve.points.front().value, curve.unit) + ", latest " +
                       figure(curve.points.back().value, curve.unit);
    if (curve.fit)
        text += "; the fitted curve is now at " + figure(curve.fit->value.back(), curve.unit) +
                " (95 % band " + figure(curve.fit->low.back(), "") + " to " +
                figure(curve.fit->high.back(), curve.unit) + ")";
    if (curve.expert) text += "; experts have " + figure(curve.expert->median, curve.unit);
    for (const CohortStep &step : curve.cohort)
        if (step.attempt == count)
            text += formatted("; %zu people had ", step.people) + figure(step.median, curve.unit) +
                    formatted(" at their session %zu", count);
    return text + ".";
}

std::string own_chart(const LearningCurve &curve)
{
    LearningChart chart(title_of(curve) + " by session", curve.unit,
                        std::max(curve.points.size(), curve.cohort.size()));
    add_others(chart, curve);
    std::vector<double> values;
    std::vector<std::string> labels;
    for (std::size_t i = 0; i < curve.points.size(); i++) {
        values.push_back(curve.points[i].value);
        labels.push_back(formatted("session %zu, ", i + 1) + curve.points[i].started_at.substr(0, 10) + ": " +
                         figure(curve.points[i].value, curve.unit));
    }
    if (curve.fit) {
        chart.band(curve.fit->low, curve.fit->high, own, 0.2);
        chart.line(curve.fit->value, own);
    }
    chart.dots(values, labels, own);
    return "<h2>" + html_text(title_of(curve)) + "</h2>\n<p>" + sentence_of(curve) + "</p>\n" +
           keys_of(curve, true) + chart.svg();
}

std::string cusum_chart(const TraineePage &page)
{
    const Cusum &cusum = page.cusum;
    if (cusum.learning.empty()) return "";
    std::string html = "<h2>Competence (CUSUM)</h2>\n<p>";
    html += cusum.competent_at
                ? formatted("<b class=good>The sum reached its limit at session %zu</b>: so many "
                            "successes are rare for somebody who fails in %g %% of sessions.",
                            *cusum.competent_at + 1, 100.0 * cusum.settings.rate_bad)
                : std::string("The sum has not reached its limit yet: more sessions are needed.");
    for (std::size_t relapse : cusum.relapses)
        html += formatted(" <b class=bad>Relapse signalled at session %zu.</b>", relapse + 1);
    html += "</p>\n<p class=soft>" + key(own, "", "learning: rises with each passed session");
    if (cusum.competent_at) html += key(alarm, cohort_dash, "relapse: rises with each failed session");
    html += formatted("Acceptable rate of failures %g %%, unacceptable %g %%.</p>\n",
                      100.0 * cusum.settings.rate_good, 100.0 * cusum.settings.rate_bad);
    LearningChart chart("Sums of the learning-curve CUSUM", "", cusum.learning.size());
    chart.level(cusum.learning_limit, own, expert_dash, "competent");
    chart.line(cusum.learning, own);
    if (cusum.competent_at) {
        chart.level(cusum.relapse_limit, alarm, expert_dash, "relapse");
        chart.line(cusum.relapse, alarm, cohort_dash);
    }
    return html + chart.svg();
}

std::string sessions_table(const TraineePage &page)
{
    std::string html =
        "<h2>Sessions</h2>\n<table><tr><th class=n>No.</th><th>Begun (UTC)</th><th class=n>Time</th>"
        "<th class=n>Score</th><th>Passed</th><th>Errors</th></tr>\n";
    for (std::size_t i = 0; i < page.sessions.size(); i++) {
        const SessionRecord &session = page.sessions[i];
        std::map<std::string, int> errors;
        for (const SessionEvent &event : session.events)
            if (event.severity > 0) errors[event.kind]++;
        std::string list;
        for (const auto &[kind, count] : errors)
            list +=
                (list.empty() ? "" : ", ") + html_text(kind) + (count > 1 ? formatted(" × %d", count) : "");
        const auto score = session.metric("score");
        const auto passed = is_passed(session, page.pass_score_pct);
        const long long seconds = std::llround(session.duration_s);
        html += formatted("<tr><td class=n>%zu</td><td>", i + 1) + session.started_at.substr(0, 10) + " " +
                session.started_at.substr(11, 5) +
                formatted("</td><td class=n>%lld:%02lld</td><td class=n>", seconds / 60, seconds % 60) +
                (score ? decimals_text(*score, 0) + " %" : "–") + "</td><td>" +
                (passed ? *passed ? "<span class=good>yes</span>" : "<span class=bad>no</span>" : "–") +
                "</td><td>" + (list.empty() ? "none" : list) + "</td></tr>\n";
    }
    return html + "</table>\n";
}

std::string cohort_table(const LearningCurve &curve)
{
    std::string html =
        "<table><tr><th class=n>Session</th><th class=n>People</th><th class=n>Lower quartile</th>"
        "<th class=n>Median</th><th class=n>Upper quartile</th></tr>\n";
    for (const CohortStep &step : curve.cohort)
        html +=
            formatted("<tr><td class=n>%zu</td><td class=n>%zu</td><td class=n>", step.attempt, step.people) +
            figure(step.low, curve.unit) + "</td><td class=n>" + figure(step.median, curve.unit) +
            "</td><td class=n>" + figure(step.high, curve.unit) + "</td></tr>\n";
    return html + "</table>\n";
}

} // namespace

std::string trainee_page(const TraineePage &page)
{
    std::string html = page_begin("Cournand: " + page.trainee + ", " + page.case_id);
    html += "<h1>" + html_text(page.trainee) + "</h1>\n<p class=soft>Curve of learning in the case " +
            html_text(page.case_id) +
            formatted(", %zu session%s</p>\n", page.sessions.size(), page.sessions.size() == 1 ? "" : "s");
    for (const LearningCurve &curve : page.curves) html += own_chart(curve);
    html += cusum_chart(page) + sessions_table(page);
    return html +
           page_end(
               "Methods and their sources are in docs/records.md. A curve over few sessions is uncertain; "
               "the band shows by how much. Not a medical device.");
}

std::string cohort_page(const CohortPage &page)
{
    std::string html = page_begin("Cournand: cohort, " + page.case_id);
    html += "<h1>" + html_text(page.group.empty() ? "All trainees" : page.group) +
            "</h1>\n<p class=soft>Case " + html_text(page.case_id) +
            formatted(", %zu people, %zu sessions</p>\n", page.people, page.sessions);
    for (const LearningCurve &curve : page.curves) {
        html += "<h2>" + html_text(title_of(curve)) + "</h2>\n" + keys_of(curve, false);
        if (curve.cohort.empty()) continue;
        LearningChart chart(title_of(curve) + " of the cohort by session", curve.unit, curve.cohort.size());
        add_others(chart, curve);
        html += chart.svg() + cohort_table(curve);
    }
    return html + page_end(formatted(
                      "A session's number is shown only where at least %zu people have played the case "
                      "so often, so that nobody can be recognised. Not a medical device.",
                      cohort_people_min));
}

} // namespace crn
