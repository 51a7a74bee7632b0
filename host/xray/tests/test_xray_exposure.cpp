// Tests the effects of one picture on the next: exposure control against its curve and limits, and lag
// against its decay law. A sequence of pictures must be repeatable.
#include "host/xray/lag.hpp"
#include "host/xray/tests/xray_room.hpp"
#include <cmath>
#include <cstdio>
#include <vector>

using namespace crn;

// For a single picture the exposure control has settled, so the signal over the measuring field must be that
// of the demanded dose for thin and thick patients.
static void exposure_holds_the_dose_behind_thin_and_thick(void **)
{
    for (double thickness_m : {0.08, 0.15, 0.20, 0.25}) {
        Room room(slab(thickness_m));
        XraySettings settings;
        settings.beam.noise = false;
        const XrayPicture picture = room.picture(settings);
        const double raw = measured_raw(picture);
        std::printf("# %.0f mm: %.0f kV, %.0f mA, %.1f ms, %.1f mm Cu, %.1f uGy; raw %.0f\n",
                    thickness_m * 1e3, picture.technique.tube_voltage_kV, picture.technique.tube_current_mA,
                    picture.technique.pulse_ms, picture.technique.copper_mm, picture.air_kerma_uGy, raw);
        assert_false(picture.is_underexposed);
        // The exposure control measures only about a thousand of the picture's pixels, which explains the
        // tolerance of 4 %.
        assert_true(std::fabs(raw / raw_of_wanted_dose - 1.0) < 0.04);
    }
}

// When the view changes from thin to thick parts of the patient, the first pictures are darker. The signals
// of the pictures must approach the final value monotonically, be within 12 % after five pulses, and then
// stay constant.
static void exposure_follows_within_a_few_pulses(void **)
{
    Room thin(slab(0.12)), thick(slab(0.24));
    XraySettings settings;
    settings.beam.noise = false;
    XrayMemory memory;
    std::uint32_t tick = 0;
    for (int i = 0; i < 12; ++i) thin.next(settings, tick += 67, memory);
    std::vector<double> raw;
    for (int i = 0; i < 10; ++i) {
        const XrayPicture picture = thick.next(settings, tick += 67, memory);
        raw.push_back(measured_raw(picture));
        std::printf("# pulse %d: raw %.0f, %.0f kV, %.0f mA, %.1f ms, %.1f mm Cu\n", i, raw.back(),
                    picture.technique.tube_voltage_kV, picture.technique.tube_current_mA,
                    picture.technique.pulse_ms, picture.technique.copper_mm);
    }
    assert_true(raw[0] < 0.4 * raw[9]);
    assert_true(raw[1] > 1.2 * raw[0] && raw[1] < 0.9 * raw[9]);
    assert_true(std::fabs(raw[6] / raw[9] - 1.0) < 0.12);
    assert_true(std::fabs(raw[9] / raw_of_wanted_dose - 1.0) < 0.04);
}

// While the patient's thickness increases, voltage, current and pulse width must stay within the limits of
// the tube and of its power. The kerma rate of fluoroscopy must never exceed 88 mGy/min. Beyond the end of
// the exposure curve the picture must be underexposed, and is_underexposed must be true.
static void exposure_keeps_its_limits_and_underexposes_at_them(void **)
{
    Exposure exposure;
    for (ExposureMode mode : {ExposureMode::fluoro, ExposureMode::cine, ExposureMode::dsa}) {
        ExposureDemand demand;
        demand.mode = mode;
        demand.dose_nGy = mode == ExposureMode::fluoro ? 40.0 : mode == ExposureMode::cine ? 170.0 : 1200.0;
        ExposureState state;
        const bool is_fluoro = mode == ExposureMode::fluoro;
        for (double water_cm = 2.0; water_cm <= 50.0; water_cm += 0.25) {
            state.water_cm = water_cm;
            const ExposureChoice choice = exposure.choose(demand, state);
            const XrayTechnique &now = choice.technique;
            assert_true(now.tube_voltage_kV >= 60.0 && now.tube_voltage_kV <= 125.0);
            assert_true(now.tube_current_mA >= (is_fluoro ? 10.0 : 300.0) &&
                        now.tube_current_mA <= (is_fluoro ? 100.0 : 800.0));
            assert_true(now.pulse_ms >= 3.0 && now.pulse_ms <= (mode == ExposureMode::dsa ? 80.0 : 10.0));
            assert_true(now.tube_voltage_kV * now.tube_current_mA <=
                        (is_fluoro ? 20e3 : 80e3) * (1.0 + 1e-12));
            const BeamTable &beam = exposure.table(now.tube_voltage_kV, now.copper_mm);
            const double rate_mGy_min = reference_kerma_uGy(beam, now, 0.75) * 15.0 * 60.0 * 1e-3;
            if (is_fluoro) assert_true(rate_mGy_min <= 88.0 * 1.000001);
            if (water_cm <= 20.0) assert_false(choice.is_limited);
            if (water_cm >= 45.0) assert_true(choice.is_limited);
        }
    }
    Room room(slab(0.45));
    XraySettings settings;
    settings.beam.noise = false;
    const XrayPicture dark = room.picture(settings);
    std::printf("# 45 cm: raw %u of %.0f\n", dark.raw[256 * 512 + 256], raw_of_wanted_dose);
    assert_true(dark.is_underexposed);
    assert_true(dark.raw[256 * 512 + 256] < 0.5 * raw_of_wanted_dose);
}

// A plate lies in the beam for 40 pictures, and then the table moves it out of the beam. The ghost of the
// plate must begin at 3 % of the change in signal, and each later ghost must be 2^(-T/h) times that in the
// previous picture, where T is the time between pictures and h the half-life of the trapped signal. Without
// an XrayMemory there must be no lag.
static void lag_is_the_stated_share_and_decays_per_picture(void **)
{
    Room room({{box_body("plate", "soft_tissue", -1, {-0.02, -0.02, -0.1}, {0.02, 0.02, 0.1})}});
    XraySettings settings = fixed(75.0, 50.0, 5.0);
    settings.beam.noise = settings.beam.scatter = false;
    settings.beam.dose_per_frame_nGy = 3000.0; // the open beam stays below raw_max
    XrayMemory memory;
    std::uint32_t tick = 0;
    double covered = 0.0;
    for (int i = 0; i < 40; ++i) covered = room.next(settings, tick += 67, memory).raw[256 * 512 + 256];
    const double covered_alone = room.picture(settings, tick).raw[256 * 512 + 256];
    assert_true(std::fabs(covered - covered_alone) <= 1.0); // in equilibrium nothing is missing
    settings.carm.isocentre_m.x() = 0.06;
    const double open = room.picture(settings, tick).raw[256 * 512 + 256];
    double last = open - covered;
    for (int i = 0; i < 6; ++i) {
        const double missing = open - room.next(settings, tick += 67, memory).raw[256 * 512 + 256];
        const double stated = i == 0 ? static_cast<double>(lag_trapped_share) : std::exp2(-67.0 / 140.0);
        std::printf("# picture %d: %.1f of a step of %.0f missing; ratio %.4f, stated %.4f\n", i + 1, missing,
                    open - covered, missing / last, stated);
        assert_true(std::fabs(missing - stated * last) <= 1.0 + 0.01 * missing); // raw values are whole
        last = missing;
    }
}

// A copy of the XrayMemory must continue as the original does; an XrayMemory that is reset must begin like a
// new one.
static void sequence_repeats_from_a_copy_of_its_memory(void **)
{
    Room room(slab(0.2));
    XraySettings settings;
    settings.size = 256;
    XrayMemory memory;
    const XrayPicture first = room.next(settings, 100, memory);
    for (std::uint32_t tick : {167u, 233u}) room.next(settings, tick, memory);
    XrayMemory copy = memory;
    const XrayPicture once = room.next(settings, 300, memory), again = room.next(settings, 300, copy);
    assert_true(once.raw == again.raw && once.grey == again.grey && once.technique == again.technique);
    XrayMemory fresh;
    const XrayPicture restarted = room.next(settings, 100, fresh);
    assert_true(restarted.raw == first.raw && restarted.shown == first.shown);
}

int main()
{
    cmocka_set_message_output(CM_OUTPUT_TAP);
    const CMUnitTest tests[] = {
        cmocka_unit_test(exposure_holds_the_dose_behind_thin_and_thick),
        cmocka_unit_test(exposure_follows_within_a_few_pulses),
        cmocka_unit_test(exposure_keeps_its_limits_and_underexposes_at_them),
        cmocka_unit_test(lag_is_the_stated_share_and_decays_per_picture),
        cmocka_unit_test(sequence_repeats_from_a_copy_of_its_memory),
    };
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
