/* Smooth curves through given points. Positions follow a natural cubic spline over chord length, so that
 * curvature is continuous. Radii follow a monotone cubic, which does not overshoot between two stated
 * diameters. Vessels, ribs and the spine are such curves. Lengths are in millimetres. */
#pragma once
#include <Eigen/Core>
#include <vector>

namespace anatomy
{

using Vec3 = Eigen::Vector3d;

/* One point of a sampled curve. arc_mm is the length from the first point. */
struct CurvePoint {
    Vec3 position_mm;
    double radius_mm;
    double arc_mm;
};

using Curve = std::vector<CurvePoint>;

/* A natural cubic spline through scalar values at increasing parameters. There must be at least two. */
class Spline
{
  public:
    Spline(std::vector<double> parameters, std::vector<double> values);
    double at(double parameter) const;

  private:
    std::vector<double> parameters_, values_, second_derivatives_;
};

/* A cubic through scalar values that stays between neighbouring values (Fritsch and Carlson 1980). It is
 * constant beyond both ends. There must be at least one value. */
class MonotoneCubic
{
  public:
    MonotoneCubic(std::vector<double> parameters, std::vector<double> values);
    double at(double parameter) const;

  private:
    std::vector<double> parameters_, values_, slopes_;
};

/* Samples the curve through `points` with `radii_mm` about every step_mm. There must be as many radii as
 * points, and at least two. Every given point is one of the samples, including both ends. */
Curve sample_curve(const std::vector<Vec3> &points, const std::vector<double> &radii_mm, double step_mm);

/* Returns the unit tangent of a sampled curve at a sample. */
Vec3 curve_tangent(const Curve &curve, size_t index);

} // namespace anatomy
