// Reads and plays session scripts (docs/session.md), which are texts that describe the actions of hands and
// C-arm. The code below converts a script to encoder counts for every tick, and to commands for the X-ray
// room.
//
//   Session session = read_session("aorta.session");
//   SessionPlayer player(session, tool_count);
//   while (!player.is_done()) { input = player.next(); ...; player.observe({inserted_m, tips}); }
//
// Error messages give file, line and column, and suggest the right spelling of a word.
#pragma once
#include "host/model/order_queue.hpp"
#include "host/model/tool_line.hpp"
#include "host/room/command.hpp"
#include "host/script/expect.hpp"
#include "host/script/hand_motion.hpp"
#include "host/script/steer.hpp"
#include "shared/wire/wire.h"
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace crn
{

enum class HandAxis { translation, rotation };

struct HandMove {
    std::size_t tool = 0;
    bool moves_all = false; // moves every tool of the line alike; `tool` is not used
    HandAxis axis = HandAxis::translation;
    std::int64_t distance_counts = 0;    // signed; for `until` only its sign counts
    std::int64_t speed_counts_per_s = 0; // positive
    std::int64_t stroke_counts = 0;      // 0: one stroke
    std::optional<std::int64_t> until_inserted_um;
};

// Describes a change of the inflator's pressure to a given value at a steady rate.
struct Inflation {
    std::int32_t kPa = 0, kPa_per_s = 100;
};

// Describes the replacement of the tool at one position by another tool, or its removal (docs/session.md,
// "Exchange").
struct Exchange {
    std::size_t position = 0;
    std::string tool; // name or number in the table; empty: the position becomes free
};

// One line of the script. A statement contains simultaneous moves of hands, a tool to steer, a pause, or a
// change of the inflator's pressure. A statement may also contain a list of commands to the X-ray room, a
// command to heart and breath, or an expectation.
struct Statement {
    int line = 0;
    std::vector<HandMove> moves;
    std::uint32_t wait_ticks = 0;
    std::vector<RoomCommand> room;
    std::optional<crn_wire_order> order;
    std::optional<Inflation> inflation;
    std::optional<Steering> steering;
    std::optional<Expectation> expectation;
    std::optional<Exchange> exchange; // resolve_tools() makes an order of it
};

// Names the files for which a script was written, as its `needs` statements state them. The options --scene,
// --tool and --stent replace these names; --tool lists the tools from the innermost, or in any order if the
// script has `begin with`.
struct SessionNeeds {
    std::string scene; // empty: free space, or not stated
    std::vector<std::string> tools, stents;
};

inline constexpr std::uint32_t inserted_unstated = 0xffffffffu;

struct Session {
    std::string file;
    SessionNeeds needs;
    // Holds the inserted length of each tool at the start of the session. The statement `begin inserted` sets
    // the inserted length of all tools that no other `begin` statement names. If no statement sets a tool's
    // inserted length, the start length of the scene applies.
    std::uint32_t inserted_um[session_tools_max] = {inserted_unstated, inserted_unstated, inserted_unstated};
    std::vector<std::string> line_names{}; // of `begin with`: name or number of the tool at each position
    int line_names_line = 0;
    std::vector<Statement> statements{};
    std::size_t tools_named = 1; // number of tools that the script needs ...
    int tools_named_line = 0;    // ... because of this line
};

Session parse_session(std::string_view text, const std::string &file); // throws FileError
Session read_session(const std::string &path);                         // throws FileError

// Finds the new tool of every replacement of tools in a script, as its number in this list of names. Returns
// the numbers of the tools in use at the start (tool_line.hpp). If a script has no statement `begin with`,
// the returned list of numbers is empty, and at most three tools are allowed. Throws FileError if a name is
// unknown, or names several tools.
LineNumbers resolve_tools(Session &session, std::span<const std::string> names);
inline constexpr std::string_view free_position = "nothing"; // a free position in `begin with`

class SessionPlayer
{
  public:
    // The conditions of a script are checked only at ticks that are multiples of this number, so that the
    // results do not depend on pictures or on the size of tick batches.
    static constexpr std::uint32_t observe_every_ticks = 16;
    static constexpr std::uint32_t until_limit_ticks = 60000;

    // Throws FileError when the script names a tool or a vessel that does not exist. `vessels` is the map of
    // the scene's vessels; if it is nullptr, no vessel is known.
    SessionPlayer(const Session &session, std::size_t tool_count, const VesselMap *vessels = nullptr);
    bool is_done() const { return statement_ == session_.statements.size(); }
    crn_wire_tick_input next(); // input of the next tick
    // Receives the state of the session after each tick that is a multiple of observe_every_ticks. The fields
    // `tips` and `witness` are needed only while wants_tips() returns true.
    void observe(const SessionView &view);
    void observe(std::span<const double> inserted_m) { observe(SessionView{inserted_m, {}, nullptr}); }
    // Returns true if the present statement needs the positions of the tips, or is an expectation.
    bool wants_tips() const;
    // Receives from the state of a tick the answer to an exchange (replacement) of tools. A refused exchange
    // ends the script.
    void answer_exchange(std::uint8_t answer);
    bool expects() const { return !is_done() && session_.statements[statement_].expectation.has_value(); }
    // Returns the commands for the X-ray room that the script has given since the previous call of this
    // function. Before the first call of next(), this function returns the commands at the start of the
    // session.
    std::vector<RoomCommand> take_commands() { return std::exchange(commands_, {}); }
    // Returns the numbers of the lines whose `until` condition was still not met after until_limit_ticks of
    // pushing.
    const std::vector<int> &given_up_lines() const { return given_up_lines_; }
    const std::vector<SteeringResult> &steered() const { return steered_; }
    const std::vector<ExpectationResult> &expected() const { return expected_; }
    // Every message has the form "FILE:LINE: what was not reached or not true, what was found; remedy". The
    // script ends at the first statement that fails to reach its goal. If empty, every expectation held.
    const std::vector<std::string> &failures() const { return failures_; }

  private:
    void look_at_steering(const SessionView &view);
    void look_at_expectation(const SessionView &view);
    void fail(const std::string &text);
    std::size_t vessel_named(const VesselName &name, int line) const;
    double turned_deg(std::size_t tool) const;
    void enter_statement();
    void finish_statement();

    void begin_move(const HandMove &move, std::size_t tool);
    void begin_inflation(const Inflation &inflation);

    const Session &session_;
    std::size_t tool_count_;
    const VesselMap map_;
    std::vector<std::size_t> vessels_; // vessel named by each statement; 0 where it names none
    std::size_t statement_ = 0;
    std::int64_t tick_in_statement_ = 0;
    struct Stroke {
        std::int64_t begin_tick;
        std::int64_t begin_counts;
        Move move;
    };
    struct Active {
        HandMove what;
        std::size_t tool;
        std::int64_t begin_counts;
        std::vector<Stroke> strokes;
        std::optional<SteadyMove> steady;
        std::int64_t ticks = 0;
    };
    std::vector<Active> active_;
    std::int64_t position_counts_[session_tools_max][2] = {}; // translation, rotation
    void ask(const RoomCommand &command);
    std::vector<RoomCommand> commands_;
    OrderQueue orders_;
    std::int32_t inflator_kPa_ = 0;
    struct {
        std::int64_t begin_kPa = 0, way_kPa = 0, ticks = 0;
    } inflating_;
    std::uint32_t buttons_ = 0; // pedals as a rig would send them
    std::vector<int> given_up_lines_;
    std::optional<Steerer> steerer_;
    std::int64_t steer_begin_counts_[2] = {};
    std::vector<SteeringResult> steered_;
    std::vector<ExpectationResult> expected_;
    std::vector<std::string> failures_;
};

// Returns true if the script steers tools into vessels, or has expectations about vessels.
bool names_vessels(const Session &session);

} // namespace crn
