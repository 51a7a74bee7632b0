// Describes the balloon of a session: which tool has it, where its balls lie on the line, and the medium in
// it for the X-ray.
#pragma once
#include "host/model/instrument.hpp"
#include "host/model/wire_frame.hpp"
#include "host/stent/balloon_axis.hpp"
#include "host/xray/paths/moved.hpp"
#include <optional>
#include <vector>

namespace crn
{

// A balloon is filled with medium of 350 mg/ml, diluted with an equal volume of saline; this is the iodine in
// it.
inline constexpr double balloon_iodine_mg_per_ml = 175.0;

// Returns the tool with a balloon, counted from the innermost; empty if no tool has one.
std::optional<std::size_t> balloon_tool(const std::vector<Instrument> &tools);
// This message answers a request to inflate when no tool has a balloon.
inline constexpr char no_balloon_text[] = "NO BALLOON - none of the tools has one to inflate";
// Returns the middle of the balloon's working length, mm from the tool's tip, where a stent is mounted.
double balloon_middle_mm(const Instrument &tool);

// Returns the balls of the balloon, in order from the tool's tip. The result is empty when no ball is in the
// patient. Inside the introducer sheath the line continues straight.
BalloonPose balloon_pose(const WireFrame &wire, std::size_t tool);

// Returns the medium in the unfolded balloon as one column with a cone at either end, around the folded tool.
// The result is empty while the balloon is folded.
std::vector<SweptCurve> balloon_filling(const WireFrame &wire, const std::vector<Instrument> &tools,
                                        double iodine_mg_per_ml);

} // namespace crn
