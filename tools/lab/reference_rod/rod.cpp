// Computes the rod's frames and its elastic energy.
#include "tools/lab/reference_rod/rod.hpp"
#include "tools/lab/reference_rod/joint.hpp"
#include <Eigen/Geometry>
#include <cmath>

namespace crn::reference
{
namespace
{

constexpr double pi = 3.14159265358979323846;

// Applies the smallest rotation that turns `from` into `to` (unit vectors) to the vector `v`, which is
// perpendicular to `from`, and returns the result.
Vector carry(const Vector &v, const Vector &from, const Vector &to)
{
    const Vector b = from.cross(to);
    const double c = 1.0 + from.dot(to);
    const Vector turned = v + b.cross(v) + b.cross(b.cross(v)) / c;
    return (turned - turned.dot(to) * to).normalized();
}

// Returns the angle from a to b about the axis t; of all equivalent angles, the function returns the one
// nearest to `guess`.
double angle_near(const Vector &a, const Vector &b, const Vector &t, double guess)
{
    const double angle = std::atan2(a.cross(b).dot(t), a.dot(b));
    return angle + 2.0 * pi * std::round((guess - angle) / (2.0 * pi));
}

void set_reference(State &state, int joint, double guess)
{
    const Vector &te = state.tangent[joint], &tf = state.tangent[joint - 1];
    state.reference[joint] = angle_near(carry(state.axis[joint], te, tf), state.axis[joint - 1], tf, guess);
}

// Adds the energy weight * (measure - rest)^2 / 2 of one joint (`measure` is a curvature or twist, `rest` its
// unloaded value), and the derivatives of this energy.
double add_square(const Measure &m, double rest, double weight, int first, Eigen::VectorXd *slope,
                  Band *second)
{
    // Gives the index of each unknown of the joint among the rod's unknowns; there, the front node and the
    // front edge come first.
    static constexpr int place[11] = {8, 9, 10, 7, 4, 5, 6, 3, 0, 1, 2};
    const double off = m.value - rest;
    if (slope)
        for (int i = 0; i < 11; i++) (*slope)[first + place[i]] += weight * off * m.slope[i];
    if (second)
        for (int i = 0; i < 11; i++)
            for (int j = 0; j < 11; j++)
                if (place[i] >= place[j])
                    second->at(first + place[i], first + place[j]) +=
                        weight * (m.slope[i] * m.slope[j] + off * m.second(i, j));
    return 0.5 * weight * off * off;
}

double joint_energy(const Rod &rod, const State &state, int j, Eigen::VectorXd *slope, Band *second)
{
    Joint joint{state.x[j] - state.x[j + 1], state.x[j - 1] - state.x[j], state.d1(j), state.d1(j - 1),
                state.angle[j - 1] - state.angle[j] + state.reference[j]};
    Measure curvature1, curvature2, twist;
    joint_measures(joint, second != nullptr, curvature1, curvature2, twist);
    const double share = rod.joint_m[j] / rod.cell_m[j];
    const double bend = rod.bend_N_m2[j] / rod.joint_m[j], turn = rod.twist_N_m2[j] / rod.cell_m[j];
    const int first = 4 * (j - 1);
    return add_square(curvature1, share * rod.rest_curvature1[j], bend, first, slope, second) +
           add_square(curvature2, share * rod.rest_curvature2[j], bend, first, slope, second) +
           add_square(twist, 0.0, turn, first, slope, second);
}

double edge_energy(const Rod &rod, const State &state, int j, Eigen::VectorXd *slope, Band *second)
{
    const Vector edge = state.x[j] - state.x[j + 1];
    const double now_m = edge.norm(), rest_m = rod.length_m(j), strain = now_m / rest_m - 1.0;
    const Vector t = edge / now_m;
    if (slope) {
        slope->segment<3>(4 * j) += rod.stretch_N[j] * strain * t;
        slope->segment<3>(4 * (j + 1)) -= rod.stretch_N[j] * strain * t;
    }
    if (second) {
        const Eigen::Matrix3d along = t * t.transpose();
        const Eigen::Matrix3d k =
            rod.stretch_N[j] * (along / rest_m + strain / now_m * (Eigen::Matrix3d::Identity() - along));
        for (int a = 0; a < 3; a++)
            for (int b = 0; b < 3; b++) {
                if (a >= b) {
                    second->at(4 * j + a, 4 * j + b) += k(a, b);
                    second->at(4 * j + 4 + a, 4 * j + 4 + b) += k(a, b);
                }
                second->at(4 * j + 4 + a, 4 * j + b) -= k(a, b);
            }
    }
    return 0.5 * rod.stretch_N[j] * rest_m * strain * strain;
}

} // namespace

State State::straight(const Rod &rod, const Vector &tip, const Vector &forward, const Vector &d1)
{
    State state;
    for (double arc : rod.arc_m) state.x.push_back(tip - arc * forward);
    const std::size_t edges = rod.arc_m.size() - 1;
    state.angle.assign(edges, 0.0);
    state.tangent.assign(edges, forward);
    state.axis.assign(edges, d1);
    state.reference.assign(rod.arc_m.size(), 0.0);
    return state;
}

Vector State::d1(int edge) const
{
    return std::cos(angle[edge]) * axis[edge] + std::sin(angle[edge]) * tangent[edge].cross(axis[edge]);
}

void move_state(const State &from, const std::vector<Vector> &x, const std::vector<double> &angle, int nodes,
                State &to)
{
    if (to.tangent.size() != from.tangent.size()) to = from;
    to.x = x;
    to.angle = angle;
    for (int j = 0; j + 1 < nodes; j++) {
        to.tangent[j] = (x[j] - x[j + 1]).normalized();
        to.axis[j] = carry(from.axis[j], from.tangent[j], to.tangent[j]);
    }
    for (int j = 1; j + 1 < nodes; j++) set_reference(to, j, from.reference[j]);
}

double elastic_energy(const Rod &rod, const State &state, int nodes, Eigen::VectorXd *slope, Band *second)
{
    double energy = 0.0;
    for (int j = 0; j + 1 < nodes; j++) energy += edge_energy(rod, state, j, slope, second);
    for (int j = 1; j + 1 < nodes; j++) energy += joint_energy(rod, state, j, slope, second);
    return energy;
}

} // namespace crn::reference
