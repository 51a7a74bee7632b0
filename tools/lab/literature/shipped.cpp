#include "tools/lab/literature/shipped.hpp"
#include "host/model/instrument.hpp"

namespace crn::literature
{

namespace
{

Instrument shipped(const std::string &name)
{
    return read_instrument("shared/examples/instruments/" + name + ".toml");
}

validate::Knot knot_of(const crn_wire_knot &from)
{
    return {.arc_m = from.arc_um * 1e-6,
            .bend_N_m2 = from.bend_stiffness_nN_m2 * 1e-9,
            .twist_N_m2 = from.twist_stiffness_nN_m2 * 1e-9,
            .mass_kg_per_m = from.mass_mg_per_m * 1e-6,
            .radius_m = from.radius_outer_um * 1e-6,
            .radius_inner_m = from.radius_inner_um * 1e-6,
            .friction = from.friction_kinetic_milli * 1e-3,
            .friction_static = from.friction_static_milli * 1e-3};
}

} // namespace

validate::Tool shipped_tool(const std::string &name, double length_m, double element_m)
{
    const Instrument instrument = shipped(name);
    validate::Tool tool;
    tool.element_m = element_m;
    tool.axial_stiffness_max_N = instrument.table.axial_stiffness_max_N;
    for (std::size_t i = 0; i < instrument.table.knots_count; i++) {
        validate::Knot knot = knot_of(instrument.table.knots[i]);
        if (knot.arc_m < length_m) tool.knots.push_back(knot);
    }
    validate::Knot end = tool.knots.back(); // as stiff as where the tool is cut, within one step of its taper
    end.arc_m = length_m;
    tool.knots.push_back(end);
    return tool;
}

double shaft_bend_N_m2(const std::string &name)
{
    const Instrument instrument = shipped(name);
    return instrument.table.knots[instrument.table.knots_count - 1].bend_stiffness_nN_m2 * 1e-9;
}

} // namespace crn::literature
