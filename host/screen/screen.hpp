// Opens a window with the library GLFW; the window shows one square picture in its middle, as large as fits.
// The program finds every OpenGL function by its name at run time, so it does not need to be linked with an
// OpenGL library.
#pragma once
#include "host/picture/picture.hpp"
#include "host/xray/gl/gl_context.hpp"
#include <functional>
#include <memory>
#include <string>

struct GLFWwindow;

namespace crn
{

class Screen
{
  public:
    // Key (GLFW_KEY_*), and its event.
    struct KeyEvent {
        int key = 0;
        bool is_press = false, is_repeat = false, is_release = false;
    };
    using KeyHandler = std::function<void(const KeyEvent &)>;
    // Holds the position of the mouse pointer, in pixels of the picture shown last; y increases downwards.
    struct PointerEvent {
        enum class Kind { press, release, move, wheel } kind = Kind::move;
        int button = 0; // GLFW_MOUSE_BUTTON_*, of press and release
        double x = 0.0, y = 0.0;
        double wheel = 0.0; // notches, above 0 away from the user
    };
    using PointerHandler = std::function<void(const PointerEvent &)>;

    // Throws std::runtime_error if the computer has no display or no OpenGL 3.3; the message says which of
    // them is missing.
    Screen(const std::string &title, int edge);
    ~Screen();
    Screen(const Screen &) = delete;
    Screen &operator=(const Screen &) = delete;

    void on_key(KeyHandler handler) { handler_ = std::move(handler); }
    void on_pointer(PointerHandler handler); // from now on the handler gets the pointer's events
    void poll();
    bool wants_close() const;
    bool is_down(int key) const;
    bool has_focus() const;
    void show(const Image &rgb); // uploads, draws, swaps
    Image read_back();           // the whole window as last shown
    // Returns the window's own OpenGL context, in which the X-ray code can compute path lengths. The window
    // must outlive it.
    std::unique_ptr<GlContext> context() const;

  private:
    void build_pipeline();
    void draw();
    void point(PointerEvent event); // adds the pointer's place

    GLFWwindow *window_ = nullptr;
    GlFunctions gl_;
    KeyHandler handler_;
    PointerHandler pointer_handler_;
    unsigned program_ = 0, array_ = 0, texture_ = 0;
    int texture_edge_ = 0;
};

} // namespace crn
