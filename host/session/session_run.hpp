// Runs the session of a script step by step, so that its caller may read the session at any tick.
// run_session() runs it to its end at once.
//
//   SessionRun run(device, patient, session, recorder, sink, settings);
//   while (!run.is_over()) run.advance_to(run.tick() + 100);
//   RunResult result = run.end();
//
// The ticks at which the caller stops change neither the result nor a byte of the recording.
#pragma once
#include "host/session/run.hpp"
#include <chrono>

namespace crn
{

class SessionRun
{
  public:
    // All references must live longer than this object; `recorder` and `sink` may be nullptr. Throws
    // FileError if the script names a tool or a vessel that does not exist; LinkError, RecordingError.
    SessionRun(SteppedDevice &device, Patient &patient, const Session &session, Recorder *recorder,
               FrameSink *sink, const RunSettings &settings);

    // Returns true when the script has ended, the user has interrupted it, or physics has left its range.
    bool is_over() const;
    std::uint32_t tick() const { return link_.tick(); }
    // Advances to this tick, or to the session's end if that comes first. Throws LinkError, RecordingError.
    void advance_to(std::uint32_t tick);
    // Advances to the next pulse of the X-ray room if that comes before `tick`. Returns true at a pulse.
    bool advance_to_pulse(std::uint32_t tick);
    // Returns false inside a batch of ticks, whose inputs and orders are already made.
    bool is_batch_done() const { return stepped_ == inputs_.size(); }
    // Ends the session here: completes the recording and returns the result. Call it once, as the last
    // function.
    RunResult end();

  private:
    std::uint32_t batch_size() const;
    std::uint32_t next_stop() const;
    void begin_batch();
    void batch(std::uint32_t limit);
    void end_batch();
    void look(bool has_nodes);
    bool pass_commands(std::uint32_t tick);
    void pass(std::uint32_t tick, const RoomCommand &command);
    void look_at_contacts();
    void record_state();
    void look_when_due();
    void show_progress();
    bool has_pulse() const;
    std::vector<double> inserted() const;

    std::chrono::steady_clock::time_point begin_ = std::chrono::steady_clock::now();
    SteppedDevice &device_;
    Link &link_;
    Patient &patient_;
    SessionPlayer player_;
    Recorder *recorder_;
    FrameSink *sink_;
    const RunSettings settings_;
    HandGrip grip_;
    SessionFigures figures_;
    ContactFigures contacts_;
    crn_wire_tick_state state_{};
    std::vector<crn_wire_tick_input> inputs_; // of the present batch
    std::size_t stepped_ = 0; // of these inputs; fewer: the caller has stopped inside the batch
    bool is_look_due_ = false, wants_nodes_ = false; // at the end of the batch
    std::uint32_t progress_tick_ = 0;
    std::uint32_t hash_tick_ = 0;
};

} // namespace crn
