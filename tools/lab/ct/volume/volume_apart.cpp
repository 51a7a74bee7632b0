// A separate process reads each volume (host/base/guarded_read.hpp), because ITK trusts the headers of files.
// In addition, Debian's GDCM has assertions that end the process. If a file is damaged, only the child
// process that reads it ends, and the parent process reports the file's name.
#include "host/base/guarded_read.hpp"
#include "tools/lab/ct/volume/volume_io.hpp"
#include <algorithm>
#include <cstdint>
#include <cstring>

namespace crn::ct
{

namespace
{

namespace fs = std::filesystem;

// One byte of a compressed file may expand to a thousand bytes, so even a small file may need all the memory
// that is permitted for one file.
constexpr double growth = 1100;
constexpr std::uint64_t file_bytes_max = std::uint64_t{4} << 30, files_max = 4096, notes_max = 100;

// A number precedes every block of values: the count of its values, 0 after the last block, or
// `fault_follows` before the text of an error.
constexpr std::uint64_t fault_follows = UINT64_MAX;

struct Grid {
    std::array<std::int32_t, 3> size;
    std::array<double, 3> spacing_mm, origin_mm;
    std::array<double, 9> direction;
};

void send(Outbox &out, const fs::path &path)
{
    try {
        read_volume_here(
            path,
            [&](const Volume &head) {
                Grid grid{};
                std::copy(head.size.begin(), head.size.end(), grid.size.begin());
                std::copy_n(head.spacing_mm.data(), 3, grid.spacing_mm.begin());
                std::copy_n(head.origin_mm.data(), 3, grid.origin_mm.begin());
                std::copy_n(head.direction.data(), 9, grid.direction.begin());
                out.value(grid);
                out.value<std::uint64_t>(head.notes.size());
                for (const std::string &note : head.notes) out.text(note);
            },
            [&](const float *values, std::size_t count) {
                out.value<std::uint64_t>(count);
                out.bytes(values, count * sizeof(float));
            });
        out.value<std::uint64_t>(0);
    } catch (const Fault &fault) {
        if (!out.is_begun()) throw;
        out.value(fault_follows);
        out.text(fault.what());
    }
}

Volume receive(Inbox &in, const std::string &name)
{
    Volume volume;
    volume.name = name;
    const Grid grid = in.value<Grid>();
    std::copy(grid.size.begin(), grid.size.end(), volume.size.begin());
    std::copy_n(grid.spacing_mm.begin(), 3, volume.spacing_mm.data());
    std::copy_n(grid.origin_mm.begin(), 3, volume.origin_mm.data());
    std::copy_n(grid.direction.begin(), 9, volume.direction.data());
    check_grid({grid.size[0], grid.size[1], grid.size[2]}, volume.spacing_mm, volume.origin_mm,
               volume.direction, name);
    for (std::uint64_t notes = std::min<std::uint64_t>(in.value<std::uint64_t>(), notes_max); notes > 0;
         --notes)
        volume.notes.push_back(in.text());
    volume.hu.resize(volume.count());
    std::size_t done = 0;
    for (std::uint64_t block; (block = in.value<std::uint64_t>()) != 0; done += block) {
        if (block == fault_follows) throw Fault(in.text());
        if (block > volume.hu.size() - done)
            throw Fault(name + ": has more values than voxels: export it again");
        in.bytes(volume.hu.data() + done, block * sizeof(float));
    }
    if (done != volume.hu.size()) throw Fault(name + ": has fewer values than voxels: export it again");
    return volume;
}

// Returns the total size of all files that a volume consists of.
std::uint64_t bytes_of(const fs::path &path)
{
    std::error_code ignored;
    if (!fs::is_directory(path, ignored)) return regular_file_bytes(path.string(), file_bytes_max);
    std::uint64_t bytes = 0, files = 0;
    for (const fs::directory_entry &entry : fs::directory_iterator(path, ignored))
        if (entry.is_regular_file(ignored)) bytes += entry.file_size(ignored), ++files;
    if (files > files_max)
        throw Fault(path.string() + ": has " + std::to_string(files) + " files, over " +
                    std::to_string(files_max) + ": give the folder of one series");
    return bytes;
}

} // namespace

Volume read_volume(const fs::path &path)
{
    std::error_code ignored;
    if (!fs::exists(path, ignored)) throw Fault(path.string() + ": is not there: give a scan");
    Volume volume;
    try {
        read_apart(
            path.string(), read_limits(bytes_of(path), growth), [&](Outbox &out) { send(out, path); },
            [&](Inbox &in) { volume = receive(in, path.string()); });
    } catch (const GuardedReadError &error) {
        throw Fault(error.what());
    }
    check_values(volume);
    make_right_handed(volume);
    return volume;
}

} // namespace crn::ct
