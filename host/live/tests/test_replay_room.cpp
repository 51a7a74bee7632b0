// Tests the replay with a scrub bar. Any moment can be shown from any angle and in any order. The same view
// must give the same picture, bit for bit, whether it was reached from a snapshot or tick by tick.
#include <algorithm>
#include <csetjmp>
#include <cstdarg>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <string>
#include <unistd.h>
#include <vector>

#include "host/live/replay_thread.hpp"
#include "host/script/session.hpp"
#include "host/session/run.hpp"

// The header cmocka.h comes last, because its macros (fail, ...) would change other headers.
extern "C" {
#include <cmocka.h>
}

namespace
{

const std::string replay_path = "/tmp/cournand_test_replay_room_" + std::to_string(getpid()) + ".rec";
constexpr char script[] =
    "begin inserted 60 mm\nview lateral\nfluoro on\nadvance 80 mm at 20 mm/s\nfluoro off\n"
    "rotate 90 deg\nview ap\nwait 2 s\ncine on\nwithdraw 40 mm at 20 mm/s\ncine off\n"
    "wait 1 s\n";

void make_recording()
{
    const crn::SceneFile scene = crn::read_scene("");
    const std::vector<crn::Instrument> tools = {
        crn::read_instrument("shared/examples/instruments/amplatz_super_stiff.toml")};
    const crn::Session session = crn::parse_session(script, "test");
    const crn_wire_entry entry = crn::entry_of(scene, tools.size(), session.inserted_um);
    crn::Device device(scene, tools, entry, crn::host_rig());
    crn::Recorder recorder(replay_path, {device.identity().core_version,
                                         device.identity().schema_hash,
                                         0,
                                         0,
                                         "",
                                         "test",
                                         tools,
                                         {},
                                         entry,
                                         crn::host_rig(),
                                         {}});
    crn::Patient patient({}, tools);
    crn::run_session(device, patient, session, &recorder, nullptr, {});
}

crn::PictureSettings replay_pictures()
{
    crn::PictureSettings settings;
    settings.size = 64;
    settings.threads = 1;
    return settings;
}

crn::ReplayAsk moment(std::uint32_t tick, double primary_deg = 0.0)
{
    crn::CArm carm;
    carm.primary_deg = primary_deg;
    carm.field_m = 0.2;
    return {tick, carm};
}

void the_same_view_twice_is_the_same_picture(void **)
{
    crn::ReplayRoom room(replay_path, "", replay_pictures());
    assert_true(room.ticks() > 8000);
    // The test first uses only the recording's snapshots, without a track (the list of prepared states). The
    // test then goes forwards and back in time, and also uses the snapshots of the track (the list of
    // prepared states).
    const crn::ReplayPicture first = room.picture(moment(6300, 30.0));
    room.picture(moment(7000));
    assert_true(room.picture(moment(6300, 30.0)).grey == first.grey);
    room.picture(moment(150));
    assert_true(room.picture(moment(6300, 30.0)).grey == first.grey);
    while (room.prepare(500)) {
    }
    assert_int_equal(room.prepared(), room.ticks());
    const crn::ReplayPicture again = room.picture(moment(6300, 30.0));
    assert_true(again.grey == first.grey && again.is_prepared && !first.is_prepared);
    assert_true(room.picture(moment(6300, -30.0)).grey != first.grey);
    assert_true(room.picture(moment(2000, 30.0)).grey != first.grey);
}

void a_moment_has_the_tools_of_that_moment(void **)
{
    crn::ReplayRoom room(replay_path, "", replay_pictures());
    const double begin_mm = room.picture(moment(0)).frame.tools.front().inserted_m * 1e3;
    const double inside_mm = room.picture(moment(5000)).frame.tools.front().inserted_m * 1e3;
    const double end_mm = room.picture(moment(room.ticks())).frame.tools.front().inserted_m * 1e3;
    if (std::abs(begin_mm - 60.0) > 1.0 || std::abs(inside_mm - 140.0) > 1.0 ||
        std::abs(end_mm - 100.0) > 1.0)
        fail_msg("%.1f, %.1f, %.1f mm, expected 60, 140, 100", begin_mm, inside_mm, end_mm);
    assert_true(room.picture(moment(room.ticks() + 5000)).frame.wire.tick == room.ticks()); // held at the end
}

// Even at a moment for which the recording or the track has a snapshot, the readings must be those of that
// moment's own tick.
void a_moment_has_the_readings_of_its_own_tick(void **)
{
    const crn::Recording recording = crn::read_recording(replay_path);
    crn::ReplayRoom room(replay_path, "", replay_pictures());
    while (room.prepare(500)) {
    }
    for (const std::uint32_t tick : {5000u, 6000u, 1u}) {
        room.picture(moment(7000));
        const crn_wire_tick_state state = room.picture(moment(tick)).state;
        assert_int_equal(state.tick, tick);
        assert_int_equal(state.hash_lane0, recording.ticks[tick - 1].hash_lane[0]);
    }
    assert_int_equal(room.picture(moment(0)).state.tick, 0);
    assert_true(room.picture(moment(0)).line == (crn::LineNumbers{1}));
}

// If no angle is requested, a picture must have the C-arm's angle in the session, as soon as the track (the
// list of prepared states) contains this angle.
void the_c_arm_is_where_it_was(void **)
{
    crn::ReplayRoom room(replay_path, "", replay_pictures());
    while (room.prepare(500)) {
    }
    assert_true(std::abs(room.picture({3000, {}}).carm.primary_deg - 90.0) < 0.01);
    assert_true(std::abs(room.picture({room.ticks(), {}}).carm.primary_deg) < 0.01);
}

void the_time_line_marks_pedals(void **)
{
    const crn::ReplayRoom room(replay_path, "", replay_pictures());
    const std::vector<crn::ReplayMark> marks = room.marks();
    assert_int_equal(marks.size(), 2);
    assert_true(marks[0].kind == crn::ReplayMark::Kind::fluoro &&
                marks[1].kind == crn::ReplayMark::Kind::acquire);
    assert_true(marks[0].end > marks[0].begin + 3000 && marks[1].end < room.ticks());
}

void the_threads_show_what_was_asked_last(void **)
{
    crn::ReplayThread replay(std::make_unique<crn::ReplayRoom>(replay_path, "", replay_pictures()));
    for (std::uint32_t tick = 0; tick <= 8000; tick += 400) replay.ask(moment(tick));
    while (!replay.latest() || replay.latest()->picture.frame.wire.tick != 8000)
        std::this_thread::sleep_for(std::chrono::milliseconds(2));
    assert_true(replay.latest()->trouble.empty());
    crn::ReplayRoom alone(replay_path, "", replay_pictures());
    assert_true(replay.latest()->picture.grey == alone.picture(moment(8000)).grey);
}

} // namespace

int main()
{
    make_recording();
    const CMUnitTest tests[] = {
        cmocka_unit_test(the_same_view_twice_is_the_same_picture),
        cmocka_unit_test(a_moment_has_the_tools_of_that_moment),
        cmocka_unit_test(a_moment_has_the_readings_of_its_own_tick),
        cmocka_unit_test(the_c_arm_is_where_it_was),
        cmocka_unit_test(the_time_line_marks_pedals),
        cmocka_unit_test(the_threads_show_what_was_asked_last),
    };
    const int failed = cmocka_run_group_tests(tests, nullptr, nullptr);
    std::remove(replay_path.c_str());
    return failed;
}
