#include "tools/lab/ct/arteries/steps.hpp"
#include "host/base/format.hpp"
#include "host/base/pending_file.hpp"
#include "host/base/text.hpp"
#include "shared/wire/wire_frame.h"
#include <algorithm>

namespace crn::ct
{

namespace
{

const std::string order[] = {"scan", "arteries", "picture", "lumen", "tree", "scene"};

} // namespace

Steps::Steps(const std::filesystem::path &folder) : file_(folder / "steps.json")
{
    try {
        done_ = nlohmann::json::parse(read_text_file(file_.string()), nullptr, false);
    } catch (const FileError &) { // the first run
    }
    if (!done_.is_object()) done_ = nlohmann::json::object();
}

bool Steps::has(const std::string &step, const std::string &inputs,
                const std::vector<std::filesystem::path> &files) const
{
    return done_.contains(step) && done_[step] == inputs &&
           std::all_of(files.begin(), files.end(),
                       [](const std::filesystem::path &file) { return std::filesystem::exists(file); });
}

bool Steps::is_done(const std::string &step, const std::string &inputs,
                    const std::vector<std::filesystem::path> &files)
{
    if (has(step, inputs, files)) return true;
    const auto first = std::find(std::begin(order), std::end(order), step);
    for (auto later = first; later != std::end(order); ++later) done_.erase(*later);
    write();
    return false;
}

void Steps::finish(const std::string &step, const std::string &inputs)
{
    done_[step] = inputs;
    write();
}

void Steps::write() const
{
    write_whole_file(file_.string(), done_.dump(2) + "\n");
}

std::string checksum(const void *bytes, std::size_t count)
{
    return formatted(
        "%08x", static_cast<unsigned>(crn_wire_crc32(0, static_cast<const std::uint8_t *>(bytes), count)));
}

std::string checksum(const Volume &volume)
{
    return checksum(volume.hu.data(), volume.hu.size() * sizeof(float)) +
           formatted(" %.6g %.6g %.6g %.6g %.6g %.6g", volume.spacing_mm[0], volume.spacing_mm[1],
                     volume.spacing_mm[2], volume.origin_mm[0], volume.origin_mm[1], volume.origin_mm[2]);
}

std::string checksum(const std::filesystem::path &file)
{
    const std::vector<unsigned char> bytes = read_binary_file(file.string());
    return checksum(bytes.data(), bytes.size());
}

} // namespace crn::ct
