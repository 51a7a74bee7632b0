// A GlLibraryFile is a shared library opened at run time. It stays loaded for the life of the process: Mesa
// keeps threads and thread-local data, so that unloading it is not safe. It is private to this folder.
#pragma once
#include <cstring>
#include <string>
#include <vector>

namespace crn
{

class GlLibraryFile
{
  public:
    // Opens the first of `names` that can be opened; if none can, is_open() is false and problem() gives the
    // cause.
    explicit GlLibraryFile(const std::vector<std::string> &names);

    bool is_open() const { return handle_ != nullptr; }
    const std::string &name() const { return name_; }
    const std::string &problem() const { return problem_; }
    // Sets `function` to nullptr when the library has no function of this name.
    template <class Function> void find(Function &function, const char *name) const
    {
        void *address = symbol(name);
        static_assert(sizeof function == sizeof address);
        std::memcpy(&function, &address, sizeof function);
    }

  private:
    void *symbol(const char *name) const;

    void *handle_ = nullptr;
    std::string name_, problem_;
};

} // namespace crn
