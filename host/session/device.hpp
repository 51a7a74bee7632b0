// Prepares a device for a session: the device has answered HELLO, has received its scene, tools, entry point
// and rig settings, and is armed and started.
#pragma once
#include "host/effects/pulse.hpp"
#include "host/link/link.hpp"
#include "host/model/tool_line.hpp"
#include "host/rig/device_choice.hpp"
#include "host/session/balloon_figures.hpp"
#include "host/session/frame_sink.hpp"
#include "host/session/range_watch.hpp"
#include "host/session/recording.hpp"
#include "host/session/scene_file.hpp"
#include "host/session/stepped_device.hpp"
#include "host/session/witness.hpp"
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <vector>

namespace crn
{

// Returns the rig settings for sessions that a script or the keyboard controls: 1 um and 1/65 536 turn per
// count, and a force gain of 1.
crn_wire_rig host_rig();

// Receives the ticks of a session in FREE_RUN.
class FreeRunSink
{
  public:
    virtual ~FreeRunSink() = default;
    virtual void tick(const crn_wire_live_tick &tick) = 0;
    // snapshot() receives the state after the last tick that tick() received. resumed() is called when the
    // device has come back and the session continues from this state.
    virtual void snapshot(std::uint32_t tick, std::span<const std::uint8_t> bytes) = 0;
    virtual void resumed(std::uint32_t tick, std::span<const std::uint8_t> bytes) = 0;
};

class Device final : public SteppedDevice
{
  public:
    // `tools` is the table of the session's tools, and `line` gives the number of the tool at each position,
    // from the innermost (tool_line.hpp); if `line` is empty, all tools are in use, in the order of the
    // table. Throws LinkError if the device refuses; the message contains the device's reason, the remedy,
    // and the name of the tool that caused the refusal.
    Device(const SceneFile &scene, std::vector<Instrument> tools, const crn_wire_entry &entry,
           const crn_wire_rig &rig, const DeviceChoice &choice = {}, const LineNumbers &line = {});
    // The destructor restores the settings that a rig had before.
    ~Device() override;
    Device(const Device &) = delete;
    Device &operator=(const Device &) = delete;

    Link &link() override { return *link_; }
    const std::vector<Instrument> &tools() const override { return tools_; }
    const LineNumbers &line() const override { return line_; }
    const crn_wire_hello_reply &identity() const { return identity_; }
    const crn_wire_rig &rig() const { return rig_; } // active; no limit above the device's own
    // Returns the header of a recording of this device's session. `session` names the script, or states who
    // controls the session.
    RecordingHeader recording_header(const std::string &session,
                                     const std::vector<StentDesign> &stents = {}) const;
    // Sets the device to the state of a snapshot of this session.
    void restore(std::span<const std::uint8_t> snapshot);

    // Advances the device as Link::step does, but the session survives an unplugged cable (docs/rig.md,
    // "Unplugged in a session"). If the device disappears and comes back within
    // DeviceChoice::return_limit_ms, its last snapshot is restored. The inputs after that snapshot are then
    // sent to the device again, and the new results are compared with the former results. After a
    // disconnection the session continues, equal bit for bit to a session without interruption. Throws
    // LinkError if the device does not come back, or if its new results differ from its former results.
    std::span<const crn_wire_tick_state> step(std::span<const crn_wire_tick_input> inputs,
                                              bool want_nodes) override;
    // Sends any other request to the device, with the same protection against an unplugged cable as step().
    void ask(const std::function<void(Link &)> &request) override;
    // The next three functions return the data that a recording contains besides the ticks. If the device is
    // a rig, its ticks, hashes and snapshots are first compared with the results of this machine's core
    // (witness.hpp). The next three functions throw LinkError if the rig's results differ from those of this
    // machine's core.
    Hash64 read_hash64() override;                      // hash of the last tick given or stepped
    std::optional<Hash64> last_hash64() override;       // last one that came without a request
    std::vector<std::uint8_t> read_snapshot() override; // LOCKSTEP
    std::uint32_t resumes() const override { return resumes_; }
    // Returns true if the device runs on its own clock; such a device removes the motor forces when the host
    // is silent too long.
    bool has_its_own_clock() const { return choice_.is_usb && pipe_ != nullptr; }

    // In FREE_RUN (`free_run` of the choice), this function waits until `milliseconds` have passed, even
    // while the cable is disconnected. `sink` receives every tick exactly once and in order. After a
    // disconnection the session continues from the last received tick. When the session continues after a
    // disconnection, the present positions of the hands become the new reference (FreeRunSink::resumed).
    // Throws LinkError with the cause if the device has stopped, or does not come back.
    void run_free(std::uint32_t milliseconds, FreeRunSink &sink);
    // Stops the device; `sink` still receives the ticks that the device had already computed.
    void stop_free(FreeRunSink &sink);

    static constexpr std::uint32_t resumes_max = 5; // within this many ticks of the session:
    static constexpr std::uint32_t resumes_within_ticks = 1000;
    static constexpr std::size_t inputs_kept_max = 1000; // then a new snapshot is taken
    static constexpr std::size_t free_run_kept_max = 10000;

  private:
    struct Hash {
        std::uint32_t lane0, lane1;
    };
    void open();
    void set_up();
    void leave(); // gives the device its own configuration back
    void call_witness();
    void check_identity(const crn_wire_hello_reply &reply) const;
    void keep_up();
    void count_resume(std::uint32_t tick);
    void resume();
    void go_back_to_snapshot();
    // device_free_run.cpp
    crn_wire_rig free_run_rig(const crn_wire_rig &own) const;
    void start_free_run();
    void resume_free(FreeRunSink &sink);
    void ask_snapshot();
    bool take_live(FreeRunSink &sink);
    void give(const crn_wire_live_tick &tick, FreeRunSink &sink);
    void check_running(FreeRunSink &sink);

    SceneFile scene_;
    std::vector<Instrument> tools_;
    LineNumbers line_;
    crn_wire_entry entry_;
    crn_wire_rig rig_, rig_before_{};
    DeviceChoice choice_;
    std::unique_ptr<Transport> pipe_;
    std::optional<Link> link_;
    crn_wire_hello_reply identity_{};
    bool has_started_ = false;

    std::vector<std::uint8_t> snapshot_;      // empty: from the session's first tick
    std::vector<crn_wire_tick_input> inputs_; // steps since the snapshot
    std::vector<Hash> hashes_;                // their results
    std::uint32_t resumes_ = 0, resumes_here_ = 0, resumes_from_tick_ = 0;
    std::unique_ptr<Witness> witness_; // only for a device that is not in this process
    std::optional<Hash64> hash_;       // the last one that was compared

    std::uint32_t given_tick_ = 0;                  // FREE_RUN: the last given tick
    std::vector<crn_wire_live_tick> without_hands_; // ticks before the first reading of the encoders
    bool has_hands_ = false;
    std::vector<std::uint8_t> snapshot_to_come_; // of a tick that has not been given yet
    std::uint32_t snapshot_tick_ = 0, silent_ms_ = 0;
};

// Returns the point where the tools enter the scene, with one inserted length per tool. A tool whose inserted
// length is not given, or is inserted_unstated (session.hpp), gets the scene's start length.
crn_wire_entry entry_of(const SceneFile &scene, std::size_t tool_count,
                        std::span<const std::uint32_t> inserted_um);

// Returns the shape of the nested tools and the readings of every tool after a batch of steps. The returned
// frame combines the nodes that the link received last with the result and the input of the last tick. Before
// the first tick, `state` is empty and no forces are known yet.
SessionFrame session_frame(SteppedDevice &device, const crn_wire_tick_state &state,
                           const crn_wire_tick_input &input);

// Holds the inserted length of one tool, and the largest length, force and torque that this tool had in a
// session.
struct ToolFigures {
    double inserted_m = 0.0;
    double inserted_max_m = 0.0;
    double axial_max_N = 0.0; // size of the force on the hand
    double torque_max_N_m = 0.0;
};

// Holds the measurements of pulse and blood pressure that the heart monitor collects in a session.
struct HeartFigures {
    PulseMonitor monitor;
    double pressure_max_mmHg = 0.0, pressure_min_mmHg = 1e3;
};

// Holds the largest values over all ticks of a session.
struct SessionFigures {
    std::uint32_t ticks = 0;
    double penetration_max_m = 0.0;
    std::uint32_t penetration_max_tick = 0;
    double strain_max = 0.0; // relative length error
    std::uint32_t strain_max_tick = 0;
    std::uint32_t contact_count_max = 0;
    std::vector<ToolFigures> tools; // from the innermost; empty before the first tick
    HeartFigures heart;
    BalloonFigures balloon;
    RangeWatch range;
    void take(const crn_wire_tick_state &state);
};

} // namespace crn
