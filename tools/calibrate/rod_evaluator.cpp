#include "tools/calibrate/rod_evaluator.hpp"
#include "tools/calibrate/fitted_instrument.hpp"
#include "tools/case/stiffness.hpp"
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>

namespace seld::calibrate
{
namespace
{

// Bounds: EI a decade either way, alpha a decade below and above, but never a tip four times as stiff as the shaft; radius within a quarter,
// density from an eighth to eight times. Those of the core hold behind them.
constexpr double bend_factor = 10.0, alpha_factor = 10.0, radius_factor = 1.25, density_factor = 8.0;
constexpr double alpha_max = 4.0;
constexpr int turn_ticks = 200; // to bring the tip into its first plane, before the hand feeds
constexpr int force_every = 4;  // ticks
constexpr double outside_mm =
    60.0; // of the instrument outside at the deepest place: what is behind it does nothing
constexpr double coarser = 1.25, coarsest = 2.0; // elements, where the core takes no finer ones
constexpr double arrived_mm = 0.01, turn_step_deg = 0.5;

const seld_wire_knot &shaft_of(const seld_wire_instrument &table)
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

std::string number(double value)
{
    char text[40];
    std::snprintf(text, sizeof text, "%.9g", value);
    return text;
}

Parameter around(const std::string &name, const std::string &unit, const std::string &text, double nominal,
                 double factor)
{
    return {name, unit, text, nominal / factor, nominal * factor, nominal, true};
}

std::vector<Parameter> parameters_of(const RodValues &nominal, bool has_tip)
{
    std::vector<Parameter> list = {
        around("bend_shaft", "N m^2", "EI of the shaft", nominal.bend_shaft_N_m2, bend_factor),
        around("radius", "mm", "outer radius of the shaft", nominal.radius_mm, radius_factor),
        around("density", "kg/m^3", "mass over the metal's cross-section", nominal.density_kg_m3,
               density_factor)};
    if (has_tip) {
        Parameter alpha =
            around("alpha", "1", "EI of the tip over EI of the shaft", nominal.tip_over_shaft, alpha_factor);
        alpha.high = std::min(alpha.high, std::max(alpha_max, nominal.tip_over_shaft));
        list.insert(list.begin() + 1, alpha);
    }
    return list;
}

} // namespace

double density_of(const seld_wire_instrument &table, double radius_mm)
{
    const seld_wire_knot &shaft = shaft_of(table);
    return shaft.mass_mg_per_m * 1e-6 / section_m2(radius_mm, shaft.radius_inner_um * 1e-3);
}

RodValues nominal_values(const seld_wire_instrument &table)
{
    const insertion::Stiffness stiffness = insertion::stiffness_of(table);
    const double radius_mm = shaft_of(table).radius_outer_um * 1e-3;
    return {stiffness.shaft_N_m2, stiffness.tip_over_shaft, radius_mm, density_of(table, radius_mm)};
}

seld_wire_instrument virtual_instrument(const seld_wire_instrument &nominal, const RodValues &values,
                                        const insertion::Case &c)
{
    seld_wire_instrument table =
        insertion::with_stiffness(nominal, {values.bend_shaft_N_m2, values.tip_over_shaft});
    const RodValues was = nominal_values(nominal);
    const double wider = values.radius_mm / was.radius_mm;
    const double inner_mm = shaft_of(nominal).radius_inner_um * 1e-3;
    const double heavier = values.density_kg_m3 * section_m2(values.radius_mm, inner_mm) /
                           (was.density_kg_m3 * section_m2(was.radius_mm, inner_mm));
    for (unsigned i = 0; i < table.knots_count; i++) {
        seld_wire_knot &knot = table.knots[i];
        knot.radius_outer_um = limited(knot.radius_outer_um * wider, knot.radius_inner_um + 1.0, 2000);
        knot.mass_mg_per_m = limited(knot.mass_mg_per_m * heavier, 500, 100000);
        knot.friction_kinetic_milli = limited(c.friction_kinetic * 1e3, 0, 1000);
        knot.friction_static_milli = limited(c.friction_static * 1e3, 0, 1000);
    }
    return table;
}

seld_wire_instrument shortened(const seld_wire_instrument &table, double length_mm)
{
    seld_wire_instrument out = table;
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
    const seld_wire_instrument &table = instrument_.table;
    const RodValues nominal = nominal_values(table);
    parameters_ = parameters_of(nominal, std::abs(std::log(nominal.tip_over_shaft)) > 1e-3);
}

InsertionSettings careful_settings()
{
    InsertionSettings settings;
    settings.speed_mm_per_s = 0.0;
    settings.still_um_per_tick = 0.02;
    settings.settle_max_ticks = 5000;
    settings.element_factor = 0.5;
    return settings;
}

void RodEvaluator::set_bounds(std::size_t parameter, double low, double high)
{
    Parameter &p = parameters_.at(parameter);
    if (!(low > 0.0) || !(low < high) || p.nominal < low || p.nominal > high)
        throw insertion::CaseError("bounds of " + p.name +
                                   ": give LOW..HIGH above 0 with the file's value, " + number(p.nominal) +
                                   " " + p.unit + ", between them");
    p.low = low;
    p.high = high;
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

namespace
{

// One insertion under way.
class Hand
{
  public:
    Hand(CoreRod &rod, const insertion::Case &c, const InsertionSettings &settings, Insertion &result)
        : rod_(rod), case_(c), settings_(settings), result_(result), hand_mm_(rod.inserted_mm())
    {
    }

    // The tip comes into the plane of the first depth while the hand does not feed.
    void turn_first()
    {
        const double to_deg = case_.depths.front().turn_deg;
        const int ticks = std::max(turn_ticks, static_cast<int>(std::abs(to_deg) / turn_step_deg));
        for (int i = 1; i <= ticks; i++) tick(hand_mm_, to_deg * i / ticks);
    }

    void feed_to(double inserted_mm)
    {
        while (hand_mm_ < inserted_mm) {
            hand_mm_ = std::min(inserted_mm, hand_mm_ + settings_.speed_mm_per_s * 1e-3);
            tick(hand_mm_, case_.turn_deg_at(hand_mm_));
        }
    }

    // Until no node moves.
    void rest()
    {
        const double turn_deg = case_.turn_deg_at(hand_mm_);
        int still = 0, ticks = 0;
        while (still < settings_.still_ticks && ticks < settings_.settle_max_ticks) {
            tick(hand_mm_, turn_deg);
            ticks++;
            const bool is_still =
                rod_.motion_um() <= settings_.still_um_per_tick && hand_mm_ - rod_.inserted_mm() < arrived_mm;
            still = is_still ? still + 1 : 0;
        }
        if (still < settings_.still_ticks) result_.is_settled = false;
        result_.settle_ticks.push_back(ticks);
    }

  private:
    void tick(double hand_mm, double turn_deg)
    {
        rod_.tick(hand_mm, turn_deg);
        if (!rod_.is_sound())
            throw TrialRefused("the instrument left the lumen's field or the core's number range");
        const double inserted_mm = rod_.inserted_mm();
        const bool is_new = result_.force.empty() || inserted_mm > result_.force.back().inserted_mm;
        if (result_.ticks++ % force_every == 0 && is_new)
            result_.force.push_back({inserted_mm, rod_.handle_axial_mN()});
    }

    CoreRod &rod_;
    const insertion::Case &case_;
    const InsertionSettings &settings_;
    Insertion &result_;
    double hand_mm_;
};

} // namespace

// The core with elements of the wanted length; longer ones where stiffness and mass leave its number format with short ones.
std::unique_ptr<CoreRod> RodEvaluator::make_rod(const seld_wire_instrument &table) const
{
    for (double factor = settings_.element_factor;; factor *= coarser) {
        seld_wire_instrument meshed = table;
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
    const seld_wire_instrument table =
        shortened(virtual_instrument(instrument_.table, values_of(values), case_),
                  case_.depths.back().inserted_mm + outside_mm);
    const std::unique_ptr<CoreRod> rod = make_rod(table);
    Insertion result;
    Hand hand(*rod, case_, settings_, result);
    hand.turn_first();
    for (std::size_t i = 0; i < depth_count && i < case_.depths.size(); i++) {
        hand.feed_to(case_.depths[i].inserted_mm);
        hand.rest();
        result.nodes_mm.push_back(rod->nodes_mm());
    }
    return result;
}

std::string RodEvaluator::settings_text() const
{
    const InsertionSettings &s = settings_;
    return "rod 1 start " + number(s.start_mm) + " speed " + number(s.speed_mm_per_s) + " still " +
           number(s.still_um_per_tick) + " for " + std::to_string(s.still_ticks) + " at most " +
           std::to_string(s.settle_max_ticks) + " elements " + number(s.element_factor);
}

double Parameter::value_at(double share) const
{
    return is_logarithmic ? low * std::pow(high / low, share) : low + (high - low) * share;
}

double Parameter::share_of(double value) const
{
    const double share =
        is_logarithmic ? std::log(value / low) / std::log(high / low) : (value - low) / (high - low);
    return std::clamp(share, 0.0, 1.0);
}

} // namespace seld::calibrate
