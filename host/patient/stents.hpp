// Simulates the stents in a session: a stent is mounted on the balloon, expanded by the balloon, deployed,
// and held by the vessel wall. This class sends the core its commands about stents, and passes the struts to
// the X-ray. The state of the stents depends only on the commands and on the tools' shape at multiples of
// look_every_ticks, whatever pictures were requested. The function give_orders() returns the commands for the
// core. The commands about stents become part of a tick's input, and are recorded. A replay sends the
// recorded commands to the core, and computes the stents again for pictures and reports.
//
//   PatientStents stents(shelf, bodies.vessels, motion, stations, tools);
//   stents.command(tick, {RoomAction::load_stent, {}});       the next one of the shelf onto the balloon
//   stents.advance(...) at stents.next_tick(); stents.give_orders(...) for every input after that
#pragma once
#include "host/base/state_archive.hpp"
#include "host/model/lesion_opening.hpp"
#include "host/model/order_queue.hpp"
#include "host/model/tool_line.hpp"
#include "host/model/wire_frame.hpp"
#include "host/room/command.hpp"
#include "host/stent/circles.hpp"
#include "host/stent/figures.hpp"
#include "host/stent/stents.hpp"
#include "host/xray/paths/moved.hpp"
#include "shared/wire/wire.h"
#include <array>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace crn
{

inline constexpr std::size_t stents_max = 8;  // largest number in a session
inline constexpr std::size_t struts_max = 64; // rings of struts that a core keeps (docs/wire.md)

// Returns the reason why a stent cannot be mounted on a balloon of these tools, or an empty string if it can.
std::string mount_refusal(const StentDesign &stent, const std::vector<Instrument> &tools);
// Reads stent files and checks that each stent can be mounted on a balloon of these tools. Throws FileError
// if a stent cannot be mounted; the message names its file.
std::vector<StentDesign> read_stents(const std::vector<std::string> &paths,
                                     const std::vector<Instrument> &tools);

// Holds the final results of one stent.
struct StentResult {
    std::string name, branch;                  // name, and vessel in which it is; empty: in none
    double diameter_mm = 0.0, length_mm = 0.0; // from the label
    StentStage stage = StentStage::on_balloon;
    bool was_taken_out = false; // the stent left the patient unopened with its balloon, and another one was
                                // loaded
    std::uint32_t loaded_tick = 0;
    std::optional<std::uint32_t> opened_tick, released_tick; // first ring opened; deployed or lost
    StentFigures figures;                                    // empty if the stent never was in the patient
    double stretch = 0.0, overlap_mm = 0.0; // stretch of the vessel; overlap with earlier deployed stents
    struct Lesion {
        std::size_t number = 0; // number of the vessel in the tree
        std::string name;
        StentCoverage coverage; // mm along the branch
    };
    std::vector<Lesion> lesions; // lesions of its branch
    double slip_mm = 0.0;
};

class PatientStents
{
  public:
    static constexpr std::uint32_t look_every_ticks = 40;

    // `stations` gives, in the order of the tree's lesions, the points at which the core computes the opening
    // of each lesion that a balloon can open. If `motion` is null, the vessels do not move. `tools` are the
    // tools in use, by position; if `has_table` is true, tools of the session's table may replace them.
    PatientStents(std::vector<StentDesign> shelf, const VesselTree &vessels, const Motion *motion,
                  std::vector<LesionStations> stations, const std::vector<Instrument> &tools,
                  bool has_table = false);
    // Call this function after the tools at the changed positions were replaced. A stent that is still on the
    // balloon leaves with its balloon.
    void set_tools(const std::vector<Instrument> &tools, ChangedPositions changed);

    // Carries out the command load_stent and ignores all other commands. If a command cannot be carried out,
    // it is kept in refusals().
    void command(std::uint32_t tick, const RoomCommand &command);
    void tick(const crn_wire_tick_input &input, const crn_wire_tick_state &state);
    std::uint32_t next_tick() const
    {
        return next_look_;
    } // tick of the next look; UINT32_MAX: none is needed
    void advance(const WireFrame &wire);
    // Adds the commands about stents that the core must carry out in the next tick.
    void give_orders(crn_wire_order_list &orders) { orders_.move_into(orders); }

    // Returns the struts at the moment of this frame, which may lie between two updates of the stents' state.
    // Nothing else changes.
    std::vector<SweptCurve> curves_at(const WireFrame &wire);

    const std::vector<StentDesign> &shelf() const { return shelf_; }
    std::size_t loaded() const { return loaded_; }
    const Stents &stents() const { return stents_; }
    std::string stage_text() const; // stage of the last loaded stent; empty: none was loaded
    std::vector<StentResult> results();
    const std::vector<std::string> &refusals() const { return refusals_; }

    // Saves or restores the stents; `tools` lists the tools in use, by position.
    void archive(StateArchive &state, const std::vector<Instrument> &tools);

  private:
    struct Vessel { // a branch whose wall may hold stents
        std::size_t branch = 0;
        std::unique_ptr<VesselWall> wall;
    };
    struct Story {             // history of a stent, in addition to its own state
        std::size_t shelf = 0; // index of its design
        double mount_mm = 0.0; // where it was mounted
        std::uint32_t loaded_tick = 0;
        std::optional<std::uint32_t> opened_tick, released_tick;
        std::optional<std::size_t> vessel; // index of the vessel where it is or was deployed
    };
    struct Taken { // the stent was taken out of the patient unopened
        std::string name;
        double diameter_mm, length_mm;
        std::uint32_t loaded_tick;
    };
    void load(std::uint32_t tick);
    void take_tools(const std::vector<Instrument> &tools);
    void take_out();
    std::optional<std::size_t> vessel_at(const BalloonPose &pose, const MotionMoment &moment);
    std::size_t vessel_of(std::size_t branch);
    void give_room(BalloonPose &pose, std::optional<std::size_t> vessel) const;
    void move_walls(const WireFrame &wire);
    std::vector<const StentWall *> walls() const;
    void note(const crn_wire_strut &ring);
    void note(const crn_wire_scaffold &hold);
    void note_stages(std::uint32_t tick);
    void ask_for_holds(const WireFrame &wire);
    void ask_for_struts(const WireFrame &wire);
    void archive_walls(StateArchive &state);
    void archive_stents(StateArchive &state);
    void archive_story(StateArchive &state, Story &story);
    void archive_core(StateArchive &state);
    void archive_order(StateArchive &state, crn_wire_order &order) const;

    const std::vector<StentDesign> shelf_;
    const VesselTree vessels_; // in the reference pose
    const std::optional<Motion> motion_;
    const std::vector<LesionStations> stations_;
    std::optional<std::size_t> tool_; // the tool with the balloon
    Instrument balloon_;              // that tool
    double mount_mm_ = 0.0, folded_end_m_ = 0.0;
    Stents stents_;
    std::vector<Story> stories_;
    std::vector<Taken> taken_out_;
    std::vector<Vessel> walls_;
    std::size_t loaded_ = 0;
    std::uint32_t next_look_ = UINT32_MAX;
    double inserted_m_ = 0.0;                               // inserted length of the balloon's tool
    WireFrame seen_;                                        // the last look, without its nodes
    std::vector<std::vector<std::uint32_t>> known_256_;     // openings in the core, per lesion and station
    std::array<crn_wire_strut, struts_max> known_struts_{}; // rings that the core has; inside_um 0: none
    OrderQueue orders_;
    std::vector<std::string> refusals_;
};

} // namespace crn
