// Models the thesis' rod (CoRdE): segments join mass points, each segment has a unit quaternion, and time
// integration is explicit. Node 0 is the tip. Segment j of the rod joins the nodes j and j+1, and its third
// axis (director) points towards the hand. SI units, doubles.
//   Energies and forces          rod_forces.cpp
//   Explicit integration         rod_integrate.cpp
//   Inserter that feeds the rod  inserter.hpp
#pragma once
#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstddef>
#include <vector>

namespace vcsim3
{

using Vector = Eigen::Vector3d;
using Quaternion = Eigen::Quaterniond;

// Holds the properties of one joint of the rod, for rods that are not uniform or not straight.
struct JointProperties {
    double bend_N_m2 = 0.0, twist_N_m2 = 0.0;
    Vector rest_strain =
        Vector::Zero(); // u of rod_forces.cpp at rest, 1/m, in the segments' axes: rest_strain()
};

// The constants of a rod. All constants are finite and positive unless a comment states otherwise.
struct RodProperties {
    int element_count = 0;      // 2 or more
    double element_m = 0.0;     // rest length of every segment
    double bend_N_m2 = 0.0;     // EI
    double twist_N_m2 = 0.0;    // GJ
    double parallel_N = 0.0;    // Kp: keeps the third director parallel to the segment
    double mass_kg_per_m = 0.0; // mass of the mass points, including the mass scale
    double inertia_bend_kg_m =
        0.0; // inertia of a segment about a transverse axis per length, including both scales
    double inertia_twist_kg_m = 0.0;     // about its own axis
    double radius_m = 0.0;               // radius of the tube that touches the wall
    double friction = 0.0;               // Coulomb, 0 or more
    double drag_per_s = 0.0;             // of the points' velocities, 0 or more
    double spin_drag_per_s = 0.0;        // of the segments' angular velocities, 0 or more
    double stretch_N = 0.0;              // Ks of the penalty mode; 0: constraints hold the lengths
    std::vector<JointProperties> joints; // of node i at [i - 1]; empty: straight, with EI and GJ above
    Vector weight_N_per_m = Vector::Zero();
};

// Node i has a position and a velocity. Segment j has an orientation (from its own axes to the world's axes),
// and an angular velocity in its own axes. The hand holds the nodes from free_count onwards and their
// segments, so no function in this file moves these nodes.
struct Rod {
    RodProperties properties;
    int free_count = 0; // 0 .. element_count + 1
    std::vector<Vector> position, velocity, force;
    std::vector<Quaternion> orientation;
    std::vector<Vector> spin, torque;

    // Makes a straight rod at rest from `tip` in direction `to_hand` (unit), with all nodes free.
    Rod(const RodProperties &given, const Vector &tip, const Vector &to_hand);

    int node_count() const { return static_cast<int>(position.size()); }
    double node_mass_kg() const { return properties.mass_kg_per_m * properties.element_m; }
    double inverse_mass(int node) const { return node < free_count ? 1.0 / node_mass_kg() : 0.0; }
    Vector director(int segment) const { return orientation[segment] * Vector::UnitZ(); }
};

// Returns the smallest rotation that turns +z into a given direction.
Quaternion turn_from_z(const Vector &direction);

// Returns the strain that a joint has in its resting shape, if the hand-side segment is rotated by `turn_rad`
// relative to the tip-side segment. `turn_rad` is the axis of the rotation times its angle, which must be
// below 2 pi.
Vector rest_strain(const Vector &turn_rad, double element_m);

// Computes the force on each node and the torque on each segment (in the segment's axes) from weight and from
// the elastic energies.
void add_elastic_forces(Rod &rod);

// Holds the rod's energies in J, for tests and for monitoring stability.
struct Energy {
    double bend_and_twist = 0.0, parallel = 0.0, stretch = 0.0, kinetic = 0.0;
    double total() const { return bend_and_twist + parallel + stretch + kinetic; }
};
Energy energy_of(const Rod &rod);

// Semi-implicit Euler integration is divided into two functions, so that constraints can change the
// velocities between them.
void integrate_velocities(Rod &rod, double step_s);
void integrate_positions(Rod &rod, double step_s);

// Returns the present length of the free part of the rod divided by its unloaded length, minus 1; the result
// is negative when the rod is compressed.
double length_error(const Rod &rod);

// Returns false when a coordinate is not finite, or when a node is farther than `reach_m` from the first node
// that the hand holds (from the tip if there is none).
bool is_sound_within(const Rod &rod, double reach_m);

} // namespace vcsim3
