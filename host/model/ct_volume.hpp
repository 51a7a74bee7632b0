// A CT of the patient in the patient frame (docs/frames.md), from which X-ray pictures are computed by ray
// casting (host/xray/volume). A scene `X.scene` may have a CT in the file `X.ct` beside its bodies.
#pragma once
#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <string>
#include <vector>

namespace crn
{

// A voxel holds its attenuation in thousandths of the attenuation of water, that is HU + 1000. Voxels of air
// hold 0.
inline constexpr int ct_permille_max = 8191; // +7191 HU: metal is cut off here
inline constexpr int ct_size_max = 1024;     // voxels along one axis
inline constexpr std::size_t ct_voxels_max = std::size_t{1} << 29;

struct CtVolume {
    std::array<int, 3> size = {0, 0, 0};                  // voxels along x (left), y (head) and z (front)
    Eigen::Vector3d spacing_mm = Eigen::Vector3d::Ones(); // of the voxels' centres
    Eigen::Vector3d first_mm = Eigen::Vector3d::Zero();   // centre of voxel (0, 0, 0)
    std::vector<std::uint16_t> permille;                  // [(y * size.z + z) * size.x + x]

    std::size_t count() const { return std::size_t{1} * size[0] * size[1] * size[2]; }
    std::size_t index(int x, int y, int z) const { return (std::size_t{1} * y * size[2] + z) * size[0] + x; }
};

// Checks sizes, spacing and position of a volume, and that no voxel is brighter than ct_permille_max.
bool check_ct_volume(const CtVolume &volume, std::string &error);

// Reads the file that write_ct_volume wrote. On failure the function returns false, `error` names the file,
// the cause and the remedy, and `volume` does not change.
bool read_ct_volume(const std::string &path, CtVolume &volume, std::string &error);

// Throws OutputError.
void write_ct_volume(const std::string &path, const CtVolume &volume);

// Returns the path of the CT that belongs to a body file or scene: the same name with the ending .ct. Returns
// "" if there is no such file.
std::string ct_beside(const std::string &path);

} // namespace crn
