// These tests check that the part of a mesh that near_part() cuts out gives the same distances, bit for bit,
// as the whole mesh: in the named blocks, in those beside them, and where another wall lies close by. The
// reference is the level set of the whole mesh.
#include "tools/bake/field.hpp"
#include "tools/bake/solid.hpp"
#include "tools/bake/tests/shapes.hpp"

#include <csetjmp>
#include <cstdarg>
#include <cstddef>
#include <cstdint>
extern "C" {
#include <cmocka.h>
}

using namespace crn::bake;
using namespace crn::bake::tests;

namespace near_part_tests
{

static constexpr double voxel_mm = 0.25, band_voxels = 9;

// Adds a mesh that does not touch the first one.
static void add(Mesh &mesh, const Mesh &other)
{
    const auto base = static_cast<std::uint32_t>(mesh.vertices_mm.size());
    mesh.vertices_mm.insert(mesh.vertices_mm.end(), other.vertices_mm.begin(), other.vertices_mm.end());
    for (const Triangle &t : other.triangles)
        mesh.triangles.push_back({t[0] + base, t[1] + base, t[2] + base});
}

// Compares the distances from the part with those from the whole mesh, around each block.
static void part_equals_whole(const Mesh &mesh, const std::vector<crn::mesh::Cell> &blocks, double share_max)
{
    const TriangleTree tree(mesh);
    const Mesh part = near_part(tree, blocks, crn::mesh::block_edge * voxel_mm);
    const double share =
        static_cast<double>(part.triangles.size()) / static_cast<double>(mesh.triangles.size());
    if (share > share_max) fail_msg("the part has %.2f of the triangles, allowed %.2f", share, share_max);
    const auto of_part = level_set(part, voxel_mm, 0.5, band_voxels, band_voxels),
               of_whole = level_set(mesh, voxel_mm, 0.5, band_voxels, band_voxels);
    for (const crn::mesh::Cell &block : blocks) {
        const crn::mesh::Cell low = {8 * block[0] - 8, 8 * block[1] - 8, 8 * block[2] - 8};
        const std::vector<double> expected = of_whole.read(low, 24, 1), got = of_part.read(low, 24, 1);
        int inside = 0, outside = 0;
        for (std::size_t n = 0; n < expected.size(); ++n) {
            if (got[n] != expected[n])
                fail_msg("voxel %zu of block (%d %d %d): %.6f mm, expected %.6f", n, block[0], block[1],
                         block[2], got[n], expected[n]);
            ++(expected[n] < 0 ? inside : outside);
        }
        assert_true(inside > 0 && outside > 0); // the wall passes through
    }
}

// A block has an edge of 2 mm, so the cut around it has one of 18 mm.
static void distances_in_and_beside_the_blocks_are_those_of_the_whole_mesh(void **)
{
    Mesh mesh = torus(20, 2, 200, 40);
    add(mesh, torus(22.9, 0.4, 200, 16)); // half a millimetre, or two voxels, from the first
    part_equals_whole(mesh, {{10, 0, 0}, {10, 1, 0}, {9, 0, 0}, {-12, 0, 0}}, 0.7);
}

static void the_same_holds_in_a_vessel_that_is_wider_than_the_cut(void **)
{
    part_equals_whole(torus(10.5, 9.5, 150, 120), {{9, 0, 0}}, 0.3);
}

} // namespace near_part_tests

int main()
{
    using namespace near_part_tests;
    const CMUnitTest tests[] = {
        cmocka_unit_test(distances_in_and_beside_the_blocks_are_those_of_the_whole_mesh),
        cmocka_unit_test(the_same_holds_in_a_vessel_that_is_wider_than_the_cut),
    };
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
