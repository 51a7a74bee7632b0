/* Smooth curves through given points. The positions on a curve follow a natural cubic spline over chord
 * length, so that curvature is continuous. The radii along a curve follow a monotone cubic, which does not
 * overshoot between two given diameters. Vessels, ribs and the spine are represented by spline curves, with a
 * position and a radius at each point. Lengths are in millimetres. */
#pragma once
#include <Eigen/Core>
#include <vector>

namespace anatomy
{

using Vec3 = Eigen::Vector3d;

/* Holds one point of a sampled curve; `arc_mm` is the length of the curve up to this point. */
struct CurvePoint {
    Vec3 position_mm;
    double radius_mm;
    double arc_mm;
};

using Curve = std::vector<CurvePoint>;

/* Describes a natural cubic spline through scalar values at increasing parameters. The spline needs at least
 * two values. */
class Spline
{
  public:
    Spline(std::vector<double> parameters, std::vector<double> values);
    double at(double parameter) const;

  private:
    std::vector<double> parameters_, values_, second_derivatives_;
};

/* Describes a cubic curve through scalar values that stays between neighbouring values (Fritsch and Carlson
 * 1980). Beyond its two ends, the curve keeps the value at the nearer end. The curve needs at least one
 * value. */
class MonotoneCubic
{
  public:
    MonotoneCubic(std::vector<double> parameters, std::vector<double> values);
    double at(double parameter) const;

  private:
    std::vector<double> parameters_, values_, slopes_;
};

/* Returns the course of one column of a table of levels over their heights `y`, as a Spline or a
 * MonotoneCubic. */
template <class Course, class Level, size_t N>
Course course_over_height(const Level (&levels)[N], double Level::*column)
{
    std::vector<double> heights, values;
    for (const Level &level : levels) {
        heights.push_back(level.y);
        values.push_back(level.*column);
    }
    return Course(heights, values);
}

/* Returns samples, about step_mm apart, of the curve through `points` with the radii `radii_mm`. There must
 * be as many radii as points, and at least two of each. Every given point, also the first and the last, is
 * one of the samples. */
Curve sample_curve(const std::vector<Vec3> &points, const std::vector<double> &radii_mm, double step_mm);

/* Rounds the corners of a course `passes` times; its ends stay. */
void round_corners(Curve &course, int passes);

/* Returns the unit tangent of a sampled curve at one of its samples. */
Vec3 curve_tangent(const Curve &curve, size_t index);

} // namespace anatomy
