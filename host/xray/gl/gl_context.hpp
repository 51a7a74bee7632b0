// Provides an OpenGL 3.3 core context, which comes from OSMesa, from EGL without a surface, or from a window.
// The libraries OSMesa and EGL are opened by their names at run time.
#pragma once
#include "host/xray/gl/gl_functions.hpp"
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

namespace crn
{

// GlError reports that OpenGL cannot be used; its message names what is missing or was refused, and gives the
// remedy.
struct GlError : std::runtime_error {
    using std::runtime_error::runtime_error;
};

// GlLost reports that an existing OpenGL context was lost; a new context may work.
struct GlLost : GlError {
    using GlError::GlError;
};

using GlFunction = void (*)();

class GlContext
{
  public:
    virtual ~GlContext() = default;
    // Makes the OpenGL context current in the calling thread; the context may be current in only one thread
    // at a time. Throws GlLost.
    virtual void enter() = 0;
    // Releases the OpenGL context from the thread, so that a context of another library may be current there.
    virtual void leave() = 0;
    // Returns the address of an OpenGL function, or nullptr if there is no function with this name; the
    // context must be current.
    virtual GlFunction function(const char *name) const = 0;
    // Returns the name of the library that provides the context, for example "OSMesa (libOSMesa.so.8)".
    virtual std::string origin() const = 0;
};

// Makes an OpenGL context current in this thread, and releases it at the end of the block.
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

// The program tries to open a library under these file names, in the order of each list.
struct GlFileNames {
    std::vector<std::string> osmesa = {"libOSMesa.so.8", "libOSMesa.so.6", "libOSMesa.so"};
    std::vector<std::string> egl = {"libEGL.so.1", "libEGL.so"};
};

// Opens a context that needs no window, from OSMesa or, where that is missing, from EGL without a surface
// (Mesa removed OSMesa in 25.1). Throws GlError, whose message states what was tried and which packages to
// install.
std::unique_ptr<GlContext> open_headless(GlLibrary library = GlLibrary::any, const GlFileNames &names = {});

// Loads every OpenGL function of the table by its name; throws GlError with the name of the first missing
// function. The context must be current.
GlFunctions load_functions(const GlContext &context);

struct GlDescription {
    std::string origin, renderer, version;
};
GlDescription describe(GlContext &context);

} // namespace crn
