// Shows during a session which goals of its case are reached. The session's thread checks the goals, and the
// GUI window takes the results from a mailbox. The marks are computed after the session, from its recording.
#pragma once
#include "host/cases/goals.hpp"
#include "host/live/live_session.hpp"
#include "host/live/mailbox.hpp"
#include <memory>
#include <string>
#include <vector>

namespace crn
{

class LiveGoals
{
  public:
    // `session` runs the case and must live longer than this object. Throws a FileError if a goal names a
    // vessel or a tool that the session does not have.
    LiveGoals(std::shared_ptr<const Case> lesson, LiveSession &session);

    void look(const SessionFrame &frame); // in the session's thread
    // Returns one result for each goal, or null before the first check.
    std::shared_ptr<const std::vector<GoalResult>> latest() const { return results_.latest(); }
    // Returns, for each position (0: innermost), the place of the tool's tip, such as "34 mm inside LAD"; a
    // text is empty if the place is not known. Null before the first look.
    std::shared_ptr<const std::vector<std::string>> tips() const { return tip_texts_.latest(); }

  private:
    std::shared_ptr<const Case> lesson_;
    TipPlaces tips_;
    EffectsWitness witness_;
    GoalWatch goals_;
    std::uint32_t next_ = 0;
    Mailbox<std::vector<GoalResult>> results_;
    Mailbox<std::vector<std::string>> tip_texts_;
};

} // namespace crn
