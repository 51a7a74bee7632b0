// Observes a session for its assessment. The observer reads the state of the tools, the patient and the X-ray
// room every 16 ticks and changes nothing. The observer needs no pictures: it computes the place of a tip in
// the picture from the geometry of the C-arm.
//
//   AssessObserver observer(patient, tools, tips);
//   run_session(device, patient, session, recorder, &observer, settings);
//   const SessionLog &log = observer.log();
//
// In FREE_RUN, in which the rig's timer starts the ticks, the shape of the tools arrives at irregular times.
// A session on a rig is therefore assessed by a replay of its recording.
#pragma once
#include "host/assess/session_log.hpp"
#include "host/patient/patient.hpp"
#include "host/script/tip_places.hpp"
#include "host/session/frame_sink.hpp"

namespace crn
{

class AssessObserver final : public FrameSink
{
  public:
    // `tools` lists the session's tools; `patient` states which of these tools are in the vessels at present.
    // `patient` and `tips` must live longer than the observer.
    AssessObserver(Patient &patient, const std::vector<Instrument> &tools, const TipPlaces &tips);

    void tick(const crn_wire_tick_input &input, const crn_wire_tick_state &state) override;
    void contacts(const crn_wire_contacts &contacts) override;
    std::uint32_t next_tick() const override { return next_tick_; }
    void frame(const SessionFrame &frame) override;

    // Returns the moments that have been recorded so far.
    const SessionLog &log() const { return log_; }

  private:
    void follow_line();
    void look_at_tools(const SessionFrame &frame, SessionMoment &moment);
    void look_at_picture(ToolMoment &tool, const Eigen::Vector3d &tip_m) const;
    void look_at_room(SessionMoment &moment);
    void look_at_vessels(const WireFrame &wire, SessionMoment &moment);
    void look_at_stents(const WireFrame &wire, SessionMoment &moment);
    double lumen_mm(const TipPlace &tip) const;

    Patient &patient_;
    const TipPlaces &tips_;
    struct TableTool {
        std::string name;
        bool is_wire = false;
    };
    std::vector<TableTool> table_;
    LineNumbers line_; // at the latest moment
    SessionLog log_;
    std::uint32_t next_tick_ = 0;
    double wall_N_ = 0.0;
    bool was_acquiring_ = false;
    double injected_at_run_ml_ = 0.0; // when the present run began
};

} // namespace crn
