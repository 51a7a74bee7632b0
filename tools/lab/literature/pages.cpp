#include "tools/lab/literature/pages.hpp"
#include "host/base/number_text.hpp"

#include <algorithm>
#include <cmath>
#include <sstream>

namespace crn::literature
{

namespace
{

std::string end_text(double end)
{
    return std::isfinite(end) ? number_text(end, 4) : "-";
}

std::string kind_text(Kind kind)
{
    return kind == Kind::validation ? "validation" : kind == Kind::input ? "input" : "not reproducible";
}

std::string verdict_of(const Measured &one, const Row &row)
{
    if (!one.failure.empty()) return "stopped";
    if (row.fitted || one.table->kind == Kind::input) return "input";
    return one.passed(row) ? "pass" : "fail";
}

std::size_t count(const std::vector<Measured> &all, const std::string &verdict)
{
    return std::size_t(
        std::count_if(all.begin(), all.end(), [&](const Measured &one) { return one.verdict() == verdict; }));
}

std::string bold_failure(const std::string &verdict)
{
    return verdict == "fail" || verdict == "stopped" ? "**" + verdict + "**" : verdict;
}

std::string identified(const Table &table)
{
    return table.source + " (" + table.identifier + ")";
}

// Counts letters, not bytes of UTF-8.
std::size_t letters(const std::string &text)
{
    return std::size_t(std::count_if(text.begin(), text.end(), [](char c) { return (c & 0xC0) != 0x80; }));
}

// Wraps an item of a list, as the documents of the repository are wrapped.
std::string item(const std::string &text)
{
    constexpr std::size_t line_letters = 120;
    std::string out, line = "-";
    std::istringstream words(text);
    for (std::string word; words >> word;) {
        if (letters(line) + 1 + letters(word) > line_letters) {
            out += line + "\n";
            line = " ";
        }
        line += " " + word;
    }
    return out + line + "\n";
}

std::string section(const Measured &one)
{
    const Table &table = *one.table;
    std::string out = "### " + table.title + "\n`" + table.name + "`, **" + one.verdict() + "**\n\n";
    out += item("**Source.** " + identified(table));
    out += item("**Experiment.** " + table.experiment);
    out += item("**Simulation.** " + table.simulation);
    out += item("**Spread.** " + table.spread);
    out += item("**Result.** " + table.comment) + "\n";
    if (!one.failure.empty()) return out + "The experiment stopped: " + one.failure + "\n\n";
    out += "| figure | unit | published | ours | distance | |\n|---|---|---|---|---|---|\n";
    for (const Row &row : table.rows) {
        const double ours = one.value(row);
        out += "| " + row.what + " | " + row.unit + " | " + row.published() + " | " + number_text(ours, 4) +
               " | " + distance_text(row, ours) + " | " + bold_failure(verdict_of(one, row)) + " |\n";
    }
    return out + "\n";
}

std::string sections(const std::vector<Measured> &all, Kind kind)
{
    std::string out;
    for (const Measured &one : all)
        if (one.table->kind == kind) out += section(one);
    return out;
}

} // namespace

std::string tsv(const std::vector<Measured> &all, bool is_whole)
{
    std::string out = "name\tvalue\tunit\tkind\tpublished\tlowest\thighest\tdistance\tverdict\n";
    for (const Measured &one : all) {
        for (const Row &row : one.table->rows) {
            const double ours = one.value(row);
            out += one.table->name + "." + row.name + "\t" + number_text(ours, 4) + "\t" + row.unit + "\t" +
                   kind_text(one.table->kind) + "\t" + row.published() + "\t" + end_text(row.lowest()) +
                   "\t" + end_text(row.highest()) + "\t" + distance_text(row, ours) + "\t" +
                   verdict_of(one, row) + "\n";
        }
    }
    if (!is_whole) return out;
    // Four columns, as in out/bench.tsv.
    out += "literature.tables\t" + std::to_string(all.size()) + "\ttables\t\n";
    out += "literature.validations\t" + std::to_string(all.size() - count(all, "input")) + "\ttables\t\n";
    out += "literature.passed\t" + std::to_string(count(all, "pass")) + "\ttables\t\n";
    out +=
        "literature.failed\t" + std::to_string(count(all, "fail") + count(all, "stopped")) + "\ttables\t\n";
    return out;
}

std::string markdown(const std::vector<Measured> &all, const std::vector<Table> &tables)
{
    const std::size_t inputs = count(all, "input");
    std::string out = std::to_string(all.size()) + " published tables are run; " + std::to_string(inputs) +
                      " of them are inputs. Of the other " + std::to_string(all.size() - inputs) +
                      " tables, " + std::to_string(count(all, "pass")) + " pass and " +
                      std::to_string(count(all, "fail") + count(all, "stopped")) + " fail.\n\n";
    out += "| table | source | figures | judged | outside | |\n|---|---|---|---|---|---|\n";
    for (const Measured &one : all) {
        std::size_t judged = 0, outside = 0;
        for (const Row &row : one.table->rows) {
            if (!one.is_judged(row)) continue;
            judged++;
            outside += !one.passed(row);
        }
        out += "| " + one.table->title + " (`" + one.table->name + "`) | " + identified(*one.table) + " | " +
               std::to_string(one.table->rows.size()) + " | " + std::to_string(judged) + " | " +
               std::to_string(outside) + " | " + bold_failure(one.verdict()) + " |\n";
    }
    out += "\n## Validations\n" + sections(all, Kind::validation);
    out += "## Inputs, not validation\nHere the published figure is an input of the simulator, or the "
           "simulator was "
           "adjusted to it. The\nexperiment shows only that the input comes out again.\n\n" +
           sections(all, Kind::input);
    out += "## Not reproducible\n";
    for (const Table &table : tables) {
        if (table.kind != Kind::not_reproducible) continue;
        out += item("**" + table.title + ".** " + identified(table) + ". " + table.experiment + " " +
                    table.comment);
    }
    return out;
}

} // namespace crn::literature
