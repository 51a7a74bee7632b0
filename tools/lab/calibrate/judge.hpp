// Computes how far a simulated insertion deviates from the scan and from the measured force. The Judge
// compares the shapes by equation 19 of the thesis at each depth, and also compares the force traces.
#pragma once
#include "tools/lab/calibrate/evaluator.hpp"
#include <span>

namespace crn::calibrate
{

// Holds statistics of the distances from the simulated nodes to the nearest point of the reference, which is
// a polyline.
struct Distances {
    double rms_mm = 0.0, mean_mm = 0.0, deviation_mm = 0.0, max_mm = 0.0;
    std::size_t count = 0;
};
double distance_to_line_mm(const Vector3d &point, std::span<const Vector3d> line);
Distances distances_of(std::span<const Vector3d> nodes_mm, std::span<const Vector3d> reference_mm);

// Returns the relative RMS of the difference between a force trace F and a reference F_ref: sqrt(sum (F -
// F_ref)^2 / sum F_ref^2) over the samples of the reference from `from_mm` to `to_mm`. Before the comparison,
// the function replaces each force by the median of the forces within `smooth_mm` around its sample. A tip
// that snaps past an edge causes a peak of force; different rod models have this peak at different inserted
// lengths. Returns nothing when the reference has no sample between `from_mm` and `to_mm`.
std::optional<double> force_error(std::span<const insertion::ForceSample> simulated,
                                  std::span<const insertion::ForceSample> reference, double from_mm,
                                  double to_mm, double smooth_mm);
// Returns the median force around one inserted length, or nothing if the trace has no sample there.
std::optional<double> force_at(std::span<const insertion::ForceSample> trace, double inserted_mm,
                               double smooth_mm);

// The search minimises the mean RMS over the fitted depths, in mm, plus `force_weight_mm` times the relative
// RMS of the force. In a rigid lumen the forces are proportional to EI, so an error of 10 % in EI adds 0.1
// times `force_weight_mm` to the objective.
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
    // Reads the reference centrelines and the reference force trace from the files of the case. Throws Fault.
    Judge(const insertion::Case &c, const JudgeSettings &settings);
    Verdict judge(const Insertion &insertion) const;
    // Simulates the insertion and returns a Verdict, even if the rod model refuses the values of the trial.
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
