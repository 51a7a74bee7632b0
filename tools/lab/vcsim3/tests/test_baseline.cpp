// These tests check the following. The baseline behaves like the rod that docs/thesis.md describes. The rod's
// forces are the gradient of its energies. The shape of the rod at rest is that of an elastic beam. The shape
// at rest is also right if one end of the rod is stiffer than the other, if the rod is curved without load,
// or if the hand turns the rod. The constraints on the rod conserve momentum and never add energy. One
// iteration of the global method gives exact lengths, and many local iterations converge to the same lengths.
// The tests compare the baseline's results with closed forms, or with an alternative computation of the same
// value.
#include "tools/lab/figures/stability.hpp"

#include <algorithm>
#include <cmath>
#include <csetjmp>
#include <cstdarg>
#include <cstddef>
#include <cstdint>
#include <random>

// The header cmocka.h comes last, because its macros (fail, ...) would change other headers.
extern "C" {
#include <cmocka.h>
}

using namespace vcsim3;

namespace
{

class Draws
{
  public:
    double between(double low, double high)
    {
        return low + (high - low) * std::ldexp(static_cast<double>(random_() >> 11), -53);
    }
    Vector vector(double size) { return {between(-size, size), between(-size, size), between(-size, size)}; }

  private:
    std::mt19937_64 random_{20};
};

void within(const char *what, double value, double expected, double allowed)
{
    if (!(std::abs(value - expected) <= allowed))
        fail_msg("%s = %.9g, expected %.9g (off by %.3g, allowed %.3g)", what, value, expected,
                 value - expected, allowed);
}

void at_most(const char *what, double value, double most)
{
    if (!(value <= most)) fail_msg("%s = %.9g, allowed %.9g", what, value, most);
}

RodProperties soft_rod(int elements)
{
    RodProperties p = rod_of(*find_preset("amplatz"), elements, preset_element_m);
    p.drag_per_s = p.spin_drag_per_s = 0.0;
    return p;
}

// Makes a rod whose nodes, orientations and velocities all deviate slightly from those of a straight rod at
// rest.
Rod shaken_rod(int elements, Draws &draws)
{
    Rod rod(soft_rod(elements), Vector::Zero(), Vector(0.6, 0.0, 0.8));
    for (Vector &position : rod.position) position += draws.vector(2e-4);
    for (Vector &velocity : rod.velocity) velocity = draws.vector(0.1);
    for (Quaternion &q : rod.orientation) {
        q.coeffs() += 0.15 * Eigen::Vector4d(draws.between(-1, 1), draws.between(-1, 1), draws.between(-1, 1),
                                             draws.between(-1, 1));
        q.normalize();
    }
    return rod;
}

double elastic_energy(const Rod &rod)
{
    const Energy energy = energy_of(rod);
    return energy.bend_and_twist + energy.parallel + energy.stretch;
}

double kinetic_energy(const Rod &rod)
{
    return energy_of(rod).kinetic;
}

Vector momentum(const Rod &rod)
{
    Vector sum = Vector::Zero();
    for (const Vector &velocity : rod.velocity) sum += rod.node_mass_kg() * velocity;
    return sum;
}

void forces_and_torques_are_the_gradient_of_the_energies(void **)
{
    Draws draws;
    Rod rod = shaken_rod(12, draws);
    rod.properties.stretch_N = 300.0;
    rod.free_count = 10; // the rest is clamped
    for (int node = 1; node < 12; node++)
        rod.properties.joints.push_back(
            {draws.between(1e-5, 3e-5), draws.between(1e-5, 3e-5), draws.vector(100.0)});
    add_elastic_forces(rod);
    const double dx = 1e-9, angle = 1e-6;
    for (int i = 0; i < rod.free_count; i++) {
        for (int k = 0; k < 3; k++) {
            Rod plus = rod, minus = rod;
            plus.position[i][k] += dx;
            minus.position[i][k] -= dx;
            const double slope = (elastic_energy(plus) - elastic_energy(minus)) / (2 * dx);
            within("force in N", rod.force[i][k], -slope, 1e-5 + 1e-5 * std::abs(slope));
            Quaternion turn(1.0, 0.0, 0.0, 0.0);
            turn.vec()[k] = angle / 2;
            plus = minus = rod;
            plus.orientation[i] = (rod.orientation[i] * turn).normalized();
            minus.orientation[i] = (rod.orientation[i] * turn.conjugate()).normalized();
            const double torque = -(elastic_energy(plus) - elastic_energy(minus)) / (2 * angle);
            within("torque in N m", rod.torque[i][k], torque, 1e-9 + 1e-5 * std::abs(torque));
        }
    }
}

void bending_strain_is_the_curvature(void **)
{
    // Neighbouring segments of length l differ by a constant rotation a about x, so the strain is u = 4/l
    // tan(a/4), and the energy per joint is l/2 EI u^2.
    const int elements = 20;
    const double a = 0.3;
    Rod rod(soft_rod(elements), Vector::Zero(), Vector::UnitZ());
    for (int j = 0; j < elements; j++) rod.orientation[j] = Eigen::AngleAxisd(a * j, Vector::UnitX());
    const RodProperties &p = rod.properties;
    const double u = 4.0 / p.element_m * std::tan(a / 4.0);
    within("bending energy in J", energy_of(rod).bend_and_twist,
           (elements - 1) * 0.5 * p.element_m * p.bend_N_m2 * u * u, 1e-12);
}

RodProperties damped_rod(int elements)
{
    RodProperties p = soft_rod(elements);
    p.drag_per_s = p.spin_drag_per_s = 40.0;
    return p;
}

// Simulates 2 s with a load on the tip along y.
void settle(Rod &rod, double load_N)
{
    DistanceConstraints distances({1.0, 0.1});
    const double step_s = 1e-4;
    for (int i = 0; i < 20000; i++) {
        add_elastic_forces(rod);
        rod.force[0].y() += load_N;
        integrate_velocities(rod, step_s);
        distances.prepare(rod, step_s);
        distances.solve_global(rod);
        integrate_positions(rod, step_s);
    }
    at_most("kinetic energy in J", kinetic_energy(rod), 1e-12);
    at_most("length error", std::abs(length_error(rod)), 1e-6);
}

void cantilever_sags_by_PL3_over_3EI(void **)
{
    const int elements = 32;
    const RodProperties p = damped_rod(elements + 2);
    const double length = elements * p.element_m;
    Rod rod = Inserter(Vector::Zero(), Vector::UnitX()).make_rod(p, length);
    const double load_N = 0.01 * 3.0 * p.bend_N_m2 / (length * length); // sags by 1 % of its length
    settle(rod, load_N);
    const double shear =
        load_N * length / p.parallel_N; // sag through the compliance of the parallel constraint
    within("sag in m", rod.position[0].y(), load_N * std::pow(length, 3) / (3 * p.bend_N_m2) + shear,
           0.005 * 0.01 * length);
}

// A rod of length L has a soft front part of length a and a stiff rear part. Under a load P, the tip of a rod
// of length L with a soft front part of length a sags by P a^3 / 3 EI_front + P (L^3 - a^3) / 3 EI_rear. The
// compliance of the joint between the two parts is the mean of the compliances of the soft and the stiff
// part.
void a_cantilever_of_two_stiffnesses_sags_by_both(void **)
{
    const int elements = 32, soft = 20;
    RodProperties p = damped_rod(elements + 2);
    const double rear = p.bend_N_m2, front = 0.25 * rear, between = 2.0 / (1.0 / rear + 1.0 / front);
    for (int node = 1; node < p.element_count; node++) {
        const double bend = node < soft ? front : node > soft ? rear : between;
        p.joints.push_back({bend, bend, Vector::Zero()});
    }
    p.bend_N_m2 = p.twist_N_m2 = 0.0; // unused
    const double length = elements * p.element_m, a = soft * p.element_m;
    Rod rod = Inserter(Vector::Zero(), Vector::UnitX()).make_rod(p, length);
    const double per_N = std::pow(a, 3) / (3 * front) + (std::pow(length, 3) - std::pow(a, 3)) / (3 * rear);
    const double load_N = 0.01 * length / per_N;
    settle(rod, load_N);
    within("sag in m", rod.position[0].y(), load_N * (per_N + length / p.parallel_N), 0.005 * 0.01 * length);
}

void a_cantilever_sags_under_its_weight_by_qL4_over_8EI(void **)
{
    const int elements = 32;
    RodProperties p = damped_rod(elements + 2);
    const double length = elements * p.element_m,
                 per_N_per_m = std::pow(length, 4) / (8 * p.bend_N_m2) + 0.5 * length * length / p.parallel_N;
    p.weight_N_per_m = Vector(0.0, 0.01 * length / per_N_per_m, 0.0);
    Rod rod = Inserter(Vector::Zero(), Vector::UnitX()).make_rod(p, length);
    settle(rod, 0.0);
    // Every node, including the tip, carries the weight of a whole element. The extra half element at the tip
    // adds a sag of P L^3 / 3 EI.
    const double tip_N = 0.5 * p.element_m * p.weight_N_per_m.y();
    within("sag in m", rod.position[0].y(),
           p.weight_N_per_m.y() * per_N_per_m + tip_N * std::pow(length, 3) / (3 * p.bend_N_m2),
           0.01 * 0.01 * length);
}

// At the tip, 10 joints bend by 12 degrees each towards the first axis, so their segments form chords of a
// circle.
constexpr int hook_joints = 10;
constexpr double hook_step_rad = 12.0 * 3.14159265358979323846 / 180.0;

Rod rod_with_hook(const Inserter &inserter, double turn_rad)
{
    const int elements = 16;
    RodProperties p = damped_rod(elements + 2);
    for (int node = 1; node < p.element_count; node++) {
        const double turn = node <= hook_joints ? hook_step_rad : 0.0;
        p.joints.push_back({p.bend_N_m2, p.twist_N_m2, rest_strain(turn * Vector::UnitY(), p.element_m)});
    }
    Rod rod = inserter.make_rod(p, elements * p.element_m);
    inserter.feed(rod, elements * p.element_m, 0.0, turn_rad);
    settle(rod, 0.0);
    return rod;
}

// The rod is straight at first, and then takes its resting shape, which is a polygon whose segments turn by
// 12 degrees at each joint.
void a_free_hook_takes_its_own_shape(void **)
{
    const Vector forward = Vector(0.6, 0.0, 0.8), axis = Vector(0.8, 0.0, -0.6);
    const Rod rod = rod_with_hook(Inserter(Vector::Zero(), forward, axis), 0.0);
    Vector place = Vector::Zero();
    double angle = 0.0;
    for (int i = rod.free_count - 1; i >= 0; i--) {
        if (i < hook_joints) angle += hook_step_rad;
        place += rod.properties.element_m * (std::cos(angle) * forward + std::sin(angle) * axis);
        at_most("off its place in m", (rod.position[i] - place).norm(), 2e-6);
    }
}

// The whole hook turns right-handed about the direction of insertion; the test compares each point with the
// expected shape.
void turning_the_hand_turns_the_hook(void **)
{
    const Vector forward = Vector(0.6, 0.0, 0.8), axis = Vector(0.8, 0.0, -0.6);
    const Inserter inserter(Vector::Zero(), forward, axis);
    const Rod before = rod_with_hook(inserter, 0.0), after = rod_with_hook(inserter, 1.0);
    const Eigen::AngleAxisd turn(1.0, forward);
    for (int i = 0; i < before.free_count; i++)
        at_most("off its place in m", (after.position[i] - turn * before.position[i]).norm(), 2e-6);
}

void twisted_rod_springs_back_at_the_frequency_of_a_shaft(void **)
{
    // The first torsional mode of a chain of n segments with free ends has the angular frequency w = 2
    // sqrt(k/J) sin(pi/(2 n)), where k = GJ/l, l is the length of a segment, and J is the inertia per length
    // times l.
    const int n = 16;
    Rod rod(soft_rod(n), Vector::Zero(), Vector::UnitZ());
    const double pi = std::acos(-1.0);
    for (int j = 0; j < n; j++)
        rod.orientation[j] = Eigen::AngleAxisd(0.01 * std::cos(pi * (j + 0.5) / n), Vector::UnitZ());
    const RodProperties &p = rod.properties;
    const double wanted =
        2.0 * std::sqrt(p.twist_N_m2 / p.inertia_twist_kg_m) / p.element_m * std::sin(pi / (2 * n));
    const double step_s = 1e-6;
    double quarter_s = 0.0;
    while (rod.orientation[0].z() > 0.0 && quarter_s < 1.0) {
        add_elastic_forces(rod);
        integrate_velocities(rod, step_s);
        integrate_positions(rod, step_s);
        quarter_s += step_s;
    }
    within("angular frequency in rad/s", pi / 2 / quarter_s, wanted, 0.005 * wanted);
}

void quaternions_keep_unit_length(void **)
{
    Draws draws;
    Rod rod = shaken_rod(20, draws);
    for (Vector &spin : rod.spin) spin = draws.vector(500.0);
    for (int i = 0; i < 2000; i++) {
        add_elastic_forces(rod);
        integrate_velocities(rod, 2e-5);
        integrate_positions(rod, 2e-5);
    }
    for (const Quaternion &q : rod.orientation) within("length of a quaternion", q.norm(), 1.0, 1e-12);
}

void free_rod_keeps_energy_and_momentum(void **)
{
    Draws draws;
    Rod rod = shaken_rod(20, draws);
    rod.properties.stretch_N = 50.0;
    const double before = energy_of(rod).total();
    const Vector start = momentum(rod);
    double most = before, least = before;
    for (int i = 0; i < 20000; i++) {
        add_elastic_forces(rod);
        integrate_velocities(rod, 5e-6);
        integrate_positions(rod, 5e-6);
        most = std::max(most, energy_of(rod).total());
        least = std::min(least, energy_of(rod).total());
    }
    at_most("growth of energy", most / before - 1.0, 0.02);
    at_most("loss of energy", 1.0 - least / before, 0.02);
    at_most("change of momentum", (momentum(rod) - start).norm() / start.norm(), 1e-9);
}

void distance_iterations_keep_momentum_and_add_no_energy(void **)
{
    Draws draws;
    for (int global = 0; global < 2; global++) {
        Rod rod = shaken_rod(30, draws);
        const Vector before = momentum(rod);
        DistanceConstraints distances({1.0, 0.0});
        distances.prepare(rod, 1e-3);
        double energy = kinetic_energy(rod);
        for (int i = 0; i < 5; i++) {
            if (global) {
                distances.solve_global(rod);
            } else {
                distances.sweep_local(rod);
            }
            at_most("kinetic energy in J", kinetic_energy(rod), energy * (1.0 + 1e-12));
            energy = kinetic_energy(rod);
        }
        at_most("change of momentum", (momentum(rod) - before).norm() / before.norm(), 1e-12);
    }
}

void one_global_iteration_meets_every_wanted_velocity(void **)
{
    Draws draws;
    Rod rod = shaken_rod(40, draws);
    rod.free_count = 38;
    const double step_s = 1e-3, beta = 0.1;
    DistanceConstraints distances({1.0, beta});
    distances.prepare(rod, step_s);
    distances.solve_global(rod);
    for (int j = 0; j < rod.free_count; j++) {
        const Vector e = rod.position[j + 1] - rod.position[j];
        const double wanted = -beta / step_s * (e.norm() - rod.properties.element_m);
        within("relative velocity in m/s", e.normalized().dot(rod.velocity[j + 1] - rod.velocity[j]), wanted,
               1e-12);
    }
}

void one_global_iteration_with_baumgarte_1_makes_small_errors_exact(void **)
{
    Draws draws;
    Rod rod(soft_rod(40), Vector::Zero(), Vector::UnitX());
    for (Vector &position : rod.position) position += draws.vector(1e-6);
    double before = 0.0, after = 0.0;
    const auto worst = [&rod] {
        double most = 0.0;
        for (int j = 0; j < rod.properties.element_count; j++)
            most = std::max(
                most, std::abs((rod.position[j + 1] - rod.position[j]).norm() - rod.properties.element_m));
        return most;
    };
    before = worst();
    DistanceConstraints distances({1.0, 1.0});
    distances.prepare(rod, 1e-3);
    distances.solve_global(rod);
    integrate_positions(rod, 1e-3);
    after = worst();
    // The length error that remains after the iteration is of second order in the error before it.
    at_most("length error in m", after, 20.0 * before * before / rod.properties.element_m);
    at_most("share that stays", after / before, 0.02);
}

void many_local_iterations_become_the_global_one(void **)
{
    Draws draws;
    Rod local = shaken_rod(20, draws), global = local;
    local.free_count = global.free_count = 18;
    DistanceConstraints distances({1.0, 0.1});
    distances.prepare(local, 1e-3);
    for (int i = 0; i < 20000; i++) distances.sweep_local(local);
    distances.solve_global(global);
    for (int i = 0; i < local.node_count(); i++)
        at_most("difference in m/s", (local.velocity[i] - global.velocity[i]).norm(), 1e-9);
}

void penalty_rod_is_compressed_by_force_over_stiffness(void **)
{
    RodProperties p = soft_rod(20);
    p.stretch_N = 100.0;
    p.drag_per_s = 100.0;
    Rod rod = Inserter(Vector::Zero(), Vector::UnitX()).make_rod(p, 18 * p.element_m);
    for (int i = 0; i < 200000; i++) {
        add_elastic_forces(rod);
        rod.force[0].x() -= 1.0;
        integrate_velocities(rod, 1e-5);
        integrate_positions(rod, 1e-5);
    }
    within("length error", length_error(rod), -1.0 / p.stretch_N, 1e-9);
}

void contact_stops_and_brakes_by_coulomb(void **)
{
    Rod rod(soft_rod(4), Vector::Zero(), Vector::UnitX());
    const Contact contact = {1, Vector::UnitY(), 0.0};
    rod.properties.friction = 0.2;
    rod.velocity[1] = Vector(0.5, -1.0, 0.0); // keeps sliding: loses 0.2 of 1 m/s
    answer_contacts(rod, {contact}, 0.1, 1e-3);
    within("normal velocity in m/s", rod.velocity[1].y(), 0.0, 1e-15);
    within("sliding velocity in m/s", rod.velocity[1].x(), 0.3, 1e-15);
    rod.velocity[1] = Vector(0.1, -1.0, 0.0); // sticks
    answer_contacts(rod, {contact}, 0.1, 1e-3);
    within("sticking velocity in m/s", rod.velocity[1].norm(), 0.0, 1e-15);
    rod.velocity[1] = Vector(0.1, 0.3, 0.0); // leaves: untouched
    answer_contacts(rod, {contact}, 0.1, 1e-3);
    within("leaving velocity in m/s", rod.velocity[1].y(), 0.3, 1e-15);
    const Contact deep = {1, Vector::UnitY(), 1e-4};
    rod.velocity[1].setZero();
    answer_contacts(rod, {deep}, 0.1, 1e-3); // a tenth of the depth is corrected in one step
    within("correction in m/s", rod.velocity[1].y(), 0.1 * 1e-4 / 1e-3, 1e-15);
}

void inserter_frees_nodes_one_by_one_on_its_axis(void **)
{
    const Vector mouth(0.1, 0.2, 0.3), direction = Vector(1.0, 2.0, -2.0).normalized();
    const Inserter inserter(mouth, direction);
    Rod rod = inserter.make_rod(soft_rod(20), 10.5 * preset_element_m);
    assert_int_equal(rod.free_count, 11);
    at_most("length error", std::abs(length_error(rod)), 1e-12);
    inserter.feed(rod, 11.2 * preset_element_m, 0.05);
    assert_int_equal(rod.free_count, 12);
    at_most("place of a held node in m",
            (rod.position[15] - (mouth - 3.8 * preset_element_m * direction)).norm(), 1e-15);
    at_most("its velocity in m/s", (rod.velocity[15] - 0.05 * direction).norm(), 1e-15);
}

} // namespace

int main()
{
    const CMUnitTest tests[] = {
        cmocka_unit_test(forces_and_torques_are_the_gradient_of_the_energies),
        cmocka_unit_test(bending_strain_is_the_curvature),
        cmocka_unit_test(cantilever_sags_by_PL3_over_3EI),
        cmocka_unit_test(a_cantilever_of_two_stiffnesses_sags_by_both),
        cmocka_unit_test(a_cantilever_sags_under_its_weight_by_qL4_over_8EI),
        cmocka_unit_test(a_free_hook_takes_its_own_shape),
        cmocka_unit_test(turning_the_hand_turns_the_hook),
        cmocka_unit_test(twisted_rod_springs_back_at_the_frequency_of_a_shaft),
        cmocka_unit_test(quaternions_keep_unit_length),
        cmocka_unit_test(free_rod_keeps_energy_and_momentum),
        cmocka_unit_test(distance_iterations_keep_momentum_and_add_no_energy),
        cmocka_unit_test(one_global_iteration_meets_every_wanted_velocity),
        cmocka_unit_test(one_global_iteration_with_baumgarte_1_makes_small_errors_exact),
        cmocka_unit_test(many_local_iterations_become_the_global_one),
        cmocka_unit_test(penalty_rod_is_compressed_by_force_over_stiffness),
        cmocka_unit_test(contact_stops_and_brakes_by_coulomb),
        cmocka_unit_test(inserter_frees_nodes_one_by_one_on_its_axis),
    };
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
