// Gives our own rod the interface of an Evaluator: the firmware core simulates how the rod is inserted into
// the case's lumen, as on the device.
//
// Four numbers are fitted: EI of the shaft, alpha (EI of the tip over EI of the shaft), the outer radius and
// the density. The case gives the friction; the instrument file gives the shape of the tip and the division
// into elements. An instrument whose tip is as stiff as its shaft has no parameter alpha.
#pragma once
#include "host/model/instrument.hpp"
#include "tools/lab/calibrate/core_rod.hpp"
#include "tools/lab/vcsim3/lumen.hpp"

namespace crn::calibrate
{

// Returns settings without shortcuts: the hand moves at the case's speed throughout, and the program waits
// long for the rod to rest. The elements are 0.35 times as long as in the instrument file, if the core
// accepts this length.
InsertionSettings careful_settings();

// Holds the values of the four fitted numbers; a number that is not fitted gets its nominal value.
struct RodValues {
    double bend_shaft_N_m2 = 0.0, tip_over_shaft = 0.0, radius_mm = 0.0, density_kg_m3 = 0.0;
};

// Returns the density of the shaft, which is its mass per length divided by the metal's cross-section.
double density_of(const crn_wire_instrument &table, double radius_mm);
RodValues nominal_values(const crn_wire_instrument &table);
// Returns a copy of the nominal instrument's table in which the fitted numbers have the given values. The
// functions of tools/lab/case/stiffness.hpp compute the stiffnesses EI and GJ of the copy. One factor scales
// the radius along the whole instrument, and another scales the mass; the friction is that of the case
// everywhere.
crn_wire_instrument virtual_instrument(const crn_wire_instrument &nominal, const RodValues &values,
                                       const insertion::Case &c);

// Returns the part of an instrument within `length_mm` of its tip; the rest stays outside the patient and
// needs no nodes.
crn_wire_instrument shortened(const crn_wire_instrument &table, double length_mm);

class RodEvaluator final : public Evaluator
{
  public:
    // `vessel` must outlive this object. Reads the instrument's file. Throws Fault.
    RodEvaluator(const insertion::Case &c, const vcsim3::Vessel &vessel, const InsertionSettings &settings);

    std::string rod() const override { return "core"; }
    std::string instrument_name() const override { return instrument_.name; }
    Insertion insert(const std::vector<double> &values, std::size_t depth_count) const override;
    std::string settings_text() const override;
    std::string instrument_text(const std::vector<double> &values, const std::string &source) const override;
    RodValues values_of(const std::vector<double> &values) const;

  private:
    std::unique_ptr<CoreRod> make_rod(const crn_wire_instrument &table) const;

    insertion::Case case_;
    const vcsim3::Vessel &vessel_;
    InsertionSettings settings_;
    Instrument instrument_;
};

} // namespace crn::calibrate
