// The back end for the X-ray's path lengths, as named on the command line.
#pragma once
#include "host/xray/gl/gl_paths.hpp"
#include "host/xray/xray.hpp"
#include <string>
#include <vector>

namespace crn
{

// raster is the integer rasteriser. opengl uses the window's own context, else OSMesa, else EGL without a
// surface.
inline const std::vector<std::string> path_choices = {"raster", "opengl", "opengl-osmesa", "opengl-egl"};
// A thread has only one context: another library's would replace the window's.
inline const std::vector<std::string> path_choices_window = {"raster", "opengl"};

// `window_context` is empty when there is no window. The maker throws GlError, and reports on standard error
// which OpenGL it found.
BodyPathsMaker paths_maker(const std::string &choice, const GlOpener &window_context);

// Prints on standard output which OpenGL each library provides or why it does not, a line each. Returns false
// when none does.
bool print_opengl();

} // namespace crn
