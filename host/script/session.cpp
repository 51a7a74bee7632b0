#include "host/script/session.hpp"
#include "host/base/text.hpp"
#include "host/script/line.hpp"
#include "host/script/rhythm.hpp"
#include "host/script/room.hpp"
#include "host/script/tool.hpp"
#include <algorithm>
#include <cmath>

namespace crn
{

namespace
{

const std::vector<std::string> hand_verbs = {"needs",  "begin",  "advance", "withdraw", "rotate",
                                             "select", "tool",   "wait",    "inflate",  "deflate",
                                             "steer",  "engage", "expect",  "exchange", "remove"};
const std::vector<Unit> pressure_units = {{"bar", 100.0}, {"atm", 101.325}, {"kPa", 1.0}};
const std::vector<Unit> pressure_rate_units = {{"bar/s", 100.0}, {"atm/s", 101.325}, {"kPa/s", 1.0}};
HandMove parse_push(LineParser &line, int sign)
{
    HandMove move;
    move.axis = HandAxis::translation;
    move.distance_counts = sign;
    double speed_m_s = 0.03;
    if (line.accept("until")) {
        line.expect("inserted");
        move.until_inserted_um = std::llround(line.quantity("length", length_units, 0.0, 1.6) * 1e6);
    } else {
        move.distance_counts =
            sign * std::llround(line.quantity("distance", length_units, 0.0, 1.6) * counts_per_m);
    }
    if (line.accept("at")) speed_m_s = line.quantity("speed", speed_units, 1e-4, 0.5);
    if (!move.until_inserted_um && line.accept("in")) {
        line.expect("strokes");
        line.expect("of");
        move.stroke_counts = std::llround(line.quantity("stroke", length_units, 1e-3, 1.6) * counts_per_m);
    }
    move.speed_counts_per_s = std::llround(speed_m_s * counts_per_m);
    return move;
}

HandMove parse_rotate(LineParser &line)
{
    HandMove move;
    move.axis = HandAxis::rotation;
    double speed_deg_s = 120.0;
    move.distance_counts =
        std::llround(line.quantity("angle", angle_units, -36000.0, 36000.0) * counts_per_turn / 360.0);
    if (line.accept("at")) speed_deg_s = line.quantity("speed", turn_speed_units, 1.0, 1080.0);
    move.speed_counts_per_s = std::llround(speed_deg_s * counts_per_turn / 360.0);
    return move;
}

HandMove parse_move(LineParser &line, const ToolChoice &selected)
{
    const std::string verb = line.choice("motion", {"advance", "withdraw", "rotate"});
    const ToolChoice choice = accept_tool(line).value_or(selected);
    HandMove move = verb == "rotate" ? parse_rotate(line) : parse_push(line, verb == "advance" ? 1 : -1);
    move.tool = choice.tool;
    move.moves_all = choice.is_all;
    return move;
}

std::vector<std::string> all_verbs()
{
    std::vector<std::string> verbs = hand_verbs;
    verbs.insert(verbs.end(), room_verbs().begin(), room_verbs().end());
    verbs.insert(verbs.end(), rhythm_verbs().begin(), rhythm_verbs().end());
    return verbs;
}

bool is_same_hand(const HandMove &a, const HandMove &b)
{
    return a.axis == b.axis && (a.moves_all || b.moves_all || a.tool == b.tool);
}

// Parses a script, and remembers the settings of the X-ray room from statement to statement.
class SessionParser
{
  public:
    explicit SessionParser(const std::string &file) { session_.file = file; }

    void line(int number, std::string_view text)
    {
        LineParser line(session_.file, number, split_line(text));
        if (line.is_at_end()) return;
        statement(line, number);
        if (!line.is_at_end())
            line.fail("'" + line.peek() + "' does not belong here; one statement per line");
    }

    Session take() { return std::move(session_); }

  private:
    void statement(LineParser &line, int number)
    {
        if (line.peek() == "advance" || line.peek() == "withdraw" || line.peek() == "rotate") {
            moves(line, number);
            return;
        }
        Statement statement;
        statement.line = number;
        if (line.peek() == "needs" && (has_begun_ || !session_.statements.empty() || has_selected_))
            line.fail("'needs' must come before all other statements");
        if (line.peek() == "begin" && (!session_.statements.empty() || has_selected_))
            line.fail("'begin' must be the first statement");
        const std::string verb = line.choice("statement", all_verbs());
        if (verb == "needs") return needs(line);
        has_begun_ = true;
        if (verb == "begin") return begin(line, number);
        if (verb == "select" || verb == "tool") {
            selected_ = require_tool(line);
            has_selected_ = true;
            note_tool(selected_, number);
            return;
        }
        if (verb == "exchange" || verb == "remove" || (verb == "load" && line.peek() != "stent")) {
            exchange(line, verb, statement);
        } else if (verb == "wait") {
            statement.wait_ticks = static_cast<std::uint32_t>(
                std::lround(line.quantity("time", time_units, 0.001, 3600.0) * 1e3));
        } else if (verb == "steer" || verb == "engage") {
            statement.steering = parse_steering(line, verb == "engage", selected_);
            note_tool({statement.steering->tool, false}, number);
        } else if (verb == "expect") {
            statement.expectation = parse_expectation(line, selected_);
            note_tool({statement.expectation->tool, false}, number);
        } else if (verb == "inflate" || verb == "deflate") {
            statement.inflation = inflation(line, verb == "inflate");
        } else if (std::find(rhythm_verbs().begin(), rhythm_verbs().end(), verb) != rhythm_verbs().end()) {
            statement.order = parse_rhythm(line, verb);
        } else {
            statement.room = room_.parse(line, verb);
        }
        session_.statements.push_back(statement);
    }

    // Reads statements such as "inflate to 8 bar at 2 bar/s", or "deflate at 4 bar/s", which releases all
    // pressure.
    Inflation inflation(LineParser &line, bool is_up) const
    {
        Inflation way{0, is_up ? 100 : 400};
        if (is_up) {
            line.expect("to");
            way.kPa = static_cast<std::int32_t>(
                std::lround(line.quantity("pressure", pressure_units, 0.0, 4000.0)));
        }
        if (line.accept("at"))
            way.kPa_per_s = static_cast<std::int32_t>(
                std::lround(line.quantity("rate", pressure_rate_units, 1.0, 4000.0)));
        return way;
    }

    // Reads statements such as "needs scene aorta", "needs tools bentson, beacon_5f" (from the innermost), or
    // "needs stents coronary_3_0x18".
    void needs(LineParser &line)
    {
        const std::string kind = line.choice("kind of file", {"scene", "tool", "tools", "stent", "stents"});
        SessionNeeds &needs = session_.needs;
        const bool is_scene = kind == "scene";
        std::vector<std::string> scene, &names = is_scene                   ? scene
                                                 : kind.starts_with("tool") ? needs.tools
                                                                            : needs.stents;
        if (!names.empty() || (is_scene && !needs.scene.empty()))
            line.fail("these files are stated in a line above");
        if (line.is_at_end()) line.fail("expected a name of a file, the line ends");
        while (!line.is_at_end()) names.push_back(line.name());
        if (is_scene && scene.size() > 1) line.fail("a session has one scene");
        if (is_scene) needs.scene = scene.front();
        if (needs.tools.size() > CRN_WIRE_TABLE_MAX)
            line.fail("a session has at most " + std::to_string(int{CRN_WIRE_TABLE_MAX}) + " tools");
    }

    // Reads statements such as "load coronary_014 as wire", "exchange catheter for balloon_3x20" or "remove
    // catheter". The hand pauses for a moment while tools are exchanged.
    void exchange(LineParser &line, const std::string &verb, Statement &statement)
    {
        constexpr std::uint32_t pause_ticks = 48; // longer than the force on the hand needs to end
        Exchange wanted;
        if (verb == "load") {
            const LineParser word = line;
            wanted.tool = tool_word(line);
            const std::string hint = suggestion(wanted.tool, {"stent"});
            if (line.is_at_end() && hint.find("did you mean") != std::string::npos)
                word.fail("unknown word '" + wanted.tool + "'" + hint);
            line.expect("as");
        }
        const LineParser before = line;
        const ToolChoice choice = require_tool(line);
        if (choice.is_all) before.fail("this is for one position: name wire, catheter, guide or tool N");
        wanted.position = choice.tool;
        if (verb == "exchange") {
            line.expect("for");
            wanted.tool = tool_word(line);
        }
        note_tool(choice, statement.line);
        statement.exchange = wanted;
        statement.wait_ticks = pause_ticks;
    }

    static std::string tool_word(LineParser &line)
    {
        if (line.is_at_end()) line.fail("expected a tool of the session, the line ends");
        return line.name();
    }

    // Reads a statement such as "begin with j_wire nothing guide_jl4_6f", which names the tools in use at the
    // start, from the innermost.
    void begin_with(LineParser &line, int number)
    {
        if (!session_.line_names.empty()) line.fail("the tools on the line are stated in a line above");
        while (!line.is_at_end()) session_.line_names.push_back(line.name());
        session_.line_names_line = number;
        if (session_.line_names.empty()) line.fail("expected the tools on the line, the line ends");
        if (session_.line_names.size() > session_tools_max)
            line.fail("a line has at most " + std::to_string(session_tools_max) + " positions");
    }

    // Reads statements such as "begin inserted 20 mm", which applies to every tool, or "begin catheter
    // inserted 80 mm", which applies to one tool.
    void begin(LineParser &line, int number)
    {
        if (line.accept("with")) return begin_with(line, number);
        const std::optional<ToolChoice> choice = accept_tool(line);
        line.expect("inserted");
        const auto length_um =
            static_cast<std::uint32_t>(std::lround(line.quantity("length", length_units, 0.0, 1.6) * 1e6));
        for (std::size_t k = 0; k < session_tools_max; k++) {
            if (!choice || choice->is_all || choice->tool == k) session_.inserted_um[k] = length_um;
        }
        if (choice) note_tool(*choice, number);
    }

    void note_tool(const ToolChoice &choice, int number)
    {
        if (choice.is_all || choice.tool < session_.tools_named) return;
        session_.tools_named = choice.tool + 1;
        session_.tools_named_line = number;
    }

    void moves(LineParser &line, int number)
    {
        Statement statement;
        statement.line = number;
        do {
            const LineParser before = line;
            statement.moves.push_back(parse_move(line, selected_));
            const HandMove &latest = statement.moves.back();
            note_tool({latest.tool, latest.moves_all}, number);
            for (std::size_t i = 0; i + 1 < statement.moves.size(); i++) {
                if (is_same_hand(statement.moves[i], latest)) {
                    before.fail("one hand cannot do this while it makes another move of the same kind");
                }
            }
        } while (line.accept("while"));
        session_.statements.push_back(statement);
    }

    Session session_;
    RoomParser room_;
    ToolChoice selected_;
    bool has_selected_ = false, has_begun_ = false;
};

// Returns the number of a tool in the table, counted from 1.
std::uint8_t number_of(const std::string &name, std::span<const std::string> names, const std::string &file,
                       int line)
{
    std::vector<std::string> known;
    std::uint8_t found = 0;
    for (std::size_t i = 0; i < names.size(); i++) {
        const std::string number = std::to_string(i + 1);
        known.push_back(names[i]);
        if (name == number) return static_cast<std::uint8_t>(i + 1);
        if (name != names[i]) continue;
        if (found != 0)
            throw FileError(file, line, 1,
                            "the session has two tools '" + name + "': write " + std::to_string(int{found}) +
                                " or " + number);
        found = static_cast<std::uint8_t>(i + 1);
    }
    if (found == 0)
        throw FileError(file, line, 1, "the session has no tool '" + name + "'" + suggestion(name, known));
    return found;
}

} // namespace

LineNumbers resolve_tools(Session &session, std::span<const std::string> names)
{
    for (Statement &statement : session.statements) {
        if (!statement.exchange) continue;
        const Exchange &wanted = *statement.exchange;
        const std::uint8_t tool =
            wanted.tool.empty() ? 0 : number_of(wanted.tool, names, session.file, statement.line);
        statement.order = crn_wire_order_of_exchange({static_cast<std::uint8_t>(wanted.position), tool});
    }
    LineNumbers line;
    for (const std::string &name : session.line_names)
        line.push_back(name == free_position ? 0
                                             : number_of(name, names, session.file, session.line_names_line));
    if (line.empty() && names.size() > session_tools_max)
        throw FileError(session.file, 0, 0,
                        "has " + std::to_string(names.size()) + " tools and does not say which " +
                            "are on the line: write 'begin with' and one to three of them");
    return line;
}

Session parse_session(std::string_view text, const std::string &file)
{
    SessionParser parser(file);
    int number = 0;
    while (!text.empty()) {
        const std::size_t end = std::min(text.find('\n'), text.size());
        parser.line(++number, text.substr(0, end));
        text.remove_prefix(std::min(end + 1, text.size()));
    }
    Session session = parser.take();
    if (session.statements.empty()) throw FileError(file, 0, 0, "holds no statement; see docs/session.md");
    return session;
}

Session read_session(const std::string &path)
{
    return parse_session(read_text_file(path), path);
}

} // namespace crn
