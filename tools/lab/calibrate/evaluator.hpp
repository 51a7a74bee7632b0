// Defines the parameters that the search fits, and the result of a trial, which simulates an insertion with
// given parameter values. In a trial, the program simulates how an instrument with the trial's values is
// inserted according to the protocol of the case. `Evaluator` hides the rod, so that the same search can fit
// another rod than ours, such as the thesis' CoRdE.
#pragma once
#include "tools/lab/case/case.hpp"
#include <Eigen/Core>
#include <memory>
#include <string>
#include <vector>

namespace crn::calibrate
{

using Eigen::Vector3d;

// A parameter is one number that the search fits; its value is above 0. The search represents a value by its
// position 0 .. 1 in the logarithmic range from `low` to `high`, because ratios of values matter more than
// differences.
struct Parameter {
    std::string name, unit, text; // "bend_shaft", "N m^2", its description
    double low = 0.1, high = 10.0, nominal = 1.0;
    bool scales_force = false; // it scales all stiffness at once, which shapes in a rigid lumen with Coulomb
                               // friction do not show

    double value_at(double share) const;
    double share_of(double value) const; // limited to 0 .. 1
};

// The result of a trial holds the shape of the instrument at rest, and the force on the hand during the
// insertion.
struct Insertion {
    std::vector<std::vector<Vector3d>>
        nodes_mm; // one list per depth: the nodes inside the vessel, tip first, at their mean places at rest
    std::vector<insertion::ForceSample> force; // increasing inserted length; every tick or every few ticks
    std::vector<int> settle_ticks;             // per depth
    bool is_settled = true;                    // false: it still moved when the time limit was reached
    long ticks = 0;                            // of the whole insertion
};

// A TrialRefused is thrown when an instrument with the given values cannot be simulated, because the core
// rejects the values or the rod becomes unstable. The text gives the reason.
class TrialRefused : public std::runtime_error
{
  public:
    using std::runtime_error::runtime_error;
};

// Several threads may call an Evaluator at once. Equal values give equal results, bit for bit.
class Evaluator
{
  public:
    virtual ~Evaluator() = default;
    const std::vector<Parameter> &parameters() const { return parameters_; }
    // Throws Fault when 0 < low < high does not hold, or when the nominal value lies outside this range.
    void set_bounds(std::size_t parameter, double low, double high);

    virtual std::string rod() const = 0; // "core": our rod; "corde": the thesis' rod
    virtual std::string instrument_name() const = 0;
    // Simulates how the instrument is inserted to the first `depth_count` depths of the case. Throws
    // TrialRefused.
    virtual Insertion insert(const std::vector<double> &values, std::size_t depth_count) const = 0;
    // Returns all settings that change the results, as text for the checkpoint's hash.
    virtual std::string settings_text() const = 0;
    // Returns the text of an instrument file that contains the given values, each followed by the text
    // `source`. The text of the instrument file is empty if our simulator cannot simulate the fitted rod
    // model.
    virtual std::string instrument_text(const std::vector<double> &values,
                                        const std::string &source) const = 0;

  protected:
    std::vector<Parameter> parameters_;
};

} // namespace crn::calibrate
