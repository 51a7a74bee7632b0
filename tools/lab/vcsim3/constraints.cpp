#include "tools/lab/vcsim3/constraints.hpp"
#include <algorithm>

namespace vcsim3
{

void DistanceConstraints::prepare(const Rod &rod, double step_s)
{
    const int count = std::min(rod.free_count, rod.properties.element_count);
    normal_.resize(count);
    wanted_m_s_.resize(count);
    mass_kg_.resize(count);
    for (std::vector<double> &gains : gain_) gains.resize(count);
    hand_impulse_.setZero();
    for (int j = 0; j < count; j++) {
        const Vector e = rod.position[j + 1] - rod.position[j];
        const double length = e.norm();
        normal_[j] = e / length;
        for (int end = 0; end < 2; end++) gain_[end][j] = settings_.mixing * rod.inverse_mass(j + end);
        mass_kg_[j] = 1.0 / (rod.inverse_mass(j) + rod.inverse_mass(j + 1));
        wanted_m_s_[j] = -settings_.baumgarte / step_s * (length - rod.properties.element_m);
    }
}

void DistanceConstraints::sweep_local(Rod &rod)
{
    for (int j = count() - 1; j >= 0; j--) {
        const double lacking = wanted_m_s_[j] - normal_[j].dot(rod.velocity[j + 1] - rod.velocity[j]);
        apply(rod, j, lacking * mass_kg_[j]);
    }
}

// The function eliminates the following equations from tip to hand:
//
//    (1/m[j] + 1/m[j+1]) p[j] - (n[j].n[j+1])/m[j+1] p[j+1] - (n[j-1].n[j])/m[j] p[j-1] = lacking[j]
//
// Each pivot of the elimination stays positive, because the matrix is J M^-1 J^T, with the masses M and the
// gradients J of independent constraints.
void DistanceConstraints::solve_global(Rod &rod)
{
    share_.resize(count());
    impulse_.resize(count());
    for (int j = 0; j < count(); j++) {
        double diagonal = rod.inverse_mass(j) + rod.inverse_mass(j + 1);
        double right = wanted_m_s_[j] - normal_[j].dot(rod.velocity[j + 1] - rod.velocity[j]);
        if (j > 0) {
            const double beside = -rod.inverse_mass(j) * normal_[j - 1].dot(normal_[j]);
            diagonal -= beside * share_[j - 1];
            right -= beside * impulse_[j - 1];
        }
        if (j + 1 < count()) share_[j] = -rod.inverse_mass(j + 1) * normal_[j].dot(normal_[j + 1]) / diagonal;
        impulse_[j] = right / diagonal;
    }
    for (int j = count() - 2; j >= 0; j--) impulse_[j] -= share_[j] * impulse_[j + 1];
    for (int j = 0; j < count(); j++) apply(rod, j, impulse_[j]);
}

void DistanceConstraints::apply(Rod &rod, int segment, double impulse_N_s)
{
    const Vector impulse = impulse_N_s * normal_[segment];
    rod.velocity[segment + 1] += gain_[1][segment] * impulse;
    rod.velocity[segment] -= gain_[0][segment] * impulse;
    if (segment + 1 >= rod.free_count) hand_impulse_ += settings_.mixing * impulse;
}

} // namespace vcsim3
