/* Smooth curves through given points: positions by a natural cubic spline over chord length (continuous
 * curvature), radii by a monotone cubic (no overshoot between two stated diameters). Used by vessels, ribs
 * and the spine. Millimetres. */
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

/* Natural cubic spline of scalar values over increasing parameters (at least two). */
class Spline
{
  public:
    Spline(std::vector<double> parameters, std::vector<double> values);
    double at(double parameter) const;

  private:
    std::vector<double> parameters_, values_, second_derivatives_;
};

/* Cubic that stays between its neighbours (Fritsch and Carlson 1980); constant beyond both ends. */
class MonotoneCubic
{
  public:
    MonotoneCubic(std::vector<double> parameters, std::vector<double> values);
    double at(double parameter) const;

  private:
    std::vector<double> parameters_, values_, slopes_;
};

/* Samples the curve through `points` with `radii_mm` (same count, at least two) about every step_mm; both
 * ends included, and every given point is one of the samples. */
Curve sample_curve(const std::vector<Vec3> &points, const std::vector<double> &radii_mm, double step_mm);

/* Unit tangent of a sampled curve at a sample. */
Vec3 curve_tangent(const Curve &curve, size_t index);

} // namespace anatomy
