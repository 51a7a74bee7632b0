// Files a program is asked to write, looked at before anything is written: none of them may be one of its inputs, another
// output, or anything but a regular file. May include: nothing. Called by: command lines.
#pragma once
#include <stdexcept>
#include <string>
#include <vector>

namespace seld
{

// A path and the option or argument that named it; an empty path is none.
struct NamedPath {
    std::string option; // "--record"
    std::string path;
};

// A command line that asks for what cannot be meant: exit code 2.
class UsageError : public std::runtime_error
{
  public:
    using std::runtime_error::runtime_error;
};

// Throws UsageError that names both options.
void check_outputs(const std::vector<NamedPath> &inputs, const std::vector<NamedPath> &outputs);

} // namespace seld
