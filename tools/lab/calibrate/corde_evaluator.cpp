#include "tools/lab/calibrate/corde_evaluator.hpp"
#include "host/base/number_text.hpp"
#include "tools/lab/calibrate/rod_evaluator.hpp"
#include "tools/lab/case/stiffness.hpp"
#include <algorithm>
#include <cmath>
#include <numbers>

namespace crn::calibrate
{
namespace
{

// The search range of each parameter contains the values of the instrument file and of the thesis' Table 5.1,
// and extends beyond them by the following factors.
constexpr double room = 3.0, radius_room = 1.25, alpha_factor = 10.0, alpha_max = 4.0;
// With the nominal ratio Kp / EI, the directors (the segments' axes) follow bends of the rod that are much
// longer than 2.2 mm. A larger ratio Kp / EI would need a rod with more mass, because the time step is fixed.
constexpr double parallel_over_bend_per_m2 = 2e5;
constexpr double newton_per_kp = 1e-2; // of the table, as tools/lab/vcsim3/preset.hpp reads it
constexpr double outside_mm = 30.0;    // length held outside the introducer at the deepest place

std::optional<ThesisRow> row_of(const Instrument &instrument, const std::string &file)
{
    const auto &presets = instrument.presets;
    if (instrument.thesis || std::find(presets.begin(), presets.end(), "vcsim3-fit") == presets.end())
        return instrument.thesis;
    return read_instrument(split_preset(file).first + ":vcsim3-fit").thesis;
}

Parameter over_both(const std::string &name, const std::string &unit, const std::string &text, double nominal,
                    std::optional<double> other, double more)
{
    const double second = other.value_or(nominal);
    return {name, unit, text, std::min(nominal, second) / more, std::max(nominal, second) * more, nominal};
}

std::vector<Parameter> parameters_of(const CordeValues &nominal, const std::optional<ThesisRow> &row)
{
    const auto in_row = [&](auto value) { return row ? std::optional<double>(value(*row)) : std::nullopt; };
    std::vector<Parameter> list = {
        over_both("young", "Pa", "Young's modulus of the shaft as a solid round wire", nominal.young_Pa,
                  in_row([](const ThesisRow &r) { return r.young_modulus; }), room),
        over_both("radius", "mm", "radius", nominal.radius_mm,
                  in_row([](const ThesisRow &r) { return r.radius_m * 1e3; }), radius_room),
        over_both("density", "kg/m^3", "mass over the cross-section", nominal.density_kg_m3,
                  in_row([](const ThesisRow &r) { return r.density; }), room),
        over_both("kp", "N", "Kp, which ties the directors to the line", nominal.parallel_N,
                  in_row([](const ThesisRow &r) { return r.kp * newton_per_kp; }), room)};
    list.front().scales_force = true;
    if (std::abs(std::log(nominal.tip_over_shaft)) > 1e-3) {
        Parameter alpha = over_both("alpha", "1", "Young's modulus of the tip over that of the shaft",
                                    nominal.tip_over_shaft, std::nullopt, alpha_factor);
        alpha.high = std::min(alpha.high, std::max(alpha_max, nominal.tip_over_shaft));
        list.insert(list.begin() + 1, alpha);
    }
    return list;
}

} // namespace

CordeSettings corde_settings()
{
    CordeSettings settings;
    settings.element_factor = 1.0;
    settings.speed_mm_per_s = 30.0;
    settings.still_um_per_tick = 0.5;
    settings.settle_max_ticks = 2000;
    return settings;
}

CordeSettings careful_corde_settings()
{
    CordeSettings settings;
    static_cast<InsertionSettings &>(settings) = careful_settings();
    settings.element_factor = 0.5;
    settings.substeps_max = 32;
    return settings;
}

CordeValues nominal_corde_values(const Instrument &instrument)
{
    const crn_wire_knot &shaft = instrument.table.knots[instrument.table.knots_count - 1];
    const insertion::Stiffness stiffness = insertion::stiffness_of(instrument.table);
    CordeValues values;
    values.radius_mm = shaft.radius_outer_um * 1e-3;
    values.young_Pa = 1.0;
    values.young_Pa = stiffness.shaft_N_m2 / values.bend_N_m2();
    values.tip_over_shaft = stiffness.tip_over_shaft;
    values.density_kg_m3 = shaft.mass_mg_per_m * 1e-6 / values.area_m2();
    values.parallel_N = parallel_over_bend_per_m2 * stiffness.shaft_N_m2;
    return values;
}

CordeEvaluator::CordeEvaluator(const insertion::Case &c, const vcsim3::Vessel &vessel,
                               const CordeSettings &settings)
    : case_(c), vessel_(vessel), settings_(settings)
{
    const std::string file = c.path_in(c.instrument).string();
    instrument_ = read_instrument(file);
    nominal_ = nominal_corde_values(instrument_);
    settings_.speed_mm_per_s = std::max(settings_.speed_mm_per_s, c.speed_mm_per_s);
    parameters_ = parameters_of(nominal_, row_of(instrument_, file));
}

CordeValues CordeEvaluator::values_of(const std::vector<double> &values) const
{
    CordeValues all = nominal_;
    for (std::size_t i = 0; i < parameters_.size() && i < values.size(); i++) {
        if (parameters_[i].name == "young") all.young_Pa = values[i];
        if (parameters_[i].name == "alpha") all.tip_over_shaft = values[i];
        if (parameters_[i].name == "radius") all.radius_mm = values[i];
        if (parameters_[i].name == "density") all.density_kg_m3 = values[i];
        if (parameters_[i].name == "kp") all.parallel_N = values[i];
    }
    return all;
}

Insertion CordeEvaluator::insert(const std::vector<double> &values, std::size_t depth_count) const
{
    const CordeModel model = corde_model(instrument_.table, values_of(values), case_, settings_,
                                         case_.depths.back().inserted_mm + outside_mm);
    const vcsim3::Wall wall = [this](const vcsim3::Vector &at_m) { return vessel_.sample(at_m); };
    CordeRod rod(model, case_, wall, settings_);
    return insert_by_hand(rod, case_, settings_, depth_count);
}

std::string CordeEvaluator::settings_text() const
{
    return "corde 1 " + settings_.text() + " of " +
           number_text(settings_.element_mm, insertion::file_digits) + " mm steps " +
           std::to_string(settings_.substeps_max) + " drag " +
           number_text(settings_.drag_per_s, insertion::file_digits) + " " +
           number_text(settings_.spin_drag_per_s, insertion::file_digits) + " " + settings_.mode.token();
}

} // namespace crn::calibrate
