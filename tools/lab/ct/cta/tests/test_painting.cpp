// These tests check the painting of solids for virtual angiograms: the area of a cut through a mesh and
// through balls, its place, and that of a solid inside another.
#include "tools/lab/ct/cta/painting.hpp"
#include "tools/lab/ct/cta/person.hpp"
#include <algorithm>
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

using namespace crn;
using namespace crn::ct;
using Eigen::Vector2d;
using Eigen::Vector3d;

namespace
{

constexpr double radius_mm = 10.0;
constexpr int sides = 96;

// A cylinder along the body from y = -20 to 20 mm around x = 3, z = -4 mm.
bake::Mesh cylinder(double radius)
{
    bake::Mesh mesh;
    for (const double y : {-20.0, 20.0}) {
        for (int i = 0; i < sides; ++i) {
            const double angle = 2 * std::numbers::pi * i / sides;
            mesh.vertices_mm.push_back({3 + radius * std::sin(angle), y, -4 + radius * std::cos(angle)});
        }
        mesh.vertices_mm.push_back({3, y, -4});
    }
    for (std::uint32_t i = 0; i < sides; ++i) {
        const std::uint32_t j = (i + 1) % sides, top = sides + 1;
        for (const bake::Triangle &t :
             {bake::Triangle{i, j, top + i}, bake::Triangle{j, top + j, top + i}, bake::Triangle{j, i, sides},
              bake::Triangle{top + i, top + j, top + sides}})
            mesh.triangles.push_back(t);
    }
    return mesh;
}

const SampleGrid grid{-20, 20, 0.1, 0.1, 400, 400};

struct Cut {
    double area_mm2 = 0;
    Vector2d middle_mm = Vector2d::Zero(); // x and z
};

Cut cut_of(const Samples &samples, int hu)
{
    Cut cut;
    for (int row = 0; row < grid.rows; ++row)
        for (int i = 0; i < grid.samples; ++i) {
            if (samples[static_cast<std::size_t>(row * grid.samples + i)] != hu) continue;
            cut.area_mm2 += grid.step_mm * grid.row_mm;
            cut.middle_mm += grid.step_mm * grid.row_mm *
                             Vector2d(grid.left_mm + i * grid.step_mm, grid.front_mm - row * grid.row_mm);
        }
    cut.middle_mm /= std::max(cut.area_mm2, 1e-9);
    return cut;
}

Samples empty()
{
    return Samples(static_cast<std::size_t>(grid.samples * grid.rows), std::int16_t{-1000});
}

void assert_near(const char *what, double value, double expected, double allowed)
{
    std::printf("# %s = %.4f, expected %.4f, allowed %.4f\n", what, value, expected, allowed);
    assert_true(std::abs(value - expected) <= allowed);
}

} // namespace

// Around a vessel, only air is painted: half of the plane is tissue.
static void balls_paint_only_over_what_is_below_a_value(void **)
{
    Samples samples = empty();
    for (int row = 0; row < grid.rows; ++row)
        for (int i = 0; i < grid.samples / 2; ++i)
            samples[static_cast<std::size_t>(row * grid.samples + i)] = 40;
    CutBalls balls(-30, 30);
    balls.add({0, -10, 0}, 5, {0, 10, 0}, 5);
    balls.paint(samples, grid, 0.0, {0, 0}, 30, -500);
    assert_near("area", cut_of(samples, 30).area_mm2, std::numbers::pi * 25 / 2, 0.5); // edges of 0.1 mm
}

static void the_cut_of_a_cylinder_has_its_area_and_place(void **)
{
    const CutMesh mesh(cylinder(radius_mm), -30, 30);
    Samples samples = empty();
    mesh.paint(samples, grid, 7.3, {1.5, -0.5}, 300);
    const Cut cut = cut_of(samples, 300);
    const double polygon = sides / 2.0 * radius_mm * radius_mm * std::sin(2 * std::numbers::pi / sides);
    assert_near("area", cut.area_mm2, polygon, 0.003 * polygon); // rows of 0.1 mm along a border of 63 mm
    assert_near("x", cut.middle_mm.x(), 4.5, 0.06);              // half a sample
    assert_near("z", cut.middle_mm.y(), -4.5, 0.06);
}

static void nothing_is_painted_beyond_the_ends_of_a_solid(void **)
{
    const CutMesh mesh(cylinder(radius_mm), -30, 30);
    Samples samples = empty();
    for (const double height : {-25.0, 20.5, 29.0, -40.0, 40.0})
        mesh.paint(samples, grid, height, {0, 0}, 300);
    assert_true(samples == empty());
}

static void a_solid_inside_another_replaces_it(void **)
{
    Samples samples = empty();
    CutMesh(cylinder(radius_mm), -30, 30).paint(samples, grid, 0.1, {0, 0}, 1200);
    CutMesh(cylinder(6), -30, 30).paint(samples, grid, 0.1, {0, 0}, 220);
    const double part = sides / 2.0 * std::sin(2 * std::numbers::pi / sides);
    assert_near("shell", cut_of(samples, 1200).area_mm2, part * (100 - 36), 0.005 * part * 64);
    assert_near("inside", cut_of(samples, 220).area_mm2, part * 36, 0.005 * part * 36);
}

static void balls_along_a_line_make_a_tube(void **)
{
    CutBalls balls(-30, 30);
    balls.add({3, -20, -4}, 2.0, {3, 20, -4}, 1.0);
    Samples samples = empty();
    balls.paint(samples, grid, 0.0, {0, 0}, 349);
    const double area = std::numbers::pi * 1.5 * 1.5;
    assert_near("area half-way", cut_of(samples, 349).area_mm2, area,
                0.03 * area); // the next balls are wider
    assert_near("x", cut_of(samples, 349).middle_mm.x(), 3, 0.06);
}

static void arteries_have_the_names_of_label_maps(void **)
{
    assert_string_equal(structure_name("aorta").c_str(), "aorta");
    assert_string_equal(structure_name("brachiocephalic_artery").c_str(), "brachiocephalic_trunk");
    assert_string_equal(structure_name("left_renal_artery").c_str(), "renal_artery_left");
    assert_string_equal(structure_name("LAD").c_str(), "coronary_arteries");
    assert_string_equal(structure_name("").c_str(), ""); // a grown twig
}

int main()
{
    const CMUnitTest tests[] = {
        cmocka_unit_test(balls_paint_only_over_what_is_below_a_value),
        cmocka_unit_test(arteries_have_the_names_of_label_maps),
        cmocka_unit_test(the_cut_of_a_cylinder_has_its_area_and_place),
        cmocka_unit_test(nothing_is_painted_beyond_the_ends_of_a_solid),
        cmocka_unit_test(a_solid_inside_another_replaces_it),
        cmocka_unit_test(balls_along_a_line_make_a_tube),
    };
    cmocka_set_message_output(CM_OUTPUT_TAP);
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
