// GLFW and OpenGL 3.3 core.
#include "host/app/window_screen.hpp"
#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>
#include <algorithm>
#include <cstring>
#include <stdexcept>

namespace seld
{
namespace
{

// The few constants of OpenGL that are used (Khronos registry).
constexpr unsigned gl_colour_buffer = 0x4000, gl_triangle_strip = 5, gl_texture_2d = 0x0DE1, gl_rgb = 0x1907,
                   gl_rgb8 = 0x8051, gl_unsigned_byte = 0x1401, gl_min_filter = 0x2801,
                   gl_mag_filter = 0x2800, gl_linear = 0x2601, gl_wrap_s = 0x2802, gl_wrap_t = 0x2803,
                   gl_clamp_to_edge = 0x812F, gl_unpack_alignment = 0x0CF5, gl_pack_alignment = 0x0D05,
                   gl_vertex_shader = 0x8B31, gl_fragment_shader = 0x8B30, gl_compile_status = 0x8B81,
                   gl_link_status = 0x8B82, gl_back = 0x0405;

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

std::string glfw_reason()
{
    const char *text = nullptr;
    glfwGetError(&text);
    return text ? text : "no reason given";
}

} // namespace

struct Screen::Functions {
    void (*ClearColor)(float, float, float, float);
    void (*Clear)(unsigned);
    void (*Viewport)(int, int, int, int);
    void (*GenTextures)(int, unsigned *);
    void (*BindTexture)(unsigned, unsigned);
    void (*TexParameteri)(unsigned, unsigned, int);
    void (*TexImage2D)(unsigned, int, int, int, int, int, unsigned, unsigned, const void *);
    void (*TexSubImage2D)(unsigned, int, int, int, int, int, unsigned, unsigned, const void *);
    void (*PixelStorei)(unsigned, int);
    unsigned (*CreateShader)(unsigned);
    void (*ShaderSource)(unsigned, int, const char *const *, const int *);
    void (*CompileShader)(unsigned);
    void (*GetShaderiv)(unsigned, unsigned, int *);
    unsigned (*CreateProgram)();
    void (*AttachShader)(unsigned, unsigned);
    void (*LinkProgram)(unsigned);
    void (*GetProgramiv)(unsigned, unsigned, int *);
    void (*UseProgram)(unsigned);
    void (*GenVertexArrays)(int, unsigned *);
    void (*BindVertexArray)(unsigned);
    void (*DrawArrays)(unsigned, int, int);
    void (*ReadBuffer)(unsigned);
    void (*ReadPixels)(int, int, int, int, unsigned, unsigned, void *);
};

void Screen::load_functions()
{
    gl_ = std::make_unique<Functions>();
    auto load = [](auto &function, const char *name) {
        const GLFWglproc address = glfwGetProcAddress(name);
        if (!address) throw std::runtime_error(std::string("window: this OpenGL has no ") + name);
        std::memcpy(&function, &address, sizeof function);
    };
    load(gl_->ClearColor, "glClearColor");
    load(gl_->Clear, "glClear");
    load(gl_->Viewport, "glViewport");
    load(gl_->GenTextures, "glGenTextures");
    load(gl_->BindTexture, "glBindTexture");
    load(gl_->TexParameteri, "glTexParameteri");
    load(gl_->TexImage2D, "glTexImage2D");
    load(gl_->TexSubImage2D, "glTexSubImage2D");
    load(gl_->PixelStorei, "glPixelStorei");
    load(gl_->CreateShader, "glCreateShader");
    load(gl_->ShaderSource, "glShaderSource");
    load(gl_->CompileShader, "glCompileShader");
    load(gl_->GetShaderiv, "glGetShaderiv");
    load(gl_->CreateProgram, "glCreateProgram");
    load(gl_->AttachShader, "glAttachShader");
    load(gl_->LinkProgram, "glLinkProgram");
    load(gl_->GetProgramiv, "glGetProgramiv");
    load(gl_->UseProgram, "glUseProgram");
    load(gl_->GenVertexArrays, "glGenVertexArrays");
    load(gl_->BindVertexArray, "glBindVertexArray");
    load(gl_->DrawArrays, "glDrawArrays");
    load(gl_->ReadBuffer, "glReadBuffer");
    load(gl_->ReadPixels, "glReadPixels");
}

Screen::Screen(const std::string &title, int edge)
{
    if (!glfwInit())
        throw std::runtime_error("window: no display (" + glfw_reason() +
                                 "); set DISPLAY, or make a film with `seldinger run --mp4 FILE`");
    glfwWindowHint(GLFW_CONTEXT_VERSION_MAJOR, 3);
    glfwWindowHint(GLFW_CONTEXT_VERSION_MINOR, 3);
    glfwWindowHint(GLFW_OPENGL_PROFILE, GLFW_OPENGL_CORE_PROFILE);
    glfwWindowHint(GLFW_OPENGL_FORWARD_COMPAT, GLFW_TRUE);
    glfwWindowHint(GLFW_SCALE_TO_MONITOR, GLFW_TRUE);
    window_ = glfwCreateWindow(edge, edge, title.c_str(), nullptr, nullptr);
    if (!window_) {
        const std::string reason = glfw_reason();
        glfwTerminate();
        throw std::runtime_error(
            "window: no OpenGL 3.3 window (" + reason +
            "); install a graphics driver (Debian: libgl1-mesa-dri), or make a film with "
            "`seldinger run --mp4 FILE`");
    }
    try {
        glfwMakeContextCurrent(window_);
        glfwSwapInterval(1);
        load_functions();
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
    program_ = gl_->CreateProgram();
    const std::pair<unsigned, const char *> parts[] = {{gl_vertex_shader, vertex_source},
                                                       {gl_fragment_shader, fragment_source}};
    for (const auto &[kind, source] : parts) {
        const unsigned shader = gl_->CreateShader(kind);
        gl_->ShaderSource(shader, 1, &source, nullptr);
        gl_->CompileShader(shader);
        int compiled = 0;
        gl_->GetShaderiv(shader, gl_compile_status, &compiled);
        if (!compiled) throw std::runtime_error("window: the graphics driver refuses the picture's shader");
        gl_->AttachShader(program_, shader);
    }
    gl_->LinkProgram(program_);
    int linked = 0;
    gl_->GetProgramiv(program_, gl_link_status, &linked);
    if (!linked) throw std::runtime_error("window: the graphics driver refuses the picture's program");
    gl_->GenVertexArrays(1, &array_);
    gl_->GenTextures(1, &texture_);
    gl_->BindTexture(gl_texture_2d, texture_);
    for (unsigned filter : {gl_min_filter, gl_mag_filter})
        gl_->TexParameteri(gl_texture_2d, filter, gl_linear);
    for (unsigned wrap : {gl_wrap_s, gl_wrap_t}) gl_->TexParameteri(gl_texture_2d, wrap, gl_clamp_to_edge);
    gl_->PixelStorei(gl_unpack_alignment, 1);
    gl_->PixelStorei(gl_pack_alignment, 1);
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
    gl_->BindTexture(gl_texture_2d, texture_);
    if (texture_edge_ != rgb.width) {
        gl_->TexImage2D(gl_texture_2d, 0, gl_rgb8, rgb.width, rgb.height, 0, gl_rgb, gl_unsigned_byte,
                        rgb.bytes.data());
        texture_edge_ = rgb.width;
    } else {
        gl_->TexSubImage2D(gl_texture_2d, 0, 0, 0, rgb.width, rgb.height, gl_rgb, gl_unsigned_byte,
                           rgb.bytes.data());
    }
    draw();
    glfwSwapBuffers(window_);
}

// The framebuffer's size is asked for every time: resizing and moving to a denser screen need nothing more.
void Screen::draw()
{
    int width = 0, height = 0;
    glfwGetFramebufferSize(window_, &width, &height);
    const int edge = std::min(width, height);
    if (edge <= 0) return; // minimised
    gl_->Viewport(0, 0, width, height);
    gl_->ClearColor(0.0f, 0.0f, 0.0f, 1.0f);
    gl_->Clear(gl_colour_buffer);
    gl_->Viewport((width - edge) / 2, (height - edge) / 2, edge, edge);
    gl_->UseProgram(program_);
    gl_->BindVertexArray(array_);
    gl_->DrawArrays(gl_triangle_strip, 0, 4);
}

// Draws once more and reads the back buffer before it is shown; rows arrive from the bottom.
Image Screen::read_back()
{
    draw();
    Image image{0, 0, 3, {}};
    glfwGetFramebufferSize(window_, &image.width, &image.height);
    const std::size_t row = static_cast<std::size_t>(image.width) * 3;
    std::vector<std::uint8_t> upward(row * image.height);
    gl_->ReadBuffer(gl_back);
    gl_->ReadPixels(0, 0, image.width, image.height, gl_rgb, gl_unsigned_byte, upward.data());
    for (int y = image.height - 1; y >= 0; --y)
        image.bytes.insert(image.bytes.end(), upward.begin() + row * y, upward.begin() + row * (y + 1));
    return image;
}

} // namespace seld
