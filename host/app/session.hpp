// Session scripts (docs/session.md): what hands and C-arm do, as text -> encoder counts per tick and commands to the room.
//
//   Session session = read_session("aorta.session");
//   SessionPlayer player(session, tool_count);
//   while (!player.is_done()) { input = player.next(); ...; player.observe(inserted_m); }
//
// Errors name file, line and column and suggest a spelling. May include: hand_motion, rhythm_order, room/command, model/text.
#pragma once
#include "host/app/hand_motion.hpp"
#include "host/app/rhythm_order.hpp"
#include "host/room/command.hpp"
#include "shared/wire/wire.h"
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace seld
{

enum class HandAxis { translation, rotation };

// Tools are numbered from the innermost, 0, as on the wire; a script says wire, catheter, guide, or tool 1 to 3.
inline constexpr std::size_t session_tools_max = SELD_WIRE_TOOL_MAX;

struct HandMove {
    std::size_t tool = 0;
    bool moves_all = false; // every tool of the line alike; `tool` is not used
    HandAxis axis = HandAxis::translation;
    std::int64_t distance_counts = 0;    // signed; for `until`, only its sign counts
    std::int64_t speed_counts_per_s = 0; // positive
    std::int64_t stroke_counts = 0;      // 0: one stroke
    std::optional<std::int64_t> until_inserted_um;
};

// The inflator goes to a pressure at a steady rate.
struct Inflation {
    std::int32_t kPa = 0, kPa_per_s = 100;
};

// One line of the script: moves of hands (together), or a pause, or the inflator's way, or commands to the room, or something asked of heart and breath.
struct Statement {
    int line = 0;
    std::vector<HandMove> moves;
    std::uint32_t wait_ticks = 0;
    std::vector<RoomCommand> room;
    std::optional<RhythmOrder> rhythm;
    std::optional<Inflation> inflation;
};

struct Session {
    std::string file;
    // Outside the inserter at the start, per tool; those not named begin as far out as `begin inserted` says.
    std::uint32_t inserted_um[session_tools_max] = {20000, 20000, 20000};
    std::vector<Statement> statements;
    std::size_t tools_named = 1; // the script needs at least so many tools ...
    int tools_named_line = 0;    // ... because of this line
};

Session parse_session(std::string_view text, const std::string &file); // throws FileError
Session read_session(const std::string &path);                         // throws FileError

class SessionPlayer
{
  public:
    // Conditions are looked at only on ticks that are multiples of this, whatever the batches and pictures.
    static constexpr std::uint32_t observe_every_ticks = 16;
    static constexpr std::uint32_t until_limit_ticks = 60000;

    // Throws FileError when the script names a tool that is not there.
    SessionPlayer(const Session &session, std::size_t tool_count);
    bool is_done() const { return statement_ == session_.statements.size(); }
    seld_wire_encoders next(); // input of the next tick
    // After each tick that is a multiple of observe_every_ticks: the length inserted of every tool.
    void observe(std::span<const double> inserted_m);
    // What the room was asked for since the last call; before the first next(): with the beginning.
    std::vector<RoomCommand> take_commands() { return std::exchange(commands_, {}); }
    // Lines whose `until` was not reached within until_limit_ticks of pushing.
    const std::vector<int> &given_up_lines() const { return given_up_lines_; }

  private:
    void enter_statement();
    void finish_statement();

    void begin_move(const HandMove &move, std::size_t tool);
    void begin_inflation(const Inflation &inflation);

    const Session &session_;
    std::size_t tool_count_;
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
    RhythmOrders rhythm_;
    std::int32_t inflator_kPa_ = 0;
    struct {
        std::int64_t begin_kPa = 0, way_kPa = 0, ticks = 0;
    } inflating_;
    std::uint32_t buttons_ = 0; // pedals as the rig would send them
    std::vector<int> given_up_lines_;
};

} // namespace seld
