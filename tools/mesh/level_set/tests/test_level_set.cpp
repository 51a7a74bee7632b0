// These tests check the following. A level set from blocks or from a mesh gives a closed surface at the
// requested distance and in the caller's unit. The surface's triangles are counter-clockwise as seen from
// outside. Solids are intersected and subtracted. The functions find the connected pieces of a surface and
// remove the pieces that are too small.
#include "tools/mesh/level_set/level_set.hpp"
#include "tools/mesh/pieces.hpp"

#include <Eigen/Geometry>
#include <algorithm>
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

constexpr double pi = 3.14159265358979323846;

// Makes the level set of a ball in the middle of 6^3 blocks around the origin; each voxel has the edge
// `voxel`.
LevelSet ball(double voxel, double radius, const Vector3d &middle = Vector3d::Zero(), bool is_near = false)
{
    LevelSet level(voxel, 3 * voxel);
    for (int k = -3; k < 3; ++k)
        for (int j = -3; j < 3; ++j)
            for (int i = -3; i < 3; ++i) {
                Block block;
                for (int n = 0; n < static_cast<int>(block.size()); ++n)
                    block[static_cast<std::size_t>(n)] =
                        (voxel * Vector3d(8 * i + n % 8, 8 * j + n / 8 % 8, 8 * k + n / 64) - middle).norm() -
                        radius;
                if (is_near)
                    level.set_near({i, j, k}, block);
                else
                    level.set({i, j, k}, block);
            }
    level.fill_signs();
    return level;
}

double volume(const std::vector<Vector3d> &v, const std::vector<Triangle> &triangles)
{
    double sum = 0;
    for (const Triangle &t : triangles) sum += v[t[0]].dot(v[t[1]].cross(v[t[2]])) / 6;
    return sum;
}

double volume(const LevelSet &level, double at = 0)
{
    const QuadSurface surface = level.surface(at);
    return volume(surface.vertices, divided(surface));
}

bool is_closed(const std::vector<Triangle> &triangles)
{
    std::map<std::pair<uint32_t, uint32_t>, int> sides;
    for (const Triangle &t : triangles)
        for (std::size_t k = 0; k < 3; ++k) {
            ++sides[{t[k], t[(k + 1) % 3]}];
            --sides[{t[(k + 1) % 3], t[k]}];
        }
    for (const auto &[side, count] : sides)
        if (count != 0) return false;
    return true;
}

void is_within(double got, double wanted, double share)
{
    if (std::abs(got / wanted - 1) > share) fail_msg("%.6g instead of %.6g", got, wanted);
}

void surface_of_blocks_is_closed_and_faces_outwards(void **)
{
    for (double voxel : {1.0, 0.5})
        for (bool is_near : {false, true}) {
            const double radius = 20 * voxel;
            const QuadSurface surface = ball(voxel, radius, Vector3d::Zero(), is_near).surface();
            for (const Vector3d &v : surface.vertices) is_within(v.norm(), radius, 0.004);
            for (const auto &triangles : {divided(surface), divided_shorter(surface)}) {
                assert_true(is_closed(triangles));
                is_within(volume(surface.vertices, triangles), 4 * pi / 3 * std::pow(radius, 3), 0.01);
            }
        }
}

void shorter_diagonal_is_the_edge_that_is_drawn(void **)
{
    const QuadSurface kite{{{0, 0, 0}, {1, 0.2, 0}, {3, 3, 0}, {0.2, 1, 0}}, {{0, 1, 2, 3}}};
    for (const auto &triangles : {divided(kite), divided_shorter(kite)}) {
        assert_int_equal(triangles.size(), 2);
        for (const Triangle &t : triangles) { /* both contain the diagonal 1-3 */
            assert_true(std::count(t.begin(), t.end(), 1u) == 1 && std::count(t.begin(), t.end(), 3u) == 1);
            const Vector3d normal =
                (kite.vertices[t[1]] - kite.vertices[t[0]]).cross(kite.vertices[t[2]] - kite.vertices[t[0]]);
            assert_true(normal.z() > 0);
        }
    }
    const QuadSurface other{kite.vertices, {{1, 2, 3, 0}}};
    const Triangle first = divided_shorter(other)[0];
    assert_true(std::count(first.begin(), first.end(), 1u) == 1 &&
                std::count(first.begin(), first.end(), 3u) == 1);
}

void mesh_gives_distances_inside_and_outside_of_it(void **)
{
    const QuadSurface surface = ball(0.5, 8).surface();
    const LevelSet level(surface.vertices, divided(surface), 0.5, 0, 6, 6);
    for (double at : {-2.0, 0.0, 2.0}) is_within(volume(level, at), 4 * pi / 3 * std::pow(8 + at, 3), 0.02);
    const std::vector<double> across = level.read({14, 0, 0}, 5, 0.5); /* x from 7 to 9 mm, in voxels */
    for (std::size_t i = 0; i < 5; ++i)
        if (std::abs(across[i] - (static_cast<double>(i) - 2)) > 0.15) fail_msg("%.3f voxels", across[i]);
    double deepest = 0;
    for (const InsideVoxel &voxel : level.inside()) {
        const Vector3d p = 0.5 * Vector3d(voxel.cell[0], voxel.cell[1], voxel.cell[2]);
        if (std::abs(8 - p.norm() - static_cast<double>(voxel.depth_mm)) > 0.1)
            fail_msg("%.3f mm deep", static_cast<double>(voxel.depth_mm));
        deepest = std::max(deepest, static_cast<double>(voxel.depth_mm));
    }
    assert_true(deepest > 2.5 && deepest <= 3); /* six voxels are kept */
}

void solids_are_intersected_and_subtracted(void **)
{
    const double whole = 4 * pi / 3 * 1000, lens = pi / 12 * (4 * 10 + 8) * std::pow(2 * 10 - 8, 2);
    LevelSet both = ball(1, 10), rest = ball(1, 10);
    both.intersect(ball(1, 10, {8, 0, 0}));
    rest.subtract(ball(1, 10, {8, 0, 0}));
    is_within(volume(both), lens, 0.03);
    is_within(volume(rest), whole - lens, 0.03);
}

void changed_distances_move_the_surface(void **)
{
    LevelSet level = ball(1, 15);
    for (const Cell &block : level.blocks())
        level.change(block, [](const Cell &at, float) {
            return static_cast<float>(Vector3d(at[0], at[1], at[2]).norm() - 18);
        });
    is_within(volume(level), 4 * pi / 3 * std::pow(18, 3), 0.01);
}

void small_pieces_are_dropped(void **)
{
    const QuadSurface large = ball(1, 15).surface(), small = ball(1, 4).surface();
    std::vector<Vector3d> vertices = small.vertices;
    std::vector<Triangle> triangles = divided(small);
    for (const Triangle &t : divided(large)) {
        const auto base = static_cast<uint32_t>(small.vertices.size());
        triangles.push_back({t[0] + base, t[1] + base, t[2] + base});
    }
    for (const Vector3d &v : large.vertices) vertices.push_back(v);
    const std::size_t all = triangles.size(), small_count = divided(small).size();
    drop_small_pieces(vertices, triangles, small_count, 0);
    assert_int_equal(triangles.size(), all); /* it has as many as it needs */
    drop_small_pieces(vertices, triangles, 0, 0.5);
    assert_int_equal(triangles.size(), all - small_count);
    assert_int_equal(vertices.size(), large.vertices.size());
    assert_true(is_closed(triangles));
    drop_small_pieces(vertices, triangles, all, 0);
    assert_true(vertices.empty() && triangles.empty());
}

} // namespace

int main()
{
    const CMUnitTest tests[] = {
        cmocka_unit_test(surface_of_blocks_is_closed_and_faces_outwards),
        cmocka_unit_test(shorter_diagonal_is_the_edge_that_is_drawn),
        cmocka_unit_test(mesh_gives_distances_inside_and_outside_of_it),
        cmocka_unit_test(solids_are_intersected_and_subtracted),
        cmocka_unit_test(changed_distances_move_the_surface),
        cmocka_unit_test(small_pieces_are_dropped),
    };
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
