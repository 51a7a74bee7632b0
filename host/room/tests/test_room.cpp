// Tests the X-ray room: it must carry out each command at its tick, and must always give the same results.
// The tests cover pulses, last image hold, runs, masks, roadmaps, review and dose. The pictures in these
// tests are synthetic, since the room does not depend on their source.
#include "host/room/presets.hpp"
#include "host/room/room_screen.hpp"
#include <algorithm>
#include <cmath>
#include <csetjmp>
#include <cstdarg>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <functional>
extern "C" {
#include <cmocka.h>
}

using namespace crn;

namespace
{

constexpr int size = 64;
constexpr std::size_t pixels = std::size_t{size} * size;

// Returns the density of the synthetic patient at a pixel and a tick, in doublings of attenuation.
using Object = std::function<double(int x, int y, std::uint32_t tick)>;

double nothing(int, int, std::uint32_t)
{
    return 0.0;
}

// Describes a synthetic instrument: a bar four pixels wide, which appears at tick 300.
double bar(int x, int, std::uint32_t tick)
{
    return tick >= 300 && x >= 30 && x < 34 ? 1.0 : 0.0;
}

XrayExposure exposure_of(const PulseRequest &request)
{
    XrayExposure exposure;
    exposure.technique.tube_voltage_kV = 70.0;
    exposure.air_kerma_uGy = request.kind == RunKind::fluoro ? 2.0 : 20.0;
    exposure.kap_Gy_cm2 = exposure.air_kerma_uGy * 1e-6 * reference_area_cm2(request.carm, request.beam);
    return exposure;
}

XrayPicture picture_of(const Object &object, std::uint32_t tick)
{
    XrayPicture picture;
    picture.size = size;
    picture.tick = tick;
    picture.grey.resize(pixels);
    picture.raw.resize(pixels);
    for (int y = 0; y < size; ++y)
        for (int x = 0; x < size; ++x) {
            const double patient = 1024.0 * (x < 32 ? 1.0 : 0.25); // bone on the right half
            const auto raw = static_cast<std::uint16_t>(patient * std::exp2(-object(x, y, tick)) + 0.5);
            picture.raw[static_cast<std::size_t>(y) * size + x] = raw;
            picture.grey[static_cast<std::size_t>(y) * size + x] = static_cast<std::uint8_t>(raw / 8);
        }
    return picture;
}

struct Bench {
    explicit Bench(const Object &of = nothing, std::size_t memory = std::size_t{64} << 20)
        : screen(room, memory), object(of)
    {
    }

    void ask(RoomAction action, std::int32_t a = 0, std::int32_t b = 0, std::int32_t c = 0)
    {
        assert_string_equal(room.give(now, {action, {a, b, c}}).c_str(), "");
    }
    // Runs the room through all ticks before tick `end`.
    void run_to(std::uint32_t end)
    {
        for (; now < end; ++now) {
            room.advance(now, nullptr);
            if (room.is_pulse_due()) {
                pulses.push_back(now);
                room.expose(exposure_of(room.pulse()));
            }
            show_events();
        }
    }
    void show_events()
    {
        for (const RoomEvent &event : room.events()) {
            const bool is_pulse = event.kind == RoomEvent::Kind::pulse;
            const XrayPicture picture = is_pulse ? picture_of(object, event.tick) : XrayPicture{};
            screen.take(event, is_pulse ? &picture : nullptr);
        }
        room.forget_events();
    }
    std::uint8_t grey_at(int x, int y)
    {
        screen.compose(size, grey);
        return grey[static_cast<std::size_t>(y) * size + static_cast<std::size_t>(x)];
    }
    // Makes a subtraction run (DSA) of six frames at 3 frames per second.
    void dsa_run()
    {
        ask(RoomAction::program, 1);
        ask(RoomAction::acquire_pedal, 1);
        run_to(now + 1700);
        ask(RoomAction::acquire_pedal, 0);
        run_to(now + 100);
    }

    Room room;
    RoomScreen screen;
    Object object;
    std::uint32_t now = 0;
    std::vector<std::uint32_t> pulses;
    std::vector<std::uint8_t> grey;
};

} // namespace

// The X-ray pulse number k of a press must come k/rate after the press, rounded up to whole ticks.
static void pulses_come_at_the_rate_chosen(void **)
{
    for (std::int32_t rate : fluoro_rates_centihertz) {
        Bench bench;
        bench.run_to(17);
        bench.ask(RoomAction::fluoro_rate, rate);
        bench.ask(RoomAction::fluoro_pedal, 1);
        bench.run_to(17 + 2000);
        bench.ask(RoomAction::fluoro_pedal, 0);
        bench.run_to(3000);
        assert_int_equal(bench.pulses.size(), (2000 * rate + 99'999) / 100'000);
        for (std::size_t k = 0; k < bench.pulses.size(); ++k)
            assert_int_equal(bench.pulses[k], 17 + std::ceil(k * 1e5 / rate));
    }
}

static void the_next_pulse_is_announced_so_that_it_is_not_missed(void **)
{
    Room room;
    assert_true(room.next_tick() == UINT32_MAX);
    room.give(40, {RoomAction::fluoro_pedal, {1, 0, 0}});
    assert_int_equal(room.next_tick(), 40);
    room.advance(40, nullptr);
    assert_true(room.is_pulse_due());
    room.expose(exposure_of(room.pulse()));
    assert_int_equal(room.next_tick(), 107); // 15 per s
    room.advance(107, nullptr);
    assert_true(room.is_pulse_due());
}

static void the_last_image_stays_when_the_pedal_is_released(void **)
{
    Bench bench;
    assert_int_equal(bench.grey_at(10, 10), 0); // no picture yet
    assert_true(bench.screen.status().source == ScreenSource::nothing);
    bench.ask(RoomAction::fluoro_pedal, 1);
    bench.run_to(500);
    assert_true(bench.screen.status().source == ScreenSource::live && bench.screen.status().is_beam_on);
    bench.ask(RoomAction::fluoro_pedal, 0);
    bench.run_to(5000);
    assert_int_equal(bench.grey_at(10, 10), 128);
    assert_true(bench.screen.status().source == ScreenSource::held && !bench.screen.status().is_beam_on);
    assert_true(bench.room.dose().kerma_rate_mGy_min() == 0.0);
}

// In this test, presses of the two pedals and changes of mode overlap in time. Only one X-ray beam may be on
// at a time, and no beam may start without a new press of a pedal.
static void a_pedal_held_over_another_run_does_nothing_until_it_is_pressed_again(void **)
{
    Bench bench;
    bench.ask(RoomAction::fluoro_pedal, 1);
    bench.run_to(1000);
    bench.ask(RoomAction::acquire_pedal, 1); // cine wins
    bench.run_to(1001);
    assert_true(bench.screen.status().kind == RunKind::cine && bench.room.is_beam_on());
    bench.ask(RoomAction::program, 1); // applies to the next press
    bench.run_to(2000);
    assert_true(bench.screen.status().kind == RunKind::cine);
    bench.ask(RoomAction::acquire_pedal, 0);
    bench.run_to(3000);
    assert_false(bench.room.is_beam_on()); // though the fluoroscopy pedal is still down
    bench.ask(RoomAction::fluoro_pedal, 0);
    bench.run_to(3100);
    bench.ask(RoomAction::fluoro_pedal, 1);
    bench.run_to(3200);
    assert_true(bench.room.is_beam_on());
    assert_int_equal(bench.room.dose().irradiations().size(), 3);
}

static void a_tap_within_one_tick_gives_neither_beam_nor_run(void **)
{
    Bench bench;
    bench.ask(RoomAction::acquire_pedal, 1);
    bench.ask(RoomAction::acquire_pedal, 0);
    bench.run_to(100);
    assert_true(bench.pulses.empty() && bench.screen.store().runs().empty() &&
                bench.room.dose().irradiations().empty());
}

// The kerma-area product of a run must equal the sum over its frames, and also the kerma times the field's
// area at the reference point: (0.6 m / 1.05 m x 25 cm x 80 %) x (0.6 m / 1.05 m x 25 cm x 60 %).
static void dose_of_a_run_is_the_sum_over_its_frames(void **)
{
    Bench bench;
    bench.ask(RoomAction::field, 250'000);
    bench.ask(RoomAction::blades, 800, 600);
    bench.ask(RoomAction::acquire_pedal, 1);
    bench.run_to(3000);
    bench.ask(RoomAction::acquire_pedal, 0);
    bench.ask(RoomAction::fluoro_pedal, 1);
    bench.run_to(4000);
    bench.ask(RoomAction::fluoro_pedal, 0);
    bench.run_to(4001);
    const XrayRun &run = bench.screen.store().find(1)->run;
    double kerma_uGy = 0.0, kap_Gy_cm2 = 0.0;
    for (const RunFrame &frame : run.frames) {
        kerma_uGy += frame.air_kerma_uGy;
        kap_Gy_cm2 += frame.kap_Gy_cm2;
    }
    const std::vector<Irradiation> &all = bench.room.dose().irradiations();
    assert_int_equal(all.size(), 2);
    assert_int_equal(all[0].run, 1);
    assert_int_equal(all[0].dose.pulses, run.frames.size());
    assert_int_equal(run.frames.size(), 45);
    assert_true(std::fabs(all[0].dose.kap_Gy_cm2 / kap_Gy_cm2 - 1.0) < 1e-9);
    assert_true(std::fabs(all[0].dose.air_kerma_uGy / kerma_uGy - 1.0) < 1e-9);
    const double edge_cm = 60.0 / 105.0 * 25.0, area_cm2 = edge_cm * 0.8 * edge_cm * 0.6;
    const double stated = kerma_uGy * 1e-6 * area_cm2;
    std::printf("# KAP of a run of 45 frames: %.6f, kerma x area %.6f Gy cm2\n", all[0].dose.kap_Gy_cm2,
                stated);
    assert_true(std::fabs(all[0].dose.kap_Gy_cm2 / stated - 1.0) < 1e-3);
    const Dose &total = bench.room.dose().total();
    assert_true(std::fabs(total.kap_Gy_cm2 - all[0].dose.kap_Gy_cm2 - all[1].dose.kap_Gy_cm2) < 1e-12);
    assert_int_equal(bench.room.dose().fluoro_ticks(), 1000); // cine is not fluoroscopy
}

static void dose_alerts_come_at_two_and_five_gray_and_are_acknowledged(void **)
{
    DoseMeter meter;
    Irradiation cine;
    cine.kind = RunKind::cine;
    meter.begin(cine);
    for (int pulse = 1; pulse <= 60; ++pulse) {
        meter.add(0, 1e5, 1.0); // 0.1 Gy each
        assert_int_equal(meter.alerts_passed(), pulse < 20 ? 0 : pulse < 50 ? 1 : 2);
        if (pulse == 30) {
            assert_int_equal(*meter.unseen_alert(), 0);
            meter.acknowledge();
            assert_false(meter.unseen_alert().has_value());
        }
    }
    assert_int_equal(*meter.unseen_alert(), 1);
}

// In DSA the contrast must be equal in front of bone and of lung: a doubling of attenuation must darken the
// background (grey value 160) by 255/2.
static void dsa_shows_what_came_since_the_mask_and_no_bone(void **)
{
    Bench bench(bar);
    bench.dsa_run();
    assert_true(bench.screen.status().is_subtracted);
    assert_int_equal(bench.grey_at(10, 30), 160);
    assert_int_equal(bench.grey_at(50, 30), 160);
    assert_in_range(bench.grey_at(32, 30), 74, 77);
    assert_int_equal(bench.screen.store().find(1)->run.frames.size(), 6);
}

static void a_new_mask_is_taken_from_the_frames_named(void **)
{
    Bench bench(bar);
    bench.dsa_run();
    bench.ask(RoomAction::mask, 3, 5); // these frames contain the bar: it disappears
    bench.run_to(bench.now + 1);
    assert_int_equal(bench.grey_at(32, 30), 160);
    bench.ask(RoomAction::review, 2, 1, 0); // before the bar: white
    bench.run_to(bench.now + 1);
    assert_in_range(bench.grey_at(32, 30), 244, 247);
    assert_int_equal(bench.screen.status().mask_first, 3);
    assert_int_equal(bench.screen.status().mask_last, 5);
    bench.ask(RoomAction::mask, 3, 6);
    bench.run_to(bench.now + 1);
    assert_non_null(std::strstr(bench.screen.status().notice.c_str(), "NO SUCH MASK"));
    assert_int_equal(bench.screen.status().mask_last, 5);
}

// The bone's edge (two doublings of attenuation, columns 31 to 32) moves when the mask is moved. Moving the
// mask right by one pixel leaves a seam of one pixel, in which only the mask is bright.
static void pixel_shift_moves_the_mask(void **)
{
    Bench bench;
    bench.dsa_run();
    bench.ask(RoomAction::shift, 100, 0);
    bench.run_to(bench.now + 1);
    assert_true(bench.grey_at(32, 30) < 100); // mask bright, live dark
    assert_int_equal(bench.grey_at(20, 30), 160);
    assert_int_equal(bench.grey_at(45, 30), 160);
    bench.ask(RoomAction::shift, -100, 0);
    bench.run_to(bench.now + 1);
    assert_true(bench.grey_at(31, 30) > 220);
    bench.ask(RoomAction::shift, 0, 0);
    bench.run_to(bench.now + 1);
    assert_int_equal(bench.grey_at(32, 30), 160);
}

static void masks_without_a_dsa_run_are_refused_with_a_notice(void **)
{
    Bench bench;
    for (int run = 0; run < 2; ++run) {
        bench.ask(RoomAction::mask, 0, 0);
        bench.run_to(bench.now + 1);
        assert_non_null(std::strstr(bench.screen.status().notice.c_str(), "NO DSA RUN"));
        bench.ask(RoomAction::acquire_pedal, 1); // then with a cine run
        bench.run_to(bench.now + 500);
        bench.ask(RoomAction::acquire_pedal, 0);
        bench.run_to(bench.now + 1);
    }
}

static void dsa_keeps_its_technique_and_holds_the_motors(void **)
{
    Bench bench;
    bench.run_to(1);
    bench.ask(RoomAction::angles, 30'000);
    bench.run_to(500);
    bench.ask(RoomAction::program, 1);
    bench.ask(RoomAction::acquire_pedal, 1);
    bench.run_to(501);
    assert_false(bench.room.is_beam_on()); // first the motors come to rest
    bench.run_to(3000);
    assert_true(bench.room.is_beam_on() && !bench.screen.status().is_moving);
    assert_true(bench.room.pulse().beam.fixed_technique.has_value() && !bench.room.pulse().settles_at_once);
    const double stood_deg = bench.screen.status().carm.primary_deg;
    bench.ask(RoomAction::angles, 45'000);
    bench.run_to(4000);
    assert_true(bench.screen.status().carm.primary_deg == stood_deg);
    bench.ask(RoomAction::acquire_pedal, 0);
    bench.run_to(8000);
    assert_true(bench.screen.status().carm.primary_deg == 45.0);
}

// The cine loop has 15 frames and runs at 15 frames/s, so it shows frame floor(time x rate) modulo 15.
static void a_cine_loop_runs_at_the_rate_of_its_run(void **)
{
    Bench bench([](int, int, std::uint32_t tick) { return tick / 1000.0; }); // each frame darker
    bench.ask(RoomAction::acquire_pedal, 1);
    bench.run_to(1000);
    bench.ask(RoomAction::acquire_pedal, 0);
    bench.run_to(1100);
    bench.ask(RoomAction::review, 1, 0, 0);
    const std::uint32_t begin = bench.now;
    for (std::uint32_t after : {0u, 70u, 500u, 999u, 1001u, 2500u}) {
        bench.run_to(begin + after + 1);
        const int frame = static_cast<int>(after * 15 / 1000) % 15;
        assert_int_equal(bench.screen.status().frame, frame);
        assert_int_equal(bench.grey_at(10, 10),
                         bench.screen.store().find(1)->grey[static_cast<std::size_t>(frame)][650]);
    }
    assert_true(bench.screen.status().source == ScreenSource::loop && bench.screen.status().frames == 15);
    bench.ask(RoomAction::fluoro_pedal, 1); // the pedal ends the review
    bench.run_to(bench.now + 10);
    assert_true(bench.screen.status().source == ScreenSource::live);
    bench.ask(RoomAction::review, 1, 0, 0);
    bench.run_to(bench.now + 10);
    assert_non_null(std::strstr(bench.screen.status().notice.c_str(), "RELEASE THE PEDAL"));
}

static void review_of_what_is_not_there_says_so(void **)
{
    Bench bench;
    bench.ask(RoomAction::review, 1, 0, 0);
    bench.run_to(1);
    assert_non_null(std::strstr(bench.screen.status().notice.c_str(), "NO RUN TO REVIEW"));
    bench.ask(RoomAction::acquire_pedal, 1);
    bench.run_to(100);
    bench.ask(RoomAction::acquire_pedal, 0);
    bench.run_to(101);
    bench.ask(RoomAction::review, 1, 7, 0);
    bench.run_to(102);
    assert_non_null(std::strstr(bench.screen.status().notice.c_str(), "NO RUN 7"));
    bench.ask(RoomAction::review, 2, 1, 2);
    bench.run_to(103);
    assert_non_null(std::strstr(bench.screen.status().notice.c_str(), "1 to 2"));
    bench.run_to(103 + 4000);
    assert_string_equal(bench.screen.status().notice.c_str(), ""); // a notice disappears by itself
}

static void stored_fluoroscopy_is_what_the_last_seconds_showed(void **)
{
    Bench bench;
    bench.ask(RoomAction::store, 2000);
    bench.run_to(1);
    assert_non_null(std::strstr(bench.screen.status().notice.c_str(), "NO FLUOROSCOPY"));
    bench.ask(RoomAction::fluoro_pedal, 1);
    bench.run_to(5001);
    bench.ask(RoomAction::store, 2000); // not while the beam is on
    bench.run_to(5002);
    assert_int_equal(bench.screen.store().runs().size(), 0);
    bench.ask(RoomAction::fluoro_pedal, 0);
    bench.ask(RoomAction::store, 2000);
    bench.run_to(5003);
    const XrayRun &run = bench.screen.store().find(1)->run;
    assert_true(run.kind == RunKind::fluoro);
    assert_int_equal(run.frames.size(), 30); // 2 s at 15 per s
    assert_true(run.frames.front().tick > 3000 && run.frames.back().tick == bench.pulses.back());
}

// The synthetic vessel is a bar that contains contrast medium only during the DSA run. In fluoroscopy without
// medium, the roadmap must make the bar brighter.
static void a_roadmap_lies_white_under_live_fluoroscopy(void **)
{
    Bench bench(bar);
    bench.dsa_run();
    bench.object = nothing;
    bench.ask(RoomAction::roadmap, 1);
    bench.ask(RoomAction::fluoro_pedal, 1);
    bench.run_to(bench.now + 10);
    assert_true(bench.screen.status().roadmap == RoadmapState::shown);
    assert_int_equal(bench.grey_at(10, 30), 128);
    assert_true(bench.grey_at(33, 30) > 32 + 41); // bone is 32
    // If the geometry has changed, the roadmap must not be shown until the former geometry returns.
    bench.ask(RoomAction::field, 200'000);
    bench.run_to(bench.now + 100);
    assert_int_equal(bench.grey_at(33, 30), 32);
    assert_true(bench.screen.status().roadmap == RoadmapState::moved);
    bench.ask(RoomAction::field, 320'000);
    bench.run_to(bench.now + 100);
    assert_true(bench.grey_at(33, 30) > 32 + 41);
    bench.ask(RoomAction::roadmap, 0);
    bench.run_to(bench.now + 100);
    assert_int_equal(bench.grey_at(33, 30), 32);
}

// Along the collimator blades every picture is dimmed and noisy. A frame that is darker along the blades than
// the mask must not produce a white rim.
static void a_roadmap_leaves_the_rim_of_the_field_alone(void **)
{
    Bench bench([](int x, int, std::uint32_t tick) {
        return x >= 60                            ? 12.0
               : x == 59                          ? 4.0 - (tick < 300 ? 1.0 : 0.0)
               : tick >= 300 && x >= 30 && x < 34 ? 1.0
                                                  : 0.0;
    });
    bench.dsa_run();
    bench.ask(RoomAction::roadmap, 1);
    bench.ask(RoomAction::fluoro_pedal, 1);
    bench.run_to(bench.now + 10);
    assert_true(bench.screen.status().roadmap == RoadmapState::shown);
    assert_int_equal(bench.grey_at(59, 30), 2); // raw 16 / 8, untouched
    assert_true(bench.grey_at(33, 30) > 16 + 41);
}

static void a_roadmap_is_collected_by_the_next_press(void **)
{
    Bench bench;
    bench.ask(RoomAction::roadmap, 2);
    bench.run_to(10);
    assert_true(bench.screen.status().roadmap == RoadmapState::waits);
    bench.object = bar; // from tick 300 on
    bench.ask(RoomAction::fluoro_pedal, 1);
    bench.run_to(1000);
    assert_true(bench.screen.status().roadmap == RoadmapState::collects);
    bench.ask(RoomAction::fluoro_pedal, 0);
    bench.run_to(1100);
    bench.object = nothing;
    bench.ask(RoomAction::fluoro_pedal, 1);
    bench.run_to(1200);
    assert_true(bench.screen.status().roadmap == RoadmapState::shown);
    assert_true(bench.grey_at(33, 30) > 32 + 41 && bench.grey_at(50, 30) == 32);
    bench.ask(RoomAction::roadmap, 1);
    bench.run_to(1300);
    assert_non_null(std::strstr(bench.screen.status().notice.c_str(), "NO ROADMAP"));
}

// Every frame takes 64 x 64 x 3 bytes, and the memory has space for 40 frames. If the second run has 30
// frames, the pictures of the first run must be deleted. If a run has 60 frames, its last 20 must not be
// stored. When the memory is full, the beam must stay on: the dose must not depend on the size of pictures.
static void image_memory_is_bounded_and_the_oldest_pictures_go(void **)
{
    Bench bench(nothing, 40 * pixels * 3);
    for (int run = 0; run < 2; ++run) {
        bench.ask(RoomAction::acquire_pedal, 1);
        bench.run_to(bench.now + 2000);
        bench.ask(RoomAction::acquire_pedal, 0);
        bench.run_to(bench.now + 10);
    }
    assert_true(bench.screen.store().find(1)->is_dropped && !bench.screen.store().find(2)->is_dropped);
    bench.ask(RoomAction::review, 1, 1, 0);
    bench.run_to(bench.now + 1);
    assert_non_null(std::strstr(bench.screen.status().notice.c_str(), "went when the image memory"));
    bench.ask(RoomAction::acquire_pedal, 1);
    bench.run_to(bench.now + 4000);
    assert_true(bench.room.is_beam_on());
    assert_non_null(std::strstr(bench.screen.status().notice.c_str(), "IMAGE MEMORY IS FULL"));
    bench.ask(RoomAction::acquire_pedal, 0);
    bench.run_to(bench.now + 1);
    assert_int_equal(bench.room.runs()[2].frames, 60);
    assert_int_equal(bench.screen.store().find(3)->run.frames.size(), 40);
    assert_true(bench.screen.store().bytes() <= 40 * pixels * 3);
    assert_int_equal(bench.room.dose().irradiations().size(), 3); // all dose given is counted nevertheless
}

static void the_table_follows_a_tip_that_leaves_the_middle(void **)
{
    Room room;
    room.give(0, {RoomAction::follow, {1, 0, 0}});
    const Eigen::Vector3d entry(0.05, -0.2, 0.03);
    room.advance(0, &entry);
    assert_true((room.gantry().carm(0.32).isocentre_m - entry).norm() < 1e-12); // is there without motion
    const Eigen::Vector3d nearby = entry + Eigen::Vector3d(0.0, 0.03, 0.0),
                          away = entry + Eigen::Vector3d(0.0, 0.07, 0.0);
    for (std::uint32_t tick = 50; tick <= 1000; tick += 50) room.advance(tick, &nearby);
    assert_true((room.gantry().carm(0.32).isocentre_m - entry).norm() < 1e-12);
    for (std::uint32_t tick = 1050; tick <= 4000; tick += 50) room.advance(tick, &away);
    assert_true((room.gantry().carm(0.32).isocentre_m - away).norm() < 1e-9);
}

// Equal commands must give equal screens, whether the test stops at all ticks or only at those that
// next_tick() returns.
static void the_same_commands_give_the_same_screens(void **)
{
    std::vector<std::uint8_t> screens[2];
    for (int way = 0; way < 2; ++way) {
        Bench bench(bar);
        Room &room = bench.room;
        const RoomCommand commands[] = {
            {RoomAction::angles, {20'000, 5'000, 0}}, {RoomAction::fluoro_pedal, {1, 0, 0}},
            {RoomAction::fluoro_pedal, {0, 0, 0}},    {RoomAction::program, {1, 0, 0}},
            {RoomAction::acquire_pedal, {1, 0, 0}},   {RoomAction::acquire_pedal, {0, 0, 0}},
            {RoomAction::roadmap, {1, 0, 0}},         {RoomAction::fluoro_pedal, {1, 0, 0}}};
        std::uint32_t at = 5;
        for (const RoomCommand &command : commands) room.give(at += 700, command);
        for (std::uint32_t tick = 0; tick < 7000;) {
            room.advance(tick, nullptr);
            if (room.is_pulse_due()) room.expose(exposure_of(room.pulse()));
            bench.show_events();
            tick = way == 0 ? tick + 1 : std::min(room.next_tick(), (tick / 1000 + 1) * 1000);
        }
        std::vector<std::uint8_t> grey;
        room.advance(7000, nullptr);
        bench.show_events();
        bench.screen.compose(size, grey);
        screens[way] = grey;
        assert_true(bench.screen.store().runs().size() == 1 &&
                    bench.screen.status().roadmap == RoadmapState::shown);
    }
    assert_true(screens[0] == screens[1]);
}

static void commands_out_of_range_are_refused_and_change_nothing(void **)
{
    Room room;
    const RoomCommand bad[] = {{static_cast<RoomAction>(0), {}},
                               {static_cast<RoomAction>(999), {}},
                               {RoomAction::fluoro_pedal, {2, 0, 0}},
                               {RoomAction::fluoro_pedal, {1, 1, 0}},
                               {RoomAction::fluoro_rate, {1000, 0, 0}},
                               {RoomAction::angles, {120'001, 0, 0}},
                               {RoomAction::angles, {0, INT32_MIN, 0}},
                               {RoomAction::field, {0, 0, 0}},
                               {RoomAction::distance, {1'050'000, 0, 0}},
                               {RoomAction::blades, {0, 1000, 0}},
                               {RoomAction::mask, {3, 2, 0}},
                               {RoomAction::review, {1, -1, 0}}};
    for (const RoomCommand &command : bad) {
        assert_false(room.give(0, command).empty());
        assert_true(room.next_tick() == UINT32_MAX);
    }
}

int main()
{
    const CMUnitTest tests[] = {
        cmocka_unit_test(pulses_come_at_the_rate_chosen),
        cmocka_unit_test(the_next_pulse_is_announced_so_that_it_is_not_missed),
        cmocka_unit_test(the_last_image_stays_when_the_pedal_is_released),
        cmocka_unit_test(a_pedal_held_over_another_run_does_nothing_until_it_is_pressed_again),
        cmocka_unit_test(a_tap_within_one_tick_gives_neither_beam_nor_run),
        cmocka_unit_test(dose_of_a_run_is_the_sum_over_its_frames),
        cmocka_unit_test(dose_alerts_come_at_two_and_five_gray_and_are_acknowledged),
        cmocka_unit_test(dsa_shows_what_came_since_the_mask_and_no_bone),
        cmocka_unit_test(a_new_mask_is_taken_from_the_frames_named),
        cmocka_unit_test(pixel_shift_moves_the_mask),
        cmocka_unit_test(masks_without_a_dsa_run_are_refused_with_a_notice),
        cmocka_unit_test(dsa_keeps_its_technique_and_holds_the_motors),
        cmocka_unit_test(a_cine_loop_runs_at_the_rate_of_its_run),
        cmocka_unit_test(review_of_what_is_not_there_says_so),
        cmocka_unit_test(stored_fluoroscopy_is_what_the_last_seconds_showed),
        cmocka_unit_test(a_roadmap_lies_white_under_live_fluoroscopy),
        cmocka_unit_test(a_roadmap_leaves_the_rim_of_the_field_alone),
        cmocka_unit_test(a_roadmap_is_collected_by_the_next_press),
        cmocka_unit_test(image_memory_is_bounded_and_the_oldest_pictures_go),
        cmocka_unit_test(the_table_follows_a_tip_that_leaves_the_middle),
        cmocka_unit_test(the_same_commands_give_the_same_screens),
        cmocka_unit_test(commands_out_of_range_are_refused_and_change_nothing),
    };
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
