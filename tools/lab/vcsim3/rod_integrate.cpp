// Makes the state of the rod, and advances this state by explicit integration.
#include "tools/lab/vcsim3/rod.hpp"
#include <algorithm>
#include <cmath>

namespace vcsim3
{

// For the direction -z, the result is a rotation by half a turn about x. The function handles the direction
// -z itself, because the compiler needs 8 s for the singular value decomposition in Eigen's FromTwoVectors.
Quaternion turn_from_z(const Vector &direction)
{
    const Vector to = direction.normalized();
    if (to.z() < -1.0 + 1e-12) return {0.0, 1.0, 0.0, 0.0};
    const double w = std::sqrt(2.0 * (1.0 + to.z())); // twice the cosine of half the angle
    const double inverse = 1.0 / w;
    return {0.5 * w, -to.y() * inverse, to.x() * inverse, 0.0};
}

Vector rest_strain(const Vector &turn_rad, double element_m)
{
    const double angle = turn_rad.norm();
    if (angle <= 0.0) return Vector::Zero();
    return 4.0 / element_m * std::tan(0.25 * angle) / angle * turn_rad;
}

Rod::Rod(const RodProperties &given, const Vector &tip, const Vector &to_hand)
    : properties(given), free_count(given.element_count + 1), position(given.element_count + 1),
      velocity(given.element_count + 1, Vector::Zero()), force(given.element_count + 1, Vector::Zero()),
      orientation(given.element_count, turn_from_z(to_hand)), spin(given.element_count, Vector::Zero()),
      torque(given.element_count, Vector::Zero())
{
    for (int i = 0; i < node_count(); i++) position[i] = tip + i * given.element_m * to_hand;
}

void integrate_velocities(Rod &rod, double step_s)
{
    const RodProperties &p = rod.properties;
    const double keep = 1.0 - p.drag_per_s * step_s, keep_spin = 1.0 - p.spin_drag_per_s * step_s;
    const double step_per_kg = step_s / rod.node_mass_kg();
    for (int i = 0; i < std::min(rod.free_count, rod.node_count()); i++)
        rod.velocity[i] = keep * rod.velocity[i] + step_per_kg * rod.force[i];
    const double bend = p.inertia_bend_kg_m * p.element_m, twist = p.inertia_twist_kg_m * p.element_m;
    for (int j = 0; j < std::min(rod.free_count, p.element_count); j++) {
        const Vector w = rod.spin[j];
        // For the inertia J and the angular velocity w of a segment, the vector w x (J w) has no third
        // component, because the two transverse moments of inertia are equal.
        const double gyro = (twist - bend) * w.z();
        const Vector turning = rod.torque[j] - gyro * Vector(w.y(), -w.x(), 0.0);
        rod.spin[j] =
            keep_spin * w + step_s * Vector(turning.x() / bend, turning.y() / bend, turning.z() / twist);
    }
}

void integrate_positions(Rod &rod, double step_s)
{
    for (int i = 0; i < std::min(rod.free_count, rod.node_count()); i++)
        rod.position[i] += step_s * rod.velocity[i];
    for (int j = 0; j < std::min(rod.free_count, rod.properties.element_count); j++) {
        Quaternion &q = rod.orientation[j];
        const Vector half = 0.5 * step_s * rod.spin[j];
        const Quaternion change = q * Quaternion(0.0, half.x(), half.y(), half.z());
        q.coeffs() += change.coeffs();
        q.normalize();
    }
}

double length_error(const Rod &rod)
{
    const int segments = std::min(rod.free_count, rod.properties.element_count);
    double length = 0.0;
    for (int j = 0; j < segments; j++) length += (rod.position[j + 1] - rod.position[j]).norm();
    return segments > 0 ? length / (segments * rod.properties.element_m) - 1.0 : 0.0;
}

bool is_sound_within(const Rod &rod, double reach_m)
{
    const Vector &centre = rod.position[std::min(rod.free_count, rod.node_count() - 1)];
    return std::all_of(rod.position.begin(), rod.position.end(),
                       [&](const Vector &p) { return p.allFinite() && (p - centre).norm() <= reach_m; });
}

} // namespace vcsim3
