// Draws pictures of volumes, with outlines and lines drawn over them. A picture shows a slice, or the
// brightest voxels along an axis.
#pragma once
#include "host/picture/canvas.hpp"
#include "tools/lab/ct/volume/volume.hpp"
#include <filesystem>
#include <string>

namespace crn::ct
{

inline constexpr Ink red{230, 40, 40}, green{60, 200, 80}, yellow{250, 210, 60}, blue{80, 140, 250};

// The view is along an axis of the grid. Axis 0 shows the side, axis 1 the front, and axis 2 the view from
// below that radiologists use (front up). In the views along axes 0 and 1, the patient's head is at the top
// of the picture.
class Picture
{
  public:
    // Shows the slice `index`; if index < 0, each pixel shows the brightest value over all slices.
    Picture(const Volume &volume, int axis, int index, double low_HU, double high_HU, double pixel_mm = 0.35);
    // Draws the outline of a surface in the displayed slice; the outline is where `level`, a volume on the
    // same grid, changes its sign. In a picture of all slices, the outline surrounds all pixels at which
    // `level` is negative (inside) in at least one slice.
    void outline(const Volume &level, Ink ink);
    void line(const std::vector<Eigen::Vector3d> &scene_mm, Ink ink, double width);
    void dot(const Eigen::Vector3d &scene_mm, Ink ink, double width);
    void caption(const std::string &text, int row = 0);
    // Throws OutputError.
    void save(const std::filesystem::path &file) const;

  private:
    SheetPoint place(const Eigen::Vector3d &voxel) const;
    Eigen::Vector3d voxel(int x, int y) const; // of the middle of a pixel, in the slice
    Volume grid_;                              // without values
    int axis_, index_, right_, down_;
    bool down_is_turned_;
    double pixel_mm_;
    int width_, height_;
    Sheet sheet_;
};

} // namespace crn::ct
