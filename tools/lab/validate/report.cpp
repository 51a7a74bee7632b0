#include "tools/lab/validate/report.hpp"
#include "host/base/format.hpp"
#include "host/base/number_text.hpp"

#include <algorithm>
#include <cmath>

namespace crn::validate
{

bool Row::passed() const
{
    return !is_bar() || (std::isfinite(error) && std::fabs(error) <= tolerance);
}

void Result::error(const std::string &what, const std::string &unit, double reference, double value,
                   double error_value, const std::string &error_unit, double tolerance)
{
    rows.push_back(
        {name + "." + what, formula, source, unit, reference, value, error_value, tolerance, error_unit});
}

void Result::relative(const std::string &what, const std::string &unit, double reference, double value,
                      double tolerance_pct)
{
    error(what, unit, reference, value, 100 * (value / reference - 1), "%", tolerance_pct);
}

void Result::absolute(const std::string &what, const std::string &unit, double reference, double value,
                      double tolerance)
{
    error(what, unit, reference, value, value - reference, unit, tolerance);
}

void Result::at_most(const std::string &what, const std::string &unit, double value, double bar)
{
    error(what, unit, 0, value, value, unit, bar);
}

void Result::reported(const std::string &what, const std::string &unit, double reference, double value)
{
    error(what, unit, reference, value, value - reference, unit, -1);
}

bool Result::passed() const
{
    return failure.empty() && !rows.empty() &&
           std::all_of(rows.begin(), rows.end(), [](const Row &r) { return r.passed(); });
}

namespace
{

std::string verdict(const Row &row)
{
    return !row.is_bar() ? "reported" : row.passed() ? "pass" : "FAIL";
}

std::string tolerance_text(const Row &row)
{
    return row.is_bar() ? number_text(row.tolerance, 4) : "-";
}

// Returns the error of a row divided by its tolerance; a value near 1 is close to failing.
double share(const Row &row)
{
    return row.tolerance > 0 ? std::fabs(row.error) / row.tolerance : row.passed() ? 0 : 2;
}

const char *const style =
    "body{font:15px/1.5 sans-serif;color:#222;background:#fff;max-width:1100px;margin:2em auto;padding:0 1em}"
    "table{border-collapse:collapse;margin:.6em 0}th,td{padding:2px 10px;text-align:left;border-bottom:1px "
    "solid #ddd}"
    "td.n{text-align:right;font-variant-numeric:tabular-nums}th{border-bottom:2px solid #888}"
    ".pass{color:#006b3c}.FAIL{color:#fff;background:#b00020;font-weight:bold}.reported{color:#777}"
    "h2{margin-top:2.2em;border-top:1px solid #bbb;padding-top:.6em}svg{max-width:100%;height:auto}";

std::string cell(const std::string &text, const char *kind = "")
{
    return std::string("<td") + (kind[0] ? " class='" + std::string(kind) + "'" : "") + ">" +
           html_text(text) + "</td>";
}

std::string rows_table(const Result &result)
{
    std::string out =
        "<table><tr><th>figure</th><th>unit</th><th>reference</th><th>ours</th><th>error</th><th>allowed</th>"
        "<th></th></tr>\n";
    for (const Row &row : result.rows) {
        std::string verdict_of = verdict(row);
        out += "<tr>" + cell(row.name.substr(result.name.size() + 1)) + cell(row.unit) +
               cell(number_text(row.reference, 4), "n") + cell(number_text(row.value, 4), "n") +
               cell(number_text(row.error, 4) + " " + row.error_unit, "n") +
               cell(row.is_bar() ? tolerance_text(row) + " " + row.error_unit : "-", "n") +
               cell(verdict_of, verdict_of.c_str()) + "</tr>\n";
    }
    return out + "</table>\n";
}

std::string section(const Result &result)
{
    std::string out = "<h2 id='" + result.name + "'>" + html_text(result.title) + "</h2>\n<p>" +
                      html_text(result.setup) + "</p>\n";
    out += "<p>Reference: " + html_text(result.formula) + " <small>(" + html_text(result.source) +
           ")</small></p>\n";
    if (!result.failure.empty()) out += "<p class='FAIL'>stopped: " + html_text(result.failure) + "</p>\n";
    out += rows_table(result);
    for (const Plot &plot : result.plots) out += svg(plot);
    return out;
}

const Row *worst_row(const Result &result)
{
    const Row *worst = nullptr;
    for (const Row &row : result.rows) {
        if (row.is_bar() && (!worst || share(row) > share(*worst))) worst = &row;
    }
    return worst;
}

} // namespace

std::string tsv(const std::vector<Result> &results)
{
    std::string out =
        "name\tformula\tsource\tunit\treference\tvalue\terror\ttolerance\terror_unit\tverdict\n";
    for (const Result &result : results) {
        for (const Row &row : result.rows) {
            const std::string numbers = formatted("%.9g\t%.9g\t%.6g\t", row.reference, row.value, row.error);
            out += row.name + "\t" + row.formula + "\t" + row.source + "\t" + row.unit + "\t" + numbers +
                   tolerance_text(row) + "\t" + row.error_unit + "\t" + verdict(row) + "\n";
        }
    }
    return out;
}

std::string html(const std::vector<Result> &results, const std::string &command)
{
    std::size_t figures = 0, passed = 0, bars = 0;
    std::string summary, sections;
    for (const Result &result : results) {
        for (const Row &row : result.rows) {
            figures++;
            bars += row.is_bar();
            passed += row.is_bar() && row.passed();
        }
        const Row *worst = worst_row(result);
        std::string kind = result.passed() ? "pass" : "FAIL";
        summary += "<tr><td><a href='#" + result.name + "'>" + html_text(result.title) + "</a></td>" +
                   cell(worst ? worst->name.substr(result.name.size() + 1) : "") +
                   cell(worst ? number_text(worst->error, 4) + " " + worst->error_unit : "", "n") +
                   cell(worst ? number_text(worst->tolerance, 4) + " " + worst->error_unit : "", "n") +
                   cell(kind, kind.c_str()) + "</tr>\n";
        sections += section(result);
    }
    return "<!doctype html><html lang='en'><head><meta charset='utf-8'><title>Cournand: "
           "validation</title><style>" +
           std::string(style) + "</style></head><body>\n<h1>Validation of the rod</h1>\n<p>" +
           std::to_string(passed) + " of " + std::to_string(bars) + " figures are within their tolerance, " +
           std::to_string(figures - bars) +
           " more are reported. Every reference is computed without the core, in double precision. Command: "
           "<code>" +
           html_text(command) +
           "</code></p>\n<table><tr><th>case</th><th>figure nearest to its tolerance</th><th>error</th>"
           "<th>allowed</th><th></th></tr>\n" +
           summary + "</table>\n" + sections + "</body></html>\n";
}

std::string tap(const std::vector<Result> &results)
{
    std::string out = "1.." + std::to_string(results.size()) + "\n";
    for (std::size_t i = 0; i < results.size(); i++) {
        const Result &result = results[i];
        out += (result.passed() ? "ok " : "not ok ") + std::to_string(i + 1) + " - validation " +
               result.name + ": " + result.title + "\n";
        if (!result.failure.empty()) out += "# stopped: " + result.failure + "\n";
        for (const Row &row : result.rows) {
            if (row.passed()) continue;
            out += "# " + row.name + " = " + number_text(row.value, 4) + " " + row.unit + ", reference " +
                   number_text(row.reference, 4) + ", error " + number_text(row.error, 4) + " " +
                   row.error_unit + ", allowed " + number_text(row.tolerance, 4) + "\n";
        }
    }
    return out;
}

std::string markdown(const std::vector<Result> &results)
{
    std::string out = "| case | reference | figures | nearest to its tolerance | error | allowed | "
                      "|\n|---|---|---|---|---|---|---|\n";
    for (const Result &result : results) {
        const Row *worst = worst_row(result);
        std::string unit = worst ? " " + worst->error_unit : "";
        out += "| " + result.title + " (`" + result.name + "`) | " + result.formula + " | " +
               std::to_string(result.rows.size()) + " | " +
               (worst ? worst->name.substr(result.name.size() + 1) : "-") + " | " +
               (worst ? number_text(worst->error, 4) + unit : "-") + " | " +
               (worst ? number_text(worst->tolerance, 4) + unit : "-") + " | " +
               (result.passed() ? "pass" : "**fail**") + " |\n";
    }
    return out;
}

} // namespace crn::validate
