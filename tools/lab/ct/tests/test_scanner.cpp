// These tests check the following. Scans by the virtual scanner have the noise, blur and Hounsfield units
// that the scanner's settings state. The tests check the Hounsfield units of fluid, wall and gel at their
// positions, the noise and point spread, and the position of the instrument. A given seed gives equal volumes
// for any number of threads. The reference values come from closed forms, such as areas of circles and
// moments of Gaussians.
#include "tools/lab/ct/tests/tube_phantom.hpp"

#include <algorithm>
#include <csetjmp>
#include <cstdarg>
#include <cstddef>
#include <cstdint>
#include <cstdio>

// The header cmocka.h comes last, because its macros (fail, ...) would change other headers.
extern "C" {
#include <cmocka.h>
}

using namespace crn::ct;
using namespace crn::tests;
using Eigen::Vector3d;

namespace
{

constexpr double radius_mm = 8;

// Returns the mean and standard deviation of the voxels between two distances from the axis.
struct Ring {
    double mean = 0, deviation = 0;
};
Ring ring(const Volume &volume, double low_mm, double high_mm)
{
    double sum = 0, squares = 0, count = 0;
    for (int k = 0; k < volume.size[2]; ++k)
        for (int j = 0; j < volume.size[1]; ++j)
            for (int i = 0; i < volume.size[0]; ++i) {
                const Vector3d p = volume.scene({double(i), double(j), double(k)});
                const double away = std::hypot(p.x(), p.z());
                if (away < low_mm || away > high_mm) continue;
                const double value = static_cast<double>(volume.hu[volume.at(i, j, k)]);
                sum += value;
                squares += value * value;
                ++count;
            }
    return {sum / count, std::sqrt(std::max(0.0, squares / count - sum * sum / count / count))};
}

void fluid_wall_and_gel_have_their_hounsfield_units(void **)
{
    ScannerSettings settings = quick_scanner(16, -2, 2);
    settings.noise_HU = 0;
    PhantomMaterials phantom;
    phantom.wall_mm = 4;
    const Volume volume = simulate_scan(tube_mesh(radius_mm, -30, 30), phantom, {}, settings, no_report);
    const double fluid = ring(volume, 0, 6.5).mean, wall = ring(volume, 9.5, 10.5).mean,
                 gel = ring(volume, 13.5, 15.5).mean;
    std::printf("#- fluid %.1f HU (80 meant), silicone %.1f (230), gel %.1f (20)\n", fluid, wall, gel);
    assert_true(std::abs(fluid - 80) < 2 && std::abs(wall - 230) < 4 && std::abs(gel - 20) < 2);
}

// At the lumen's edge, the picture has the value half-way between fluid and wall; the area inside this edge
// gives the lumen's radius.
void the_lumen_has_its_area_at_half_height(void **)
{
    ScannerSettings settings = quick_scanner(16, -1, 1);
    settings.noise_HU = 0;
    PhantomMaterials phantom;
    phantom.wall_mm = 4;
    const Volume volume = simulate_scan(tube_mesh(radius_mm, -30, 30), phantom, {}, settings, no_report);
    double area = 0;
    for (int j = 0; j < volume.size[1]; ++j)
        for (int i = 0; i < volume.size[0]; ++i) {
            const Vector3d p = volume.scene({double(i), double(j), 0});
            if (std::hypot(p.x(), p.z()) > radius_mm + 2) continue;
            const double share = (230 - static_cast<double>(volume.hu[volume.at(i, j, 0)])) / 150;
            area += std::clamp(share, -0.2, 1.2) * volume.spacing_mm.x() * volume.spacing_mm.y();
        }
    const double found = std::sqrt(area / M_PI);
    std::printf("#- radius by area %.3f mm, made %.3f mm\n", found, radius_mm);
    assert_true(std::abs(found - radius_mm) < 0.04);
}

void the_noise_is_the_one_that_was_asked_for(void **)
{
    const Volume volume =
        simulate_scan(tube_mesh(radius_mm, -30, 30), {}, {}, quick_scanner(16, -5, 5), no_report);
    const double deviation = ring(volume, 0, 5).deviation;
    std::printf("#- noise %.1f HU, asked for 15\n", deviation);
    assert_true(std::abs(deviation - 15) < 2.5);
}

// A thin plastic thread along the scanner's axis appears as a point in each slice. The second moments of the
// thread's image are the moments of the point spread plus r^2 / 4, the moments of the thread's cross-section
// of radius r.
void a_thread_is_blurred_as_stated(void **)
{
    ScannerSettings settings = quick_scanner(10, -1, 1);
    settings.noise_HU = 0;
    settings.spacing_mm = {0.2, 0.2, 1};
    settings.blur_mm = 0.5;
    const ScanInstrument thread{{{1.2, -9, -0.7}, {1.2, 9, -0.7}}, plain_stretch(0.15, 0, "polymer_barium")};
    const Volume volume = simulate_scan(tube_mesh(radius_mm, -30, 30), {}, {thread}, settings, no_report);
    double sum = 0, x = 0, z = 0, square = 0;
    for (int pass = 0; pass < 2; ++pass)
        for (int j = 0; j < volume.size[1]; ++j)
            for (int i = 0; i < volume.size[0]; ++i) {
                const Vector3d p = volume.scene({double(i), double(j), 0});
                if (std::hypot(p.x() - 1.2, p.z() + 0.7) > 1.6) continue;
                const double mass = static_cast<double>(volume.hu[volume.at(i, j, 0)]) - 80;
                if (pass == 0) {
                    sum += mass;
                    x += mass * p.x();
                    z += mass * p.z();
                } else {
                    square += mass *
                              ((p.x() - x / sum) * (p.x() - x / sum) + (p.z() - z / sum) * (p.z() - z / sum));
                }
            }
    const double sigma = std::sqrt(square / sum / 2), expected = std::sqrt(0.25 + 0.15 * 0.15 / 4);
    std::printf("#- thread at (%.3f, %.3f) mm, meant (1.2, -0.7); sigma %.3f mm, meant %.3f\n", x / sum,
                z / sum, sigma, expected);
    assert_true(std::hypot(x / sum - 1.2, z / sum + 0.7) < 0.02);
    assert_true(std::abs(sigma - expected) < 0.04);
}

// Metal reaches the end of the grey scale, and the values around it deviate upwards and downwards by more
// than the noise does.
void steel_blooms_and_streaks(void **)
{
    const std::vector<Vector3d> line = {{-6, 0.2, 1}, {6, -0.2, 1}};
    const ScanInstrument wire{line, plain_stretch(0.4445, 0, "steel")};
    ScannerSettings settings = quick_scanner(16, -3, 3);
    const Volume volume = simulate_scan(tube_mesh(radius_mm, -30, 30), {}, {wire}, settings, no_report);
    double beside = 0;
    for (double x = -5; x <= 5; x += 0.5) beside += std::abs(volume.value(volume.voxel({x, 0, 3})) - 80) / 21;
    const double inside = *std::max_element(volume.hu.begin(), volume.hu.end());
    std::printf("#- brightest %.0f HU, 2 mm beside the wire off by %.0f HU on average (noise 15)\n", inside,
                beside);
    assert_true(inside == settings.highest_HU);
    assert_true(beside > 20);
}

void threads_do_not_change_a_scan_and_the_seed_does(void **)
{
    ScannerSettings settings = quick_scanner(12, -2, 2);
    settings.views = 120;
    const auto scan = [&](int threads, std::uint64_t seed) {
        settings.threads = threads;
        settings.seed = seed;
        return simulate_scan(tube_mesh(5, -30, 30), {}, {}, settings, no_report).hu;
    };
    const std::vector<float> one = scan(1, 7);
    assert_true(one == scan(3, 7));
    assert_true(one != scan(1, 8));
}

} // namespace

int main()
{
    const CMUnitTest tests[] = {
        cmocka_unit_test(fluid_wall_and_gel_have_their_hounsfield_units),
        cmocka_unit_test(the_lumen_has_its_area_at_half_height),
        cmocka_unit_test(the_noise_is_the_one_that_was_asked_for),
        cmocka_unit_test(a_thread_is_blurred_as_stated),
        cmocka_unit_test(steel_blooms_and_streaks),
        cmocka_unit_test(threads_do_not_change_a_scan_and_the_seed_does),
    };
    cmocka_set_message_output(CM_OUTPUT_TAP);
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
