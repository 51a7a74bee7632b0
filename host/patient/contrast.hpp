// Simulates the contrast medium in a session from the ordered injections and the positions of the tools, and
// passes the medium to the X-ray. The medium depends only on the commands and on the shape of the tools at
// fixed ticks (next_tick). A replay therefore shows the same medium as the session, whatever pictures were
// requested. While the vessels contain no medium, nothing is computed.
#pragma once
#include "host/base/state_archive.hpp"
#include "host/effects/injector.hpp"
#include "host/effects/lumen_pressure.hpp"
#include "host/model/lesion_opening.hpp"
#include "host/model/tool_line.hpp"
#include "host/model/wire_frame.hpp"
#include "host/patient/moved_vessels.hpp"
#include "host/room/command.hpp"
#include "host/xray/paths/moved.hpp"
#include "host/xray/run.hpp"
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace crn
{

inline constexpr double iodine_default_mg_per_ml =
    350.0; // strength of the injected medium until a command changes it

// Returns the index of the tool that injects, counted from the innermost. `asked` is the number of the
// requested tool, counted from 1 for the innermost; the number 0 selects the outermost tool with a lumen. The
// function returns no value if the session has no such tool.
std::optional<std::size_t> injecting_tool(const std::vector<Instrument> &tools, std::int32_t asked);
// Returns true if the tool reaches more than 1 mm beyond the introducer. A tool that reaches no farther than
// 1 mm beyond the introducer counts as taken out, also from the lumens of other tools.
bool is_in_patient(const crn_wire_tool_state &tool);
// Returns the reason why these tools cannot carry out a command to the syringe, whatever their positions. The
// returned reason is empty if the tools can carry out the command, or if the command is not for the syringe.
// `iodine_mg_per_ml` is the strength of the injected medium.
std::string injection_refusal(const std::vector<Instrument> &tools, const RoomCommand &command,
                              double iodine_mg_per_ml);

// Returns the openings of a tool whose tip is at the arc length `tip_arc_m`: the end hole first, then the
// side holes. The flow is divided between the openings in proportion to their areas, because the resistance
// of the lumen between the holes is neglected.
std::vector<CatheterMouth> catheter_mouths(const Instrument &tool, const WireFrame &wire, double tip_arc_m);

// Holds how long this machine took for the computation, in seconds; these times are not part of the session's
// results.
struct ContrastCost {
    std::uint64_t steps = 0, frames = 0; // steps of 1 ms; frames in which medium was visible
    double step_s = 0.0, frame_s = 0.0;  // for the columns
};

class PatientContrast
{
  public:
    static constexpr std::uint32_t look_every_ticks =
        40; // ticks between looks at the tools, while medium is in the vessels

    // `motion` describes how heart and breath move the vessels; if it is nullptr, the vessels do not move.
    // `opening` describes the lesions that a balloon can open.
    PatientContrast(const VesselTree &vessels, const std::vector<Instrument> &tools,
                    const Motion *motion = nullptr, LesionOpening opening = {});

    // Call this function after the tools at the changed positions were replaced in this tick. An injection
    // through a tool that is taken out ends.
    void set_tools(const std::vector<Instrument> &tools, ChangedPositions changed, std::uint32_t tick);

    // Returns the reason why a command cannot be carried out with medium of this strength, or an empty string
    // if it can.
    std::string refusal(const RoomCommand &command, double iodine_mg_per_ml) const;
    // Checks the command as refusal() does, with the medium strength of the latest command, and carries it
    // out. Call this function when the command's tick is over, so that the tools are where they were at that
    // tick.
    std::string command(std::uint32_t tick, const RoomCommand &command);
    // Receives the core's heart phase; call this function for every tick before the frame of that tick. If
    // the heart phase is never passed on, the heart beats regularly, 70 times a minute. At the tick of an
    // injection, this function refuses the injection if the tools inside the lumen leave too little space in
    // it.
    void tick(const crn_wire_tick_state &state);
    // Returns the injections of the session that were refused.
    const std::vector<Refusal> &refusals() const { return refusals_; }
    std::uint32_t next_tick() const; // UINT32_MAX: no look is needed
    // Returns true if the tools were looked at in this frame.
    bool advance(const WireFrame &wire);

    // Injures the vessels (ContrastFlow::set_hole, set_flap) at the next look. From then on, while there is a
    // hole, the blood is simulated even without medium.
    void set_hole(std::size_t index, const WallHole &hole, std::uint32_t tick);
    void set_flap(std::size_t index, const WallFlap &flap, std::uint32_t tick);
    // Lets the flow follow holes that close, and sets the share of the arterial pressure that is left after a
    // loss of blood. Call it only after advance() has returned true, so that pictures change nothing.
    void follow_wounds(double pressure_share);
    double pressure_share() const { return pressure_share_; }
    const FlowCells &cells_at(const WireFrame &wire); // where heart and breath have moved them

    // curves() returns the columns of medium for the X-ray. colour() stores in each node of the tools the
    // iodine concentration in the blood around the node.
    const std::vector<SweptCurve> &curves() const { return curves_; }
    void colour(WireFrame &wire) const;

    bool was_used() const { return injector_.injected_ml() > 0.0; }
    double injected_ml() const { return injector_.injected_ml(); }
    double flow_ml_s() const { return fluid_.flow_ml_s; } // present flow of the injection
    // Returns the pressure in kPa for a flow of 1 ml/s through the outermost tool with a lumen, with the
    // tools where they are in `state`. The pressure for the flow is infinite if the lumen is closed, and has
    // no value if no tool has a lumen.
    std::optional<double> injection_kPa_per_ml_s(const crn_wire_tick_state &state) const;
    // Returns the medium that was injected after tick `from` up to tick `to` as DICOM files state it: total
    // volume, total time, mean flow and strength.
    std::optional<RunContrast> given(std::uint32_t from, std::uint32_t to) const;
    const ContrastFlow &flow() const { return flow_; }
    double received_mg(std::size_t branch) const { return flow_.received_mg()[branch]; } // iodine
    const VesselTree &vessels() const { return vessels_; } // in the reference pose, as in the scene file
    VesselTree opened_vessels() const; // and with lesions as far open as in the last frame
    const ContrastCost &cost() const { return cost_; }

    // Saves or restores the state of the contrast medium at tick `now`. `tools` lists the tools in use, by
    // position, and `last` is the last tick. The columns of medium are not saved, but are made again from the
    // restored state.
    void archive(StateArchive &state, std::uint32_t now, const std::vector<Instrument> &tools,
                 const crn_wire_tick_state &last);

  private:
    void archive_lesions(StateArchive &state);
    void archive_syringe(StateArchive &state);
    void archive_columns(StateArchive &state);
    void reopen();
    BeatPhase beat_at(std::uint32_t tick, std::size_t &next) const;
    void place_vessels(const WireFrame &wire);
    bool open_vessels(const WireFrame &wire); // returns true if their shape has changed
    enum class State { idle, waits, flows };
    void look(const WireFrame &wire);
    void note_given(std::uint32_t tick);
    std::uint32_t look_due() const;
    void make_curves();
    Eigen::Vector3d column_begin_m(std::size_t cell) const;
    void add_mouth(SweptCurve &curve, const SweptPoint &first, std::size_t cell) const;
    // Moves the settled part of a cell's medium from the whole width to the core, and the core down.
    Eigen::Vector3d settle(std::size_t cell, double &core_mg_per_ml, double &wall_mg_per_ml) const;
    void add_mixed_begin(SweptCurve &curve, const SweptPoint &first, std::size_t cell) const;
    void make_curves_of(std::size_t branch, bool is_core);
    void make_small_curves(const VesselTree &now); // contrast_small.cpp
    void make_small_curve(const VesselBranch &vessel, std::size_t index);
    void make_blush(const VesselTree &now);
    void make_sinuses();
    void make_wounds(); // contrast_wounds.cpp
    void make_jet(const WallHole &hole, const Eigen::Vector3d &ball_m);
    void make_pocket(const WallFlap &flap);
    void wake(std::uint32_t tick);
    void take_injuries();
    void narrow(std::size_t cell, SweptPoint &point) const; // by a flap
    bool is_forgotten() const;
    double stream_at(std::size_t cell, double &behind_tip_mm) const;
    SweptPoint stream_point(std::size_t cell, double narrowness) const;

    std::vector<Instrument> tools_; // at the positions of the line
    const VesselTree vessels_;      // in the reference pose
    MovedVessels moved_;
    const LesionOpening opening_;
    std::vector<double> flow_open_,
        seen_open_; // how far lesions are open: in flow_, and in the last frame
    ContrastFlow flow_;
    Injector injector_;
    State state_ = State::idle;
    std::int64_t seen_tick_ = -1;          // of the last frame
    std::uint32_t look_tick_ = 0;          // of the last look
    std::uint32_t wake_tick_ = UINT32_MAX; // of the look from which on a hole bleeds; none
    double pressure_share_ = 1.0;
    // Injuries since the last look: a hole or a flap, and its index.
    std::vector<std::pair<std::size_t, WallHole>> new_holes_;
    std::vector<std::pair<std::size_t, WallFlap>> new_flaps_;
    std::size_t tool_ = 0; // tool at the syringe
    double iodine_mg_per_ml_ = iodine_default_mg_per_ml;
    InjectedFluid fluid_;
    struct Beat {
        std::uint32_t tick = 0;
        BeatPhase phase;
    };
    std::vector<Beat> beats_; // of the ticks since the last frame
    ContrastCost cost_;
    struct Given { // a period of constant flow, from tick to tick
        std::uint32_t tick_begin = 0, tick_end = 0;
        InjectedFluid fluid;
    };
    std::vector<Given> given_; // since the session began
    struct Stream {            // the stream from the tip, while medium is injected
        std::size_t cell = 0;
        Eigen::Vector3d tip_m = Eigen::Vector3d::Zero();
        double share = 1.0;    // share of the medium that leaves at the tip
        double strength = 0.0; // 1 during the injection; falls to 0 after it
    } stream_;
    struct Asked { // an injection whose tick has not come
        std::uint32_t tick = 0;
        std::uint64_t number = 0;
        std::size_t tool = 0;
        double flow_ml_s = 0.0, iodine_mg_per_ml = 0.0;
    };
    std::vector<InnerTool> inside(std::size_t tool, const crn_wire_tick_state &state) const;
    std::string pressure_refusal(const Asked &asked, const crn_wire_tick_state &state) const;
    void judge_asked();
    std::vector<Asked> asked_;
    crn_wire_tick_state last_{};
    std::vector<Refusal> refusals_;
    std::vector<double> mean_flows_ml_s_; // through each cell, at rest
    std::vector<SweptCurve> curves_;
    // Holds the phases of heart and breath, and the strength of the medium, for which the columns in curves_
    // were made.
    MotionMoment curves_at_;
    double curves_mg_per_ml_ = iodine_default_mg_per_ml;
};

} // namespace crn
