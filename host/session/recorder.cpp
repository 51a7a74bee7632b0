#include "host/base/pending_file.hpp"
#include "host/session/recording_chunks.hpp"
#include "host/session/recording_format.hpp"
#include <cerrno>
#include <unistd.h>

namespace crn
{

using namespace recording_format;

namespace
{

void put_tool(crn_wire_writer &writer, const Instrument &tool)
{
    put_text(writer, tool.name);
    put_double(writer, tool.length_m);
    crn_wire_put_instrument(&writer, &tool.table);
    const std::size_t layers = std::min(tool.layers.size(), layers_max);
    crn_wire_write(&writer, layers, 2);
    for (std::size_t i = 0; i < layers; i++) {
        const InstrumentLayer &layer = tool.layers[i];
        put_double(writer, layer.arc_begin_m);
        put_double(writer, layer.arc_end_m);
        put_text(writer, layer.material.substr(0, 64));
        put_double(writer, layer.fill);
        put_double(writer, layer.radius_share);
    }
}

std::vector<std::uint8_t> header_bytes(const RecordingHeader &header)
{
    std::vector<std::uint8_t> bytes(head_bytes_max);
    crn_wire_writer writer = crn_wire_writer_make(bytes.data(), bytes.size());
    crn_wire_write(&writer, header.core_version, 4);
    crn_wire_write(&writer, header.schema_hash, 8);
    crn_wire_write(&writer, header.scene_bytes, 4);
    crn_wire_write(&writer, header.scene_crc32, 4);
    put_text(writer, header.scene_path);
    put_text(writer, header.session_path);
    const std::size_t tools = std::min<std::size_t>(header.tools.size(), CRN_WIRE_TABLE_MAX);
    crn_wire_write(&writer, tools, 1);
    for (std::size_t k = 0; k < tools; k++) put_tool(writer, header.tools[k]);
    crn_wire_write(&writer, header.line.size(), 1);
    for (const std::uint8_t number : header.line) crn_wire_write(&writer, number, 1);
    crn_wire_put_entry(&writer, &header.entry);
    crn_wire_put_rig(&writer, &header.rig);
    bytes.resize(writer.length);
    return bytes;
}

std::vector<std::uint8_t> side_holes_of(std::size_t tool, const SideHoles &holes)
{
    std::vector<std::uint8_t> bytes(side_holes_bytes);
    crn_wire_writer writer = crn_wire_writer_make(bytes.data(), bytes.size());
    crn_wire_write(&writer, tool, 1);
    put_double(writer, holes.arc_begin_m);
    put_double(writer, holes.arc_end_m);
    crn_wire_write(&writer, holes.count, 4);
    put_double(writer, holes.diameter_m);
    return bytes;
}

// Returns the label of a tool's balloon, encoded as bytes.
std::vector<std::uint8_t> balloon_of(std::size_t tool, const BalloonLabel &label)
{
    const std::size_t markers = std::min(label.marker_arcs_m.size(), balloon_markers_max);
    std::vector<std::uint8_t> bytes(balloon_bytes(markers));
    crn_wire_writer writer = crn_wire_writer_make(bytes.data(), bytes.size());
    crn_wire_write(&writer, tool, 1);
    put_double(writer, label.nominal_kPa);
    put_double(writer, label.rated_burst_kPa);
    put_double(writer, label.crossing_profile_m);
    crn_wire_write(&writer, markers, 1);
    for (std::size_t i = 0; i < markers; i++) put_double(writer, label.marker_arcs_m[i]);
    return bytes;
}

// Returns a stent, encoded as bytes: name and material, the connections of the rings, and then counts and
// numbers in the order of their lists.
std::vector<std::uint8_t> stent_of(const StentDesign &stent)
{
    constexpr std::size_t text_max = 200;
    std::vector<std::uint8_t> bytes(stent_bytes_max);
    crn_wire_writer writer = crn_wire_writer_make(bytes.data(), bytes.size());
    put_text(writer, stent.name.substr(0, text_max));
    put_text(writer, stent.material.substr(0, text_max));
    crn_wire_write(&writer, stent.connection == StentConnection::facing, 1);
    for (const StentCount &row : stent_counts())
        crn_wire_write(&writer, static_cast<std::uint32_t>(stent.*row.value), 4);
    for (const StentNumber &row : stent_numbers()) put_double(writer, stent.*row.value);
    bytes.resize(writer.length);
    return bytes;
}

} // namespace

Recorder::Recorder(const std::string &path, const RecordingHeader &header) : path_(path)
{
    try {
        const OpenPending opened = open_pending(path);
        forget_pending(opened.name); // a recording that is cut off is worth keeping
        pending_file_ = opened.name;
        file_.reset(::fdopen(opened.file, "wb"));
        if (!file_) throw OutputError(path, errno);
    } catch (const OutputError &error) {
        throw RecordingError(RecordingFault::unreadable, error.what());
    }
    std::fwrite(magic, 1, 8, file_.get());
    chunk(HEAD, header_bytes(header));
    for (std::size_t k = 0; k < header.tools.size(); k++)
        for (const SideHoles &holes : header.tools[k].side_holes) chunk(SIDE_HOLES, side_holes_of(k, holes));
    for (std::size_t k = 0; k < header.tools.size(); k++)
        if (header.tools[k].balloon) chunk(BALLOON, balloon_of(k, *header.tools[k].balloon));
    for (const StentDesign &stent : header.stents) chunk(STENT, stent_of(stent));
}

// A destructor may not throw. If the remaining ticks cannot be written, they are lost, and a reader
// recognises that the recording was cut off. A recording in which no tick has begun is discarded, because it
// would replace an earlier file by nothing.
Recorder::~Recorder()
{
    if (tick_ == 0 && !has_name_) {
        file_.reset();
        discard_pending(pending_file_);
        return;
    }
    try {
        if (file_) flush_ticks();
        give_name();
    } catch (const std::exception &) {
    }
}

// The recording is useful whether it is complete or cut off, so the file now gets its final name.
void Recorder::give_name()
{
    file_.reset();
    if (has_name_) return;
    has_name_ = true;
    try {
        commit_pending(pending_file_, path_, true);
    } catch (const OutputError &error) {
        throw RecordingError(RecordingFault::unreadable, error.what());
    }
}

void Recorder::chunk(std::uint32_t kind, std::span<const std::uint8_t> payload)
{
    const std::vector<std::uint8_t> bytes = sealed_chunk(kind, payload);
    if (std::fwrite(bytes.data(), 1, bytes.size(), file_.get()) != bytes.size() ||
        std::fflush(file_.get()) != 0) {
        const OutputError error(path_, errno);
        give_name();
        throw RecordingError(RecordingFault::unreadable, error.what());
    }
}

void Recorder::flush_ticks()
{
    if (pending_.empty()) return;
    std::vector<std::uint8_t> bytes(8 + pending_.size() * tick_bytes_max(CRN_WIRE_TOOL_MAX));
    crn_wire_writer writer = crn_wire_writer_make(bytes.data(), bytes.size());
    crn_wire_write(&writer, tick_ - pending_.size(), 4);
    crn_wire_write(&writer, pending_.size(), 4);
    for (const RecordedTick &tick : pending_) {
        crn_wire_put_tick_input(&writer, &tick.input);
        crn_wire_write(&writer, tick.hash_lane[0], 4);
        crn_wire_write(&writer, tick.hash_lane[1], 4);
    }
    pending_.clear();
    bytes.resize(writer.length);
    chunk(TICKS, bytes);
}

void Recorder::tick(const crn_wire_tick_input &input, const crn_wire_tick_state &state)
{
    pending_.push_back({input, {state.hash_lane0, state.hash_lane1}});
    tick_++;
    if (pending_.size() == ticks_per_chunk) flush_ticks();
}

void Recorder::hash(std::uint32_t tick, std::uint64_t hash)
{
    std::uint8_t bytes[12];
    crn_wire_writer writer = crn_wire_writer_make(bytes, sizeof bytes);
    crn_wire_write(&writer, tick, 4);
    crn_wire_write(&writer, hash, 8);
    chunk(HASH, bytes);
}

void Recorder::snapshot(std::uint32_t tick, std::span<const std::uint8_t> bytes)
{
    state(SNAPSHOT, tick, bytes);
}

void Recorder::resumed(std::uint32_t tick, std::span<const std::uint8_t> bytes)
{
    state(RESUMED, tick, bytes);
}

void Recorder::state(std::uint32_t kind, std::uint32_t tick, std::span<const std::uint8_t> snapshot)
{
    flush_ticks();
    std::vector<std::uint8_t> bytes(4 + snapshot.size());
    crn_wire_writer writer = crn_wire_writer_make(bytes.data(), bytes.size());
    crn_wire_write(&writer, tick, 4);
    std::copy(snapshot.begin(), snapshot.end(), bytes.begin() + 4);
    chunk(kind, bytes);
}

void Recorder::command(std::uint32_t tick, const RoomCommand &command)
{
    chunk(ROOM, command_payload(tick, command));
}

void Recorder::finish(std::uint32_t tick, std::uint64_t final_hash)
{
    flush_ticks();
    std::uint8_t bytes[12];
    crn_wire_writer writer = crn_wire_writer_make(bytes, sizeof bytes);
    crn_wire_write(&writer, tick, 4);
    crn_wire_write(&writer, final_hash, 8);
    chunk(END, bytes);
    give_name();
}

} // namespace crn
