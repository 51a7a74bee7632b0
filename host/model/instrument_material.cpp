// Reads the material of a wire's core (docs/instruments.md, "Materials"). The file states the stress-strain
// curve of the material in tension. The code converts this curve to the law that the program firmware/core
// needs, which relates bending moment and curvature.
#include "host/base/format.hpp"
#include "host/model/instrument_parts.hpp"
#include <cmath>
#include <numbers>

namespace crn::instrument_file
{

namespace
{

constexpr NumberRange surface_strain_bounds = {500e-6, 50000e-6},
                      limit_bounds = {0.1, 20.0}; // of crn_material

// The law has straight branches, but a round core yields gradually: its surface first, at the moment M_y, and
// its middle last, at 16/(3 pi) M_y. These branches fit the gradual curve best; docs/instruments.md states
// the errors. The plateau of the law begins beyond M_y, and rises. Where the plateau of the surface ends, a
// round core stiffens gradually, too, so the law's plateau ends later.
constexpr double begin_over_yield = 1.39, hardening = 0.075, limit_over_plateau = 1.2;

std::uint32_t to_count(double value)
{
    return static_cast<std::uint32_t>(std::lround(value));
}

// Reads the key `stress_key`, and puts what both kinds of materials have.
void read_begin(const TomlTable &table, const char *stress_key, double stress_MPa, double modulus_GPa,
                crn_wire_instrument &wire)
{
    const double strain = stress_MPa / (modulus_GPa * 1e3), surface_strain = begin_over_yield * strain;
    if (surface_strain < surface_strain_bounds.low || surface_strain > surface_strain_bounds.high)
        table[stress_key].fail_key(formatted(
            "and 'young_modulus_GPa' make a yield strain of %g, outside %.2g .. %.2g", strain,
            surface_strain_bounds.low / begin_over_yield, surface_strain_bounds.high / begin_over_yield));
    wire.yield_strain_micro = to_count(surface_strain * 1e6);
    wire.core_modulus_MPa = to_count(modulus_GPa * 1e3);
    wire.hardening_milli = to_count(hardening * 1e3);
}

void read_nitinol(const TomlTable &table, crn_wire_instrument &wire)
{
    table.check_keys(
        {"kind", "young_modulus_GPa", "upper_plateau_MPa", "lower_plateau_MPa", "plateau_strain"});
    const double modulus_GPa = table.sourced("young_modulus_GPa", {20.0, 90.0}),
                 upper_MPa = table.sourced("upper_plateau_MPa", {100.0, 1000.0}),
                 lower_MPa = table.sourced("lower_plateau_MPa", {0.0, 0.95 * upper_MPa}),
                 plateau_strain = table.sourced("plateau_strain", {0.005, 0.1});
    read_begin(table, "upper_plateau_MPa", upper_MPa, modulus_GPa, wire);
    const double strain = upper_MPa / (modulus_GPa * 1e3),
                 limit = limit_over_plateau * plateau_strain / (begin_over_yield * strain);
    if (limit < limit_bounds.low || limit > limit_bounds.high)
        table["plateau_strain"].fail_key(formatted(
            "must be %.2g to %.2g, where the plateau begins at a strain of %.2g",
            plateau_strain * limit_bounds.low / limit, plateau_strain * limit_bounds.high / limit, strain));
    wire.unload_milli = to_count(lower_MPa / upper_MPa * 1e3);
    wire.limit_milli = to_count(limit * 1e3);
    wire.material_kind = CRN_WIRE_MATERIAL_SUPERELASTIC;
}

void read_steel(const TomlTable &table, crn_wire_instrument &wire)
{
    table.check_keys({"kind", "young_modulus_GPa", "yield_MPa"});
    const double modulus_GPa = table.sourced("young_modulus_GPa", {20.0, 300.0}),
                 yield_MPa = table.sourced("yield_MPa", {50.0, 4000.0});
    read_begin(table, "yield_MPa", yield_MPa, modulus_GPa, wire);
    wire.material_kind = CRN_WIRE_MATERIAL_METAL;
}

} // namespace

void read_material(const TomlTable &root, InstrumentKind kind, crn_wire_instrument &wire)
{
    const TomlValue material = root["material"];
    if (!material) return;
    if (kind != InstrumentKind::wire)
        material.fail("'material' is for wires, because its law is that of a solid round core; remove it");
    const TomlTable table = material.table().inside("material");
    if (table["kind"].one_of({"nitinol", "steel"}) == "nitinol")
        read_nitinol(table, wire);
    else
        read_steel(table, wire);
}

void check_material(const TomlTable &root, const crn_wire_instrument &wire)
{
    if (wire.material_kind == CRN_WIRE_MATERIAL_ELASTIC) return;
    for (std::uint16_t i = 0; i < wire.knots_count; i++) {
        const crn_wire_knot &knot = wire.knots[i];
        const double radius_um = 1e6 * std::pow(4.0 * knot.bend_stiffness_nN_m2 * 1e-9 /
                                                    (std::numbers::pi * wire.core_modulus_MPa * 1e6),
                                                0.25);
        if (radius_um <= knot.radius_outer_um) continue;
        root.table("material")
            .inside("material")["young_modulus_GPa"]
            .fail_key(formatted("is too low: a round core with the bending stiffness %g N m^2, at %g mm from "
                                "the tip, would be "
                                "%.3g mm thick in a wire of %.3g mm",
                                knot.bend_stiffness_nN_m2 * 1e-9, knot.arc_um * 1e-3, 2e-3 * radius_um,
                                2e-3 * knot.radius_outer_um));
    }
}

void forget_material(crn_wire_instrument &wire)
{
    wire.material_kind = CRN_WIRE_MATERIAL_ELASTIC;
    wire.yield_strain_micro = wire.core_modulus_MPa = 0;
    wire.hardening_milli = wire.unload_milli = wire.limit_milli = 0;
}

} // namespace crn::instrument_file
