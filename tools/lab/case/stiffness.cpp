// Computes EI along an instrument from two numbers: the EI of its shaft, and alpha.
#include "tools/lab/case/stiffness.hpp"
#include "tools/lab/case/case.hpp"
#include <algorithm>
#include <cmath>

namespace crn::insertion
{
namespace
{

constexpr double least_N_m2 = 1e-7, most_N_m2 = 3e-2; // the core's limits (firmware/core/core.h, crn_knot)
constexpr double same = 1e-9;                         // two values of alpha closer than this count as equal

std::uint32_t rounded_nN_m2(double stiffness_N_m2)
{
    return static_cast<std::uint32_t>(std::lround(std::clamp(stiffness_N_m2, least_N_m2, most_N_m2) * 1e9));
}

} // namespace

Stiffness stiffness_of(const crn_wire_instrument &table)
{
    const double tip_nN_m2 = table.knots[0].bend_stiffness_nN_m2;
    const double shaft_nN_m2 = table.knots[table.knots_count - 1].bend_stiffness_nN_m2;
    return {shaft_nN_m2 * 1e-9, tip_nN_m2 / shaft_nN_m2};
}

double tip_weight(double bend_N_m2, const Stiffness &nominal)
{
    const double range = std::log(nominal.tip_over_shaft);
    return std::abs(range) < same ? 0.0 : std::log(bend_N_m2 / nominal.shaft_N_m2) / range;
}

crn_wire_instrument with_stiffness(const crn_wire_instrument &table, const Stiffness &wanted)
{
    const Stiffness nominal = stiffness_of(table);
    if (!(wanted.shaft_N_m2 > 0.0) || !(wanted.tip_over_shaft > 0.0))
        throw Fault("stiffness: EI of the shaft and alpha must be above 0, not " +
                    std::to_string(wanted.shaft_N_m2) + " and " + std::to_string(wanted.tip_over_shaft));
    if (std::abs(std::log(nominal.tip_over_shaft)) < same && std::abs(std::log(wanted.tip_over_shaft)) > same)
        throw Fault("stiffness: alpha shall be " + std::to_string(wanted.tip_over_shaft) +
                    ", but this instrument's tip is as stiff as its shaft, so nothing says where the tip "
                    "ends; give it a soft section");
    crn_wire_instrument out = table;
    for (std::uint32_t i = 0; i < out.knots_count; i++) {
        crn_wire_knot &knot = out.knots[i];
        const double was_N_m2 = knot.bend_stiffness_nN_m2 * 1e-9;
        const double now_N_m2 =
            wanted.shaft_N_m2 * std::pow(wanted.tip_over_shaft, tip_weight(was_N_m2, nominal));
        knot.twist_stiffness_nN_m2 = rounded_nN_m2(knot.twist_stiffness_nN_m2 * 1e-9 * now_N_m2 / was_N_m2);
        knot.bend_stiffness_nN_m2 = rounded_nN_m2(now_N_m2);
    }
    return out;
}

} // namespace crn::insertion
