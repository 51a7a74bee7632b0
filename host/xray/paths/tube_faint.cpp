#include "host/xray/paths/tube_faint.hpp"
#include "host/xray/paths/lanes.hpp"
#include <algorithm>
#include <cmath>
#include <numbers>

namespace crn
{

using Eigen::Vector3d;
using std::numbers::pi;

namespace
{

constexpr double ball_chord = 5.0 * pi / 16.0;
constexpr int points_at_once = 32;
constexpr int coarse_pixels = 4; // the distance of points of the coarse picture, in pixels

// The pixels whose centres are next above and to the left of some points of a line (pixel centres are at .5),
// and the places of the points between the centres.
struct FinePoints {
    std::int32_t column[points_at_once], row[points_at_once];
    float u[points_at_once], v[points_at_once];
};

// A line in the picture, from a to b, moved by `off`.
struct FineLine {
    double ax, ay, bx, by, off_x, off_y;
    int steps;
};

// Adds path lengths between the points of a row of the coarse picture.
CRN_WIDE void add_between(const float *points, int size, float *fine)
{
    for (int i = 0; i < size / coarse_pixels; ++i)
        for (int k = 0; k < coarse_pixels; ++k)
            fine[i * coarse_pixels + k] +=
                points[i] + (static_cast<float>(k) + 0.5f) / coarse_pixels * (points[i + 1] - points[i]);
    for (int x = size / coarse_pixels * coarse_pixels; x < size; ++x) {
        const int i = x / coarse_pixels;
        fine[x] += points[i] + (static_cast<float>(x % coarse_pixels) + 0.5f) / coarse_pixels *
                                   (points[i + 1] - points[i]);
    }
}

CRN_WIDE void place_points(const FineLine &line, int begin, int count, FinePoints &points)
{
    for (int i = 0; i < count; ++i) {
        const double t = (begin + i + 0.5) / line.steps;
        const double x = line.ax + t * (line.bx - line.ax) + line.off_x,
                     y = line.ay + t * (line.by - line.ay) + line.off_y;
        const double column = std::floor(x - 0.5), row = std::floor(y - 0.5);
        points.column[i] = static_cast<std::int32_t>(column);
        points.row[i] = static_cast<std::int32_t>(row);
        points.u[i] = static_cast<float>(x - 0.5 - column);
        points.v[i] = static_cast<float>(y - 0.5 - row);
    }
}

} // namespace

FaintMedium::FaintMedium(const View &view)
    : focal_pixels_(view.source_detector_m / view.pixel_m), half_(0.5 * view.size), size_(view.size),
      coarse_size_(view.size / coarse_pixels + 2)
{
}

// Shares a length among the four pixels around a point.
void FaintMedium::add_fine(int column, int row, float u, float v, float length_mm)
{
    if (column < 0 || row < 0 || column + 1 >= size_ || row + 1 >= size_) return;
    float *pixel = fine_mm_.data() + static_cast<std::size_t>(row) * size_ + column;
    pixel[0] += length_mm * (1.0f - u) * (1.0f - v);
    pixel[1] += length_mm * u * (1.0f - v);
    pixel[size_] += length_mm * (1.0f - u) * v;
    pixel[size_ + 1] += length_mm * u * v;
}

// The line is a row of points half a pixel apart, and across its width at most one pixel apart. The volume of
// the medium over the area of a pixel at that depth is the path length.
void FaintMedium::line(const Vector3d &a_mm, const Vector3d &b_mm, double radius_mm, double share)
{
    if (!(std::min(a_mm.z(), b_mm.z()) > 1.0) || !(share > 0.0)) return;
    if (fine_mm_.empty()) fine_mm_.assign(static_cast<std::size_t>(size_) * size_, 0.0f);
    const double ax = half_ + focal_pixels_ * a_mm.x() / a_mm.z(),
                 ay = half_ - focal_pixels_ * a_mm.y() / a_mm.z();
    const double bx = half_ + focal_pixels_ * b_mm.x() / b_mm.z(),
                 by = half_ - focal_pixels_ * b_mm.y() / b_mm.z();
    const double length_pixels = std::hypot(bx - ax, by - ay),
                 apart_mm = 0.5 * (a_mm.z() + b_mm.z()) / focal_pixels_;
    if (!(length_pixels < 4.0 * size_)) return;
    const int steps = std::max(1, static_cast<int>(std::ceil(2.0 * length_pixels)));
    const double width_pixels = 2.0 * radius_mm / apart_mm;
    const int across = std::max(1, static_cast<int>(std::lround(width_pixels)));
    const double volume_mm3 = pi * radius_mm * radius_mm * (b_mm - a_mm).norm() * share;
    const double sx = length_pixels > 0.0 ? -(by - ay) / length_pixels : 0.0,
                 sy = length_pixels > 0.0 ? (bx - ax) / length_pixels : 0.0;
    // Across the line, path lengths are those of a round vessel.
    const auto chord = [&](int j) {
        const double beside = 2.0 * (j + 0.5) / across - 1.0;
        return std::sqrt(1.0 - beside * beside);
    };
    double chords = 0.0;
    for (int j = 0; j < across; ++j) chords += chord(j);
    for (int j = 0; j < across; ++j) {
        const double off = across > 1 ? ((j + 0.5) / across - 0.5) * width_pixels : 0.0;
        const auto each_mm =
            static_cast<float>(volume_mm3 / (apart_mm * apart_mm) / steps * chord(j) / chords);
        FinePoints points;
        for (int begin = 0; begin < steps; begin += points_at_once) {
            const int count = std::min(points_at_once, steps - begin);
            place_points({ax, ay, bx, by, off * sx, off * sy, steps}, begin, count, points);
            for (int i = 0; i < count; ++i)
                add_fine(points.column[i], points.row[i], points.u[i], points.v[i], each_mm);
        }
    }
}

void FaintMedium::ball(const Vector3d &at_mm, double radius_mm, double share)
{
    if (!(at_mm.z() > 1.0 + radius_mm) || !(share > 0.0) || !(radius_mm > 0.0)) return;
    if (coarse_mm_.empty()) coarse_mm_.assign(static_cast<std::size_t>(coarse_size_) * coarse_size_, 0.0f);
    const double x = (half_ + focal_pixels_ * at_mm.x() / at_mm.z()) / coarse_pixels,
                 y = (half_ - focal_pixels_ * at_mm.y() / at_mm.z()) / coarse_pixels;
    const double reach = std::max(radius_mm * focal_pixels_ / at_mm.z() / coarse_pixels, 1.5);
    const auto middle_mm = static_cast<float>(ball_chord * radius_mm * share);
    const auto per_square = static_cast<float>(1.0 / (reach * reach));
    const auto inside = [&](double at) { return static_cast<int>(std::clamp(at, 0.0, coarse_size_ - 1.0)); };
    const int x0 = inside(std::ceil(x - reach)), x1 = inside(std::floor(x + reach));
    const int y0 = inside(std::ceil(y - reach)), y1 = inside(std::floor(y + reach));
    for (int row = y0; row <= y1; ++row) {
        const auto dy = static_cast<float>(row - y);
        float *line = coarse_mm_.data() + static_cast<std::size_t>(row) * coarse_size_;
        for (int column = x0; column <= x1; ++column) {
            const auto dx = static_cast<float>(column - x);
            const float left = std::max(1.0f - (dx * dx + dy * dy) * per_square, 0.0f);
            line[column] += middle_mm * left * left * left;
        }
    }
}

// Between the points of the coarse picture, path lengths are interpolated bilinearly; its point k lies at the
// pixel edge k * coarse_pixels.
void FaintMedium::finish(std::vector<float> &haze_mm)
{
    haze_mm.clear();
    if (!coarse_mm_.empty() && fine_mm_.empty())
        fine_mm_.assign(static_cast<std::size_t>(size_) * size_, 0.0f);
    std::vector<float> between(static_cast<std::size_t>(coarse_size_));
    for (int y = 0; y < size_ && !coarse_mm_.empty(); ++y) {
        const float v = (static_cast<float>(y % coarse_pixels) + 0.5f) / coarse_pixels;
        const float *low = coarse_mm_.data() + static_cast<std::size_t>(y / coarse_pixels) * coarse_size_,
                    *high = low + coarse_size_;
        for (int i = 0; i < coarse_size_; ++i) between[i] = low[i] + v * (high[i] - low[i]);
        add_between(between.data(), size_, fine_mm_.data() + static_cast<std::size_t>(y) * size_);
    }
    haze_mm.swap(fine_mm_);
}

} // namespace crn
