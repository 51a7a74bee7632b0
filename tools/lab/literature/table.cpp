#include "tools/lab/literature/table.hpp"
#include "host/base/number_text.hpp"
#include "host/base/toml_reader.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <stdexcept>

namespace crn::literature
{

namespace
{

constexpr NumberRange any_number{-1e9, 1e9};

std::optional<double> optional_number(const TomlTable &table, const std::string &key)
{
    if (!table.has(key)) return std::nullopt;
    return table.number(key, any_number);
}

Row read_row(const TomlTable &table, Kind kind)
{
    table.check_keys({"name", "what", "unit", "mean", "deviation", "low", "high", "fitted"});
    Row row;
    row.name = table.words("name");
    row.what = table.words("what");
    row.unit = table.words("unit");
    row.mean = optional_number(table, "mean");
    row.deviation = optional_number(table, "deviation");
    row.low = optional_number(table, "low");
    row.high = optional_number(table, "high");
    row.fitted = table.has("fitted") && table["fitted"].truth();
    const bool is_range = row.low || row.high;
    if (is_range && (row.mean || row.deviation))
        table.fail("state either 'mean' and 'deviation', or 'low' and 'high'");
    if (!is_range && !row.mean) table.fail("no published figure: state 'mean', or 'low' and 'high'");
    if (row.low && row.high && !(*row.low < *row.high)) table.fail("'low' must be below 'high'");
    if (row.deviation && !(*row.deviation > 0)) table.fail("'deviation' must be above 0");
    if (kind == Kind::validation && !row.fitted && !row.has_spread())
        table.fail(
            "a figure without a published spread cannot be judged: leave it out, or say fitted = true");
    return row;
}

Table read_table(const std::filesystem::path &file)
{
    const TomlTable root =
        read_toml(file.string(), {"a published table", "a file of tools/lab/literature/tables"});
    root.check_keys(
        {"title", "kind", "source", "identifier", "experiment", "simulation", "spread", "comment", "row"});
    Table table;
    table.name = file.stem().string();
    table.title = root.words("title");
    const std::string kind = root["kind"].one_of({"validation", "input", "not reproducible"});
    table.kind = kind == "validation" ? Kind::validation
                 : kind == "input"    ? Kind::input
                                      : Kind::not_reproducible;
    table.source = root.words("source");
    table.identifier = root.words("identifier");
    table.experiment = root.words("experiment");
    table.simulation = root.words("simulation");
    table.spread = root.words("spread");
    table.comment = root.words("comment");
    for (const TomlTable &row : root.tables("row")) {
        table.rows.push_back(read_row(row, table.kind));
        const std::string &name = table.rows.back().name;
        if (std::count_if(table.rows.begin(), table.rows.end(),
                          [&](const Row &other) { return other.name == name; }) > 1)
            row.fail("the name '" + name + "' occurs twice");
    }
    const bool is_run = table.kind != Kind::not_reproducible;
    if (is_run && table.rows.empty()) root.fail_file("no [[row]]: a table needs at least one figure");
    if (!is_run && !table.rows.empty()) root.fail_file("a table that is not reproducible has no [[row]]");
    return table;
}

} // namespace

double Row::lowest() const
{
    if (mean) return deviation ? *mean - deviations_allowed * *deviation : -INFINITY;
    return low.value_or(-INFINITY);
}

double Row::highest() const
{
    if (mean) return deviation ? *mean + deviations_allowed * *deviation : INFINITY;
    return high.value_or(INFINITY);
}

std::string Row::published() const
{
    if (mean && deviation) return number_text(*mean, 4) + " ± " + number_text(*deviation, 3);
    if (mean) return number_text(*mean, 4);
    if (low && high) return number_text(*low, 4) + " to " + number_text(*high, 4);
    return low ? "at least " + number_text(*low, 4) : "at most " + number_text(*high, 4);
}

std::vector<Table> read_tables(const std::string &folder)
{
    std::vector<std::filesystem::path> files;
    std::error_code ignored;
    for (const auto &entry : std::filesystem::directory_iterator(folder, ignored))
        if (entry.path().extension() == ".toml") files.push_back(entry.path());
    if (files.empty())
        throw std::runtime_error(folder + ": no published table (*.toml); give the folder with --tables");
    std::sort(files.begin(), files.end());
    std::vector<Table> tables;
    for (const auto &file : files) tables.push_back(read_table(file));
    return tables;
}

} // namespace crn::literature
