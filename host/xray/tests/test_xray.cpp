// Compares path lengths with formulas, and tests that a picture depends only on its inputs. The photons and
// the detector are tested in test_xray_physics.cpp.
#include "host/xray/detector.hpp"
#include "host/xray/tests/xray_shapes.hpp"
#include "host/xray/xray.hpp"
#include <algorithm>
#include <cmath>
#include <csetjmp>
#include <cstdarg>
#include <cstddef>
#include <cstdio>
extern "C" {
#include <cmocka.h>
}

using namespace crn;

namespace
{

double sphere_chord_m(const View &view, const Eigen::Vector3d &ray, const Eigen::Vector3d &centre_m,
                      double radius_m)
{
    const Eigen::Vector3d to = centre_m - view.source_m;
    const double along = to.dot(ray), square = radius_m * radius_m - (to.squaredNorm() - along * along);
    return square > 0.0 ? 2.0 * std::sqrt(square) : 0.0;
}

double box_chord_m(const View &view, const Eigen::Vector3d &ray, const Eigen::Vector3d &low,
                   const Eigen::Vector3d &high)
{
    double enter = 0.0, leave = 1e9;
    for (int axis = 0; axis < 3; ++axis) {
        double a = (low[axis] - view.source_m[axis]) / ray[axis],
               b = (high[axis] - view.source_m[axis]) / ray[axis];
        enter = std::max(enter, std::min(a, b));
        leave = std::min(leave, std::max(a, b));
    }
    return std::max(leave - enter, 0.0);
}

struct Errors {
    double mean_mm = 0.0, max_mm = 0.0;
};

template <class Chord>
Errors path_errors(const std::vector<std::int32_t> &path, const View &view, Chord chord_m)
{
    Errors errors;
    int count = 0;
    for (int y = 0; y < view.size; ++y)
        for (int x = 0; x < view.size; ++x) {
            const double expected_mm = chord_m(pixel_ray(view, x, y)) * 1e3;
            const double off_mm =
                std::fabs(path[static_cast<std::size_t>(y) * view.size + x] / 1024.0 - expected_mm);
            errors.max_mm = std::max(errors.max_mm, off_mm);
            if (expected_mm == 0.0) continue;
            errors.mean_mm += off_mm;
            ++count;
        }
    errors.mean_mm /= std::max(count, 1);
    std::printf("# mean %.4f mm, max %.4f mm over %d pixels\n", errors.mean_mm, errors.max_mm, count);
    return errors;
}

XraySettings oblique_settings()
{
    XraySettings settings;
    settings.carm.primary_deg = 37.0;
    settings.carm.secondary_deg = -21.0;
    settings.carm.isocentre_m = {0.01, 0.02, -0.03};
    return settings;
}

struct Rendered {
    XrayScene scene;
    std::unique_ptr<Xray> xray;
    XrayPicture picture;
};

std::unique_ptr<Rendered> render(const Bodies &bodies, const XraySettings &settings,
                                 const WireFrame &wire = {}, int threads = 2,
                                 const std::vector<RadiopaqueInstrument> &tools = {guidewire_look()})
{
    auto rendered = std::make_unique<Rendered>();
    std::string error;
    if (!rendered->scene.set_bodies(bodies, error)) {
        std::printf("# %s\n", error.c_str());
        fail_msg("the bodies were refused");
    }
    rendered->xray = std::make_unique<Xray>(rendered->scene, threads);
    rendered->xray->render(settings, tools, wire, 7, rendered->picture);
    return rendered;
}

WireFrame bent_wire()
{
    WireFrame wire;
    wire.tick = 1234;
    for (int i = 0; i < 80; ++i) { // half circle of radius 40 mm by a rational parametrisation, then straight
        const double s = std::min(i, 40) / 40.0 * 2.0 - 1.0, scale = 0.04 / (1.0 + s * s);
        WireNode node;
        node.position_m = {scale * (1 - s * s), scale * 2 * s + 0.002 * std::max(i - 40, 0), 0.01 * s};
        node.arc_m = i * 0.0025;
        node.radius_m = 0.00045;
        wire.nodes.push_back(node);
    }
    return wire;
}

Bodies chest_like()
{
    return {{sphere_body("trunk", "soft_tissue", -1, {0, 0, 0}, 0.11, 24),
             sphere_body("lung", "lung", 0, {0.05, 0.01, 0}, 0.04, 12),
             box_body("spine", "bone", 0, {-0.02, -0.06, -0.06}, {0.02, 0.06, -0.03})}};
}

std::uint64_t hash_of(const XrayPicture &picture)
{
    std::uint64_t hash = 14695981039346656037ull;
    auto take = [&](unsigned byte) { hash = (hash ^ byte) * 1099511628211ull; };
    for (std::uint8_t grey : picture.grey) take(grey);
    for (std::uint16_t raw : picture.raw) {
        take(raw & 255u);
        take(raw >> 8);
    }
    for (std::uint32_t photons : picture.photons) {
        take(photons & 255u);
        take(photons >> 8 & 255u);
    }
    return hash;
}

} // namespace

// With 100,000 triangles the remaining errors are the distance between facets and sphere (0.013 mm), and half
// a unit (1/2048 mm) of rounding per face.
static void sphere_path_is_the_chord(void **)
{
    const Eigen::Vector3d centre_m(0.02, 0.01, -0.02);
    const auto seen =
        render({{sphere_body("ball", "soft_tissue", -1, centre_m, 0.06, 112)}}, oblique_settings());
    const View view = make_view(oblique_settings().carm, 512);
    const Errors errors =
        path_errors(seen->xray->body_path_q10mm(Material::soft_tissue), view,
                    [&](const auto &ray) { return sphere_chord_m(view, ray, centre_m, 0.06); });
    assert_true(errors.mean_mm < 0.02);
}

// On flat faces a mesh of facets has no error of shape. The errors of a box come only from the rounding of
// its depths and of its corners, which moves the corners by up to 1/512 pixel at the slanted rim.
static void box_path_is_the_chord(void **)
{
    const Eigen::Vector3d low(-0.03, -0.05, -0.04), high(0.04, 0.03, 0.02);
    const auto seen = render({{box_body("box", "bone", -1, low, high)}}, oblique_settings());
    const View view = make_view(oblique_settings().carm, 512);
    const Errors errors = path_errors(seen->xray->body_path_q10mm(Material::bone_cortical), view,
                                      [&](const auto &ray) { return box_chord_m(view, ray, low, high); });
    assert_true(errors.mean_mm < 0.005);
    assert_true(errors.max_mm < 0.5);
}

static void nested_body_is_taken_out_of_its_parent(void **)
{
    const Eigen::Vector3d outer_m(0, 0, 0), inner_m(0.01, 0.005, 0.01);
    const auto seen = render({{sphere_body("heart", "muscle", -1, outer_m, 0.06, 80),
                               sphere_body("cavity", "blood", 0, inner_m, 0.03, 80)}},
                             oblique_settings());
    const View view = make_view(oblique_settings().carm, 512);
    auto inner = [&](const auto &ray) { return sphere_chord_m(view, ray, inner_m, 0.03); };
    auto wall = [&](const auto &ray) { return sphere_chord_m(view, ray, outer_m, 0.06) - inner(ray); };
    assert_true(path_errors(seen->xray->body_path_q10mm(Material::blood), view, inner).mean_mm < 0.02);
    assert_true(path_errors(seen->xray->body_path_q10mm(Material::muscle), view, wall).mean_mm < 0.03);
}

// If the source is inside a body, the path length is measured from the source to the wall; faces behind the
// source or nearer than 1 mm are cut off.
static void source_inside_a_body_sees_the_way_out(void **)
{
    XraySettings settings;
    const Eigen::Vector3d low(-0.3, -0.3, -0.9), high(0.3, 0.3, 0.1);
    const auto seen = render({{box_body("box", "soft_tissue", -1, low, high)}}, settings);
    const View view = make_view(settings.carm, 512);
    const Errors errors = path_errors(seen->xray->body_path_q10mm(Material::soft_tissue), view,
                                      [&](const auto &ray) { return box_chord_m(view, ray, low, high); });
    assert_true(errors.mean_mm < 0.01);
}

static void picture_is_the_same_for_any_number_of_threads(void **)
{
    const std::uint64_t one = hash_of(render(chest_like(), oblique_settings(), bent_wire(), 1)->picture);
    for (int threads : {2, 3, 7})
        assert_int_equal(hash_of(render(chest_like(), oblique_settings(), bent_wire(), threads)->picture),
                         one);
    // The golden hash of the picture is equal for all compilers and optimisation levels; it changes only when
    // the picture is meant to change.
    std::printf("# hash %016llx\n", static_cast<unsigned long long>(one));
    assert_int_equal(one, 0x7a9083b12e5445e1);
}

// Medium in a wide vessel has one ray per pixel and in a narrow vessel nine rays, and a wire displaces
// medium. The golden hash of this picture, too, is equal for all compilers and any number of threads.
static void picture_of_contrast_medium_is_the_same_for_any_number_of_threads(void **)
{
    XrayScene scene;
    std::string error;
    assert_true(scene.set_bodies(chest_like(), error));
    SweptCurve wide{Material::iohexol_350, {}}, narrow{Material::iohexol_350, {}};
    for (int i = 0; i <= 30; ++i) {
        const double s = i / 30.0;
        wide.points.push_back({{0.01 + 0.02 * s * s, -0.05 + 0.1 * s, 0.01 * s}, 0.012, 0.1 + 0.5 * s});
        narrow.points.push_back({{-0.03 + 0.05 * s, 0.02 * s, 0.02}, 0.003 - 0.002 * s, 0.8});
    }
    const std::vector<SweptCurve> curves = {wide, narrow};
    const std::vector<RadiopaqueInstrument> wires = {guidewire_look()};
    WireFrame wire = bent_wire();
    for (WireNode &node : wire.nodes) node.contrast_mg_per_ml = 120.0;
    for (int threads : {1, 2, 7}) {
        Xray xray(scene, threads);
        XrayPicture picture;
        xray.render(oblique_settings(), {wires, wire, curves}, 7, nullptr, picture);
        std::printf("# contrast medium %016llx\n", static_cast<unsigned long long>(hash_of(picture)));
        assert_int_equal(hash_of(picture), 0xf1f93ff6fd41763c);
    }
}

static void kept_view_gives_the_same_picture_as_a_new_one(void **)
{
    const auto first = render(chest_like(), oblique_settings(), bent_wire());
    const std::vector<RadiopaqueInstrument> wires = {guidewire_look()};
    XrayPicture kept, moved;
    first->xray->render(oblique_settings(), wires, WireFrame{}, 7, moved);
    assert_true(first->xray->last_render_used_cache());
    assert_int_not_equal(hash_of(moved), hash_of(first->picture));
    first->xray->render(oblique_settings(), wires, bent_wire(), 7, kept);
    assert_true(first->xray->last_render_used_cache());
    assert_int_equal(hash_of(kept), hash_of(first->picture));
    XraySettings other = oblique_settings();
    other.carm.primary_deg += 1.0;
    first->xray->render(other, wires, bent_wire(), 7, moved);
    assert_false(first->xray->last_render_used_cache());
}

// A renderer that has drawn other poses, tools and views must give the picture of one that draws for the
// first time: a lung that breathes, a guidewire, and medium in a wide, a narrow and a small vessel.
static void breath_gives_the_picture_of_a_new_renderer_with_tools_and_medium(void **)
{
    const Bodies bodies = chest_like();
    XrayScene scene;
    std::string error;
    assert_true(scene.set_bodies(bodies, error));
    Xray kept(scene, 2);
    const std::vector<RadiopaqueInstrument> wires = {guidewire_look()};
    for (int pulse = 0; pulse < 8; ++pulse) {
        XraySettings settings = oblique_settings();
        if (pulse > 3) settings.carm.isocentre_m.y() += 0.03;
        std::vector<Eigen::Vector3i> lung = bodies.bodies[1].vertices_um;
        for (Eigen::Vector3i &at : lung) at.y() += pulse == 6 ? 0 : 900 * pulse;
        const MovedBody moved[] = {{1, lung}};
        std::vector<SweptCurve> curves(3, {Material::iohexol_350, {}});
        for (int i = 0; i <= 10; ++i) {
            const double s = 0.1 * i, filled = 0.1 + 0.08 * pulse;
            curves[0].points.push_back({{0.01, -0.05 + 0.1 * s, 0.01 * s}, 0.012, filled});
            curves[1].points.push_back({{-0.03 + 0.05 * s, 0.02 * s, 0.02}, 0.003, filled});
            curves[2].points.push_back({{0.02 + 0.06 * s, 0.03 * s * pulse, 0.0}, 0.0004, filled});
        }
        curves[2].is_fine = true;
        WireFrame wire = bent_wire();
        for (WireNode &node : wire.nodes) node.position_m.x() += 0.001 * pulse;
        const XrayFrame frame{wires, wire, curves, moved};
        XrayPicture picture, expected;
        kept.render(settings, frame, 7, nullptr, picture);
        Xray(scene, 1).render(settings, frame, 7, nullptr, expected);
        assert_true(picture.raw == expected.raw && picture.photons == expected.photons);
        assert_true(picture.grey == expected.grey && picture.shown == expected.shown);
    }
}

// The path length times the cross-section of the beam, summed over all pixels, must be the volume of the
// guidewire's tube, including its bends.
static void tube_has_the_volume_of_its_wire(void **)
{
    XraySettings settings;
    const WireFrame wire = bent_wire();
    const RadiopaqueInstrument solid{{{0.0, 1.0, Material::steel, 1.0, 1.0}}, {}};
    const auto seen = render({}, settings, wire, 1, {solid});
    const std::vector<std::int32_t> path = seen->xray->instrument_path_q10mm(Material::steel);
    double length_mm = 0.0, volume_mm3 = 0.0;
    for (std::size_t i = 1; i < wire.nodes.size(); ++i)
        length_mm += (wire.nodes[i].position_m - wire.nodes[i - 1].position_m).norm() * 1e3;
    const double magnification = settings.carm.source_detector_m / settings.carm.source_isocentre_m;
    const double pixel_mm = settings.carm.field_m / 512.0 * 1e3 / magnification;
    for (std::int32_t chord : path) volume_mm3 += chord / 1024.0 * pixel_mm * pixel_mm;
    const double expected = 3.14159265 * 0.45 * 0.45 * length_mm;
    std::printf("# volume %.3f mm3, expected %.3f\n", volume_mm3, expected);
    // The tolerance of the volume is 2 %, because the guidewire leaves the plane of the isocentre by up to 10
    // mm in both directions (2.7 % in area), and is smoothed between nodes.
    assert_true(std::fabs(volume_mm3 - expected) < 0.02 * expected);
}

static void tube_is_unbroken_and_as_thick_as_the_wire(void **)
{
    WireFrame wire;
    for (int i = 0; i < 40; ++i) {
        WireNode node;
        node.position_m = {0.0003 + i * 0.0012, -0.02 + i * 0.001, 0.0};
        node.arc_m = i * 0.0015620499;
        node.radius_m = 0.00045;
        wire.nodes.push_back(node);
    }
    XraySettings settings;
    const RadiopaqueInstrument solid{{{0.0, 1.0, Material::steel, 1.0, 1.0}}, {}};
    const auto seen = render({}, settings, wire, 1, {solid});
    const std::vector<std::int32_t> path = seen->xray->instrument_path_q10mm(Material::steel);
    const View view = make_view(settings.carm, 512);
    double thinnest_mm = 1e9, thickest_mm = 0.0;
    for (int step = 20; step <= 180; ++step) {
        const double share = step / 200.0;
        Eigen::Vector2d pixel;
        assert_true(project(view,
                            wire.nodes.front().position_m +
                                share * (wire.nodes.back().position_m - wire.nodes.front().position_m),
                            pixel));
        const double chord_mm =
            path[static_cast<std::size_t>(pixel.y()) * 512 + static_cast<std::size_t>(pixel.x())] / 1024.0;
        thinnest_mm = std::min(thinnest_mm, chord_mm);
        thickest_mm = std::max(thickest_mm, chord_mm);
    }
    std::printf("# between %.3f and %.3f mm, diameter 0.9\n", thinnest_mm, thickest_mm);
    // The mean path length is taken over a pixel (0.45 mm), whose centre may lie 0.3 mm beside the axis. The
    // mean path length is therefore at least 0.60 mm, and a gap between two pieces would make it smaller.
    assert_true(thinnest_mm > 0.60 && thickest_mm < 0.91);
}

static void cramped_or_broken_wire_frames_do_no_harm(void **)
{
    WireFrame wire = bent_wire();
    wire.nodes[3].position_m = wire.nodes[2].position_m;
    wire.nodes[7].position_m.x() = std::nan("");
    wire.nodes[5].position_m =
        wire.nodes[4].position_m + (wire.nodes[3].position_m - wire.nodes[4].position_m);
    render(chest_like(), oblique_settings(), wire);
    wire.nodes.resize(1);
    render(chest_like(), oblique_settings(), wire);
    WireFrame through_source = bent_wire();
    for (WireNode &node : through_source.nodes) node.position_m.z() -= 0.75;
    render(chest_like(), XraySettings{}, through_source);
}

// In DICOM, a positive LAO angle moves structures behind the isocentre, such as the spine, to the right of
// the picture.
static void carm_angles_have_the_signs_of_dicom(void **)
{
    CArm carm;
    Eigen::Vector2d at;
    assert_true(project(make_view(carm, 512), {0.05, 0.0, 0.0}, at));
    assert_true(at.x() > 256.0); // patient left is on the right
    assert_true(project(make_view(carm, 512), {0.0, 0.05, 0.0}, at));
    assert_true(at.y() < 256.0); // head up
    carm.primary_deg = 40.0;
    const View lao = make_view(carm, 512);
    assert_true(lao.forward.x() > 0.0); // the detector goes to the patient's left
    assert_true(project(lao, {0.0, 0.0, -0.05}, at));
    assert_true(at.x() > 256.0);
    carm.primary_deg = 0.0;
    carm.secondary_deg = 30.0;
    const View cranial = make_view(carm, 512);
    assert_true(cranial.forward.y() > 0.0); // the detector goes to the head
    assert_true(std::fabs(cranial.forward.y() - 0.5) < 1e-12);
    assert_true(std::fabs(cranial.forward.z() - std::sqrt(0.75)) < 1e-12);
}

static void metal_and_bone_are_dark_and_lung_is_bright(void **)
{
    XraySettings settings;
    settings.beam.noise = false;
    const XrayPicture with = render(chest_like(), settings, bent_wire())->picture;
    const XrayPicture without = render(chest_like(), settings)->picture;
    const View view = make_view(settings.carm, 512);
    auto grey_at = [&](const XrayPicture &picture, const Eigen::Vector3d &point) {
        Eigen::Vector2d at;
        assert_true(project(view, point, at));
        return static_cast<int>(
            picture.grey[static_cast<std::size_t>(at.y()) * 512 + static_cast<std::size_t>(at.x())]);
    };
    assert_true(grey_at(without, {0, 0, -0.045}) + 20 < grey_at(without, {-0.045, 0, 0}));
    assert_true(grey_at(without, {0.05, 0.01, 0}) > grey_at(without, {-0.05, 0.01, 0}) + 20);
    const Eigen::Vector3d on_wire = bent_wire().nodes[20].position_m;
    assert_true(grey_at(with, on_wire) + 15 < grey_at(without, on_wire));
    assert_int_equal(with.grey[0], 0); // collimator
    assert_int_equal(with.photons[0], 0);
}

static void unknown_material_and_bad_meshes_are_refused_by_name(void **)
{
    XrayScene scene;
    std::string error;
    Bodies bodies{{box_body("rib 4", "unobtainium", -1, {0, 0, 0}, {0.1, 0.1, 0.1})}};
    assert_false(scene.set_bodies(bodies, error));
    assert_true(error.find("rib 4") != error.npos && error.find("unobtainium") != error.npos);
    assert_true(error.find("bone_cortical") != error.npos);
    bodies.bodies[0].material = "bone";
    bodies.bodies[0].parent = 3;
    assert_false(scene.set_bodies(bodies, error));
    assert_true(error.find("parent 3") != error.npos);
    bodies.bodies[0].parent = 0;
    assert_false(scene.set_bodies(bodies, error));
    assert_true(error.find("circle") != error.npos);
    bodies.bodies[0].parent = -1;
    bodies.bodies[0].triangles[2][1] = 8;
    assert_false(scene.set_bodies(bodies, error));
    assert_true(error.find("triangle 2") != error.npos);
    bodies.bodies[0].triangles[2][1] = 7;
    bodies.bodies[0].vertices_um[1].x() = 3'000'000;
    assert_false(scene.set_bodies(bodies, error));
    assert_true(error.find("vertex 1") != error.npos);
    assert_int_equal(scene.triangle_count(), 0);
}

int main()
{
    cmocka_set_message_output(CM_OUTPUT_TAP);
    const CMUnitTest tests[] = {
        cmocka_unit_test(sphere_path_is_the_chord),
        cmocka_unit_test(box_path_is_the_chord),
        cmocka_unit_test(nested_body_is_taken_out_of_its_parent),
        cmocka_unit_test(source_inside_a_body_sees_the_way_out),
        cmocka_unit_test(picture_is_the_same_for_any_number_of_threads),
        cmocka_unit_test(picture_of_contrast_medium_is_the_same_for_any_number_of_threads),
        cmocka_unit_test(kept_view_gives_the_same_picture_as_a_new_one),
        cmocka_unit_test(breath_gives_the_picture_of_a_new_renderer_with_tools_and_medium),
        cmocka_unit_test(tube_has_the_volume_of_its_wire),
        cmocka_unit_test(tube_is_unbroken_and_as_thick_as_the_wire),
        cmocka_unit_test(cramped_or_broken_wire_frames_do_no_harm),
        cmocka_unit_test(carm_angles_have_the_signs_of_dicom),
        cmocka_unit_test(metal_and_bone_are_dark_and_lung_is_bright),
        cmocka_unit_test(unknown_material_and_bad_meshes_are_refused_by_name),
    };
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
