// Draws medium that is finer or softer than the exact cylinders of TubePainter: lines of small vessels, and
// soft balls of medium in tissue. Lines go into a picture of their path lengths, balls into a coarse one.
#pragma once
#include "host/xray/paths/paths.hpp"
#include <vector>

namespace crn
{

// A soft ball's concentration at the distance r from its middle is that of its middle times (1 -
// r^2/R^2)^(5/2), so that a ray at the distance d crosses 5 pi/16 R (1 - d^2/R^2)^3 of it. The whole ball
// holds this many R^3 at the concentration of its middle.
inline constexpr double soft_ball_cubes = 0.7710628; // 5 pi^2 / 64

class FaintMedium
{
  public:
    explicit FaintMedium(const View &view);

    // Positions are in camera axes, in mm. `share` is the share of the cross-section, or of the ball's
    // middle, that is medium.
    void line(const Eigen::Vector3d &a_mm, const Eigen::Vector3d &b_mm, double radius_mm, double share);
    void ball(const Eigen::Vector3d &at_mm, double radius_mm, double share);
    // Moves the path lengths of all lines and balls into `haze_mm`, which becomes empty if nothing was drawn.
    void finish(std::vector<float> &haze_mm);

  private:
    void add_fine(int column, int row, float u, float v, float length_mm);

    double focal_pixels_, half_;
    int size_, coarse_size_;
    std::vector<float> fine_mm_, coarse_mm_; // empty until something is drawn
};

} // namespace crn
