// What a volume's file says of itself, read strictly and without ITK: ITK takes what it does not understand
// as 1 mm, believes every number of dimensions and reserves what is declared. Its reading is held against
// this one.
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
    std::uint64_t value_bytes = 0;  // of all voxels, unpacked
    bool is_deflated = false;       // by zlib, from head_bytes on
    double bytes_per_file_byte = 1; // at most, by the way it is packed
    std::uint64_t head_bytes = 0;   // before the values, where they are in the same file
    std::string data_file;          // empty: the same
    bool is_many_files = false;     // a list or pattern of files
};

// From the first bytes of a file. Throws Fault with the file, the field and what to do.
DeclaredVolume declared_nrrd(std::string_view head, const std::string &file);
DeclaredVolume declared_meta(std::string_view head, const std::string &file);
DeclaredVolume declared_nifti(std::string_view head, const std::string &file);

// The same of a file, its values held against its size.
DeclaredVolume declared_volume(const std::filesystem::path &file);

// Throws Fault when ITK understands another grid than the file declares.
void check_agreement(const DeclaredVolume &declared, const std::array<long, 3> &size,
                     const Eigen::Vector3d &spacing_mm, const std::string &file);

} // namespace crn::ct
