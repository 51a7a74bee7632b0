#include "host/screen/glfw_window.hpp"
#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>
#include <stdexcept>

namespace crn
{

std::string glfw_reason()
{
    const char *text = nullptr;
    glfwGetError(&text);
    return text ? text : "no reason given";
}

GLFWwindow *open_glfw_window(const std::string &title, int width, int height)
{
    if (!glfwInit())
        throw std::runtime_error("window: no display (" + glfw_reason() +
                                 "); set DISPLAY, or make a film with `cournand run --mp4 FILE`");
    glfwWindowHint(GLFW_CONTEXT_VERSION_MAJOR, 3);
    glfwWindowHint(GLFW_CONTEXT_VERSION_MINOR, 3);
    glfwWindowHint(GLFW_OPENGL_PROFILE, GLFW_OPENGL_CORE_PROFILE);
    glfwWindowHint(GLFW_OPENGL_FORWARD_COMPAT, GLFW_TRUE);
    glfwWindowHint(GLFW_SCALE_TO_MONITOR, GLFW_TRUE);
    // A desktop finds the window's icon by this window class (tools/desktop/cournand.desktop).
    glfwWindowHintString(GLFW_X11_CLASS_NAME, "cournand");
    glfwWindowHintString(GLFW_X11_INSTANCE_NAME, "cournand");
    GLFWwindow *window = glfwCreateWindow(width, height, title.c_str(), nullptr, nullptr);
    if (window) return window;
    const std::string reason = glfw_reason();
    glfwTerminate();
    throw std::runtime_error("window: no OpenGL 3.3 window (" + reason +
                             "); install a graphics driver (Debian: libgl1-mesa-dri), or make a film with "
                             "`cournand run --mp4 FILE`");
}

} // namespace crn
