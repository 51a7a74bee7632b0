// These tests check the following. The measuring chamber gives the same techniques that automatic exposure
// would choose from a picture of any size. The dose of a session therefore does not depend on which pictures
// the program makes. The kerma-area product of the chamber is the kerma times the area of the open field.
#include "host/xray/meter.hpp"
#include "host/xray/tests/xray_room.hpp"
#include <algorithm>
#include <cmath>
#include <cstdio>

using namespace crn;

namespace
{

// Makes a trunk (of a body) with uneven thickness, with bone beside the middle and air above it. The chamber
// and the pictures measure at different points of this uneven trunk.
Bodies trunk()
{
    Bodies bodies = slab(0.2);
    bodies.bodies.push_back(sphere_body("bone", "bone_cortical", 0, {0.03, -0.02, 0.0}, 0.035, 24));
    bodies.bodies.push_back(sphere_body("air", "air", 0, {-0.05, 0.06, 0.0}, 0.04, 24));
    return bodies;
}

} // namespace

// Simulates the first eight pulses after the beam is switched on. Measured difference: 2.0 % of kerma at
// most, from 256 to 1024 pixels: about one step of 1 kV.
static void pulses_are_taken_as_from_a_picture_of_any_size(void **)
{
    double worst = 0.0;
    for (const int size : {256, 512, 1024}) {
        Room room(trunk());
        XrayMeter meter(room.scene);
        XraySettings settings;
        settings.size = size;
        XrayMemory memory;
        for (std::uint32_t pulse = 0; pulse < 8; ++pulse) {
            const XrayPicture picture = room.next(settings, pulse * 67, memory);
            const XrayExposure exposure = meter.expose(settings, {}, MeterPace::follows);
            worst = std::max(worst, std::fabs(exposure.air_kerma_uGy / picture.air_kerma_uGy - 1.0));
            assert_true(exposure.is_underexposed == picture.is_underexposed);
        }
    }
    std::printf("# kerma differs by %.3f %% at most\n", worst * 100.0);
    assert_true(worst < 0.05);
}

static void the_size_of_a_picture_does_not_change_the_dose(void **)
{
    Room room(trunk());
    XrayMeter small(room.scene), large(room.scene, 2);
    XraySettings settings;
    for (std::uint32_t pulse = 0; pulse < 4; ++pulse) {
        settings.size = 64;
        const XrayExposure a = small.expose(settings, {}, MeterPace::follows);
        settings.size = 2048;
        const XrayExposure b = large.expose(settings, {}, MeterPace::follows);
        assert_true(a.technique == b.technique && a.air_kerma_uGy == b.air_kerma_uGy &&
                    a.kap_Gy_cm2 == b.kap_Gy_cm2);
    }
}

// With an SID of 1.05 m and an SOD of 0.75 m, the reference point is 0.6 m from the source. At the reference
// point, a field of 25 cm with blades at 80 % and 60 % measures 11.43 cm x 8.57 cm.
static void kerma_area_product_is_kerma_times_the_open_area(void **)
{
    Room room(slab(0.2));
    XrayMeter meter(room.scene);
    XraySettings settings;
    settings.carm.field_m = 0.25;
    settings.beam.open_width_share = 0.8;
    settings.beam.open_height_share = 0.6;
    const XrayExposure square = meter.expose(settings, {}, MeterPace::settles);
    const double area_cm2 = 25.0 * 0.8 * 25.0 * 0.6 * (0.6 / 1.05) * (0.6 / 1.05);
    assert_true(std::fabs(square.kap_Gy_cm2 / (square.air_kerma_uGy * 1e-6 * area_cm2) - 1.0) < 1e-12);
    settings.beam.circular_field = true; // as wide as the narrower pair of blades
    const XrayExposure round = meter.expose(settings, {}, MeterPace::settles);
    const double radius_cm = 0.5 * 25.0 * 0.6 * 0.6 / 1.05;
    assert_true(
        std::fabs(round.kap_Gy_cm2 / (round.air_kerma_uGy * 1e-6 * 3.14159265358979 * radius_cm * radius_cm) -
                  1.0) < 1e-12);
}

// Before the first frame of a DSA run, the generator makes test exposures. The first frame of a DSA run must
// have the technique of a single picture, whatever pulses came before.
static void test_exposures_settle_at_once(void **)
{
    Room room(trunk());
    XrayMeter meter(room.scene);
    XraySettings settings;
    settings.beam.mode = ExposureMode::dsa;
    settings.beam.dose_per_frame_nGy = 1200.0;
    const XrayExposure exposure = meter.expose(settings, {}, MeterPace::settles);
    const XrayPicture picture = room.picture(settings);
    std::printf("# settled: %.2f uGy, of a picture %.2f uGy\n", exposure.air_kerma_uGy,
                picture.air_kerma_uGy);
    assert_true(std::fabs(exposure.air_kerma_uGy / picture.air_kerma_uGy - 1.0) < 0.03);
}

static void a_locked_technique_is_taken_and_the_control_waits(void **)
{
    Room room(trunk());
    XrayMeter meter(room.scene), other(room.scene);
    XraySettings settings;
    const XrayExposure first = meter.expose(settings, {}, MeterPace::follows);
    other.expose(settings, {}, MeterPace::follows);
    XraySettings locked = fixed(70.0, 300.0, 5.0, 0.3);
    const XrayExposure held = meter.expose(locked, {}, MeterPace::follows);
    assert_true(held.technique == *locked.beam.fixed_technique && held.air_kerma_uGy > first.air_kerma_uGy);
    assert_true(meter.expose(settings, {}, MeterPace::follows).technique ==
                other.expose(settings, {}, MeterPace::follows).technique);
}

// A lead plate enters the beam after some pulses, and automatic exposure must follow the moved body.
static void bodies_that_move_change_the_dose(void **)
{
    Bodies bodies = slab(0.1);
    bodies.bodies.push_back(box_body("plate", "soft_tissue", -1, {0.6, -0.5, 0.1}, {1.2, 0.5, 0.2}));
    Room room(bodies);
    XrayMeter meter(room.scene);
    XraySettings settings;
    const double before = meter.expose(settings, {}, MeterPace::settles).air_kerma_uGy;
    std::vector<Eigen::Vector3i> moved = bodies.bodies[1].vertices_um;
    for (Eigen::Vector3i &vertex : moved) vertex.x() -= 900'000;
    const MovedBody plate{1, moved};
    const double after = meter.expose(settings, {&plate, 1}, MeterPace::settles).air_kerma_uGy;
    assert_true(after > 3.0 * before);
}

int main()
{
    const CMUnitTest tests[] = {
        cmocka_unit_test(pulses_are_taken_as_from_a_picture_of_any_size),
        cmocka_unit_test(the_size_of_a_picture_does_not_change_the_dose),
        cmocka_unit_test(kerma_area_product_is_kerma_times_the_open_area),
        cmocka_unit_test(test_exposures_settle_at_once),
        cmocka_unit_test(a_locked_technique_is_taken_and_the_control_waits),
        cmocka_unit_test(bodies_that_move_change_the_dose),
    };
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
