#include "host/base/output_files.hpp"
#include "host/base/pending_file.hpp"
#include <cerrno>
#include <filesystem>

namespace crn
{

namespace
{

namespace fs = std::filesystem;

// Returns true if two paths name the same file. The two paths may differ in spelling, be links, or name a
// file that does not exist yet.
bool is_same_file(const std::string &a, const std::string &b)
{
    std::error_code failed;
    if (fs::exists(a, failed) && fs::exists(b, failed)) return fs::equivalent(a, b, failed);
    const fs::path whole_a = fs::weakly_canonical(fs::absolute(a, failed), failed);
    const fs::path whole_b = fs::weakly_canonical(fs::absolute(b, failed), failed);
    return !whole_a.empty() && whole_a == whole_b;
}

void check_kind(const NamedPath &output)
{
    std::error_code failed;
    const fs::file_status status = fs::status(output.path, failed);
    if (!fs::exists(status) || fs::is_regular_file(status)) return;
    throw UsageError(output.option + " " + output.path + " is " +
                     (fs::is_directory(status) ? "a folder" : "a device or pipe") +
                     ": name a regular file to write");
}

} // namespace

void check_outputs(const std::vector<NamedPath> &inputs, const std::vector<NamedPath> &outputs)
{
    for (std::size_t i = 0; i < outputs.size(); i++) {
        const NamedPath &output = outputs[i];
        if (output.path.empty()) continue;
        check_kind(output);
        for (const NamedPath &input : inputs) {
            if (!input.path.empty() && is_same_file(input.path, output.path)) {
                throw UsageError(output.option + " " + output.path + " would overwrite what " + input.option +
                                 " reads: name another file");
            }
        }
        for (std::size_t k = 0; k < i; k++) {
            if (!outputs[k].path.empty() && is_same_file(outputs[k].path, output.path)) {
                throw UsageError(output.option + " and " + outputs[k].option + " would both write " +
                                 output.path + ": name two files");
            }
        }
    }
    for (const NamedPath &output : outputs)
        if (!output.path.empty()) probe_output(output.path);
}

void check_output_folder(const NamedPath &output)
{
    if (output.path.empty()) return;
    std::error_code failed;
    fs::path folder = fs::absolute(output.path, failed).lexically_normal();
    if (fs::exists(folder, failed) && !fs::is_directory(folder, failed))
        throw UsageError(output.option + " " + output.path + " is not a folder: name a folder, new or old");
    while (!fs::exists(folder, failed) && folder.has_relative_path()) folder = folder.parent_path();
    if (!fs::is_directory(folder, failed)) throw OutputError(output.path, ENOTDIR);
    try {
        probe_output((folder / ".cournand-probe").string());
    } catch (const OutputError &error) {
        throw OutputError(output.option + " " + output.path + ": " + error.what());
    }
}

} // namespace crn
