// Judges our figures by the published spread, and compares the verdicts with the tracked list of tables that
// passed before.
#pragma once
#include "tools/lab/literature/experiments.hpp"
#include "tools/lab/literature/table.hpp"

#include <map>
#include <string>
#include <vector>

namespace crn::literature
{

struct Measured {
    const Table *table = nullptr;
    Figures figures;
    double seconds = 0;
    std::string failure; // the error that stopped the experiment, or empty

    double value(const Row &row) const; // NaN without a figure
    bool is_judged(const Row &row) const;
    bool passed(const Row &row) const;
    // "pass" or "fail" of a validation, "input" of a table that proves nothing, "stopped" after an error.
    std::string verdict() const;
};

// Checks that the experiment gave a finite figure for every row, and no other figure. Throws
// std::runtime_error that names the figure.
void check_complete(const Table &table, const Figures &figures);

// The distance of our figure from the published mean in standard deviations, or from the nearer end of the
// range as a share of the range (0 inside it). Empty where the source states no spread.
std::string distance_text(const Row &row, double value);

// The tracked verdicts: a line "TABLE<tab>pass" or "TABLE<tab>fail" for every validation.
using Expectations = std::map<std::string, std::string>;
Expectations read_expectations(const std::string &file); // throws std::runtime_error
std::string expectations_text(const Expectations &all);

struct Comparison {
    std::vector<std::string> worse;         // passed before, and fail now
    std::vector<std::string> better;        // failed before, and pass now
    std::vector<std::string> unknown, gone; // not in the list; in the list without a table of this name
};
// `is_whole` says that all tables were measured; only then can a table be gone.
Comparison compare(const std::vector<Measured> &all, const Expectations &expected, bool is_whole);

} // namespace crn::literature
