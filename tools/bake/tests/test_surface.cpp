// These tests check that a vessel made of centrelines is as wide as they state, or that the program says
// where it is not, by how much, and which voxel would hold the width. The distance of the axis from the
// triangles, computed here for each triangle, is the reference.
#include "tools/bake/centreline.hpp"
#include "tools/bake/tests/shapes.hpp"

#include <csetjmp>
#include <cstdarg>
#include <cstddef>
#include <cstdint>
extern "C" {
#include <cmocka.h>
}

using namespace crn::bake;

namespace surface_tests
{

// A vessel along y with a radius of 1.5 mm, which has a radius of `throat_mm` at its middle.
static Curve vessel(double throat_mm)
{
    Curve curve;
    curve.name = "vessel";
    for (int i = 0; i <= 80; ++i) {
        const double y = 0.5 * i, narrow = std::max(0.0, 1.0 - std::abs(y - 20.0) / 6.0);
        curve.spheres.push_back({{0.1, y, 0.2}, 1.5 - narrow * (1.5 - throat_mm)});
    }
    return curve;
}

// The least distance of the vessel's middle from the triangles: by projection onto each edge and face.
static double throat_radius_mm(const Mesh &mesh, const Eigen::Vector3d &middle)
{
    double least = INFINITY;
    for (const Triangle &t : mesh.triangles) {
        const Eigen::Vector3d corners[3] = {mesh.vertices_mm[t[0]], mesh.vertices_mm[t[1]],
                                            mesh.vertices_mm[t[2]]};
        const Eigen::Vector3d normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]).normalized();
        const Eigen::Vector3d foot = middle - normal * normal.dot(middle - corners[0]);
        bool is_inside = true;
        for (int k = 0; k < 3; ++k) {
            const Eigen::Vector3d &a = corners[k], edge = corners[(k + 1) % 3] - a;
            const double along = std::clamp((middle - a).dot(edge) / edge.squaredNorm(), 0.0, 1.0);
            least = std::min(least, (middle - a - along * edge).norm());
            is_inside = is_inside && normal.dot(edge.cross(foot - a)) >= 0;
        }
        if (is_inside) least = std::min(least, (middle - foot).norm());
    }
    return least;
}

static Mesh surface(const Curve &curve, double voxel_mm)
{
    Progress progress;
    Mesh mesh = surface_of({curve}, voxel_mm, progress);
    check_closed(mesh, Cap::none);
    return mesh;
}

// Before, a throat of 1.20 mm became one of 1.1 mm without a word, and a balloon in it pressed with 221 N in
// place of 162 N.
static void a_throat_that_the_voxel_cannot_hold_is_reported_with_the_one_that_does(void **)
{
    const Curve curve = vessel(0.6);
    const Mesh coarse = surface(curve, 0.75);
    const double lost_mm = 0.6 - throat_radius_mm(coarse, {0.1, 20.0, 0.2});
    const std::string warning = narrowing_warning(coarse, {curve}, 0.75);
    std::printf("# %s# at the throat: %.4f mm\n", warning.c_str(), lost_mm);
    assert_true(lost_mm > 0.02 * 0.6);
    double inside_mm = 0.0, radius_mm = 0.0, x = 0.0, y = 0.0, z = 0.0, percent = 0.0, holds_mm = 0.0;
    assert_int_equal(
        std::sscanf(warning.c_str(),
                    "warning: the surface of voxels of 0.75 mm is %lf mm inside the radius of %lf mm that "
                    "the centreline has at (%lf, %lf, %lf) mm (%lf %%), so the vessel is too narrow "
                    "there: surface_mm = %lf",
                    &inside_mm, &radius_mm, &x, &y, &z, &percent, &holds_mm),
        7);
    assert_true(std::abs(y - 20.0) < 1.5);
    assert_float_equal(radius_mm - inside_mm, throat_radius_mm(coarse, {x, y, z}), 0.006);
    assert_float_equal(percent, 100 * inside_mm / radius_mm, 1.0);
    const Mesh fine = surface(curve, holds_mm);
    assert_string_equal(narrowing_warning(fine, {curve}, holds_mm).c_str(), "");
    const double held_mm = throat_radius_mm(fine, {0.1, 20.0, 0.2});
    std::printf("# voxels of %.2f mm: radius %.4f mm of 0.6 mm\n", holds_mm, held_mm);
    // The two cones beside the throat meet in a circle, a little farther out than the throat's sphere.
    const double slope = (1.5 - 0.6) / 6.0, wanted_mm = 0.6 / std::sqrt(1 - slope * slope);
    assert_float_equal(held_mm, wanted_mm, 0.02 * wanted_mm);
}

static void a_wide_vessel_needs_no_warning(void **)
{
    Curve curve = vessel(1.5);
    for (auto &sphere : curve.spheres) sphere.radius_mm = 6.0;
    assert_string_equal(narrowing_warning(surface(curve, 0.75), {curve}, 0.75).c_str(), "");
}

} // namespace surface_tests

int main()
{
    const CMUnitTest tests[] = {
        cmocka_unit_test(
            surface_tests::a_throat_that_the_voxel_cannot_hold_is_reported_with_the_one_that_does),
        cmocka_unit_test(surface_tests::a_wide_vessel_needs_no_warning),
    };
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
