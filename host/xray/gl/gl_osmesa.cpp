// Mesa's off-screen library needs neither a display nor a graphics card, and has the core profile since Mesa
// 11.2.
#include "host/xray/gl/gl_headless.hpp"
#include "host/xray/gl/gl_library.hpp"
#include <array>

namespace crn
{
namespace
{

// Constants of GL/osmesa.h.
constexpr int osmesa_format = 0x22, osmesa_depth_bits = 0x30, osmesa_profile = 0x33,
              osmesa_core_profile = 0x34, osmesa_major = 0x36, osmesa_minor = 0x37, osmesa_rgba = 0x1908;

using Handle = struct osmesa_context *;

struct OsMesa {
    GlLibraryFile file;
    Handle (*create)(const int *attributes, Handle share) = nullptr;
    void (*destroy)(Handle context) = nullptr;
    unsigned char (*make_current)(Handle context, void *pixels, unsigned type, int width,
                                  int height) = nullptr;
    GlFunction (*address)(const char *name) = nullptr;

    explicit OsMesa(const std::vector<std::string> &names) : file(names)
    {
        file.find(create, "OSMesaCreateContextAttribs");
        file.find(destroy, "OSMesaDestroyContext");
        file.find(make_current, "OSMesaMakeCurrent");
        file.find(address, "OSMesaGetProcAddress");
    }
    bool is_whole() const { return create && destroy && make_current && address; }
};

class OsMesaContext final : public GlContext
{
  public:
    explicit OsMesaContext(const OsMesa &library) : library_(library)
    {
        const std::array attributes = {osmesa_format,
                                       osmesa_rgba,
                                       osmesa_depth_bits,
                                       0,
                                       osmesa_profile,
                                       osmesa_core_profile,
                                       osmesa_major,
                                       3,
                                       osmesa_minor,
                                       3,
                                       0};
        handle_ = library_.create(attributes.data(), nullptr);
        if (!handle_) throw GlError(origin() + " gives no core 3.3 context");
    }
    ~OsMesaContext() override { library_.destroy(handle_); }

    void enter() override
    {
        if (!library_.make_current(handle_, pixels_.data(), gl::type_unsigned_byte, edge, edge))
            throw GlLost("OpenGL: " + origin() + " does not make its context current");
    }
    void leave() override { library_.make_current(nullptr, nullptr, 0, 0, 0); }
    GlFunction function(const char *name) const override { return library_.address(name); }
    std::string origin() const override { return "OSMesa (" + library_.file.name() + ")"; }

  private:
    // OSMesa requires a picture buffer of its own, although path lengths are drawn to textures.
    static constexpr int edge = 8;

    OsMesa library_;
    Handle handle_ = nullptr;
    std::array<unsigned char, std::size_t{4} * edge * edge> pixels_{};
};

} // namespace

std::unique_ptr<GlContext> open_osmesa(const std::vector<std::string> &file_names)
{
    const OsMesa library(file_names);
    if (!library.file.is_open())
        throw GlError("OSMesa is missing (" + library.file.problem() + "; Debian: libosmesa6)");
    if (!library.is_whole())
        throw GlError("OSMesa (" + library.file.name() +
                      ") is older than Mesa 11.2: no OSMesaCreateContextAttribs");
    return std::make_unique<OsMesaContext>(library);
}

} // namespace crn
