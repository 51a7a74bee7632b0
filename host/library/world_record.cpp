// Writes the recording of a world in the same form as `cournand run` writes the recording of a session.
#include "host/library/world.hpp"

namespace crn::library
{

void World::record(const std::string &path, const std::string &session)
{
    check_free();
    if (recorder_) throw Refused(COURNAND_BAD_STATE, "the world is being recorded: end its recording first");
    if (tick() != 0 || was_commanded_ || !orders_.is_empty())
        throw Refused(COURNAND_BAD_STATE,
                      "a recording begins at tick 0, before the first order: make another world");
    const RecordingHeader header = recording_header(session);
    recorder_ = with_files([&] { return std::make_unique<Recorder>(path, header); });
    recorded_hash_tick_ = 0;
}

RecordingHeader World::recording_header(const std::string &session) const
{
    RecordingHeader header;
    header.core_version = core_version_;
    header.schema_hash = crn_wire_schema_hash();
    header.scene_bytes = static_cast<std::uint32_t>(scene().file().bytes.size());
    header.scene_crc32 = scene().file().crc32;
    header.scene_path = scene().file().path;
    header.session_path = session;
    header.tools = settings_.tools;
    if (settings_.line != whole_table(settings_.tools.size())) header.line = settings_.line;
    header.entry = settings_.entry;
    header.rig = settings_.rig;
    header.stents = settings_.stents;
    return header;
}

void World::record_state()
{
    if (!recorder_) return;
    const std::optional<Hash64> hash = link_.last_hash64();
    if (hash && hash->tick > recorded_hash_tick_) {
        recorded_hash_tick_ = hash->tick;
        recording_work([&](Recorder &recorder) { recorder.hash(hash->tick, hash->hash); });
    }
    if (!recorder_ || tick() % Recorder::snapshot_every_ticks != 0) return;
    std::vector<std::uint8_t> snapshot(SimTransport::snapshot_bytes());
    if (!pipe_.take_snapshot(snapshot)) throw Refused(COURNAND_INTERNAL, "the device gives no snapshot");
    recording_work([&](Recorder &recorder) { recorder.snapshot(tick(), snapshot); });
}

void World::end_recording()
{
    if (!recorder_) throw Refused(COURNAND_BAD_STATE, "the world is not being recorded");
    const std::unique_ptr<Recorder> ended = std::move(recorder_);
    with_files([&] { ended->finish(tick(), hash()); });
}

} // namespace crn::library
