// Draws the tools along their common centreline, and curves of struts and contrast medium, as round tubes.
// The path lengths along the rays are exact for cylinders that are cut by the bisecting planes of their
// joints, so that neighbouring pieces neither overlap nor leave a gap.
#pragma once
#include "host/xray/paths/moved.hpp"
#include "host/xray/paths/paths.hpp"

namespace crn
{

// Replaces the contents of `paths` by the path lengths in the tools and curves of this frame, in this view.
// Tools and curves displace the material `displaced` (blood, or the tissue where no blood is drawn) and also
// the iodine in it, whose amount is given at the nodes of the tools' centreline.
void draw_tubes(const XrayFrame &frame, const View &view, Material displaced, ToolPaths &paths);

} // namespace crn
