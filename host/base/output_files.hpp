// Checks the paths of all output files before a program begins its work. An output file may be neither one of
// the program's inputs nor another output; it must be a regular file that can be written.
#pragma once
#include <stdexcept>
#include <string>
#include <vector>

namespace crn
{

// Describes a path and the command-line option or argument that contained it; an empty path means that there
// is no file.
struct NamedPath {
    std::string option; // "--record"
    std::string path;
};

// UsageError means that the command line contradicts itself; the program's exit code is then 2.
class UsageError : public std::runtime_error
{
  public:
    using std::runtime_error::runtime_error;
};

// Throws UsageError that names the two contradictory options, or OutputError for a file that cannot be
// written because its folder is missing, full or not writable. To test whether an output can be written, the
// function creates a temporary file beside it and removes this file at once.
void check_outputs(const std::vector<NamedPath> &inputs, const std::vector<NamedPath> &outputs);

// Checks an output folder in the same way as an output file; the program creates the folder later if it is
// missing.
void check_output_folder(const NamedPath &output);

} // namespace crn
