// Checks the files that a program is to write, before it writes any and before the work for them. None of
// them may be one of its inputs, another output, or anything but a regular file, and each must be writable.
#pragma once
#include <stdexcept>
#include <string>
#include <vector>

namespace crn
{

// A path and the option or argument that named it; an empty path means none.
struct NamedPath {
    std::string option; // "--record"
    std::string path;
};

// A command line that makes no sense: exit code 2.
class UsageError : public std::runtime_error
{
  public:
    using std::runtime_error::runtime_error;
};

// Throws UsageError that names both options, or OutputError for a name that cannot be written: its folder is
// missing, full or not writable for us. To find out, it creates a file beside each name and removes it at
// once.
void check_outputs(const std::vector<NamedPath> &inputs, const std::vector<NamedPath> &outputs);

// Checks a folder likewise; the folder will be made if it is missing.
void check_output_folder(const NamedPath &output);

} // namespace crn
