// Simulates the screen of the X-ray room: live picture, last image hold, loops, subtraction, roadmap, and the
// pictures of runs. The screen reads the X-ray room and does not change it. The screen receives the room's
// events in order, and the picture of every X-ray pulse from the code that makes the pictures.
//
//   RoomScreen screen(room);
//   for (const RoomEvent &event : room.events())
//       screen.take(event, event.kind == RoomEvent::Kind::pulse ? &picture_of(event) : nullptr);
//   screen.compose(size, grey); screen.status();
//
// Two screens that receive the same events and pictures show images that are equal bit for bit. See
// docs/room.md.
#pragma once
#include "host/room/room.hpp"
#include "host/room/run_store.hpp"
#include <optional>
#include <string>
#include <vector>

namespace crn
{

enum class ScreenSource { nothing, live, held, loop, still };
enum class RoadmapState {
    off,
    waits,
    collects,
    shown,
    moved
}; // moved: the geometry has changed, so the roadmap is not laid over

// Holds the values that the display shows: the state of the room, and a description of what is on the screen.
struct RoomStatus : RoomState {
    RunKind kind = RunKind::fluoro; // of the beam, or of the shown picture
    double pulses_per_s = 0.0;      // likewise
    ScreenSource source = ScreenSource::nothing;
    int run = 0, frame = 0, frames = 0; // of the shown picture; run 0: fluoroscopy that is not kept
    int runs_kept = 0;
    bool is_subtracted = false;
    int mask_first = 0, mask_last = 0; // frames from 0
    double shift_right_px = 0.0, shift_up_px = 0.0;
    RoadmapState roadmap = RoadmapState::off;
    CArm picture_carm; // at the pulse of the shown picture; before the first pulse: the present one
};

class RoomScreen
{
  public:
    // `store_bytes_max` limits the memory for the pictures of runs (see RunStore). `room` must live longer
    // than the screen.
    explicit RoomScreen(const Room &room, std::size_t store_bytes_max = std::size_t{512} << 20);

    // If the event is an X-ray pulse, `picture` is the picture of that pulse; for every other event,
    // `picture` is null.
    void take(const RoomEvent &event, const XrayPicture *picture);
    // describe() returns a description (without frames) of the run to which a pulse's picture belongs, as in
    // files. frame_of() returns the picture as a frame of that run.
    static XrayRun describe(const RoomEvent &pulse, const XrayPicture &picture);
    static RunFrame frame_of(const RoomEvent &pulse, const XrayPicture &picture);

    const Room &room() const { return room_; }
    RoomStatus status() const;
    // Writes the present picture of the screen, which has size*size pixels and is black before the first
    // pulse. Returns false if the screen's picture has not changed since the last call.
    bool compose(int size, std::vector<std::uint8_t> &grey);
    // Writes into `grey` one frame of a stored run as the review shows it, and describes the frame in
    // `status`. If `frame` is -1, the function writes the frame that a loop of the run shows now. Returns
    // false if the run has no pictures, or if `grey` and `status` already hold this frame.
    bool compose_stored(int run, int frame, std::vector<std::uint8_t> &grey, RoomStatus &status);
    const RunStore &store() const { return store_; }

  private:
    struct Review {
        bool is_on = false, is_loop = false;
        int run = 0, frame = 0;
        std::uint32_t tick_begin = 0;
    };
    // Holds the frame that the screen shows, before a mask is subtracted or a roadmap is added.
    struct Source {
        const std::vector<std::uint16_t> *raw = nullptr;
        const std::vector<std::uint8_t> *grey = nullptr;
        StoredRun *run = nullptr; // nullptr: fluoroscopy that is not kept
        int frame = 0;
        int size = 0;
        const RunFrame *pulse = nullptr;
    };
    struct Roadmap {
        RoadmapState state = RoadmapState::off;
        std::vector<float> reference, peak; // log2; doublings
        float floor = 0.0f;
        CArm carm;
    };

    void carry_out(std::uint32_t tick, const RoomCommand &command);
    void begin_beam(const RoomEvent &event);
    void end_beam(const RoomEvent &event);
    void keep(const RoomEvent &event, const XrayPicture &picture);
    void set_mask(std::uint32_t tick, const RoomCommand &command);
    void set_roadmap(std::uint32_t tick, std::int32_t wanted);
    void roadmap_from_run(StoredRun &stored);
    void collect_roadmap(const RunFrame &frame, int size);
    void finish_roadmap();
    void set_review(std::uint32_t tick, const RoomCommand &command);
    void notify(std::uint32_t tick, const std::string &text) { notice_ = {text, tick}; }
    Source shown() const;
    bool is_subtracted(const Source &source) const;
    void fill_shown(RoomStatus &status) const;
    void fill_run(const Source &source, RoomStatus &status) const;
    int loop_frame(const StoredRun &stored) const;
    StoredRun *shown_dsa(std::uint32_t tick);
    void compose_subtracted(const Source &source, std::vector<std::uint8_t> &grey);

    const Room &room_;
    RunStore store_;
    bool is_beam_on_ = false, is_acquired_ = false;
    Review review_;
    Roadmap roadmap_;
    // Holds the last frame of the X-ray beam; the frame is first shown live, and later as a held image. If
    // the run of the held frame is stored, the store contains the frame too.
    RunFrame held_frame_;
    std::vector<std::uint8_t> held_grey_;
    int held_run_ = 0, held_index_ = 0, held_size_ = 0;
    RunKind held_kind_ = RunKind::fluoro;
    double held_pulses_per_s_ = 0.0;
    bool has_held_ = false;
    RoomNotice notice_;
    // version_ counts the changes of the picture on the screen, and composed_version_ is the value of this
    // count at the last call of compose().
    std::uint64_t version_ = 0, composed_version_ = ~std::uint64_t{0};
    int composed_frame_ = -1;
    // Holds the mask of the run that was shown last, in the form that the subtraction uses.
    struct MaskCache {
        const StoredRun *run = nullptr;
        RunMask mask;
        std::vector<float> log2_values;
    } mask_cache_;
};

// Returns true if two poses of the C-arm agree within half a millimetre and a tenth of a degree. If two poses
// of the C-arm differ by more than half a millimetre or a tenth of a degree, a roadmap made in one would be
// misleading in the other.
bool is_same_geometry(const CArm &a, const CArm &b);

} // namespace crn
