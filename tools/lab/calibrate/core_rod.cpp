#include "tools/lab/calibrate/core_rod.hpp"
#include "tools/lab/vcsim3/core_blocks.hpp"

namespace crn::calibrate
{
namespace
{

using vcsim3::from_q, vcsim3::to_q30;

constexpr double m_of_mm = 1e-3;

// Converts the instrument table as the device does when it receives a table (firmware/app/app_setup.c), but
// leaves out balloons, because no calibration uses one.
crn_instrument tool_of(const crn_wire_instrument &table)
{
    crn_instrument tool{};
    tool.knot_count = table.knots_count;
    tool.lumen_friction_milli = table.lumen_friction_milli;
    tool.axial_stiffness_max_N = table.axial_stiffness_max_N;
    tool.element_tip_um = table.element_tip_um;
    tool.element_shaft_um = table.element_shaft_um;
    tool.element_fine_um = table.element_fine_um;
    tool.material = {.kind = table.material_kind,
                     .yield_strain_micro = table.yield_strain_micro,
                     .core_modulus_MPa = table.core_modulus_MPa,
                     .hardening_milli = table.hardening_milli,
                     .unload_milli = table.unload_milli,
                     .limit_milli = table.limit_milli};
    for (unsigned i = 0; i < table.knots_count; i++) {
        const crn_wire_knot &from = table.knots[i];
        crn_knot &to = tool.knots[i];
        to.arc_um = from.arc_um;
        to.bend_stiffness_nN_m2 = from.bend_stiffness_nN_m2;
        to.twist_stiffness_nN_m2 = from.twist_stiffness_nN_m2;
        to.mass_mg_per_m = from.mass_mg_per_m;
        to.radius_outer_um = from.radius_outer_um;
        to.radius_inner_um = from.radius_inner_um;
        to.friction_kinetic_milli = from.friction_kinetic_milli;
        to.friction_static_milli = from.friction_static_milli;
        to.rest_curvature1_per_m_milli = from.rest_curvature1_per_m_milli;
        to.rest_curvature2_per_m_milli = from.rest_curvature2_per_m_milli;
    }
    return tool;
}

} // namespace

struct CoreRod::Core : vcsim3::CoreBlocks {
    double start_mm = 0.0;
};

CoreRod::CoreRod(const crn_wire_instrument &table, const crn_lumen *lumen, const Vector3d &mouth_mm,
                 const Vector3d &direction, const Vector3d &gravity_m_s2, double inserted_mm)
    : core_(std::make_unique<Core>())
{
    const crn_instrument tool = tool_of(table);
    crn_entry entry{};
    for (int k = 0; k < 3; k++) {
        entry.position_m_q30.v[k] = to_q30(mouth_mm[k] * m_of_mm);
        entry.direction_q30.v[k] = to_q30(direction[k]);
    }
    crn_build_place place{};
    const crn_build_status status = crn_model_build(core_->model, &tool, 1, lumen, &entry, &place);
    if (status != CRN_BUILD_OK)
        throw TrialRefused("the core refuses the instrument: build status " +
                           std::to_string(static_cast<int>(status)) + ", knot " + std::to_string(place.knot) +
                           "; see crn_build_status in firmware/core/core.h");
    const auto mm_s2 = [&](int k) { return static_cast<std::int32_t>(std::lround(gravity_m_s2[k] * 1e3)); };
    crn_model_set_gravity(core_->model, mm_s2(0), mm_s2(1), mm_s2(2));
    const std::uint32_t inserted_um[CRN_TOOL_MAX] = {
        static_cast<std::uint32_t>(std::lround(inserted_mm * 1e3))};
    crn_state_init(core_->model, core_->state, inserted_um);
    core_->start_mm = from_q(crn_state_inserted(core_->state, 0), 30) * 1e3;
}

CoreRod::~CoreRod() = default;

unsigned CoreRod::version()
{
    return CRN_CORE_VERSION;
}

void CoreRod::tick(double hand_mm, double turn_deg)
{
    Core &c = *core_;
    const double turns = turn_deg / 360.0;
    c.input.hands[0].feed_m_q30 = to_q30((hand_mm - c.start_mm) * m_of_mm);
    c.input.hands[0].turn32 =
        static_cast<std::uint32_t>(static_cast<std::int64_t>(std::llround(std::ldexp(turns, 32))));
    crn_step(c.model, c.state, &c.input, &c.output);
}

double CoreRod::inserted_mm() const
{
    return from_q(crn_state_inserted(core_->state, 0), 30) * 1e3;
}

double CoreRod::handle_axial_mN() const
{
    return from_q(core_->output.tools[0].axial_N_q22, 22) * 1e3;
}

bool CoreRod::is_sound() const
{
    return (core_->output.fault_bits & (CRN_FAULT_SATURATED | CRN_FAULT_OUTSIDE)) == 0;
}

std::vector<Vector3d> CoreRod::nodes_mm() const
{
    const std::uint32_t free = crn_state_free_count(core_->state);
    std::vector<Vector3d> nodes;
    for (std::uint32_t i = 0; i < free; i++) {
        const crn_vec3 p = crn_state_position(core_->state, i);
        nodes.emplace_back(from_q(p.v[0], 30) * 1e3, from_q(p.v[1], 30) * 1e3, from_q(p.v[2], 30) * 1e3);
    }
    return nodes;
}

} // namespace crn::calibrate
