#include "tools/lab/vcsim3/direct.hpp"
#include "tools/lab/vcsim3/core_blocks.hpp"
#include <stdexcept>

namespace vcsim3
{
namespace
{

std::uint32_t scaled(double value, double scale)
{
    return static_cast<std::uint32_t>(std::lround(value * scale));
}

crn_knot knot_at(const DirectProperties &p, double arc_m)
{
    crn_knot knot{};
    knot.arc_um = scaled(arc_m, 1e6);
    knot.bend_stiffness_nN_m2 = scaled(p.bend_N_m2, 1e9);
    knot.twist_stiffness_nN_m2 = scaled(p.twist_N_m2, 1e9);
    knot.mass_mg_per_m = scaled(p.mass_kg_per_m, 1e6);
    knot.radius_outer_um = scaled(p.radius_m, 1e6);
    knot.friction_kinetic_milli = knot.friction_static_milli = scaled(p.friction, 1e3);
    return knot;
}

crn_instrument instrument_of(const DirectProperties &p)
{
    crn_instrument instrument{};
    instrument.knot_count = 2;
    instrument.knots[0] = knot_at(p, 0.0);
    instrument.knots[1] = knot_at(p, p.length_m);
    instrument.axial_stiffness_max_N = scaled(p.axial_max_N, 1.0);
    instrument.element_tip_um = instrument.element_shaft_um = scaled(p.element_m, 1e6);
    return instrument;
}

} // namespace

struct DirectRod::Core : CoreBlocks {
    double hand_m = 0.0;
};

DirectRod::DirectRod(const DirectProperties &properties, const crn_lumen &lumen, const Vector &mouth_m,
                     const Vector &direction, double inserted_m)
    : core_(std::make_unique<Core>())
{
    const crn_instrument instrument = instrument_of(properties);
    crn_entry entry{};
    for (int k = 0; k < 3; k++) {
        entry.position_m_q30.v[k] = to_q30(mouth_m[k]);
        entry.direction_q30.v[k] = to_q30(direction[k]);
    }
    crn_build_place place{};
    const crn_build_status status = crn_model_build(core_->model, &instrument, 1, &lumen, &entry, &place);
    if (status != CRN_BUILD_OK)
        throw std::runtime_error("the core refuses the direct solver's rod: build status " +
                                 std::to_string(static_cast<int>(status)) + ", knot " +
                                 std::to_string(place.knot) +
                                 "; see crn_build_status in firmware/core/core.h");
    crn_model_set_gravity(core_->model, 0, 0, 0);
    const std::uint32_t inserted_um[CRN_TOOL_MAX] = {scaled(inserted_m, 1e6)};
    crn_state_init(core_->model, core_->state, inserted_um);
}

DirectRod::DirectRod(DirectRod &&) noexcept = default;
DirectRod::~DirectRod() = default;

void DirectRod::tick(double feed_m)
{
    core_->hand_m += feed_m;
    core_->input.hands[0].feed_m_q30 = to_q30(core_->hand_m);
    crn_step(core_->model, core_->state, &core_->input, &core_->output);
}

double DirectRod::inserted_m() const
{
    return from_q(core_->output.tools[0].inserted_m_q30, 30);
}

double DirectRod::handle_axial_N() const
{
    return from_q(core_->output.tools[0].axial_N_q22, 22);
}

double DirectRod::depth_max_m() const
{
    return from_q(core_->output.penetration_max_m_q30, 30);
}

int DirectRod::contact_count() const
{
    return core_->output.contact_count;
}

int DirectRod::solve_count() const
{
    return core_->output.solve_count;
}

std::vector<Vector> DirectRod::positions() const
{
    const std::uint32_t free = crn_state_free_count(core_->state);
    std::vector<Vector> positions;
    for (std::uint32_t i = 0; i <= free && i < crn_state_node_count(core_->model); i++) {
        const crn_vec3 p = crn_state_position(core_->state, i);
        positions.emplace_back(from_q(p.v[0], 30), from_q(p.v[1], 30), from_q(p.v[2], 30));
    }
    return positions;
}

std::vector<bool> DirectRod::touching() const
{
    const std::uint32_t free = crn_state_free_count(core_->state);
    std::vector<bool> touching(positions().size(), false);
    crn_vec3 force;
    for (std::uint32_t i = 0; i < free && i < touching.size(); i++)
        touching[i] = crn_state_contact_force(core_->model, core_->state, i, &force);
    return touching;
}

std::vector<std::uint8_t> DirectRod::save() const
{
    std::vector<std::uint8_t> bytes(crn_state_bytes());
    crn_state_save(core_->state, bytes.data());
    return bytes;
}

bool DirectRod::restore(const std::vector<std::uint8_t> &bytes)
{
    return bytes.size() == crn_state_bytes() && crn_state_restore(core_->model, core_->state, bytes.data());
}

double DirectRod::length_error() const
{
    const std::vector<Vector> nodes = positions();
    double length = 0.0, rest = 0.0;
    for (std::size_t j = 0; j + 1 < nodes.size(); j++) {
        length += (nodes[j + 1] - nodes[j]).norm();
        rest += from_q(crn_model_edge_length(core_->model, static_cast<std::uint32_t>(j)), 30);
    }
    return rest > 0.0 ? length / rest - 1.0 : 0.0;
}

} // namespace vcsim3
