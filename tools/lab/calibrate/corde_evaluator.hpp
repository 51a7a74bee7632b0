// Gives the thesis' rod (CoRdE) the interface of an Evaluator, so that the search can fit it. The thesis' rod
// is the baseline with which our rod is compared, and the same search fits both rods.
//
// Five numbers are fitted, as in section 5.3.3 of the thesis: Young's modulus of the shaft, alpha (the tip's
// modulus divided by the shaft's), radius, density and Kp. The instrument file determines how stiffness
// changes from tip to shaft, the ratio GJ / EI and the tip's shape; the case determines friction and gravity.
#pragma once
#include "host/model/instrument.hpp"
#include "tools/lab/calibrate/corde_rod.hpp"
#include "tools/lab/vcsim3/lumen.hpp"

namespace crn::calibrate
{

// Returns the default settings, or settings without shortcuts: elements half as long, a slow simulated hand,
// and a long wait until the rod rests.
CordeSettings corde_settings();
CordeSettings careful_corde_settings();

// Converts the stiffness, radius and mass of the instrument file to those of a solid round wire. The function
// chooses Kp so that the directors (the segments' axes) follow bends of the rod that are longer than some
// millimetres.
CordeValues nominal_corde_values(const Instrument &instrument);

class CordeEvaluator final : public Evaluator
{
  public:
    // `vessel` must outlive this object. Reads the instrument's file. Throws Fault.
    CordeEvaluator(const insertion::Case &c, const vcsim3::Vessel &vessel, const CordeSettings &settings);

    std::string rod() const override { return "corde"; }
    std::string instrument_name() const override { return instrument_.name; }
    Insertion insert(const std::vector<double> &values, std::size_t depth_count) const override;
    std::string settings_text() const override;
    std::string instrument_text(const std::vector<double> &, const std::string &) const override
    {
        return {};
    }
    CordeValues values_of(const std::vector<double> &values) const;

  private:
    insertion::Case case_;
    const vcsim3::Vessel &vessel_;
    CordeSettings settings_;
    Instrument instrument_;
    CordeValues nominal_;
};

} // namespace crn::calibrate
