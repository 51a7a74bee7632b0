// Watches during a session which goals of a case are reached, and computes the case's marks at the end.
//
//   GoalWatch goals(lesson, tips.map());
//   goals.look({inserted_m, tips, &witness, tick}, turned_deg);      every GoalWatch::look_every_ticks
//   Json entry = case_result(lesson, goals.results(), report);
#pragma once
#include "host/cases/case.hpp"
#include "host/session/frame_sink.hpp"
#include "host/session/run.hpp"
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace crn
{

struct GoalResult {
    bool is_reached = false;
    std::optional<std::uint32_t> tick; // of a goal that is reached once
    std::string found;                 // what was measured at the last look
};

class GoalWatch
{
  public:
    // The result depends on the ticks at which the goals are checked, so these ticks are the same in every
    // session.
    static constexpr std::uint32_t look_every_ticks = 64;

    // `lesson` must live longer than this object. Throws FileError if a goal names a vessel or a tool that
    // the case does not have; the message gives the line of the case file.
    GoalWatch(const Case &lesson, const VesselMap &map);
    // Checks the goals against the state of the session at one tick. `turned_deg` holds the angle by which
    // each hand has turned.
    void look(const SessionView &view, std::span<const double> turned_deg);
    // Returns one result for each goal; goals that must hold at the end are judged by the last check.
    const std::vector<GoalResult> &results() const { return results_; }
    bool are_all_reached() const;

  private:
    const Case &lesson_;
    const VesselMap &map_;
    std::vector<std::size_t> vessels_; // named by each goal, 0 where it names none
    std::vector<GoalResult> results_;
};

// Passes the frames of a session to the goals and to another observer, which may be nullptr. A replay of a
// recording passes the same frames, so the recorded session gets the same results.
class GoalSink final : public FrameSink
{
  public:
    GoalSink(GoalWatch &goals, const TipPlaces &tips, const SessionWitness *witness, FrameSink *inner)
        : goals_(goals), tips_(tips), witness_(witness), inner_(inner)
    {
    }
    void tick(const crn_wire_tick_input &input, const crn_wire_tick_state &state) override;
    std::uint32_t next_tick() const override;
    void frame(const SessionFrame &frame) override;
    void finish() override;
    // Judges the goals at the end of the session. Call end() after the session.
    void end(std::span<const double> inserted_m, std::span<const TipPlace> tips);

  private:
    GoalWatch &goals_;
    const TipPlaces &tips_;
    const SessionWitness *witness_;
    FrameSink *inner_;
    std::uint32_t next_ = 0, tick_ = 0;
    crn_wire_tick_input last_{};
};

// Returns the entry "case" of a session's report: {"name", "title", "score", "is_reached", "goals": [{"text",
// "expected", "when", "is_reached", "at_s", "found", "marks", "points"}], "limits": [{"measure", "title",
// "value", "unit", "full_marks_at", "no_marks_at", "marks", "points"}]}. The score is the sum of the points,
// in percent of the sum of the possible marks.
nlohmann::ordered_json case_result(const Case &lesson, const std::vector<GoalResult> &goals,
                                   const nlohmann::ordered_json &report);
// Prints the entry "case" of a report, with one line for each goal and limit.
void print_case_result(const nlohmann::ordered_json &entry);

// Watches the goals of the case that a session or a replay plays. If no case is played, the class only passes
// frames on.
class CasePlay
{
  public:
    // `lesson`, `witness` and `pictures` may be nullptr; if they are not, they must live longer than this
    // object. Throws as GoalWatch.
    CasePlay(const Case *lesson, const TipPlaces &tips, const SessionWitness *witness, FrameSink *pictures);
    FrameSink *sink() { return sink_; }
    // Judges the goals at the end of a session; the session must have a case. Returns the entry "case" of the
    // report.
    nlohmann::ordered_json judge_end(const RunResult &result, const nlohmann::ordered_json &report);
    // Does the same as judge_end(), and prints the entry of the report.
    nlohmann::ordered_json end(const RunResult &result, const nlohmann::ordered_json &report);

  private:
    const Case *lesson_;
    FrameSink *sink_;
    std::optional<GoalWatch> goals_;
    std::optional<GoalSink> goal_sink_;
};

} // namespace crn
