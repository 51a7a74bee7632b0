// The balloon of a session: which tool has it, where its balls are on the line, and what the X-ray sees of
// what fills it.
#pragma once
#include "host/model/instrument.hpp"
#include "host/model/wire_frame.hpp"
#include "host/stent/balloon_axis.hpp"
#include "host/xray/paths/moved.hpp"
#include <optional>
#include <vector>

namespace crn
{

// Medium of 350 mg/ml, diluted with as much saline.
inline constexpr double balloon_iodine_mg_per_ml = 175.0;

// The tool with a balloon, from the innermost; nothing: none has one.
std::optional<std::size_t> balloon_tool(const std::vector<Instrument> &tools);
// What whoever inflates is told when there is none.
inline constexpr char no_balloon_text[] = "NO BALLOON - none of the tools has one to inflate";
// Middle of its working length, mm from the tool's tip: where a stent is mounted.
double balloon_middle_mm(const Instrument &tool);

// Balls along their tool, from its tip. Empty when no ball is in the patient. Inside the inserter the line
// goes on straight.
BalloonPose balloon_pose(const WireFrame &wire, std::size_t tool);

// What fills the unfolded balloon: one column with a cone at either end, around the folded tool. Empty: it is
// folded.
std::vector<SweptCurve> balloon_filling(const WireFrame &wire, const std::vector<Instrument> &tools,
                                        double iodine_mg_per_ml);

} // namespace crn
