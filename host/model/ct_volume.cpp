// The file of a CT volume (docs/own_ct.md, "The file X.ct"): a head of 80 bytes, and then the voxels; all
// numbers are little-endian.
//
//    0  "CRNCT001"                  44 ... 67  centre of the first voxel, mm: three float64
//    8  sizes: three uint32         68         CRC-32 of the voxels
//   20  spacing, mm: three float64  72         CRC-32 of bytes 0 ... 71;  76  0
#include "host/model/ct_volume.hpp"
#include "host/base/format.hpp"
#include "host/base/pending_file.hpp"
#include "shared/wire/wire_frame.h"
#include <algorithm>
#include <bit>
#include <cerrno>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <memory>

namespace crn
{
namespace
{

constexpr std::size_t head_bytes = 80;
constexpr char magic[] = "CRNCT001";
static_assert(std::endian::native == std::endian::little, "the voxels are stored as they are in memory");

std::uint32_t checksum(const void *bytes, std::size_t count)
{
    return crn_wire_crc32(0, static_cast<const std::uint8_t *>(bytes), count);
}

std::array<char, head_bytes> head_of(const CtVolume &volume)
{
    std::array<char, head_bytes> head{};
    std::memcpy(head.data(), magic, 8);
    for (int axis = 0; axis < 3; ++axis) {
        const auto size = static_cast<std::uint32_t>(volume.size[axis]);
        std::memcpy(head.data() + 8 + 4 * axis, &size, 4);
        std::memcpy(head.data() + 20 + 8 * axis, &volume.spacing_mm[axis], 8);
        std::memcpy(head.data() + 44 + 8 * axis, &volume.first_mm[axis], 8);
    }
    const std::uint32_t voxels = checksum(volume.permille.data(), 2 * volume.permille.size());
    std::memcpy(head.data() + 68, &voxels, 4);
    const std::uint32_t own = checksum(head.data(), 72);
    std::memcpy(head.data() + 72, &own, 4);
    return head;
}

bool read_head(const std::array<char, head_bytes> &head, CtVolume &volume)
{
    std::uint32_t own = 0;
    std::memcpy(&own, head.data() + 72, 4);
    if (std::memcmp(head.data(), magic, 8) != 0 || own != checksum(head.data(), 72)) return false;
    for (int axis = 0; axis < 3; ++axis) {
        std::uint32_t size = 0;
        std::memcpy(&size, head.data() + 8 + 4 * axis, 4);
        volume.size[axis] = static_cast<int>(std::min<std::uint32_t>(size, ct_size_max + 1));
        std::memcpy(&volume.spacing_mm[axis], head.data() + 20 + 8 * axis, 8);
        std::memcpy(&volume.first_mm[axis], head.data() + 44 + 8 * axis, 8);
    }
    return true;
}

bool check_geometry(const CtVolume &volume, std::string &error)
{
    for (int axis = 0; axis < 3; ++axis) {
        const char name[] = {"xyz"[axis], '\0'};
        const double spacing = volume.spacing_mm[axis], last = spacing * volume.size[axis];
        if (volume.size[axis] < 2 || volume.size[axis] > ct_size_max)
            error =
                formatted("%d voxels along %s; 2 to %d are possible", volume.size[axis], name, ct_size_max);
        else if (!(spacing >= 0.01 && spacing <= 10.0))
            error = formatted("voxels of %g mm along %s; 0.01 to 10 are possible", spacing, name);
        else if (!(std::fabs(volume.first_mm[axis]) + last <= 2000.0))
            error = formatted("reaches farther than 2 m from the origin along %s", name);
        else
            continue;
        return false;
    }
    if (volume.count() <= ct_voxels_max) return true;
    error = formatted("%zu voxels, more than %zu; halve its resolution", volume.count(), ct_voxels_max);
    return false;
}

} // namespace

bool check_ct_volume(const CtVolume &volume, std::string &error)
{
    if (!check_geometry(volume, error)) return false;
    if (volume.permille.size() != volume.count()) {
        error = formatted("%zu voxels, but its sizes need %zu", volume.permille.size(), volume.count());
        return false;
    }
    const auto is_beyond = [](std::uint16_t value) { return value > ct_permille_max; };
    if (std::none_of(volume.permille.begin(), volume.permille.end(), is_beyond)) return true;
    error = formatted("a voxel is brighter than %d HU", ct_permille_max - 1000);
    return false;
}

bool read_ct_volume(const std::string &path, CtVolume &volume, std::string &error)
{
    const std::string remedy = "; make it again (docs/own_ct.md)";
    std::unique_ptr<std::FILE, int (*)(std::FILE *)> file(std::fopen(path.c_str(), "rb"), std::fclose);
    std::array<char, head_bytes> head;
    CtVolume read;
    if (!file) {
        error = path + ": cannot be opened: " + std::strerror(errno);
        return false;
    }
    std::string fault;
    if (std::fread(head.data(), 1, head_bytes, file.get()) != head_bytes || !read_head(head, read)) {
        error = path + ": is not a CT of this program, or its head is damaged" + remedy;
        return false;
    }
    std::error_code none;
    const bool is_whole = check_geometry(read, fault) &&
                          std::filesystem::file_size(path, none) == head_bytes + 2 * read.count();
    if (fault.empty() && !is_whole) fault = "the file is not as long as its head states";
    if (fault.empty()) {
        read.permille.resize(read.count());
        std::uint32_t voxels = 0;
        std::memcpy(&voxels, head.data() + 68, 4);
        if (std::fread(read.permille.data(), 2, read.count(), file.get()) != read.count() ||
            checksum(read.permille.data(), 2 * read.count()) != voxels)
            fault = "its voxels are damaged";
    }
    if (!fault.empty() || !check_ct_volume(read, fault)) {
        error = path + ": " + fault + remedy;
        return false;
    }
    volume = std::move(read);
    return true;
}

void write_ct_volume(const std::string &path, const CtVolume &volume)
{
    const std::array<char, head_bytes> head = head_of(volume);
    PendingFile file(path);
    file.write(head.data(), head.size());
    file.write(volume.permille.data(), 2 * volume.permille.size());
    file.commit();
}

std::string ct_beside(const std::string &path)
{
    if (path.empty()) return "";
    const std::filesystem::path ct = std::filesystem::path(path).replace_extension(".ct");
    std::error_code ignored;
    return std::filesystem::is_regular_file(ct, ignored) ? ct.string() : "";
}

} // namespace crn
