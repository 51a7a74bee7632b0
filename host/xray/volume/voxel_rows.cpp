// Copies the voxels of a CT into rows that suit the processor's caches.
#include "host/xray/volume/voxel_rows.hpp"
#include <algorithm>
#include <cstring>
#include <new>
#include <sys/mman.h>

namespace crn
{
namespace
{

constexpr int line_voxels = 32;              // of a cache line of 64 bytes
constexpr std::size_t page_bytes = 2u << 20; // of a large page
constexpr int spare_voxels = 8;              // the last load of a row reads past its end

// Rows and planes begin at odd numbers of cache lines after each other. With a power of two, neighbouring
// rows would compete for the same places in the cache.
std::int32_t odd_lines(std::int32_t voxels)
{
    const std::int32_t lines = (voxels + line_voxels - 1) / line_voxels;
    return (lines | 1) * line_voxels;
}

} // namespace

VoxelRows::VoxelRows(const CtVolume &volume, bool is_turned)
{
    const auto [nx, ny, nz] = volume.size;
    const int row = is_turned ? nz : nx, rows = is_turned ? nx : nz;
    row_stride_ = odd_lines(row + spare_voxels);
    plane_stride_ = odd_lines(row_stride_ * rows);
    // The innermost loop loads three rows for each ray. For a ray in the last two rows or planes, it does not
    // use the third, which lies in the plane behind the last one.
    const std::size_t planes = static_cast<std::size_t>(ny) + 1;
    const std::size_t bytes = (2 * planes * plane_stride_ + page_bytes - 1) / page_bytes * page_bytes;
    voxels_ = static_cast<std::uint16_t *>(::operator new (bytes, std::align_val_t{page_bytes}));
#ifdef MADV_HUGEPAGE
    madvise(voxels_, bytes, MADV_HUGEPAGE); // where it is refused, small pages are slower but serve as well
#endif
    std::memset(voxels_, 0, bytes);
    for (int y = 0; y < ny; ++y) {
        std::uint16_t *plane = voxels_ + std::size_t{1} * y * plane_stride_;
        const std::uint16_t *from = volume.permille.data() + volume.index(0, y, 0);
        if (!is_turned) {
            for (int z = 0; z < nz; ++z)
                std::copy_n(from + std::size_t{1} * z * nx, nx, plane + std::size_t{1} * z * row_stride_);
            continue;
        }
        for (int x0 = 0; x0 < nx; x0 += line_voxels) // a few rows at a time stay in the cache
            for (int z = 0; z < nz; ++z)
                for (int x = x0; x < std::min(x0 + line_voxels, nx); ++x)
                    plane[std::size_t{1} * x * row_stride_ + z] = from[std::size_t{1} * z * nx + x];
    }
}

VoxelRows::~VoxelRows()
{
    ::operator delete (voxels_, std::align_val_t{page_bytes});
}

} // namespace crn
