// Chooses which implementation computes the X-ray's path lengths, by the name that the user gives on the
// command line.
#pragma once
#include "host/xray/gl/gl_paths.hpp"
#include "host/xray/xray.hpp"
#include <string>
#include <vector>

namespace crn
{

// "raster" is the integer rasteriser. The choice "opengl" uses the OpenGL context of the window. Without a
// window it uses OSMesa, or else EGL without a surface.
inline const std::vector<std::string> path_choices = {"raster", "opengl", "opengl-osmesa", "opengl-egl"};
// With a window only the choices "raster" and "opengl" are allowed. A thread has only one OpenGL context, so
// the context of another library would replace the window's context.
inline const std::vector<std::string> path_choices_window = {"raster", "opengl"};

// `window_context` must be empty if there is no window. The returned function throws GlError if there is no
// OpenGL, and prints on standard error which OpenGL library it found.
BodyPathsMaker paths_maker(const std::string &choice, const GlOpener &window_context);

// Prints one line for each library on standard output: which OpenGL the library provides, or why it provides
// none. Returns false if no library provides OpenGL.
bool print_opengl();

} // namespace crn
