// Volumes from files and into files, by ITK's readers and writers, behind a header that knows nothing of
// them.
#pragma once
#include "tools/lab/ct/volume/volume.hpp"
#include "tools/mesh/fault.hpp"
#include <cstdint>
#include <filesystem>
#include <functional>

namespace crn::ct
{

inline constexpr int volume_side_max = 2048;                           // voxels along an axis
inline constexpr std::size_t volume_voxels_max = std::size_t{1} << 28; // 1 GiB as the floats that we hold
inline constexpr double spacing_min_mm = 0.01, spacing_max_mm = 10.0;

// A file .nrrd, .nhdr, .nii, .nii.gz, .mha or .mhd, or a folder with one DICOM series. Throws Fault: what,
// where, what to do. Left-handed grids are turned (make_right_handed), which is noted. It is read by a child
// process (volume_apart.cpp), so that damaged files end nothing but that: call it before threads start.
Volume read_volume(const std::filesystem::path &path);
// What the child does: the grid first (a volume without values), then all values in order, in blocks. Throws
// Fault, also in between.
using TakeHead = std::function<void(const Volume &head)>;
using TakeValues = std::function<void(const float *values, std::size_t count)>;
void read_volume_here(const std::filesystem::path &path, const TakeHead &take_head,
                      const TakeValues &take_values);

// By the name's ending as above, whole numbers of HU; a name without ending becomes a folder with a DICOM
// series. Throws Fault.
void write_volume(const Volume &volume, const std::filesystem::path &path);

// What reading checks, whoever says it: sizes, spacing and axes are possible. `what` begins the message.
void check_grid(const std::array<long, 3> &size, const Eigen::Vector3d &spacing_mm,
                const Eigen::Vector3d &origin_mm, const Eigen::Matrix3d &direction, const std::string &what);

// Its first part, which needs no axes: sizes and spacing.
void check_plausible(const std::array<long, 3> &size, const Eigen::Vector3d &spacing_mm,
                     const std::string &what);
// Values that are no numbers, all the same, or that no scanner writes.
void check_values(const Volume &volume);

// What the readers of NIfTI and DICOM pass over in silence: files that end before their values do. Throws
// Fault.
void check_nifti_length(const std::string &file, std::uint64_t value_bytes);
void check_dicom_length(const std::filesystem::path &file);

// Slices of a series by their places (middle of the first pixel, LPS) along `normal`: the order, from the
// lowest on, and the distance. Throws Fault where slices are missing, double or uneven. `names` are for the
// message.
struct SliceOrder {
    std::vector<std::size_t> order;
    double distance_mm = 0;
};
SliceOrder order_slices(const std::vector<Eigen::Vector3d> &places_mm, const Eigen::Vector3d &normal,
                        const std::vector<std::string> &names, const std::string &series);

} // namespace crn::ct
