#include "tools/lab/calibrate/corde_rod.hpp"
#include "tools/lab/calibrate/fitted_instrument.hpp"
#include "tools/lab/case/stiffness.hpp"
#include <algorithm>
#include <cmath>
#include <numbers>

namespace crn::calibrate
{
namespace
{

using vcsim3::JointProperties, vcsim3::RodProperties;

constexpr double tick_s = 1e-3, radian = std::numbers::pi / 180.0;
// The constants limit two products: the time step times the highest angular frequency of the points, and the
// time step times that of the segments' rotation. The integration is stable while the root of the sum of the
// squares of these two products is below 2; the margin covers compressed segments and large rotations.
constexpr double point_ratio = 1.5, turn_ratio = 0.9;
constexpr double passed_mm = 3.0; // a rod deeper in the wall has passed through it

// Returns EI, GJ and the resting angle of a joint between two elements. Compliance and curvature are summed
// over the two half elements beside the joint.
JointProperties joint_at(const crn_wire_instrument &table, const CordeValues &values, double arc_mm,
                         double element_mm)
{
    constexpr int samples = 16;
    const insertion::Stiffness file = insertion::stiffness_of(table);
    double bend = 0.0, twist = 0.0; // compliances
    Vector3d turn_rad = Vector3d::Zero();
    for (int i = 0; i < samples; i++) {
        const crn_wire_knot knot = knot_at(table, arc_mm + element_mm * ((i + 0.5) / samples - 0.5), false);
        const double weight = insertion::tip_weight(knot.bend_stiffness_nN_m2 * 1e-9, file);
        const double bend_N_m2 = values.bend_N_m2() * std::pow(values.tip_over_shaft, weight);
        bend += 1.0 / (samples * bend_N_m2);
        twist += knot.bend_stiffness_nN_m2 / (samples * bend_N_m2 * knot.twist_stiffness_nN_m2);
        // A rotation about the second axis bends the tip towards the first axis; this rotation turns the
        // direction of the tip-side segment into that of the hand-side segment.
        turn_rad += element_mm * 1e-6 / samples *
                    Vector3d(-knot.rest_curvature2_per_m_milli, knot.rest_curvature1_per_m_milli, 0.0);
    }
    return {1.0 / bend, 1.0 / twist, vcsim3::rest_strain(turn_rad, element_mm * 1e-3)};
}

// Chooses the number of substeps that the rod's real mass requires, up to the given maximum, and then the
// mass for which the rod is stable with this number of substeps. The rotational inertia affects only the
// numerical integration, so we choose the value that makes rotation as stable as translation.
void choose_steps(CordeModel &model, double real_kg_per_m, int substeps_max)
{

    RodProperties &rod = model.properties;
    const double fastest =
        2.0 / rod.element_m * std::sqrt(rod.parallel_N); // divided by the root of kg/m, per s
    const double wanted = std::ceil(fastest / std::sqrt(real_kg_per_m) * tick_s / point_ratio);
    model.substeps = static_cast<int>(std::clamp(wanted, 1.0, double(substeps_max)));
    const double step_s = tick_s / model.substeps;
    rod.mass_kg_per_m = std::max(real_kg_per_m, std::pow(fastest * step_s / point_ratio, 2));
    model.mass_scale = rod.mass_kg_per_m / real_kg_per_m;
    double bend = 0.0, twist = 0.0;
    for (const JointProperties &joint : rod.joints) {
        bend = std::max(bend, joint.bend_N_m2);
        twist = std::max(twist, joint.twist_N_m2);
    }
    const double l = rod.element_m, per_turn = std::pow(step_s / turn_ratio, 2);
    rod.inertia_bend_kg_m = (rod.parallel_N + 4.0 * bend / (l * l)) * per_turn;
    rod.inertia_twist_kg_m = std::max(2.0 * rod.inertia_bend_kg_m, 4.0 * twist / (l * l) * per_turn);
}

vcsim3::SimulationSettings simulation_settings(const CordeModel &model, const CordeSettings &settings)
{
    vcsim3::SimulationSettings simulation;
    simulation.mode = settings.mode;
    simulation.substeps = model.substeps;
    return simulation;
}

} // namespace

double CordeValues::area_m2() const
{
    return std::numbers::pi * radius_mm * radius_mm * 1e-6;
}

double CordeValues::bend_N_m2() const
{
    return young_Pa * area_m2() * radius_mm * radius_mm * 1e-6 / 4.0;
}

Vector3d zero_turn_axis(const Vector3d &direction)
{
    int least = 0;
    for (int k = 1; k < 3; k++)
        if (std::abs(direction[k]) < std::abs(direction[least])) least = k;
    return Vector3d::Unit(least).cross(direction).normalized();
}

CordeModel corde_model(const crn_wire_instrument &table, const CordeValues &values, const insertion::Case &c,
                       const CordeSettings &settings, double length_mm)
{
    CordeModel model;
    RodProperties &rod = model.properties;
    const double element_mm = settings.element_mm * settings.element_factor;
    rod.element_count = std::max(2, static_cast<int>(std::ceil(length_mm / element_mm)));
    rod.element_m = element_mm * 1e-3;
    rod.parallel_N = values.parallel_N;
    rod.radius_m = values.radius_mm * 1e-3;
    rod.friction = c.friction_kinetic;
    rod.drag_per_s = settings.drag_per_s;
    rod.spin_drag_per_s = settings.spin_drag_per_s;
    for (int node = 1; node < rod.element_count; node++)
        rod.joints.push_back(joint_at(table, values, node * element_mm, element_mm));
    const double real_kg_per_m = values.density_kg_m3 * values.area_m2();
    rod.weight_N_per_m = real_kg_per_m * c.gravity_m_s2;
    choose_steps(model, real_kg_per_m, settings.substeps_max);
    return model;
}

CordeRod::CordeRod(const CordeModel &model, const insertion::Case &c, const vcsim3::Wall &wall,
                   const CordeSettings &settings)
    : simulation_(model.properties,
                  vcsim3::Inserter(c.mouth_mm * 1e-3, c.direction, zero_turn_axis(c.direction)), wall,
                  simulation_settings(model, settings), settings.start_mm * 1e-3)
{
}

void CordeRod::tick(double hand_mm, double turn_deg)
{
    simulation_.tick(hand_mm * 1e-3 - simulation_.inserted_m(), turn_deg * radian - simulation_.turn_rad());
}

double CordeRod::inserted_mm() const
{
    return simulation_.inserted_m() * 1e3;
}

double CordeRod::handle_axial_mN() const
{
    return simulation_.handle_axial_mean_N() * 1e3;
}

bool CordeRod::is_sound() const
{
    const vcsim3::Rod &rod = simulation_.rod();
    if (!vcsim3::is_sound_within(rod, 1.2 * rod.properties.element_m * rod.properties.element_count))
        return false;
    return std::all_of(simulation_.contacts().begin(), simulation_.contacts().end(),
                       [](const vcsim3::Contact &contact) { return contact.depth_m < passed_mm * 1e-3; });
}

std::vector<Vector3d> CordeRod::nodes_mm() const
{
    const vcsim3::Rod &rod = simulation_.rod();
    std::vector<Vector3d> nodes;
    for (int i = 0; i < std::min(rod.free_count, rod.node_count()); i++)
        nodes.push_back(rod.position[i] * 1e3);
    return nodes;
}

} // namespace crn::calibrate
