// Opens the two kinds of OpenGL context without a window. This header is private to this folder: others call
// open_headless.
#pragma once
#include "host/xray/gl/gl_context.hpp"

namespace crn
{

// Both throw GlError with the package to install.
std::unique_ptr<GlContext> open_osmesa(const std::vector<std::string> &file_names);
std::unique_ptr<GlContext> open_egl(const std::vector<std::string> &file_names);

} // namespace crn
