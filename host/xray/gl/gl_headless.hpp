// Opens the two kinds of OpenGL context that need no window: OSMesa, and EGL without a surface. Only files in
// the same folder may include this header; other code calls open_headless.
#pragma once
#include "host/xray/gl/gl_context.hpp"

namespace crn
{

// Both functions (for OSMesa and for EGL) throw GlError, whose message names the package to install.
std::unique_ptr<GlContext> open_osmesa(const std::vector<std::string> &file_names);
std::unique_ptr<GlContext> open_egl(const std::vector<std::string> &file_names);

} // namespace crn
