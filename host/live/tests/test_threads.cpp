// Tests that the result of a session does not depend on its threads. The report must be the same with all
// pictures, with some pictures left out, and without a GUI window. The recording must replay bit for bit. If
// a thread fails, the session ends, and its fault text gives the reason.
#include <atomic>
#include <csetjmp>
#include <cstdarg>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <string>
#include <thread>
#include <unistd.h>
#include <vector>

#include <nlohmann/json.hpp>

#include "host/base/text.hpp"
#include "host/live/physics_thread.hpp"
#include "host/model/instrument.hpp"
#include "host/picture/session_pictures.hpp"
#include "host/session/replay.hpp"

// The header cmocka.h comes last, because its macros (fail, ...) would change other headers.
extern "C" {
#include <cmocka.h>
}

namespace
{

const std::string folder = "/tmp/cournand_test_threads_" + std::to_string(getpid());
const crn::SceneFile scene = crn::read_scene("");

std::vector<crn::Instrument> tools()
{
    return {crn::read_instrument("shared/examples/instruments/amplatz_super_stiff.toml")};
}

crn::PictureSettings small_pictures(int size = 64)
{
    crn::PictureSettings settings;
    settings.size = size;
    settings.threads = 1;
    return settings;
}

std::unique_ptr<crn::LiveSession> live(const std::string &record, const crn::PictureSettings &pictures,
                                       bool keeps_all)
{
    return std::make_unique<crn::LiveSession>(scene, tools(), crn::entry_of(scene, 1, {}), record, pictures,
                                              std::vector<crn::RoomCommand>{}, crn::DeviceChoice{},
                                              keeps_all);
}

// Plays the same actions at the same ticks in each session, in the pace `counted`.
std::unique_ptr<crn::LiveSession> played(const std::string &record, const crn::PictureSettings &pictures,
                                         bool keeps_all)
{
    using crn::RoomAction;
    crn::PhysicsThread physics(live(record, pictures, keeps_all), crn::PhysicsPace::counted);
    const auto command = [&](crn::RoomCommand wanted) {
        physics.ask([wanted](crn::LiveSession &session) { session.command(wanted); });
    };
    const auto push = [&](std::int64_t um_per_s) {
        physics.ask([um_per_s](crn::LiveSession &session) {
            session.lead(std::vector<crn::HandSpeed>{{um_per_s, 0}});
        });
    };
    command({RoomAction::fluoro_rate, {3000, 0, 0}});
    command({RoomAction::fluoro_pedal, {1, 0, 0}});
    push(30'000);
    for (int i = 0; i < 20; ++i) physics.run_ticks(17);
    command({RoomAction::fluoro_pedal, {0, 0, 0}});
    command({RoomAction::angles, {20'000, 0, 0}});
    physics.ask([](crn::LiveSession &session) { session.drag(0, 5000, -3000); });
    push(0);
    physics.run_ticks(1600); // the motors come to rest
    command({RoomAction::acquire_pedal, {1, 0, 0}});
    physics.run_ticks(500);
    command({RoomAction::acquire_pedal, {0, 0, 0}});
    physics.run_ticks(60);
    return physics.stop();
}

nlohmann::ordered_json report(crn::LiveSession &session)
{
    const crn::SceneAnatomy &anatomy = session.anatomy();
    const crn::RunResult result = session.result(crn::TipPlaces(anatomy.bodies.vessels, anatomy.motion));
    return crn::report_of(result, "", tools(), "test", session.patient());
}

void pictures_never_change_the_report(void **)
{
    const std::unique_ptr<crn::LiveSession> all = played("", small_pictures(), true);
    all->finish();
    const std::unique_ptr<crn::LiveSession> some = played("", small_pictures(256), false);
    some->finish();
    const nlohmann::ordered_json one = report(*all), other = report(*some);
    assert_true(one["ticks"] == 2500);
    assert_true(one["room"]["total"]["pulses"].get<int>() > 15);
    if (one != other) fail_msg("%s\ndiffers from\n%s", one.dump(1).c_str(), other.dump(1).c_str());
    assert_int_equal(all->pictures().pictures().screen().store().runs().size(), 1);
}

void what_the_threads_record_replays_bit_for_bit(void **)
{
    const std::string path = folder + ".rec";
    const std::unique_ptr<crn::LiveSession> session = played(path, small_pictures(), false);
    session->finish();
    const crn::Recording recording = crn::read_recording(path);
    std::remove(path.c_str());
    assert_true(recording.is_complete);
    const crn::RecordingHeader &header = recording.header;
    crn::Device device(scene, header.tools, header.entry, header.rig);
    crn::Patient patient({}, header.tools);
    crn::ReplaySettings settings;
    settings.verifies = true;
    const crn::ReplayResult result = crn::replay_recording(device, recording, &patient, nullptr, settings);
    assert_false(result.first_difference_tick.has_value());
    assert_int_equal(result.ticks_compared, 2500);
    const nlohmann::ordered_json live_report = report(*session);
    assert_true(patient.room().dose().total().pulses ==
                live_report["room"]["total"]["pulses"].get<unsigned>());
}

// A drag of the mouse moves the hand by the wanted distance, but at most as fast as a real hand can move.
void a_drag_moves_the_tool_by_its_distance(void **)
{
    crn::PhysicsThread physics(live("", small_pictures(), true), crn::PhysicsPace::counted);
    physics.run_ticks(20);
    const double before_m = physics.state()->frame.tools[0].inserted_m;
    physics.ask([](crn::LiveSession &session) { session.drag(0, 10'000, 0); });
    physics.run_ticks(20);
    const double soon_m = physics.state()->frame.tools[0].inserted_m;
    assert_true(soon_m - before_m < 0.0045); // 0.2 m/s
    physics.run_ticks(100);
    const double after_m = physics.state()->frame.tools[0].inserted_m;
    if (std::abs(after_m - before_m - 0.010) > 0.0003)
        fail_msg("moved by %.3f mm", (after_m - before_m) * 1e3);
    physics.stop()->finish();
}

// The GUI window reads states and pictures, and requests actions, while the threads of physics and pictures
// work in real time. This test also runs under the thread sanitizer (make test-lab).
void the_window_may_ask_and_read_at_any_time(void **)
{
    crn::PhysicsThread physics(live("", small_pictures(), false), crn::PhysicsPace::real_time);
    physics.ask([](crn::LiveSession &session) {
        session.command({crn::RoomAction::fluoro_rate, {3000, 0, 0}});
        session.command({crn::RoomAction::fluoro_pedal, {1, 0, 0}});
    });
    std::uint32_t last_tick = 0;
    std::uint64_t last_number = 0;
    // The test ends after the given number of pictures, or, on a machine that draws no pictures, after the
    // given number of ticks.
    for (int i = 0; last_number < 8 && last_tick < 60'000; ++i) {
        const std::shared_ptr<const crn::SuiteState> state = physics.state();
        assert_true(state->tick >= last_tick);
        last_tick = state->tick;
        if (const auto picture = physics.live()) {
            assert_true(picture->number >= last_number);
            last_number = picture->number;
            assert_true(picture->grey.size() == 64 * 64);
        }
        if (i % 7 == 0) physics.ask([](crn::LiveSession &session) { session.drag(0, 50, 20); });
        if (i == 20) physics.show_reference({crn::ReferenceChoice::Kind::copy});
        std::this_thread::sleep_for(std::chrono::milliseconds(3));
    }
    assert_true(last_number >= 8);
    const std::unique_ptr<crn::LiveSession> session = physics.stop();
    session->finish();
    assert_true(session->fault().empty());
    assert_non_null(session->pictures().reference().get());
}

// A loop on the reference monitor must show the stored run, and a copy must show what the live monitor
// showed.
void the_reference_monitor_shows_copies_and_runs(void **)
{
    const std::unique_ptr<crn::LiveSession> session = played("", small_pictures(), true);
    crn::PictureThread &pictures = session->pictures();
    assert_null(pictures.reference().get());
    pictures.show_reference({crn::ReferenceChoice::Kind::copy});
    pictures.wait_until_idle();
    const auto copy = pictures.reference();
    assert_true(copy && copy->grey == pictures.live()->grey);
    pictures.show_reference({crn::ReferenceChoice::Kind::frame, 1, 2});
    pictures.wait_until_idle();
    const auto frame = pictures.reference();
    assert_int_equal(frame->status.run, 1);
    assert_int_equal(frame->status.frame, 2);
    assert_true(frame->grey == pictures.pictures().screen().store().find(1)->grey[2]);
    pictures.show_reference({});
    pictures.wait_until_idle();
    assert_true(pictures.reference()->grey.empty());
    session->finish();
}

// In the tested session a guidewire is at the first position, the second position has no tool, and a guiding
// catheter is in the session's table but not in use. The GUI window gets the tools in use at every moment,
// and the reason for every refusal.
void a_hand_exchanges_tools_and_hears_why_not(void **)
{
    const auto read = [](const char *name) {
        return crn::read_instrument("shared/examples/instruments/" + std::string(name) + ".toml");
    };
    crn::PictureSettings pictures = small_pictures();
    pictures.line = {1, 0};
    const std::vector<crn::Instrument> table = {read("amplatz_super_stiff"), read("guide_jl4_6f")};
    const std::uint32_t inserted_um[] = {20'000, 0};
    auto session = std::make_unique<crn::LiveSession>(scene, table, crn::entry_of(scene, 2, inserted_um), "",
                                                      pictures, std::vector<crn::RoomCommand>{});
    crn::PhysicsThread physics(std::move(session), crn::PhysicsPace::counted);
    const auto exchange = [&](std::uint8_t position, std::uint8_t tool) {
        physics.ask([=](crn::LiveSession &live) { live.exchange(position, tool); });
        physics.run_ticks(60);
        return physics.state();
    };
    physics.run_ticks(20);
    assert_true(physics.state()->line == (crn::LineNumbers{1, 0}));
    assert_true(exchange(1, 2)->line == (crn::LineNumbers{1, 2}));
    const auto refused = exchange(0, 0); // the wire leads, and lies in the patient
    assert_true(refused->line == (crn::LineNumbers{1, 2}));
    if (refused->notice.text.find("NO EXCHANGE - the device at this position is still in the patient") != 0)
        fail_msg("it says: %s", refused->notice.text.c_str());
    assert_true(exchange(1, 0)->line == (crn::LineNumbers{1, 0}));
    physics.stop()->finish();
}

// If no tool in use has a balloon, the inflator must report this, even though the session's table has a
// balloon catheter.
void the_inflator_needs_a_balloon_on_the_line(void **)
{
    crn::PictureSettings pictures = small_pictures();
    pictures.line = {1};
    std::vector<crn::Instrument> table = tools();
    table.push_back(crn::read_instrument("shared/examples/instruments/balloon_3x20.toml"));
    crn::PhysicsThread physics(std::make_unique<crn::LiveSession>(scene, table, crn::entry_of(scene, 1, {}),
                                                                  "", pictures,
                                                                  std::vector<crn::RoomCommand>{}),
                               crn::PhysicsPace::counted);
    physics.run_ticks(20);
    physics.ask([](crn::LiveSession &live) { live.inflate(100); });
    physics.run_ticks(500);
    assert_true(physics.state()->refused.text.find("NO BALLOON") == 0);
    assert_true(physics.state()->inflator_kPa == 0.0);
    physics.stop()->finish();
}

// If the disk is full or the folder no longer exists, the GUI window must get the reason.
void a_failure_in_the_physics_reaches_the_window(void **)
{
    crn::PhysicsThread physics(live("", small_pictures(), true), crn::PhysicsPace::counted);
    physics.ask([](crn::LiveSession &) { throw std::runtime_error("no space left on device"); });
    bool was_told = false;
    try {
        physics.run_ticks(10);
    } catch (const std::runtime_error &error) {
        was_told = std::string(error.what()) == "no space left on device";
    }
    assert_true(was_told);
}

} // namespace

int main()
{
    const CMUnitTest tests[] = {
        cmocka_unit_test(pictures_never_change_the_report),
        cmocka_unit_test(what_the_threads_record_replays_bit_for_bit),
        cmocka_unit_test(a_drag_moves_the_tool_by_its_distance),
        cmocka_unit_test(the_window_may_ask_and_read_at_any_time),
        cmocka_unit_test(the_reference_monitor_shows_copies_and_runs),
        cmocka_unit_test(a_hand_exchanges_tools_and_hears_why_not),
        cmocka_unit_test(the_inflator_needs_a_balloon_on_the_line),
        cmocka_unit_test(a_failure_in_the_physics_reaches_the_window),
    };
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
