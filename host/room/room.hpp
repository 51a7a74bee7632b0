// The X-ray room as a state machine: pedals, geometry, runs, masks, roadmap, review, dose. No window, no clock, no X-ray of its
// own: commands and ticks go in, requests for pulses and what the screen shows come out.
//
//   room.give(tick, command);                    // in force from that tick on, before it is carried out
//   room.advance(tick, &tip);                    // every millisecond up to `tick`
//   if (room.is_pulse_due()) { render(room.pulse()); room.expose(picture); }
//   room.compose(grey); room.status();           // the screen
//
// Stop at next_tick() at the latest, or pulses are missed. The same commands and pictures give the same screens, bit for
// bit. May include: host/xray. Called by: host/app. See docs/room.md.
#pragma once
#include "host/room/command.hpp"
#include "host/room/dose.hpp"
#include "host/room/gantry.hpp"
#include "host/room/run_store.hpp"
#include "host/xray/xray.hpp"
#include <deque>
#include <optional>
#include <string>
#include <vector>

namespace crn
{

struct PulseRequest {
    RunKind kind = RunKind::fluoro;
    CArm carm;
    XrayBeam beam;
    bool settles_at_once = false; // a test exposure has found the technique: render without generator memory
};

enum class ScreenSource { nothing, live, held, loop, still };
enum class RoadmapState {
    off,
    waits,
    collects,
    shown,
    moved
}; // moved: the geometry is another one; not laid over

// What the display tells about the room.
struct RoomStatus {
    std::uint32_t tick = 0;
    CArm carm;
    bool is_moving = false, is_blocked = false, follows_tip = false;
    bool is_beam_on = false;
    RunKind kind = RunKind::fluoro;                               // of the beam, or of what is shown
    double pulses_per_s = 0.0;                                    // the same
    RunKind program = RunKind::cine;                              // what the acquisition pedal makes
    double fluoro_pulses_per_s = 0.0, program_pulses_per_s = 0.0; // chosen for the next press
    ScreenSource source = ScreenSource::nothing;
    int run = 0, frame = 0, frames = 0; // of the picture shown; run 0: fluoroscopy that is not kept
    int runs_kept = 0;
    bool is_subtracted = false;
    int mask_first = 0, mask_last = 0; // frames from 0
    double shift_right_px = 0.0, shift_up_px = 0.0;
    RoadmapState roadmap = RoadmapState::off;
    double open_width_share = 1.0, open_height_share = 1.0;
    bool is_round = false;
    XrayTechnique technique; // of the last pulse
    bool is_underexposed = false;
    std::string notice; // of the last four seconds
};

class Room
{
  public:
    // Memory for the pictures of runs; see RunStore.
    explicit Room(std::size_t store_bytes_max = std::size_t{512} << 20);

    // Commands come in the order of their ticks; one of a tick already passed counts for the next. Returns why a
    // command cannot be carried out at all, else empty.
    std::string give(std::uint32_t tick, const RoomCommand &command);
    // The next tick at which something is to be seen: a command, a pulse, or a look at the tip. UINT32_MAX: none.
    std::uint32_t next_tick() const;
    // `tip`: where the leading tip is at `tick`; nullptr: not known.
    void advance(std::uint32_t tick, const Eigen::Vector3d *tip);

    bool is_pulse_due() const { return is_pulse_due_; }
    PulseRequest pulse() const;
    // The run that a picture for pulse() belongs to, as files describe it, without frames; and its frame. Before expose().
    XrayRun describe(const XrayPicture &picture) const;
    RunFrame take(const XrayPicture &picture) const;
    void expose(const XrayPicture &picture); // what pulse() gave

    RoomStatus status() const;
    // The picture on the screen, size*size; black before the first pulse. False when it is the one of the last call.
    bool compose(int size, std::vector<std::uint8_t> &grey);

    const Gantry &gantry() const { return gantry_; }
    const DoseMeter &dose() const { return dose_; }
    const RunStore &store() const { return store_; }
    // Presses of a pedal that made no run.
    const std::vector<Refusal> &refusals() const { return refusals_; }
    bool is_beam_on() const { return beam_.is_on; }
    double field_m() const { return field_um_ * 1e-6; }

  private:
    struct Queued { // a command that waits for its tick
        std::uint32_t tick;
        RoomCommand command;
    };
    struct Beam {
        bool is_on = false;
        RunKind kind = RunKind::fluoro;
        bool is_acquired = false;
        std::uint32_t tick_begin = 0;
        std::int64_t rate_centihertz = 0;
        std::uint32_t index = 0;             // of the next pulse
        std::optional<XrayTechnique> locked; // DSA: what the first frame was taken with
        std::uint32_t next_tick() const;
    };
    struct Review {
        bool is_on = false, is_loop = false;
        int run = 0, frame = 0;
        std::uint32_t tick_begin = 0;
    };
    // The frame on the screen before masks and roadmap.
    struct Source {
        const std::vector<std::uint16_t> *raw = nullptr;
        const std::vector<std::uint8_t> *grey = nullptr;
        StoredRun *run = nullptr; // nullptr: fluoroscopy that is not kept
        int frame = 0;
        int size = 0;
    };
    struct Roadmap {
        RoadmapState state = RoadmapState::off;
        std::vector<float> reference, peak; // log2; doublings
        float floor = 0.0f;
        CArm carm;
    };

    void process(std::uint32_t tick, const Eigen::Vector3d *tip);
    void carry_out(std::uint32_t tick, const RoomCommand &command);
    void carry_out_geometry(std::uint32_t tick, const RoomCommand &command);
    void move(std::uint32_t tick, const GantryPose &pose);
    void follow(std::uint32_t tick, const Eigen::Vector3d &tip);
    void press_pedals(std::uint32_t tick);
    void begin_beam(std::uint32_t tick, bool is_acquired);
    void end_beam(std::uint32_t tick);
    void store_fluoro(std::uint32_t tick, std::uint32_t milliseconds);
    void set_mask(const RoomCommand &command);
    void set_roadmap(std::uint32_t tick, std::int32_t wanted);
    void roadmap_from_run(StoredRun &stored);
    void collect_roadmap(const RunFrame &frame, int size);
    void finish_roadmap();
    void set_review(std::uint32_t tick, const RoomCommand &command);
    void notify(std::uint32_t tick, const std::string &text);
    void release_acquisition(std::uint32_t tick);
    std::string name_of_program() const { return program_ == RunKind::dsa ? "DSA" : "CINE"; }
    XrayRun header(int size) const;
    Source shown() const;
    bool is_subtracted(const Source &source) const;
    void fill_shown(RoomStatus &status) const;
    int loop_frame(const StoredRun &stored) const;
    StoredRun *shown_dsa(std::uint32_t tick);
    bool is_same_geometry(const CArm &carm) const;
    void compose_subtracted(const Source &source, std::vector<std::uint8_t> &grey);

    Gantry gantry_;
    DoseMeter dose_;
    RunStore store_;
    std::deque<Queued> queue_;
    std::int64_t tick_ = -1; // last one processed
    std::int32_t field_um_ = 320'000;
    std::int32_t blade_width_permille_ = 970, blade_height_permille_ = 970;
    bool is_round_ = false;
    bool follows_tip_ = false, was_blocked_ = false;
    bool is_fluoro_down_ = false, is_fluoro_armed_ = false, is_acquire_down_ = false,
         is_acquire_armed_ = false;
    RunKind program_ = RunKind::cine;
    std::int32_t fluoro_centihertz_ = 1500, cine_centihertz_ = 1500, dsa_centihertz_ = 300;
    Beam beam_;
    bool is_pulse_due_ = false;
    Review review_;
    Roadmap roadmap_;
    // The last frame of the beam: live, then held. A kept one stays in the store.
    RunFrame held_frame_;
    std::vector<std::uint8_t> held_grey_;
    int held_run_ = 0, held_index_ = 0, held_size_ = 0;
    RunKind held_kind_ = RunKind::fluoro;
    double held_pulses_per_s_ = 0.0;
    XrayTechnique held_technique_;
    bool is_underexposed_ = false;
    bool has_held_ = false;
    std::string notice_;
    std::int64_t notice_until_ = -1;
    bool is_acquire_waiting_ = false; // for the motors
    std::vector<Refusal> refusals_;
    // What the last compose() showed.
    std::uint64_t version_ = 0, composed_version_ = ~std::uint64_t{0};
    int composed_frame_ = -1;
    // Mask of the run shown last, as it is subtracted.
    struct MaskCache {
        const StoredRun *run = nullptr;
        RunMask mask;
        std::vector<float> log2_values;
    } mask_cache_;
};

} // namespace crn
