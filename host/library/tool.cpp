#include "host/library/tool.hpp"
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>

namespace crn::library
{

namespace
{

std::uint32_t times(std::uint32_t value, double factor)
{
    const double product = std::nearbyint(value * factor);
    return static_cast<std::uint32_t>(std::min(product, double{std::numeric_limits<std::uint32_t>::max()}));
}

std::int32_t times(std::int32_t value, double factor)
{
    constexpr double most = std::numeric_limits<std::int32_t>::max();
    return static_cast<std::int32_t>(std::clamp(std::nearbyint(value * factor), -most, most));
}

void check_factor(const char *name, double value, double least)
{
    if (value >= least && value <= 10.0) return; // refuses NaN, too
    throw Refused(COURNAND_BAD_ARGUMENT, std::string("scales: ") + name + " is " + std::to_string(value) +
                                             ", not within " + std::to_string(least) + " and 10");
}

} // namespace

NamedTool open_tool(const std::string &path)
{
    return {read_instrument(path), std::filesystem::path(split_preset(path).first).stem().string()};
}

void describe(const Instrument &tool, cournand_tool_info &info)
{
    info.is_catheter = tool.kind == InstrumentKind::catheter;
    info.name = tool.name.c_str();
    info.length_m = tool.length_m;
    std::uint32_t radius_um = 0;
    for (std::uint16_t i = 0; i < tool.table.knots_count; i++)
        radius_um = std::max(radius_um, tool.table.knots[i].radius_outer_um);
    info.radius_max_m = radius_um * 1e-6;
    info.has_balloon = tool.balloon.has_value();
}

std::vector<double> marker_arcs(const Instrument &tool)
{
    std::vector<double> arcs_m;
    if (tool.balloon) arcs_m = tool.balloon->marker_arcs_m;
    std::sort(arcs_m.begin(), arcs_m.end());
    return arcs_m;
}

Instrument scaled(const Instrument &tool, const cournand_tool_scales &scales)
{
    check_factor("bend_stiffness", scales.bend_stiffness, 0.1);
    check_factor("twist_stiffness", scales.twist_stiffness, 0.1);
    check_factor("mass", scales.mass, 0.1);
    check_factor("friction", scales.friction, 0.1);
    check_factor("rest_curvature", scales.rest_curvature, -10.0);
    Instrument made = tool;
    for (std::uint16_t i = 0; i < made.table.knots_count; i++) {
        crn_wire_knot &knot = made.table.knots[i];
        knot.bend_stiffness_nN_m2 = times(knot.bend_stiffness_nN_m2, scales.bend_stiffness);
        knot.twist_stiffness_nN_m2 = times(knot.twist_stiffness_nN_m2, scales.twist_stiffness);
        knot.mass_mg_per_m = times(knot.mass_mg_per_m, scales.mass);
        knot.friction_kinetic_milli = times(knot.friction_kinetic_milli, scales.friction);
        knot.friction_static_milli = times(knot.friction_static_milli, scales.friction);
        knot.rest_curvature1_per_m_milli = times(knot.rest_curvature1_per_m_milli, scales.rest_curvature);
        knot.rest_curvature2_per_m_milli = times(knot.rest_curvature2_per_m_milli, scales.rest_curvature);
    }
    for (InstrumentArc &arc : made.shape) {
        arc.curvature1_per_m *= scales.rest_curvature;
        arc.curvature2_per_m *= scales.rest_curvature;
    }
    return made;
}

} // namespace crn::library
