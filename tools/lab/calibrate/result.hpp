// What a calibration has found, before it is written: the same for any number of workers, so nothing of the
// machine or the clock.
#pragma once
#include "tools/lab/calibrate/identify.hpp"
#include "tools/lab/vcsim3/lumen.hpp"

namespace crn::calibrate
{

struct DepthResult {
    std::string name;
    double inserted_mm = 0.0;
    bool is_fitted = false; // false: for validation
    Distances distances;
    std::optional<double> force_error; // relative, from the mouth to here
    int settle_ticks = 0;
    std::optional<double> short_cuts_mm; // RMS distance to the same insertion made without them; absent where
                                         // that cannot be made
    std::vector<Vector3d> simulated_mm, reference_mm;
};

struct ParameterResult {
    Parameter parameter;
    double fitted = 0.0; // at the optimum
    Identified identified;
    bool is_determined = false;
    std::string why;   // of what is not determined
    double kept = 0.0; // in the instrument file: what is not determined keeps its nominal value
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
    Distances average; // means over all depths of their figures
    std::vector<MethodResult> methods;
    std::string instrument_file; // text with the kept values; empty: our simulator has no such rod
};

struct Finished {
    SearchSettings settings;
    SearchState state;
};

// From the best of the searches. Trials of the identification and the last insertions go to `evaluate`.
Result make_result(const insertion::Case &c, const Evaluator &evaluator, const Evaluator &careful,
                   const Judge &judge, const std::vector<Finished> &searches, const EvaluateShares &evaluate,
                   const IdentifySettings &settings);

std::string to_json(const Result &result);
std::string page_html(const Result &result);
// Figure 5.5 for every depth, and the searches' curves. Throw std::runtime_error.
void draw_shapes(const Result &result, const vcsim3::Vessel &vessel, const std::string &path);
void draw_curves(const Result &result, const std::string &path);

} // namespace crn::calibrate
