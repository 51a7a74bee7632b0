// Computes the elastic energies of the rod model CoRdE and their gradients. In the following formulas l is
// the rest length, e = x[j+1] - x[j], t = e/|e|, and d3 is the third director:
//   parallel  l Kp/2 |t - d3|^2                           per segment
//   bending   l/2 (EI (u1^2 + u2^2) + GJ u3^2)            per joint, u = (4/l) v/(1+w), (w, v) = q[j]* q[j+1],
//                                                         less u at rest
//   stretch   Ks/(2 l) (|e| - l)^2                        per segment, in the penalty mode only
//
// In CoRdE, the strain u of a joint is 2/|q|^2 B q.q', where q is the mean of the two segments' quaternions
// and q' is their difference divided by the length l of a segment. For unit quaternions and segments of
// length l, the strain u is 4/l tan(angle/4) about the axis of the rotation between the segments. Every node
// carries the weight of one whole element.
#include "tools/lab/vcsim3/rod.hpp"

namespace vcsim3
{
namespace
{

// Returns half the tangent of a quarter of the rotation angle between two segments, as a vector in the axes
// of either segment.
Vector quarter_tangent(const Quaternion &a, const Quaternion &b)
{
    const Quaternion relative = a.conjugate() * b;
    const double sign = relative.w() < 0.0 ? -1.0 : 1.0; // q and -q are the same orientation
    return sign * relative.vec() / (1.0 + sign * relative.w());
}

struct Bent {
    Vector strain, moment; // relative to the rest state
};

Bent bent_from_rest(const RodProperties &p, int node, const Vector &strain)
{
    if (p.joints.empty())
        return {strain, {p.bend_N_m2 * strain.x(), p.bend_N_m2 * strain.y(), p.twist_N_m2 * strain.z()}};
    const JointProperties &joint = p.joints[node - 1];
    const Vector off = strain - joint.rest_strain;
    return {off, {joint.bend_N_m2 * off.x(), joint.bend_N_m2 * off.y(), joint.twist_N_m2 * off.z()}};
}

// The joint at the first node that the hand holds represents only half a cell, because the other half is
// inside the introducer.
double joint_weight(const Rod &rod, int joint_node)
{
    return joint_node >= rod.free_count ? 2.0 : 1.0;
}

void add_joint_torques(Rod &rod, int node)
{
    const int tip_side = node - 1, hand_side = node;
    const Vector s = quarter_tangent(rod.orientation[tip_side], rod.orientation[hand_side]);
    const Vector m = joint_weight(rod, node) *
                     bent_from_rest(rod.properties, node, 4.0 / rod.properties.element_m * s).moment;
    const Vector even = (1.0 - s.squaredNorm()) * m + 2.0 * s * s.dot(m);
    const Vector odd = 2.0 * m.cross(s);
    rod.torque[tip_side] += even - odd;
    rod.torque[hand_side] -= even + odd;
}

void add_segment_forces(Rod &rod, int j)
{
    const RodProperties &p = rod.properties;
    const Vector e = rod.position[j + 1] - rod.position[j];
    const double length = e.norm();
    const Vector t = e / length, d3 = rod.director(j);
    Vector pull = p.element_m * p.parallel_N / length * (d3 - t * t.dot(d3));
    pull -= p.stretch_N * (length / p.element_m - 1.0) * t;
    rod.force[j + 1] += pull;
    rod.force[j] -= pull;
    const Vector t_body = rod.orientation[j].conjugate() * t;
    rod.torque[j] += p.element_m * p.parallel_N * Vector(-t_body.y(), t_body.x(), 0.0);
}

} // namespace

void add_elastic_forces(Rod &rod)
{
    const Vector weight_N = rod.properties.element_m * rod.properties.weight_N_per_m;
    std::fill(rod.force.begin(), rod.force.end(), weight_N);
    std::fill(rod.torque.begin(), rod.torque.end(), Vector::Zero());
    const int segments = std::min(rod.free_count, rod.properties.element_count);
    for (int j = 0; j < segments; j++) add_segment_forces(rod, j);
    for (int node = 1; node <= rod.free_count && node < rod.properties.element_count; node++)
        add_joint_torques(rod, node);
}

Energy energy_of(const Rod &rod)
{
    const RodProperties &p = rod.properties;
    Energy energy;
    for (int j = 0; j < std::min(rod.free_count, p.element_count); j++) {
        const Vector e = rod.position[j + 1] - rod.position[j];
        const double length = e.norm();
        energy.parallel += 0.5 * p.element_m * p.parallel_N * (e / length - rod.director(j)).squaredNorm();
        energy.stretch += 0.5 * p.stretch_N / p.element_m * (length - p.element_m) * (length - p.element_m);
        const Vector &w = rod.spin[j];
        energy.kinetic +=
            0.5 * p.element_m *
            (p.inertia_bend_kg_m * (w.x() * w.x() + w.y() * w.y()) + p.inertia_twist_kg_m * w.z() * w.z());
    }
    for (int node = 0; node < std::min(rod.free_count, rod.node_count()); node++)
        energy.kinetic += 0.5 * rod.node_mass_kg() * rod.velocity[node].squaredNorm();
    for (int node = 1; node <= rod.free_count && node < p.element_count; node++) {
        const Bent u = bent_from_rest(
            p, node, 4.0 / p.element_m * quarter_tangent(rod.orientation[node - 1], rod.orientation[node]));
        energy.bend_and_twist += 0.5 * p.element_m * joint_weight(rod, node) * u.strain.dot(u.moment);
    }
    return energy;
}

} // namespace vcsim3
