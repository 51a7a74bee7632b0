// A CT volume holds Hounsfield units on a grid with spacing, origin and direction. There are three frames. In
// the coordinates of the voxels, whole numbers are the middles of voxels. Scanners and ITK use the LPS axes,
// in mm: +x towards the patient's left, +y towards the back, +z towards the head. The scene's coordinates,
// also in mm, have +x towards the left, +y towards the head, and +z towards the front. Only the next two
// functions convert between LPS and the scene's coordinates.
#pragma once
#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <string>
#include <vector>

namespace crn::ct
{

inline Eigen::Vector3d scene_from_lps(const Eigen::Vector3d &lps)
{
    return {lps.x(), lps.z(), -lps.y()};
}
inline Eigen::Vector3d lps_from_scene(const Eigen::Vector3d &scene)
{
    return {scene.x(), -scene.z(), scene.y()};
}

struct Volume {
    std::array<int, 3> size = {0, 0, 0};
    Eigen::Vector3d spacing_mm = Eigen::Vector3d::Ones();
    Eigen::Vector3d origin_mm = Eigen::Vector3d::Zero();     // LPS, middle of the first voxel
    Eigen::Matrix3d direction = Eigen::Matrix3d::Identity(); // columns: unit vectors of the axes in LPS
    std::vector<float> hu;                                   // first axis fastest
    std::string name;                                        // file or folder, for messages
    std::vector<std::string> notes;                          // repairs that were made while reading

    std::size_t count() const
    {
        return static_cast<std::size_t>(size[0]) * static_cast<std::size_t>(size[1]) *
               static_cast<std::size_t>(size[2]);
    }
    std::size_t at(int i, int j, int k) const
    {
        return (static_cast<std::size_t>(k) * static_cast<std::size_t>(size[1]) +
                static_cast<std::size_t>(j)) *
                   static_cast<std::size_t>(size[0]) +
               static_cast<std::size_t>(i);
    }
    bool holds(int i, int j, int k) const
    {
        return i >= 0 && j >= 0 && k >= 0 && i < size[0] && j < size[1] && k < size[2];
    }
    Eigen::Vector3d lps(const Eigen::Vector3d &voxel) const
    {
        return origin_mm + direction * spacing_mm.cwiseProduct(voxel);
    }
    Eigen::Vector3d scene(const Eigen::Vector3d &voxel) const { return scene_from_lps(lps(voxel)); }
    Eigen::Vector3d voxel(const Eigen::Vector3d &scene_mm) const
    {
        return (direction.transpose() * (lps_from_scene(scene_mm) - origin_mm)).cwiseQuotient(spacing_mm);
    }
    // The next two functions convert a displacement in voxels to the scene's millimetres, and back.
    Eigen::Matrix3d scene_per_voxel() const;
    // Interpolates between the nearest eight voxels; outside the volume, the function returns the value at
    // the border.
    double value(const Eigen::Vector3d &voxel) const;
    // Returns a volume on the same grid with all voxels set to `fill`, for use as a mask or as a map of
    // speeds.
    Volume like(float fill) const;
};

// Makes a left-handed grid right-handed by counting the voxels of the third axis from the other end. Every
// place keeps its value.
void make_right_handed(Volume &volume);

// Returns the voxels in the box [low, high) as a separate volume.
Volume cut_out(const Volume &volume, const std::array<int, 3> &low, const std::array<int, 3> &high);

} // namespace crn::ct
