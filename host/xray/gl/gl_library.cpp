#include "host/xray/gl/gl_library.hpp"
#include <dlfcn.h>

namespace crn
{

GlLibraryFile::GlLibraryFile(const std::vector<std::string> &names)
{
    for (const std::string &name : names) {
        handle_ = dlopen(name.c_str(), RTLD_NOW | RTLD_LOCAL | RTLD_NODELETE);
        if (handle_) {
            name_ = name;
            return;
        }
        const char *text = dlerror();
        if (problem_.empty()) problem_ = text ? text : name + " does not open";
    }
}

void *GlLibraryFile::symbol(const char *name) const
{
    return handle_ ? dlsym(handle_, name) : nullptr;
}

} // namespace crn
