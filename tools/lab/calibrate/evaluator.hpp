// What is fitted, and what one trial of it gives. A trial is an insertion of the virtual instrument by the
// case's protocol; who inserts it is behind `Evaluator`, so that another rod than ours (the thesis' CoRdE) is
// fitted by the same search.
#pragma once
#include "tools/lab/case/case.hpp"
#include <Eigen/Core>
#include <memory>
#include <string>
#include <vector>

namespace crn::calibrate
{

using Eigen::Vector3d;

// One number to fit, above 0. The search sees it as a share 0 .. 1 of the way from `low` to `high` along the
// logarithm: a factor is what counts.
struct Parameter {
    std::string name, unit, text; // "bend_shaft", "N m^2", what it is
    double low = 0.1, high = 10.0, nominal = 1.0;
    bool scales_force =
        false; // all stiffness at once, which a rigid lumen with Coulomb friction does not show in shapes

    double value_at(double share) const;
    double share_of(double value) const; // limited to 0 .. 1
};

// The instrument where it rests, and what the hand has felt on the way.
struct Insertion {
    std::vector<std::vector<Vector3d>>
        nodes_mm; // one list per depth: those beyond the mouth, tip first: where they are on average at rest
    std::vector<insertion::ForceSample> force; // rising; every tick or every few
    std::vector<int> settle_ticks;             // per depth
    bool is_settled = true;                    // false: still moving when its time was over
    long ticks = 0;                            // of the whole insertion
};

// Why an instrument cannot be tried with these numbers: the core refuses it, or it went to pieces.
class TrialRefused : public std::runtime_error
{
  public:
    using std::runtime_error::runtime_error;
};

// Safe to call from several threads at once; the same values give the same bits.
class Evaluator
{
  public:
    virtual ~Evaluator() = default;
    const std::vector<Parameter> &parameters() const { return parameters_; }
    // Throws CaseError when 0 < low < high does not hold or the nominal value lies outside.
    void set_bounds(std::size_t parameter, double low, double high);

    virtual std::string rod() const = 0; // "core": ours; "corde": the thesis'
    virtual std::string instrument_name() const = 0;
    // To the first `depth_count` depths of the case. Throws TrialRefused.
    virtual Insertion insert(const std::vector<double> &values, std::size_t depth_count) const = 0;
    // All that changes its answers, as text: it is part of the checkpoint's hash.
    virtual std::string settings_text() const = 0;
    // The instrument's file with these values and `source` behind them; empty when our simulator has no such
    // rod.
    virtual std::string instrument_text(const std::vector<double> &values,
                                        const std::string &source) const = 0;

  protected:
    std::vector<Parameter> parameters_;
};

} // namespace crn::calibrate
