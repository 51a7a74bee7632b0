/* The body of a vertebra, without its arch. */
#pragma once
#include "tools/anatomy/shapes.hpp"

namespace anatomy
{

/* The measures of one vertebral body in its own frame: x to the left, y up and z to the front. */
struct BodyMeasures {
    double upper_width_mm, lower_width_mm, depth_mm;
    double front_height_mm, back_height_mm;
    double hollow_mm;                   // how deep the end plates are in their middle
    double notch_mm;                    // how deep the back is in its middle
    double right_spur_mm, left_spur_mm; // how far osteophytes stand out at the edges of the end plates
};

/* A vertebral body has a waist, hollow end plates with a rim, and a flat or slightly hollow back. */
class VertebralBody : public Shape
{
  public:
    VertebralBody(const Vec3 &centre, const Eigen::Matrix3d &rotation, const BodyMeasures &measures);
    double distance(const Vec3 &point) const override;

  private:
    Vec3 centre_;
    Eigen::Matrix3d inverse_;
    BodyMeasures measures_;
};

} // namespace anatomy
