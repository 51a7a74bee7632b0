// Builds an OpenGL program from a pair of shaders. Only files in the same folder, and host/screen/screen.cpp,
// may include this header.
#pragma once
#include "host/xray/gl/gl_context.hpp"

namespace crn
{

// Throws GlError with the driver's message if the driver refuses a shader. The caller deletes the program.
unsigned build_program(const GlFunctions &gl, const char *vertex_text, const char *fragment_text);

} // namespace crn
