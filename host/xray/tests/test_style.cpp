// These tests check the following. Pictures in the style of the VCSim3 thesis follow the formula for the
// product over surfaces, show the bodies that the thesis shows, and do not depend on the number of threads.
// The test uses a sphere, in which the length of a ray's chord determines the angle between normal and ray.
#include "host/xray/style/vcsim3.hpp"
#include "host/xray/tests/xray_shapes.hpp"
#include <algorithm>
#include <cmath>
#include <csetjmp>
#include <cstdarg>
#include <cstddef>
#include <cstdint>
extern "C" {
#include <cmocka.h>
}

using namespace crn;

namespace
{

constexpr double sphere_radius_m = 0.04;

Bodies sphere_of(const char *material)
{
    return {{sphere_body("ball", material, -1, {0, 0, 0}, sphere_radius_m, 100)}};
}

XraySettings small_view()
{
    XraySettings settings;
    settings.size = 128;
    settings.carm.field_m = 0.15;
    return settings;
}

WireFrame straight_wire()
{
    WireFrame wire;
    for (int i = 0; i < 30; ++i)
        wire.nodes.push_back({Eigen::Vector3d(0.001 * i - 0.015, 0.02, 0.0), 0.001 * i, 0.0006, 0.0});
    wire.tip_arc_m = {0.0};
    return wire;
}

XrayPicture picture_of(const Bodies &bodies, const WireFrame &wire, int threads, std::uint64_t seed = 1)
{
    const RadiopaqueInstrument tool = guidewire_look();
    Vcsim3Look look(bodies, threads);
    XrayPicture picture;
    look.draw(small_view(), XrayFrame{{&tool, 1}, wire}, seed, picture);
    return picture;
}

// A ray crosses both surfaces of a sphere at the same angle: |n.v| is half the chord divided by the radius.
void density_of_a_sphere_is_the_stated_product(void **)
{
    const Bodies bodies = sphere_of("bone_cortical");
    Vcsim3Look look(bodies, 1);
    XrayPicture picture;
    look.draw(small_view(), XrayFrame{{}, {}}, 1, picture);
    const View view = make_view(small_view().carm, 128);
    const SurfaceLook surface = surface_look(bodies, 0);
    int compared = 0;
    for (int y = 0; y < 128; ++y)
        for (int x = 0; x < 128; ++x) {
            const double u = (x - 63.5) * view.pixel_m, v = (63.5 - y) * view.pixel_m;
            const Eigen::Vector3d ray =
                (view.right * u + view.up * v + view.forward * view.source_detector_m).normalized();
            const double along = ray.dot(-view.source_m),
                         square = view.source_m.squaredNorm() - along * along;
            const double got = look.body_density_q16()[static_cast<std::size_t>(y * 128 + x)] / 65536.0;
            if (square > sphere_radius_m * sphere_radius_m * 1.02) assert_true(got == 0.0);
            if (square > sphere_radius_m * sphere_radius_m * 0.96) continue; // the rim is a facet wide
            const double cosine = std::sqrt(1.0 - square / (sphere_radius_m * sphere_radius_m));
            const double opacity = surface.edge_opacity * std::pow(1.0 - cosine, surface.power);
            const double expected = -2.0 * std::log1p(-opacity);
            // The normals of the mesh are those of its flat facets, each of which spans 0.9 degrees.
            if (std::abs(got - expected) > 0.012 + 0.02 * expected)
                fail_msg("pixel %d, %d: density %.4f, expected %.4f", x, y, got, expected);
            ++compared;
        }
    assert_true(compared > 3000);
}

void noise_has_the_stated_mean_and_deviation(void **)
{
    const XrayPicture picture =
        picture_of(sphere_of("soft_tissue"), {}, 1); // not shown: background everywhere
    double sum = 0.0, squares = 0.0;
    for (std::uint8_t grey : picture.grey) {
        sum += grey;
        squares += static_cast<double>(grey) * grey;
    }
    const double count = static_cast<double>(picture.grey.size()), mean = sum / count;
    const double deviation = std::sqrt(squares / count - mean * mean);
    // Over 16,384 pixels the standard error of the mean is 0.07 grey values, and that of the standard
    // deviation is 0.05 grey values. Rounding down to whole numbers lowers the mean grey value by half a grey
    // value.
    if (std::abs(mean - (255.0 * vcsim3_background - 0.5)) > 0.3) fail_msg("mean %.3f", mean);
    if (std::abs(deviation - 255.0 * vcsim3_noise) > 0.25) fail_msg("deviation %.3f", deviation);
}

void shows_bones_heart_and_vessels_only(void **)
{
    Bodies bodies = sphere_of("cortical_bone");
    const auto shows = [&](const char *name, const char *material, const char *parent_material) {
        bodies.bodies.resize(1);
        bodies.bodies[0].material = parent_material;
        bodies.bodies.push_back(sphere_body(name, material, 0, {0, 0, 0}, 0.01, 2));
        return surface_look(bodies, 1).edge_opacity > 0.0;
    };
    assert_true(shows("femur", "cortical_bone", "muscle"));
    assert_true(shows("heart", "muscle", "muscle"));
    assert_true(shows("aorta", "blood", "soft"));
    assert_true(shows("renal", "iohexol_350", "soft"));
    assert_false(shows("flesh", "muscle", "adipose"));
    assert_false(shows("tree", "blood", "lung"));
    assert_false(shows("lung", "lung", "muscle"));
    assert_false(shows("marrow", "trabecular_bone", "cortical_bone"));
    assert_false(shows("gas", "air", "soft"));
}

void wire_is_a_dark_line_at_its_place(void **)
{
    const XrayPicture picture = picture_of({}, straight_wire(), 1);
    const View view = make_view(small_view().carm, 128);
    Eigen::Vector2d pixel;
    assert_true(project(view, {0.0, 0.02, 0.0}, pixel));
    const int x = static_cast<int>(pixel.x()), row = static_cast<int>(pixel.y());
    const auto at = [&](int y) { return int{picture.grey[static_cast<std::size_t>(y * 128 + x)]}; };
    const int darkest = std::min({at(row - 1), at(row), at(row + 1)});
    if (darkest > 150) fail_msg("grey %d on the wire, at most 150 expected", darkest);
    if (at(row - 5) < 170 || at(row + 5) < 170)
        fail_msg("grey %d and %d beside it", at(row - 5), at(row + 5));
}

// Returns the mean grey value along a line parallel to the tube's axis and `below_m` below it; the mean still
// has a noise of 0.8 grey values.
double grey_beside_the_axis(const XrayPicture &picture, double below_m)
{
    const View view = make_view(small_view().carm, 128);
    double sum = 0.0;
    for (int k = 0; k < 120; ++k) {
        Eigen::Vector2d pixel;
        assert_true(project(view, {0.0005 * (k - 60), -below_m, 0.0}, pixel));
        sum += picture.grey[static_cast<std::size_t>(static_cast<int>(pixel.y()) * 128 +
                                                     static_cast<int>(pixel.x()))];
    }
    return sum / 120.0;
}

// The test covers a former error: pictures in the thesis' style did not show contrast medium in vessels.
void contrast_medium_is_a_tube_that_is_darker_the_more_iodine_it_holds(void **)
{
    const auto picture_with = [](double share) {
        const SweptCurve curve{Material::iohexol_350,
                               {{{-0.04, 0.0, 0.0}, 0.005, share}, {{0.04, 0.0, 0.0}, 0.005, share}}};
        Vcsim3Look look({}, 1);
        XrayPicture picture;
        look.draw(small_view(), XrayFrame{{}, {}, {&curve, 1}}, 1, picture);
        return picture;
    };
    const double background = 255.0 * vcsim3_background;
    const XrayPicture undiluted = picture_with(1.0), diluted = picture_with(0.05);
    // At 4 mm from the tube's axis the ray crosses two surfaces with |n.v| = 0.6. The tube has only 12 sides,
    // and the rows of pixels are 0.8 mm apart at the tube.
    const double light = 1.0 - 0.8 * std::pow(1.0 - 0.6, 0.7);
    const double edge = grey_beside_the_axis(undiluted, 0.004);
    if (std::abs(edge - background * light * light) > 0.15 * background)
        fail_msg("grey %.1f at the edge, expected %.1f", edge, background * light * light);
    assert_true(edge + 40.0 < grey_beside_the_axis(undiluted, 0.0));
    const double thin = grey_beside_the_axis(diluted, 0.004);
    if (thin < edge + 30.0 || thin > background - 20.0) fail_msg("grey %.1f diluted", thin);
    for (const XrayPicture *picture : {&undiluted, &diluted})
        if (std::abs(grey_beside_the_axis(*picture, 0.008) - background) > 3.0) fail_msg("dark beside it");
    assert_true(picture_with(0.0).grey == picture_of({}, {}, 1).grey);
}

// The test covers a former error: a beating heart did not move in pictures in the thesis' style. Bodies must
// be drawn where they are at the tick of the picture. The bodies must return to their unmoved positions when
// the next picture has no moved bodies.
void bodies_are_drawn_where_they_have_moved_to(void **)
{
    const Eigen::Vector3i way_um(21000, -13000, 8000);
    Bodies bodies = sphere_of("bone_cortical"), there = bodies;
    bodies.bodies.push_back(sphere_body("still", "bone_cortical", -1, {-0.04, 0.04, 0}, 0.01, 20));
    there.bodies.push_back(bodies.bodies[1]);
    for (Eigen::Vector3i &vertex_um : there.bodies[0].vertices_um) vertex_um += way_um;
    const MovedBody moved{0, there.bodies[0].vertices_um};
    Vcsim3Look look(bodies, 1), look_there(there, 1);
    XrayPicture at_rest, picture, again, expected;
    look.draw(small_view(), XrayFrame{{}, {}}, 1, at_rest);
    look.draw(small_view(), XrayFrame{{}, {}, {}, {&moved, 1}}, 1, picture);
    look.draw(small_view(), XrayFrame{{}, {}}, 1, again);
    look_there.draw(small_view(), XrayFrame{{}, {}}, 1, expected);
    assert_true(picture.grey == expected.grey);
    assert_true(picture.grey != at_rest.grey);
    assert_true(again.grey == at_rest.grey);
}

void same_bytes_for_any_number_of_threads_and_only_the_seed_changes_the_noise(void **)
{
    const Bodies bodies = sphere_of("bone_cortical");
    const XrayPicture one = picture_of(bodies, straight_wire(), 1);
    assert_true(one.grey == picture_of(bodies, straight_wire(), 2).grey);
    assert_true(one.grey == picture_of(bodies, straight_wire(), 4).grey);
    assert_true(one.grey != picture_of(bodies, straight_wire(), 1, 2).grey);
}

} // namespace

int main()
{
    const CMUnitTest tests[] = {
        cmocka_unit_test(density_of_a_sphere_is_the_stated_product),
        cmocka_unit_test(noise_has_the_stated_mean_and_deviation),
        cmocka_unit_test(shows_bones_heart_and_vessels_only),
        cmocka_unit_test(wire_is_a_dark_line_at_its_place),
        cmocka_unit_test(contrast_medium_is_a_tube_that_is_darker_the_more_iodine_it_holds),
        cmocka_unit_test(bodies_are_drawn_where_they_have_moved_to),
        cmocka_unit_test(same_bytes_for_any_number_of_threads_and_only_the_seed_changes_the_noise),
    };
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
