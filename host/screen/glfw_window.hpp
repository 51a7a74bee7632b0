// Opens a window with the library GLFW; all windows of the programs are opened by this code.
#pragma once
#include <string>

struct GLFWwindow;

namespace crn
{

std::string glfw_reason(); // of the last failure of GLFW

// Starts GLFW and opens a window for OpenGL 3.3 core, with sizes in the desktop's units. The caller ends with
// glfwTerminate(). Throws std::runtime_error with the cause and the remedy, after ending GLFW.
GLFWwindow *open_glfw_window(const std::string &title, int width, int height);

} // namespace crn
