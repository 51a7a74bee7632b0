// A vessel seen from the front as glass, with a rod of spheres in it: green where the rod touches the wall,
// red where it is free.
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
    // Returns the place of a patient's point in the picture, from its top left corner.
    Eigen::Vector2d place_of(const Vector &position_m) const;

    // Draws the vessel with its top left corner at this place, and the rod's nodes as spheres: far ones
    // first, touching ones on top.
    void draw(Canvas &canvas, double left, double top, const std::vector<ShapeNode> &shape,
              double free_radius_mm, double touching_radius_mm) const;

  private:
    double pixels_per_mm_, left_mm_,
        top_mm_; // patient x and y of the corner; x grows to the right, y upwards
    int width_, height_;
    std::vector<double> glass_; // share of wall colour per pixel
};

} // namespace vcsim3
