// Computes the pressure that the transducer of a catheter measures at the catheter's tip. The tip may narrow
// the vessel so much that little blood passes (a wedged or "damped" catheter). If the tip narrows the vessel,
// the pressure falls and its pulse gets smaller (docs/contrast.md, "Pressure at the catheter's tip").
//
//   pressure.tick(aortic_mmHg, state);     for every tick
//   pressure.advance(wire);                with the shape of the tools, no later than next_tick()
//
// The pressure depends only on the ticks and on the shape of the tools at fixed ticks, and not on which
// pictures are made.
#pragma once
#include "host/base/state_archive.hpp"
#include "host/effects/flow_cells.hpp"
#include "host/effects/flow_network.hpp"
#include "host/model/tool_line.hpp"
#include "host/model/wire_frame.hpp"
#include "host/patient/moved_vessels.hpp"
#include "shared/wire/wire.h"
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace crn
{

// Holds the pressures of one complete heartbeat, in mmHg.
struct BeatPressure {
    double systolic = 0.0, diastolic = 0.0, mean = 0.0;
    double pulse() const { return systolic - diastolic; }
};

class CatheterPressure
{
  public:
    static constexpr std::uint32_t look_every_ticks = 80;
    // Gives the pressure behind a balloon that blocks a coronary artery, as a share of the aortic pressure;
    // collateral vessels keep up this pressure (mean of 100 patients without coronary disease: Wustmann et
    // al., Circulation 2003;107:2213).
    static constexpr double collateral_share = 0.18;
    static constexpr double venous_mmHg = 6.0;
    // Gives the time constant with which the pressure behind a complete block falls; the value is an
    // assumption.
    static constexpr double bed_time_s = 0.3;
    // Gives the limit for a damped pressure: its pulse pressure is below this share of the aortic pulse
    // pressure. The value is an assumption.
    static constexpr double damped_pulse_share = 0.5;

    // `motion` may be nullptr. `tools` lists the tools from the innermost outwards; the transducer is at the
    // hub of the outermost tool with a lumen.
    CatheterPressure(const VesselTree &vessels, const std::vector<Instrument> &tools, const Motion *motion,
                     LesionOpening opening);

    // Call this function after the tools at the changed positions were replaced.
    void set_tools(const std::vector<Instrument> &tools, ChangedPositions changed);
    std::uint32_t next_tick() const; // UINT32_MAX: no catheter lies in the vessels
    void advance(const WireFrame &wire);
    // Adopts wounds of the vessels (FlowNetwork::set_wounds).
    void set_wounds(std::span<const CellHole> holes, std::span<const double> open_share);
    void tick(double aortic_mmHg, const crn_wire_tick_state &state);

    // Returns true if a catheter lies in the vessels and its tip has been located.
    bool is_measuring() const { return has_place_; }
    double pressure_mmHg() const { return pressure_mmHg_; }
    // Returns the pressure at the tip above that in the veins, as a share of the aortic pressure: 1 if the
    // blood flows freely, collateral_share if the tip blocks the vessel.
    double share() const { return share_; }
    // Returns true if the tip narrows the vessel so much that less than a tenth of the blood pressure passes
    // it.
    bool is_blocked() const;
    // Returns true if the catheter's pressure was damped in the last complete heartbeat. An injection while
    // the pressure is damped may injure the artery.
    bool is_damped() const { return is_damped_; }
    std::uint32_t damped_ticks() const { return damped_ticks_; } // of the session
    const BeatPressure &beat() const { return beat_; }           // the last complete one
    // Returns the name of the tool with the transducer; empty if no tool has a lumen.
    const std::string &tool_name() const { return name_; }

    // Saves or restores the state at tick `now`; `tools` lists the tools in use, by position.
    void archive(StateArchive &state, std::uint32_t now, const std::vector<Instrument> &tools);

  private:
    class BeatFigures
    {
      public:
        void take(double mmHg);
        BeatPressure end();
        void archive(StateArchive &state);

      private:
        double highest_ = 0.0, lowest_ = 1e9, sum_ = 0.0;
        std::uint32_t count_ = 0;
    };
    void open_vessels(const WireFrame &wire);
    void reopen();
    void end_beat();
    void leave();

    const VesselTree vessels_; // in the reference pose
    const LesionOpening opening_;
    double direct_share() const { return (share_ - collateral_share) / (1.0 - collateral_share); }
    std::optional<std::size_t> tool_;
    std::string name_;
    MovedVessels moved_;
    FlowCells cells_;
    FlowNetwork network_;
    std::vector<double> tool_mm_, open_;
    std::uint32_t look_tick_ = 0; // of the last look, or of the tick in which the tip entered the vessels
    bool is_inserted_ = false, has_place_ = false, is_damped_ = false;
    double share_ = 1.0, pressure_mmHg_ = 0.0;
    std::uint32_t beat_ms_ = UINT32_MAX, damped_ticks_ = 0;
    bool is_whole_beat_ = false; // the catheter has measured since the beat began
    BeatFigures measured_, aortic_;
    BeatPressure beat_;
};

} // namespace crn
