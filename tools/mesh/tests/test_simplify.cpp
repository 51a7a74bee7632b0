// These tests check the following. The function drop_short_edges collapses edges that are shorter than a
// given length, and the surface stays closed and does not move.
#include "tools/mesh/simplify.hpp"

#include <Eigen/Geometry>
#include <cmath>
#include <csetjmp>
#include <cstdarg>
#include <cstddef>
#include <cstdint>
#include <map>
extern "C" {
#include <cmocka.h>
}

using namespace crn::mesh;
using Eigen::Vector3d;

namespace
{

struct Surface {
    std::vector<Vector3d> vertices;
    std::vector<Triangle> triangles;

    // Adds a vertex inside a triangle, beside the triangle's first corner, and divides the triangle into
    // three triangles.
    void divide(std::size_t t, double share)
    {
        const auto [a, b, c] = triangles[t];
        const auto inner = static_cast<uint32_t>(vertices.size());
        vertices.push_back(vertices[a] + share * (vertices[b] + vertices[c] - 2 * vertices[a]));
        triangles[t] = {a, b, inner};
        triangles.push_back({b, c, inner});
        triangles.push_back({c, a, inner});
    }
    double volume() const
    {
        double sum = 0;
        for (const Triangle &t : triangles)
            sum += vertices[t[0]].dot(vertices[t[1]].cross(vertices[t[2]])) / 6;
        return sum;
    }
    double shortest() const
    {
        double least = INFINITY;
        for (const Triangle &t : triangles)
            for (std::size_t k = 0; k < 3; ++k)
                least = std::min(least, (vertices[t[k]] - vertices[t[(k + 1) % 3]]).norm());
        return least;
    }
    bool is_closed() const
    {
        std::map<std::pair<uint32_t, uint32_t>, int> sides;
        for (const Triangle &t : triangles)
            for (std::size_t k = 0; k < 3; ++k)
                if (++sides[{t[k], t[(k + 1) % 3]}] > 1) return false;
        for (const auto &[side, count] : sides)
            if (!sides.contains({side.second, side.first})) return false;
        return true;
    }
};

Surface octahedron()
{
    return {{{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}},
            {{0, 2, 4}, {2, 1, 4}, {1, 3, 4}, {3, 0, 4}, {2, 0, 5}, {1, 2, 5}, {3, 1, 5}, {0, 3, 5}}};
}

void short_edges_vanish_and_the_surface_stays_closed(void **)
{
    Surface surface = octahedron();
    for (std::size_t t = 0; t < 8; ++t) surface.divide(t, 1e-4);
    surface.divide(3, 1e-4); /* a cluster: a short edge beside a short edge */
    surface.divide(3, 1e-4);
    assert_true(surface.is_closed() && surface.shortest() < 1e-3);
    drop_short_edges(surface.vertices, surface.triangles, 0.01);
    assert_true(surface.is_closed() && surface.shortest() > 1);
    assert_int_equal(surface.vertices.size(), 6);
    assert_int_equal(surface.triangles.size(), 8);
    assert_true(std::abs(surface.volume() - 4.0 / 3) < 1e-3);
}

void a_surface_without_short_edges_stays_as_it_is(void **)
{
    Surface surface = octahedron();
    drop_short_edges(surface.vertices, surface.triangles, 1);
    assert_true(surface.vertices == octahedron().vertices && surface.triangles == octahedron().triangles);
}

void a_tetrahedron_is_not_flattened(void **)
{
    Surface surface{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}},
                    {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}}};
    drop_short_edges(surface.vertices, surface.triangles, 5);
    assert_int_equal(surface.triangles.size(), 4);
}

} // namespace

int main()
{
    const CMUnitTest tests[] = {cmocka_unit_test(short_edges_vanish_and_the_surface_stays_closed),
                                cmocka_unit_test(a_surface_without_short_edges_stays_as_it_is),
                                cmocka_unit_test(a_tetrahedron_is_not_flattened)};
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
