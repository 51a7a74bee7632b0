// Defines the command line of `cournand records`, and carries out its commands (docs/records.md).
#pragma once
#include "host/records/store.hpp"
#include <string>
#include <vector>

namespace CLI
{
class App;
}

namespace crn
{

struct RecordsOptions {
    std::string command;                // "list", "show", ...
    std::string place;                  // --records; empty: default_records_place()
    std::string what, new_name;         // positional arguments
    std::string case_id, trainee;       // filters
    std::vector<std::string> metrics;   // of curve and cohort; empty: score, errors, duration_s
    std::vector<std::string> files;     // of import
    std::string format = "csv", output; // of export; an empty output is standard output
    std::string home_page, html, to;
    std::string name, cohort, keep_until; // of trainee
    bool no_name = false, no_cohort = false, no_keep_until = false;
    bool json = false, lists_trainees = false;
    bool is_expert = false, is_no_expert = false;
    bool expired = false, with_recordings = false, keeps_recordings = false, yes = false;
    double pass_score = 80.0, rate_good = 0.1, rate_bad = 0.3; // of curve: CUSUM
};

void add_records(CLI::App &app, RecordsOptions &options);
// Returns 1 if `check` found damage or `ship` could not send everything, otherwise 0. Throws RecordsError,
// UsageError, OutputError.
int command_records(const RecordsOptions &options);

// The following functions carry out the commands about learning curves and groups of trainees; they are in
// cli_records_learning.cpp.
int command_records_curve(RecordStore &store, const RecordsOptions &options);
int command_records_cohort(RecordStore &store, const RecordsOptions &options);
// "12:03" from seconds.
std::string clock_text(double seconds);

} // namespace crn
