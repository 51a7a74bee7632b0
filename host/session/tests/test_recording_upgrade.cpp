// Tests recordings of the previous protocol: such a recording must be refused, and the message must name that
// protocol and the command that converts the file. A converted recording must have the same ticks, commands
// and hashes, and must replay bit for bit. A damaged recording must be refused, and no file may be written. A
// program with protocol 4 wrote the file protocol_4.rec: 700 ticks of a guidewire, with commands to heart and
// breath, eight strut rings (one of them removed), and two commands to the X-ray room.
#include <algorithm>
#include <array>
#include <csetjmp>
#include <cstdarg>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <span>
#include <string>
#include <unistd.h>
#include <vector>

#include "firmware/core/core.h"
#include "host/base/pending_file.hpp"
#include "host/base/text.hpp"
#include "host/model/order_queue.hpp"
#include "host/session/recording_upgrade.hpp"
#include "host/session/replay.hpp"
#include "shared/wire/wire_frame.h"

// The header cmocka.h comes last, because its macros (fail, ...) would change other headers.
extern "C" {
#include <cmocka.h>
}

namespace
{

using crn::RecordingFault;
using Bytes = std::vector<std::uint8_t>;

constexpr std::uint64_t final_hash = 0xa051c11357cd75b6;
constexpr std::size_t ticks_count = 700, old_tick_bytes = 56;
constexpr std::uint32_t kind_head = 1, kind_ticks = 2, kind_hash = 3, kind_view = 5, kind_room = 8;

const Bytes &old_bytes()
{
    static const Bytes bytes = crn::read_binary_file("host/session/tests/protocol_4.rec");
    return bytes;
}

std::uint32_t word_at(const Bytes &from, std::size_t place)
{
    return std::uint32_t{from[place]} | std::uint32_t{from[place + 1]} << 8 |
           std::uint32_t{from[place + 2]} << 16 | std::uint32_t{from[place + 3]} << 24;
}

void put_word(Bytes &bytes, std::size_t place, std::uint32_t value)
{
    for (unsigned i = 0; i < 4; i++) bytes[place + i] = static_cast<std::uint8_t>(value >> 8 * i);
}

std::size_t chunk_of(const Bytes &bytes, std::uint32_t kind)
{
    std::size_t at = 8;
    while (word_at(bytes, at) != kind) at += 12 + word_at(bytes, at + 4);
    return at;
}

// Corrects the checksum of a chunk that the test has changed.
void seal(Bytes &bytes, std::size_t at)
{
    const std::uint32_t covered = 8 + word_at(bytes, at + 4);
    put_word(bytes, at + covered, crn_wire_crc32(0, bytes.data() + at, covered));
}

crn::Recording upgraded(const Bytes &bytes)
{
    return crn::parse_recording(crn::upgraded_recording(bytes, "old.rec"), "new.rec");
}

void expect_refusal(const Bytes &bytes, RecordingFault fault, const char *text)
{
    try {
        crn::upgraded_recording(bytes, "old.rec");
        fail_msg("converted, instead of: %s", text);
    } catch (const crn::RecordingError &error) {
        if (!strstr(error.what(), text)) fail_msg("'%s' does not say '%s'", error.what(), text);
        assert_int_equal(static_cast<int>(error.fault), static_cast<int>(fault));
        assert_non_null(strstr(error.what(), "old.rec: "));
    }
}

// Plays a converted recording to its end. The old files are those of core versions 15 and 17. A later core
// computes other hashes from the same inputs, so there the replay must end as a device ends that gets these
// inputs one by one. That the inputs are those of the old file is the subject of the tests below.
crn::ReplayResult play(const crn::Recording &recording, std::uint32_t core_version = 15)
{
    const crn::RecordingHeader &header = recording.header;
    assert_int_equal(header.core_version, core_version);
    crn::Device device(crn::read_scene(""), header.tools, header.entry, header.rig, {}, header.line);
    crn::ReplaySettings settings;
    settings.verifies = device.identity().core_version == header.core_version;
    const crn::ReplayResult result = crn::replay_recording(device, recording, nullptr, nullptr, settings);
    if (result.first_difference_tick) fail_msg("%s", result.difference.c_str());
    crn::Device other(crn::read_scene(""), header.tools, header.entry, header.rig, {}, header.line);
    for (const crn::RecordedTick &tick : recording.ticks) other.step(std::span(&tick.input, 1), false);
    assert_true(result.hash == other.read_hash64().hash);
    assert_int_equal(result.tick, recording.ticks.size());
    assert_true(settings.verifies == (result.hash == recording.hashes.back().hash));
    return result;
}

void opening_an_old_recording_names_the_command_that_converts_it(void **)
{
    for (const char *begin :
         {"CRN-REC5", "CRN-REC4", "CRN-REC3", "CRN-REC2", "\x53\x45\x4c\x44REC3", "\x53\x45\x4c\x44REC2"}) {
        Bytes bytes = old_bytes();
        std::copy_n(begin, 8, bytes.begin());
        try {
            crn::parse_recording(bytes, "a/old.rec");
            fail_msg("an old recording was read");
        } catch (const crn::RecordingError &error) {
            assert_true(error.fault == RecordingFault::older_version);
            assert_non_null(strstr(error.what(), "a/old.rec: is a recording of version '"));
            assert_non_null(strstr(error.what(), "cournand replay --upgrade a/old.rec -o NEW.rec"));
        }
    }
}

void expect_elastic_tools(const crn::Recording &recording)
{
    for (const crn::Instrument &tool : recording.header.tools) {
        const crn_wire_instrument &table = tool.table;
        assert_int_equal(table.material_kind, 0);
        assert_int_equal(table.yield_strain_micro + table.core_modulus_MPa, 0);
        assert_int_equal(table.hardening_milli + table.unload_milli + table.limit_milli, 0);
    }
}

void a_converted_recording_is_played(void **)
{
    const crn::Recording recording = upgraded(old_bytes());
    assert_true(recording.is_complete);
    assert_int_equal(recording.ticks.size(), ticks_count);
    expect_elastic_tools(recording);
    assert_true(recording.hashes.back().hash == final_hash);
    play(recording);
    assert_int_equal(recording.commands.size(), 2);
    assert_int_equal(recording.commands[1].tick, 300);
}

// In protocol 4, every tick had 26 bytes of fields for commands. In the present protocol, a tick without
// commands has one byte instead of these fields: the number of its commands.
void what_was_nothing_costs_nothing_any_more(void **)
{
    const Bytes bytes = crn::upgraded_recording(old_bytes(), "old.rec");
    std::size_t orders_bytes = 0;
    for (const crn::RecordedTick &tick : crn::parse_recording(bytes, "new.rec").ticks)
        for (const crn_wire_order &order : crn::orders_of(tick.input))
            orders_bytes += order.kind == CRN_WIRE_KIND_strut ? 19 : 4;
    assert_int_equal(orders_bytes, 9 * 19 + 2 * 4);
    const std::size_t added_to_header = 2 * 4 + 1 + 21; // two lengths of its tool, the empty line, a material
    assert_int_equal(old_bytes().size() + added_to_header - bytes.size(),
                     ticks_count * (old_tick_bytes - 31) - orders_bytes);
}

void every_order_is_in_its_tick(void **)
{
    const crn::Recording recording = upgraded(old_bytes());
    for (std::size_t i = 0; i < ticks_count; i++) {
        const crn_wire_tick_input &input = recording.ticks[i].input;
        const std::size_t wanted = (i >= 5 && i < 13) + (i == 10) + (i == 450) + (i == 600);
        assert_int_equal(input.orders.items_count, wanted);
        assert_int_equal(input.hands[0].translation_counts, 60 * i);
        assert_int_equal(input.syringe_counts, -static_cast<int>(i));
        assert_int_equal(input.inflator_raw, std::min<std::size_t>(2 * i, 800));
    }
    const crn_wire_order_list &both = recording.ticks[10].input.orders;
    assert_int_equal(crn::order_of(both, CRN_WIRE_KIND_rhythm)->rhythm.value, 140);
    const crn_wire_strut &ring = crn::order_of(both, CRN_WIRE_KIND_strut)->strut;
    assert_true(ring.number == 6 && ring.joined == 1 && ring.y_um == 50000 && ring.z_um == -700);
    assert_true(ring.inside_um == 900 && ring.thickness_um == 80);
    const crn_wire_strut &gone = recording.ticks[600].input.orders.items[0].strut;
    assert_true(gone.number == 3 && gone.inside_um == 0);
}

// In tick 7, which also has a command for a strut ring, the test writes a command to hold a lesion open
// (scaffold) into the fields that protocol 4 had for such commands.
void a_scaffold_becomes_an_order(void **)
{
    Bytes bytes = old_bytes();
    const std::size_t at = chunk_of(bytes, kind_ticks);
    const std::size_t fields = at + 8 + 8 + 7 * old_tick_bytes + 2 + 8 + 12 + 3;
    const std::uint8_t scaffold[5] = {2, 4, 12, 0xfe, 0x7f};
    std::copy_n(scaffold, 5, bytes.begin() + static_cast<std::ptrdiff_t>(fields));
    seal(bytes, at);
    const crn::Recording recording = upgraded(bytes);
    const crn_wire_order_list &orders = recording.ticks[7].input.orders;
    assert_int_equal(orders.items_count, 2);
    const crn_wire_scaffold &hold = crn::order_of(orders, CRN_WIRE_KIND_scaffold)->scaffold;
    assert_true(hold.lesion == 2 && hold.first == 4 && hold.last == 12 && hold.open_q15 == 0x7ffe);
}

// The test replaces each command to the X-ray room by a chunk of the kind VIEW, as in version 2. A chunk of
// the kind VIEW contains the tick, the state of fluoroscopy, whether the table follows the tip, both angles,
// table and field.
Bytes with_views()
{
    Bytes bytes(old_bytes().begin(), old_bytes().begin() + 8);
    bytes[7] = '2';
    const Bytes &now = old_bytes();
    for (std::size_t at = 8, size; at < now.size(); at += size) {
        size = 12 + word_at(now, at + 4);
        if (word_at(now, at) != kind_room) {
            bytes.insert(bytes.end(), now.begin() + static_cast<std::ptrdiff_t>(at),
                         now.begin() + static_cast<std::ptrdiff_t>(at + size));
            continue;
        }
        const std::uint32_t tick = word_at(now, at + 8);
        const std::size_t begin = bytes.size();
        bytes.resize(begin + 8 + 30 + 4);
        const std::array<std::uint32_t, 3> head = {kind_view, 30, tick};
        const std::array<std::uint32_t, 6> view = {tick > 0 ? 20000u : 0u, 0, 1000, 2000, 3000, 320000};
        for (std::size_t i = 0; i < head.size(); i++) put_word(bytes, begin + 4 * i, head[i]);
        bytes[begin + 12] = bytes[begin + 13] = 1;
        for (std::size_t i = 0; i < view.size(); i++) put_word(bytes, begin + 14 + 4 * i, view[i]);
        seal(bytes, begin);
    }
    return bytes;
}

void views_of_version_2_become_commands(void **)
{
    const crn::Recording recording = upgraded(with_views());
    assert_true(recording.is_complete);
    // After the conversion, the expected commands are angles, field, table, follow and pedal, and then the
    // changed angles.
    assert_int_equal(recording.commands.size(), 6);
    assert_true(recording.commands[2].command ==
                (crn::RoomCommand{crn::RoomAction::table, {1000, 2000, 3000}}));
    assert_true(recording.commands[5].command == (crn::RoomCommand{crn::RoomAction::angles, {20000, 0, 0}}));
    play(recording);
}

void a_recording_from_before_the_renaming_is_converted(void **)
{
    Bytes bytes = old_bytes();
    const std::uint8_t earlier[4] = {0x53, 0x45, 0x4c, 0x44};
    std::copy_n(earlier, 4, bytes.begin());
    assert_true(crn::upgraded_recording(bytes, "old.rec") == crn::upgraded_recording(old_bytes(), "old.rec"));
}

void what_was_cut_off_stays_cut_off(void **)
{
    Bytes bytes = old_bytes();
    bytes.resize(bytes.size() - 10); // into its end
    assert_false(upgraded(bytes).is_complete);
    assert_int_equal(upgraded(bytes).ticks.size(), ticks_count);
    bytes.resize(bytes.size() - 20); // into its second chunk of ticks
    assert_int_equal(upgraded(bytes).ticks.size(), 500);
    bytes.resize(chunk_of(old_bytes(), kind_ticks) + 100);
    assert_int_equal(upgraded(bytes).ticks.size(), 0);
}

// A program with protocol 5 wrote the file protocol_5.rec: about 0.9 s of a session with a guidewire and a
// catheter.
const Bytes &protocol_5_bytes()
{
    static const Bytes bytes = crn::read_binary_file("host/session/tests/protocol_5.rec");
    return bytes;
}

void a_recording_of_protocol_5_is_played(void **)
{
    const crn::Recording recording = upgraded(protocol_5_bytes());
    assert_true(recording.is_complete);
    assert_int_equal(recording.header.tools.size(), 2);
    assert_true(recording.header.line.empty());
    assert_int_equal(recording.header.tools[1].table.whole_um, 0);
    assert_true(recording.ticks.size() > 900);
    play(recording);
}

// A program with protocol 6 wrote the file protocol_6.rec: about 1.1 s of a session whose table has a
// guidewire, a balloon and a guiding catheter. The balloon is put on the line after 16 ms.
const Bytes &protocol_6_bytes()
{
    static const Bytes bytes = crn::read_binary_file("host/session/tests/protocol_6.rec");
    return bytes;
}

void a_recording_of_protocol_6_is_played(void **)
{
    const crn::Recording recording = upgraded(protocol_6_bytes());
    assert_true(recording.is_complete);
    const crn::RecordingHeader &header = recording.header;
    assert_int_equal(header.tools.size(), 3);
    assert_true(header.line == (crn::LineNumbers{1, 0, 3}));
    assert_int_equal(header.tools[1].table.balloon_count, 7);
    assert_int_equal(header.tools[1].table.balloon[2].pressure_kPa, 800);
    assert_int_equal(header.tools[1].table.whole_um, 1400000);
    assert_int_equal(header.tools[2].table.knots[1].radius_inner_um, 900);
    assert_true(header.tools[0].layers.size() >= 4);
    expect_elastic_tools(recording);
    assert_int_equal(recording.ticks.size(), 1116);
    play(recording, 17);
}

// Converts a present snapshot to protocol 6, without the sets of the tools and the ways of the walls before
// the core's nodes.
constexpr std::ptrdiff_t nodes_bytes = 388 * 84,
                         sets_bytes = 4 + CRN_TOOL_MAX * CRN_SET_CELL_MAX * 8 + 4 + 192 * 16;

Bytes snapshot_of_protocol_6(const Bytes &now)
{
    Bytes old(now.begin(), now.end() - nodes_bytes - sets_bytes);
    old[0] = 4;
    old.insert(old.end(), now.end() - nodes_bytes, now.end());
    return old;
}

// Converts a snapshot of protocol 6 to protocol 5, without the release of each tool and without the five
// words about the tools in use before the core's nodes.
Bytes snapshot_of_protocol_5(const Bytes &now)
{
    const Bytes newer = snapshot_of_protocol_6(now);
    constexpr std::ptrdiff_t exchange = 5 * 4;
    Bytes old(newer.begin(), newer.begin() + 12);
    old[0] = 3;
    for (std::ptrdiff_t k = 0; k < 3; k++)
        old.insert(old.end(), newer.begin() + 12 + 120 * k, newer.begin() + 12 + 120 * k + 108);
    old.insert(old.end(), newer.begin() + 12 + 120 * 3, newer.end() - nodes_bytes - exchange);
    old.insert(old.end(), newer.end() - nodes_bytes, newer.end());
    return old;
}

// Plays an old recording up to its second chunk of ticks, puts an old snapshot of that state into the file,
// and compares the converted snapshot with the state.
void expect_snapshot_converted(const Bytes &old, Bytes (*as_old)(const Bytes &now))
{
    const crn::Recording whole = upgraded(old);
    const crn::RecordingHeader &header = whole.header;
    crn::Device device(crn::read_scene(""), header.tools, header.entry, header.rig, {}, header.line);
    std::vector<crn_wire_tick_input> inputs;
    const std::size_t at = chunk_of(old, kind_ticks), first = word_at(old, at + 12);
    for (std::size_t i = 0; i < first; i++) {
        inputs.push_back(whole.ticks[i].input);
        if (inputs.size() < 50 && i + 1 < first) continue;
        device.step(inputs, false);
        inputs.clear();
    }
    const Bytes now = device.read_snapshot(), snapshot = as_old(now);
    constexpr std::uint32_t kind_snapshot = 4;
    Bytes chunk(8 + 4 + snapshot.size() + 4);
    put_word(chunk, 0, kind_snapshot);
    put_word(chunk, 4, static_cast<std::uint32_t>(4 + snapshot.size()));
    put_word(chunk, 8, static_cast<std::uint32_t>(first));
    std::copy(snapshot.begin(), snapshot.end(), chunk.begin() + 12);
    seal(chunk, 0);
    Bytes bytes = old;
    bytes.insert(bytes.begin() + static_cast<std::ptrdiff_t>(at + 12 + word_at(old, at + 4)), chunk.begin(),
                 chunk.end());
    const crn::Recording recording = upgraded(bytes);
    assert_int_equal(recording.snapshots.size(), 1);
    assert_true(recording.snapshots[0].bytes == now);
    device.restore(recording.snapshots[0].bytes);
}

void snapshots_of_old_protocols_become_the_present_one(void **)
{
    expect_snapshot_converted(protocol_5_bytes(), snapshot_of_protocol_5);
    expect_snapshot_converted(protocol_6_bytes(), snapshot_of_protocol_6);
}

// The line of a recording of protocol 6 follows its tools. A line that cannot be, and a tool that is cut off,
// are refused.
void damaged_heads_of_protocol_6_are_refused(void **)
{
    const Bytes &good = protocol_6_bytes();
    const std::size_t head = chunk_of(good, kind_head), end = head + 8 + word_at(good, head + 4);
    const std::array<std::uint8_t, 4> line = {3, 1, 0, 3};
    const auto place =
        std::find_end(good.begin() + static_cast<std::ptrdiff_t>(head),
                      good.begin() + static_cast<std::ptrdiff_t>(end), line.begin(), line.end());
    assert_true(place != good.begin() + static_cast<std::ptrdiff_t>(end));
    const std::size_t at = static_cast<std::size_t>(place - good.begin());
    for (const std::uint8_t count : {std::uint8_t{4}, std::uint8_t{255}}) {
        Bytes bytes = good;
        bytes[at] = count;
        seal(bytes, head);
        expect_refusal(bytes, RecordingFault::inconsistent, "a line that cannot be");
    }
    Bytes bytes = good;
    bytes[at + 1] = 9; // a tool that is not in the table
    seal(bytes, head);
    expect_refusal(bytes, RecordingFault::inconsistent, "a line that cannot be");
    bytes = good;
    const std::size_t tools_at = head + 8 + 4 + 8 + 8 + 2 + word_at(good, head + 8 + 4 + 8 + 8) % 65536 + 2 +
                                 std::strlen("exchange.session");
    assert_int_equal(bytes[tools_at], 3);
    bytes[tools_at] = 8; // tools that do not exist
    seal(bytes, head);
    expect_refusal(bytes, RecordingFault::inconsistent, "a tool is cut off");
    bytes[tools_at] = 9;
    seal(bytes, head);
    expect_refusal(bytes, RecordingFault::inconsistent, "it has 9 tools");
}

// The test flips one bit at a time, and tries chunks with correct checksums and wrong contents.
void damage_is_refused(void **)
{
    Bytes bytes = old_bytes();
    for (std::size_t byte = 8; byte < bytes.size(); byte += byte < 200 ? 1 : 397) {
        const auto bit = static_cast<std::uint8_t>(1u << (byte % 8));
        bytes[byte] ^= bit;
        try {
            assert_false(upgraded(bytes).is_complete);
        } catch (const crn::RecordingError &) {
        }
        bytes[byte] ^= bit;
    }
    const std::size_t ticks = chunk_of(bytes, kind_ticks), hash = chunk_of(bytes, kind_hash);
    bytes[hash + 8 + 4] ^= 1;
    expect_refusal(bytes, RecordingFault::damaged, "the checksum of a chunk does not match");
    bytes[hash + 8 + 4] ^= 1;
    bytes.push_back(0);
    expect_refusal(bytes, RecordingFault::damaged, "has bytes behind its end");
    bytes.pop_back();
    put_word(bytes, ticks + 8, 1);
    seal(bytes, ticks);
    expect_refusal(bytes, RecordingFault::inconsistent, "ticks are missing or doubled");
    put_word(bytes, ticks + 8, 0);
    bytes[ticks + 16] = 2;
    seal(bytes, ticks);
    expect_refusal(bytes, RecordingFault::inconsistent, "another number of hands than tools");
}

void other_versions_and_schemas_are_refused_by_name(void **)
{
    Bytes bytes = old_bytes();
    const std::size_t head = chunk_of(bytes, kind_head);
    bytes[head + 8 + 4] ^= 1;
    seal(bytes, head);
    expect_refusal(bytes, RecordingFault::newer_version,
                   "was written with another wire schema (file fe912b8c91b717ba");
    bytes = old_bytes();
    bytes[7] = '7';
    expect_refusal(bytes, RecordingFault::newer_version, "is a recording of version '7'");
    bytes[7] = '1';
    expect_refusal(bytes, RecordingFault::newer_version, "is a recording of version '1'");
    bytes[0] = 'X';
    expect_refusal(bytes, RecordingFault::not_a_recording, "is not a Cournand recording");
    expect_refusal(crn::upgraded_recording(old_bytes(), "x"), RecordingFault::newer_version,
                   "has this program's version already");
    expect_refusal({}, RecordingFault::not_a_recording, "is not a Cournand recording");
}

// The upgraded file must be either complete or absent, and the old file must not change.
void a_file_is_converted_whole_or_not_at_all(void **)
{
    const std::filesystem::path folder =
        std::filesystem::temp_directory_path() / ("cournand_upgrade_" + std::to_string(getpid()));
    std::filesystem::create_directory(folder);
    const std::string from = folder / "old.rec", to = folder / "new.rec";
    const auto put = [&](const Bytes &bytes) {
        crn::write_whole_file(from, {reinterpret_cast<const char *>(bytes.data()), bytes.size()});
    };
    Bytes damaged = old_bytes();
    damaged[damaged.size() / 2] ^= 1;
    put(damaged);
    try {
        crn::upgrade_recording(from, to);
        fail_msg("a damaged recording was converted");
    } catch (const crn::RecordingError &error) {
        assert_non_null(strstr(error.what(), from.c_str()));
    }
    assert_int_equal(std::distance(std::filesystem::directory_iterator(folder), {}), 1);
    put(old_bytes());
    assert_int_equal(crn::upgrade_recording(from, to).ticks.size(), ticks_count);
    play(crn::read_recording(to));
    assert_true(crn::read_binary_file(from) == old_bytes());
    assert_int_equal(std::distance(std::filesystem::directory_iterator(folder), {}), 2);
    std::filesystem::remove_all(folder);
}

} // namespace

int main()
{
    const CMUnitTest tests[] = {
        cmocka_unit_test(opening_an_old_recording_names_the_command_that_converts_it),
        cmocka_unit_test(a_converted_recording_is_played),
        cmocka_unit_test(what_was_nothing_costs_nothing_any_more),
        cmocka_unit_test(every_order_is_in_its_tick),
        cmocka_unit_test(a_scaffold_becomes_an_order),
        cmocka_unit_test(views_of_version_2_become_commands),
        cmocka_unit_test(a_recording_from_before_the_renaming_is_converted),
        cmocka_unit_test(what_was_cut_off_stays_cut_off),
        cmocka_unit_test(a_recording_of_protocol_5_is_played),
        cmocka_unit_test(a_recording_of_protocol_6_is_played),
        cmocka_unit_test(snapshots_of_old_protocols_become_the_present_one),
        cmocka_unit_test(damaged_heads_of_protocol_6_are_refused),
        cmocka_unit_test(damage_is_refused),
        cmocka_unit_test(other_versions_and_schemas_are_refused_by_name),
        cmocka_unit_test(a_file_is_converted_whole_or_not_at_all),
    };
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
