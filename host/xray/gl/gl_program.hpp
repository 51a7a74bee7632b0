// Builds an OpenGL program from a pair of shaders. This header is private to its folder and to host/app's
// window.
#pragma once
#include "host/xray/gl/gl_context.hpp"

namespace crn
{

// Throws GlError with the message of the driver. The caller deletes the program.
unsigned build_program(const GlFunctions &gl, const char *vertex_text, const char *fragment_text);

} // namespace crn
