// Our own rod as an evaluator: the firmware core, fed into the case's lumen as the device feeds it.
//
// Four numbers are fitted: EI of the shaft, alpha (EI of the tip over that), the outer radius and the density. The friction, the
// shape and the mesh are the case's and the instrument file's. An instrument whose tip is as stiff as its shaft has no alpha.
// May include: tools/case, host/model, tools/vcsim3's lumen (the reader of scenes), the core's core.h. Called by: main, tests.
#pragma once
#include "host/model/instrument.hpp"
#include "tools/calibrate/core_rod.hpp"
#include "tools/vcsim3/lumen.hpp"

namespace seld::calibrate
{

// How the hand moves, and when the instrument is at rest. The defaults are measured: docs/calibrate.md, "Short cuts".
struct InsertionSettings {
    double start_mm = 5.0;          // inserted when the hand begins; the core may need a little more
    double speed_mm_per_s = 30.0;   // of the hand; the case's where that is faster
    double still_um_per_tick = 0.2; // at rest: no node moves more, for `still_ticks`
    int still_ticks = 50;
    int settle_max_ticks = 1000;
    double element_factor = 0.7; // elements so many times longer than the file's
};

// Without short cuts: elements half as long as the file's where the core takes them, and a long rest.
InsertionSettings careful_settings();

// Values of the four; a missing parameter has its nominal value.
struct RodValues {
    double bend_shaft_N_m2 = 0.0, tip_over_shaft = 0.0, radius_mm = 0.0, density_kg_m3 = 0.0;
};

// kg/m over the metal's cross-section at the shaft.
double density_of(const seld_wire_instrument &table, double radius_mm);
RodValues nominal_values(const seld_wire_instrument &table);
// The nominal table with these values: EI and GJ by tools/case/stiffness.hpp, radius and mass by a factor along the whole
// instrument, the case's friction everywhere.
seld_wire_instrument virtual_instrument(const seld_wire_instrument &nominal, const RodValues &values,
                                        const insertion::Case &c);

// The first `length_mm` of an instrument: what stays outside needs no nodes.
seld_wire_instrument shortened(const seld_wire_instrument &table, double length_mm);

class RodEvaluator final : public Evaluator
{
  public:
    // `vessel` must outlive this. Reads the instrument's file. Throws CaseError, FileError.
    RodEvaluator(const insertion::Case &c, const vcsim3::Vessel &vessel, const InsertionSettings &settings);

    const std::vector<Parameter> &parameters() const override { return parameters_; }
    Insertion insert(const std::vector<double> &values, std::size_t depth_count) const override;
    std::string settings_text() const override;

    // Throws CaseError when 0 < low < high does not hold or the nominal value lies outside.
    void set_bounds(std::size_t parameter, double low, double high);
    const Instrument &instrument() const { return instrument_; }
    RodValues values_of(const std::vector<double> &values) const;

  private:
    std::unique_ptr<CoreRod> make_rod(const seld_wire_instrument &table) const;

    insertion::Case case_;
    const vcsim3::Vessel &vessel_;
    InsertionSettings settings_;
    Instrument instrument_;
    std::vector<Parameter> parameters_;
};

} // namespace seld::calibrate
