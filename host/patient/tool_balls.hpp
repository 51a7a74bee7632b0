// Represents the tools as balls that narrow the vessels, for models of the blood flow.
#pragma once
#include "host/effects/contrast_flow.hpp"
#include "host/model/instrument.hpp"
#include "host/model/wire_frame.hpp"
#include <vector>

namespace crn
{

bool has_lumen(const Instrument &tool);

// Returns the point of the nested tools at an arc length from the leading tip, or the nearer end if the arc
// length is beyond it. `wire` has at least one node.
Eigen::Vector3d place_at(const WireFrame &wire, double arc_m);

// Returns balls along the tools, at most 2 mm apart, and the balls that model a balloon. The balls of a
// balloon that fills the vessel block the blood flow.
std::vector<ToolBall> balls_of(const WireFrame &wire);

} // namespace crn
