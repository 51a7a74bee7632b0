// Shows the program's window with the library GLFW and OpenGL 3.3 core.
#include "host/screen/screen.hpp"
#include "host/screen/glfw_window.hpp"
#define GLFW_INCLUDE_NONE
#include "host/xray/gl/gl_program.hpp"
#include <GLFW/glfw3.h>
#include <algorithm>
#include <stdexcept>

namespace crn
{
namespace
{

constexpr const char *vertex_source = R"(#version 330 core
out vec2 place;
void main() {
    vec2 corner = vec2(gl_VertexID & 1, gl_VertexID >> 1);
    place = vec2(corner.x, 1.0 - corner.y);
    gl_Position = vec4(corner * 2.0 - 1.0, 0.0, 1.0);
})";

constexpr const char *fragment_source = R"(#version 330 core
in vec2 place;
out vec4 colour;
uniform sampler2D picture;
void main() { colour = vec4(texture(picture, place).rgb, 1.0); })";

// The OpenGL context is current all the time, because the window's thread uses no other context.
class WindowContext final : public GlContext
{
  public:
    explicit WindowContext(GLFWwindow *window) : window_(window) {}
    void enter() override { glfwMakeContextCurrent(window_); }
    void leave() override {}
    GlFunction function(const char *name) const override { return glfwGetProcAddress(name); }
    std::string origin() const override { return "the window (GLFW)"; }

  private:
    GLFWwindow *window_;
};

} // namespace

Screen::Screen(const std::string &title, int edge)
{
    window_ = open_glfw_window(title, edge, edge);
    try {
        glfwMakeContextCurrent(window_);
        glfwSwapInterval(1);
        gl_ = load_functions(*context());
        build_pipeline();
    } catch (...) {
        glfwDestroyWindow(window_);
        glfwTerminate();
        throw;
    }
    glfwSetWindowUserPointer(window_, this);
    glfwSetKeyCallback(window_, [](GLFWwindow *window, int key, int, int action, int) {
        auto *self = static_cast<Screen *>(glfwGetWindowUserPointer(window));
        if (self->handler_)
            self->handler_({key, action == GLFW_PRESS, action == GLFW_REPEAT, action == GLFW_RELEASE});
    });
    glfwSetWindowRefreshCallback(window_, [](GLFWwindow *window) {
        auto *self = static_cast<Screen *>(glfwGetWindowUserPointer(window));
        if (self->texture_edge_ == 0) return;
        self->draw();
        glfwSwapBuffers(window);
    });
}

Screen::~Screen()
{
    glfwDestroyWindow(window_);
    glfwTerminate();
}

void Screen::build_pipeline()
{
    program_ = build_program(gl_, vertex_source, fragment_source);
    gl_.GenVertexArrays(1, &array_);
    gl_.GenTextures(1, &texture_);
    gl_.BindTexture(gl::texture_2d, texture_);
    for (unsigned filter : {gl::min_filter, gl::mag_filter})
        gl_.TexParameteri(gl::texture_2d, filter, gl::linear);
    for (unsigned wrap : {gl::wrap_s, gl::wrap_t}) gl_.TexParameteri(gl::texture_2d, wrap, gl::clamp_to_edge);
    gl_.PixelStorei(gl::unpack_alignment, 1);
    gl_.PixelStorei(gl::pack_alignment, 1);
}

std::unique_ptr<GlContext> Screen::context() const
{
    return std::make_unique<WindowContext>(window_);
}

void Screen::on_pointer(PointerHandler handler)
{
    pointer_handler_ = std::move(handler);
    // GLFW's callbacks are C functions, which can find this C++ object only through the window's user
    // pointer.
    struct Of {
        Screen *operator()(GLFWwindow *window) const
        {
            return static_cast<Screen *>(glfwGetWindowUserPointer(window));
        }
    };
    static constexpr Of of;
    glfwSetMouseButtonCallback(window_, [](GLFWwindow *window, int button, int action, int) {
        const bool is_press = action == GLFW_PRESS;
        of(window)->point(
            {is_press ? PointerEvent::Kind::press : PointerEvent::Kind::release, button, 0, 0, 0});
    });
    glfwSetCursorPosCallback(window_, [](GLFWwindow *window, double, double) {
        of(window)->point({PointerEvent::Kind::move, 0, 0, 0, 0});
    });
    glfwSetScrollCallback(window_, [](GLFWwindow *window, double, double notches) {
        of(window)->point({PointerEvent::Kind::wheel, 0, 0, 0, notches});
    });
}

void Screen::point(PointerEvent event)
{
    int width = 0, height = 0;
    double x = 0.0, y = 0.0;
    glfwGetWindowSize(window_, &width, &height);
    glfwGetCursorPos(window_, &x, &y);
    const int edge = std::min(width, height);
    if (edge <= 0 || texture_edge_ == 0) return; // no picture is shown
    event.x = (x - (width - edge) / 2) * texture_edge_ / edge;
    event.y = (y - (height - edge) / 2) * texture_edge_ / edge;
    pointer_handler_(event);
}

void Screen::poll()
{
    glfwPollEvents();
}
bool Screen::wants_close() const
{
    return glfwWindowShouldClose(window_) != 0;
}
bool Screen::is_down(int key) const
{
    return glfwGetKey(window_, key) == GLFW_PRESS;
}
bool Screen::has_focus() const
{
    return glfwGetWindowAttrib(window_, GLFW_FOCUSED) != 0;
}

void Screen::show(const Image &rgb)
{
    gl_.BindTexture(gl::texture_2d, texture_);
    if (texture_edge_ != rgb.width) {
        gl_.TexImage2D(gl::texture_2d, 0, gl::rgb8, rgb.width, rgb.height, 0, gl::rgb, gl::type_unsigned_byte,
                       rgb.bytes.data());
        texture_edge_ = rgb.width;
    } else {
        gl_.TexSubImage2D(gl::texture_2d, 0, 0, 0, rgb.width, rgb.height, gl::rgb, gl::type_unsigned_byte,
                          rgb.bytes.data());
    }
    draw();
    glfwSwapBuffers(window_);
}

// Every drawing reads the framebuffer's size again, so no other code needs to handle a resized window, or a
// move to a screen with smaller pixels.
void Screen::draw()
{
    int width = 0, height = 0;
    glfwGetFramebufferSize(window_, &width, &height);
    const int edge = std::min(width, height);
    if (edge <= 0) return; // minimised
    gl_.Viewport(0, 0, width, height);
    gl_.ClearColor(0.0f, 0.0f, 0.0f, 1.0f);
    gl_.Clear(gl::colour_buffer_bit);
    gl_.BindTexture(gl::texture_2d, texture_);
    gl_.Viewport((width - edge) / 2, (height - edge) / 2, edge, edge);
    gl_.UseProgram(program_);
    gl_.BindVertexArray(array_);
    gl_.DrawArrays(gl::triangle_strip, 0, 4);
}

// Draws the picture once more, and reads OpenGL's back buffer before the window shows this buffer; OpenGL
// returns the lowest row first.
Image Screen::read_back()
{
    draw();
    Image image{0, 0, 3, {}};
    glfwGetFramebufferSize(window_, &image.width, &image.height);
    const std::size_t row = static_cast<std::size_t>(image.width) * 3;
    std::vector<std::uint8_t> upward(row * image.height);
    gl_.ReadBuffer(gl::back);
    gl_.ReadPixels(0, 0, image.width, image.height, gl::rgb, gl::type_unsigned_byte, upward.data());
    for (int y = image.height - 1; y >= 0; --y)
        image.bytes.insert(image.bytes.end(), upward.begin() + row * y, upward.begin() + row * (y + 1));
    return image;
}

} // namespace crn
