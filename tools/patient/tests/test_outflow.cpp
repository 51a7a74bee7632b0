// These tests check that blood leaves a person's own vessels at every end but the inlet, by a stated law of
// the vessel's width before the end, although the mesh closes its ends; that the inlet is the end of the
// widest vessel, whatever its cap looks like; and that medium moves downstream everywhere. Widths of tubes,
// cones and forks are known in closed form.
#include "host/effects/contrast_flow.hpp"
#include "host/model/bodies.hpp"
#include "tools/centreline/end_width.hpp"
#include "tools/centreline/tests/shapes.hpp"
#include "tools/patient/outflow.hpp"
#include "tools/patient/scene_folder.hpp"
#include <numbers>

using namespace crn;
using namespace crn::patient;
using centreline::Branch;
using centreline::Sphere;
using centreline::tests::Folder;
using Eigen::Vector3d;
using std::numbers::pi;

// All tests of this room are one unit, so these names have a namespace of their own.
namespace outflow_tests
{

static bake::Progress own_progress;

static void is_near(double got, double wanted, double share, const char *what)
{
    std::printf("# %s: %.4g, expected %.4g\n", what, got, wanted);
    if (!(std::abs(got - wanted) <= share * std::abs(wanted)))
        fail_msg("%s is %.6g, expected %.6g within %.1f %%", what, got, wanted, 100 * share);
}

// Thin vessels follow Murray's law, pi/4 500/s r^3; wide ones have the mean speed of an ascending aorta.
static void the_law_is_of_murray_up_to_the_speed_of_an_aorta(void **)
{
    is_near(outlet_flow_ml_s(0.5), pi / 4 * 500 * 0.125e-3, 1e-12, "flow of 0.5 mm in ml/s");
    is_near(outlet_flow_ml_s(1.0) / outlet_flow_ml_s(0.5), 8, 1e-12,
            "flow of a thin vessel of twice the radius");
    is_near(outlet_flow_ml_s(6.0) / outlet_flow_ml_s(3.0), 4, 1e-12,
            "flow of a wide vessel of twice the radius");
    is_near(60e-3 * outlet_flow_ml_s(13.0), 5.0, 0.03, "flow of an aorta of 26 mm in l/min");
    is_near(outlet_flow_ml_s(1.28 + 1e-9), outlet_flow_ml_s(1.28 - 1e-9), 1e-6, "flow where the laws meet");
}

// Inscribed spheres at every 0.5 mm from an end inwards, in a vessel of this radius.
template <typename Radius> static std::vector<Sphere> inwards(double length_mm, Radius radius_mm)
{
    std::vector<Sphere> line;
    for (double s = 0; s <= length_mm; s += 0.5) line.push_back({{0, s, 0}, std::max(0.1, radius_mm(s))});
    return line;
}

static void a_cap_hides_no_width(void **)
{
    // Before a flat cap or a half ball, a sphere is as large as its distance from the end.
    std::vector<Sphere> flat = inwards(40, [](double s) { return std::min(3.0, s); });
    is_near(centreline::width_inside(flat).radius_mm, 3.0, 1e-12, "radius behind a flat cap in mm");
    centreline::open_end(flat);
    for (const Sphere &sphere : flat) assert_float_equal(sphere.radius_mm, 3.0, 1e-12);
    // A cone whose half angle has the tangent 1/4 becomes shorter by the radius of the vessel.
    std::vector<Sphere> cone = inwards(40, [](double s) { return std::min(4.0, 0.5 + s / 4); });
    is_near(centreline::width_inside(cone).radius_mm, 4.0, 1e-12, "radius behind a cone in mm");
    centreline::open_end(cone);
    for (const Sphere &sphere : cone)
        assert_float_equal(sphere.radius_mm, std::min(4.0, 0.5 + (sphere.centre_mm.y() + 4) / 4), 1e-9);
}

static void a_vessel_that_becomes_narrower_keeps_its_width(void **)
{
    const auto radius_mm = [](double s) { return 1.0 + 0.02 * s; };
    std::vector<Sphere> tapered = inwards(40, radius_mm);
    // The median over two radii is the radius one radius inside.
    is_near(centreline::width_inside(tapered).radius_mm, 1.02, 0.01,
            "radius of a tapered artery's end in mm");
    centreline::open_end(tapered);
    for (const Sphere &sphere : tapered)
        assert_float_equal(sphere.radius_mm, radius_mm(sphere.centre_mm.y()), 1e-12);
    assert_float_equal(centreline::width_inside({{{0, 0, 0}, 2.0}}).radius_mm, 2.0, 0);
}

// --- a fork whose three ends are closed ---

constexpr double trunk_mm = 4.0, left_mm = 3.0, right_mm = 2.0;

static Branch line(const Vector3d &from, const Vector3d &to, double first_mm, double radius_mm)
{
    constexpr int steps = 80;
    Branch branch;
    for (int i = 0; i <= steps; ++i)
        branch.spheres.push_back({from + (to - from) * i / steps,
                                  std::min(radius_mm, first_mm + (to - from).norm() * i / steps / 4)});
    return branch;
}

// The trunk begins 60 mm below the fork; its first radius may be that of a cone's tip.
static bake::Mesh fork(double first_mm)
{
    return bake::surface_of({line({0, -60, 0}, {0, 0, 0}, first_mm, trunk_mm),
                             line({0, 0, 0}, {45, 45, 0}, left_mm, left_mm),
                             line({0, 0, 0}, {-45, 45, 0}, right_mm, right_mm)},
                            0.25, own_progress);
}

static VesselTree scene_of(const bake::Mesh &mesh, Choices &choices)
{
    const Folder folder;
    SceneWish wish;
    wish.folder = folder.path / "scene";
    wish.has_bodies = false;
    make_scene_folder({{"fork", mesh}}, {"mm", "+x,+y,+z", {}}, wish, choices, own_progress);
    Bodies bodies;
    std::string error;
    if (!read_bodies((wish.folder / "patient.bodies").string(), bodies, error)) fail_msg("%s", error.c_str());
    return bodies.vessels;
}

static std::size_t cell_at(const ContrastFlow &flow, const Vector3d &place_mm)
{
    return flow.cells().nearest(place_mm * 1e-3);
}

// The mean flow out of the end near a place.
static double leaves_ml_s(const ContrastFlow &flow, const Vector3d &place_mm)
{
    return flow.network().outflow_ml_s(flow.network().run_of(cell_at(flow, place_mm)));
}

// Before, the flow out of each end was that of the sphere in its cap, and nearly nothing left the fork.
static void flows_of_a_closed_fork_follow_the_law(void **)
{
    Choices choices;
    const VesselTree tree = scene_of(fork(trunk_mm), choices);
    assert_int_equal(tree.branches.size(), 3);
    ContrastFlow flow(tree);
    FlowDrive even;
    even.pressure_mmHg = mean_pressure_mmHg;
    flow.step(even, {});
    const double left = leaves_ml_s(flow, {46, 46, 0}), right = leaves_ml_s(flow, {-46, 46, 0});
    is_near(left, pi * left_mm * left_mm * 0.16, 0.02, "flow out of the left arm in ml/s");
    is_near(right, pi * right_mm * right_mm * 0.16, 0.04, "flow out of the right arm in ml/s");
    is_near(left / right, 9.0 / 4.0, 0.02, "ratio of the flows");
    is_near(flow.network().inflow_ml_s(0), left + right, 1e-9, "flow into the trunk in ml/s");
}

// 3 ml/s enter a trunk of 6.5 ml/s. Of the medium, nothing flows back past the catheter, each arm gets its
// share of the flow, and in the end all of it has left.
static void medium_moves_downstream_everywhere(void **)
{
    Choices choices;
    ContrastFlow flow(scene_of(fork(trunk_mm), choices));
    FlowDrive even;
    even.pressure_mmHg = mean_pressure_mmHg;
    const CatheterMouth mouth{Vector3d(0, -30, 0) * 1e-3, 1.0};
    flow.set_mouths({&mouth, 1});
    const std::size_t before = cell_at(flow, {0, -42, 0}), arm = cell_at(flow, {30, 30, 0});
    double most_before = 0, most_in_arm = 0;
    for (int ms = 0; ms < 20000; ++ms) {
        flow.step(even, {ms < 1000 ? 3.0 : 0.0, 350.0});
        most_before = std::max(most_before, flow.iodine_mg_per_ml(before));
        most_in_arm = std::max(most_in_arm, flow.iodine_mg_per_ml(arm));
    }
    const IodineBudget &budget = flow.budget();
    std::printf(
        "# iodine: injected %.0f mg, reflux %.2g mg, before the catheter %.2g mg/ml, in the arm %.0f mg/ml\n",
        budget.injected_mg, budget.reflux_mg, most_before, most_in_arm);
    assert_float_equal(budget.reflux_mg, 0.0, 1e-9);
    assert_float_equal(most_before, 0.0, 1e-9);
    assert_true(most_in_arm > 100);
    is_near(budget.out_mg, budget.injected_mg, 0.01, "iodine that has left in mg");
}

// --- the inlet ---

static Vector3d inlet_of(const bake::Mesh &mesh)
{
    Choices choices;
    return scene_of(mesh, choices).branches.front().points_m.front() * 1e3;
}

// Before, the tip of the cone counted, and the inlet was the end of an arm.
static void the_inlet_is_the_widest_vessel_though_it_ends_in_a_point(void **)
{
    const Vector3d inlet = inlet_of(fork(0.6));
    std::printf("# inlet at (%.1f, %.1f, %.1f) mm\n", inlet.x(), inlet.y(), inlet.z());
    assert_true((inlet - Vector3d(0, -60, 0)).norm() < 4);
}

// A tube along y that becomes narrower, with a flat cap at its wide end.
static bake::Mesh narrowing_tube(double wide_mm, double thin_mm, double length_mm)
{
    constexpr int along = 60, around = 40;
    bake::Mesh mesh = centreline::tests::tube_mesh(1.0, length_mm, 0, along, around);
    for (Vector3d &v : mesh.vertices_mm) {
        const double radius = wide_mm + (thin_mm - wide_mm) * v.y() / length_mm;
        v.x() *= radius, v.z() *= radius;
    }
    mesh.vertices_mm.emplace_back(0, 0, 0);
    const auto middle = static_cast<std::uint32_t>(mesh.vertices_mm.size() - 1);
    for (std::uint32_t j = 0; j < around; ++j) mesh.triangles.push_back({(j + 1) % around, middle, j});
    return mesh;
}

// Before, the only opening was taken, however thin the vessel is there.
static void the_inlet_may_be_closed_where_another_end_is_open(void **)
{
    const Vector3d inlet = inlet_of(narrowing_tube(4.0, 2.0, 120));
    std::printf("# inlet at (%.1f, %.1f, %.1f) mm\n", inlet.x(), inlet.y(), inlet.z());
    assert_true(inlet.y() < 4);
}

// Before, the lower end of an aorta with an aneurysm was the inlet, and instruments entered against the
// blood.
static void blood_enters_an_aorta_from_above_if_its_ends_are_equal(void **)
{
    bake::Mesh mesh = centreline::tests::tube_mesh(1.0, 160, 0, 80, 40);
    for (Vector3d &v : mesh.vertices_mm) {
        const double radius = 8 + 10 * std::exp(-std::pow((v.y() - 70) / 20, 2));
        v.x() *= radius, v.z() *= radius;
    }
    const Vector3d inlet = inlet_of(mesh);
    std::printf("# inlet at (%.1f, %.1f, %.1f) mm\n", inlet.x(), inlet.y(), inlet.z());
    assert_true(inlet.y() > 155);
}

} // namespace outflow_tests

int main()
{
    const CMUnitTest tests[] = {
        cmocka_unit_test(outflow_tests::the_law_is_of_murray_up_to_the_speed_of_an_aorta),
        cmocka_unit_test(outflow_tests::a_cap_hides_no_width),
        cmocka_unit_test(outflow_tests::a_vessel_that_becomes_narrower_keeps_its_width),
        cmocka_unit_test(outflow_tests::flows_of_a_closed_fork_follow_the_law),
        cmocka_unit_test(outflow_tests::medium_moves_downstream_everywhere),
        cmocka_unit_test(outflow_tests::the_inlet_is_the_widest_vessel_though_it_ends_in_a_point),
        cmocka_unit_test(outflow_tests::the_inlet_may_be_closed_where_another_end_is_open),
        cmocka_unit_test(outflow_tests::blood_enters_an_aorta_from_above_if_its_ends_are_equal)};
    cmocka_set_message_output(CM_OUTPUT_TAP);
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
