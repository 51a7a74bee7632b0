// A GlLibraryFile is a shared library that is opened at run time. The library stays loaded until the process
// ends, because Mesa keeps threads and thread-local data, so that unloading the library is not safe. Only
// files in the same folder may include this header.
#pragma once
#include <cstring>
#include <string>
#include <vector>

namespace crn
{

class GlLibraryFile
{
  public:
    // Opens the first of the libraries `names` that the system can load. If none of the libraries can be
    // loaded, is_open() returns false and problem() returns the cause.
    explicit GlLibraryFile(const std::vector<std::string> &names);

    bool is_open() const { return handle_ != nullptr; }
    const std::string &name() const { return name_; }
    const std::string &problem() const { return problem_; }
    // Sets `function` to nullptr if the library has no function with this name.
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
