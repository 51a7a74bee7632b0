// These tests check the following. Exact distances are exact. A mesh that encloses a solid is accepted, and
// is repaired where a repair is safe. For any other mesh the error message gives the file, the element and
// the remedy. The tests use small meshes with one fault each.
#include "tools/bake/centreline.hpp"
#include "tools/bake/tests/shapes.hpp"
#include "tools/bake/tests/texts.hpp"

#include <csetjmp>
#include <cstdarg>
#include <cstddef>
#include <cstdint>
#include <random>
extern "C" {
#include <cmocka.h>
}

using namespace crn::bake;
using namespace crn::bake::tests;

namespace
{

void tree_gives_the_signed_distance_of_a_cube(void **)
{
    const Mesh mesh = cube(10);
    const TriangleTree tree(mesh);
    std::mt19937_64 random(5);
    for (int i = 0; i < 20000; ++i) {
        Eigen::Vector3d p;
        for (int k = 0; k < 3; ++k) p[k] = std::ldexp(static_cast<double>(random() >> 11), -53) * 20 - 5;
        const Eigen::Vector3d q = (p.array() - 5).abs() - 5;
        const double exact = q.cwiseMax(0).norm() + std::min(0.0, q.maxCoeff());
        const double got = tree.nearest(p).distance_mm;
        if (std::abs(got - exact) > 1e-12)
            fail_msg("%g at %s, expected %g", got, place_text(p).c_str(), exact);
    }
}

void closed_mesh_is_taken_and_an_inverted_one_turned(void **)
{
    Mesh mesh = cube(10);
    check_closed(mesh, Cap::none);
    assert_true(std::abs(volume_mm3(mesh) - 1000) < 1e-9 && mesh.notes.empty());
    for (Triangle &t : mesh.triangles) std::swap(t[0], t[1]);
    check_closed(mesh, Cap::none);
    assert_true(volume_mm3(mesh) > 999);
    contains(mesh.notes.at(0), {"inside out"});
}

void one_turned_triangle_is_turned_back(void **)
{
    Mesh mesh = cube(10);
    std::swap(mesh.triangles[7][0], mesh.triangles[7][1]);
    check_closed(mesh, Cap::none);
    assert_true(std::abs(volume_mm3(mesh) - 1000) < 1e-9);
    contains(mesh.notes.at(0), {"1 triangles turned"});
}

void openings_are_told_by_place_and_capped_on_request(void **)
{
    Mesh open = tube(6, 80, 20, 32);
    contains(complaint([&] { check_closed(open, Cap::none); }),
             {"test mesh", "2 openings", "(0.0, 0.0, 0.0) mm (32 edges, 12.0 mm across)",
              "(0.0, 80.0, 0.0) mm", "cap = true"});
    check_closed(open, Cap::flat);
    const double area = 32 * 36.0 / 2 * std::sin(turn / 32);
    assert_true(std::abs(volume_mm3(open) - area * 80) < 1e-6);
}

void opening_that_is_not_flat_is_not_capped(void **)
{
    Mesh mesh = tube(6, 80, 20, 32);
    mesh.vertices_mm[3].y() -= 4;
    contains(complaint([&] { check_closed(mesh, Cap::flat); }), {"not flat", "(32 edges", "mesh editor"});
}

void non_manifold_edge_is_named(void **)
{
    Mesh mesh = cube(10);
    mesh.vertices_mm.emplace_back(5, 5, 20);
    mesh.triangles.push_back({4, 5, 8});
    contains(complaint([&] { check_closed(mesh, Cap::none); }),
             {"1 non-manifold edges", "(0.0, 0.0, 10.0) mm - (10.0, 0.0, 10.0) mm", "3 triangles",
              "2 open edges"});
}

void one_sided_surface_is_refused(void **)
{
    Mesh strip = grid_mesh(40, 2, false, [](double u, double v) {
        const double across = (v - 0.25) * 8, half = turn / 2 * u;
        return Eigen::Vector3d((20 + across * std::cos(half)) * std::cos(turn * u),
                               (20 + across * std::cos(half)) * std::sin(turn * u), across * std::sin(half));
    });
    std::vector<Triangle>
        kept; // the grid closes along v: we drop its second half and join the ends crosswise
    for (Triangle t : strip.triangles) {
        for (std::uint32_t &v : t)
            if (v >= 80) v = 81 - v;
        if (t[0] != t[1] && t[1] != t[2] && t[2] != t[0]) kept.push_back(t);
    }
    strip.triangles.clear();
    for (std::size_t i = 0; i < kept.size(); i += 4)
        strip.triangles.insert(strip.triangles.end(), kept.begin() + static_cast<std::ptrdiff_t>(i),
                               kept.begin() + static_cast<std::ptrdiff_t>(i) + 2);
    contains(complaint([&] { check_closed(strip, Cap::none); }), {"one-sided", "triangle"});
}

void crossing_triangles_are_named(void **)
{
    Progress progress;
    Mesh mesh = cube(10);
    assert_string_equal(complaint([&] { check_crossing(mesh, progress); }).c_str(), "");
    const Mesh other = cube(10);
    for (const Eigen::Vector3d &v : other.vertices_mm)
        mesh.vertices_mm.push_back(v + Eigen::Vector3d(3, 4, 5));
    for (const Triangle &t : other.triangles) mesh.triangles.push_back({t[0] + 8, t[1] + 8, t[2] + 8});
    contains(complaint([&] { check_crossing(mesh, progress); }),
             {"cube", "pairs of triangles cross", "the first are", "boolean union"});
}

void flat_sheet_is_refused(void **)
{
    Mesh mesh;
    mesh.name = "sheet";
    mesh.vertices_mm = {{0, 0, 0}, {10, 0, 0}, {0, 10, 0}};
    mesh.triangles = {{0, 1, 2}, {0, 2, 1}};
    contains(complaint([&] { check_closed(mesh, Cap::none); }), {"sheet", "encloses nothing"});
}

std::string loading(const Folder &folder, const std::string &name, const std::string &content,
                    const std::string &unit = "mm")
{
    MeshText text;
    text.file = folder.write(name, content);
    text.placement.unit = unit;
    return complaint([&] { load_mesh(text); });
}

const std::string tetrahedron = "v 0 0 0\nv 20 0 0\nv 0 20 0\nv 0 0 20\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n";

void files_without_a_mesh_are_refused(void **)
{
    const Folder folder;
    contains(loading(folder, "a.stl", ""), {"a.stl", "is empty"});
    contains(loading(folder, "b.obj", "v 0 0 0\nv 1 0 0\n"), {"b.obj"});
    contains(loading(folder, "c.ply", "not a mesh"), {"c.ply", "cannot be read"});
    contains(loading(folder, "d.xyz", tetrahedron), {"d.xyz", "export the mesh as"});
    contains(loading(folder, "e.glb", "glTF garbage garbage"), {"e.glb", "cannot be read"});
    assert_string_equal(loading(folder, "good.obj", tetrahedron).c_str(), "");
}

void wrong_unit_is_recognised(void **)
{
    const Folder folder;
    contains(loading(folder, "a.obj", tetrahedron, "m"),
             {"a.obj", "unit 'm'", "did you mean unit 'cm' or 'mm'?"});
    contains(loading(folder, "a.obj", tetrahedron, "um"), {"0.02 mm", "did you mean"});
    contains(loading(folder, "b.obj",
                     "v 0 0 0\nv 0.5 0 0\nv 0 0.5 0\nv 0 0 0.5\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n"),
             {"0.5 mm long", "'m'"});
}

void numbers_that_are_not_finite_are_named(void **)
{
    const Folder folder;
    std::string ply =
        "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n"
        "element face 4\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n20 0 0\n0 nan 0\n0 0 20\n"
        "3 0 2 1\n3 0 1 3\n3 0 3 2\n3 1 2 3\n";
    contains(loading(folder, "a.ply", ply), {"a.ply", "vertex 2", "not a number"});
}

void equal_vertices_are_welded(void **)
{
    const Folder folder;
    std::string stl = "solid a\n";
    const Mesh mesh = cube(10);
    for (const Triangle &t : mesh.triangles) {
        stl += "facet normal 0 0 0\nouter loop\n";
        for (std::uint32_t v : t)
            stl += "vertex " + std::to_string(mesh.vertices_mm[v].x()) + " " +
                   std::to_string(mesh.vertices_mm[v].y()) + " " + std::to_string(mesh.vertices_mm[v].z()) +
                   "\n";
        stl += "endloop\nendfacet\n";
    }
    MeshText text;
    text.file = folder.write("cube.stl", stl + "endsolid a\n");
    text.placement.unit = "mm";
    Mesh loaded = load_mesh(text);
    assert_int_equal(loaded.vertices_mm.size(), 8);
    check_closed(loaded, Cap::none);
    assert_true(std::abs(volume_mm3(loaded) - 1000) < 1e-6);
}

// Returns the distance of a point from the convex hull of two spheres; the function tries many spheres
// interpolated between the two.
double hull_distance(const Eigen::Vector3d &p, const Eigen::Vector3d &a, double ra, const Eigen::Vector3d &b,
                     double rb)
{
    double best = INFINITY;
    for (int i = 0; i <= 100000; ++i) {
        const double s = i / 100000.0;
        best = std::min(best, (p - a - s * (b - a)).norm() - ra - s * (rb - ra));
    }
    return best;
}

void tapered_capsule_distance_is_that_of_all_spheres_between(void **)
{
    std::mt19937_64 random(9);
    const auto draw = [&](double low, double high) {
        return low + (high - low) * std::ldexp(static_cast<double>(random() >> 11), -53);
    };
    for (int i = 0; i < 60; ++i) {
        const Eigen::Vector3d a(draw(-5, 5), draw(-5, 5), draw(-5, 5)),
            b(draw(-5, 5), draw(-5, 5), draw(-5, 5));
        const Eigen::Vector3d p(draw(-15, 15), draw(-15, 15), draw(-15, 15));
        const double ra = draw(0.5, 4), rb = draw(0.5, 4), expected = hull_distance(p, a, ra, b, rb);
        const double got = tapered_capsule_distance(p, a, ra, b, rb);
        if (std::abs(got - expected) > 1e-6) fail_msg("%g, expected %g", got, expected);
    }
}

void surface_of_a_straight_centreline_is_a_closed_tube(void **)
{
    Progress progress;
    Curve line;
    for (double y : {0, 30, 60}) line.spheres.push_back({{0, y, 0}, 5});
    Mesh mesh = surface_of({line}, 0.5, progress);
    check_closed(mesh, Cap::none);
    assert_int_equal(mesh.notes.size(), 0); /* it is not inside out, so nothing is repaired */
    const double exact = turn / 2 * 25 * 60 + 4.0 / 3 * turn / 2 * 125;
    assert_true(std::abs(volume_mm3(mesh) / exact - 1) < 0.005);
    for (const Eigen::Vector3d &v : mesh.vertices_mm) {
        const double wall =
            tapered_capsule_distance(v, line.spheres[0].centre_mm, 5, line.spheres[2].centre_mm, 5);
        assert_true(std::abs(wall) <
                    0.02); /* chords of half a millimetre: h^2 / 8 R = 0.006 mm, twice along a diagonal */
    }
}

} // namespace

int main()
{
    const CMUnitTest tests[] = {
        cmocka_unit_test(tree_gives_the_signed_distance_of_a_cube),
        cmocka_unit_test(closed_mesh_is_taken_and_an_inverted_one_turned),
        cmocka_unit_test(one_turned_triangle_is_turned_back),
        cmocka_unit_test(openings_are_told_by_place_and_capped_on_request),
        cmocka_unit_test(opening_that_is_not_flat_is_not_capped),
        cmocka_unit_test(non_manifold_edge_is_named),
        cmocka_unit_test(one_sided_surface_is_refused),
        cmocka_unit_test(crossing_triangles_are_named),
        cmocka_unit_test(flat_sheet_is_refused),
        cmocka_unit_test(files_without_a_mesh_are_refused),
        cmocka_unit_test(wrong_unit_is_recognised),
        cmocka_unit_test(numbers_that_are_not_finite_are_named),
        cmocka_unit_test(equal_vertices_are_welded),
        cmocka_unit_test(tapered_capsule_distance_is_that_of_all_spheres_between),
        cmocka_unit_test(surface_of_a_straight_centreline_is_a_closed_tube),
    };
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
