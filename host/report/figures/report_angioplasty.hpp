// Writes the part of a session's report that describes the balloon and the stents.
#pragma once
#include "host/model/instrument.hpp"
#include "host/session/balloon_figures.hpp"
#include <nlohmann/json_fwd.hpp>
#include <vector>

namespace crn
{

class PatientStents;

// `table` has all tools of the session. If several balloons were used, the label and the pressure are those
// of the balloon that came nearest to its rated burst pressure or exceeded it the most. Returns null without
// a balloon. The curves in this part of the report leave out the time before and after inflations.
nlohmann::ordered_json balloon_report(const BalloonFigures &balloon, const std::vector<Instrument> &table);
// Returns [] without stents.
nlohmann::ordered_json stents_report(PatientStents *stents);

} // namespace crn
