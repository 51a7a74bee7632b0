#include "host/picture/path_choice.hpp"
#include "host/base/terminal.hpp"
#include <cstdio>

namespace crn
{
namespace
{

GlOpener opener_of(const std::string &choice, const GlOpener &window_context)
{
    if (choice == "opengl" && window_context) return window_context;
    const GlLibrary library = choice == "opengl-osmesa" ? GlLibrary::osmesa
                              : choice == "opengl-egl"  ? GlLibrary::egl
                                                        : GlLibrary::any;
    return [library] { return open_headless(library); };
}

bool print_library(const char *name, GlLibrary library)
{
    try {
        const std::unique_ptr<GlContext> context = open_headless(library);
        const GlDescription found = describe(*context);
        say(stdout, "%-14s%s, OpenGL %s, by %s\n", name, found.renderer.c_str(), found.version.c_str(),
            found.origin.c_str());
        return true;
    } catch (const GlError &error) {
        say(stdout, "%-14s%s\n", name, error.what());
        return false;
    }
}

} // namespace

BodyPathsMaker paths_maker(const std::string &choice, const GlOpener &window_context)
{
    if (choice == "raster") return {};
    return [open = opener_of(choice, window_context)](const BodyMeshes &meshes, int threads) {
        auto paths = std::make_unique<GlPaths>(meshes, open, threads);
        const GlDescription &found = paths->description();
        say(stderr, "X-ray by OpenGL %s on %s, by %s\n", found.version.c_str(), found.renderer.c_str(),
            found.origin.c_str());
        return paths;
    };
}

bool print_opengl()
{
    const bool has_osmesa = print_library("opengl-osmesa", GlLibrary::osmesa);
    const bool has_egl = print_library("opengl-egl", GlLibrary::egl);
    return has_osmesa || has_egl;
}

} // namespace crn
