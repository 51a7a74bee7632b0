// These tests check the following. Points of the patient appear in the picture where the geometry of the
// C-arm projects them. Markers at known positions appear at the pixels that an independent calculation
// predicts, and on the side that DICOM prescribes. The C-arm's motors stay within their limits, and the C-arm
// does not collide with the table.
#include "firmware/tests/reference/long_run.h"
#include "host/room/command.hpp"
#include "host/room/gantry.hpp"
#include "host/room/presets.hpp"
#include "host/xray/tests/xray_shapes.hpp"
#include "host/xray/xray.hpp"
#include <algorithm>
#include <cmath>
#include <csetjmp>
#include <cstdarg>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <numbers>
#include <set>
extern "C" {
#include <cmocka.h>
}

using namespace crn;

namespace
{

constexpr double degree = std::numbers::pi / 180.0;

const Material marker_materials[8] = {Material::steel,    Material::nitinol, Material::platinum,
                                      Material::tungsten, Material::gold,    Material::bone_cortical,
                                      Material::lung,     Material::adipose};

Eigen::Vector3d corner_m(int i)
{
    return {i & 1 ? 0.04 : -0.04, i & 2 ? 0.05 : -0.05, i & 4 ? 0.03 : -0.03};
}

// Makes steel balls of 3 mm at the corners of a box of 80 x 100 x 60 mm. Each ball has a material name of its
// own, so that its path lengths appear in a picture of their own.
Bodies marker_cube(const Eigen::Vector3d &middle_m)
{
    static const char *names[8] = {"steel", "nitinol",       "platinum", "tungsten",
                                   "gold",  "bone_cortical", "lung",     "adipose"};
    Bodies bodies;
    for (int i = 0; i < 8; ++i)
        bodies.bodies.push_back(sphere_body(names[i], names[i], -1, middle_m + corner_m(i), 0.0015, 10));
    return bodies;
}

// Returns the centre of a marker's shadow, as a mean over pixels that is weighted by path length.
Eigen::Vector2d shadow(const std::vector<std::int32_t> &path, int size)
{
    Eigen::Vector2d sum = Eigen::Vector2d::Zero();
    double weight = 0.0;
    for (int y = 0; y < size; ++y)
        for (int x = 0; x < size; ++x) {
            const double w = path[static_cast<std::size_t>(y) * size + x];
            sum += w * Eigen::Vector2d(x + 0.5, y + 0.5);
            weight += w;
        }
    assert_true(weight > 0.0);
    return sum / weight;
}

// Predicts the pixel of a marker without the program's own C-arm code. Instead of the C-arm, the calculation
// turns the patient and looks from the front. The patient turns first about the long axis by the primary
// angle, and then about the left-right axis by the secondary angle.
Eigen::Vector2d predicted(const CArm &carm, int size, const Eigen::Vector3d &point_m)
{
    const Eigen::Vector3d p = point_m - carm.isocentre_m;
    const double c = std::cos(carm.primary_deg * degree), s = std::sin(carm.primary_deg * degree);
    const Eigen::Vector3d turned(c * p.x() - s * p.z(), p.y(), s * p.x() + c * p.z());
    const double cs = std::cos(carm.secondary_deg * degree), ss = std::sin(carm.secondary_deg * degree);
    const Eigen::Vector3d tilted(turned.x(), cs * turned.y() - ss * turned.z(),
                                 ss * turned.y() + cs * turned.z());
    const double scale = carm.source_detector_m / (carm.source_isocentre_m + tilted.z());
    const double pixels_per_m = size / carm.field_m;
    return {0.5 * size + tilted.x() * scale * pixels_per_m, 0.5 * size - tilted.y() * scale * pixels_per_m};
}

} // namespace

static void markers_land_on_the_predicted_pixels(void **)
{
    const double pairs[12][2] = {{0, 0},  {45, -30}, {-10, -30}, {-35, -35}, {-5, 40},  {40, 30},
                                 {90, 0}, {-90, 0},  {45, 0},    {-30, 20},  {110, 10}, {-120, -50}};
    const Eigen::Vector3d middle_m(0.02, 0.10, -0.01);
    XrayScene scene;
    std::string error;
    assert_true(scene.set_bodies(marker_cube(middle_m), error));
    Xray xray(scene, 1);
    double worst_px = 0.0;
    for (const auto &pair : pairs) {
        XraySettings settings;
        settings.carm.primary_deg = pair[0];
        settings.carm.secondary_deg = pair[1];
        settings.carm.isocentre_m = middle_m + Eigen::Vector3d(0.004, -0.006, 0.003);
        settings.carm.source_detector_m = 1.10;
        settings.carm.source_isocentre_m = 0.72;
        settings.carm.field_m = 0.25;
        XrayPicture picture;
        xray.render(settings, {}, {}, 1, picture);
        for (int i = 0; i < 8; ++i) {
            const Eigen::Vector2d at = shadow(xray.body_path_q10mm(marker_materials[i]), picture.size);
            const Eigen::Vector2d wanted = predicted(settings.carm, picture.size, middle_m + corner_m(i));
            worst_px = std::max(worst_px, (at - wanted).norm());
        }
    }
    std::printf("# 8 markers x 12 angle pairs at 512 x 512: worst %.3f px off, allowed 0.5\n", worst_px);
    assert_true(worst_px <= 0.5);
}

// With LAO (left anterior oblique) the detector moves to the patient's left, and structures in the back of
// the body move to the right of the picture. With cranial angulation the detector moves to the head, and
// structures in the front of the body move down in the picture.
static void angles_have_the_signs_of_dicom(void **)
{
    const auto at = [](double primary_deg, double secondary_deg, const Eigen::Vector3d &point_m) {
        CArm carm;
        carm.primary_deg = primary_deg;
        carm.secondary_deg = secondary_deg;
        Eigen::Vector2d pixel;
        assert_true(project(make_view(carm, 512), point_m, pixel));
        return pixel;
    };
    const Eigen::Vector3d spine(0.0, 0.0, -0.06), sternum(0.0, 0.0, 0.06);
    assert_true(at(30, 0, spine).x() > 260 && at(-30, 0, spine).x() < 252);
    assert_true(at(0, 30, sternum).y() > 260 && at(0, -30, sternum).y() < 252);
    CArm lao;
    lao.primary_deg = 30.0;
    assert_true(make_view(lao, 512).forward.x() > 0.4); // towards the patient's left
    CArm cranial;
    cranial.secondary_deg = 30.0;
    assert_true(make_view(cranial, 512).forward.y() > 0.4); // towards the head
}

static void sides_of_the_picture_are_named_as_dicom_does(void **)
{
    const auto sides = [](double primary_deg, double secondary_deg) {
        CArm carm;
        carm.primary_deg = primary_deg;
        carm.secondary_deg = secondary_deg;
        const View view = make_view(carm, 512);
        return patient_side(view.right) + "/" + patient_side(view.up);
    };
    assert_string_equal(sides(0, 0).c_str(), "L/H");
    assert_string_equal(sides(30, 0).c_str(), "LP/H"); // right edge: left and back
    assert_string_equal(sides(-30, 0).c_str(), "LA/H");
    assert_string_equal(sides(60, 0).c_str(), "PL/H");
    assert_string_equal(sides(90, 0).c_str(), "P/H"); // lateral: the back on the right
    assert_string_equal(sides(-90, 0).c_str(), "A/H");
    assert_string_equal(sides(0, 30).c_str(), "L/HP");
    assert_string_equal(sides(0, -30).c_str(), "L/HA");
    assert_string_equal(sides(120, 0).c_str(), "PR/H");
}

// Moves every axis. No axis of the C-arm may exceed its given speed or acceleration or overshoot its target.
// The time of the motion must be that of a trapezium of speed, distance/speed + speed/acceleration, within 2
// %.
static void motors_keep_speed_and_acceleration_and_do_not_overshoot(void **)
{
    const GantryPose from = {0, 0, 0, 0, 0, 1.05, 0.75}, to = {30, -20, 0.1, -0.2, 0.05, 1.15, 0.80};
    Gantry gantry;
    gantry.place(from);
    gantry.aim(to);
    GantryPose last = from, last_speed{};
    std::array<int, gantry_axes> arrived{};
    for (int tick = 1; tick < 20000; ++tick) {
        gantry.tick();
        for (int i = 0; i < gantry_axes; ++i) {
            const AxisLimits &limits = gantry_limits()[i];
            const double speed = (gantry.pose()[i] - last[i]) * 1e3;
            assert_true(std::fabs(speed) <= limits.speed * (1 + 1e-9));
            assert_true(std::fabs(speed - last_speed[i]) <= limits.acceleration * 1e-3 * 2.001);
            assert_true((to[i] - gantry.pose()[i]) * (to[i] - from[i]) >= 0.0); // not past it
            if (arrived[i] == 0 && gantry.pose()[i] == to[i]) arrived[i] = tick;
            last_speed[i] = speed;
        }
        last = gantry.pose();
    }
    assert_false(gantry.is_moving() || gantry.is_blocked());
    for (int i = 0; i < gantry_axes; ++i) {
        const AxisLimits &limits = gantry_limits()[i];
        const double stated_s =
            std::fabs(to[i] - from[i]) / limits.speed + limits.speed / limits.acceleration;
        if (std::fabs(arrived[i] * 1e-3 - stated_s) > 0.02 * stated_s)
            fail_msg("axis %d arrived after %.3f s, the trapezium says %.3f s", i, arrived[i] * 1e-3,
                     stated_s);
    }
}

static void a_new_target_on_the_way_is_taken_smoothly(void **)
{
    Gantry gantry;
    gantry.place({0, 0, 0, 0, 0, 1.05, 0.75});
    gantry.aim_axis(axis_primary, 40.0);
    double last = 0.0, last_speed = 0.0, highest = 0.0;
    for (int tick = 0; tick < 6000; ++tick) {
        if (tick == 1000) gantry.aim_axis(axis_primary, 0.0);
        gantry.tick();
        const double speed = (gantry.pose()[axis_primary] - last) * 1e3;
        assert_true(std::fabs(speed - last_speed) <=
                    gantry_limits()[axis_primary].acceleration * 1e-3 * 2.001);
        last = gantry.pose()[axis_primary];
        last_speed = speed;
        highest = std::max(highest, last);
    }
    assert_true(highest > 20.0 && highest < 40.0 && last == 0.0);
}

static void halt_brakes_and_stays(void **)
{
    Gantry gantry;
    gantry.place({0, 0, 0, 0, 0, 1.05, 0.75});
    gantry.aim_axis(axis_primary, 40.0);
    for (int tick = 0; tick < 1000; ++tick) gantry.tick();
    gantry.halt();
    for (int tick = 0; tick < 1000; ++tick) gantry.tick();
    const double stood_deg = gantry.pose()[axis_primary];
    assert_false(gantry.is_moving());
    for (int tick = 0; tick < 1000; ++tick) gantry.tick();
    assert_true(gantry.pose()[axis_primary] == stood_deg && stood_deg < 40.0);
}

// Whatever pose is commanded, a gap must remain between C-arm and table, also at the end of braking. The test
// commands random poses of the C-arm one after the other, each for 4 s.
static void nothing_touches_the_table(void **)
{
    std::uint64_t seed = 12345;
    const auto random = [&](double low, double high) {
        seed = seed * 6364136223846793005u + 1442695040888963407u;
        return low + (high - low) * static_cast<double>(seed >> 40) / 16777216.0;
    };
    Gantry gantry;
    gantry.place({0, 0, 0, 0, 0, 1.05, 0.75});
    double smallest_m = 1.0;
    constexpr int poses = REFERENCE_RUN(300);
    int blocked = 0;
    for (int pose = 0; pose < poses; ++pose) {
        gantry.aim({random(-120, 120), random(-50, 50), random(-0.3, 0.3), random(-0.5, 0.5),
                    random(-0.3, 0.5), random(0.9, 1.3), random(0.6, 0.85)});
        for (int tick = 0; tick < 4000; ++tick) {
            gantry.tick();
            if (tick % 10 == 0) smallest_m = std::min(smallest_m, table_clearance_m(gantry.pose()));
        }
        blocked += gantry.is_blocked();
    }
    std::printf("# smallest gap %.1f mm, %d of %d motions stopped by the interlock\n", smallest_m * 1e3,
                blocked, poses);
    assert_true(smallest_m >= 0.02); // it brakes at 2.5 cm and checks seven places along the move
    assert_true(blocked > poses / 30);
}

static void a_blocked_arm_is_free_to_go_back(void **)
{
    Gantry gantry;
    gantry.place({0, 0, 0, 0, 0, 0.90, 0.75});
    gantry.aim_axis(axis_primary, 120.0);
    for (int tick = 0; tick < 10000; ++tick) gantry.tick();
    assert_true(gantry.is_blocked() && !gantry.is_moving());
    const double stopped_deg = gantry.pose()[axis_primary];
    assert_true(stopped_deg > 40.0 && stopped_deg < 119.0);
    gantry.aim_axis(axis_primary, 0.0);
    for (int tick = 0; tick < 10000; ++tick) gantry.tick();
    assert_true(gantry.pose()[axis_primary] == 0.0 && !gantry.is_blocked());
}

// The expected gap between C-arm and table in the AP view follows from the dimensions of tube and table. The
// tube's housing ends 25 cm in front of the focal spot, and therefore 50 cm below the isocentre. The
// underside of the table is 13 + 6 cm below the patient's origin.
static void the_gap_under_the_table_is_the_one_of_the_drawing(void **)
{
    const double gap_m = table_clearance_m({0, 0, 0, 0, 0, 1.05, 0.75});
    assert_float_equal(gap_m, 0.50 - 0.19, 1e-9);
}

// In coronary views the heart is at the isocentre. In views of the aortic arch and of the renal and iliac
// arteries, the table has another height than in coronary views.
static void every_preset_is_reached_clear_of_the_table(void **)
{
    std::set<std::string_view> names;
    for (const ViewPreset &preset : view_presets()) {
        Gantry gantry;
        gantry.place({0, 0, 0.02, 0.12, 0.03, 1.05, 0.75});
        gantry.aim({preset.primary_mdeg * 1e-3, preset.secondary_mdeg * 1e-3, 0.02, 0.12, 0.03,
                    preset.sid_um * 1e-6, 0.75});
        for (int tick = 0; tick < 8000; ++tick) gantry.tick();
        std::printf("# %-16s clear of the table by %3.0f mm\n", std::string(preset.name).c_str(),
                    table_clearance_m(gantry.pose()) * 1e3);
        if (gantry.is_blocked() || gantry.pose() != gantry.target())
            fail_msg("preset %s is not reached", std::string(preset.name).c_str());
        assert_true(refusal({RoomAction::angles, {preset.primary_mdeg, preset.secondary_mdeg, 0}}).empty());
        assert_true(refusal({RoomAction::field, {preset.field_um, 0, 0}}).empty());
        assert_true(view_preset(preset.name) == &preset);
        names.insert(preset.name);
    }
    assert_int_equal(names.size(), view_presets().size());
    assert_null(view_preset("spyder"));
}

int main()
{
    const CMUnitTest tests[] = {
        cmocka_unit_test(markers_land_on_the_predicted_pixels),
        cmocka_unit_test(angles_have_the_signs_of_dicom),
        cmocka_unit_test(sides_of_the_picture_are_named_as_dicom_does),
        cmocka_unit_test(motors_keep_speed_and_acceleration_and_do_not_overshoot),
        cmocka_unit_test(a_new_target_on_the_way_is_taken_smoothly),
        cmocka_unit_test(halt_brakes_and_stays),
        cmocka_unit_test(nothing_touches_the_table),
        cmocka_unit_test(a_blocked_arm_is_free_to_go_back),
        cmocka_unit_test(the_gap_under_the_table_is_the_one_of_the_drawing),
        cmocka_unit_test(every_preset_is_reached_clear_of_the_table),
    };
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
