// Conditions of an assessment are phrases that are true or false at one moment of a session
// (docs/assessment.md, "Conditions").
//
//   tip wire in LAD at least 20 mm and not x-ray on
//   ( guide withdraws or guide advances faster than 20 mm/s ) and injecting
//
// A condition is read once from a plan, is connected to the vessels of a scene, and is evaluated at every
// moment.
#pragma once
#include "host/assess/signals.hpp"
#include "host/script/tool.hpp"
#include <limits>
#include <map>
#include <string>
#include <vector>

namespace crn
{

struct ConditionAtom {
    enum class Kind {
        xray,
        acquiring,
        gantry_moves,
        injecting,
        pressure_damped,
        unaspirated_injection,
        injected_ml,
        runs,
        filled_runs,
        empty_runs,
        empty_run_ends,
        time_s,
        hand_advances,
        hand_withdraws,
        hand_moves,
        hand_turns,
        inserted_mm,
        hand_force_N,
        tip_moves,
        tip_in_vessel,
        tip_in_picture,
        tip_off_the_way,
        tip_ahead,
        tip_fixed,
        damped,
        balloon_bar,
        balloon_above_rated,
        balloon_burst,
        balloon_beyond_stent,
        stent_loaded,
        stent_deployed,
        stent_lost,
        lesion_open_pct,
        wall_N,
        line_without_wire,
        perforated,
        dissected,
        blood_loss_ml,
    };
    Kind kind = Kind::xray;
    std::size_t tool = 0, other = 0;
    std::string vessel;             // as the plan names it, or what its table [vessels] makes of it
    std::string file{};             // that states the condition
    int line = 0, column = 0;       // of the vessel's name in the file
    std::size_t vessel_number = 0;  // of the map; set by bind()
    std::vector<std::size_t> way{}; // vessels that are not off the way; set by bind()
    double least = -std::numeric_limits<double>::infinity(), most = std::numeric_limits<double>::infinity();
    bool is_below = false; // less than `most`

    bool allows(double value) const { return value >= least && (is_below ? value < most : value <= most); }
};

// Holds the names that a plan gives to vessels of a scene, and the vessels through which a wire may go.
struct PlanVessels {
    std::map<std::string, std::string> names; // such as target = "LAD"
    std::vector<std::string> way;             // empty: not stated
    std::string file{};                       // and line of the way
    int line = 0;
};

class Condition
{
  public:
    // Reads a condition, which begins at `column` of the line in the file. Throws a FileError that names the
    // place of the mistake and suggests a known word.
    static Condition parse(const std::string &text, const std::string &file, int line, int column);

    // Returns an empty string if the condition applies to this session. If the condition does not apply to
    // the session, returns the reason: a missing tool, balloon, vessel or name. The condition "a or b"
    // applies if at least one of its two parts applies. Finds the vessels that the condition names; throws
    // FileError if the scene has vessels, but none with such a name.
    std::string bind(const SessionLog &log, const PlanVessels &vessels);

    // Returns true if the condition holds at moment `i`. The amounts in a condition (injected medium, number
    // of runs, time) are counted from moment `since`.
    bool holds(const SessionSignals &signals, std::size_t i, std::size_t since = 0) const;
    const std::string &text() const { return text_; }

  private:
    friend class ConditionParser;
    enum class Join { atom, all, any, negation };
    Join join_ = Join::atom;
    std::vector<Condition> parts_;
    ConditionAtom atom_;
    std::string text_;
};

} // namespace crn
