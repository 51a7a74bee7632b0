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
// window the choice "opengl" uses OSMesa, or EGL without a surface if OSMesa is missing.
inline const std::vector<std::string> path_choices = {"raster", "opengl", "opengl-osmesa", "opengl-egl"};
// If the program has a window, only the choices "raster" and "opengl" are allowed. A thread has only one
// OpenGL context, so the context of another library would replace the window's context.
inline const std::vector<std::string> path_choices_window = {"raster", "opengl"};

// `window_context` must be empty if the program has no window. The returned function throws GlError if no
// OpenGL is available, and prints on standard error which OpenGL library it found.
BodyPathsMaker paths_maker(const std::string &choice, const GlOpener &window_context);

// Prints one line for each OpenGL library on standard output: the version that the library provides, or why
// it provides none. Returns false if no library provides OpenGL.
bool print_opengl();

} // namespace crn
