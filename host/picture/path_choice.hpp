// Chooses the back end that computes the X-ray's path lengths, by its name on the command line.
#pragma once
#include "host/xray/gl/gl_paths.hpp"
#include "host/xray/xray.hpp"
#include <string>
#include <vector>

namespace crn
{

// "raster" is the integer rasteriser. "opengl" uses the OpenGL context of the window or, without a window,
// OSMesa or else EGL without a surface.
inline const std::vector<std::string> path_choices = {"raster", "opengl", "opengl-osmesa", "opengl-egl"};
// The window allows only these two, because a thread has only one OpenGL context, and that of another library
// would replace the window's.
inline const std::vector<std::string> path_choices_window = {"raster", "opengl"};

// `window_context` is empty when there is no window. The returned function throws GlError if there is no
// OpenGL, and prints on standard error which OpenGL it found.
BodyPathsMaker paths_maker(const std::string &choice, const GlOpener &window_context);

// Prints on standard output, one line for each library, which OpenGL the library provides, or why it provides
// none. Returns false if no library provides OpenGL.
bool print_opengl();

} // namespace crn
