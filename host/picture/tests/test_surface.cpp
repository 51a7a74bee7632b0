// Tests pictures of vessel walls: all panels must have one scale, nearer objects must hide farther ones, and
// a wall must look like glass over its contents.
#include "host/picture/surface_picture.hpp"
#include <csetjmp>
#include <cstdarg>
#include <cstddef>
#include <cstdint>
extern "C" {
#include <cmocka.h>
}

using namespace crn;
using Eigen::Vector3d;

namespace
{

constexpr int size = 100;

// Makes a box about the z axis; the corners of its faces are anticlockwise as seen from outside.
SurfaceMesh box(SurfaceKind kind, double half_mm, double z_mm)
{
    SurfaceMesh mesh;
    mesh.kind = kind;
    for (int i = 0; i < 8; ++i)
        mesh.vertices_mm.emplace_back(i & 1 ? half_mm : -half_mm, i & 2 ? half_mm : -half_mm,
                                      z_mm + (i & 4 ? half_mm : -half_mm));
    constexpr std::uint32_t sides[6][4] = {{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4},
                                           {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}};
    for (const auto &side : sides) {
        mesh.triangles.push_back({side[0], side[1], side[2]});
        mesh.triangles.push_back({side[0], side[2], side[3]});
    }
    return mesh;
}

std::array<int, 3> pixel(const Image &image, int x, int y)
{
    const std::uint8_t *at = &image.bytes[static_cast<std::size_t>((y * image.width + x) * image.channels)];
    return {at[0], at[1], at[2]};
}

constexpr std::array<int, 3> white = {255, 255, 255};

// The first box is 20 mm wide and covers 92 pixels of the panel. The second box is 10 mm wide, so it ends 23
// pixels from the middle of its panel.
void panels_are_side_by_side_on_one_scale(void **)
{
    const Image image = draw_surfaces(
        {{0, {box(SurfaceKind::calcium, 10, 0)}}, {1, {box(SurfaceKind::calcium, 5, 0)}}}, {}, size);
    assert_int_equal(image.width, 2 * size);
    assert_int_equal(image.height, size);
    assert_true(pixel(image, 94, 50) != white && pixel(image, 98, 50) == white);
    assert_true(pixel(image, size + 50 + 22, 50) != white && pixel(image, size + 50 + 24, 50) == white);
    assert_true(pixel(image, size + 50, 50 - 22) != white && pixel(image, size + 50, 50 - 24) == white);
}

// Seen from +z, the calcium is yellowish (more red than blue), and the balloon is blue.
void what_is_nearer_hides_what_is_behind(void **)
{
    for (const double calcium_z : {-8.0, 8.0}) {
        const Image image = draw_surfaces(
            {{0, {box(SurfaceKind::calcium, 5, calcium_z), box(SurfaceKind::balloon, 3, 0)}}}, {}, size);
        const auto [red, green, blue] = pixel(image, 50, 50);
        assert_true((red > blue) == (calcium_z > 0));
    }
}

// Beside the balloon the picture of the wall is red. Where the wall covers the balloon, the balloon's blue
// must be visible through the wall, but fainter than without the wall.
void a_wall_is_glass(void **)
{
    const SurfaceMesh balloon = box(SurfaceKind::balloon, 3, 0);
    const Image in_glass = draw_surfaces({{0, {box(SurfaceKind::wall, 5, 0), balloon}}}, {}, size);
    const auto [red, green, blue] = pixel(in_glass, 55, 45);
    const auto [wall_red, wall_green, wall_blue] = pixel(in_glass, 83, 55);
    assert_true(wall_red > wall_blue + 40);
    assert_true(blue > wall_blue + 10 && red < wall_red - 10);
    assert_true(pixel(in_glass, 98, 50) == white);
}

void nothing_is_white_paper(void **)
{
    const Image image = draw_surfaces({{0, {}}}, {}, size);
    assert_true(pixel(image, 50, 50) == white);
}

} // namespace

int main()
{
    const CMUnitTest tests[] = {
        cmocka_unit_test(panels_are_side_by_side_on_one_scale),
        cmocka_unit_test(what_is_nearer_hides_what_is_behind),
        cmocka_unit_test(a_wall_is_glass),
        cmocka_unit_test(nothing_is_white_paper),
    };
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
