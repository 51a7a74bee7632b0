// Tools as swept round tubes on one centreline: chord lengths along the rays, exact for cylinders cut at their joints'
// bisecting planes, so that neighbouring pieces neither overlap nor leave a gap. 3x3 rays per pixel.
#pragma once
#include "host/model/wire_frame.hpp"
#include "host/xray/paths.hpp"
#include "host/xray/xray.hpp"
#include <span>

namespace seld
{

// Replaces `paths` by those of the tools in this view. What they are made of displaces blood.
void draw_tools(std::span<const RadiopaqueInstrument> tools, const WireFrame &wire, const View &view,
                ToolPaths &paths);

} // namespace seld
