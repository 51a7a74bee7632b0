// Implements EGL without a surface, which Mesa offers as the replacement for OSMesa. EGL without a surface
// needs no display server, and neither does OSMesa.
#include "host/base/format.hpp"
#include "host/xray/gl/gl_headless.hpp"
#include "host/xray/gl/gl_library.hpp"
#include <mutex>

namespace crn
{
namespace
{

// The next constants are those of EGL/egl.h and EGL/eglext.h (Khronos registry).
constexpr unsigned egl_platform_surfaceless_mesa = 0x31DD, egl_opengl_api = 0x30A2;
constexpr int egl_surface_type = 0x3033, egl_pbuffer_bit = 1, egl_renderable_type = 0x3040,
              egl_opengl_bit = 8, egl_none = 0x3038, egl_context_major = 0x3098, egl_context_minor = 0x30FB,
              egl_profile_mask = 0x30FD, egl_core_profile_bit = 1, egl_extensions = 0x3055;

using Handle = void *;

struct Egl {
    GlLibraryFile file;
    GlFunction (*address)(const char *name) = nullptr;
    const char *(*query)(Handle display, int name) = nullptr;
    unsigned (*initialise)(Handle display, int *major, int *minor) = nullptr;
    unsigned (*terminate)(Handle display) = nullptr;
    unsigned (*bind_api)(unsigned api) = nullptr;
    unsigned (*choose_config)(Handle display, const int *attributes, Handle *configs, int capacity,
                              int *count) = nullptr;
    Handle (*create)(Handle display, Handle config, Handle share, const int *attributes) = nullptr;
    unsigned (*destroy)(Handle display, Handle context) = nullptr;
    unsigned (*make_current)(Handle display, Handle draw, Handle read, Handle context) = nullptr;
    int (*error)() = nullptr;
    unsigned (*release_thread)() = nullptr;
    Handle (*platform_display)(unsigned platform, void *native,
                               const int *attributes) = nullptr; // EGL_EXT_platform_base

    explicit Egl(const std::vector<std::string> &names) : file(names)
    {
        file.find(address, "eglGetProcAddress");
        file.find(query, "eglQueryString");
        file.find(initialise, "eglInitialize");
        file.find(terminate, "eglTerminate");
        file.find(bind_api, "eglBindAPI");
        file.find(choose_config, "eglChooseConfig");
        file.find(create, "eglCreateContext");
        file.find(destroy, "eglDestroyContext");
        file.find(make_current, "eglMakeCurrent");
        file.find(error, "eglGetError");
        file.find(release_thread, "eglReleaseThread");
        if (!address) return;
        const GlFunction found = address("eglGetPlatformDisplayEXT");
        std::memcpy(&platform_display, &found, sizeof platform_display);
    }
    bool is_whole() const
    {
        return address && query && initialise && terminate && bind_api && choose_config && create &&
               destroy && make_current && error && release_thread;
    }
    bool has_surfaceless() const
    {
        const char *text = query(nullptr, egl_extensions);
        return platform_display && text &&
               std::string(text).find("EGL_MESA_platform_surfaceless") != std::string::npos;
    }
};

std::string code_of(const Egl &egl)
{
    return formatted("0x%04x", static_cast<unsigned>(egl.error()));
}

// Holds the display for EGL without a surface; a process has only one such display. EGL gives every caller in
// a process the same display, and ending this display ends all its contexts. The EGL display is therefore
// ended only together with the last context.
class Display
{
  public:
    explicit Display(const Egl &egl) : egl_(egl)
    {
        display_ = egl.platform_display(egl_platform_surfaceless_mesa, nullptr, nullptr);
        int major = 0, minor = 0;
        if (!display_ || !egl.initialise(display_, &major, &minor))
            throw GlError("EGL (" + egl.file.name() + ") gives no surfaceless display (error " +
                          code_of(egl) + "; Debian: libgl1-mesa-dri)");
    }
    ~Display()
    {
        egl_.terminate(display_);
        egl_.release_thread();
    }
    Display(const Display &) = delete;
    Display &operator=(const Display &) = delete;

    const Egl &egl() const { return egl_; }
    Handle handle() const { return display_; }

    static std::shared_ptr<Display> shared(const std::vector<std::string> &names);

  private:
    Egl egl_;
    Handle display_ = nullptr;
};

std::shared_ptr<Display> Display::shared(const std::vector<std::string> &names)
{
    static std::mutex mutex;
    static std::weak_ptr<Display> present;
    const std::lock_guard lock(mutex);
    const Egl egl(names);
    if (!egl.file.is_open()) throw GlError("EGL is missing (" + egl.file.problem() + "; Debian: libegl1)");
    if (!egl.is_whole()) throw GlError("EGL (" + egl.file.name() + ") lacks functions of EGL 1.4");
    if (!egl.has_surfaceless())
        throw GlError("EGL (" + egl.file.name() +
                      ") works only with a display: no EGL_MESA_platform_surfaceless (Debian: libegl-mesa0)");
    std::shared_ptr<Display> display = present.lock();
    if (!display) present = display = std::make_shared<Display>(egl);
    return display;
}

class EglContext final : public GlContext
{
  public:
    explicit EglContext(std::shared_ptr<Display> display)
        : display_(std::move(display)), egl_(display_->egl())
    {
        egl_.bind_api(egl_opengl_api);
        const int wanted[] = {egl_surface_type, egl_pbuffer_bit, egl_renderable_type, egl_opengl_bit,
                              egl_none};
        Handle config = nullptr;
        int count = 0;
        egl_.choose_config(display_->handle(), wanted, &config, 1, &count);
        const int attributes[] = {egl_context_major,    3,       egl_context_minor, 3, egl_profile_mask,
                                  egl_core_profile_bit, egl_none};
        if (count > 0) handle_ = egl_.create(display_->handle(), config, nullptr, attributes);
        if (!handle_)
            throw GlError(origin() + " gives no core 3.3 context (error " + code_of(egl_) +
                          "; Debian: libgl1-mesa-dri)");
    }
    ~EglContext() override { egl_.destroy(display_->handle(), handle_); }

    void enter() override
    {
        egl_.bind_api(egl_opengl_api);
        if (!egl_.make_current(display_->handle(), nullptr, nullptr, handle_))
            throw GlLost("OpenGL: " + origin() + " does not make its context current (error " +
                         code_of(egl_) + ")");
    }
    void leave() override { egl_.make_current(display_->handle(), nullptr, nullptr, nullptr); }
    GlFunction function(const char *name) const override { return egl_.address(name); }
    std::string origin() const override { return "EGL without surface (" + egl_.file.name() + ")"; }

  private:
    std::shared_ptr<Display> display_;
    const Egl &egl_;
    Handle handle_ = nullptr;
};

} // namespace

std::unique_ptr<GlContext> open_egl(const std::vector<std::string> &file_names)
{
    return std::make_unique<EglContext>(Display::shared(file_names));
}

} // namespace crn
