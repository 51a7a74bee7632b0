// A recording contains everything that determines a session, tick by tick (docs/session.md describes every
// byte).
//
//   file   = "CRN-REC6" | chunk ...
//   chunk  = kind u32 | bytes u32 | payload | CRC-32 u32 over kind, bytes and payload
//   order  = HEAD, SIDE_HOLES, BALLOON and STENT; then TICKS, HASH, SNAPSHOT, RESUMED and ROOM as they happen;
//            END when the session was closed properly
//
// A recorder writes the recording in chunks. If a crash cuts off the recording, the file can be read up to
// its last complete chunk. A reader refuses a file that is not a recording, that has another version, or that
// is damaged in the middle.
#pragma once
#include "host/model/tool_line.hpp"
#include "host/room/command.hpp"
#include "host/stent/design.hpp"
#include "shared/wire/wire.h"
#include <cstdio>
#include <memory>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

namespace crn
{

struct RecordingHeader {
    std::uint32_t core_version = 0;
    std::uint64_t schema_hash = 0;
    std::uint32_t scene_bytes = 0; // 0: free space
    std::uint32_t scene_crc32 = 0;
    std::string scene_path;
    std::string session_path;
    std::vector<Instrument> tools; // the table; its values determine the session, the layers only its picture
    LineNumbers line{};            // as Device has it; empty: the tools are the line, from the innermost
    crn_wire_entry entry{};
    crn_wire_rig rig{};
    std::vector<StentDesign> stents{}; // load_stent mounts them in this order
    std::size_t positions() const { return line.empty() ? tools.size() : line.size(); }
};

struct RecordedTick {
    crn_wire_tick_input input{};
    std::uint32_t hash_lane[2] = {0, 0};
};

struct RecordedHash {
    std::uint32_t tick = 0;
    std::uint64_t hash = 0;
};

struct RecordedSnapshot {
    std::uint32_t tick = 0;
    std::vector<std::uint8_t> bytes;
};

struct RecordedCommand {
    std::uint32_t tick = 0; // in force from this tick on
    RoomCommand command;
};

struct Recording {
    RecordingHeader header;
    std::vector<RecordedTick> ticks; // ticks[i] led from tick i to tick i + 1
    std::vector<RecordedHash> hashes;
    std::vector<RecordedSnapshot> snapshots;
    std::vector<RecordedCommand> commands; // commands to the room, in order of time
    std::vector<RecordedSnapshot> resumes; // FREE_RUN after an unplug: the session continues from this state
    bool is_complete = false;              // the recording was closed properly; otherwise it was cut off
                                           // after the last whole chunk

    const RecordedSnapshot *snapshot_before(std::uint32_t tick) const; // nullptr: start from the beginning
    const RecordedSnapshot *resumed_at(std::uint32_t tick) const;      // nullptr: nothing happened there
    std::uint32_t ticks_to_resume(std::uint32_t tick) const;           // until the next one, UINT32_MAX: none
};

enum class RecordingFault {
    unreadable,
    not_a_recording,
    older_version, // recording_upgrade.hpp converts it
    newer_version, // or of a wire schema that this program does not know
    truncated,
    damaged,
    inconsistent
};

class RecordingError : public std::runtime_error
{
  public:
    RecordingError(RecordingFault fault_, const std::string &text) : std::runtime_error(text), fault(fault_)
    {
    }
    RecordingFault fault;
};

std::vector<std::uint8_t> read_recording_bytes(const std::string &path); // throws RecordingError
Recording read_recording(const std::string &path);                       // throws RecordingError
Recording parse_recording(std::span<const std::uint8_t> bytes,
                          const std::string &name); // throws RecordingError

class Recorder
{
  public:
    static constexpr std::uint32_t ticks_per_chunk = 500;
    static constexpr std::uint32_t snapshot_every_ticks = 5000;

    // The constructor and all later calls throw RecordingError when the file cannot be written. Until the
    // recording is finished or abandoned, its file is called "path.partPID-RANDOM". If the program is killed
    // before the recording is finished, the file with that temporary name stays and can be replayed.
    Recorder(const std::string &path, const RecordingHeader &header);
    ~Recorder(); // closes as a cut-off recording unless finish() was called

    void tick(const crn_wire_tick_input &input, const crn_wire_tick_state &state);
    void hash(std::uint32_t tick, std::uint64_t hash);
    void snapshot(std::uint32_t tick, std::span<const std::uint8_t> bytes);
    void resumed(std::uint32_t tick, std::span<const std::uint8_t> bytes);
    void command(std::uint32_t tick, const RoomCommand &command);
    void finish(std::uint32_t tick, std::uint64_t hash);

  private:
    void flush_ticks();
    void give_name();
    void chunk(std::uint32_t kind, std::span<const std::uint8_t> payload);
    void state(std::uint32_t kind, std::uint32_t tick, std::span<const std::uint8_t> bytes);

    struct Close {
        void operator()(std::FILE *file) const { std::fclose(file); }
    };
    std::string path_, pending_file_;
    std::unique_ptr<std::FILE, Close> file_;
    bool has_name_ = false;
    std::vector<RecordedTick> pending_;
    std::uint32_t tick_ = 0;
};

} // namespace crn
