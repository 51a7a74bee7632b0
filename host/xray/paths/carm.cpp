// C-arm geometry. Sine and cosine are computed as series of sums and products only, so that every compiler
// gives the same result.
#include "host/xray/paths/carm.hpp"
#include <algorithm>
#include <array>
#include <cmath>

namespace crn
{
namespace
{

constexpr double pi = 3.14159265358979323846;

// Sums Taylor's series to x^13 or x^14, for |x| <= pi/4, with an error below 1e-14.
double sine_series(double x)
{
    double square = x * x, term = x, sum = x;
    for (int n = 2; n <= 12; n += 2) {
        term = -term * square / (n * (n + 1));
        sum = sum + term;
    }
    return sum;
}

double cosine_series(double x)
{
    double square = x * x, term = 1.0, sum = 1.0;
    for (int n = 1; n <= 13; n += 2) {
        term = -term * square / (n * (n + 1));
        sum = sum + term;
    }
    return sum;
}

struct SineCosine {
    double sine, cosine;
};

// Computes the sine and cosine of any angle within +-1e6 degrees; the results for multiples of 90 degrees are
// exact.
SineCosine sine_cosine(double angle_deg)
{
    double quarters = std::floor(angle_deg / 90.0 + 0.5);
    double rest = (angle_deg - 90.0 * quarters) * (pi / 180.0);
    double s = sine_series(rest), c = cosine_series(rest);
    switch (static_cast<long long>(quarters) & 3) {
    case 0:
        return {s, c};
    case 1:
        return {c, -s};
    case 2:
        return {-s, -c};
    default:
        return {-c, s};
    }
}

double clamp_finite(double value, double low, double high, double otherwise)
{
    return std::isfinite(value) ? std::clamp(value, low, high) : otherwise;
}

} // namespace

CArm clamp_carm(const CArm &carm)
{
    CArm held = carm;
    held.primary_deg = clamp_finite(carm.primary_deg, -120.0, 120.0, 0.0);
    held.secondary_deg = clamp_finite(carm.secondary_deg, -50.0, 50.0, 0.0);
    held.source_detector_m = clamp_finite(carm.source_detector_m, 0.90, 1.30, 1.05);
    held.source_isocentre_m = clamp_finite(carm.source_isocentre_m, 0.60, 0.85, 0.75);
    held.field_m = clamp_finite(carm.field_m, 0.10, 0.48, 0.32);
    for (int axis = 0; axis < 3; ++axis)
        held.isocentre_m[axis] = clamp_finite(carm.isocentre_m[axis], -1.9, 1.9, 0.0);
    return held;
}

View make_view(const CArm &carm, int size)
{
    auto [sin_p, cos_p] = sine_cosine(carm.primary_deg);
    auto [sin_s, cos_s] = sine_cosine(carm.secondary_deg);
    View view;
    view.forward = {sin_p * cos_s, sin_s, cos_p * cos_s};
    view.up = {-sin_p * sin_s, cos_s, -cos_p * sin_s};
    view.right = {cos_p, 0.0, -sin_p}; // up x forward
    view.source_m = carm.isocentre_m - carm.source_isocentre_m * view.forward;
    view.source_detector_m = carm.source_detector_m;
    view.source_isocentre_m = carm.source_isocentre_m;
    view.pixel_m = carm.field_m / size;
    view.size = size;
    return view;
}

bool project(const View &view, const Eigen::Vector3d &point_m, Eigen::Vector2d &pixel)
{
    Eigen::Vector3d ray = point_m - view.source_m;
    double depth_m = ray.dot(view.forward);
    if (!(depth_m > 1e-3)) return false;
    double scale = view.source_detector_m / (depth_m * view.pixel_m);
    pixel = {view.size * 0.5 + ray.dot(view.right) * scale, view.size * 0.5 - ray.dot(view.up) * scale};
    return true;
}

std::string patient_side(const Eigen::Vector3d &direction)
{
    constexpr double smallest = 0.38; // sin 22.5 deg
    constexpr char names[3][2] = {{'R', 'L'}, {'F', 'H'}, {'P', 'A'}};
    std::array<int, 3> order = {0, 1, 2};
    std::stable_sort(order.begin(), order.end(),
                     [&](int a, int b) { return std::fabs(direction[a]) > std::fabs(direction[b]); });
    std::string side;
    for (int axis : order)
        if (std::fabs(direction[axis]) >= smallest) side += names[axis][direction[axis] > 0.0 ? 1 : 0];
    return side;
}

} // namespace crn
