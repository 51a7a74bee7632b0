// Paints solids into the slices of a CT. Every slice is sampled on planes across the body and on rows from
// the patient's right to the left; a solid is painted between the crossings of its surface with a row.
#pragma once
#include "tools/bake/mesh.hpp"
#include "tools/lab/ct/volume/volume.hpp"
#include <cstdint>

namespace crn::ct
{

inline constexpr int samples_along = 3, rows_per_pixel = 2, planes_per_slice = 2;

// The rows of samples in one plane across the body. Coordinates are the scene's: x to the left, z to the
// front.
struct SampleGrid {
    double left_mm = 0, front_mm = 0; // of the first sample of the first row; the rows go to the back
    double step_mm = 0, row_mm = 0;   // distances of samples and of rows
    int samples = 0, rows = 0;
};

using Samples = std::vector<std::int16_t>; // HU; rows one after the other

// A closed mesh that can be cut at any height.
class CutMesh
{
  public:
    // `low_mm` and `high_mm` limit the heights at which it is cut.
    CutMesh(bake::Mesh mesh, double low_mm, double high_mm);
    // Paints what lies inside the mesh at this height, moved by `shift_mm` to the left and to the front.
    void paint(Samples &samples, const SampleGrid &grid, double height_mm, const Eigen::Vector2d &shift_mm,
               std::int16_t hu) const;

  private:
    static constexpr double bin_mm = 2.0;
    bake::Mesh mesh_;
    double low_mm_;
    std::vector<std::vector<std::uint32_t>> bins_; // triangles that reach into each 2 mm of height
};

// Many balls, which make vessels too small for a mesh.
class CutBalls
{
  public:
    CutBalls(double low_mm, double high_mm);
    // Adds the tapered tube between two points.
    void add(const Eigen::Vector3d &from_mm, double from_radius_mm, const Eigen::Vector3d &to_mm,
             double to_radius_mm);
    // Paints only over samples that are below `below_hu`.
    void paint(Samples &samples, const SampleGrid &grid, double height_mm, const Eigen::Vector2d &shift_mm,
               std::int16_t hu, std::int16_t below_hu = INT16_MAX) const;

  private:
    static constexpr double bin_mm = 1.0;
    struct Ball {
        Eigen::Vector3f centre_mm;
        float radius_mm;
    };
    double low_mm_;
    std::vector<std::vector<Ball>> bins_;
};

} // namespace crn::ct
