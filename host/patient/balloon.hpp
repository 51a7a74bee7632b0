// Describes the balloon of a session: the tool that carries it, the contrast medium in it, and the positions
// of the balls (spheres) that model it in the core.
#pragma once
#include "host/model/instrument.hpp"
#include "host/model/wire_frame.hpp"
#include "host/stent/balloon_axis.hpp"
#include "host/xray/paths/moved.hpp"
#include <optional>
#include <vector>

namespace crn
{

// A balloon is filled with contrast medium (350 mg of iodine per ml) that is diluted with an equal volume of
// saline. The mixture in a balloon has 175 mg of iodine per ml.
inline constexpr double balloon_iodine_mg_per_ml = 175.0;

// Returns the index of the tool with a balloon, counted from the innermost, or no value if no tool has a
// balloon.
std::optional<std::size_t> balloon_tool(const std::vector<Instrument> &tools);
// The user gets this message after a command to inflate the balloon if no tool has a balloon.
inline constexpr char no_balloon_text[] = "NO BALLOON - none of the devices has one to inflate";
// Returns the middle of the balloon's working length, in mm from the tool's tip; a stent is mounted there.
double balloon_middle_mm(const Instrument &tool);

// Returns the balls that model the balloon, in order from the tool's tip. The returned list of balls is empty
// if no ball is inside the patient. Balls inside the introducer sheath are placed on a straight continuation
// of the nested tools.
BalloonPose balloon_pose(const WireFrame &wire, std::size_t tool);

// Returns the contrast medium in the unfolded balloon as one column around the tool's shaft; each end of the
// column is a cone. The returned list of pieces is empty while the balloon is folded.
std::vector<SweptCurve> balloon_filling(const WireFrame &wire, const std::vector<Instrument> &tools,
                                        double iodine_mg_per_ml);

} // namespace crn
