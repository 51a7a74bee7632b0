#include "host/suite/suite_window.hpp"
#include "host/screen/glfw_window.hpp"
#include <imgui.h>
#include <imgui_freetype.h>
#include <imgui_internal.h>

#include <backends/imgui_impl_glfw.h>
#include <backends/imgui_impl_opengl3.h>
#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>
#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <stdexcept>
#include <string_view>
#include <utility>

namespace crn
{
namespace
{

constexpr float layout_width = 1600.0f, layout_height = 900.0f, scale_min = 0.8f;
constexpr float text_units = 15.0f, small_units = 12.5f, bold_units = 17.0f, large_units = 27.0f;

// Holds the OpenGL context of the X-ray code, in a window that is never shown.
class HiddenContext final : public GlContext
{
  public:
    explicit HiddenContext(GLFWwindow *window) : window_(window) {}
    void enter() override { glfwMakeContextCurrent(window_); }
    void leave() override { glfwMakeContextCurrent(nullptr); }
    GlFunction function(const char *name) const override { return glfwGetProcAddress(name); }
    std::string origin() const override { return "the window (GLFW)"; }

  private:
    GLFWwindow *window_;
};

// Represents the OpenGL context of the visible window; this context is always current in the drawing thread.
class ShownContext final : public GlContext
{
  public:
    void enter() override {}
    void leave() override {}
    GlFunction function(const char *name) const override { return glfwGetProcAddress(name); }
    std::string origin() const override { return "the window (GLFW)"; }
};

struct FontFiles {
    const char *text, *bold;
};
// The font DejaVu contains every character that the window writes, and is installed on nearly every Debian
// desktop.
constexpr FontFiles font_files[] = {
    {"/usr/share/fonts/truetype/dejavu/DejaVuSans.ttf",
     "/usr/share/fonts/truetype/dejavu/DejaVuSans-Bold.ttf"},
    {"/usr/share/fonts/TTF/DejaVuSans.ttf", "/usr/share/fonts/TTF/DejaVuSans-Bold.ttf"},
    {"/usr/share/fonts/dejavu-sans-fonts/DejaVuSans.ttf",
     "/usr/share/fonts/dejavu-sans-fonts/DejaVuSans-Bold.ttf"},
    {"/usr/share/fonts/truetype/liberation/LiberationSans-Regular.ttf",
     "/usr/share/fonts/truetype/liberation/LiberationSans-Bold.ttf"}};

FontFiles installed_font()
{
    std::error_code ignored;
    for (const FontFiles &files : font_files)
        if (std::filesystem::exists(files.text, ignored) && std::filesystem::exists(files.bold, ignored))
            return files;
    throw std::runtime_error(
        "window: no font; install fonts-dejavu-core (Debian), or name a file with --font");
}

void set_style(float scale)
{
    ImGuiStyle style;
    ImGui::StyleColorsDark(&style);
    style.WindowRounding = 0.0f;
    style.FrameRounding = 4.0f;
    style.GrabRounding = 4.0f;
    style.PopupRounding = 4.0f;
    style.ScrollbarSize = 12.0f;
    style.WindowPadding = {9.0f, 7.0f};
    style.FramePadding = {7.0f, 4.0f};
    style.ItemSpacing = {6.0f, 5.0f};
    style.WindowBorderSize = 0.0f;
    const ImVec4 panel(0.118f, 0.141f, 0.169f, 1.0f), raised(0.175f, 0.208f, 0.247f, 1.0f),
        bright(0.235f, 0.286f, 0.345f, 1.0f);
    style.Colors[ImGuiCol_WindowBg] = panel;
    style.Colors[ImGuiCol_ChildBg] = panel;
    style.Colors[ImGuiCol_PopupBg] = ImVec4(0.078f, 0.094f, 0.114f, 0.98f);
    style.Colors[ImGuiCol_Text] = ImVec4(0.91f, 0.93f, 0.94f, 1.0f);
    style.Colors[ImGuiCol_TextDisabled] = ImVec4(0.604f, 0.643f, 0.682f, 1.0f);
    style.Colors[ImGuiCol_Button] = raised;
    style.Colors[ImGuiCol_ButtonHovered] = bright;
    style.Colors[ImGuiCol_ButtonActive] = ImVec4(0.30f, 0.42f, 0.53f, 1.0f);
    style.Colors[ImGuiCol_FrameBg] = raised;
    style.Colors[ImGuiCol_FrameBgHovered] = bright;
    style.Colors[ImGuiCol_SliderGrab] = ImVec4(0.337f, 0.706f, 0.914f, 1.0f);
    style.Colors[ImGuiCol_SliderGrabActive] = ImVec4(0.902f, 0.624f, 0.0f, 1.0f);
    style.Colors[ImGuiCol_Separator] = bright;
    style.Colors[ImGuiCol_ScrollbarBg] = panel;
    style.Colors[ImGuiCol_ScrollbarGrab] = raised;
    style.Colors[ImGuiCol_ScrollbarGrabHovered] = bright;
    style.Colors[ImGuiCol_ScrollbarGrabActive] = bright;
    style.Colors[ImGuiCol_TableHeaderBg] = raised;
    style.Colors[ImGuiCol_PlotHistogram] = ImVec4(0.337f, 0.706f, 0.914f, 1.0f);
    style.ScaleAllSizes(scale);
    ImGui::GetStyle() = style;
}

} // namespace

SuiteWindow::SuiteWindow(const std::string &title, WindowSize size, const std::string &font)
{
    font_file_ = font;
    bold_file_ = font;
    if (font.empty()) {
        const FontFiles files = installed_font();
        font_file_ = files.text;
        bold_file_ = files.bold;
    } else if (std::error_code ignored; !std::filesystem::is_regular_file(font, ignored)) {
        throw std::runtime_error("window: there is no font '" + font + "'; name a TrueType file with --font");
    }
    open(title, size);
    try {
        paint_ = std::make_unique<PaintThread>(window_);
        paint_->run([this] {
            glfwSwapInterval(1);
            gl_ = load_functions(ShownContext());
            find_copy();
        });
        set_up_imgui();
    } catch (...) {
        paint_.reset();
        glfwTerminate();
        throw;
    }
}

SuiteWindow::~SuiteWindow()
{
    paint_->start([] { ImGui_ImplOpenGL3_Shutdown(); });
    paint_.reset();
    ImGui_ImplGlfw_Shutdown();
    ImGui::DestroyContext();
    glfwTerminate(); // destroys both windows
}

void SuiteWindow::open(const std::string &title, WindowSize size)
{
    window_ = open_glfw_window(title, size.width, size.height);
    glfwSetWindowSizeLimits(window_, 800, 450, GLFW_DONT_CARE, GLFW_DONT_CARE);
    glfwSetWindowUserPointer(window_, this);
    glfwSetKeyCallback(window_, [](GLFWwindow *window, int key, int, int action, int modifiers) {
        auto *self = static_cast<SuiteWindow *>(glfwGetWindowUserPointer(window));
        // A click on a text field sets WantTextInput only in the frame after the click; a key that is pressed
        // before that frame belongs to the field as well.
        const bool has_field =
            ImGui::GetIO().WantTextInput || ImGui::GetCurrentContext()->WantTextInputNextFrame == 1;
        const bool is_typing = has_field && action != GLFW_RELEASE;
        if (self->key_handler_ && !is_typing) self->key_handler_(key, action, modifiers);
    });
    glfwSetCursorPosCallback(window_, [](GLFWwindow *window, double x, double y) {
        auto *self = static_cast<SuiteWindow *>(glfwGetWindowUserPointer(window));
        self->pointer_x_ = static_cast<float>(x);
        self->pointer_y_ = static_cast<float>(y);
    });
    glfwSetMouseButtonCallback(window_, [](GLFWwindow *window, int button, int action, int) {
        auto *self = static_cast<SuiteWindow *>(glfwGetWindowUserPointer(window));
        if (button == GLFW_MOUSE_BUTTON_LEFT)
            self->button_events_.push_back({action == GLFW_PRESS, self->pointer_x_, self->pointer_y_});
    });
    glfwSetWindowRefreshCallback(window_, [](GLFWwindow *window) {
        static_cast<SuiteWindow *>(glfwGetWindowUserPointer(window))->is_shown_lost_ = true;
    });
    glfwSetWindowFocusCallback(window_, [](GLFWwindow *window, int has_focus) {
        auto *self = static_cast<SuiteWindow *>(glfwGetWindowUserPointer(window));
        if (self->focus_handler_ && !has_focus) self->focus_handler_();
    });
}

// ImGui's callbacks call those above. The program handles keys and the left mouse button in its own
// callbacks. This version of ImGui loses a key that is pressed and released between two frames. If the button
// is released and pressed again between two frames, ImGui does not notice the release, and a drag continues.
void SuiteWindow::set_up_imgui()
{
    ImGui::CreateContext();
    ImGuiIO &io = ImGui::GetIO();
    io.IniFilename = nullptr;
    io.ConfigFlags = ImGuiConfigFlags_None; // keys are controls; they do not walk through buttons
    io.Fonts->FontBuilderIO = ImGuiFreeType::GetBuilderForFreeType();
    bool can_draw = ImGui_ImplGlfw_InitForOpenGL(window_, true);
    paint_->run([&can_draw] { can_draw = can_draw && ImGui_ImplOpenGL3_Init("#version 330 core"); });
    if (!can_draw)
        throw std::runtime_error("window: Dear ImGui cannot draw with this OpenGL; install libgl1-mesa-dri");
    fit();
}

// Computes the sizes of text and panels from the size of the window. Text grows with the window, and stays
// legible on a screen with small pixels.
void SuiteWindow::fit()
{
    int width = 0, height = 0;
    glfwGetFramebufferSize(window_, &width, &height);
    float dense = 1.0f, ignored = 1.0f;
    glfwGetWindowContentScale(window_, &dense, &ignored);
    width_ = static_cast<float>(width);
    height_ = static_cast<float>(height);
    const float wanted = std::min(width_ / layout_width, height_ / layout_height);
    const float scale = std::max(wanted, scale_min * std::min(dense, std::max(wanted, 1.0f)));
    if (width <= 0 || height <= 0 || std::fabs(scale - scale_) < 0.01f) return;
    scale_ = scale;
    set_style(scale);
    build_fonts();
}

void SuiteWindow::build_fonts()
{
    ImGuiIO &io = ImGui::GetIO();
    io.Fonts->Clear();
    static constexpr ImWchar ranges[] = {0x20,   0xff,   0x2010, 0x2026, 0x2080, 0x2089,
                                         0x2190, 0x21ff, 0x25a0, 0x25ff, 0};
    const auto add = [&](const std::string &file, float units) {
        ImFont *font =
            io.Fonts->AddFontFromFileTTF(file.c_str(), std::round(units * scale_), nullptr, ranges);
        if (!font) throw std::runtime_error("window: '" + file + "' is no font; name another with --font");
        return font;
    };
    fonts_ = {add(font_file_, text_units), add(font_file_, small_units), add(bold_file_, bold_units),
              add(bold_file_, large_units)};
    if (!io.Fonts->Build()) throw std::runtime_error("window: '" + font_file_ + "' cannot be drawn");
    are_fonts_new_ = true;
}

void SuiteWindow::poll(double seconds)
{
    if (seconds > 0.0)
        glfwWaitEventsTimeout(seconds);
    else
        glfwPollEvents();
}

bool SuiteWindow::wants_close() const
{
    return glfwWindowShouldClose(window_) != 0;
}

// Passes to ImGui at most one press or release of the left button per frame, with the position of the pointer
// at that moment.
void SuiteWindow::show_button()
{
    ImGuiIO &io = ImGui::GetIO();
    if (!button_events_.empty()) {
        const ButtonEvent event = button_events_.front();
        button_events_.pop_front();
        is_button_down_ = event.is_down;
        io.MousePos = {event.x, event.y};
    }
    io.MouseDown[ImGuiMouseButton_Left] = is_button_down_;
}

// If the fonts have changed, makes the texture of the letters again, because ImGui itself makes this texture
// only once.
void SuiteWindow::begin_frame()
{
    paint_->finish();
    fit();
    if (are_fonts_new_)
        paint_->run([] {
            ImGui_ImplOpenGL3_DestroyFontsTexture();
            ImGui_ImplOpenGL3_NewFrame();
            if (!ImGui::GetIO().Fonts->TexID) ImGui_ImplOpenGL3_CreateFontsTexture();
        });
    if (std::exchange(are_fonts_new_, false)) is_shown_lost_ = true;
    ImGui_ImplGlfw_NewFrame();
    show_button();
    ImGui::NewFrame();
}

// ImGui keeps its drawing commands until the next frame begins, so the drawing thread can use them.
void SuiteWindow::end_frame()
{
    ImGui::Render();
    const bool is_lost = std::exchange(is_shown_lost_, false);
    paint_->start([this, size = size_now(), is_lost, uploads = std::exchange(uploads_, {})] {
        for (const Upload &picture : uploads) upload(picture);
        if (is_lost) changes_.forget();
        if (copy_part_) {
            draw_changes(size, uploads);
        } else {
            draw(size);
            glfwSwapBuffers(window_);
        }
        shown_at_ = std::chrono::steady_clock::now();
    });
}

ScreenSize SuiteWindow::size_now() const
{
    ScreenSize size;
    glfwGetFramebufferSize(window_, &size.width, &size.height);
    return size;
}

// Without a graphics card, Mesa draws into main memory, and can copy a part of the drawn frame to the window.
void SuiteWindow::find_copy()
{
    const auto *renderer = reinterpret_cast<const char *>(gl_.GetString(gl::renderer));
    const std::string_view name = renderer ? renderer : "";
    const bool is_slow = name.starts_with("llvmpipe") || name.starts_with("softpipe");
    if (!is_slow || !glfwExtensionSupported("GLX_MESA_copy_sub_buffer")) return;
    const auto display = reinterpret_cast<void *(*)()>(glfwGetProcAddress("glXGetCurrentDisplay"));
    const auto drawable = reinterpret_cast<unsigned long (*)()>(glfwGetProcAddress("glXGetCurrentDrawable"));
    const auto copy = reinterpret_cast<CopyPart>(glfwGetProcAddress("glXCopySubBufferMESA"));
    query_drawable_ = reinterpret_cast<QueryDrawable>(glfwGetProcAddress("glXQueryDrawable"));
    if (!display || !drawable || !copy || !query_drawable_) return;
    glx_display_ = display();
    glx_drawable_ = drawable();
    copy_part_ = glx_display_ && glx_drawable_ ? copy : nullptr;
}

void SuiteWindow::draw(ScreenSize size)
{
    gl_.Viewport(0, 0, size.width, size.height);
    gl_.ClearColor(0.063f, 0.078f, 0.094f, 1.0f);
    gl_.Clear(gl::colour_buffer_bit);
    ImGui_ImplOpenGL3_RenderDrawData(ImGui::GetDrawData());
}

// Makes Mesa allocate a back buffer of this size, by swapping the buffers once. Returns false if the window's
// size has changed meanwhile, because a part that is copied must not reach beyond the back buffer.
bool SuiteWindow::fit_back_buffer(ScreenSize size)
{
    const auto has_size = [&] {
        constexpr int glx_width = 0x801D, glx_height = 0x801E;
        unsigned width = 0, height = 0;
        query_drawable_(glx_display_, glx_drawable_, glx_width, &width);
        query_drawable_(glx_display_, glx_drawable_, glx_height, &height);
        return ScreenSize{static_cast<int>(width), static_cast<int>(height)} == size;
    };
    if (!has_size()) return false;
    glfwSwapBuffers(window_);
    gl_.Viewport(0, 0, size.width, size.height);
    gl_.Clear(gl::colour_buffer_bit);
    return has_size();
}

// Draws and shows only those parts of the window that differ from the last frame. The buffers are not
// swapped, so the back buffer keeps all other parts.
void SuiteWindow::draw_changes(ScreenSize size, const std::vector<Upload> &uploads)
{
    if (back_buffer_ != size) {
        changes_.forget();
        back_buffer_ = fit_back_buffer(size) ? size : ScreenSize{};
        if (back_buffer_ != size) return; // the next screen tries again
    }
    const auto id_of = [](unsigned name) {
        return reinterpret_cast<ImTextureID>(static_cast<std::uintptr_t>(name));
    };
    std::vector<ImTextureID> fresh, pictures;
    for (const Upload &picture : uploads) fresh.push_back(id_of(picture.name));
    for (const Texture &texture : textures_) pictures.push_back(id_of(texture.name));
    ImDrawData &data = *ImGui::GetDrawData();
    const std::vector<ScreenRect> places = changes_.take(data, size, fresh);
    keep_places(data, size, places, pictures);
    gl_.Viewport(0, 0, size.width, size.height);
    gl_.ClearColor(0.063f, 0.078f, 0.094f, 1.0f);
    gl_.Enable(gl::scissor_test);
    for (const ScreenRect &place : places) {
        gl_.Scissor(place.left, size.height - place.bottom, place.right - place.left,
                    place.bottom - place.top);
        gl_.Clear(gl::colour_buffer_bit);
    }
    gl_.Disable(gl::scissor_test);
    ImGui_ImplOpenGL3_RenderDrawData(&data);
    for (const ScreenRect &place : places)
        copy_part_(glx_display_, glx_drawable_, place.left, size.height - place.bottom,
                   place.right - place.left, place.bottom - place.top);
}

// Reads the last frame from OpenGL's back buffer. If the window swaps its buffers for every frame, the back
// buffer does not keep the last frame, so the function first draws this frame again. OpenGL returns the
// lowest row first.
Image SuiteWindow::read_back()
{
    const ScreenSize size = size_now();
    Image image{size.width, size.height, 3, {}};
    const std::size_t row = static_cast<std::size_t>(image.width) * 3;
    std::vector<std::uint8_t> upward(row * static_cast<std::size_t>(image.height));
    paint_->run([&] {
        if (!copy_part_) draw(size);
        gl_.PixelStorei(gl::pack_alignment, 1);
        gl_.ReadBuffer(gl::back);
        gl_.ReadPixels(0, 0, image.width, image.height, gl::rgb, gl::type_unsigned_byte, upward.data());
    });
    for (int y = image.height - 1; y >= 0; --y)
        image.bytes.insert(image.bytes.end(), upward.begin() + static_cast<std::ptrdiff_t>(row) * y,
                           upward.begin() + static_cast<std::ptrdiff_t>(row) * (y + 1));
    return image;
}

// The drawing thread is idle during this call, because a frame is being composed.
void *SuiteWindow::texture(std::size_t slot, int size, const std::vector<std::uint8_t> &grey,
                           std::uint64_t version, bool is_sharp)
{
    if (textures_.size() <= slot) textures_.resize(slot + 1);
    Texture &texture = textures_[slot];
    const bool is_new = texture.name == 0;
    if (is_new) paint_->run([&] { gl_.GenTextures(1, &texture.name); });
    const bool is_stale = is_new || texture.version != version || texture.size != size;
    if (is_stale || texture.is_sharp != is_sharp) {
        const std::vector<std::uint8_t> none;
        uploads_.push_back({texture.name, size, is_stale ? grey : none, is_sharp});
        texture = {texture.name, size, version, is_sharp};
    }
    return reinterpret_cast<void *>(static_cast<std::uintptr_t>(texture.name));
}

void SuiteWindow::upload(const Upload &picture)
{
    gl_.BindTexture(gl::texture_2d, picture.name);
    for (unsigned filter : {gl::min_filter, gl::mag_filter})
        gl_.TexParameteri(gl::texture_2d, filter, picture.is_sharp ? gl::nearest : gl::linear);
    for (unsigned wrap : {gl::wrap_s, gl::wrap_t}) gl_.TexParameteri(gl::texture_2d, wrap, gl::clamp_to_edge);
    if (picture.grey.empty()) return;
    // The texture has one byte per pixel, in its red channel, which is shown as red, green and blue.
    for (unsigned colour : {gl::swizzle_r, gl::swizzle_g, gl::swizzle_b})
        gl_.TexParameteri(gl::texture_2d, colour, static_cast<int>(gl::red));
    gl_.TexParameteri(gl::texture_2d, gl::swizzle_a, static_cast<int>(gl::one));
    gl_.PixelStorei(gl::unpack_alignment, 1);
    gl_.TexImage2D(gl::texture_2d, 0, gl::r8, picture.size, picture.size, 0, gl::red, gl::type_unsigned_byte,
                   picture.grey.data());
}

std::unique_ptr<GlContext> SuiteWindow::context()
{
    if (!hidden_) {
        glfwWindowHint(GLFW_VISIBLE, GLFW_FALSE);
        hidden_ = glfwCreateWindow(16, 16, "Cournand X-ray", nullptr, nullptr);
        if (!hidden_) throw std::runtime_error("window: no second OpenGL context (" + glfw_reason() + ")");
    }
    return std::make_unique<HiddenContext>(hidden_);
}

} // namespace crn
