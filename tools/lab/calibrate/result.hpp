// Defines the result of a calibration as it is in memory, before it is written to files. The result must be
// equal for any number of workers, so it contains neither facts about the machine nor durations.
#pragma once
#include "tools/lab/calibrate/identify.hpp"
#include "tools/lab/vcsim3/lumen.hpp"

namespace crn::calibrate
{

struct DepthResult {
    std::string name;
    double inserted_mm = 0.0;
    bool is_fitted = false; // false: the depth serves for validation
    Distances distances;
    std::optional<double> force_error; // relative, from the introducer to here
    int settle_ticks = 0;
    std::optional<double> short_cuts_mm; // RMS distance from the same insertion made without shortcuts; empty
                                         // where that cannot be made
    std::vector<Vector3d> simulated_mm, reference_mm;
};

struct ParameterResult {
    Parameter parameter;
    double fitted = 0.0; // at the optimum
    Identified identified;
    bool is_determined = false;
    std::string why;   // reason when it is not determined
    double kept = 0.0; // value in the instrument file: an undetermined number keeps its nominal value
};

struct MethodResult {
    SearchSettings search;
    double best = 0.0;
    std::vector<GenerationFigures> curve;
};

struct Result {
    std::string name, instrument, rod; // of the case; Evaluator::rod()
    SearchSettings search;             // of the best method
    double noise_mm = 0.0;
    bool has_force = false;
    Verdict best, kept; // at the optimum; with the instrument as it is written
    unsigned evaluations = 0;
    std::vector<ParameterResult> parameters;
    std::vector<DepthResult> depths;
    Distances average; // means of the figures over all depths
    std::vector<MethodResult> methods;
    std::string instrument_file; // text with the kept values; empty: our simulator has no such rod
};

struct Finished {
    SearchSettings settings;
    SearchState state;
};

// Makes the result of the calibration from the search that found the best trial. The function `evaluate` runs
// the trials that determine the range of each number, and the final insertions.
Result make_result(const insertion::Case &c, const Evaluator &evaluator, const Evaluator &careful,
                   const Judge &judge, const std::vector<Finished> &searches, const EvaluateShares &evaluate,
                   const IdentifySettings &settings);

std::string to_json(const Result &result);
std::string page_html(const Result &result);
// The functions below draw Figure 5.5 of the thesis for every depth, and plots of how each search converged.
// Both throw std::runtime_error.
void draw_shapes(const Result &result, const vcsim3::Vessel &vessel, const std::string &path);
void draw_curves(const Result &result, const std::string &path);

} // namespace crn::calibrate
