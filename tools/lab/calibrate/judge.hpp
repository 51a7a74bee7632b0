// The deviation of an insertion from the scan and from the measured force: equation 19 of the thesis at each
// depth, and the force trace.
#pragma once
#include "tools/lab/calibrate/evaluator.hpp"
#include <span>

namespace crn::calibrate
{

// Distances of the simulated nodes from the nearest point of the reference, a line of straight pieces.
struct Distances {
    double rms_mm = 0.0, mean_mm = 0.0, deviation_mm = 0.0, max_mm = 0.0;
    std::size_t count = 0;
};
double distance_to_line_mm(const Vector3d &point, std::span<const Vector3d> line);
Distances distances_of(std::span<const Vector3d> nodes_mm, std::span<const Vector3d> reference_mm);

// Returns the relative RMS of the difference of two force traces: sqrt(sum (F - F_ref)^2 / sum F_ref^2) over
// the samples of the reference from `from_mm` to `to_mm`. Both are medians over `smooth_mm` around each
// sample, since a tip that snaps past an edge gives a peak that another model has elsewhere. Empty when there
// is no such sample.
std::optional<double> force_error(std::span<const insertion::ForceSample> simulated,
                                  std::span<const insertion::ForceSample> reference, double from_mm,
                                  double to_mm, double smooth_mm);
// The median around one inserted length; empty where the trace has no sample.
std::optional<double> force_at(std::span<const insertion::ForceSample> trace, double inserted_mm,
                               double smooth_mm);

// The search minimises the mean RMS over the fitted depths, in mm, plus `force_weight_mm` times the relative
// RMS of the force. Forces scale with EI in a rigid lumen, so a scale that is 10 % off costs a tenth of the
// weight.
struct JudgeSettings {
    std::size_t fit_depths = 2; // the first ones; the others serve for validation
    double force_weight_mm = 1.0;
    double force_from_mm = 10.0, force_smooth_mm = 6.0;
};
struct Verdict {
    double objective = refused_objective;
    double error_mm = refused_objective;             // equation 19, averaged over the fitted depths
    double force_error = 0.0;                        // relative; 0 without a trace
    static constexpr double refused_objective = 1e3; // of a trial that was refused

    bool is_refused() const { return objective >= refused_objective; }
};

class Judge
{
  public:
    // Reads the case's centrelines and force trace. Throws CaseError.
    Judge(const insertion::Case &c, const JudgeSettings &settings);
    Verdict judge(const Insertion &insertion) const;
    // Inserts and judges; a refused trial also gives a verdict.
    Verdict evaluate(const Evaluator &evaluator, const std::vector<double> &values) const;

    bool has_force() const { return !force_.empty(); }
    const std::vector<std::vector<Vector3d>> &references_mm() const { return references_mm_; }
    const std::vector<insertion::ForceSample> &force() const { return force_; }
    const JudgeSettings &settings() const { return settings_; }
    std::optional<double> force_error_to(const Insertion &insertion, std::size_t depth) const;
    std::string settings_text() const; // part of the checkpoint's hash

  private:
    JudgeSettings settings_;
    std::vector<double> inserted_mm_;
    std::vector<std::vector<Vector3d>> references_mm_;
    std::vector<insertion::ForceSample> force_;
};

} // namespace crn::calibrate
