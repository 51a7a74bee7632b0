// Tests the path lengths of rays in tools and curves: in walls, cores, bands, struts and contrast medium.
// Other tests check which material the tools and curves displace.
#include "host/xray/paths/tube.hpp"
#include "host/xray/tests/xray_shapes.hpp"
#include "host/xray/xray.hpp"
#include <cmath>
#include <csetjmp>
#include <cstdarg>
#include <cstddef>
#include <cstdio>
#include <limits>
#include <numbers>
#include <random>
extern "C" {
#include <cmocka.h>
}

using namespace crn;
using Eigen::Vector3d;

namespace
{

using std::numbers::pi;

CArm zoomed(double field_m)
{
    CArm carm;
    carm.field_m = field_m;
    return carm;
}

ToolPaths tubes(const XrayFrame &frame, const View &view)
{
    ToolPaths paths;
    draw_tubes(frame, view, Material::blood, paths);
    return paths;
}

// Returns the mean path length over the rays of a pixel, in mm.
double length_mm(const ToolPaths &paths, Material material, int x, int y)
{
    for (std::size_t slot = 0; slot < paths.materials.size(); ++slot)
        if (paths.materials[slot] == material)
            return paths.sum(y * paths.size + x, slot) / 1024.0 / tool_rays;
    return 0.0;
}

// Returns the volume of a material: the sum over all pixels of path length times cross-section of the beam at
// the depth of the isocentre.
double volume_mm3(const ToolPaths &paths, const View &view, Material material)
{
    const double pixel_mm = view.pixel_m * 1e3 * view.source_isocentre_m / view.source_detector_m;
    double sum = 0.0;
    for (std::int32_t pixel : paths.pixels) {
        const int x = pixel % paths.size, y = pixel / paths.size;
        // In the plane of the isocentre, the beams of all pixels have the same cross-section; the beam of a
        // pixel beside the axis crosses this plane at an angle.
        const double dx = (x + 0.5 - view.size * 0.5) * view.pixel_m,
                     dy = (y + 0.5 - view.size * 0.5) * view.pixel_m;
        const double slant = std::sqrt(dx * dx + dy * dy + view.source_detector_m * view.source_detector_m);
        sum += length_mm(paths, material, x, y) * view.source_detector_m / slant;
    }
    return sum * pixel_mm * pixel_mm;
}

WireFrame straight_wire(double radius_m, double contrast_mg_per_ml = 0.0)
{
    WireFrame wire;
    for (int i = 0; i < 30; ++i) {
        WireNode node;
        node.position_m = {-0.03 + 0.002 * i, 0.0, 0.0};
        node.arc_m = 0.002 * i;
        node.radius_m = radius_m;
        node.contrast_mg_per_ml = contrast_mg_per_ml;
        wire.nodes.push_back(node);
    }
    return wire;
}

} // namespace

// The ray through the middle of a catheter crosses the catheter's wall twice. The wall of this catheter
// consists of polymer and braid, and a marker band lies around it.
static void catheter_wall_braid_and_marker_band_have_their_thickness(void **)
{
    const RadiopaqueInstrument catheter{{{0.0, 1.0, Material::polymer, 0.8, 1.0, 0.70},
                                         {0.0, 1.0, Material::steel, 0.2, 1.0, 0.70},
                                         {0.01, 0.02, Material::platinum, 1.0, 1.2, 1.0}},
                                        {{0.0, 0.001, 0.0007}, {1.0, 0.001, 0.0007}}};
    const std::vector<RadiopaqueInstrument> tools = {catheter};
    const WireFrame wire = straight_wire(0.001);
    const View view = make_view(zoomed(0.10), 1024); // 0.07 mm per pixel at the isocentre
    const ToolPaths paths = tubes({tools, wire}, view);
    auto at = [&](double x_m, Material material) {
        Eigen::Vector2d pixel;
        assert_true(project(view, {x_m, 0.00001, 0.0}, pixel));
        return length_mm(paths, material, static_cast<int>(pixel.x()), static_cast<int>(pixel.y()));
    };
    const double polymer = at(-0.025, Material::polymer), steel = at(-0.025, Material::steel);
    const double band = at(-0.015, Material::platinum), no_band = at(-0.025, Material::platinum);
    std::printf("# polymer %.4f, steel %.4f, platinum band %.4f mm\n", polymer, steel, band);
    assert_true(std::fabs(polymer - 0.8 * 0.6) < 0.003); // twice 0.3 mm of wall
    assert_true(std::fabs(steel - 0.2 * 0.6) < 0.003);
    assert_true(std::fabs(band - 0.4) < 0.003);
    assert_true(no_band == 0.0);
    assert_true(std::fabs(at(-0.025, Material::blood) + 0.6) <
                0.004); // displaced by the wall; the lumen stays
}

// The expected amount is the volume of a cone of length h with the radii a and b, pi h (a^2 + a b + b^2)/3,
// times the mean fraction of contrast medium between positions s and t along the cone. The mean fraction is
// exact for pieces of 0.5 mm.
static void contrast_column_holds_the_iodine_of_its_cone(void **)
{
    for (double thickest_m : {0.0005, 0.002, 0.012}) {
        SweptCurve column{Material::iohexol_350, {}};
        double expected_mm3 = 0.0;
        for (int i = 0; i <= 100; ++i) {
            const double s = i / 100.0;
            column.points.push_back({{-0.025 + 0.05 * s, 0.01 * s, 0.0},
                                     thickest_m * (0.4 + 0.6 * s),
                                     contrast_share(350.0 * (0.9 - 0.7 * s))});
        }
        for (int i = 0; i < 10000; ++i) {
            const double s = (i + 0.5) / 10000.0, radius_mm = 1e3 * thickest_m * (0.4 + 0.6 * s);
            expected_mm3 += pi * radius_mm * radius_mm * (0.9 - 0.7 * s) * std::hypot(50.0, 10.0) / 10000.0;
        }
        const std::vector<SweptCurve> curves = {column};
        const WireFrame wire;
        const View view = make_view(zoomed(0.20), 512);
        const ToolPaths paths = tubes({{}, wire, curves}, view);
        const double iodine = volume_mm3(paths, view, Material::iohexol_350);
        std::printf("# radius to %.1f mm: %.3f mm3 of iohexol, expected %.3f, displaced %.3f\n",
                    thickest_m * 1e3, iodine, expected_mm3, volume_mm3(paths, view, Material::blood));
        // The tolerance of the amount is 0.5 %, because parts up to 12 mm in front of and behind the
        // isocentre are magnified differently; this effect is of second order.
        assert_true(std::fabs(iodine - expected_mm3) < 0.005 * expected_mm3);
        assert_true(std::fabs(iodine + volume_mm3(paths, view, Material::blood)) < 1e-6 * expected_mm3);
    }
}

// Returns the length in mm of a ray in the cylinder of radius r about the line from a to b, which is cut
// perpendicular to its axis. The ray and the cylinder are in patient axes; the reference is computed in
// double precision from the quadratic equation of the cylinder and from its two ends.
static double chord_mm(const View &view, int x, int y, const Vector3d &a, const Vector3d &b, double radius_m)
{
    const double half = 0.5 * view.size;
    const Vector3d ray = (view.right * ((x + 0.5 - half) * view.pixel_m) +
                          view.up * ((half - y - 0.5) * view.pixel_m) + view.forward * view.source_detector_m)
                             .normalized();
    const Vector3d axis = (b - a).normalized(), from = view.source_m - a;
    const Vector3d across = ray - axis * ray.dot(axis), beside = from - axis * from.dot(axis);
    const double square = across.squaredNorm(), half_b = across.dot(beside);
    const double inside = half_b * half_b - square * (beside.squaredNorm() - radius_m * radius_m);
    if (inside <= 0.0) return 0.0;
    const double end_a = -from.dot(axis) / ray.dot(axis),
                 end_b = ((b - a).norm() - from.dot(axis)) / ray.dot(axis);
    const double enter = std::max((-half_b - std::sqrt(inside)) / square, std::min(end_a, end_b));
    const double leave = std::min((-half_b + std::sqrt(inside)) / square, std::max(end_a, end_b));
    return std::max(leave - enter, 0.0) * 1e3;
}

// Short and long cylinders in any direction, some of them beyond the edge of the picture: each ray through
// the middle of a pixel must have the length of the reference. The painter may leave out only rays that miss
// the cylinder.
static void wide_cylinders_of_any_direction_have_exact_chords(void **)
{
    std::mt19937 random(1);
    auto within = [&](double low, double high) { return low + (high - low) * random() / 4294967295.0; };
    auto anywhere = [&](double reach) {
        return Vector3d(within(-reach, reach), within(-reach, reach), within(-reach, reach));
    };
    const WireFrame wire;
    const View view = make_view(zoomed(0.20), 128);
    double worst_mm = 0.0;
    for (int turn = 0; turn < 200; ++turn) {
        const double radius_m = within(0.009, 0.02);
        const Vector3d a = anywhere(0.08), b = a + anywhere(1.0).normalized() * within(0.0005, 0.03);
        const std::vector<SweptCurve> curves = {{Material::iohexol_350, {{a, radius_m}, {b, radius_m}}}};
        const ToolPaths paths = tubes({{}, wire, curves}, view);
        for (int y = 0; y < view.size; ++y)
            for (int x = 0; x < view.size; ++x)
                worst_mm = std::max(worst_mm, std::fabs(length_mm(paths, Material::iohexol_350, x, y) -
                                                        chord_mm(view, x, y, a, b, radius_m)));
    }
    std::printf("# largest error %.4f mm\n", worst_mm);
    assert_true(worst_mm < 0.002); // lengths are whole 1/1024 mm
}

// A strut of 40 um must lose no metal where rays are 0.14 mm apart, wherever the strut lies between the rays.
static void struts_thinner_than_the_rays_are_apart_lose_nothing(void **)
{
    const WireFrame wire;
    const View view = make_view(zoomed(0.30), 512);
    for (int place = 0; place < 8; ++place) {
        const double shift_m = place * 0.00005;
        const std::vector<SweptCurve> curves = {
            {Material::steel, {{{-0.02, shift_m, 0.0}, 2e-5}, {{0.02, 0.011 + shift_m, 0.0}, 2e-5}}}};
        const ToolPaths paths = tubes({{}, wire, curves}, view);
        const double metal = volume_mm3(paths, view, Material::steel);
        const double expected = pi * 0.02 * 0.02 * std::hypot(40.0, 11.0);
        std::printf("# %.5f mm3, expected %.5f\n", metal, expected);
        assert_true(std::fabs(metal - expected) < 0.02 * expected); // lengths are whole 1/1024 mm
    }
}

// A guidewire in contrast medium displaces the medium: the amount of iodine must be smaller, and blood must
// be subtracted for the remaining displaced volume.
static void wire_in_contrast_displaces_iodine_and_blood(void **)
{
    const std::vector<RadiopaqueInstrument> tools = {{{{0.0, 1.0, Material::nitinol, 1.0, 1.0}}, {}}};
    const WireFrame wire = straight_wire(0.0005, 0.3 * 350.0);
    const View view = make_view(zoomed(0.10), 512);
    const ToolPaths paths = tubes({tools, wire}, view);
    const double metal = volume_mm3(paths, view, Material::nitinol);
    const double iodine = volume_mm3(paths, view, Material::iohexol_350),
                 blood = volume_mm3(paths, view, Material::blood);
    std::printf("# metal %.4f, iohexol %.4f, blood %.4f mm3\n", metal, iodine, blood);
    assert_true(std::fabs(iodine + 0.3 * metal) < 0.01 * metal);
    assert_true(std::fabs(blood + 0.7 * metal) < 0.01 * metal);
}

// The picture of 400 struts of 12 pieces must equal the sum of the pictures of single struts.
static void many_curves_add_up(void **)
{
    std::vector<SweptCurve> curves;
    for (int k = 0; k < 400; ++k) {
        SweptCurve curve{Material::steel, {}};
        for (int i = 0; i <= 12; ++i) {
            const double angle = 0.5 * i + k, along = 0.00015 * k;
            curve.points.push_back(
                {{0.0015 * std::cos(angle), along - 0.03, 0.0015 * std::sin(angle)}, 4e-5});
        }
        curves.push_back(curve);
    }
    const WireFrame wire;
    const View view = make_view(zoomed(0.15), 512);
    const ToolPaths together = tubes({{}, wire, curves}, view);
    std::vector<double> sums(512 * 512, 0.0);
    for (const SweptCurve &curve : curves) {
        const std::vector<SweptCurve> one = {curve};
        const ToolPaths paths = tubes({{}, wire, one}, view);
        for (std::int32_t pixel : paths.pixels)
            sums[pixel] += length_mm(paths, Material::steel, pixel % 512, pixel / 512);
    }
    for (int pixel = 0; pixel < 512 * 512; ++pixel)
        assert_true(std::fabs(sums[pixel] - length_mm(together, Material::steel, pixel % 512, pixel / 512)) <
                    1e-6);
}

// A line of a small vessel and a soft ball near the isocentre hold as much medium as the vessel and the ball:
// pi r^2 times length, and 5 pi^2 / 64 R^3, each times the share. Lengths in a plane through the isocentre; 1
// % is the depth of the ball.
static void small_vessels_and_soft_balls_hold_their_medium(void **)
{
    const WireFrame wire;
    const View view = make_view(zoomed(0.15), 512);
    const double pixel_mm = view.pixel_m * 1e3 * view.source_isocentre_m / view.source_detector_m;
    const auto held_mm3 = [&](const SweptCurve &curve) {
        const std::vector<SweptCurve> one = {curve};
        const ToolPaths paths = tubes({{}, wire, one}, view);
        assert_true(paths.pixels.empty());
        double sum = 0.0;
        for (float length_mm : paths.haze_mm) sum += static_cast<double>(length_mm);
        return sum * pixel_mm * pixel_mm;
    };
    SweptCurve vessel{
        Material::iohexol_350, {{{-0.01, 0, 0}, 2e-4, 0.5}, {{0.02, 0.01, 0}, 2e-4, 0.5}}, true};
    const double vessel_mm3 = pi * 0.2 * 0.2 * std::hypot(30.0, 10.0) * 0.5;
    const SweptCurve ball{Material::iohexol_350, {{{0.01, 0, 0}, 8e-3, 0.1}}};
    const double ball_mm3 = 5.0 * pi * pi / 64.0 * 8.0 * 8.0 * 8.0 * 0.1;
    std::printf("# vessel %.4f of %.4f mm3, ball %.3f of %.3f mm3\n", held_mm3(vessel), vessel_mm3,
                held_mm3(ball), ball_mm3);
    assert_true(std::fabs(held_mm3(vessel) - vessel_mm3) < 1e-3 * vessel_mm3);
    assert_true(std::fabs(held_mm3(ball) - ball_mm3) < 0.01 * ball_mm3);
}

// Returns the pixels whose rays meet a material of the frame, or whose sum of path lengths in iohexol is at
// least `sum_min`.
static std::vector<std::uint8_t> met_alone(const XrayFrame &frame, const View &view, std::int64_t sum_min)
{
    const ToolPaths paths = tubes(frame, view);
    std::vector<std::uint8_t> met(static_cast<std::size_t>(paths.size) * paths.size, 0);
    for (const std::int32_t pixel : paths.pixels)
        for (std::size_t slot = 1; slot < paths.materials.size(); ++slot) {
            const std::int64_t sum = paths.sum(pixel, slot);
            if (sum_min > 0 ? paths.materials[slot] == Material::iohexol_350 && sum >= sum_min : sum > 0)
                met[static_cast<std::size_t>(pixel)] = 1;
        }
    return met;
}

// A label image that is drawn in one pass must mark the same pixels as if each kind of object were drawn
// alone, and must not change the path lengths.
static void labels_are_those_of_each_kind_alone(void **)
{
    const RadiopaqueInstrument wire_look{{{0.0, 1.0, Material::nitinol, 1.0, 0.4}}, {}},
        tube_look{{{0.0, 1.0, Material::polymer, 0.5, 1.0, 0.6}}, {}};
    const std::vector<RadiopaqueInstrument> tools = {wire_look, tube_look};
    WireFrame wire = straight_wire(0.001, 100.0);
    wire.tip_arc_m = {0.0, 0.02};
    const std::vector<SweptCurve> curves = {
        {Material::steel, {{{-0.01, -0.01, 0.0}, 5e-5}, {{0.02, 0.012, 0.0}, 5e-5}}},
        {Material::iohexol_350, {{{-0.02, 0.004, 0.0}, 0.004, 0.02}, {{0.02, 0.0, 0.0}, 0.002, 0.1}}},
        {Material::iohexol_350, {{{0.0, -0.02, 0.0}, 0.003, 0.05}, {{0.0, 0.02, 0.0}, 0.003, 0.0}}}};
    constexpr std::int64_t sum_min = 32 * tool_rays;
    const View view = make_view(zoomed(0.10), 256);
    TubeLabels labels;
    labels.tool_bits = {1, 2};
    labels.curves = {{1, 16, 0}, {2, 8, sum_min}};
    ToolPaths paths;
    for (int again = 0; again < 2; ++again) // the second drawing finds the memory of the first
        draw_tubes({tools, wire, curves, {}, &labels}, view, Material::blood, paths);
    const std::span<const SweptCurve> all = curves;
    const std::vector<RadiopaqueInstrument> first = {wire_look, {}}, second = {{}, tube_look};
    const std::pair<std::uint8_t, std::vector<std::uint8_t>> alone[] = {
        {1, met_alone({first, wire}, view, 0)},
        {2, met_alone({second, wire}, view, 0)},
        {16, met_alone({{}, wire, all.first(1)}, view, 0)},
        {8, met_alone({{}, wire, all.last(2)}, view, sum_min)}};
    for (const auto &[bit, met] : alone) {
        std::size_t count = 0;
        for (std::size_t pixel = 0; pixel < met.size(); ++pixel) {
            assert_int_equal((labels.pixels[pixel] & bit) != 0, met[pixel]);
            count += met[pixel];
        }
        std::printf("# bit %d: %d pixels\n", bit, static_cast<int>(count));
        assert_true(count > 50);
    }
    const ToolPaths without = tubes({tools, wire, curves}, view);
    assert_true(paths.pixels == without.pixels && paths.wide_q10mm == without.wide_q10mm);
    assert_true(paths.narrow_entry == without.narrow_entry && paths.narrow_q10mm == without.narrow_q10mm);
}

// The tested curves have faults: some are not finite, have no length or only one point, lie behind or pass
// through the source, are seen end-on, or are bent back on themselves. Faulty curves must do no harm, and
// those parts of them that can be drawn must be drawn.
static void broken_and_awkward_curves_do_no_harm(void **)
{
    const double nan = std::numeric_limits<double>::quiet_NaN(),
                 infinite = std::numeric_limits<double>::infinity();
    const std::vector<SweptCurve> curves = {
        {Material::steel, {}},
        {Material::steel, {{{0, 0, 0}, 0.001}}},
        {Material::steel, {{{0, 0, 0}, 0.001}, {{0, 0, 0}, 0.001}}},
        {Material::steel, {{{0, nan, 0}, 0.001}, {{0, 0.01, 0}, 0.001}}},
        {Material::steel, {{{0, 0, 0}, infinite}, {{0, 0.01, 0}, 0.001}}},
        {Material::steel, {{{0, 0, 0}, -1.0}, {{0, 0.01, 0}, -1.0}}},
        {Material::steel, {{{0, 0, 0}, 0.001, nan}, {{0, 0.01, 0}, 0.001}}},
        {Material::steel, {{{0, 0, -0.8}, 0.001}, {{0, 0.01, -0.9}, 0.001}}},
        {Material::steel, {{{0, 0, -0.7}, 0.001}, {{0, 0.0, -0.9}, 0.001}}},
        {Material::steel, {{{1e6, 1e6, 1e6}, 1e5}, {{-1e6, 1e6, 1e6}, 1e5}}},
        {Material::gold,
         {{{0.01, 0.01, 0.0}, 0.001}, {{0.02, 0.01, 0.0}, 0.001}, {{0.01, 0.01, 0.0}, 0.001}}},
        {Material::polymer, {{{0, 0, -0.02}, 0.001}, {{0, 0, 0.02}, 0.001}}}, // along the axis of the beam
    };
    const WireFrame wire;
    const View view = make_view(CArm(), 256);
    const ToolPaths paths = tubes({{}, wire, curves}, view);
    Eigen::Vector2d pixel;
    assert_true(project(view, {0.015, 0.01, 0.0}, pixel));
    assert_true(length_mm(paths, Material::gold, static_cast<int>(pixel.x()), static_cast<int>(pixel.y())) >
                1.5);
    const double end_on = length_mm(paths, Material::polymer, 128, 128);
    std::printf("# seen end on: %.3f mm\n", end_on);
    assert_true(end_on > 30.0 && end_on < 40.01);
    for (const std::int32_t drawn : paths.pixels)
        for (std::size_t slot = 1; slot < paths.materials.size(); ++slot)
            assert_in_range(paths.sum(drawn, slot), 0, 9ll * 1024 * 41);
}

// Struts and contrast medium must be visible in the picture: both are darker than the blood around them, and
// a curve of air leaves no trace.
static void curves_are_seen_in_the_picture(void **)
{
    XrayScene scene;
    std::string error;
    assert_true(scene.set_bodies({{box_body("chest", "soft_tissue", -1, {-0.1, -0.1, -0.1}, {0.1, 0.1, 0.1}),
                                   box_body("heart", "blood", 0, {-0.05, -0.05, -0.05}, {0.05, 0.05, 0.05})}},
                                 error));
    Xray xray(scene, 2);
    XraySettings settings;
    settings.beam.noise = false;
    const std::vector<SweptCurve> curves = {
        {Material::iohexol_350, {{{-0.02, 0.01, 0.0}, 0.0015, 0.8}, {{0.02, 0.01, 0.0}, 0.0015, 0.8}}},
        {Material::platinum, {{{-0.02, -0.01, 0.0}, 0.0001}, {{0.02, -0.01, 0.0}, 0.0001}}}};
    const WireFrame wire;
    XrayPicture with, without;
    xray.render(settings, {{}, wire, curves}, 1, nullptr, with);
    xray.render(settings, {{}, wire}, 1, nullptr, without);
    const View view = make_view(settings.carm, 512);
    for (double y_m : {0.01, -0.01}) {
        Eigen::Vector2d pixel;
        assert_true(project(view, {0.0, y_m, 0.0}, pixel));
        const std::size_t at =
            static_cast<std::size_t>(pixel.y()) * 512 + static_cast<std::size_t>(pixel.x());
        std::printf("# %d instead of %d quanta\n", static_cast<int>(with.photons[at]),
                    static_cast<int>(without.photons[at]));
        assert_true(with.photons[at] < 0.9 * without.photons[at]);
    }
}

int main()
{
    cmocka_set_message_output(CM_OUTPUT_TAP);
    const CMUnitTest tests[] = {
        cmocka_unit_test(catheter_wall_braid_and_marker_band_have_their_thickness),
        cmocka_unit_test(contrast_column_holds_the_iodine_of_its_cone),
        cmocka_unit_test(wide_cylinders_of_any_direction_have_exact_chords),
        cmocka_unit_test(struts_thinner_than_the_rays_are_apart_lose_nothing),
        cmocka_unit_test(wire_in_contrast_displaces_iodine_and_blood),
        cmocka_unit_test(many_curves_add_up),
        cmocka_unit_test(small_vessels_and_soft_balls_hold_their_medium),
        cmocka_unit_test(labels_are_those_of_each_kind_alone),
        cmocka_unit_test(broken_and_awkward_curves_do_no_harm),
        cmocka_unit_test(curves_are_seen_in_the_picture),
    };
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
