// Shows any moment of a recording from any angle of the C-arm. Each moment is computed from the last snapshot
// before it, so a late moment takes no longer than an early one. Contrast medium, stents and the position of
// the C-arm depend on the whole session before the moment. The replay takes medium, stents and the C-arm's
// position from a track (a list of these states over time), which another thread prepares once.
//
//   ReplayRoom room("live.rec", "", settings);
//   while (room.prepare(1000)) ...                        in one thread, until the track is complete
//   ReplayPicture picture = room.picture({12'000, carm}); in another thread, at any time
#pragma once
#include "host/picture/room_pictures.hpp"
#include "host/session/device.hpp"
#include "host/session/recording.hpp"
#include <atomic>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

namespace crn
{

struct ReplayAsk {
    std::uint32_t tick = 0;
    std::optional<CArm> carm; // empty: as it was in the session
};

struct ReplayPicture {
    int size = 0;
    std::vector<std::uint8_t> grey;
    SessionFrame frame; // shape and readings of the tools at that tick
    CArm carm;
    crn_wire_tick_state state{};
    LineNumbers line;         // the tools on the line at that tick
    bool is_prepared = false; // the track has reached that tick, so medium and stents are in the picture
};

// Describes a period of the session that the time line marks.
struct ReplayMark {
    enum class Kind { fluoro, acquire, injection } kind = Kind::fluoro;
    std::uint32_t begin = 0, end = 0;
};

class ReplayRoom
{
  public:
    // If `scene` is empty, the path in the recording is used. Throws the exceptions of the functions that
    // read the files.
    ReplayRoom(const std::string &recording, const std::string &scene, PictureSettings settings);
    ~ReplayRoom();

    std::uint32_t ticks() const { return static_cast<std::uint32_t>(recording_.ticks.size()); }
    const std::vector<Instrument> &tools() const { return recording_.header.tools; }
    std::vector<ReplayMark> marks() const;

    // Continues the track (the list of states over the session) by at most this number of ticks. Returns
    // false when the track (the list of states over the session) is complete. One thread at a time.
    bool prepare(std::uint32_t ticks);
    std::uint32_t prepared() const { return prepared_; }
    // Computes a picture; equal requests give pictures that are equal bit for bit. Only one thread at a time
    // may call picture(), but this may be another thread than the one that calls prepare().
    ReplayPicture picture(const ReplayAsk &ask);

    static constexpr std::uint32_t snapshot_every_ticks = 1000;

  private:
    struct Moment { // what the track knows from one tick on
        CArm carm;
        std::shared_ptr<const std::vector<SweptCurve>> curves; // medium and struts; null: none
    };
    void look_at_track();
    void feel_walls(Device &device);
    void go_to(std::uint32_t tick);
    void step_to(Device &device, std::uint32_t tick, crn_wire_tick_state &state) const;

    const Recording recording_;
    PictureSettings settings_;
    SceneFile scene_;
    SceneAnatomy anatomy_;
    std::vector<RadiopaqueInstrument> looks_;

    // Of the pictures' thread.
    std::unique_ptr<Device> device_;
    std::unique_ptr<Patient> patient_; // for its bodies alone
    std::unique_ptr<Xray> xray_;
    crn_wire_tick_state state_{};

    // Of the track's thread.
    std::unique_ptr<Device> track_device_;
    std::unique_ptr<Patient> track_patient_;
    crn_wire_tick_state track_state_{};
    std::size_t command_ = 0;

    mutable std::mutex mutex_; // for the track:
    std::map<std::uint32_t, Moment> moments_;
    std::map<std::uint32_t, std::vector<std::uint8_t>> snapshots_;
    std::atomic<std::uint32_t> prepared_ = 0;
};

} // namespace crn
