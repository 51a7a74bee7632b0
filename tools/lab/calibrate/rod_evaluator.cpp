#include "tools/lab/calibrate/rod_evaluator.hpp"
#include "tools/lab/calibrate/fitted_instrument.hpp"
#include "tools/lab/case/stiffness.hpp"
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>

namespace crn::calibrate
{
namespace
{

// For EI and alpha the search range extends from the nominal value by a factor of 10 either way. The search
// range of the density extends by a factor of 8 either way, and that of the radius by 25 % either way. The
// tip is never more than four times as stiff as the shaft. The core's own limits also restrict the ranges of
// the fitted values.
constexpr double bend_factor = 10.0, rod_alpha_factor = 10.0, radius_factor = 1.25, density_factor = 8.0;
constexpr double rod_alpha_max = 4.0;
constexpr double rod_outside_mm =
    60.0; // length of the instrument outside at the deepest place; what is farther back has no effect
constexpr double coarser = 1.25,
                 coarsest =
                     2.0; // factors of the element length, for tools whose finer elements the core rejects

const crn_wire_knot &shaft_of(const crn_wire_instrument &table)
{
    return table.knots[table.knots_count - 1];
}

double section_m2(double outer_mm, double inner_mm)
{
    return std::numbers::pi * (outer_mm * outer_mm - inner_mm * inner_mm) * 1e-6;
}

std::uint32_t limited(double value, double low, double high)
{
    return static_cast<std::uint32_t>(std::lround(std::clamp(value, low, high)));
}

Parameter around(const std::string &name, const std::string &unit, const std::string &text, double nominal,
                 double factor)
{
    return {name, unit, text, nominal / factor, nominal * factor, nominal};
}

std::vector<Parameter> parameters_of(const RodValues &nominal, bool has_tip)
{
    std::vector<Parameter> list = {
        around("bend_shaft", "N m^2", "EI of the shaft", nominal.bend_shaft_N_m2, bend_factor),
        around("radius", "mm", "outer radius of the shaft", nominal.radius_mm, radius_factor),
        around("density", "kg/m^3", "mass over the metal's cross-section", nominal.density_kg_m3,
               density_factor)};
    list.front().scales_force = true;
    if (has_tip) {
        Parameter alpha = around("alpha", "1", "EI of the tip over EI of the shaft", nominal.tip_over_shaft,
                                 rod_alpha_factor);
        alpha.high = std::min(alpha.high, std::max(rod_alpha_max, nominal.tip_over_shaft));
        list.insert(list.begin() + 1, alpha);
    }
    return list;
}

} // namespace

double density_of(const crn_wire_instrument &table, double radius_mm)
{
    const crn_wire_knot &shaft = shaft_of(table);
    return shaft.mass_mg_per_m * 1e-6 / section_m2(radius_mm, shaft.radius_inner_um * 1e-3);
}

RodValues nominal_values(const crn_wire_instrument &table)
{
    const insertion::Stiffness stiffness = insertion::stiffness_of(table);
    const double radius_mm = shaft_of(table).radius_outer_um * 1e-3;
    return {stiffness.shaft_N_m2, stiffness.tip_over_shaft, radius_mm, density_of(table, radius_mm)};
}

crn_wire_instrument virtual_instrument(const crn_wire_instrument &nominal, const RodValues &values,
                                       const insertion::Case &c)
{
    crn_wire_instrument table =
        insertion::with_stiffness(nominal, {values.bend_shaft_N_m2, values.tip_over_shaft});
    const RodValues was = nominal_values(nominal);
    const double wider = values.radius_mm / was.radius_mm;
    const double inner_mm = shaft_of(nominal).radius_inner_um * 1e-3;
    const double heavier = values.density_kg_m3 * section_m2(values.radius_mm, inner_mm) /
                           (was.density_kg_m3 * section_m2(was.radius_mm, inner_mm));
    for (unsigned i = 0; i < table.knots_count; i++) {
        crn_wire_knot &knot = table.knots[i];
        knot.radius_outer_um = limited(knot.radius_outer_um * wider, knot.radius_inner_um + 1.0, 2000);
        knot.mass_mg_per_m = limited(knot.mass_mg_per_m * heavier, 500, 100000);
        knot.friction_kinetic_milli = limited(c.friction_kinetic * 1e3, 0, 1000);
        knot.friction_static_milli = limited(c.friction_static * 1e3, 0, 1000);
    }
    return table;
}

crn_wire_instrument shortened(const crn_wire_instrument &table, double length_mm)
{
    crn_wire_instrument out = table;
    unsigned last = 0;
    while (last < table.knots_count && table.knots[last].arc_um < length_mm * 1e3) last++;
    if (last == table.knots_count || last == 0) return out;
    out.knots[last] = knot_at(table, length_mm, false);
    out.knots_count = static_cast<std::uint16_t>(last + 1);
    return out;
}

RodEvaluator::RodEvaluator(const insertion::Case &c, const vcsim3::Vessel &vessel,
                           const InsertionSettings &settings)
    : case_(c), vessel_(vessel), settings_(settings),
      instrument_(read_instrument(c.path_in(c.instrument).string()))
{
    settings_.speed_mm_per_s = std::max(settings_.speed_mm_per_s, c.speed_mm_per_s);
    const crn_wire_instrument &table = instrument_.table;
    const RodValues nominal = nominal_values(table);
    parameters_ = parameters_of(nominal, std::abs(std::log(nominal.tip_over_shaft)) > 1e-3);
}

InsertionSettings careful_settings()
{
    InsertionSettings settings;
    settings.speed_mm_per_s = 0.0;
    settings.still_um_per_tick = 0.02;
    settings.settle_max_ticks = 5000;
    settings.element_factor = 0.35;
    return settings;
}

RodValues RodEvaluator::values_of(const std::vector<double> &values) const
{
    RodValues all = nominal_values(instrument_.table);
    for (std::size_t i = 0; i < parameters_.size() && i < values.size(); i++) {
        if (parameters_[i].name == "bend_shaft") all.bend_shaft_N_m2 = values[i];
        if (parameters_[i].name == "alpha") all.tip_over_shaft = values[i];
        if (parameters_[i].name == "radius") all.radius_mm = values[i];
        if (parameters_[i].name == "density") all.density_kg_m3 = values[i];
    }
    return all;
}

// Creates a simulation in the core whose rod has elements of the wanted length. The elements are longer than
// wanted where short elements would have a stiffness or mass outside the core's number format.
std::unique_ptr<CoreRod> RodEvaluator::make_rod(const crn_wire_instrument &table) const
{
    for (double factor = settings_.element_factor;; factor *= coarser) {
        crn_wire_instrument meshed = table;
        meshed.element_tip_um = limited(table.element_tip_um * factor, 200, 8000);
        meshed.element_shaft_um = limited(table.element_shaft_um * factor, meshed.element_tip_um, 8000);
        try {
            return std::make_unique<CoreRod>(meshed, &vessel_.lumen(), case_.mouth_mm, case_.direction,
                                             case_.gravity_m_s2, settings_.start_mm);
        } catch (const TrialRefused &) {
            if (factor > coarsest) throw;
        }
    }
}

Insertion RodEvaluator::insert(const std::vector<double> &values, std::size_t depth_count) const
{
    const crn_wire_instrument table =
        shortened(virtual_instrument(instrument_.table, values_of(values), case_),
                  case_.depths.back().inserted_mm + rod_outside_mm);
    return insert_by_hand(*make_rod(table), case_, settings_, depth_count);
}

std::string RodEvaluator::settings_text() const
{
    return "rod 1 core " + std::to_string(CoreRod::version()) + " " + settings_.text();
}

std::string RodEvaluator::instrument_text(const std::vector<double> &values, const std::string &source) const
{
    return fitted_instrument_text(case_.path_in(case_.instrument).string(),
                                  virtual_instrument(instrument_.table, values_of(values), case_), source);
}

} // namespace crn::calibrate
