// These tests check the following. The derivatives of the distance field agree with differences of the
// field's values. On a plane, the friction force on the rod is the friction coefficient mu times the load. In
// a rigid bent tube the shape of the rod does not depend on the scale of EI, and the force is proportional to
// the stiffness. The work of the hand equals the energy that the rod stores. Shorter edges of the rod and
// shorter feeding steps change the result only slightly. A rod that has come to rest does not creep
// afterwards. The generated noise has a normal distribution, and equal seeds give equal noise.
#include "tools/lab/reference_rod/truth.hpp"
extern "C" {
#include "firmware/tests/reference/tube_lumen.h"
}
#include <cmath>
#include <memory>

#include <csetjmp>
#include <cstdarg>
#include <cstddef>
#include <cstdint>
#include <cstdio>

// The header cmocka.h comes last, because its macros (fail, ...) would change other headers.
extern "C" {
#include <cmocka.h>
}

using namespace crn::reference;
namespace lumen = crn::reference::lumen;

namespace
{

void assert_below(const char *what, double value, double limit)
{
    std::printf("# %s = %.6g, allowed %.6g\n", what, value, limit);
    assert_true(value <= limit);
}

// Makes a tube that is 8 mm wide: a straight piece of 20 mm, and then two bends of 90 degrees and 30 mm
// radius. The bends form an S and do not lie in one plane.
class Tube
{
  public:
    Tube()
    {
        const double quarter_m = 1.5707963267948966 * 0.03;
        const reference_piece pieces[] = {
            {0.02, 0, 0}, {quarter_m, 1.5707963267948966, 0}, {quarter_m, 1.5707963267948966, 2.2}};
        tube_.reset(reference_tube_make(pieces, 3, 0.004, 1));
    }
    const crn_lumen &field() const { return tube_->lumen; }
    Wall wall() const
    {
        return [this](const Vector &x) { return lumen::lumen_field(tube_->lumen, x); };
    }

  private:
    struct Free {
        void operator()(reference_tube *tube) const { reference_tube_free(tube); }
    };
    std::unique_ptr<reference_tube, Free> tube_;
};

const Tube &tube()
{
    static const Tube one;
    return one;
}

// Makes a guidewire whose first 40 mm are a tenth as stiff as the shaft; a taper from 40 to 80 mm follows.
crn_wire_instrument wire(double factor)
{
    crn_wire_instrument table{};
    const double bends[][2] = {{0, 3e-5}, {40, 3e-5}, {60, 1e-4}, {80, 3e-4}, {400, 3e-4}};
    for (const auto &[arc_mm, bend_N_m2] : bends) {
        crn_wire_knot &knot = table.knots[table.knots_count++];
        knot.arc_um = static_cast<std::uint32_t>(std::lround(arc_mm * 1e3));
        knot.bend_stiffness_nN_m2 = static_cast<std::uint32_t>(std::lround(bend_N_m2 * factor * 1e9));
        knot.twist_stiffness_nN_m2 = knot.bend_stiffness_nN_m2;
        knot.radius_outer_um = 440;
    }
    return table;
}

Run run(double factor, double friction, const Cut &cut, const Step &step)
{
    crn::insertion::Case c;
    c.depths = {{"half", 55, 0, {}, {}}, {"end", 90, 40, {}, {}}};
    return insert(c, wire(factor), tube().wall(), friction, cut, step);
}

const Cut coarse{1e-3, 2e-3};
const Step two_mm{2e-3};

double distance_mm(const Vector &p, const std::vector<Vector> &line)
{
    double least = 1e9;
    for (std::size_t i = 0; i + 1 < line.size(); i++) {
        const Vector along = line[i + 1] - line[i];
        const double u = std::clamp((p - line[i]).dot(along) / along.squaredNorm(), 0.0, 1.0);
        least = std::min(least, (p - line[i] - u * along).norm());
    }
    return least;
}

// Returns the root mean square of the smallest distances between two sets of curves, over all depths.
double shape_off_mm(const Run &a, const Run &b)
{
    double sum = 0.0;
    int count = 0;
    for (std::size_t d = 0; d < a.centrelines_mm.size(); d++)
        for (const Vector &p : a.centrelines_mm[d])
            sum += std::pow(distance_mm(p, b.centrelines_mm[d]), 2), count++;
    return std::sqrt(sum / count);
}

double force_sum_mN(const Run &r)
{
    double sum = 0.0;
    for (const auto &sample : r.force) sum += sample.axial_mN;
    return sum / static_cast<double>(r.force.size());
}

// We take central differences over 1 um within a voxel, where the second derivative of the field along an
// axis is constant.
void field_has_the_derivatives_of_its_value(void **)
{
    const double h = 1e-6;
    int checked = 0;
    for (int i = 0; i < 60; i++) {
        const Vector x(0.02 + 4e-4 * i, 0.0031 * std::sin(0.7 * i), 0.0031 * std::cos(0.7 * i));
        const lumen::LumenField field = lumen::lumen_field(tube().field(), x);
        if (field.gradient.norm() < 0.5) continue;
        const lumen::LumenSample sample = lumen::sample_lumen(tube().field(), x);
        assert_true(sample.distance_m == field.distance_m);
        assert_true((sample.inward + field.gradient.normalized()).norm() < 1e-12);
        for (int k = 0; k < 3; k++) {
            const lumen::LumenField up = lumen::lumen_field(tube().field(), x + h * Vector::Unit(k));
            const lumen::LumenField down = lumen::lumen_field(tube().field(), x - h * Vector::Unit(k));
            assert_true(std::abs((up.distance_m - down.distance_m) / (2 * h) - field.gradient[k]) < 1e-5);
            assert_true(((up.gradient - down.gradient) / (2 * h) - field.second_per_m.col(k)).norm() <
                        1.0 + 0.02 * field.second_per_m.norm());
        }
        checked++;
    }
    assert_true(checked > 20);
}

// A rod lies on a plane under a load of 0.5 N/m and is pushed along the plane. The force on the hand is the
// friction coefficient mu times the load on the part of the rod outside the sheath.
void friction_on_a_plane_is_the_coefficient_times_the_load(void **)
{
    const double per_m_N = 0.5, friction = 0.2, inserted_m = 0.08;
    Rod rod = uniform_rod(1e-5, 1e-5, 5e-4, 0.1, 2e-3); // soft, so the clamp carries only 1 mm of it
    Physics physics;
    physics.friction = friction;
    physics.onset_m = 1e-7;
    physics.wall = [](const Vector &x) {
        lumen::LumenField field;
        field.distance_m = -x.z() - 5e-4;
        field.gradient = -Vector::UnitZ();
        return field;
    };
    for (double cell_m : rod.cell_m) physics.load_N.push_back(-per_m_N * cell_m * Vector::UnitZ());
    Insertion line(rod, physics, {}, 0.01, 0.0);
    for (double at_m = 0.011; at_m < inserted_m + 1e-9; at_m += 1e-3) assert_true(line.advance(at_m, 0.0));
    const double expected_N = friction * per_m_N * inserted_m;

    assert_below("off from mu w L, share", std::abs(line.hand_N() / expected_N - 1.0), 0.03);
    // When the rod is drawn back, friction points in the opposite direction.
    for (int i = 0; i < 3; i++) assert_true(line.advance(line.inserted_m() - 1e-3, 0.0));
    assert_below("drawn back, share",
                 std::abs(line.hand_N() / (-friction * per_m_N * line.inserted_m()) - 1.0), 0.03);
}

void shape_does_not_know_the_scale_of_stiffness_and_force_does(void **)
{
    const Run soft = run(1.0, 0.1, coarse, two_mm), stiff = run(10.0, 0.1, coarse, two_mm);
    assert_int_equal(soft.unsettled + stiff.unsettled, 0);
    assert_below("shape differs by mm rms", shape_off_mm(stiff, soft), 0.03);
    assert_below("force ratio is off from 10 by a share of",
                 std::abs(force_sum_mN(stiff) / force_sum_mN(soft) / 10.0 - 1.0), 0.02);
    assert_below("contact depth mm", stiff.depth_mm, 0.2);
}

void finer_cutting_and_feeding_change_little(void **)
{
    const Run plain = run(1.0, 0.1, coarse, two_mm);
    const Run cut = run(1.0, 0.1, {0.5e-3, 1e-3}, two_mm), fed = run(1.0, 0.1, coarse, {1e-3});
    assert_below("half the edges: mm rms", shape_off_mm(cut, plain), 0.05);
    assert_below("half the feed step: mm rms", shape_off_mm(fed, plain), 0.05);
    assert_below("half the edges: force, share", std::abs(force_sum_mN(cut) / force_sum_mN(plain) - 1.0),
                 0.01);
}

// Without friction the work of the hand equals the energy that the rod stores; the wall stores a thousandth
// of this energy. The tolerance of 1.5 % covers the error of the trapezium rule in steps in which a node
// loses contact with the wall. An earlier version lacked the force with which a sleeve pushes a bent rod out,
// so the computed work was 13 % too large.
void the_work_of_the_hand_is_the_energy_that_the_rod_stores(void **)
{
    const Rod rod = cut_rod(wire(1.0), 0.1, {0.5e-3, 1e-3});
    Physics physics;
    physics.wall = tube().wall();
    Insertion line(rod, physics, {}, 2e-3, 0.0);
    double work_J = 0.0, before_N = 0.0;
    const double step_m = 0.25e-3;
    while (line.inserted_m() < 0.09 - 1e-9) {
        assert_true(line.advance(line.inserted_m() + step_m, 0.0));
        work_J += 0.5 * (before_N + line.hand_N()) * step_m;
        before_N = line.hand_N();
    }
    const double stored_J = elastic_energy(rod, line.state(), line.free_nodes() + 1, nullptr, nullptr);
    std::printf("# work %.6g mJ, stored %.6g mJ\n", work_J * 1e3, stored_J * 1e3);
    assert_below("work over stored energy, less 1", std::abs(work_J / stored_J - 1.0), 0.015);
}

// The sheath straightens a J tip. A J tip that leaves the sheath pulls itself out. The J tip's force is the
// energy per length of the straightened rod in the sheath, EI kappa^2 / 2, where kappa is the unloaded
// curvature of the J.
void free_j_pulls_itself_out_of_the_sheath(void **)
{
    const double bend_N_m2 = 1e-5, curvature_per_m = 100.0;
    Rod rod = uniform_rod(bend_N_m2, bend_N_m2, 4e-4, 0.04, 0.5e-3);
    for (int i = 0; i < rod.nodes(); i++)
        rod.rest_curvature1[i] = 2.0 * std::tan(0.5 * curvature_per_m * rod.cell_m[i]);
    Insertion line(rod, {}, {}, 2e-3, 0.0);
    double sum_N = 0.0;
    int count = 0;
    while (line.inserted_m() < 0.025) {
        assert_true(line.advance(line.inserted_m() + 0.2e-3, 0.0));
        sum_N += line.hand_N();
        count++;
    }
    assert_below("off from -EI kappa^2 / 2, share",
                 std::abs(sum_N / count / (-0.5 * bend_N_m2 * curvature_per_m * curvature_per_m) - 1.0),
                 0.01);
}

// With friction, the hand must push harder than without it. Without friction, the hand's work only increases
// the energy that the rod's bends store.
void friction_is_felt_by_the_hand(void **)
{
    assert_true(force_sum_mN(run(1.0, 0.1, coarse, two_mm)) >
                1.1 * force_sum_mN(run(1.0, 0.0, coarse, two_mm)));
}

void rod_at_rest_does_not_creep(void **)
{
    const Rod rod = cut_rod(wire(1.0), 0.06, coarse);
    Physics physics;
    physics.wall = tube().wall();
    physics.friction = 0.1;
    Insertion line(rod, physics, {}, 0.002, 0.0);
    for (int i = 1; i <= 29; i++) assert_true(line.advance(0.002 + 2e-3 * i, 0.0));
    const std::vector<Vector> before = line.centreline_m();
    for (int i = 0; i < 20; i++) assert_true(line.advance(line.inserted_m(), 0.0));
    double most_um = 0.0;
    for (std::size_t i = 0; i < before.size(); i++)
        most_um = std::max(most_um, (line.centreline_m()[i] - before[i]).norm() * 1e6);
    assert_below("crept by um", most_um, 1.0);
}

void noise_is_normal_and_repeats(void **)
{
    Noise noise(7), again(7);
    double sum = 0.0, squares = 0.0, fourth = 0.0;
    constexpr int count = 20000;
    for (int i = 0; i < count; i++) {
        const double value = noise.next();
        assert_true(value == again.next());
        sum += value;
        squares += value * value;
        fourth += value * value * value * value;
    }
    // The bounds for the mean, variance and fourth moment of n random numbers are five standard errors, which
    // are 1/sqrt(n), sqrt(2/n) and sqrt(96/n).
    assert_below("mean", std::abs(sum / count), 0.035);
    assert_below("variance off by", std::abs(squares / count - 1.0), 0.05);
    assert_below("fourth moment off by", std::abs(fourth / count - 3.0), 0.35);
}

} // namespace

int main()
{
    const CMUnitTest tests[] = {
        cmocka_unit_test(field_has_the_derivatives_of_its_value),
        cmocka_unit_test(friction_on_a_plane_is_the_coefficient_times_the_load),
        cmocka_unit_test(shape_does_not_know_the_scale_of_stiffness_and_force_does),
        cmocka_unit_test(finer_cutting_and_feeding_change_little),
        cmocka_unit_test(the_work_of_the_hand_is_the_energy_that_the_rod_stores),
        cmocka_unit_test(free_j_pulls_itself_out_of_the_sheath),
        cmocka_unit_test(friction_is_felt_by_the_hand),
        cmocka_unit_test(rod_at_rest_does_not_creep),
        cmocka_unit_test(noise_is_normal_and_repeats),
    };
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
