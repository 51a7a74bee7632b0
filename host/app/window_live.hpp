// Runs a session that the user controls by keyboard; it has one device, one recording and its pictures. An
// object of this class serves one session; after a reset the window makes a new object. A device in the mode
// FREE_RUN computes ticks by its own clock, and its encoders measure the motion of the user's hands. The
// pedals of a rig work in addition to the keys.
#pragma once
#include "host/model/order_queue.hpp"
#include "host/picture/session_pictures.hpp"
#include "host/rig/pedals.hpp"
#include "host/script/hand_motion.hpp"
#include "host/session/device.hpp"
#include "host/session/hand_grip.hpp"
#include "host/session/range_watch.hpp"
#include "host/session/run.hpp"
#include <chrono>
#include <memory>
#include <span>
#include <string>
#include <vector>

namespace crn
{

class LiveSession final : private FreeRunSink
{
  public:
    // `tools` lists the tools from the innermost outwards. `begin` holds the commands that the X-ray room
    // receives at the start. If `record` is empty, the session is not recorded. Throws the exceptions that
    // Device, Recorder and SessionPictures throw.
    LiveSession(const SceneFile &scene, const std::vector<Instrument> &tools, const crn_wire_entry &entry,
                const std::string &record, const PictureSettings &pictures,
                const std::vector<RoomCommand> &begin, const DeviceChoice &choice = {});

    std::span<LiveHand> hands() { return hands_; } // one per tool
    // Sets the rate at which the inflator's pressure changes from now on; a rate of 0 keeps the pressure.
    // If no tool has a balloon, the screen shows a notice instead.
    void inflate(std::int32_t kPa_per_s);
    void choose_tool(std::size_t tool, bool all); // marked in the display
    void command(const RoomCommand &command);     // in force from the next tick on; recorded
    void order(const crn_wire_order &order);      // for the next tick
    // Advances the session by `ticks` ticks and makes the pictures that become due. Returns false when the
    // device stopped; fault() gives the reason.
    bool advance(std::uint32_t ticks);
    const std::string &fault() const { return fault_; }
    // The session stops when the physics leaves its valid range: fault() then returns the notice, and range()
    // returns the details.
    const RangeWatch &range() const { return figures_.range; }
    void annotate(const std::string &notice, const std::vector<std::string> &panel);
    const Image &image() const { return pictures_.image(); }
    void finish(); // closes the recording and writes the runs
    // Returns the result of the session, in the form in which a script's session reports it; call this after
    // finish(). `tips` gives the vessels.
    RunResult result(const TipPlaces &tips) const;
    const SessionPictures &pictures() const { return pictures_; }
    Patient &patient() { return *patient_; }
    const SceneAnatomy &anatomy() const { return anatomy_; }
    const std::vector<std::string> &files() const { return pictures_.files(); } // written by finish()
    bool was_stopped() const { return pictures_.was_stopped(); } // Ctrl-C came while finish() wrote

  private:
    std::uint32_t batch_size(std::uint32_t wanted);
    void batch(std::uint32_t count);
    void advance_rig(std::uint32_t ticks);
    void tick(const crn_wire_live_tick &tick) override;
    void snapshot(std::uint32_t tick, std::span<const std::uint8_t> bytes) override;
    void resumed(std::uint32_t tick, std::span<const std::uint8_t> bytes) override;
    void record_state();
    void pass(std::uint32_t tick, const RoomCommand &command);
    void look_at_pedals();
    void picture();
    void stop_out_of_range();

    PictureSettings settings_;
    DeviceChoice choice_;
    Device device_;
    std::unique_ptr<Recorder> recorder_;
    const SceneAnatomy anatomy_;
    std::unique_ptr<Patient> patient_;
    SessionPictures pictures_;
    std::vector<LiveHand> hands_;
    HandGrip grip_; // grip of the keys
    SessionFigures figures_;
    ContactFigures contacts_;
    crn_wire_fault_log faults_{};
    std::uint64_t end_hash_ = 0;
    const std::chrono::steady_clock::time_point begin_ = std::chrono::steady_clock::now();
    RigPedals rig_pedals_;
    RigSyringe rig_syringe_;
    OrderQueue orders_;
    const bool has_balloon_;
    std::int32_t inflation_kPa_per_s_ = 0, inflator_milli_kPa_ = 0; // 1/1000 kPa
    std::uint32_t buttons_ = 0; // pedals pressed by key, as a rig would send them
    std::vector<crn_wire_tick_input> inputs_;
    crn_wire_tick_state state_{};
    SessionFrame frame_;
    std::uint32_t hash_tick_ = 0;
    std::uint32_t led_tick_ = 0; // FREE_RUN: the last received tick
    std::string fault_;
    bool has_stopped_ = false; // by itself, because physics left its range
};

} // namespace crn
