// Executes statements that steer a tool as a person does (docs/session.md): the hand pushes, turns, pulls
// back and tries again, until the tip lies in the named vessel.
//
//   steer wire into ascending aorta at 60 mm/s until 30 mm within 90 s
//   engage catheter left main ostium
//
// Every decision uses only integers, and is made at the ticks at which the script observes the session. A
// session therefore gives equal encoder counts, whatever pictures are made. While a statement steers a tool,
// the encoder counts are those of an ordinary motion of a hand.
#pragma once
#include "host/script/hand_motion.hpp"
#include "host/script/tip_places.hpp"
#include "host/script/tool.hpp"
#include <cstdint>
#include <optional>
#include <string>

namespace crn
{

struct Steering {
    std::size_t tool = 0;
    bool engages = false; // an ostium, from a wide vessel: slowly, passing it in both directions
    VesselName vessel;
    std::int64_t speed_um_s = 0;
    std::int64_t depth_um = 0; // depth inside the vessel
    std::int64_t limit_ticks = 0;
};

// Parses the words of a line after "steer" or "engage". Throws FileError; the message gives the line's
// position in the file.
Steering parse_steering(LineParser &line, bool engages, const ToolChoice &selected);

// Holds the result of one steering statement, for the report and for the text printed at the end of a run.
struct SteeringResult {
    int line = 0;
    std::size_t tool = 0;
    std::string vessel;
    int tries = 1;
    std::uint32_t ticks = 0;
    bool is_reached = false;
};

class Steerer
{
  public:
    Steerer(const Steering &what, const VesselMap &map, std::size_t goal);

    struct Counts {
        std::int64_t translation = 0, rotation = 0;
    };
    Counts next(); // counts of the hand since the statement began, one tick later
    // Receives the position of the tip; the caller must call this function at all ticks that are multiples of
    // SessionPlayer::observe_every_ticks. `inserted_um` is the inserted length of the steered tool.
    void observe(const TipPlace &tip, std::int64_t inserted_um);

    bool is_done() const { return stage_ == Stage::done; }
    bool has_failed() const { return stage_ == Stage::failed; }
    // Returns the reason why steering failed, with the position of the tip and a remedy.
    std::string failure() const;
    int tries() const { return tries_; }
    std::int64_t ticks() const { return tick_; }

  private:
    enum class Stage {
        push,  // push towards the goal
        pull,  // pull back to before the place where it went wrong
        turn,  // turn the hand, with the tip free
        rest,  // wait until the tip has followed the turn
        seat,  // push a little deeper, stroke by stroke, from inside the ostium
        watch, // check that it stays inside
        done,
        failed
    };
    void begin(Stage stage);
    void stop_for(Stage next);
    void go_back();
    void look_pushing();
    void look_pulling(std::int64_t inserted_um);
    void look_seating();
    void look_watching();
    bool is_in_goal(std::int64_t least_um) const;
    std::int64_t route_left_um() const;
    std::int64_t left_um() const; // distance to the wanted place
    std::int64_t next_angle();
    std::int64_t spin_of(int attempt) const; // counts/s; 0: pushed without spinning

    const Steering what_;
    const VesselMap &map_;
    const std::size_t goal_;
    Stage stage_ = Stage::rest, after_ = Stage::push, after_turn_ = Stage::push;
    std::int64_t tick_ = 0, stage_tick_ = 0;
    Counts base_, now_;
    std::optional<SteadyMove> run_, spin_; // push and pull, and a simultaneous turn
    std::optional<Move> stroke_, twist_;   // for the stages seat and turn
    std::int64_t rest_ticks_ = 0;
    std::int64_t angle_ = 0; // angle of the hand relative to the beginning

    TipPlace tip_;
    VesselWay way_;
    bool has_looked_ = false;
    std::int64_t reach_um_ = 0, back_um_ = 0; // limit of the displacement; distance of the pull
    std::int64_t best_um_ = 0,
                 best_at_ = 0;  // of this push: the least distance left, and the hand's position there
    std::int64_t wrong_um_ = 0; // distance left on the route where it went wrong
    bool was_in_goal_ = false;  // was in the goal
    std::int64_t seat_best_um_ = 0;
    int tries_ = 1, seat_misses_ = 0;
    std::int64_t turns_ = 0;
};

} // namespace crn
