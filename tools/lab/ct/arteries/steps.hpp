// Remembers which steps of `ct patient` are done, so that a second run repeats only what changed.
#pragma once
#include "tools/lab/ct/volume/volume.hpp"
#include <filesystem>
#include <nlohmann/json.hpp>

namespace crn::ct
{

// The file steps.json holds, for each step, the checksum of its inputs.
class Steps
{
  public:
    explicit Steps(const std::filesystem::path &folder);
    // Whether the step was made from these inputs and its files are there. A step that must be made again is
    // taken out of the file with all later steps, so the file tells what is done while a command runs.
    bool is_done(const std::string &step, const std::string &inputs,
                 const std::vector<std::filesystem::path> &files);
    // The same question, which changes nothing.
    bool has(const std::string &step, const std::string &inputs,
             const std::vector<std::filesystem::path> &files) const;
    void finish(const std::string &step, const std::string &inputs);

  private:
    void write() const;

    std::filesystem::path file_;
    nlohmann::json done_ = nlohmann::json::object();
};

std::string checksum(const void *bytes, std::size_t count);
std::string checksum(const Volume &volume);
std::string checksum(const std::filesystem::path &file);

} // namespace crn::ct
