#include "tools/lab/literature/verdict.hpp"
#include "host/base/number_text.hpp"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <limits>
#include <sstream>
#include <stdexcept>

namespace crn::literature
{

double Measured::value(const Row &row) const
{
    const auto found = figures.values.find(row.name);
    return found == figures.values.end() ? std::numeric_limits<double>::quiet_NaN() : found->second;
}

bool Measured::is_judged(const Row &row) const
{
    return table->kind == Kind::validation && !row.fitted && row.has_spread();
}

bool Measured::passed(const Row &row) const
{
    const double ours = value(row);
    return ours >= row.lowest() && ours <= row.highest(); // false for NaN
}

std::string Measured::verdict() const
{
    if (!failure.empty()) return "stopped";
    if (table->kind == Kind::input) return "input";
    for (const Row &row : table->rows)
        if (is_judged(row) && !passed(row)) return "fail";
    return "pass";
}

void check_complete(const Table &table, const Figures &figures)
{
    for (const Row &row : table.rows) {
        const auto found = figures.values.find(row.name);
        if (found == figures.values.end())
            throw std::runtime_error("the experiment gives no figure '" + row.name + "'");
        if (!std::isfinite(found->second))
            throw std::runtime_error("the figure '" + row.name + "' is no finite number");
    }
    for (const auto &figure : figures.values) {
        const auto is_its_row = [&](const Row &row) { return row.name == figure.first; };
        if (std::none_of(table.rows.begin(), table.rows.end(), is_its_row))
            throw std::runtime_error("the figure '" + figure.first + "' has no row in " + table.name +
                                     ".toml");
    }
}

std::string distance_text(const Row &row, double value)
{
    if (row.mean && row.deviation) {
        const double deviations = (value - *row.mean) / *row.deviation;
        return (deviations < 0 ? "" : "+") + number_text(deviations, 2) + " SD";
    }
    if (row.mean)
        return (value < *row.mean ? "" : "+") + number_text(100 * (value / *row.mean - 1), 2) + " %";
    if (value >= row.lowest() && value <= row.highest()) return "inside";
    const double end = value < row.lowest() ? row.lowest() : row.highest();
    if (end == 0) return number_text(value, 2) + " beyond";
    return (value < end ? "" : "+") + number_text(100 * (value / end - 1), 3) + " % beyond";
}

Expectations read_expectations(const std::string &file)
{
    std::ifstream in(file);
    if (!in) throw std::runtime_error(file + ": cannot be read; `make literature` runs where the list lies");
    Expectations all;
    std::string line;
    for (int number = 1; std::getline(in, line); number++) {
        if (line.empty() || line[0] == '#') continue;
        std::istringstream words(line);
        std::string name, verdict, more;
        words >> name >> verdict;
        if ((verdict != "pass" && verdict != "fail") || words >> more || !all.emplace(name, verdict).second)
            throw std::runtime_error(
                file + ":" + std::to_string(number) +
                ": a line is the name of a table once, and 'pass' or 'fail'; --expect writes it");
    }
    return all;
}

std::string expectations_text(const Expectations &all)
{
    std::string out =
        "# Verdicts of the published tables; `literature --expect` writes them. A table that passed and "
        "fails now is an error.\n";
    for (const auto &[name, verdict] : all) out += name + "\t" + verdict + "\n";
    return out;
}

Comparison compare(const std::vector<Measured> &all, const Expectations &expected, bool is_whole)
{
    Comparison result;
    Expectations left = expected;
    for (const Measured &one : all) {
        if (one.table->kind != Kind::validation) continue;
        const auto before = expected.find(one.table->name);
        left.erase(one.table->name);
        if (before == expected.end()) {
            result.unknown.push_back(one.table->name);
        } else if (before->second == "pass" && one.verdict() != "pass") {
            result.worse.push_back(one.table->name);
        } else if (before->second == "fail" && one.verdict() == "pass") {
            result.better.push_back(one.table->name);
        }
    }
    if (is_whole)
        for (const auto &[name, verdict] : left) result.gone.push_back(name);
    return result;
}

} // namespace crn::literature
