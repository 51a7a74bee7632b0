// Session scripts (docs/session.md): what hand and C-arm do, as text -> encoder counts per tick and view changes.
//
//   Session session = read_session("aorta.session");
//   SessionPlayer player(session);
//   while (!player.is_done()) { input = player.next(); ...; player.observe(inserted_m); }
//
// Errors name file, line and column and suggest a spelling. May include: hand_motion, view_state, model/text.
#pragma once
#include "host/app/hand_motion.hpp"
#include "host/app/view_state.hpp"
#include "shared/wire/wire.h"
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace seld
{

enum class HandAxis { translation, rotation };

struct HandMove {
    HandAxis axis = HandAxis::translation;
    std::int64_t distance_counts = 0;    // signed; for `until`, only its sign counts
    std::int64_t speed_counts_per_s = 0; // positive
    std::int64_t stroke_counts = 0;      // 0: one stroke
    std::optional<std::int64_t> until_inserted_um;
};

// One line of the script: moves of the hand (together), or a pause, or a view change.
struct Statement {
    int line = 0;
    std::vector<HandMove> moves;
    std::uint32_t wait_ticks = 0;
    std::optional<ViewState> view; // the whole state after this statement
};

struct Session {
    std::string file;
    std::uint32_t inserted_um = 20000; // outside the inserter at the start
    std::vector<Statement> statements;
};

Session parse_session(std::string_view text, const std::string &file); // throws FileError
Session read_session(const std::string &path);                         // throws FileError

class SessionPlayer
{
  public:
    // Conditions are looked at only on ticks that are multiples of this, whatever the batches and pictures.
    static constexpr std::uint32_t observe_every_ticks = 16;
    static constexpr std::uint32_t until_limit_ticks = 60000;

    explicit SessionPlayer(const Session &session);
    bool is_done() const { return statement_ == session_.statements.size(); }
    seld_wire_encoders next();       // input of the next tick
    void observe(double inserted_m); // after each tick that is a multiple of observe_every_ticks
    const ViewState &view() const { return view_; }
    // Lines whose `until` was not reached within until_limit_ticks of pushing.
    const std::vector<int> &given_up_lines() const { return given_up_lines_; }

  private:
    void enter_statement();
    void finish_statement();

    const Session &session_;
    std::size_t statement_ = 0;
    std::int64_t tick_in_statement_ = 0;
    struct Stroke {
        std::int64_t begin_tick;
        std::int64_t begin_counts;
        Move move;
    };
    struct Active {
        HandMove what;
        std::int64_t begin_counts;
        std::vector<Stroke> strokes;
        std::optional<SteadyMove> steady;
        std::int64_t ticks = 0;
    };
    std::vector<Active> active_;
    std::int64_t position_counts_[2] = {0, 0};
    ViewState view_;
    std::vector<int> given_up_lines_;
};

} // namespace seld
