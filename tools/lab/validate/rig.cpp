#include "tools/lab/validate/rig.hpp"

extern "C" {
#include "firmware/core/core_state.h"
}

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

namespace crn::validate
{

namespace
{

constexpr double Q22 = 1 << 22, Q24 = 1 << 24, Q30 = 1 << 30, Q33 = 8 * Q30, turn32 = 4294967296.0;

std::uint32_t micro(double value)
{
    return std::uint32_t(std::lround(value * 1e6));
}

crn_vec3 fixed(const Vector3d &v, double one)
{
    return crn_vec3_make(std::int32_t(std::lround(v[0] * one)), std::int32_t(std::lround(v[1] * one)),
                         std::int32_t(std::lround(v[2] * one)));
}

Vector3d real(const crn_vec3 &v, double one)
{
    return Vector3d(v.v[0], v.v[1], v.v[2]) / one;
}

crn_instrument instrument_of(const Tool &tool)
{
    crn_instrument instrument{};
    instrument.knot_count = std::uint32_t(tool.knots.size());
    if (tool.knots.size() > CRN_KNOT_MAX) throw std::runtime_error("rig: too many knots");
    for (std::size_t i = 0; i < tool.knots.size(); i++) {
        const Knot &from = tool.knots[i];
        crn_knot &to = instrument.knots[i];
        to.arc_um = micro(from.arc_m);
        to.bend_stiffness_nN_m2 = std::uint32_t(std::lround(from.bend_N_m2 * 1e9));
        to.twist_stiffness_nN_m2 = std::uint32_t(std::lround(from.twist_N_m2 * 1e9));
        to.mass_mg_per_m = micro(from.mass_kg_per_m);
        to.radius_outer_um = micro(from.radius_m);
        to.radius_inner_um = micro(from.radius_inner_m);
        const double held = from.friction_static < 0 ? from.friction : from.friction_static;
        to.friction_kinetic_milli = std::uint32_t(std::lround(from.friction * 1e3));
        to.friction_static_milli = std::uint32_t(std::lround(held * 1e3));
        to.rest_curvature1_per_m_milli = std::int32_t(std::lround(from.rest_curvature_per_m * 1e3));
    }
    instrument.lumen_friction_milli = std::uint32_t(std::lround(tool.lumen_friction * 1e3));
    instrument.axial_stiffness_max_N = std::uint32_t(std::lround(tool.axial_stiffness_max_N));
    instrument.element_tip_um = instrument.element_shaft_um = micro(tool.element_m);
    return instrument;
}

} // namespace

Tool uniform_tool(const Knot &knot, double length_m, double element_m)
{
    Tool tool;
    tool.knots = {knot, knot};
    tool.knots[0].arc_m = 0;
    tool.knots[1].arc_m = length_m;
    tool.element_m = element_m;
    return tool;
}

struct Rig::Core {
    crn_model model;
    crn_state state;
    crn_input input{};
    crn_output output{};
    double base_angle[CRN_TOOL_MAX] = {};
};

Rig::Rig(const std::vector<Tool> &tools, const LumenField *field, const Start &start)
    : core_(std::make_unique<Core>())
{
    std::vector<crn_instrument> instruments;
    std::uint32_t inserted_um[CRN_TOOL_MAX] = {};
    for (std::size_t k = 0; k < tools.size() && k < CRN_TOOL_MAX; k++) {
        instruments.push_back(instrument_of(tools[k]));
        inserted_um[k] = micro(start.inserted_m.at(k));
    }
    crn_entry entry{fixed(start.mouth_m, Q30), fixed(start.direction, Q30), start.blood_kg_m3};
    crn_build_place place{};
    crn_build_status status =
        crn_model_build(&core_->model, instruments.data(), std::uint32_t(instruments.size()),
                        field ? field->lumen() : nullptr, &entry, &place);
    if (status != CRN_BUILD_OK) {
        throw std::runtime_error("rig: the core refuses tool " + std::to_string(place.tool) + ", knot " +
                                 std::to_string(place.knot) + " with status " + std::to_string(status));
    }
    crn_model_set_gravity(&core_->model, 0, 0, 0);
    set_stall(400);
    crn_state_init(&core_->model, &core_->state, inserted_um);
}

Rig::~Rig() = default;
Rig::Rig(Rig &&) noexcept = default;

// --- loads and supports of the rod ---

void Rig::set_gravity(const Vector3d &m_s2)
{
    crn_vec3 mm = fixed(m_s2, 1e3);
    crn_model_set_gravity(&core_->model, mm.v[0], mm.v[1], mm.v[2]);
}

void Rig::set_tip_load(const Vector3d &N)
{
    crn_model_set_tip_load(&core_->model, fixed(N, Q22));
}

void Rig::set_hold(const Hold &hold)
{
    crn_tip_hold h{};
    h.pinned = true;
    h.second = hold.second;
    h.axial_free = hold.axial_free;
    h.turn = hold.turn;
    h.axis_q30 = fixed(Vector3d::UnitX(), Q30);
    h.position_m_q30[0] = fixed(hold.anchor_m, Q30);
    h.position_m_q30[1] = fixed(hold.second_anchor_m, Q30);
    crn_model_set_tip_hold(&core_->model, &h);
}

// The core controls the tip's angle relative to an axis that follows the rod without twist from the
// introducer to the tip. When the rod coils, the axis that follows the rod without twist itself rotates at
// the tip (writhe). To keep the tip from rotating in space, the controlled angle must be the negative of the
// angle by which the axis rotates (writhe).
void Rig::hold_in_space()
{
    crn_model &model = core_->model;
    Vector3d start = real(model.base_axis1_q30, Q30), axis = start;
    Vector3d tangent = -real(model.entry.direction_q30, Q30), first = tangent;
    auto carry = [](const Vector3d &u, const Vector3d &from, const Vector3d &to) {
        return Vector3d(u - u.dot(to) / (1 + from.dot(to)) * (from + to)).normalized();
    };
    for (unsigned i = free_count(); i-- > 0;) {
        Vector3d ahead = (position(i + 1) - position(i)).normalized();
        axis = carry(axis, tangent, ahead);
        tangent = ahead;
    }
    Vector3d still = carry(start, first, tangent);
    double turned = std::atan2(tangent.dot(still.cross(axis)), still.dot(axis));
    model.hold.turn32 = std::uint32_t(std::int64_t(std::llround(-turned / (2 * M_PI) * turn32)));
}

void Rig::set_stall(double N)
{
    core_->model.stall_N_q22 = std::int32_t(std::lround(N * Q22));
}

void Rig::feed(double m, unsigned tool)
{
    core_->input.hands[tool].feed_m_q30 = std::int32_t(std::lround(m * Q30));
}

void Rig::turn(double rad, unsigned tool)
{
    double turns = rad / (2 * M_PI);
    core_->input.hands[tool].turn32 =
        std::uint32_t(std::int64_t(std::llround((turns - std::floor(turns)) * turn32)));
}

void Rig::step(int ticks)
{
    Core &c = *core_;
    for (int tick = 0; tick < ticks; tick++) {
        std::uint32_t before[CRN_TOOL_MAX];
        for (unsigned k = 0; k < CRN_TOOL_MAX; k++) before[k] = c.state.words.tools[k].base_turn32;
        if (c.model.hold.turn) hold_in_space();
        crn_step(&c.model, &c.state, &c.input, &c.output);
        for (unsigned k = 0; k < CRN_TOOL_MAX; k++) {
            auto moved = std::int32_t(c.state.words.tools[k].base_turn32 - before[k]);
            c.base_angle[k] += moved / turn32 * 2 * M_PI;
        }
    }
}

void Rig::place(const std::vector<Vector3d> &positions_m)
{
    crn_node_state *nodes = core_->state.words.nodes;
    unsigned count = free_count();
    if (positions_m.size() < count) throw std::runtime_error("rig: a position for every free node, please");
    for (unsigned i = 0; i < count; i++) nodes[i].position_m_q30 = fixed(positions_m[i], Q30);
    for (unsigned i = 0; i < count; i++) {
        Vector3d ahead = position(i + 1) - position(i);
        nodes[i].tangent_q30 = fixed(ahead.normalized(), Q30);
        nodes[i].step_m_q33 = nodes[i].bristle_m_q33 = crn_vec3_make(0, 0, 0);
    }
}

// --- measurements ---

unsigned Rig::free_count() const
{
    return crn_state_free_count(&core_->state);
}

Vector3d Rig::position(unsigned node) const
{
    return real(crn_state_position(&core_->state, node), Q30);
}

std::vector<Vector3d> Rig::shape() const
{
    std::vector<Vector3d> points;
    for (unsigned i = 0; i < free_count(); i++) points.push_back(position(i));
    points.push_back(real(core_->model.entry.position_m_q30, Q30));
    return points;
}

double Rig::arc(unsigned node) const
{
    return crn_model_arc(&core_->model, node) / Q30;
}

double Rig::inserted(unsigned tool) const
{
    return crn_state_inserted(&core_->state, tool) / Q30;
}

double Rig::handle_axial(unsigned tool) const
{
    return core_->output.tools[tool].axial_N_q22 / Q22;
}

double Rig::handle_torque(unsigned tool) const
{
    return core_->output.tools[tool].torque_N_m_q24 / Q24;
}

double Rig::base_angle(unsigned tool) const
{
    return core_->base_angle[tool];
}

// Angles of the rod's frames are counted about tangents that point to the hand. The angles of the hand are
// counted about the direction of insertion, and those of the rod about the opposite direction, so the two
// have opposite signs.
double Rig::tip_angle(unsigned tool) const
{
    const crn_node_state *nodes = core_->state.words.nodes;
    double twist = 0;
    for (unsigned j = 0; j < free_count(); j++) {
        twist +=
            std::int32_t(nodes[j].angle_turn32[tool] - nodes[j + 1].angle_turn32[tool]) / turn32 * 2 * M_PI;
    }
    return base_angle(tool) - twist;
}

double Rig::length_error() const
{
    return core_->output.strain_max_q30 / Q30;
}

double Rig::penetration() const
{
    return core_->output.penetration_max_m_q30 / Q30;
}

Vector3d Rig::hold_force(unsigned node) const
{
    const crn_tip_hold &hold = core_->model.hold;
    Vector3d miss = real(hold.position_m_q30[node == 0 ? 0 : 1], Q30) - position(node);
    if (hold.axial_free) miss -= miss.dot(real(hold.axis_q30, Q30)) * real(hold.axis_q30, Q30);
    return miss * double(CRN_HOLD_STIFFNESS_N_m);
}

double Rig::motion_per_tick() const
{
    double most = 0;
    for (unsigned i = 0; i < free_count(); i++) {
        most = std::max(most, real(core_->state.words.nodes[i].step_m_q33, Q33).cwiseAbs().maxCoeff());
    }
    return most;
}

std::optional<Vector3d> Rig::contact_force(unsigned node) const
{
    crn_vec3 force;
    if (!crn_state_contact_force(&core_->model, &core_->state, node, &force)) return std::nullopt;
    return real(force, Q22);
}

unsigned Rig::contact_count() const
{
    return core_->output.contact_count;
}

unsigned Rig::solve_count() const
{
    return core_->output.solve_count;
}

bool Rig::saturated() const
{
    return core_->output.fault_bits & CRN_FAULT_SATURATED;
}

bool Rig::capped() const
{
    return core_->output.fault_bits & CRN_FAULT_STEP_CAPPED;
}

} // namespace crn::validate
