// Opens the suite's window with GLFW and draws its contents with Dear ImGui: fonts, textures for the
// monitors, and the sizes of all parts. Only the thread that made this object may use it. The window is drawn
// in a separate thread, so that keys can be read during the drawing.
#pragma once
#include "host/picture/picture.hpp"
#include "host/screen/paint_thread.hpp"
#include "host/suite/screen_changes.hpp"
#include "host/xray/gl/gl_context.hpp"
#include <chrono>
#include <deque>
#include <functional>
#include <memory>
#include <string>
#include <vector>

struct GLFWwindow;
struct ImFont;

namespace crn
{

struct UiFonts {
    ImFont *text = nullptr, *small_text = nullptr, *bold = nullptr, *large = nullptr;
};

struct WindowSize {
    int width = 1600, height = 900; // pixels of the screen's coordinates
};

class SuiteWindow
{
  public:
    using KeyHandler = std::function<void(int key, int action, int modifiers)>;

    // `font` names a TrueType file; if it is empty, the installed DejaVu Sans or Liberation Sans is used.
    // Throws std::runtime_error if the computer has no display, no OpenGL 3.3 or no font; the message names
    // the remedy.
    SuiteWindow(const std::string &title, WindowSize size, const std::string &font);
    ~SuiteWindow();
    SuiteWindow(const SuiteWindow &) = delete;
    SuiteWindow &operator=(const SuiteWindow &) = delete;

    // The handler receives no keys while the user types into a text field.
    void on_key(KeyHandler handler) { key_handler_ = std::move(handler); }
    void on_focus_lost(std::function<void()> handler) { focus_handler_ = std::move(handler); }
    // Handles all pending events; if none is pending, waits up to `seconds` for the first one.
    void poll(double seconds);
    bool wants_close() const;
    void begin_frame(); // waits until the frame before is shown
    void end_frame();   // hands the frame to the thread that draws and shows it
    bool is_drawing() const { return !paint_->is_idle(); }
    // Returns the time at which the last frame was shown; call this function only while no frame is being
    // drawn.
    std::chrono::steady_clock::time_point shown_at() const { return shown_at_; }
    Image read_back(); // the window as last shown

    float scale() const { return scale_; } // pixels per unit of the layout, which is about 1600 x 900 units
    float width() const { return width_; } // of the window, in pixels
    float height() const { return height_; }
    const UiFonts &fonts() const { return fonts_; }

    // Loads a grey picture into texture number `slot`, unless the texture already has this `version`, and
    // returns the texture for ImGui. `is_sharp` shows single pixels.
    void *texture(std::size_t slot, int size, const std::vector<std::uint8_t> &grey, std::uint64_t version,
                  bool is_sharp);
    // Returns an OpenGL context for the X-ray code, which another thread may use. The window must outlive it.
    std::unique_ptr<GlContext> context();

  private:
    struct Texture {
        unsigned name = 0;
        int size = 0;
        std::uint64_t version = 0;
        bool is_sharp = false;
    };
    struct Upload { // that waits for the frame which shows it
        unsigned name = 0;
        int size = 0;
        std::vector<std::uint8_t> grey; // empty: only the filter changes
        bool is_sharp = false;
    };
    void open(const std::string &title, WindowSize size);
    void set_up_imgui();
    void fit();
    void show_button();
    void build_fonts();
    void upload(const Upload &upload);
    void find_copy();
    bool fit_back_buffer(ScreenSize size);
    void draw(ScreenSize size);
    void draw_changes(ScreenSize size, const std::vector<Upload> &uploads);
    ScreenSize size_now() const;

    // Describes a press or a release of the left mouse button, with the position of the pointer at that
    // moment.
    struct ButtonEvent {
        bool is_down = false;
        float x = 0.0f, y = 0.0f;
    };

    GLFWwindow *window_ = nullptr, *hidden_ = nullptr;
    std::deque<ButtonEvent> button_events_; // that no frame has shown to ImGui yet
    bool is_button_down_ = false;           // as ImGui has seen it
    float pointer_x_ = 0.0f, pointer_y_ = 0.0f;
    GlFunctions gl_;
    KeyHandler key_handler_;
    std::function<void()> focus_handler_;
    std::string font_file_, bold_file_;
    UiFonts fonts_;
    float scale_ = 0.0f, width_ = 0.0f, height_ = 0.0f;
    std::vector<Texture> textures_;
    std::vector<Upload> uploads_;
    bool are_fonts_new_ = false;
    bool is_shown_lost_ = false; // the window must be drawn wholly
    // Copies a part of the back buffer to the window (GLX_MESA_copy_sub_buffer). The pointer is null if there
    // is a graphics card, which draws the whole window faster than the program could find the changed parts.
    using CopyPart = void (*)(void *display, unsigned long drawable, int x, int y, int width, int height);
    CopyPart copy_part_ = nullptr;
    using QueryDrawable = int (*)(void *display, unsigned long drawable, int attribute, unsigned *value);
    QueryDrawable query_drawable_ = nullptr;
    ScreenSize back_buffer_; // empty: not known
    void *glx_display_ = nullptr;
    unsigned long glx_drawable_ = 0;
    ScreenChanges changes_;
    std::chrono::steady_clock::time_point shown_at_{};
    std::unique_ptr<PaintThread> paint_; // OpenGL belongs to it
};

} // namespace crn
