// Reads and writes volumes with ITK's readers and writers, behind a header that does not include ITK.
#pragma once
#include "tools/lab/ct/volume/volume.hpp"
#include "tools/mesh/fault.hpp"
#include <cstdint>
#include <filesystem>
#include <functional>

namespace crn::ct
{

inline constexpr int volume_side_max = 2048;                           // voxels along an axis
inline constexpr std::size_t volume_voxels_max = std::size_t{1} << 28; // 1 GiB as the floats that we keep
inline constexpr double spacing_min_mm = 0.01, spacing_max_mm = 10.0;

// Reads a volume from a file .nrrd, .nhdr, .nii, .nii.gz, .mha or .mhd, or from a folder with one DICOM
// series. Throws Fault, whose message gives the cause, the position and the remedy. A left-handed grid is
// made right-handed (make_right_handed), and a note reports this change. A child process reads the file
// (volume_apart.cpp), so that a damaged file ends only the child process. Call this before threads start.
Volume read_volume(const std::filesystem::path &path);
// The child process delivers the grid first (as a volume without values), and then all values in order, in
// blocks. Throws Fault, possibly between blocks.
using TakeHead = std::function<void(const Volume &head)>;
using TakeValues = std::function<void(const float *values, std::size_t count)>;
void read_volume_here(const std::filesystem::path &path, const TakeHead &take_head,
                      const TakeValues &take_values);

// The extension of the file's name selects one of the formats that read_volume accepts; values are whole HU
// numbers. If the name has no extension, the function writes a folder with a DICOM series. Throws Fault.
void write_volume(const Volume &volume, const std::filesystem::path &path);

// Checks that sizes, spacing and axes of a volume are possible. The program applies this check to every
// volume that it reads. `what` begins the message.
void check_grid(const std::array<long, 3> &size, const Eigen::Vector3d &spacing_mm,
                const Eigen::Vector3d &origin_mm, const Eigen::Matrix3d &direction, const std::string &what);

// Checks only the sizes and the spacing of a volume, not its axes.
void check_plausible(const std::array<long, 3> &size, const Eigen::Vector3d &spacing_mm,
                     const std::string &what);
// Throws Fault if a value is not finite, if all values are equal, or if the values are outside the range of
// real scanners.
void check_values(const Volume &volume);

// The functions that read NIfTI and DICOM accept files that hold fewer values than they declare; this check
// refuses such files. Throws Fault.
void check_nifti_length(const std::string &file, std::uint64_t value_bytes);
void check_dicom_length(const std::filesystem::path &file, std::uint64_t pixel_bytes);

// Returns the transfer syntax of a DICOM file. Throws Fault if it is none that is read, or the file ends
// before it.
std::string dicom_syntax(const std::filesystem::path &file);

// Sorts the slices of a series by the position of the middle of their first pixel (LPS) along `normal`.
// Returns the order of the slices, from the lowest slice onwards, and the distance between neighbouring
// slices. Throws Fault if slices are missing, duplicated or unevenly spaced. `names` serve the message.
struct SliceOrder {
    std::vector<std::size_t> order;
    double distance_mm = 0;
};
SliceOrder order_slices(const std::vector<Eigen::Vector3d> &places_mm, const Eigen::Vector3d &normal,
                        const std::vector<std::string> &names, const std::string &series);

} // namespace crn::ct
