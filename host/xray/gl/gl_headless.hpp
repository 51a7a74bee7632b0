// The two ways to an OpenGL context without a window. Private to this folder: others ask for open_headless.
#pragma once
#include "host/xray/gl/gl_context.hpp"

namespace crn
{

// Both throw GlError with the package that would help.
std::unique_ptr<GlContext> open_osmesa(const std::vector<std::string> &file_names);
std::unique_ptr<GlContext> open_egl(const std::vector<std::string> &file_names);

} // namespace crn
