// Watches what tools do to the walls of the vessels in a session, and injures the vessels when a wall does
// not bear it (docs/complications.md). Two things are watched: the pressure of each tool's tip on the wall,
// from the contact forces of the core, and the size of the balloon, from its pressure and its maker's table.
//
//   if (complications.feel(contacts)) complications.locate(frame, contrast);   every 16 ticks
//   complications.tick(state);                                                 every tick
//   complications.advance(frame, contrast);                                    no later than next_tick()
//
// The result depends only on the core's results at fixed ticks, so that a replay has the same injuries.
#pragma once
#include "host/complications/injury.hpp"
#include "host/model/tool_line.hpp"
#include "host/model/vessel_tree.hpp"
#include "host/model/wire_frame.hpp"
#include "host/patient/contrast.hpp"
#include "shared/wire/wire.h"
#include <array>
#include <optional>
#include <string>
#include <vector>

namespace crn
{

// Returns the diameter that a balloon would have without a vessel, from its maker's table: between two rows
// in proportion to the pressure, beyond the last row along its last segment. 0 if it is folded.
double free_balloon_mm(const crn_wire_instrument &tool, double pressure_kPa);
// Returns the area with which a tool's tip pushes: that of its whole end. The soft tip of a catheter gives
// way, so that it bears on more than the ring around its lumen.
double tip_area_mm2(const Instrument &tool);

// Describes how a tip pushes the wall in front of it.
struct TipPush {
    bool is_known = false; // it is outside all other tools, in the patient
    double force_N = 0.0;  // of the wall against the tip, along the tip
    Eigen::Vector3d place_m = Eigen::Vector3d::Zero(), ahead = Eigen::Vector3d::Zero();
};
// `contacts` are the forces of the wall on the nodes of `wire` at the same tick.
TipPush tip_push(const WireFrame &wire, const crn_wire_contacts &contacts, std::size_t tool);

class PatientComplications
{
  public:
    // A multiple of the ticks after which every session reads the forces: a balloon that has been inflated
    // since then is looked at in time.
    static constexpr std::uint32_t look_every_ticks = 80;

    PatientComplications(const VesselTree &vessels, const std::vector<Instrument> &tools);

    // Call this function after the tools at the changed positions were replaced.
    void set_tools(const std::vector<Instrument> &tools, ChangedPositions changed);
    void command(const RoomCommand &command) { take_command(limits_, command); }
    const ComplicationLimits &limits() const { return limits_; }

    // Receives the forces of the walls. Returns true if some force is so large that the shape of the tools at
    // this tick must be passed to locate().
    bool feel(const crn_wire_contacts &contacts);
    // The next two functions return true if the vessels were injured, or if an injury has grown.
    bool locate(const WireFrame &wire, PatientContrast &contrast);
    bool advance(const WireFrame &wire, PatientContrast &contrast);
    void tick(const crn_wire_tick_state &state);
    std::uint32_t next_tick() const; // UINT32_MAX: no balloon is inflated

    const std::vector<Injury> &injuries() const { return injuries_; }
    std::size_t count(InjuryKind kind) const;
    // Returns the blood that was lost around the heart, and in all.
    double lost_around_heart_ml(const ContrastFlow &flow) const;
    double pressure_left(const ContrastFlow &flow) const;
    // Returns the message about the last injury, or an empty string.
    std::string notice() const;

    void archive(StateArchive &state, std::uint32_t now, const std::vector<Instrument> &tools);

  private:
    // A watched limit, and the injury that has occurred since it was exceeded.
    struct Watch {
        LimitWatch limit;
        std::optional<std::size_t> injury;
        void reset() { *this = {}; }
    };
    struct Tip {
        Watch perforation, dissection;
    };
    struct Found { // what exceeds a limit
        InjuryCause cause = InjuryCause::tip;
        std::string tool;
        Eigen::Vector3d place_m = Eigen::Vector3d::Zero(), ahead = Eigen::Vector3d::Zero();
        double value = 0.0, force_N = 0.0, front_mm = 0.0; // diameter of the tip
        std::size_t cell = 0, begin = 0, end = 0;          // of a balloon: the cells that it stretches
    };
    bool watch(Watch &watch, InjuryKind kind, const Found &found, std::uint32_t tick, const FlowCells &cells,
               PatientContrast &contrast);
    double limit_of(InjuryKind kind, InjuryCause cause) const;
    std::optional<std::size_t> near(InjuryKind kind, std::size_t cell, const FlowCells &cells) const;
    Injury make(InjuryKind kind, const Found &found, std::uint32_t tick, const FlowCells &cells) const;
    void size(Injury &injury, const Found &found, const FlowCells &cells) const;
    void wound(const Injury &injury, std::uint32_t tick, const FlowCells &cells,
               PatientContrast &contrast) const;
    std::string vessel_name(std::size_t cell, const FlowCells &cells) const;
    std::optional<Found> stretched(const WireFrame &wire, const FlowCells &cells) const;

    const VesselTree vessels_;
    std::vector<Instrument> tools_;
    ComplicationLimits limits_;
    std::vector<Injury> injuries_;
    std::array<Tip, CRN_WIRE_TOOL_MAX> tips_;
    Watch balloon_perforation_, balloon_dissection_;
    crn_wire_contacts contacts_{}; // of the last call of feel()
    std::uint32_t balloon_kPa_ = 0, look_tick_ = 0;
};

} // namespace crn
