// Runs a session that a person controls; it has one device, one recording, one patient and the thread of its
// pictures. An object of this class serves one session; after a reset the GUI makes a new object. In the mode
// FREE_RUN, a device computes ticks by its own clock, and its encoders measure the motion of the user's
// hands. The pedals of a rig work in addition to the pedal keys of the keyboard. Only one thread at a time
// may use an object of this class.
#pragma once
#include "host/live/hand_speed.hpp"
#include "host/live/picture_thread.hpp"
#include "host/live/suite_state.hpp"
#include "host/model/order_queue.hpp"
#include "host/rig/pedals.hpp"
#include "host/script/hand_motion.hpp"
#include "host/session/device.hpp"
#include "host/session/hand_grip.hpp"
#include "host/session/range_watch.hpp"
#include "host/session/run.hpp"
#include <chrono>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

namespace crn
{

class LiveSession final : private FreeRunSink
{
  public:
    // `tools` lists all tools of the session, and pictures.line states which of them are in use at the start
    // (tool_line.hpp). `begin` holds the commands that the X-ray room receives at the start. If `record` is
    // empty, the session is not recorded. Throws the exceptions that Device, Recorder and PictureThread
    // throw.
    LiveSession(const SceneFile &scene, const std::vector<Instrument> &tools, const crn_wire_entry &entry,
                const std::string &record, const PictureSettings &pictures,
                const std::vector<RoomCommand> &begin, const DeviceChoice &choice = {},
                bool keeps_all_pictures = false);

    // --- what the user does; all of it is in force from the next tick on, and recorded ---

    // Sets the speeds of the hands, one per tool.
    void lead(std::span<const HandSpeed> speeds);
    // Moves one hand by a distance and an angle in encoder counts, at most as fast as a real hand can move.
    void drag(std::size_t tool, std::int32_t translation_counts, std::int32_t rotation_counts);
    // Sets the rate at which the inflator's pressure changes from now on; a rate of 0 keeps the pressure. If
    // no tool in use has a balloon, the screen shows a notice about this instead.
    void inflate(std::int32_t kPa_per_s);
    void command(const RoomCommand &command);
    void order(const crn_wire_order &order);
    // Replaces the tool at a position (0: innermost) by the tool with this number in the session's table,
    // from 1; the number 0 only removes the tool. If the replacement of a tool was refused, the patient's
    // notice() returns the reason.
    void exchange(std::uint8_t position, std::uint8_t tool);
    void note_input(SuiteClock::time_point when) { asked_ = when; } // for the delay from hand to picture

    // Advances the session by `ticks` ticks, and gives the pictures that become due to their thread. Returns
    // false when the device stopped; fault() gives the reason.
    bool advance(std::uint32_t ticks);
    std::uint32_t tick() const { return choice_.free_run ? led_tick_ : done_tick_; }
    // Each time the session has updated tools and patient (at least every 20 ms), it calls `observer` in its
    // own thread. The observer changes nothing.
    using Observer = std::function<void(const SessionFrame &, Patient &)>;
    void observe(Observer observer) { observer_ = std::move(observer); }
    bool has_own_clock() const { return choice_.free_run && choice_.is_usb; }
    const std::string &fault() const { return fault_; }
    // The session stops when the physics leaves its valid range: fault() then returns the notice, and range()
    // the details.
    const RangeWatch &range() const { return figures_.range; }
    SuiteState state() const; // a copy of what the window shows
    PictureThread &pictures() { return pictures_; }
    void finish(); // closes the recording and writes the runs
    // Returns the result of the session, in the form in which a script's session reports it; call this after
    // finish(). `tips` gives the vessels.
    RunResult result(const TipPlaces &tips) const;
    Patient &patient() { return *patient_; }
    const SceneAnatomy &anatomy() const { return anatomy_; }
    const std::vector<std::string> &files() const { return files_; } // written by finish()
    bool was_stopped() const { return was_stopped_; }                // Ctrl-C came while finish() wrote

  private:
    std::uint32_t batch_size(std::uint32_t wanted);
    void batch(std::uint32_t count);
    void advance_rig(std::uint32_t ticks);
    void tick(const crn_wire_live_tick &tick) override;
    void snapshot(std::uint32_t tick, std::span<const std::uint8_t> bytes) override;
    void resumed(std::uint32_t tick, std::span<const std::uint8_t> bytes) override;
    void record_state();
    void look_at_contacts(Link &link);
    void pass(std::uint32_t tick, const RoomCommand &command);
    void look_at_pedals();
    void look();
    void give_pictures();
    std::uint32_t next_look() const;
    void stop_out_of_range();
    static crn_wire_hand step_of_drag(crn_wire_hand &waiting);

    PictureSettings settings_;
    DeviceChoice choice_;
    Device device_;
    std::unique_ptr<Recorder> recorder_;
    const SceneAnatomy anatomy_;
    std::unique_ptr<Patient> patient_;
    PictureThread pictures_;
    std::vector<LiveHand> hands_;
    std::vector<crn_wire_hand> dragged_, to_drag_; // by the mouse: done, and still to do
    HandGrip grip_;                                // grip of the keys
    SessionFigures figures_;
    ContactFigures contacts_;
    crn_wire_fault_log faults_{};
    std::uint64_t end_hash_ = 0;
    const std::chrono::steady_clock::time_point begin_ = std::chrono::steady_clock::now();
    RigPedals rig_pedals_;
    RigSyringe rig_syringe_;
    OrderQueue orders_;
    std::int32_t inflation_kPa_per_s_ = 0, inflator_milli_kPa_ = 0; // 1/1000 kPa
    std::uint32_t buttons_ = 0; // pedals pressed by key, as a rig would send them
    std::vector<crn_wire_tick_input> inputs_;
    crn_wire_tick_state state_{};
    SessionFrame frame_;
    RoomNotice refused_; // of the inflator
    SuiteClock::time_point asked_{};
    std::uint32_t done_tick_ = 0;
    std::uint32_t hash_tick_ = 0;
    std::uint32_t led_tick_ = 0; // FREE_RUN: the last received tick
    Observer observer_;
    std::string fault_;
    std::vector<std::string> files_;
    bool was_stopped_ = false;
    bool has_stopped_ = false; // by itself, because physics left its range
};

} // namespace crn
