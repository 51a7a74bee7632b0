// Draws a vessel as glass, seen from the front, with a rod of spheres in it. A sphere is green where the rod
// touches the wall, and red elsewhere.
#pragma once
#include "tools/lab/figures/canvas.hpp"
#include "tools/lab/figures/compression.hpp"

namespace vcsim3
{

class VesselPicture
{
  public:
    // Samples the lumen once, at `pixels_per_mm`.
    VesselPicture(const Vessel &vessel, double pixels_per_mm);

    int width() const { return width_; }
    int height() const { return height_; }
    // Returns the place of a patient's point in the picture, counted from the picture's top left corner.
    Eigen::Vector2d place_of(const Vector &position_m) const;

    // Draws the vessel with its top left corner at this place, and the rod's nodes as spheres. Far spheres
    // are drawn first, and touching ones last.
    void draw(Canvas &canvas, double left, double top, const std::vector<ShapeNode> &shape,
              double free_radius_mm, double touching_radius_mm) const;

  private:
    double pixels_per_mm_, left_mm_,
        top_mm_; // patient x and y of the corner; x grows to the right, y upwards
    int width_, height_;
    std::vector<double> glass_; // share of wall colour per pixel
};

} // namespace vcsim3
