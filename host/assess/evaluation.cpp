#include "host/assess/evaluation.hpp"
#include <algorithm>
#include <cmath>

namespace crn
{

namespace
{

std::size_t moments_in(double seconds)
{
    return static_cast<std::size_t>(std::lround(seconds / SessionLog::seconds_per_moment));
}

class Evaluator
{
  public:
    Evaluator(const AssessPlan &plan, const SessionLog &log) : plan_(plan), log_(log), signals_(log) {}

    Evaluation run()
    {
        for (std::size_t k = 0; k < plan_.errors.size(); ++k) find_error(k);
        std::stable_sort(result_.errors.begin(), result_.errors.end(), [&](const auto &a, const auto &b) {
            const Severity sa = plan_.errors[a.kind].severity, sb = plan_.errors[b.kind].severity;
            return sa != sb ? sa > sb : a.begin_tick < b.begin_tick;
        });
        std::size_t begin = 0;
        bool is_open = true; // the phase before has ended, so a phase without a begin may begin
        for (const PlanPhase &phase : plan_.phases) find_phase(phase, begin, is_open);
        return std::move(result_);
    }

  private:
    // A handling error begins when its condition has held for `for_s`. A handling error ends when its
    // condition has not held for `again_s`.
    void find_error(std::size_t kind)
    {
        const PlanError &error = plan_.errors[kind];
        Condition when = error.when;
        result_.why_not.push_back(when.bind(log_, plan_.vessels));
        if (!result_.why_not.back().empty()) return;
        const std::size_t least = std::max<std::size_t>(moments_in(error.for_s), 1),
                          gap = std::max<std::size_t>(moments_in(error.again_s), 1);
        std::size_t held = 0, quiet = gap;
        bool is_counted = false;
        int count = 0;
        for (std::size_t i = 0; i < log_.moments.size(); ++i) {
            if (!when.holds(signals_, i)) {
                held = 0;
                if (++quiet >= gap) is_counted = false;
                continue;
            }
            quiet = 0;
            if (++held < least) continue;
            if (is_counted) {
                result_.errors.back().end_tick = log_.moments[i].tick;
                continue;
            }
            is_counted = true;
            note({kind, log_.moments[i + 1 - held].tick, log_.moments[i].tick, ++count <= error.at_most});
        }
    }

    void note(const FoundError &found)
    {
        result_.errors.push_back(found);
        if (!found.counts) return;
        const Severity severity = plan_.errors[found.kind].severity;
        result_.lost_marks += static_cast<double>(severity);
        result_.has_life_threatening |= severity == Severity::life_threatening;
    }

    void find_phase(const PlanPhase &phase, std::size_t &begin, bool &is_open)
    {
        FoundPhase found;
        Condition first = phase.begin.value_or(phase.end), last = phase.end;
        found.why_not = first.bind(log_, plan_.vessels);
        if (found.why_not.empty()) found.why_not = last.bind(log_, plan_.vessels);
        std::vector<Condition> done;
        for (const PlanStep &step : phase.steps) {
            done.push_back(step.done);
            found.steps.push_back({done.back().bind(log_, plan_.vessels), {}});
        }
        if (found.why_not.empty()) {
            std::optional<std::size_t> from;
            if (phase.begin)
                from = first_moment(first, begin, begin);
            else if (is_open && begin < log_.moments.size())
                from = begin;
            is_open = false;
            if (from) {
                const std::optional<std::size_t> to = first_moment(last, *from, *from);
                follow(done, *from, to, found);
                is_open = to.has_value();
                begin = to.value_or(*from);
            }
        }
        result_.phases.push_back(std::move(found));
    }

    // Finds the steps that were done during the phase; a phase that did not end lasts until the end of the
    // session.
    void follow(const std::vector<Condition> &done, std::size_t from, std::optional<std::size_t> to,
                FoundPhase &found) const
    {
        found.begin_tick = log_.moments[from].tick;
        if (to) found.end_tick = log_.moments[*to].tick;
        for (std::size_t s = 0; s < done.size(); ++s) {
            if (!found.steps[s].why_not.empty()) continue;
            const std::optional<std::size_t> at = first_moment(done[s], from, from);
            if (at && *at <= to.value_or(log_.moments.size()))
                found.steps[s].done_tick = log_.moments[*at].tick;
        }
    }

    std::optional<std::size_t> first_moment(const Condition &condition, std::size_t from,
                                            std::size_t since) const
    {
        for (std::size_t i = from; i < log_.moments.size(); ++i)
            if (condition.holds(signals_, i, since)) return i;
        return {};
    }

    const AssessPlan &plan_;
    const SessionLog &log_;
    const SessionSignals signals_;
    Evaluation result_;
};

} // namespace

Evaluation evaluate(const AssessPlan &plan, const SessionLog &log)
{
    return Evaluator(plan, log).run();
}

void check_plan(const AssessPlan &plan, const SessionLog &log)
{
    SessionLog empty = log;
    empty.moments.clear();
    evaluate(plan, empty);
}

} // namespace crn
