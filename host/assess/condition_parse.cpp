// Reads conditions; condition.cpp evaluates them.
#include "host/assess/condition.hpp"
#include "host/script/line.hpp"
#include <algorithm>
#include <cmath>

namespace crn
{

namespace
{

using Kind = ConditionAtom::Kind;

const std::vector<Unit> pressures = {{"bar", 1.0}, {"atm", 1.01325}, {"kPa", 0.01}};
const std::vector<Unit> forces = {{"N", 1.0}, {"mN", 1e-3}};
const std::vector<Unit> volumes = {{"ml", 1.0}};
const std::vector<Unit> shares = {{"%", 1.0}};
const std::vector<std::string> hand_words = {"advances", "withdraws", "moves", "turns", "inserted", "force"};
const std::vector<std::string> tip_words = {"in", "off", "ahead", "moves", "fixed"};
const std::vector<std::string> first_words = {
    "x-ray", "acquiring", "c-arm",    "injecting",   "injected", "runs",  "filled", "empty",    "time",
    "tip",   "balloon",   "stent",    "lesion",      "wall",     "line",  "wire",   "catheter", "guide",
    "tool",  "damped",    "pressure", "unaspirated", "vessel",   "blood", "not",    "("};

// Splits a condition into words and brackets. Quotation marks around the name of a vessel are removed.
std::vector<Token> words_of(std::string text, int column)
{
    for (char &c : text)
        if (c == '"' || c == '\'') c = ' ';
    std::vector<Token> words;
    for (const Token &token : split_line(text)) {
        std::size_t begin = 0;
        for (std::size_t i = 0; i <= token.text.size(); ++i) {
            const bool is_bracket = i < token.text.size() && (token.text[i] == '(' || token.text[i] == ')');
            if (i < token.text.size() && !is_bracket) continue;
            const int here = token.column + column - 1;
            if (i > begin)
                words.push_back({token.text.substr(begin, i - begin), here + static_cast<int>(begin)});
            if (is_bracket) words.push_back({token.text.substr(i, 1), here + static_cast<int>(i)});
            begin = i + 1;
        }
    }
    return words;
}

bool ends_a_vessel(const std::string &word)
{
    static const std::vector<std::string> words = {"at", "below", "above", "and", "or", ")"};
    return std::find(words.begin(), words.end(), word) != words.end();
}

} // namespace

class ConditionParser
{
  public:
    ConditionParser(const std::string &file, int line, const std::string &text, int column)
        : file_(file), line_(file_, line, words_of(text, column))
    {
    }

    Condition whole()
    {
        if (line_.is_at_end()) line_.fail("the condition is empty: give one, like 'x-ray on'");
        Condition condition = any();
        if (!line_.is_at_end()) line_.fail("expected 'and', 'or' or the end, " + line_.found());
        return condition;
    }

  private:
    Condition joined(Condition::Join join, const char *word, Condition (ConditionParser::*part)())
    {
        Condition first = (this->*part)();
        if (line_.peek() != word) return first;
        Condition condition;
        condition.join_ = join;
        condition.parts_.push_back(std::move(first));
        while (line_.accept(word)) condition.parts_.push_back((this->*part)());
        return condition;
    }

    Condition any() { return joined(Condition::Join::any, "or", &ConditionParser::all); }
    Condition all() { return joined(Condition::Join::all, "and", &ConditionParser::one); }

    Condition one()
    {
        // A condition that a person writes has few nested brackets; very many nested brackets would overflow
        // the stack.
        if (++depth_ > 32) line_.fail("more than 32 nested brackets and 'not'");
        Condition condition;
        if (line_.accept("not")) {
            condition.join_ = Condition::Join::negation;
            condition.parts_.push_back(one());
        } else if (line_.accept("(")) {
            condition = any();
            line_.expect(")");
        } else {
            condition.atom_ = atom();
        }
        --depth_;
        return condition;
    }

    ConditionAtom atom()
    {
        if (line_.peek() == "wire" || line_.peek() == "catheter" || line_.peek() == "guide" ||
            line_.peek() == "tool")
            return hand();
        const std::string word = line_.choice("condition", first_words);
        if (word == "tip") return tip();
        if (word == "x-ray") return state(Kind::xray, "on");
        if (word == "c-arm") return state(Kind::gantry_moves, "moves");
        if (word == "acquiring") return of(Kind::acquiring);
        if (word == "injecting") return of(Kind::injecting);
        if (word == "pressure") return state(Kind::pressure_damped, "damped");
        if (word == "unaspirated") {
            line_.expect("injection");
            return state(Kind::unaspirated_injection, "begins");
        }
        if (word == "injected") return bounded(Kind::injected_ml, "volume", volumes, 1e4);
        if (word == "time") return bounded(Kind::time_s, "time", time_units, 36000.0);
        if (word == "runs") return counted(Kind::runs);
        if (word == "empty" && line_.accept("run")) return state(Kind::empty_run_ends, "ends");
        if (word == "filled" || word == "empty") {
            line_.expect("runs");
            return counted(word == "filled" ? Kind::filled_runs : Kind::empty_runs);
        }
        if (word == "damped") {
            ConditionAtom atom = of(Kind::damped);
            atom.tool = accept_one_tool(line_, {});
            return atom;
        }
        if (word == "balloon") return balloon();
        if (word == "stent") {
            const std::string stage = line_.choice("stage of a stent", {"loaded", "deployed", "lost"});
            return of(stage == "loaded"     ? Kind::stent_loaded
                      : stage == "deployed" ? Kind::stent_deployed
                                            : Kind::stent_lost);
        }
        if (word == "lesion") {
            line_.expect("open");
            return bounded(Kind::lesion_open_pct, "opening", shares, 100.0);
        }
        if (word == "wall") {
            line_.expect("force");
            return bounded(Kind::wall_N, "force", forces, 1e3);
        }
        if (word == "vessel") {
            const std::string how = line_.choice("injury of a vessel", {"perforated", "dissected"});
            return of(how == "perforated" ? Kind::perforated : Kind::dissected);
        }
        if (word == "blood") {
            line_.expect("loss");
            return bounded(Kind::blood_loss_ml, "volume", volumes, 1e4);
        }
        if (word == "line") {
            line_.expect("without");
            return state(Kind::line_without_wire, "wire");
        }
        line_.fail("expected a condition behind '" + word + "', " + line_.found());
    }

    ConditionAtom of(Kind kind) const
    {
        ConditionAtom atom;
        atom.kind = kind;
        atom.file = file_;
        atom.line = line_.line();
        return atom;
    }

    ConditionAtom state(Kind kind, const char *word)
    {
        line_.expect(word);
        return of(kind);
    }

    ConditionAtom bounded(Kind kind, const std::string &what, const std::vector<Unit> &units, double limit)
    {
        ConditionAtom atom = of(kind);
        read_bound(atom, what, units, limit);
        return atom;
    }

    ConditionAtom counted(Kind kind)
    {
        ConditionAtom atom = of(kind);
        line_.expect("at");
        const bool is_least = line_.choice("bound", {"least", "most"}) == "least";
        (is_least ? atom.least : atom.most) = line_.number("a number of runs");
        return atom;
    }

    // Reads a limit of the form "at least X", "at most X", "below X" or "above X".
    void read_bound(ConditionAtom &atom, const std::string &what, const std::vector<Unit> &units,
                    double limit)
    {
        const std::string bound = line_.choice("bound", {"at", "below", "above"});
        const std::string side = bound == "at" ? line_.choice("bound", {"least", "most"}) : bound;
        const double value = line_.quantity(what, units, 0.0, limit);
        if (side == "least" || side == "above") {
            atom.least = value;
            if (side == "above") atom.least = std::nextafter(value, limit + 1.0);
        } else {
            atom.most = value;
            atom.is_below = side == "below";
        }
    }

    void read_length(ConditionAtom &atom, double standard_mm)
    {
        if (line_.peek() != "at" && line_.peek() != "below" && line_.peek() != "above") {
            atom.least = standard_mm;
            return;
        }
        static const std::vector<Unit> lengths = {{"mm", 1.0}, {"cm", 10.0}, {"m", 1000.0}};
        read_bound(atom, "length", lengths, 1600.0);
    }

    void read_speed(ConditionAtom &atom, double standard, const std::vector<Unit> &units)
    {
        atom.least = standard;
        if (!line_.accept("faster")) return;
        line_.expect("than");
        atom.least = line_.quantity("speed", units, 0.0, 2000.0);
    }

    ConditionAtom hand()
    {
        static const std::vector<Unit> speeds = {{"mm/s", 1.0}, {"cm/s", 10.0}};
        ConditionAtom atom = of(Kind::hand_moves);
        atom.tool = accept_one_tool(line_, {});
        const std::string word = line_.choice("what a tool does", hand_words);
        if (word == "inserted" || word == "force") {
            atom.kind = word == "force" ? Kind::hand_force_N : Kind::inserted_mm;
            if (word == "force")
                read_bound(atom, "force", forces, 100.0);
            else
                read_length(atom, 0.0);
        } else if (word == "turns") {
            atom.kind = Kind::hand_turns;
            read_speed(atom, 20.0, turn_speed_units);
        } else {
            atom.kind = word == "advances"    ? Kind::hand_advances
                        : word == "withdraws" ? Kind::hand_withdraws
                                              : Kind::hand_moves;
            read_speed(atom, 2.0, speeds);
        }
        return atom;
    }

    ConditionAtom tip()
    {
        static const std::vector<Unit> speeds = {{"mm/s", 1.0}, {"cm/s", 10.0}};
        ConditionAtom atom = of(Kind::tip_in_vessel);
        atom.tool = accept_one_tool(line_, {});
        const std::string word = line_.choice("what a tip does", tip_words);
        if (word == "moves") {
            atom.kind = Kind::tip_moves;
            read_speed(atom, 5.0, speeds);
        } else if (word == "fixed") {
            atom.kind = Kind::tip_fixed;
            read_length(atom, 10.0);
        } else if (word == "off") {
            line_.expect("the");
            line_.expect("way");
            atom.kind = Kind::tip_off_the_way;
            atom.column = line_.column();
            read_length(atom, 10.0);
        } else if (word == "ahead") {
            line_.expect("of");
            atom.kind = Kind::tip_ahead;
            atom.other = accept_one_tool(line_, {});
            read_length(atom, 2.0);
        } else if (line_.accept("picture")) {
            atom.kind = Kind::tip_in_picture;
        } else {
            read_vessel(atom);
            read_length(atom, 0.0);
        }
        return atom;
    }

    void read_vessel(ConditionAtom &atom)
    {
        atom.column = line_.column();
        while (!line_.is_at_end() && !ends_a_vessel(line_.peek())) {
            atom.vessel += (atom.vessel.empty() ? "" : " ") + line_.peek();
            line_.skip();
        }
        if (atom.vessel.empty()) line_.fail("expected 'picture' or the name of a vessel, " + line_.found());
    }

    ConditionAtom balloon()
    {
        if (line_.accept("burst")) return of(Kind::balloon_burst);
        if (line_.accept("beyond")) {
            line_.expect("stent");
            ConditionAtom atom = of(Kind::balloon_beyond_stent);
            read_length(atom, 2.0);
            return atom;
        }
        LineParser ahead = line_; // "above rated burst", or "above 12 bar"
        if (ahead.accept("above") && ahead.accept("rated")) {
            line_.skip();
            line_.skip();
            return state(Kind::balloon_above_rated, "burst");
        }
        return bounded(Kind::balloon_bar, "pressure", pressures, 40.0);
    }

    const std::string file_;
    LineParser line_;
    int depth_ = 0;
};

Condition Condition::parse(const std::string &text, const std::string &file, int line, int column)
{
    Condition condition = ConditionParser(file, line, text, column).whole();
    condition.text_ = text;
    return condition;
}

} // namespace crn
