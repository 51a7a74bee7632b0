// Checks the conditions that a grid and a series of slices must fulfil before the program measures anything
// in them.
#include "host/base/format.hpp"
#include "tools/lab/ct/volume/volume_io.hpp"
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <fstream>
#include <memory>
#include <numeric>
#include <zlib.h>

namespace crn::ct
{

namespace
{

constexpr const char *implicit_syntax = "1.2.840.10008.1.2"; // the other syntaxes begin with it

// Returns the number of bytes that a gzip file holds when unpacked. After its last member, only zeros may
// follow, which pad files on tapes; zlib's gzread() ignores anything there in silence.
std::uint64_t unpacked_bytes(const std::string &file)
{
    std::ifstream stream(file, std::ios::binary);
    std::vector<unsigned char> in(1 << 16), out(1 << 16);
    z_stream zip{};
    if (inflateInit2(&zip, 15 + 16) != Z_OK) throw std::bad_alloc(); // accepts gzip alone
    const std::unique_ptr<z_stream, int (*)(z_stream *)> ended(&zip, inflateEnd);
    bool is_member_open = true;
    std::uint64_t unpacked = 0, place = 0;
    while (true) {
        if (zip.avail_in == 0) {
            stream.read(reinterpret_cast<char *>(in.data()), static_cast<std::streamsize>(in.size()));
            zip.next_in = in.data(), zip.avail_in = static_cast<unsigned>(stream.gcount());
        }
        if (zip.avail_in == 0) break;
        if (!is_member_open && *zip.next_in == 0) {
            ++zip.next_in, --zip.avail_in, ++place;
            continue;
        }
        if (!is_member_open) inflateReset(&zip);
        const unsigned before = zip.avail_in;
        zip.next_out = out.data(), zip.avail_out = static_cast<unsigned>(out.size());
        const int result = inflate(&zip, Z_NO_FLUSH);
        if (result != Z_OK && result != Z_STREAM_END)
            throw Fault(file + ": is damaged: from byte " + std::to_string(place) +
                        " on, it cannot be unpacked; copy or export it again");
        place += before - zip.avail_in;
        unpacked += out.size() - zip.avail_out;
        is_member_open = result == Z_OK;
    }
    if (is_member_open)
        throw Fault(file + ": is truncated: its compressed values end after " + std::to_string(unpacked) +
                    " bytes without a checksum; copy or export it again");
    return unpacked;
}

bool is_gzip(const std::string &file)
{
    std::ifstream stream(file, std::ios::binary);
    return stream.get() == 0x1f && stream.get() == 0x8b;
}

} // namespace

void check_plausible(const std::array<long, 3> &size, const Eigen::Vector3d &spacing_mm,
                     const std::string &what)
{
    double voxels = 1;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        if (size[axis] < 2 || size[axis] > volume_side_max)
            throw Fault(what + ": " + std::to_string(size[axis]) + " voxels along axis " +
                        std::to_string(axis + 1) + ": a scan has 2 to " + std::to_string(volume_side_max) +
                        "; export the whole volume as one");
        voxels *= static_cast<double>(size[axis]);
    }
    if (voxels > static_cast<double>(volume_voxels_max))
        throw Fault(what + ": " + formatted("%.0f", voxels * 1e-6) + " million voxels are more than the " +
                    formatted("%.0f", static_cast<double>(volume_voxels_max) * 1e-6) +
                    " million that are read: cut the volume to the body or the phantom");
    for (int axis = 0; axis < 3; ++axis)
        if (!(spacing_mm[axis] >= spacing_min_mm && spacing_mm[axis] <= spacing_max_mm))
            throw Fault(what + ": spacing " +
                        formatted("%g x %g x %g mm", spacing_mm[0], spacing_mm[1], spacing_mm[2]) +
                        " cannot be a CT scan's (" +
                        formatted("%g to %g mm", spacing_min_mm, spacing_max_mm) +
                        "): mend the header, or export it again in mm");
}

void check_grid(const std::array<long, 3> &size, const Eigen::Vector3d &spacing_mm,
                const Eigen::Vector3d &origin_mm, const Eigen::Matrix3d &direction, const std::string &what)
{
    check_plausible(size, spacing_mm, what);
    if (!origin_mm.allFinite() || origin_mm.cwiseAbs().maxCoeff() > 1e5)
        throw Fault(what + ": the origin is no place in mm: mend the header");
    if (!direction.allFinite() ||
        (direction.transpose() * direction - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff() > 1e-3)
        throw Fault(what + ": the axes are not at right angles and of length 1 (a tilted gantry, or a broken "
                           "header): resample the volume to right angles first");
}

void check_nifti_length(const std::string &file, std::uint64_t value_bytes)
{
    constexpr std::uint64_t head_bytes = 348;
    const std::uint64_t bytes = is_gzip(file) ? unpacked_bytes(file) : std::filesystem::file_size(file);
    if (bytes < head_bytes + value_bytes)
        throw Fault(file + ": is truncated: it ends after " + std::to_string(bytes) +
                    " bytes, its header promises " + std::to_string(head_bytes + value_bytes) +
                    " or more; copy or export it again");
}

std::string dicom_syntax(const std::filesystem::path &file)
{
    constexpr std::size_t magic_at = 128, group_at = 144;
    std::ifstream stream(file, std::ios::binary);
    if (!stream)
        throw Fault(file.string() + ": may not be read: allow it, or take the file out of the folder");
    std::string head(1 << 12, '\0');
    stream.read(head.data(), static_cast<std::streamsize>(head.size()));
    head.resize(static_cast<std::size_t>(std::max<std::streamsize>(stream.gcount(), 0)));
    if (head.size() < magic_at + 4 || head.compare(magic_at, 4, "DICM") != 0)
        return implicit_syntax; // an old file
    const std::size_t at = head.find(std::string{"\x02\x00\x10\x00UI", 6}, magic_at);
    if (at == std::string::npos || at + 8 > head.size() || head.size() < group_at)
        throw Fault(file.string() +
                    ": is truncated, or says no transfer syntax (0002,0010): export it again");
    const std::string text = head.substr(at + 8, static_cast<std::uint8_t>(head[at + 6]));
    const std::string syntax = text.substr(0, text.find_last_not_of(std::string(" \0", 2)) + 1);
    for (const char *known :
         {"", ".1", ".2", ".5", ".4.50", ".4.51", ".4.57", ".4.70", ".4.80", ".4.81", ".4.90", ".4.91"})
        if (syntax == std::string(implicit_syntax) + known) return syntax;
    throw Fault(file.string() +
                ": its transfer syntax (0002,0010) is not read: export it without compression, or convert it "
                "by 'dcmconv +te'");
}

// In a DICOM file, the length of the pixel data stands before the pixel data. The check handles files with
// explicit and with implicit value representations. Packed pixels have no length.
void check_dicom_length(const std::filesystem::path &file, std::uint64_t pixel_bytes)
{
    std::ifstream stream(file, std::ios::binary);
    const std::string bytes{std::istreambuf_iterator<char>(stream), {}};
    const bool is_big_endian = dicom_syntax(file) == std::string(implicit_syntax) + ".2";
    const std::string tag =
        is_big_endian ? std::string{"\x7f\xe0\x00\x10", 4} : std::string{"\xe0\x7f\x10\x00", 4};
    for (std::size_t at = bytes.find(tag); at != std::string::npos; at = bytes.find(tag, at + 1)) {
        const bool is_explicit =
            at + 12 <= bytes.size() && bytes[at + 4] == 'O' && (bytes[at + 5] == 'W' || bytes[at + 5] == 'B');
        const std::size_t begin = at + (is_explicit ? 12 : 8);
        if (begin > bytes.size()) break;
        std::uint32_t length = 0;
        for (std::size_t i = 0; i < 4; ++i)
            length =
                length << 8 | static_cast<std::uint8_t>(bytes[is_big_endian ? begin - 4 + i : begin - 1 - i]);
        if (is_explicit && length == 0xffffffffu) return;
        if (length >= pixel_bytes && begin + length <= bytes.size()) return;
    }
    throw Fault(file.string() + ": is truncated: it ends before its pixels do, or has fewer than it "
                                "declares; copy or export it again");
}

SliceOrder order_slices(const std::vector<Eigen::Vector3d> &places_mm, const Eigen::Vector3d &normal,
                        const std::vector<std::string> &names, const std::string &series)
{
    SliceOrder result;
    const std::size_t count = places_mm.size();
    if (count < 2)
        throw Fault(series + ": " + std::to_string(count) +
                    " slice: a series has at least 2; give the folder with all of its files");
    std::vector<double> heights(count);
    for (std::size_t i = 0; i < count; ++i) heights[i] = places_mm[i].dot(normal);
    result.order.resize(count);
    std::iota(result.order.begin(), result.order.end(), std::size_t{0});
    std::stable_sort(result.order.begin(), result.order.end(),
                     [&](std::size_t a, std::size_t b) { return heights[a] < heights[b]; });
    std::vector<double> steps;
    for (std::size_t i = 1; i < count; ++i)
        steps.push_back(heights[result.order[i]] - heights[result.order[i - 1]]);
    std::vector<double> sorted = steps;
    std::nth_element(sorted.begin(), sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 2),
                     sorted.end());
    const double step = sorted[sorted.size() / 2];
    for (std::size_t i = 0; i < steps.size(); ++i) {
        const std::string &before = names[result.order[i]], &after = names[result.order[i + 1]];
        if (steps[i] < 1e-3)
            throw Fault(
                series + ": " + before + " and " + after +
                " are at the same place: the series is there twice, or two series are mixed; keep one");
        if (std::abs(steps[i] - step) > std::max(0.02, 0.02 * step)) {
            const double missing = std::round(steps[i] / step) - 1;
            if (missing >= 1 && std::abs(steps[i] - (missing + 1) * step) < 0.1 * step)
                throw Fault(series + ": " +
                            formatted(missing > 1 ? "%.0f slices are missing between "
                                                  : "a slice is missing between ",
                                      missing) +
                            before + " and " + after +
                            formatted(" (%.3f mm apart, others %.3f mm): export the whole series again",
                                      steps[i], step));
            throw Fault(
                series + ": uneven slices: " + before + " and " + after +
                formatted(" are %.3f mm apart, others %.3f mm: reconstruct or resample the series evenly",
                          steps[i], step));
        }
        // If slices are displaced sideways relative to each other, all shapes in the volume are sheared.
        const Eigen::Vector3d shift = places_mm[result.order[i + 1]] - places_mm[result.order[i]];
        if ((shift - shift.dot(normal) * normal).norm() > 0.05)
            throw Fault(series + ": " + after + " is shifted sideways against " + before +
                        ": a tilted gantry or two series; resample to right angles");
    }
    result.distance_mm =
        (heights[result.order.back()] - heights[result.order.front()]) / static_cast<double>(count - 1);
    return result;
}

} // namespace crn::ct
