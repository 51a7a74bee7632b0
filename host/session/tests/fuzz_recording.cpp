// This fuzz target reads files with arbitrary bytes as recordings. The fuzz target tests every input
// unchanged, and then with corrected checksums and schema hash, so that the fuzzer gets past the checks of
// these values. The fuzz target reads every input as a recording of this version, and as a recording of the
// previous version that must be converted. An accepted recording must have the properties that recording.hpp
// promises, and a refusal must have a message.
#include "host/session/recording_chunks.hpp"
#include "host/session/recording_format.hpp"
#include "host/session/recording_upgrade.hpp"
#include "shared/wire/wire_frame.h"
#include <algorithm>
#include <cstdlib>
#include <vector>

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t *bytes, std::size_t count);
extern "C" std::size_t fuzz_seed(unsigned index, std::uint8_t *bytes, std::size_t capacity);

namespace
{

using namespace crn;
using namespace crn::recording_format;

void promise(bool kept)
{
    if (!kept) std::abort();
}

void walk(const Recording &recording)
{
    const std::size_t tools = recording.header.tools.size();
    const std::size_t ticks = recording.ticks.size();
    promise(tools >= 1 && tools <= CRN_WIRE_TABLE_MAX &&
            recording.header.entry.inserted_um_count == recording.header.positions());
    for (const Instrument &tool : recording.header.tools)
        promise(tool.table.knots_count <= CRN_WIRE_MAX_instrument_knots && tool.layers.size() <= layers_max);
    for (const RecordedTick &tick : recording.ticks)
        promise(tick.input.hands_count == recording.header.positions());
    for (const RecordedSnapshot &snapshot : recording.snapshots) promise(snapshot.tick <= ticks);
    for (std::size_t i = 0; i < recording.commands.size(); i++) {
        promise(refusal(recording.commands[i].command).empty());
        promise(i == 0 || recording.commands[i - 1].tick <= recording.commands[i].tick);
    }
    const auto last = static_cast<std::uint32_t>(ticks);
    const RecordedSnapshot *before = recording.snapshot_before(last);
    promise((before == nullptr) == recording.snapshots.empty());
    if (recording.is_complete) promise(!recording.hashes.empty() && recording.hashes.back().tick == ticks);
}

void offer(const std::vector<std::uint8_t> &bytes)
{
    static const std::string name = "fuzz";
    try {
        walk(parse_recording(bytes, name));
    } catch (const RecordingError &error) {
        promise(*error.what() != '\0');
    }
}

void convert(const std::vector<std::uint8_t> &bytes)
{
    static const std::string name = "fuzz";
    try {
        walk(parse_recording(upgraded_recording(bytes, name), name)); // the converted recording is readable
    } catch (const RecordingError &error) {
        promise(*error.what() != '\0');
    }
}

void put(std::uint8_t *place, std::uint64_t value, int bytes)
{
    for (int i = 0; i < bytes; i++) place[i] = static_cast<std::uint8_t>(value >> (8 * i));
}

std::uint64_t schema_of(char version)
{
    if (version == magic[7]) return crn_wire_schema_hash();
    if (version == protocol_6_version) return schema_of_protocol_6;
    return version == protocol_5_version ? schema_of_protocol_5 : schema_of_protocol_4;
}

// Corrects the checksums of all chunks, the version number, and the schema hash in the first chunk.
void seal(std::vector<std::uint8_t> &bytes, char version = magic[7])
{
    if (bytes.size() < 8) return;
    std::copy_n(magic, 8, bytes.begin());
    bytes[7] = static_cast<std::uint8_t>(version);
    const std::uint64_t schema = schema_of(version);
    for (std::size_t at = 8; bytes.size() - at >= chunk_head_bytes + chunk_tail_bytes;) {
        std::uint8_t *chunk = bytes.data() + at;
        const std::size_t count = chunk[4] | chunk[5] << 8 | chunk[6] << 16 | std::size_t{chunk[7]} << 24;
        if (count > bytes.size() - at - chunk_head_bytes - chunk_tail_bytes) return;
        if (at == 8 && count >= 12) put(chunk + chunk_head_bytes + 4, schema, 8);
        put(chunk + chunk_head_bytes + count, crn_wire_crc32(0, chunk, chunk_head_bytes + count), 4);
        at += chunk_head_bytes + count + chunk_tail_bytes;
    }
}

// --- seeds ---

class Writer
{
  public:
    Writer() { bytes.assign(magic, magic + 8); }
    void chunk(std::uint32_t kind, const std::vector<std::uint8_t> &payload)
    {
        std::uint8_t head[chunk_head_bytes];
        put(head, kind, 4);
        put(head + 4, payload.size(), 4);
        bytes.insert(bytes.end(), head, head + sizeof head);
        bytes.insert(bytes.end(), payload.begin(), payload.end());
        bytes.resize(bytes.size() + chunk_tail_bytes);
    }
    std::vector<std::uint8_t> bytes;
};

// Puts an instrument with two knots. Before the present version, an instrument had no material, and before
// protocol 6, it had no lengths of the whole tool either.
void put_table(crn_wire_writer &writer, char version)
{
    crn_wire_instrument table{};
    table.knots_count = 2;
    table.knots[1].arc_um = 1500000;
    std::vector<std::uint8_t> bytes(CRN_WIRE_BYTES_instrument);
    crn_wire_writer present = crn_wire_writer_make(bytes.data(), bytes.size());
    crn_wire_put_instrument(&present, &table);
    constexpr std::size_t material = 1 + 5 * 4, lengths = 2 * 4;
    bytes.resize(present.length - (version < magic[7] ? material : 0) -
                 (version < protocol_6_version ? lengths : 0));
    for (const std::uint8_t byte : bytes) crn_wire_write(&writer, byte, 1);
}

std::vector<std::uint8_t> head(unsigned tools, char version = magic[7])
{
    std::vector<std::uint8_t> bytes(4096);
    crn_wire_writer writer = crn_wire_writer_make(bytes.data(), bytes.size());
    crn_wire_write(&writer, 2, 4);
    crn_wire_write(&writer, crn_wire_schema_hash(), 8);
    crn_wire_write(&writer, 0, 8);
    put_text(writer, "a.scene");
    put_text(writer, "b.session");
    crn_wire_write(&writer, tools, 1);
    for (unsigned k = 0; k < tools; k++) {
        put_text(writer, "wire");
        put_double(writer, 1.5);
        put_table(writer, version);
        crn_wire_write(&writer, 1, 2);
        put_double(writer, 0.0);
        put_double(writer, 1.5);
        put_text(writer, "steel");
        put_double(writer, 1.0);
        put_double(writer, 1.0);
    }
    if (version >= protocol_6_version) crn_wire_write(&writer, 0, 1); // the tools are the line
    crn_wire_entry entry{};
    entry.inserted_um_count = static_cast<std::uint16_t>(tools);
    crn_wire_put_entry(&writer, &entry);
    crn_wire_rig rig{};
    rig.tracks_count = 1;
    crn_wire_put_rig(&writer, &rig);
    bytes.resize(writer.length);
    return bytes;
}

std::vector<std::uint8_t> words(std::initializer_list<std::uint32_t> values)
{
    std::vector<std::uint8_t> bytes;
    for (std::uint32_t value : values)
        for (int i = 0; i < 4; i++) bytes.push_back(static_cast<std::uint8_t>(value >> (8 * i)));
    return bytes;
}

std::vector<std::uint8_t> ticks(unsigned tools, std::uint32_t first, std::uint32_t count)
{
    std::vector<std::uint8_t> bytes = words({first, count});
    for (std::uint32_t i = 0; i < count; i++) {
        crn_wire_tick_input input{};
        input.hands_count = static_cast<std::uint16_t>(tools);
        if (i == 1) input.orders = {1, {crn_wire_order_of_rhythm({CRN_WIRE_RHYTHM_HEART_RATE, 90})}};
        if (i == 2)
            input.orders = {2, {crn_wire_order_of_scaffold({1, 0, 2, 30000}), crn_wire_order_of_strut({})}};
        const std::size_t at = bytes.size();
        bytes.resize(at + tick_bytes_max(tools));
        crn_wire_writer writer = crn_wire_writer_make(bytes.data() + at, bytes.size() - at);
        crn_wire_put_tick_input(&writer, &input);
        bytes.resize(at + writer.length + 8);
    }
    return bytes;
}

std::vector<std::uint8_t> old_ticks(unsigned tools, std::uint32_t first, std::uint32_t count)
{
    std::vector<std::uint8_t> bytes = words({first, count});
    for (std::uint32_t i = 0; i < count; i++) {
        const std::size_t at = bytes.size();
        bytes.resize(at + old_tick_bytes(tools), static_cast<std::uint8_t>(i));
        bytes[at] = static_cast<std::uint8_t>(tools);
        bytes[at + 1] = 0;
    }
    return bytes;
}

// Makes a recording of protocol 5 or 6.
std::vector<std::uint8_t> previous_file(unsigned tools, char version)
{
    Writer file;
    file.chunk(HEAD, head(tools, version));
    file.chunk(TICKS, ticks(tools, 0, 3));
    file.chunk(SNAPSHOT, words({3, version == protocol_6_version ? 4u : 3u, 8, 9}));
    file.chunk(END, words({3, 1, 2}));
    seal(file.bytes, version);
    return file.bytes;
}

// Makes a recording of version 2 that includes one chunk of a kind that only version 2 had.
std::vector<std::uint8_t> old_file(unsigned tools)
{
    Writer file;
    file.chunk(HEAD, head(tools, oldest_version));
    file.chunk(TICKS, old_ticks(tools, 0, 3));
    std::vector<std::uint8_t> view = words({3, 0x01010001, 2, 3, 4, 5, 6, 7});
    view.resize(view_bytes);
    file.chunk(VIEW, view);
    file.chunk(END, words({3, 1, 2}));
    seal(file.bytes, oldest_version);
    return file.bytes;
}

} // namespace

int LLVMFuzzerTestOneInput(const std::uint8_t *bytes, std::size_t count)
{
    std::vector<std::uint8_t> copy(bytes, bytes + count);
    copy.shrink_to_fit(); // exact, so that a read past the end is seen
    if (count % 4 == 0) offer(copy);
    seal(copy);
    offer(copy);
    for (char version = oldest_version; version < magic[7]; version++) {
        seal(copy, version);
        convert(copy);
    }
    return 0;
}

std::size_t fuzz_seed(unsigned index, std::uint8_t *bytes, std::size_t capacity)
{
    if (index >= 13) return 0;
    const unsigned tools = 1 + index % 3;
    Writer file;
    file.chunk(HEAD, head(tools));
    if (index >= 1) file.chunk(TICKS, ticks(tools, 0, 3));
    if (index >= 2) file.chunk(HASH, words({3, 1, 2}));
    if (index >= 3) file.chunk(SNAPSHOT, words({3, 7, 8, 9}));
    if (index >= 4) {
        std::vector<std::uint8_t> command(command_bytes); // the pedal goes down at tick 3
        command[0] = 3;
        command[4] = static_cast<std::uint8_t>(RoomAction::fluoro_pedal);
        command[6] = 1;
        file.chunk(ROOM, command);
        file.chunk(TICKS, ticks(tools, 3, 2));
    }
    if (index >= 5) file.chunk(END, words({5, 1, 2}));
    seal(file.bytes);
    if (index >= 6) file.bytes = old_file(tools);
    if (index >= 9)
        file.bytes = previous_file(tools, index % 2 == 0 ? protocol_5_version : protocol_6_version);
    if (file.bytes.size() > capacity) return 0;
    std::copy(file.bytes.begin(), file.bytes.end(), bytes);
    return file.bytes.size();
}
