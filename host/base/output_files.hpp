// Files a program is asked to write, looked at before anything is written and before the work that they are
// for: none of them may be one of its inputs, another output, or anything but a regular file, and each can be
// written.
#pragma once
#include <stdexcept>
#include <string>
#include <vector>

namespace crn
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

// Throws UsageError that names both options, or OutputError for a name under which nothing can be written: a
// folder that is missing or full or not ours to write to. For that a file is made beside each name and
// removed at once.
void check_outputs(const std::vector<NamedPath> &inputs, const std::vector<NamedPath> &outputs);

// The same of a folder that will be made where it is missing.
void check_output_folder(const NamedPath &output);

} // namespace crn
