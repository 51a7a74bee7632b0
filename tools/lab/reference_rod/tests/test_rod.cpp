// These tests check the following. The derivatives of the rod's energy are correct, and the band solver
// solves its systems of equations. A cantilever takes the shape of Euler's elastica, which a separate
// shooting method computes. A curved tip at rest lies on the circle of its curve, in the plane that the
// hand's angle determines.
#include "tools/lab/reference_rod/insertion.hpp"
#include "tools/lab/validate/elastica.hpp"
#include <Eigen/Dense>
#include <cmath>

#include <csetjmp>
#include <cstdarg>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <numbers>

// The header cmocka.h comes last, because its macros (fail, ...) would change other headers.
extern "C" {
#include <cmocka.h>
}

using namespace crn::reference;

namespace
{

using std::numbers::pi;

void assert_near(const char *what, double value, double expected, double allowed)
{
    if (std::abs(value - expected) > allowed)
        std::printf("# %s = %.9g, expected %.9g +- %.3g\n", what, value, expected, allowed);
    assert_true(std::abs(value - expected) <= allowed);
}

// Makes a rod of six nodes that is bent, twisted and stretched; the amounts are fixed numbers of order 0.1.
struct Crooked {
    Rod rod = uniform_rod(3e-4, 2e-4, 4e-4, 0.01, 0.002);
    State state;
    Crooked()
    {
        for (int j = 1; j + 1 < rod.nodes(); j++)
            rod.rest_curvature1[j] = 0.2 - 0.1 * j, rod.rest_curvature2[j] = 0.05 * j;
        const State straight = State::straight(rod, Vector::Zero(), Vector::UnitX(), Vector::UnitY());
        std::vector<Vector> x = straight.x;
        std::vector<double> angle = straight.angle;
        for (int i = 0; i < rod.nodes(); i++)
            x[i] += 3e-4 * Vector(std::sin(3.0 * i), std::cos(5.0 * i), std::sin(7.0 * i + 1));
        for (std::size_t j = 0; j < angle.size(); j++) angle[j] = 0.3 * std::sin(2.0 * j);
        state = straight;
        move_state(straight, x, angle, rod.nodes(), state);
    }
    int unknowns() const { return 4 * rod.nodes() - 1; }
    State moved(int unknown, double by) const
    {
        std::vector<Vector> x = state.x;
        std::vector<double> angle = state.angle;
        (unknown % 4 == 3 ? angle[unknown / 4] : x[unknown / 4][unknown % 4]) += by;
        State to = state;
        move_state(state, x, angle, rod.nodes(), to);
        return to;
    }
};

// We take central differences with steps of 1e-7 m and 1e-7 rad; their error is about 1e-6 of the largest
// derivative.
void forces_are_the_slope_of_the_energy(void **)
{
    const Crooked c;
    Eigen::VectorXd slope = Eigen::VectorXd::Zero(4 * c.rod.nodes());
    elastic_energy(c.rod, c.state, c.rod.nodes(), &slope, nullptr);
    for (int k = 0; k < c.unknowns(); k++) {
        const double h = 1e-7;
        const double difference = (elastic_energy(c.rod, c.moved(k, h), c.rod.nodes(), nullptr, nullptr) -
                                   elastic_energy(c.rod, c.moved(k, -h), c.rod.nodes(), nullptr, nullptr)) /
                                  (2.0 * h);
        assert_near("slope", difference, slope[k], (k % 4 == 3 ? 1e-8 : 1e-5) + 1e-6 * std::abs(slope[k]));
    }
}

// In the displaced state the reference frames have moved with the rod, so the difference matrix of the
// energy's slope is not quite symmetric. The antisymmetric part of the difference matrix is the rotation of
// frames that are carried around a closed loop. We therefore compare the symmetric part, which is the mean of
// the difference matrix and its transpose.
void stiffness_is_the_slope_of_the_forces(void **)
{
    const Crooked c;
    const int n = c.unknowns();
    Eigen::VectorXd ignored = Eigen::VectorXd::Zero(4 * c.rod.nodes());
    Band second;
    second.reset(4 * c.rod.nodes());
    elastic_energy(c.rod, c.state, c.rod.nodes(), &ignored, &second);
    Eigen::MatrixXd difference(n, n);
    for (int k = 0; k < n; k++) {
        const double h = 1e-7;
        Eigen::VectorXd up = Eigen::VectorXd::Zero(4 * c.rod.nodes()), down = up;
        elastic_energy(c.rod, c.moved(k, h), c.rod.nodes(), &up, nullptr);
        elastic_energy(c.rod, c.moved(k, -h), c.rod.nodes(), &down, nullptr);
        difference.col(k) = (up - down).head(n) / (2.0 * h);
    }
    for (int i = 0; i < n; i++)
        for (int j = std::max(0, i - Band::reach); j <= i; j++) {
            const double scale = std::sqrt(std::abs(second.at(i, i) * second.at(j, j)));
            assert_near("stiffness", 0.5 * (difference(i, j) + difference(j, i)), second.at(i, j),
                        1e-5 * scale);
        }
}

void band_solves_as_a_full_matrix_does(void **)
{
    constexpr int n = 40;
    Band band;
    band.reset(n);
    Eigen::MatrixXd full = Eigen::MatrixXd::Zero(n, n);
    for (int i = 0; i < n; i++)
        for (int j = std::max(0, i - Band::reach); j <= i; j++)
            full(i, j) = full(j, i) = band.at(i, j) = i == j ? 12.0 : std::sin(1.0 + 3 * i + 5 * j);
    const Eigen::VectorXd right = Eigen::VectorXd::LinSpaced(n, -1.0, 2.0);
    const Eigen::VectorXd expected = full.ldlt().solve(right);
    Eigen::VectorXd x = right;
    assert_true(band.factor());
    band.solve(x);
    assert_true((x - expected).norm() < 1e-12 * expected.norm());
    band.reset(n);
    for (int i = 0; i < n; i++) band.at(i, i) = i == 20 ? -1.0 : 1.0;
    assert_false(band.factor());
}

// With P L^2 / EI = 3 the tip sags by more than half its length. 100 edges give an error of 0.05 % of L.
void cantilever_is_the_elastica(void **)
{
    const double length_m = 0.1, bend_N_m2 = 3e-4, load = 3.0, edge_m = 1e-3;
    Rod rod = uniform_rod(bend_N_m2, bend_N_m2, 4e-4, length_m + edge_m, edge_m);
    const int free = rod.nodes() - 2;
    rod.joint_m[free] *= 0.5; // half of its cell is in the clamp
    State state = State::straight(rod, length_m * Vector::UnitX(), Vector::UnitX(), Vector::UnitZ());
    Physics physics;
    physics.load_N.assign(rod.nodes(), Vector::Zero());
    physics.load_N[0].y() = -load * bend_N_m2 / (length_m * length_m);
    std::vector<Anchor> anchors(rod.nodes());
    const Outcome outcome = find_rest(rod, physics, free, rod.nodes(), anchors, state);
    assert_true(outcome.at_rest);
    const crn::validate::PlaneShape exact = crn::validate::elastica(load, 0.0);
    for (const double share : {0.25, 0.5, 0.75, 1.0}) {
        const std::size_t at =
            static_cast<std::size_t>(std::lround(share * static_cast<double>(exact.x.size() - 1)));
        const Vector &x = state.x[free - static_cast<int>(std::lround(share * free))];
        assert_near("x / L", x.x() / length_m, exact.x[at], 5e-4);
        assert_near("y / L", x.y() / length_m, exact.y[at], 5e-4);
    }
}

// The tip has a curve of 180 degrees with a radius of 3 mm. The end of the curve lies 6 mm beside its
// beginning, towards d1 and at the same distance along the shaft. Because the edges are 0.5 mm long, the
// circle on which the nodes lie is 0.1 % larger than the given radius of 3 mm.
void curved_tip_rests_in_its_circle_where_the_hand_turned_it(void **)
{
    crn_wire_instrument table{};
    const double arc_mm = pi * 3.0;
    const auto knot = [&](double at_mm, double curvature_per_m) {
        crn_wire_knot &k = table.knots[table.knots_count++];
        k.arc_um = static_cast<std::uint32_t>(std::lround(at_mm * 1e3));
        k.bend_stiffness_nN_m2 = k.twist_stiffness_nN_m2 = 20000;
        k.radius_outer_um = 400;
        k.rest_curvature1_per_m_milli = static_cast<std::int32_t>(std::lround(curvature_per_m * 1e3));
    };
    knot(0, 1e3 / 3.0);
    knot(arc_mm, 1e3 / 3.0);
    knot(arc_mm, 0);
    knot(200, 0);
    for (const double turn : {0.0, 1.0}) {
        const Sheath sheath;
        Insertion line(cut_rod(table, 0.03, {}), {}, sheath, 0.002, 0.0);
        for (int i = 1; i <= 28; i++) assert_true(line.advance(0.002 + 1e-3 * i, turn * i / 28));
        const Vector d1 = zero_turn_axis(sheath.direction), across = sheath.direction.cross(d1);
        const Vector expected = (0.03 - arc_mm * 1e-3) * sheath.direction +
                                6e-3 * (std::cos(turn) * d1 + std::sin(turn) * across);
        const double off_mm = (line.state().x[0] - expected).norm() * 1e3;
        assert_near("tip is off by mm", off_mm, 0.0, 0.1);
        assert_near("hand feels mN", line.hand_N() * 1e3, 0.0, 0.02);
    }
}

} // namespace

int main()
{
    const CMUnitTest tests[] = {
        cmocka_unit_test(forces_are_the_slope_of_the_energy),
        cmocka_unit_test(stiffness_is_the_slope_of_the_forces),
        cmocka_unit_test(band_solves_as_a_full_matrix_does),
        cmocka_unit_test(cantilever_is_the_elastica),
        cmocka_unit_test(curved_tip_rests_in_its_circle_where_the_hand_turned_it),
    };
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
