// Who draws the X-ray's path lengths, as the command line names it.
#pragma once
#include "host/xray/gl/gl_paths.hpp"
#include "host/xray/xray.hpp"
#include <string>
#include <vector>

namespace crn
{

// raster: the integer rasteriser. opengl: in the window its own context, else OSMesa, else EGL without a
// surface.
inline const std::vector<std::string> path_choices = {"raster", "opengl", "opengl-osmesa", "opengl-egl"};
// A thread has one context: another library's would take the place of the window's.
inline const std::vector<std::string> path_choices_window = {"raster", "opengl"};

// `window_context` is empty where there is no window. The maker throws GlError, and says on standard error
// which OpenGL it found.
BodyPathsMaker paths_maker(const std::string &choice, const GlOpener &window_context);

// What each library gives or why it does not, a line each, on standard output. False when none does.
bool print_opengl();

} // namespace crn
