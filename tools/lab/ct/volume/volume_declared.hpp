// Reads, strictly and without ITK, the sizes, the spacing and the amount of data that a volume file declares.
// ITK replaces a spacing that it does not understand by 1 mm, trusts any number of dimensions, and reserves
// any amount of memory that a file declares. The program therefore compares the data that ITK reads with the
// result of the strict reading.
#pragma once
#include "tools/mesh/fault.hpp"
#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>

namespace crn::ct
{

struct DeclaredVolume {
    std::array<long, 3> size = {0, 0, 0};
    Eigen::Vector3d spacing_mm = Eigen::Vector3d::Zero();
    std::uint64_t value_bytes = 0;  // size of all voxels, unpacked
    bool is_deflated = false;       // by zlib, from head_bytes on
    std::uint64_t packed_bytes = 0; // stated size of the deflated values; 0: not stated
    double bytes_per_file_byte = 1; // upper limit, given by the kind of packing
    std::uint64_t head_bytes = 0;   // bytes before the values, where they are in the same file
    std::string data_file;          // empty: the same file
    bool is_many_files = false;     // a list or pattern of files
    bool has_place = true;          // false: a NIfTI file without position and direction
};

// Each of the three functions below receives only the first bytes of a file. Throws Fault, whose message
// names the file, the field and the remedy.
DeclaredVolume declared_nrrd(std::string_view head, const std::string &file);
DeclaredVolume declared_meta(std::string_view head, const std::string &file);
DeclaredVolume declared_nifti(std::string_view head, const std::string &file);

// Reads the header of a file, and compares the declared values with the size of the file.
DeclaredVolume declared_volume(const std::filesystem::path &file);

// Throws Fault when the grid that ITK reports differs from the grid that the file declares.
void check_agreement(const DeclaredVolume &declared, const std::array<long, 3> &size,
                     const Eigen::Vector3d &spacing_mm, const std::string &file);

} // namespace crn::ct
