// Tools on the wire and curves as swept round tubes: chord lengths along the rays, exact for cylinders cut at
// their joints' bisecting planes, so that neighbouring pieces neither overlap nor leave a gap.
#pragma once
#include "host/xray/paths/moved.hpp"
#include "host/xray/paths/paths.hpp"

namespace crn
{

// Replaces `paths` by those of the frame's tools and curves in this view. They take the place of `displaced`
// (blood, or the tissue where no blood is drawn), with the iodine that the wire's nodes say is in it.
void draw_tubes(const XrayFrame &frame, const View &view, Material displaced, ToolPaths &paths);

} // namespace crn
