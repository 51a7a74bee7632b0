#include "tools/anatomy/spline.hpp"
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace anatomy
{

namespace
{

/* Finds the index i for which parameters[i] <= parameter < parameters[i + 1] (a span). If the parameter lies
 * outside all spans, returns the index of the first or the last span. */
size_t span_of(const std::vector<double> &parameters, double parameter)
{
    const auto above = std::upper_bound(parameters.begin(), parameters.end(), parameter);
    const auto index = std::distance(parameters.begin(), above) - 1;
    return static_cast<size_t>(std::clamp<long>(index, 0, static_cast<long>(parameters.size()) - 2));
}

} // namespace

/* The second derivatives of the spline are zero at both ends. Thomas' algorithm solves the usual tridiagonal
 * system for the second derivatives of the spline. */
Spline::Spline(std::vector<double> parameters, std::vector<double> values)
    : parameters_(std::move(parameters)), values_(std::move(values)), second_derivatives_(values_.size(), 0.0)
{
    const size_t count = values_.size();
    std::vector<double> upper(count, 0.0), right(count, 0.0);
    for (size_t i = 1; i + 1 < count; i++) {
        const double before = parameters_[i] - parameters_[i - 1],
                     after = parameters_[i + 1] - parameters_[i];
        const double load =
            6.0 * ((values_[i + 1] - values_[i]) / after - (values_[i] - values_[i - 1]) / before);
        const double pivot = 2.0 * (before + after) - before * upper[i - 1];
        upper[i] = after / pivot;
        right[i] = (load - before * right[i - 1]) / pivot;
    }
    for (size_t i = count - 1; i-- > 1;)
        second_derivatives_[i] = right[i] - upper[i] * second_derivatives_[i + 1];
}

double Spline::at(double parameter) const
{
    const size_t i = span_of(parameters_, parameter);
    const double width = parameters_[i + 1] - parameters_[i];
    const double b = std::clamp((parameter - parameters_[i]) / width, 0.0, 1.0), a = 1.0 - b;
    return a * values_[i] + b * values_[i + 1] +
           ((a * a * a - a) * second_derivatives_[i] + (b * b * b - b) * second_derivatives_[i + 1]) * width *
               width / 6.0;
}

MonotoneCubic::MonotoneCubic(std::vector<double> parameters, std::vector<double> values)
    : parameters_(std::move(parameters)), values_(std::move(values)), slopes_(values_.size(), 0.0)
{
    // The curve's slope at a given value is the harmonic mean of the slopes of the two adjacent chords, which
    // keeps each span of the curve monotone. At a local extremum the slope is zero.
    for (size_t i = 1; i + 1 < values_.size(); i++) {
        const double before = (values_[i] - values_[i - 1]) / (parameters_[i] - parameters_[i - 1]);
        const double after = (values_[i + 1] - values_[i]) / (parameters_[i + 1] - parameters_[i]);
        slopes_[i] = before * after > 0.0 ? 2.0 * before * after / (before + after) : 0.0;
    }
}

double MonotoneCubic::at(double parameter) const
{
    if (values_.size() == 1) return values_[0];
    const size_t i = span_of(parameters_, parameter);
    const double width = parameters_[i + 1] - parameters_[i];
    const double t = std::clamp((parameter - parameters_[i]) / width, 0.0, 1.0), u = 1.0 - t;
    return values_[i] * (1.0 + 2.0 * t) * u * u + values_[i + 1] * t * t * (3.0 - 2.0 * t) +
           width * t * u * (slopes_[i] * u - slopes_[i + 1] * t);
}

Curve sample_curve(const std::vector<Vec3> &points, const std::vector<double> &radii_mm, double step_mm)
{
    std::vector<double> chord(points.size(), 0.0), x, y, z;
    for (size_t i = 0; i < points.size(); i++) {
        if (i > 0) chord[i] = chord[i - 1] + (points[i] - points[i - 1]).norm();
        x.push_back(points[i].x());
        y.push_back(points[i].y());
        z.push_back(points[i].z());
    }
    const Spline spline_x(chord, x), spline_y(chord, y), spline_z(chord, z);
    const MonotoneCubic radius(chord, radii_mm);
    Curve curve;
    auto append = [&](double parameter) {
        const Vec3 position(spline_x.at(parameter), spline_y.at(parameter), spline_z.at(parameter));
        const double arc =
            curve.empty() ? 0.0 : curve.back().arc_mm + (position - curve.back().position_mm).norm();
        curve.push_back({position, radius.at(parameter), arc});
    };
    append(0.0);
    for (size_t i = 0; i + 1 < points.size(); i++) {
        const int steps = std::max(1, static_cast<int>(std::ceil((chord[i + 1] - chord[i]) / step_mm)));
        for (int k = 1; k <= steps; k++) append(chord[i] + (chord[i + 1] - chord[i]) * k / steps);
    }
    return curve;
}

void round_corners(Curve &course, int passes)
{
    for (int pass = 0; pass < passes; pass++) {
        Vec3 before = course.front().position_mm;
        for (size_t i = 1; i + 1 < course.size(); i++) {
            const Vec3 here = course[i].position_mm;
            course[i].position_mm = 0.25 * before + 0.5 * here + 0.25 * course[i + 1].position_mm;
            before = here;
        }
    }
}

Vec3 curve_tangent(const Curve &curve, size_t index)
{
    const size_t before = index > 0 ? index - 1 : 0, after = std::min(index + 1, curve.size() - 1);
    return (curve[after].position_mm - curve[before].position_mm).normalized();
}

} // namespace anatomy
