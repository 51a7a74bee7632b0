// Draws tools on the wire and curves as swept round tubes. Their chord lengths along the rays are exact for
// cylinders cut at their joints' bisecting planes, so that neighbouring pieces neither overlap nor leave a
// gap.
#pragma once
#include "host/xray/paths/moved.hpp"
#include "host/xray/paths/paths.hpp"

namespace crn
{

// Replaces `paths` by the paths of the frame's tools and curves in this view. They displace the material
// `displaced` (blood, or the tissue where no blood is drawn) together with the iodine that the wire's nodes
// report in it.
void draw_tubes(const XrayFrame &frame, const View &view, Material displaced, ToolPaths &paths);

} // namespace crn
