// Chooses between the two kinds of OpenGL context that need no window, and contains the code that both kinds
// use.
#include "host/xray/gl/gl_context.hpp"
#include "host/xray/gl/gl_headless.hpp"
#include <cstring>

namespace crn
{

GlFunctions load_functions(const GlContext &context)
{
    GlFunctions functions;
    auto load = [&](auto &function, const char *name) {
        const GlFunction address = context.function(name);
        if (!address)
            throw GlError("OpenGL: " + context.origin() + " has no " + name + ": it is older than 3.3");
        static_assert(sizeof function == sizeof address);
        std::memcpy(&function, &address, sizeof function);
    };
#define CRN_GL_LOAD(result, name, arguments) load(functions.name, "gl" #name);
    CRN_GL_FUNCTIONS(CRN_GL_LOAD)
#undef CRN_GL_LOAD
    return functions;
}

GlDescription describe(GlContext &context)
{
    GlEntered entered(context);
    const GlFunctions functions = load_functions(context);
    auto text = [&](unsigned name) {
        const unsigned char *bytes = functions.GetString(name);
        return std::string(bytes ? reinterpret_cast<const char *>(bytes) : "unknown");
    };
    return {context.origin(), text(gl::renderer), text(gl::version)};
}

std::unique_ptr<GlContext> open_headless(GlLibrary library, const GlFileNames &names)
{
    std::string problems;
    if (library != GlLibrary::egl) {
        try {
            return open_osmesa(names.osmesa);
        } catch (const GlError &error) {
            problems = error.what();
        }
    }
    if (library != GlLibrary::osmesa) {
        try {
            return open_egl(names.egl);
        } catch (const GlError &error) {
            problems += (problems.empty() ? "" : "; ") + std::string(error.what());
        }
    }
    throw GlError("OpenGL: no context: " + problems + "; the picture needs none with --xray raster");
}

} // namespace crn
