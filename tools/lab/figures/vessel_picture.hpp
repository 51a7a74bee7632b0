// Draws a vessel as if it were made of glass, seen from the front, and a rod of spheres in it. A sphere is
// green where the rod touches the wall; all other spheres are red.
#pragma once
#include "tools/lab/figures/canvas.hpp"
#include "tools/lab/figures/compression.hpp"

namespace vcsim3
{

class VesselPicture
{
  public:
    // Samples the lumen once and stores the result as a picture of `pixels_per_mm`.
    VesselPicture(const Vessel &vessel, double pixels_per_mm);

    int width() const { return width_; }
    int height() const { return height_; }
    // Converts a point of the patient to pixels of the picture, counted from the picture's top left corner.
    Eigen::Vector2d place_of(const Vector &position_m) const;

    // Draws the vessel with its top left corner at the given position of the canvas, and draws the rod's
    // nodes as spheres. Distant spheres are drawn first, and spheres that touch the wall are drawn last.
    void draw(Canvas &canvas, double left, double top, const std::vector<ShapeNode> &shape,
              double free_radius_mm, double touching_radius_mm) const;

  private:
    double pixels_per_mm_, left_mm_,
        top_mm_; // patient x and y of the corner; x grows to the right, y upwards
    int width_, height_;
    std::vector<double> glass_; // share of wall colour per pixel
};

} // namespace vcsim3
