// Holds the results of a validation case, which are values with their references and plots, and writes these
// results. Every comparison states its tolerance.
#pragma once
#include "tools/lab/validate/plot.hpp"

#include <string>
#include <vector>

namespace crn::validate
{

// One figure. `error` has the unit `error_unit`; the row passes when the magnitude of the error is within
// `tolerance`. A tolerance below 0 means that the value is reported but not judged.
struct Row {
    std::string name;    // case.what: unique and stable, because others refer to it
    std::string formula; // how the reference is computed
    std::string source;  // where the formula comes from
    std::string unit;    // unit of reference and value
    double reference = 0, value = 0;
    double error = 0, tolerance = 0;
    std::string error_unit;
    bool passed() const;
    bool is_bar() const { return tolerance >= 0; }
};

struct Result {
    std::string name, title, setup; // setup: how the rod is held and loaded, for the reader
    std::string formula, source;    // of rows that do not give their own
    std::vector<Row> rows;
    std::vector<Plot> plots;
    double seconds = 0;
    std::string failure; // the error that stopped the case, or empty

    // Compares the value with the reference, and computes the error in percent of the reference.
    void relative(const std::string &what, const std::string &unit, double reference, double value,
                  double tolerance_pct);
    // Compares the value with the reference, and computes the error in the unit of the value.
    void absolute(const std::string &what, const std::string &unit, double reference, double value,
                  double tolerance);
    // Stores an error, in `error_unit`, that the validation case itself has computed.
    void error(const std::string &what, const std::string &unit, double reference, double value, double error,
               const std::string &error_unit, double tolerance);
    // Checks that a value is not larger than the limit `bar`.
    void at_most(const std::string &what, const std::string &unit, double value, double bar);
    void reported(const std::string &what, const std::string &unit, double reference, double value);
    bool passed() const;
};

std::string tsv(const std::vector<Result> &results);
std::string html(const std::vector<Result> &results, const std::string &command);
std::string tap(const std::vector<Result> &results);
// Returns the table of docs/validation.md, with one line per case; the line shows the value of the case that
// is closest to failing.
std::string markdown(const std::vector<Result> &results);

} // namespace crn::validate
