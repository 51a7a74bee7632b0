// These tests check the following. The reference solutions of the validation suite are correct; the tests do
// not use the core. The solutions reproduce published values for the elastica, Euler's columns, Greenhill's
// twisted rod and the localised coil. The lumen field that the suite makes for a case has its wall where the
// distance function is zero. The report states which rows (comparisons) passed.
extern "C" {
#include "firmware/core/lumen.h"
}
#include "tools/lab/validate/elastica.hpp"
#include "tools/lab/validate/lumen_field.hpp"
#include "tools/lab/validate/report.hpp"
#include <cmath>
#include <csetjmp>
#include <cstdarg>
#include <cstddef>
#include <cstdint>
#include <cstring>
extern "C" {
#include <cmocka.h>
}

namespace
{

using namespace crn::validate;

void check_near(const char *what, double value, double expected, double allowed)
{
    if (!(std::fabs(value - expected) <= allowed)) {
        fail_msg("%s = %.9g, expected %.9g (allowed %g)", what, value, expected, allowed);
    }
}

struct Known {
    double load, shortening, deflection, angle;
};

// The expected values come from Bisshopp and Drucker's table of the tip-loaded elastica, to the sixth digit.
void tip_loaded_elastica_has_the_published_values(void **)
{
    for (Known k : {Known{0.5, .015919, .162144, .244534},
                    {1, .056433, .301721, .461352},
                    {2, .160642, .493457, .781750},
                    {4, .328941, .669964, 1.121239},
                    {5, .387628, .713792, 1.215368},
                    {10, .554996, .810609, 1.430286}}) {
        PlaneShape shape = elastica(k.load, 0);
        check_near("(L - x) / L", 1 - shape.x.back(), k.shortening, 1e-6);
        check_near("y / L", -shape.y.back(), k.deflection, 1e-6);
        check_near("angle", -shape.angle.back(), k.angle, 1e-6);
    }
}

void heavy_elastica_has_the_published_values(void **)
{
    for (Known k : {Known{1, .008754, .123471, .165116},
                    {5, .153343, .495905, .697005},
                    {50, .754985, .907917, 1.526453}}) {
        PlaneShape shape = elastica(0, k.load);
        check_near("(L - x) / L", 1 - shape.x.back(), k.shortening, 1e-6);
        check_near("y / L", -shape.y.back(), k.deflection, 1e-6);
        check_near("angle", -shape.angle.back(), k.angle, 1e-6);
    }
}

// The expected values come from Timoshenko and Gere, table 2-4. At a load of 1.152 times the critical load
// Pcr, the angle alpha of the tip is 60 degrees, and the tip's coordinates relative to the length L are x / L
// = 0.741 and y / L = 0.593. At a load of 1.884 times the critical load Pcr, the angle alpha of the tip is
// 120 degrees.
void buckled_cantilever_has_the_published_values(void **)
{
    const double euler = M_PI * M_PI / 4;
    Buckled shape = buckled_cantilever(1.152 * euler);
    check_near("x / L", shape.x, 0.741, 2e-3);
    check_near("y / L", shape.y, 0.593, 2e-3);
    check_near("alpha", shape.angle * 180 / M_PI, 60, 0.2);
    check_near("alpha", buckled_cantilever(1.884 * euler).angle * 180 / M_PI, 120, 0.2);
}

void columns_have_the_published_loads(void **)
{
    check_near("K clamped-pinned", M_PI / euler_clamped_pinned(), 0.699156, 1e-6);
    check_near("u of a hinge", euler_spring_pinned(1e-9), M_PI, 1e-6);
    check_near("u of a stiff spring", euler_spring_pinned(1e9), euler_clamped_pinned(), 1e-6);
    check_near("u of two spans, second short", euler_two_spans(1, 1e-3), 2 * M_PI * (1 - 1.0 / 3000), 1e-4);
    check_near("Greenhill", greenhill(), 8.9868, 1e-4);
    check_near("beta 1", beam_mode(1), 1.875104, 1e-6);
    check_near("beta 2", beam_mode(2), 4.694091, 1e-6);
    check_near("beta 3", beam_mode(3), 7.854757, 1e-6);
}

// PyElastica's example of Gazzola et al. 2018 states the moment and tension of a coiled rod for an end
// rotation of 27 turns, a slack of 3 %, and a ratio B / C of bending to torsional stiffness of 1.345 / 0.789.
void coil_has_the_published_moment_and_tension(void **)
{
    Writhe coil = writhe(0.03, 27 * 2 * M_PI, 1.345 / 0.789);
    check_near("moment", coil.moment, 98.541496171, 1e-6);
    check_near("tension", coil.tension, 2900.993205792, 1e-4);
}

// Along a bent tube, the wall of the field lies within 0.03 mm of the exact wall, and its normals are within
// 2 degrees of the exact inward direction.
void field_lies_where_its_distance_says(void **)
{
    Path path({0, 0, 0}, {1, 0, 0}, {0, 0, 1});
    path.straight(0.03).bend(0.04, M_PI / 2).roll(1).straight(0.03);
    check_near("length", path.length(), 0.06 + 0.02 * M_PI, 1e-12);
    const double radius = 0.003;
    LumenField field = tube_field(path, radius, 1);
    for (double s = 0.005; s < path.length() - 0.005; s += 0.00037) {
        Vector3d centre = path.at(s), ahead = (path.at(s + 1e-6) - centre).normalized();
        Vector3d side = ahead.cross(Vector3d(0.3, 0.8, -0.5)).normalized();
        Vector3d across = std::cos(40 * s) * side + std::sin(40 * s) * ahead.cross(side);
        for (double at : {0.7, 0.9, 1.0, 1.1}) {
            Vector3d p = centre + at * radius * across;
            crn_vec3 fixed = crn_vec3_make(std::int32_t(std::lround(p[0] * (1 << 30))),
                                           std::int32_t(std::lround(p[1] * (1 << 30))),
                                           std::int32_t(std::lround(p[2] * (1 << 30))));
            crn_lumen_sample sample = crn_lumen_contact(field.lumen(), &fixed);
            check_near("distance (m)", sample.distance_m_q30 / double(1 << 30), (at - 1) * radius, 3e-5);
            Vector3d normal =
                Vector3d(sample.normal_q30.v[0], sample.normal_q30.v[1], sample.normal_q30.v[2]) / (1 << 30);
            check_near("cos of the normal's error", normal.dot(-across), 1, 6e-4);
        }
    }
}

// Rows pass within their tolerance. A row of the report fails if its error exceeds the tolerance or its value
// is not a number. A row that is only reported never fails.
void report_says_what_passed(void **)
{
    Result good, bad;
    good.name = good.title = "good";
    bad.name = bad.title = "bad";
    good.relative("a", "N", 100, 100.9, 1);
    good.reported("b", "N", 1, 5);
    bad.absolute("c", "mm", 2, 2.2, 0.1);
    bad.relative("d", "N", 0, 0, 1);
    assert_true(good.passed());
    assert_false(bad.passed());
    assert_false(bad.rows[1].passed());
    assert_false(Result{}.passed());
    std::string table = tsv({good, bad});
    assert_non_null(std::strstr(table.c_str(), "good.a\t"));
    assert_non_null(std::strstr(table.c_str(), "\treported\n"));
    assert_non_null(std::strstr(table.c_str(), "\tFAIL\n"));
    std::string lines = tap({good, bad});
    assert_true(lines.rfind("1..2\nok 1 - ", 0) == 0);
    assert_non_null(std::strstr(lines.c_str(), "not ok 2 - "));
    std::string page = html({good, bad}, "make <it>");
    assert_non_null(std::strstr(page.c_str(), "make &lt;it&gt;"));
}

// A plot draws only finite values, and shows the names of its series.
void plot_leaves_out_what_is_not_finite(void **)
{
    std::string drawn =
        svg({"t", "x", "y", {{"one & two", {0, 1, 2}, {0, NAN, 4}, true}, {"", {0, 2}, {1, INFINITY}}}});
    std::size_t dots = 0;
    for (std::size_t at = drawn.find("r='3'"); at != std::string::npos; at = drawn.find("r='3'", at + 1))
        dots++;
    assert_int_equal(dots, 3); /* two values and the legend */
    assert_non_null(std::strstr(drawn.c_str(), "one &amp; two"));
    assert_null(std::strstr(drawn.c_str(), "nan"));
    assert_null(std::strstr(drawn.c_str(), "inf"));
}

} // namespace

int main()
{
    const CMUnitTest tests[] = {
        cmocka_unit_test(tip_loaded_elastica_has_the_published_values),
        cmocka_unit_test(heavy_elastica_has_the_published_values),
        cmocka_unit_test(buckled_cantilever_has_the_published_values),
        cmocka_unit_test(columns_have_the_published_loads),
        cmocka_unit_test(coil_has_the_published_moment_and_tension),
        cmocka_unit_test(field_lies_where_its_distance_says),
        cmocka_unit_test(report_says_what_passed),
        cmocka_unit_test(plot_leaves_out_what_is_not_finite),
    };
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
