// Tests that a session replays bit for bit at any speed and from any snapshot. A recording that was cut off
// must be readable up to its last complete chunk. A damaged recording must be refused, whichever byte is
// damaged.
#include <algorithm>
#include <csetjmp>
#include <cstdarg>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <string>
#include <unistd.h>
#include <vector>

#include "firmware/tests/reference/long_run.h"
#include "host/base/text.hpp"
#include "host/patient/contrast.hpp"
#include "host/session/replay.hpp"
#include "host/session/run.hpp"
#include "shared/wire/wire_frame.h"

// The header cmocka.h comes last, because its macros (fail, ...) would change other headers.
extern "C" {
#include <cmocka.h>
}

namespace
{

const std::string recording_path = "/tmp/cournand_test_" + std::to_string(getpid()) + ".rec";
const crn::SceneFile scene = crn::read_scene("");

struct RecordedSession {
    crn::RunResult result;
    std::vector<std::uint8_t> bytes;
};

RecordedSession record(const std::string &script,
                       const char *tool = "shared/examples/instruments/amplatz_super_stiff.toml")
{
    const std::vector<crn::Instrument> tools = {crn::read_instrument(tool)};
    const crn::Session session = crn::parse_session(script, "test");
    const crn_wire_entry entry = crn::entry_of(scene, tools.size(), session.inserted_um);
    crn::Device device(scene, tools, entry, crn::host_rig());
    const crn::RecordingHeader header = device.recording_header("test");
    RecordedSession recorded;
    {
        crn::Recorder recorder(recording_path, header);
        crn::Patient patient({}, tools);
        recorded.result = crn::run_session(device, patient, session, &recorder, nullptr, {});
    }
    recorded.bytes = crn::read_binary_file(recording_path);
    std::remove(recording_path.c_str());
    return recorded;
}

std::uint32_t word(const std::vector<std::uint8_t> &from, std::size_t place)
{
    return std::uint32_t{from[place]} | std::uint32_t{from[place + 1]} << 8 |
           std::uint32_t{from[place + 2]} << 16 | std::uint32_t{from[place + 3]} << 24;
}

const RecordedSession &session()
{
    static const RecordedSession recorded =
        record("fluoro on\nadvance 150 mm at 30 mm/s while rotate 1 turn\nc-arm LAO 20\nwait 1 s");
    return recorded;
}

crn::ReplayResult replay(const crn::Recording &recording, const crn::ReplaySettings &settings)
{
    const crn::RecordingHeader &header = recording.header;
    crn::Device device(scene, header.tools, header.entry, header.rig);
    return crn::replay_recording(device, recording, nullptr, nullptr, settings);
}

crn::ReplaySettings verify(const char *speed, double from_s)
{
    crn::ReplaySettings settings;
    settings.speed = *crn::replay_speed(speed);
    settings.verifies = true;
    settings.from_s = from_s;
    return settings;
}

void a_session_replays_bit_for_bit_at_any_speed(void **)
{
    const crn::Recording recording = crn::parse_recording(session().bytes, "test");
    assert_true(recording.is_complete);
    assert_int_equal(recording.ticks.size(), session().result.figures.ticks);
    for (const char *speed : {"fast", "paused", "50"}) {
        const crn::ReplayResult result = replay(recording, verify(speed, 0));
        assert_false(result.first_difference_tick.has_value());
        assert_true(result.hash == session().result.hash);
        assert_int_equal(result.ticks_compared, recording.ticks.size());
    }
}

void a_replay_from_a_snapshot_ends_in_the_same_state(void **)
{
    const crn::Recording recording = crn::parse_recording(session().bytes, "test");
    assert_int_equal(recording.snapshots.size(), 1);
    for (double from_s : {4.999, 5.0, 5.5}) {
        const crn::ReplayResult result = replay(recording, verify("fast", from_s));
        assert_false(result.first_difference_tick.has_value());
        assert_true(result.hash == session().result.hash);
    }
}

crn::Instrument catheter()
{
    return crn::read_instrument("shared/examples/instruments/pigtail_5f.toml");
}

// Makes a scene of one straight vessel around the tools.
crn::SceneAnatomy vessel()
{
    crn::VesselBranch branch;
    branch.name = "aorta";
    branch.flow_ml_s = 20.0;
    for (int i = 0; i <= 30; ++i) {
        branch.points_m.push_back({0.01 * i, 0.0, 0.0});
        branch.radii_m.push_back(0.008);
    }
    crn::SceneAnatomy anatomy;
    anatomy.bodies.vessels = {{branch}};
    return anatomy;
}

void a_replay_from_later_on_knows_what_was_injected_before(void **)
{
    const RecordedSession recorded =
        record("wait 1 s\ninject 8 ml at 4 ml/s\nadvance 60 mm at 60 mm/s\nwait 1 s",
               "shared/examples/instruments/pigtail_5f.toml");
    const crn::Recording recording = crn::parse_recording(recorded.bytes, "test");
    const crn::RecordingHeader &header = recording.header;
    std::vector<std::uint8_t> whole;
    for (double from_s : {0.0, 1.5, 2.9}) {
        crn::Device device(scene, header.tools, header.entry, header.rig);
        crn::Patient patient(vessel(), {catheter()});
        crn::replay_recording(device, recording, &patient, nullptr, verify("fast", from_s));
        const crn::ContrastFlow &flow = patient.contrast().flow();
        assert_true(flow.held_mg() > 100.0);
        if (whole.empty()) whole = flow.snapshot();
        if (flow.snapshot() != whole) fail_msg("from %.1f s: %.3f mg in the vessel", from_s, flow.held_mg());
    }
}

// If two premature beats are ordered at once, the second beat must be ordered a tick later. Only the two
// ticks with the commands for premature beats need more bytes in the recording.
void orders_are_recorded_in_their_ticks_and_replay(void **)
{
    const RecordedSession recorded = record("heart rate 120 /min\nbreath hold on\nwait 1 s");
    const crn::Recording recording = crn::parse_recording(recorded.bytes, "test");
    for (std::size_t i = 0; i < recording.ticks.size(); i++)
        assert_int_equal(recording.ticks[i].input.orders.items_count, i < 2);
    assert_int_equal(recording.ticks[0].input.orders.items[0].rhythm.value, 120);
    assert_int_equal(recording.ticks[1].input.orders.items[0].rhythm.action, CRN_WIRE_RHYTHM_BREATH_HOLD);
    assert_false(replay(recording, verify("fast", 0)).first_difference_tick.has_value());
    std::size_t at = 8;
    while (word(recorded.bytes, at) != 2) at += 12 + word(recorded.bytes, at + 4);
    assert_int_equal(word(recorded.bytes, at + 4), 8 + 500 * 31 + 2 * 4);
}

void side_holes_are_recorded(void **)
{
    const RecordedSession recorded = record("wait 10 ms", "shared/examples/instruments/pigtail_5f.toml");
    const crn::Recording recording = crn::parse_recording(recorded.bytes, "test");
    const std::vector<crn::SideHoles> expected = catheter().side_holes,
                                      &read = recording.header.tools[0].side_holes;
    assert_int_equal(read.size(), 1);
    assert_int_equal(read[0].count, expected[0].count);
    assert_true(read[0].arc_begin_m == expected[0].arc_begin_m && read[0].arc_end_m == expected[0].arc_end_m);
    assert_true(read[0].diameter_m == expected[0].diameter_m);
}

void a_changed_input_is_found_at_its_tick(void **)
{
    crn::Recording recording = crn::parse_recording(session().bytes, "test");
    recording.ticks[1234].input.hands[0].translation_counts += 40;
    const crn::ReplayResult result = replay(recording, verify("fast", 0));
    assert_true(result.first_difference_tick.has_value());
    assert_int_equal(*result.first_difference_tick, 1235);
}

void commands_to_the_room_are_recorded_with_their_ticks(void **)
{
    const crn::Recording recording = crn::parse_recording(session().bytes, "test");
    assert_int_equal(recording.commands.size(), 2);
    assert_int_equal(recording.commands[0].tick, 0);
    assert_true(recording.commands[0].command ==
                (crn::RoomCommand{crn::RoomAction::fluoro_pedal, {1, 0, 0}}));
    assert_int_equal(recording.commands[1].tick, 5200);
    assert_true(recording.commands[1].command == (crn::RoomCommand{crn::RoomAction::angles, {20000, 0, 0}}));
}

// Under the sanitizers, the tests try every tenth cut, and every tenth bit after the first chunks.
constexpr std::size_t every = 11 - REFERENCE_RUN(10);

// The test cuts the file at every length in its last part, and at many lengths before that part. The reader
// must either accept the cut file with fewer ticks, or refuse it as truncated.
void a_recording_cut_off_anywhere_keeps_its_whole_chunks(void **)
{
    const std::vector<std::uint8_t> &whole = session().bytes;
    std::size_t ticks_before = 0;
    const std::size_t last_part = whole.size() - 3000;
    for (std::size_t length = 0; length < whole.size();
         length += length < last_part ? std::min(977 * every, last_part - length) : every) {
        try {
            const crn::Recording recording = crn::parse_recording({whole.data(), length}, "cut");
            assert_false(recording.is_complete);
            assert_true(recording.ticks.size() >= ticks_before);
            ticks_before = recording.ticks.size();
        } catch (const crn::RecordingError &error) {
            assert_true(error.fault == crn::RecordingFault::truncated ||
                        error.fault == crn::RecordingFault::not_a_recording);
            assert_int_equal(ticks_before, 0);
        }
    }
    assert_int_equal(ticks_before, session().result.figures.ticks);
}

// If the length field of a chunk exceeds the length of every chunk of its kind, the file must count as
// damaged, and not as cut off.
void a_flipped_high_bit_of_a_length_is_no_cut(void **)
{
    std::vector<std::uint8_t> bytes = session().bytes;
    int chunks = 0;
    for (std::size_t at = 8; at < bytes.size(); at += 12 + word(bytes, at + 4), chunks++) {
        for (unsigned bit = 21; bit < 32; bit++) {
            std::uint8_t &byte = bytes[at + 4 + bit / 8];
            byte = static_cast<std::uint8_t>(byte ^ 1u << bit % 8);
            try {
                crn::parse_recording(bytes, "x.rec");
                fail_msg("bit %u of the length of chunk %d reads as a file that was cut off", bit, chunks);
            } catch (const crn::RecordingError &error) {
                assert_true(error.fault == crn::RecordingFault::damaged);
                assert_non_null(strstr(error.what(), "x.rec: is damaged: a chunk of kind"));
            }
            byte = static_cast<std::uint8_t>(byte ^ 1u << bit % 8);
        }
    }
    assert_true(chunks > 4);
}

// The test flips one bit at a time. A flipped bit in the length of a chunk may make the file look cut off;
// every other flip must be refused.
void a_flipped_bit_is_never_taken_for_a_complete_recording(void **)
{
    std::vector<std::uint8_t> bytes = session().bytes;
    for (std::size_t byte = 0; byte < bytes.size(); byte += byte < 400 ? 1 : 211 * every) {
        const auto bit = static_cast<std::uint8_t>(1u << (byte % 8));
        bytes[byte] ^= bit;
        try {
            assert_false(crn::parse_recording(bytes, "flipped").is_complete);
        } catch (const crn::RecordingError &) {
        }
        bytes[byte] ^= bit;
    }
}

void other_files_and_newer_versions_are_refused_by_name(void **)
{
    std::vector<std::uint8_t> bytes = session().bytes;
    bytes[7] = '7';
    try {
        crn::parse_recording(bytes, "x.rec");
        fail_msg("a newer version was accepted");
    } catch (const crn::RecordingError &error) {
        assert_true(error.fault == crn::RecordingFault::newer_version);
        assert_non_null(strstr(error.what(), "x.rec: is a recording of version '7'"));
    }
    bytes[0] = 'X';
    try {
        crn::parse_recording(bytes, "x.rec");
        fail_msg("another file was accepted");
    } catch (const crn::RecordingError &error) {
        assert_true(error.fault == crn::RecordingFault::not_a_recording);
    }
}

// In this test the ticks of the second chunk come first: the CRC of this chunk is correct, but its position
// is wrong.
void ticks_out_of_order_are_refused(void **)
{
    std::vector<std::uint8_t> bytes = session().bytes;
    std::size_t at = 8;
    while (word(bytes, at) != 2) at += 12 + word(bytes, at + 4);
    bytes[at + 8] = 1;
    const std::uint32_t covered = 8 + word(bytes, at + 4);
    const std::uint32_t crc = crn_wire_crc32(0, bytes.data() + at, covered);
    for (unsigned i = 0; i < 4; i++) bytes[at + covered + i] = static_cast<std::uint8_t>(crc >> (8 * i));
    try {
        crn::parse_recording(bytes, "x.rec");
        fail_msg("ticks out of order were accepted");
    } catch (const crn::RecordingError &error) {
        assert_true(error.fault == crn::RecordingFault::inconsistent);
    }
}

void a_recording_cannot_be_written_into_a_missing_folder(void **)
{
    try {
        crn::Recorder recorder("/does/not/exist/a.rec", {});
        fail_msg("a recording was opened in a missing folder");
    } catch (const crn::RecordingError &error) {
        assert_non_null(strstr(error.what(), "/does/not/exist/a.rec: cannot be written"));
    }
}

// An observer that makes pictures divides the batches of ticks; this division must not change the session.
class CountingSink final : public crn::SteadySink
{
  public:
    CountingSink() : SteadySink(15) {}
    void picture(const crn::SessionFrame &frame) override
    {
        assert_int_equal(frame.wire.tick, crn::picture_tick(count++, 15));
        assert_true(frame.wire.nodes.size() > 3);
    }
    std::uint32_t count = 0;
};

void pictures_do_not_change_the_session(void **)
{
    const crn::Recording recording = crn::parse_recording(session().bytes, "test");
    const crn::RecordingHeader &header = recording.header;
    crn::Device device(scene, header.tools, header.entry, header.rig);
    CountingSink sink;
    const crn::ReplayResult result =
        crn::replay_recording(device, recording, nullptr, &sink, verify("fast", 0));
    assert_true(result.hash == session().result.hash);
    assert_int_equal(sink.count, session().result.figures.ticks * 15 / 1000 + 1);
}

} // namespace

int main()
{
    const CMUnitTest tests[] = {
        cmocka_unit_test(a_session_replays_bit_for_bit_at_any_speed),
        cmocka_unit_test(a_replay_from_a_snapshot_ends_in_the_same_state),
        cmocka_unit_test(a_replay_from_later_on_knows_what_was_injected_before),
        cmocka_unit_test(orders_are_recorded_in_their_ticks_and_replay),
        cmocka_unit_test(side_holes_are_recorded),
        cmocka_unit_test(a_changed_input_is_found_at_its_tick),
        cmocka_unit_test(commands_to_the_room_are_recorded_with_their_ticks),
        cmocka_unit_test(a_recording_cut_off_anywhere_keeps_its_whole_chunks),
        cmocka_unit_test(a_flipped_high_bit_of_a_length_is_no_cut),
        cmocka_unit_test(a_flipped_bit_is_never_taken_for_a_complete_recording),
        cmocka_unit_test(other_files_and_newer_versions_are_refused_by_name),
        cmocka_unit_test(ticks_out_of_order_are_refused),
        cmocka_unit_test(a_recording_cannot_be_written_into_a_missing_folder),
        cmocka_unit_test(pictures_do_not_change_the_session),
    };
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
