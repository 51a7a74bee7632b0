// Where an OpenGL 3.3 core context comes from: OSMesa or EGL without a surface, each opened at run time by
// its library's name, or whatever a window gives.
#pragma once
#include "host/xray/gl/gl_functions.hpp"
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

namespace crn
{

// Says what is missing or refused, and what to do about it.
struct GlError : std::runtime_error {
    using std::runtime_error::runtime_error;
};

// A context that was there and is no longer: a new one may do.
struct GlLost : GlError {
    using GlError::GlError;
};

using GlFunction = void (*)();

class GlContext
{
  public:
    virtual ~GlContext() = default;
    // Makes it current in the calling thread; one thread at a time. Throws GlLost.
    virtual void enter() = 0;
    // Gives the thread back, so that a context of another library may follow.
    virtual void leave() = 0;
    // While it is current; nullptr when there is none of this name.
    virtual GlFunction function(const char *name) const = 0;
    // "OSMesa (libOSMesa.so.8)"
    virtual std::string origin() const = 0;
};

// Enters, and leaves at the end of the block.
class GlEntered
{
  public:
    explicit GlEntered(GlContext &context) : context_(context) { context_.enter(); }
    ~GlEntered() { context_.leave(); }
    GlEntered(const GlEntered &) = delete;
    GlEntered &operator=(const GlEntered &) = delete;

  private:
    GlContext &context_;
};

enum class GlLibrary { any, osmesa, egl };

// File names that are tried in turn.
struct GlFileNames {
    std::vector<std::string> osmesa = {"libOSMesa.so.8", "libOSMesa.so.6", "libOSMesa.so"};
    std::vector<std::string> egl = {"libEGL.so.1", "libEGL.so"};
};

// A context without window: of OSMesa, or where that is missing (Mesa dropped it in 25.1) of EGL without a
// surface. Throws GlError, which names what was tried and the packages to install.
std::unique_ptr<GlContext> open_headless(GlLibrary library = GlLibrary::any, const GlFileNames &names = {});

// Every function of the table by its name; throws GlError naming the first that is missing. The context is
// current.
GlFunctions load_functions(const GlContext &context);

struct GlDescription {
    std::string origin, renderer, version;
};
GlDescription describe(GlContext &context);

} // namespace crn
