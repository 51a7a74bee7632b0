// An OpenGL 3.3 core context comes from OSMesa, from EGL without a surface, or from a window. The libraries
// of the first two are opened at run time by name.
#pragma once
#include "host/xray/gl/gl_functions.hpp"
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

namespace crn
{

// The message says what is missing or refused, and how to fix it.
struct GlError : std::runtime_error {
    using std::runtime_error::runtime_error;
};

// A context that existed has been lost; a new one may work.
struct GlLost : GlError {
    using GlError::GlError;
};

using GlFunction = void (*)();

class GlContext
{
  public:
    virtual ~GlContext() = default;
    // Makes the context current in the calling thread; only one thread may do so at a time. Throws GlLost.
    virtual void enter() = 0;
    // Releases the thread, so that a context of another library may follow.
    virtual void leave() = 0;
    // May be called while the context is current; returns nullptr when there is no function of this name.
    virtual GlFunction function(const char *name) const = 0;
    // Names the library, for example "OSMesa (libOSMesa.so.8)".
    virtual std::string origin() const = 0;
};

// Enters the context, and leaves it at the end of the block.
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

// Opens a context without a window: by OSMesa, or by EGL without a surface where OSMesa is missing (Mesa
// dropped it in 25.1). Throws GlError, which names what was tried and which packages to install.
std::unique_ptr<GlContext> open_headless(GlLibrary library = GlLibrary::any, const GlFileNames &names = {});

// Loads every function of the table by its name; throws GlError with the name of the first one missing. The
// context must be current.
GlFunctions load_functions(const GlContext &context);

struct GlDescription {
    std::string origin, renderer, version;
};
GlDescription describe(GlContext &context);

} // namespace crn
