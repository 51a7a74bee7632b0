// Writes the part of a session's report that describes the balloon and the stents.
#pragma once
#include "host/model/instrument.hpp"
#include "host/session/balloon_figures.hpp"
#include <nlohmann/json_fwd.hpp>
#include <vector>

namespace crn
{

class PatientStents;

// Returns null without a balloon; `tool` is the latest tool with one, or nullptr. The curves in this part
// leave out the time before and after inflations.
nlohmann::ordered_json balloon_report(const BalloonFigures &balloon, const Instrument *tool);
// Returns [] without stents.
nlohmann::ordered_json stents_report(PatientStents *stents);

} // namespace crn
